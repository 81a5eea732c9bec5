//! The signals against `tests/oracles/signals.json`, which `tests/oracles/signals.py` made with NumPy and
//! SciPy in float64. The script also takes a dump of real frames, for checks by hand.

use super::SIGNALS;
use crate::image::Frame;
use crate::plugin::find;
use crate::region::Rect;
use crate::signal::testing::values_on_boxes;
use serde::Deserialize;

#[derive(Deserialize)]
struct Oracle {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    name: String,
    frames: String,
    width: usize,
    height: usize,
    boxes: Vec<[f64; 4]>,
    byte_sum: u64,
    signals: Vec<Values>,
}

#[derive(Deserialize)]
struct Values {
    kind: String,
    params: toml::Table,
    values: Vec<f64>,
}

/// The frame of `frame` in `signals.py`.
fn frame(kind: &str, width: usize, height: usize, t: usize) -> Frame {
    Frame::from_fn(width, height, |x, y| {
        std::array::from_fn(|c| {
            let c = if kind == "grey" { 0 } else { c };
            let seed = (x * 7919 + y * 104_729 + c * 1_299_709 + t * 15_485_863) as u64;
            let noise = ((seed * 1_664_525 + 1_013_904_223) % (1 << 32)) >> 27;
            let block = (8 + 2 * t..20 + 2 * t).contains(&x) && (7 + t..21 + t).contains(&y);
            let mut value = ((2 * x + 3 * y + 40 * c + t) % 180) as i64 + noise as i64;
            if block {
                value += 60 - 25 * c as i64;
            }
            if kind == "harsh" {
                value = 3 * value - 250;
            }
            value.clamp(0, 255) as u8
        })
    })
}

fn compute(kind: &str, params: &str, frames: &[Frame], boxes: &[[f64; 4]]) -> Vec<f64> {
    let signal = find(SIGNALS, kind).unwrap().build_from_text(params).unwrap();
    let boxes: Vec<Rect> = boxes.iter().map(|b| Rect::new(b[0], b[1], b[2], b[3])).collect();
    values_on_boxes(signal.as_ref(), frames, &boxes)
}

fn inline(table: &toml::Table) -> String {
    toml::Value::Table(table.clone()).to_string()
}

#[test]
fn values_agree_with_numpy_and_scipy() {
    let oracle: Oracle =
        serde_json::from_str(include_str!("../../../../tests/oracles/signals.json")).unwrap();
    let mut compared = 0;
    for case in &oracle.cases {
        let frames: Vec<Frame> =
            (0..case.boxes.len()).map(|t| frame(&case.frames, case.width, case.height, t)).collect();
        let sum: u64 = frames.iter().flat_map(|f| f.bytes()).map(|&b| u64::from(b)).sum();
        assert_eq!(sum, case.byte_sum, "{}: not the oracle's frames", case.name);
        for expected in &case.signals {
            let params = inline(&expected.params);
            let got = compute(&expected.kind, &params, &frames, &case.boxes);
            assert_eq!(got.len(), expected.values.len());
            for (t, (a, b)) in got.iter().zip(&expected.values).enumerate() {
                let what = format!("{} {} {params} frame {t}: {a} against {b}", case.name, expected.kind);
                let tolerance = match expected.kind.as_str() {
                    "distribution-field" => 1e-6 * b.abs(),
                    // Samples of single precision; the correlation of faint texture loses digits.
                    "template-correlation" => 2e-6,
                    // Eigenvalues of covariances with a condition of 1e6 keep about ten digits.
                    _ => 1e-9 * b.abs().max(1.0),
                };
                assert!((a - b).abs() <= tolerance, "{what}");
                compared += 1;
            }
        }
    }
    assert!(compared > 300, "{compared}");
}
