//! The signals against `tests/oracles/signals.json`, which `tests/oracles/signals.py` made with NumPy and
//! SciPy in float64; the script also takes a dump of real frames, for checks by hand. Those of response maps and particles
//! against numbers of NumPy, and by hand.

use crate::image::Frame;
use crate::num::particles::{effective_number, entropy};
use crate::region::{Rect, Region};
use crate::signal::testing::{run, run_on_states, value_of_map};
use crate::tracker::testing::two_peaks;
use crate::tracker::{Moments, TrackerState};
use proptest::prelude::*;
use serde::Deserialize;
use trackfail_testing::assert_near;

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

/// Frame made by `frame` in `signals.py`.
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
        let boxes: Vec<Rect> = case.boxes.iter().map(|b| Rect::new(b[0], b[1], b[2], b[3])).collect();
        for expected in &case.signals {
            let params = toml::Value::Table(expected.params.clone()).to_string();
            let got = run(&expected.kind, &params, &frames, &boxes);
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

/// Signals of a response map: kind, parameters, and the value of `two_peaks`.
const OF_MAPS: [(&str, &str, f64); 4] = [
    ("response-apce", "{}", 17.049655672345054),
    ("response-psr", "{}", 7.349575370134235),
    ("response-peak", "{ measure = \"peak\" }", 0.984375),
    ("response-peak", "{ measure = \"second-peak\" }", 0.7142857142857143),
];

// python3: with F and side of `tracker/correlation/response/tests.rs`, NumPy 2.4.6:
// (F.max() - F.min())**2 / ((F - F.min())**2).mean(); S = side(5, 5); (F.max() - S.mean()) / S.std(); F.max()
// side(4, 4).max() / F.max()
#[test]
fn values_of_a_map_agree_with_numpy() {
    for (kind, params, want) in OF_MAPS {
        let got = value_of_map(kind, params, &two_peaks(), 20);
        assert!((got / want - 1.0).abs() < 1e-13, "{kind} {params}: {got} {want}");
    }
}

proptest! {
    // The peaks themselves alone are no ratios.
    #[test]
    fn gain_and_offset_of_a_map_change_nothing(gain in 1..9_i16, offset in -50..50_i16) {
        let other: Vec<f32> = two_peaks().iter().map(|v| f32::from(gain) * v + f32::from(offset)).collect();
        for (kind, params, want) in &OF_MAPS[..2] {
            let got = value_of_map(kind, params, &other, 20);
            prop_assert!((got / want - 1.0).abs() < 1e-9, "{kind} {params}: {got} {want}");
        }
    }
}

// By hand: a spike a over n - 1 zeros has APCE a^2 / (a^2 / n) = n, mean a / n and deviation a sqrt(n - 1) / n, thus the ratio
// sqrt(n - 1) in a map of 5 x 2 cells, which is not wider than the window, so that all of it is the sidelobe; half of the cells
// at either end have APCE a^2 / (a^2 / 2) = 2. The box around the first peak wraps and has round(0.22 * 20) = 4 cells each way;
// below 0 there is no second peak, nor a first one in a map that is nowhere above.
#[test]
fn values_of_maps_by_hand() {
    let map = |ground: f32, n: usize, cells: &[(usize, f32)]| {
        let mut map = vec![ground; n];
        cells.iter().for_each(|(cell, value)| map[*cell] = *value);
        map
    };
    let second = "{ measure = \"second-peak\" }";
    for (kind, params, map, width, want) in [
        ("response-apce", "{}", map(-1.0, 144, &[(100, 4.0)]), 12, 144.0),
        ("response-apce", "{}", [0.0, 3.0].repeat(8), 4, 2.0),
        ("response-apce", "{}", vec![0.7; 16], 4, 0.0),
        ("response-psr", "{}", map(0.0, 10, &[(7, 0.5)]), 5, 3.0),
        ("response-psr", "{}", map(0.0, 400, &[(7, 0.5)]), 20, 1e6),
        ("response-psr", "{}", vec![3.0; 400], 20, 0.0),
        ("response-peak", second, [-0.5, -1.0, -2.0, -0.75].repeat(4), 4, 1.0),
        ("response-peak", second, vec![0.0; 16], 4, 1.0),
        ("response-peak", second, map(-1.0, 400, &[(210, 1.0)]), 20, 0.0),
        ("response-peak", second, map(0.0, 400, &[(0, 1.0), (16 * 20 + 17, 0.5)]), 20, 0.0),
        ("response-peak", second, map(0.0, 400, &[(0, 1.0), (15 * 20 + 17, 0.25)]), 20, 0.25),
    ] {
        assert_near([value_of_map(kind, params, &map, width)], [want], 1e-9, format!("{kind} {params}"));
    }
}

// By hand: 1 / (4 * 1), 1 / (4 * 1/2), 1 / (4 * 3/8), 1 / (4 * 1/4); two of four particles share the weight, ln 2 / ln 4;
// weights 1/2, 1/4, 1/4, 0 have 1.5 ln 2 / ln 4.
#[test]
fn values_of_weights_by_hand() {
    let clouds = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.5, 0.0], [0.5, 0.25, 0.25, 0.0], [0.25; 4]];
    let states = clouds.map(|weights| {
        let (effective_samples, entropy) = (effective_number(&weights), entropy(&weights));
        let moments = Moments { effective_samples, samples: 4.0, entropy, ..Moments::default() };
        TrackerState {
            posterior: Some(moments),
            ..TrackerState::tracked(Region::Rect(Rect::new(0.0, 0.0, 4.0, 4.0)))
        }
    });
    for (kind, want) in
        [("effective-particles", [0.25, 0.5, 2.0 / 3.0, 1.0]), ("particle-entropy", [0.0, 0.5, 0.75, 1.0])]
    {
        assert_near(run_on_states(kind, "{}", &states), want, 1e-15, kind);
    }
}
