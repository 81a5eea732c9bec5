//! Benchmarks of trackfail, one file for each group.
//!
//! `cargo bench -p trackfail-benches` runs all, `--bench arma` one of them. `benches/peers/compare.py` then sets the times
//! beside those of the same computations in other languages; `docs/performance.md` has the ratios.
