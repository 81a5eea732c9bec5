//! Benchmarks of trackfail, a group a file; `cargo bench -p trackfail-benches` runs them all.
