use super::super::scene;
use super::super::{RenderedSuite, VERSION, suite as sequences};
use super::*;
use crate::Sequence;
use crate::lock::TargetType;
use rayon::prelude::*;
use trackfail_core::image::Frame;
use trackfail_core::region::Region;

const NAMES: [&str; 2] = ["synthetic-d1", "synthetic-d2"];

fn suite(name: &str) -> &'static RenderedSuite {
    super::super::SUITES.iter().find(|s| s.name == name).unwrap()
}

/// Without light and noise, so that a pixel is what is drawn there.
fn bare(plan: &ScenePlan) -> ScenePlan {
    ScenePlan { light: &[], shadow: &[], noise: 0.0, ..*plan }
}

fn without_target(plan: &ScenePlan) -> ScenePlan {
    ScenePlan { target: Actor { x: &[(0.0, -1e5)], ..plan.target }, ..*plan }
}

fn sequence(plan: &ScenePlan) -> Sequence {
    scene::sequence("test", VERSION, plan)
}

fn frame(q: &Sequence, t: usize) -> Frame {
    q.frame(t).unwrap()
}

/// Number of pixels in which two frames differ.
fn differing(a: &Frame, b: &Frame) -> usize {
    a.bytes().chunks_exact(3).zip(b.bytes().chunks_exact(3)).filter(|(p, q)| p != q).count()
}

#[test]
fn every_entry_has_its_script_and_every_script_its_entry() {
    for (name, scripts) in [("synthetic-d1", d1::SCRIPTS), ("synthetic-d2", d2::SCRIPTS)] {
        let entries: Vec<&str> = lock::rendered_entries(name).iter().map(|e| e.name.as_str()).collect();
        assert_eq!(entries, scripts.iter().map(|s| s.name).collect::<Vec<_>>());
        let q = sequences(name).unwrap();
        assert_eq!(q.len(), entries.len());
        for (q, e) in q.iter().zip(lock::rendered_entries(name)) {
            assert_eq!((q.name.as_str(), q.len()), (e.name.as_str(), e.frames));
            assert_eq!(q.size().unwrap(), e.size, "{}", q.name);
            assert!(q.attributes.contains(&format!("target-{}", e.target_type.word())), "{}", q.name);
        }
    }
}

// The paper: 18 sequences, about 3400 frames; 51 sequences, about 7500 frames; cars, people and faces in both.
#[test]
fn the_suites_have_the_papers_sizes() {
    for (name, count, frames, lengths) in [(NAMES[0], 18, 3400, 120..=350), (NAMES[1], 51, 7500, 100..=250)] {
        let entries = lock::rendered_entries(name);
        assert_eq!(entries.len(), count);
        let sum: usize = entries.iter().map(|e| e.frames).sum();
        assert!(sum.abs_diff(frames) <= 300, "{name}: {sum}");
        assert!(entries.iter().all(|e| lengths.contains(&e.frames)));
        assert!(entries.iter().all(|e| [(320, 240), (360, 288)].contains(&e.size)));
        for target_type in [TargetType::Car, TargetType::Person, TargetType::Face] {
            let of = |e: &&RenderedEntry| e.target_type == target_type;
            assert!(entries.iter().filter(of).count() >= count / 5, "{name} {target_type:?}");
        }
    }
}

#[test]
fn a_target_is_what_its_entry_says() {
    for name in NAMES {
        for (plan, e) in suite(name).plans().iter().zip(lock::rendered_entries(name)) {
            let expected = match plan.target.kind {
                Kind::Roof | Kind::Car | Kind::Rear => TargetType::Car,
                Kind::Person => TargetType::Person,
                Kind::Head => TargetType::Face,
                other => panic!("{}: {other:?}", e.name),
            };
            assert_eq!(e.target_type, expected, "{}", e.name);
            let has = |code: &str| e.attributes.iter().any(|a| a == code);
            assert_eq!(has("IV"), !(plan.light.is_empty() && plan.shadow.is_empty()), "{}", e.name);
            assert_eq!(has("SV"), plan.target.scale.len() > 1, "{}", e.name);
        }
    }
}

/// No obstacle covers a pixel of the target in the first 25 frames, and the target is inside the frame.
#[test]
fn starts_in_full_view() {
    for name in NAMES {
        suite(name).plans().par_iter().for_each(|plan| {
            let alone = ScenePlan { front: &[], ..bare(plan) };
            let [all, all_gone, own, own_gone] =
                [bare(plan), without_target(&bare(plan)), alone, without_target(&alone)]
                    .map(|p| sequence(&p));
            for t in [0, 8, 16, 24] {
                let r = own.truth[t].as_ref().unwrap().rect();
                let (w, h) = (plan.size.0 as f64, plan.size.1 as f64);
                assert!(r.x >= 0.0 && r.y >= 0.0 && r.x + r.w <= w && r.y + r.h <= h, "{} {t}", plan.name);
                let shown = differing(&frame(&all, t), &frame(&all_gone, t));
                let whole = differing(&frame(&own, t), &frame(&own_gone, t));
                assert_eq!(shown, whole, "{} {t}", plan.name);
            }
        });
    }
}

/// How many frames the target is wholly hidden, counted on every fourth one.
fn hidden(plan: &ScenePlan) -> usize {
    let (with, without) = (sequence(&bare(plan)), sequence(&without_target(&bare(plan))));
    (0..plan.frames).step_by(4).filter(|&t| frame(&with, t) == frame(&without, t)).count() * 4
}

#[test]
fn total_occlusions_are_total() {
    for (name, least) in [(NAMES[0], 7), (NAMES[1], 18)] {
        let counts: Vec<_> = suite(name).plans().par_iter().map(|p| (p.name, hidden(p))).collect();
        assert!(counts.iter().filter(|c| c.1 >= 4).count() >= least, "{counts:?}");
        // And most of the time a target can be seen.
        assert!(counts.iter().all(|c| c.1 < 110), "{counts:?}");
    }
}

/// No target outruns the random walk of the paper's filter, and none is out of its reach in size.
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
