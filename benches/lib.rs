//! Benchmarks of trackfail, one file for each group.
//!
//! `cargo bench -p trackfail-benches` runs all, `--bench arma` one of them. `benches/peers/compare.py` runs them
//! in turn with the same computations in other languages; `docs/performance.md` has its table of ratios.

use trackfail::image::Frame;
use trackfail::spec::{self, Experiment};

/// Smooth gradients with texture of +-12 values, as photographs have, moved to the left by `shift` pixels.
pub fn frame(width: usize, height: usize, shift: usize) -> Frame {
    Frame::from_fn(width, height, |x, y| {
        let x = x + shift;
        std::array::from_fn(|c| {
            let smooth = 128.0
                + 70.0 * (0.03 * x as f64 + c as f64).sin()
                + 40.0 * (0.05 * y as f64 + 2.0 * c as f64).cos();
            let texture = ((x * 7919 + y * 104_729 + c * 1299) * 2_654_435_761 % 4_294_967_296) >> 16;
            (smooth + (texture % 25) as f64 - 12.0) as u8
        })
    })
}

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
