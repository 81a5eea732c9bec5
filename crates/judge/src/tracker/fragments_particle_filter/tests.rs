//! The filter against NumPy and against direct counting.

use super::evidence::Place;
use super::layout::Fragment;
use super::*;
use crate::tracker::testing::Scene;
use proptest::prelude::*;
use trackfail_testing::assert_near;

// The half sizes of the source, worked by hand for 40 x 60: flat strips are 20 x 6 with centers 6 apart, upright
// ones 4 x 30 with centers 4 apart.
#[test]
fn strips_are_those_of_the_source() {
    let all = layout::fragments(40.0, 60.0);
    assert_eq!(all.len(), 2 * 10 + 2 * 10);
    assert_eq!(all[0], [-20.0, -30.0, 0.0, -24.0]);
    assert_eq!(all[1], [0.0, -30.0, 20.0, -24.0]);
    assert_eq!(all[19], [0.0, 24.0, 20.0, 30.0]);
    assert_eq!(all[20], [-20.0, -30.0, -16.0, 0.0]);
    assert_eq!(all[39], [16.0, 0.0, 20.0, 30.0]);
}

/// Likeness by counting pixels one by one, from the definition.
fn direct(first: &Frame, now: &Frame, fragment: &Fragment, here: &Place, there: &Place) -> f64 {
    let histogram = |frame: &Frame, &[x, y]: &Place| {
        let mut counts = vec![0.0; 512];
        let edge = |c: f64, e: f64| (c + e + 0.5).floor();
        let (left, top) = (edge(x, fragment[0]), edge(y, fragment[1]));
        let (right, bottom) = (edge(x, fragment[2]).max(left + 1.0), edge(y, fragment[3]).max(top + 1.0));
        for j in 0..frame.height() {
            for i in 0..frame.width() {
                if (left..right).contains(&(i as f64)) && (top..bottom).contains(&(j as f64)) {
                    let [r, g, b] = frame.pixel(i, j).map(|v| usize::from(v) / 32);
                    counts[64 * r + 8 * g + b] += 1.0;
                }
            }
        }
        let pixels = counts.iter().sum::<f64>().max(1.0);
        counts.into_iter().map(move |count| count / pixels)
    };
    histogram(first, here).zip(histogram(now, there)).map(|(q, p)| (p * q).sqrt()).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn likenesses_are_those_of_direct_counting(
        many: bool, x in -10.0..130.0, y in -10.0..100.0, w in 0.5..40.0, h in 0.5..50.0,
    ) {
        let moved = Scene { camera: (3, 1), step: (4, -2), ..Scene::SLOPES };
        let (first, now) = (Scene::SLOPES.frame(0, 0.0), moved.frame(1, 0.0));
        let fragments = layout::fragments(w, h);
        let (here, there) = ([52.0, 45.0], [x, y]);
        let mut evidence = Evidence::new(fragments.clone(), &first, &here);
        // Many places make integral histograms worth while, one does not.
        evidence.look(&now, &vec![there; if many { 2000 } else { 1 }]);
        let mut rho = vec![];
        evidence.likeness(&there, &mut rho);
        prop_assert_eq!(rho.len(), fragments.len());
        for (r, f) in rho.iter().zip(&fragments) {
            let expected = direct(&first, &now, f, &here, &there);
            prop_assert!((r - expected).abs() < 1e-9, "{} {}", r, expected);
        }
    }

    #[test]
    fn reliabilities_sum_to_one(
        rho in prop::collection::vec(0.0..=1.0, 2..40), rate in 0.0..=1.0, sigma in 0.01..2.0,
    ) {
        let mut reliabilities = vec![1.0 / rho.len() as f64; rho.len()];
        for _ in 0..50 {
            follow(&mut reliabilities, &rho, rate, sigma);
            prop_assert!((reliabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let votes = votes(&reliabilities);
            prop_assert!((votes.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}

// python3: import numpy as np; rho = np.array([.9, .6, .99]); r = np.array([.5, .3, .2]); s = .1
//   L = np.exp(-(1-rho)/(2*s*s)); (r*L).sum(); .9*r + .1*L/L.sum()
#[test]
fn fusion_and_reliabilities_agree_with_numpy() {
    let (rho, votes) = ([0.9, 0.6, 0.99], [0.5, 0.3, 0.2]);
    assert_near([fuse(&rho, &votes, 1.0, 0.1)], [FUSED], 1e-12, "");
    let mut reliabilities = votes;
    follow(&mut reliabilities, &rho, 0.1, 0.1);
    assert_near(reliabilities, FOLLOWED, 1e-12, "");
}
const FUSED: f64 = 0.12467510606041547;
const FOLLOWED: [f64; 3] = [0.4510986942593667, 0.2700000003360931, 0.2789013054045402];

// Worked by hand: a fifth of the mean of four reliabilities is 1/20.
#[test]
fn weak_fragments_have_no_vote() {
    assert_eq!(votes(&[0.5, 0.25, 0.1875, 0.0625]), [0.5, 0.25, 0.1875, 0.0625]);
    assert_near(votes(&[0.6, 0.36, 0.02, 0.02]), [0.625, 0.375, 0.0, 0.0], 1e-12, "");
}

// The lower half of the block disappears behind the ground for good.
#[test]
fn a_half_hidden_block_is_followed_and_its_hidden_fragments_lose_their_votes() {
    let scene = Scene { step: (1, 0), ..Scene::SLOPES };
    let frames: Vec<Frame> = (0..60).map(|t| scene.frame(t / 2, if t < 3 { 0.0 } else { 15.0 })).collect();
    let last = |params: &str| scene.run("fragments-particle-filter", params, 11, &frames).pop().unwrap();
    let (followed, fixed) = (last("{ reliability_rate = 0.1 }"), last("{ reliability_rate = 0 }"));
    let ((x, y), (cx, cy)) = (followed.region.rect().center(), scene.rect(29).center());
    assert!((x - cx).hypot(y - cy) < 4.0, "{x} {y}");
    let likelihood = |s: &TrackerState| s.posterior.as_ref().unwrap().likelihood;
    assert!(likelihood(&followed) > 1.3 * likelihood(&fixed));
}
