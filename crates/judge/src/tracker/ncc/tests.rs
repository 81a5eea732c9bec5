use super::*;
use crate::region::Rect;
use crate::tracker::testing::{follow, track};
use proptest::prelude::*;
use rayon::prelude::*;

/// A textured frame, shifted by whole pixels.
fn texture(dx: i64, dy: i64) -> Frame {
    Frame::from_fn(90, 70, |x, y| {
        let (u, v) = ((x as i64 - dx) as u32, (y as i64 - dy) as u32);
        let h = u.wrapping_mul(2_654_435_761) ^ v.wrapping_mul(40_503_001);
        let h = (h ^ (h >> 15)).wrapping_mul(2_246_822_519);
        [(h >> 8) as u8, (h >> 16) as u8, (h >> 24) as u8]
    })
}

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
        let mut c = Correlator::new(w, h, r);
        c.set_template(&template.iter().map(|&v| f64::from(v)).collect::<Vec<_>>());
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

    #[test]
    fn follows_a_shift_exactly(dx in -7_i64..8, dy in -7_i64..8) {
        let region = Region::Rect(Rect::new(30.25, 25.5, 20.0, 16.0));
        let answer = follow(&ENTRY, "{}", &region, &[texture(0, 0), texture(dx, dy)]);
        prop_assert_eq!(answer, region.shifted(dx as f64, dy as f64));
    }
}

// python3: import numpy as np; t=np.array([10,20,30,60.]); i=np.array([1,2,4,5.]);
// np.corrcoef(t,i)[0,1]
#[test]
fn one_score_agrees_with_numpy() {
    let mut c = Correlator::new(2, 2, 2);
    c.set_template(&[10.0, 20.0, 30.0, 60.0]);
    let mut area = vec![9; 36];
    for (k, v) in [(14, 1), (15, 2), (20, 4), (21, 5)] {
        area[k] = v;
    }
    assert!((c.scores(&area)[2 * 5 + 2] - NUMPY).abs() < 1e-12);
}
const NUMPY: f64 = 0.9296696802013683;

// What the module's text promises about rounding, at the size of a large target and at extremes.
#[test]
fn transformed_sums_are_nearly_whole_numbers() {
    for seed in [1_u32, 2] {
        let bytes =
            |n: usize, k: u32| -> Vec<u8> {
                (0..n as u32)
                    .map(|i| {
                        if (i.wrapping_mul(2_654_435_761) ^ k).count_ones().is_multiple_of(2) {
                            0
                        } else {
                            255
                        }
                    })
                    .collect()
            };
        let mut c = Correlator::new(260, 220, 110);
        c.set_template(&bytes(260 * 220, seed).into_iter().map(f64::from).collect::<Vec<_>>());
        c.scores(&bytes(480 * 440, seed ^ 77));
        let worst = (0..=220)
            .flat_map(|dy| c.line[dy * 480..dy * 480 + 221].iter())
            .map(|v| (v - v.round()).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-3, "{worst}");
    }
}

#[test]
fn answers_do_not_depend_on_gain_and_offset() {
    let dim = |f: &Frame| Frame::from_fn(90, 70, |x, y| f.pixel(x, y).map(|v| v / 2 + 20));
    let region = Region::Rect(Rect::new(30.0, 25.0, 20.0, 16.0));
    let answer = follow(&ENTRY, "{}", &region, &[texture(0, 0), dim(&texture(4, -3))]);
    assert_eq!(answer, region.shifted(4.0, -3.0));
}

#[test]
fn without_contrast_it_stays() {
    let flat = Frame::new(40, 30, vec![77; 3600]);
    let region = Region::Rect(Rect::new(10.0, 10.0, 8.0, 8.0));
    assert_eq!(follow(&ENTRY, "{ search = 2.0 }", &region, &[flat.clone(), flat]), region);
}

#[test]
fn the_template_follows_at_its_rate() {
    let (old, new) = (texture(0, 0), texture(31, 17));
    // A fifth of the new look leaves the old place the best one.
    let mixed = Frame::from_fn(90, 70, |x, y| {
        let (a, b) = (old.pixel(x, y), new.pixel(x, y));
        [0, 1, 2].map(|k| ((u32::from(a[k]) * 4 + u32::from(b[k])) / 5) as u8)
    });
    let window = Window { x: 30, y: 25, w: 20, h: 16 };
    let region = Region::Rect(Rect::new(30.0, 25.0, 20.0, 16.0));
    for rate in [0.0, 0.25, 1.0] {
        let params = Params { search: 1.0, update_rate: rate };
        let mut t = Tracking { target: Target::new(&params, &old, &region), params };
        assert_eq!(t.update(&mixed).unwrap().region, region);
        let got = t.target.template;
        for ((&a, &b), t) in gray(&old, &window).iter().zip(&gray(&mixed, &window)).zip(got) {
            let want = f64::from(a) + rate * (f64::from(b) - f64::from(a));
            assert!((t - want).abs() < 1e-12);
        }
    }
}

#[test]
fn lengths_are_smooth() {
    assert_eq!([1, 7, 12, 13, 121, 12_000, 12_001].map(smooth), [2, 8, 12, 16, 128, 12_000, 12_150]);
}

/// Difficulty: the simplest tracker fails on most sequences, not on all, and comes back on some.
#[test]
fn a_plain_tracker_fails_now_and_then() {
    let config = ENTRY.build_from_text("{}").unwrap();
    let counts: Vec<(usize, usize, f64)> = trackfail_dataset::synthetic::suite("synthetic-otb")
        .unwrap()
        .par_iter()
        .map(|q| {
            let frames: Vec<Frame> = (0..q.len()).map(|t| q.frame(t).unwrap()).collect();
            let states = track(&*config, q, 0, q.truth[0].as_ref().unwrap(), &frames);
            let (mut failures, mut recoveries, mut good, mut on) = (0, 0, 0, true);
            for (state, truth) in states.iter().zip(q.truth.iter().flatten()) {
                let meets = state.region.intersection(truth) > 0.0;
                failures += usize::from(on && !meets);
                recoveries += usize::from(!on && meets);
                good += usize::from(meets);
                on = meets;
            }
            (failures, recoveries, good as f64 / q.len() as f64)
        })
        .collect();
    let failures: usize = counts.iter().map(|c| c.0).sum();
    let recoveries: usize = counts.iter().map(|c| c.1).sum();
    assert!((20..=60).contains(&failures), "{failures} {counts:?}");
    assert!(recoveries >= 10, "{recoveries} {counts:?}");
    assert!((3..=8).contains(&counts.iter().filter(|c| c.0 == 0).count()), "{counts:?}");
    let mean = counts.iter().map(|c| c.2).sum::<f64>() / counts.len() as f64;
    assert!((0.5..0.85).contains(&mean) && counts.iter().all(|c| c.2 > 0.2), "{mean} {counts:?}");
}
