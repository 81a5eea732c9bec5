//! Benchmarks of trackfail, one file for each group.
//!
//! `cargo bench -p trackfail-benches` runs all, `--bench arma` one of them. `benches/peers/compare.py` runs them
//! in turn with the same computations in other languages; `docs/performance.md` has its table of ratios.
