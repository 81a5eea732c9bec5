use super::*;
use crate::tracker::testing::track;
use proptest::prelude::*;
use rayon::prelude::*;
use trackfail_dataset::{Sequence, synthetic};

// Pearson's correlation coefficient over the overlapping pixels, straight from its definition.
fn pearson(a: &[u8], b: &[u8]) -> f64 {
    let n = a.len() as f64;
    let mean = |v: &[u8]| v.iter().map(|&x| f64::from(x)).sum::<f64>() / n;
    let (ma, mb) = (mean(a), mean(b));
    let dot = |p: &[u8], mp: f64, q: &[u8], mq: f64| -> f64 {
        p.iter().zip(q).map(|(&x, &y)| (f64::from(x) - mp) * (f64::from(y) - mq)).sum()
    };
    dot(a, ma, b, mb) / (dot(a, ma, a, ma) * dot(b, mb, b, mb)).sqrt()
}

proptest! {
    #[test]
    fn scores_agree_with_the_definition(
        w in 2_usize..9, h in 2_usize..9, r in 2_usize..6,
        bytes in proptest::collection::vec(any::<u8>(), 400..401),
    ) {
        let (width, height) = (w + 2 * r, h + 2 * r);
        let area: Vec<u8> = (0..width * height).map(|k| bytes[k % 397]).collect();
        let template: Vec<u8> = (0..w * h).map(|k| bytes[(k * 7 + 3) % 399]).collect();
        let mut c = Correlator::new(&template, w, h, r);
        let scores = c.scores(&area);
        for dy in 0..=2 * r {
            for dx in 0..=2 * r {
                let window: Vec<u8> =
                    (0..w * h).map(|k| area[(dy + k / w) * width + dx + k % w]).collect();
                let (want, got) = (pearson(&window, &template), scores[dy * (2 * r + 1) + dx]);
                if want.is_finite() {
                    prop_assert!((want - got).abs() < 1e-9, "{want} {got}");
                } else {
                    prop_assert_eq!(got, 0.0);
                }
            }
        }
    }
}

// What the module's text promises about rounding, at the size of a large target and at extremes.
#[test]
fn transformed_sums_are_nearly_whole_numbers() {
    for seed in [1_u32, 2] {
        let byte = |i: u32, k: u32| 255 * ((i.wrapping_mul(2_654_435_761) ^ k).count_ones() % 2) as u8;
        let bytes = |n: u32, k: u32| -> Vec<u8> { (0..n).map(|i| byte(i, k)).collect() };
        let mut c = Correlator::new(&bytes(260 * 220, seed), 260, 220, 110);
        c.scores(&bytes(480 * 440, seed ^ 77));
        let sums = (0..=220).flat_map(|dy| &c.line[dy * 480..][..221]);
        let worst = sums.map(|v| (v - v.round()).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-3, "{worst}");
    }
}

#[test]
fn lengths_are_smooth() {
    assert_eq!([1, 7, 12, 13, 121, 12_000, 12_001].map(smooth), [2, 8, 12, 16, 128, 12_000, 12_150]);
}

/// The simplest tracker must fail on most sequences, but not on all, and recover on some.
#[test]
fn a_plain_tracker_fails_now_and_then() {
    let config = ENTRY.build_from_text("{}").unwrap();
    let count = |q: &Sequence| {
        let frames: Vec<Frame> = (0..q.len()).map(|t| q.frame(t).unwrap()).collect();
        let states = track(&*config, q, 0, q.truth[0].as_ref().unwrap(), &frames);
        let pairs = states.iter().zip(q.truth.iter().flatten());
        let on: Vec<bool> = pairs.map(|(s, truth)| s.region.intersection(truth) > 0.0).collect();
        let changes = |to: bool| on.windows(2).filter(|pair| pair[0] != to && pair[1] == to).count();
        let good = on.iter().filter(|on| **on).count() as f64 / q.len() as f64;
        (changes(false), changes(true), good)
    };
    let sequences = synthetic::suite("synthetic-otb").unwrap();
    let counts: Vec<(usize, usize, f64)> = sequences.par_iter().map(count).collect();
    let failures: usize = counts.iter().map(|c| c.0).sum();
    let recoveries: usize = counts.iter().map(|c| c.1).sum();
    assert!((20..=60).contains(&failures), "{failures} {counts:?}");
    assert!(recoveries >= 10, "{recoveries} {counts:?}");
    assert!((3..=8).contains(&counts.iter().filter(|c| c.0 == 0).count()), "{counts:?}");
    let mean = counts.iter().map(|c| c.2).sum::<f64>() / counts.len() as f64;
    assert!((0.5..0.85).contains(&mean) && counts.iter().all(|c| c.2 > 0.2), "{mean} {counts:?}");
}
