//! Properties that `synthetic-d1` and `synthetic-d2` share with the sets that they stand in for.

use super::actor::Kind;
use super::scene::{self, ScenePlan};
use super::{SUITES, suite as sequences};
use crate::Sequence;
use rayon::prelude::*;
use trackfail_core::region::Region;

const NAMES: [&str; 2] = ["synthetic-d1", "synthetic-d2"];

fn plans(name: &str) -> &'static [ScenePlan] {
    &SUITES.iter().find(|s| s.name == name).unwrap().scenes().plans
}

/// The plan without light and noise, so that a pixel has the color drawn there.
fn bare(plan: &ScenePlan) -> ScenePlan {
    ScenePlan { light: Vec::new(), shadow: Vec::new(), noise: 0.0, ..plan.clone() }
}

pub(super) fn without_target(plan: &ScenePlan) -> ScenePlan {
    let mut plan = plan.clone();
    plan.target.x = vec![(0.0, -1e5)];
    plan
}

fn sequence(plan: &ScenePlan) -> Sequence {
    scene::sequence("test", plan)
}

/// Number of pixels in which two sequences differ in a frame.
fn differing(a: &Sequence, b: &Sequence, t: usize) -> usize {
    let [a, b] = [a, b].map(|sequence| sequence.frame(t).unwrap());
    a.bytes().chunks_exact(3).zip(b.bytes().chunks_exact(3)).filter(|(p, q)| p != q).count()
}

// The paper: 18 sequences, about 3400 frames; 51 sequences, about 7500 frames; cars, people and faces in both.
#[test]
fn the_suites_have_the_papers_sizes() {
    for (name, count, frames, lengths) in [(NAMES[0], 18, 3400, 120..=350), (NAMES[1], 51, 7500, 100..=250)] {
        let plans = plans(name);
        assert_eq!(plans.len(), count);
        let sum: usize = plans.iter().map(|plan| plan.frames).sum();
        assert!(sum.abs_diff(frames) <= 300, "{name}: {sum}");
        assert!(plans.iter().all(|plan| lengths.contains(&plan.frames)));
        assert!(plans.iter().all(|plan| [(320, 240), (360, 288)].contains(&plan.size)));
        for word in ["target-car", "target-person", "target-face"] {
            assert!(plans.iter().filter(|plan| has(plan, word)).count() >= count / 5, "{name} {word}");
        }
    }
}

fn has(plan: &ScenePlan, word: &str) -> bool {
    plan.attributes.iter().any(|a| a == word)
}

#[test]
fn a_target_is_what_its_attributes_say() {
    for plan in NAMES.into_iter().flat_map(plans) {
        let expected = match plan.target.kind {
            Kind::Roof | Kind::Car | Kind::Rear => "target-car",
            Kind::Person => "target-person",
            Kind::Head => "target-face",
            other => panic!("{}: {other:?}", plan.name),
        };
        assert!(has(plan, expected), "{}", plan.name);
        let lit = !(plan.light.is_empty() && plan.shadow.is_empty());
        assert_eq!(has(plan, "illumination-variation"), lit, "{}", plan.name);
        assert_eq!(has(plan, "scale-variation"), plan.target.scale.len() > 1, "{}", plan.name);
    }
}

/// In the first 25 frames the target is inside the frame and no obstacle covers a pixel of it.
#[test]
fn starts_in_full_view() {
    for name in NAMES {
        plans(name).par_iter().for_each(|plan| {
            let alone = ScenePlan { front: Vec::new(), ..bare(plan) };
            let [all, all_gone, own, own_gone] =
                [bare(plan), without_target(&bare(plan)), alone.clone(), without_target(&alone)]
                    .map(|p| sequence(&p));
            for t in [0, 8, 16, 24] {
                let r = own.truth[t].as_ref().unwrap().rect();
                let (w, h) = (plan.size.0 as f64, plan.size.1 as f64);
                assert!(r.x >= 0.0 && r.y >= 0.0 && r.x + r.w <= w && r.y + r.h <= h, "{} {t}", plan.name);
                assert_eq!(differing(&all, &all_gone, t), differing(&own, &own_gone, t), "{} {t}", plan.name);
            }
        });
    }
}

/// Number of frames in which the target is wholly hidden, estimated from every fourth one.
fn hidden(plan: &ScenePlan) -> usize {
    let (with, without) = (sequence(&bare(plan)), sequence(&without_target(&bare(plan))));
    (0..plan.frames).step_by(4).filter(|t| differing(&with, &without, *t) == 0).count() * 4
}

#[test]
fn total_occlusions_are_total() {
    for (name, least) in [(NAMES[0], 7), (NAMES[1], 18)] {
        let counts: Vec<_> = plans(name).par_iter().map(|p| (&p.name, hidden(p))).collect();
        assert!(counts.iter().filter(|c| c.1 >= 4).count() >= least, "{counts:?}");
        // And most of the time a target can be seen.
        assert!(counts.iter().all(|c| c.1 < 110), "{counts:?}");
    }
}

/// Targets move no faster than the random walk of the paper's filter and keep to sizes that it can reach.
#[test]
fn targets_move_and_grow_slowly() {
    for name in NAMES {
        for q in sequences(name).unwrap() {
            for (t, pair) in q.truth.windows(2).enumerate() {
                let [Some(a), Some(b)] = pair else { panic!("{} {t}", q.name) };
                assert!(matches!(a, Region::Rect(_)));
                let (a, b) = (a.rect(), b.rect());
                let ((ax, ay), (bx, by)) = (a.center(), b.center());
                assert!((bx - ax).abs() < 6.0 && (by - ay).abs() < 6.0, "{} {t}", q.name);
                assert!((b.w - a.w).abs() < 1.5 && (b.h - a.h).abs() < 1.5, "{} {t}", q.name);
                assert!((18.0..=64.0).contains(&a.w), "{} {t}: {}", q.name, a.w);
            }
        }
    }
}
