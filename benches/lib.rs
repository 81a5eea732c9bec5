//! Benchmarks of trackfail, one file for each group.
//!
//! `cargo bench -p trackfail-benches` runs all, `--bench arma` one of them. `benches/peers/compare.py` runs them
//! in turn with the same computations in other languages; `docs/performance.md` has its table of ratios.

use trackfail::spec::{self, Experiment};

/// An experiment of 20 sequences x `runs` runs of a tracker x 100 thresholds.
///
/// # Panics
/// When experiment files are read in another way than when this was written.
pub fn many_cells(runs: usize) -> Experiment {
    let thresholds: Vec<String> = (0..100).map(|k| format!("{}", f64::from(k) / 1000.0)).collect();
    let text = format!(
        r#"
schema = 1
name = "many"
title = "Many cells"
protocol = "khalid2016/1"
[suites]
test = "synthetic-otb"
[[tracker]]
name = "scripted"
runs = {runs}
[[method]]
name = "RAW"
signal = {{ kind = "distribution-field" }}
detector = {{ kind = "level", below = 0.0 }}
[method.grid]
below = [{}]
[[table]]
name = "many"
rows = ["recall"]
columns = "method"
"#,
        thresholds.join(", ")
    );
    spec::parse("many", &text).expect("a valid experiment")
}
