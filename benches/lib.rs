//! Benchmarks of trackfail, one file for each group.
//!
//! `cargo bench -p trackfail-benches` runs all, `--bench arma` one of them. `benches/peers/compare.py` runs them
//! in turn with the same computations in other languages; `docs/performance.md` has its table of ratios.

use trackfail::dataset::synthetic;
use trackfail::image::Frame;
use trackfail::plugin::Entry;
use trackfail::region::{Rect, Region};
use trackfail::spec::{self, Experiment};
use trackfail::tracker::{RunContext, Tracker, TrackerConfig};

/// Gradients with texture of +-12 values, as photographs have, moved to the left by `shift` pixels: waves of heights `across` and
/// `down` around a middle, and `more` in each pixel's colors.
pub fn textured(
    (width, height): (usize, usize),
    [middle, across, down]: [f64; 3],
    shift: usize,
    more: impl Fn(usize, usize, usize) -> f64,
) -> Frame {
    Frame::from_fn(width, height, |x, y| {
        std::array::from_fn(|c| {
            let u = x + shift;
            let smooth = middle
                + across * (0.03 * u as f64 + c as f64).sin()
                + down * (0.05 * y as f64 + 2.0 * c as f64).cos();
            let texture = ((u * 7919 + y * 104_729 + c * 1299) * 2_654_435_761 % 4_294_967_296) >> 16;
            (smooth + (texture % 25) as f64 - 12.0 + more(x, y, c)) as u8
        })
    })
}

/// A textured frame, moved to the left by `shift` pixels.
pub fn frame(width: usize, height: usize, shift: usize) -> Frame {
    textured((width, height), [128.0, 70.0, 40.0], shift, |_, _, _| 0.0)
}

/// A textured frame of 320 x 240 with an ellipse of these half axes in its middle that differs.
pub fn frame_with_target([a, b]: [f64; 2]) -> Frame {
    textured((320, 240), [110.0, 50.0, 30.0], 0, |x, y, c| {
        let (u, v) = ((x as f64 + 0.5 - 160.0) / a, (y as f64 + 0.5 - 120.0) / b);
        let target = if u * u + v * v < 1.0 { 60.0 } else { 0.0 };
        target * (1.0 - c as f64)
    })
}

/// A tracker with these parameters that has been started on a box.
///
/// # Panics
/// When it refuses the parameters or does not start.
pub fn started(entry: &Entry<dyn TrackerConfig>, text: &str, frame: &Frame, place: Rect) -> Box<dyn Tracker> {
    let setup = entry.build_from_text(text).expect("the parameters are valid");
    let sequence = synthetic::suite("synthetic-otb").expect("it is built in").swap_remove(0);
    let context = RunContext { sequence: &sequence, start_frame: 0, run: 0, seed: 1, data_roots: &[] };
    setup.start(&context, frame, &Region::Rect(place)).expect("it starts").0
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
suites.test = "synthetic-otb"
tracker = [{{ name = "scripted", runs = {runs} }}]
table = [{{ name = "many", rows = ["recall"], columns = "method" }}]
[[method]]
name = "RAW"
signal.kind = "distribution-field"
detector = {{ kind = "level", below = 0.0 }}
grid.below = [{}]
"#,
        thresholds.join(", ")
    );
    spec::parse("many", &text).expect("a valid experiment")
}
