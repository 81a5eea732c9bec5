use super::actor::Kind;
use super::scene::ScenePlan;
use super::*;
use crate::Frames;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use trackfail_core::image::Frame;
use trackfail_core::region::Region;

fn frame(sequence: &Sequence, t: usize) -> Frame {
    sequence.frame(t).unwrap()
}

fn all() -> impl Iterator<Item = (&'static RenderedSuite, Sequence)> {
    SUITES.iter().flat_map(|s| s.sequences().into_iter().map(move |q| (s, q)))
}

/// Digest of three frames, all regions and all attributes of a sequence.
fn content(sequence: &Sequence) -> String {
    let mut hash = Sha256::new();
    let n = sequence.len();
    for t in [0, n / 2, n - 1] {
        hash.update(frame(sequence, t).bytes());
    }
    for (x, y) in sequence.truth.iter().flatten().flat_map(Region::corners) {
        hash.update(x.to_le_bytes());
        hash.update(y.to_le_bytes());
    }
    hash.update(sequence.attributes.join(","));
    for (name, flags) in &sequence.frame_attributes {
        hash.update(name);
        hash.update(flags.iter().map(|&f| u8::from(f)).collect::<Vec<_>>());
    }
    hash.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect()
}

#[test]
fn pixels_and_truth_are_those_of_this_version() {
    let mut found = String::new();
    for suite in &SUITES {
        let parts: Vec<_> = suite.sequences().par_iter().map(content).collect();
        let digest = Sha256::digest(parts.concat());
        let short: String = digest.iter().take(8).map(|b| format!("{b:02x}")).collect();
        found.push_str(&format!("{} {VERSION} {short}\n", suite.name));
    }
    assert_eq!(
        found, GOLDEN,
        "frames or ground truth changed: raise synthetic::VERSION, then copy the left side"
    );
}
const GOLDEN: &str = "synthetic-otb 1 a95b96b7bde659a4
synthetic-vot 1 3f261f9d69df18e2
synthetic-d1 1 4d0d1a554d53ad28
synthetic-d2 1 76463e71f2d8a3c5
";

#[test]
fn suites_are_well_formed() {
    for (suite, q) in all() {
        let n = q.len();
        assert!((120..=260).contains(&n), "{}: {n}", q.name);
        assert!(q.attributes.is_sorted() && !q.attributes.is_empty(), "{}", q.name);
        assert!(q.truth.iter().all(Option::is_some));
        assert_eq!((q.numbering.first, q.numbering.official), (1, (1, n as u32)));
        assert_eq!(q.digest().unwrap().len(), 64);
        assert!(matches!(q.frames, Frames::Rendered(_, m) if m == n));
        let f = frame(&q, 0);
        for (t, region) in q.truth.iter().enumerate() {
            let region = region.as_ref().unwrap();
            assert_eq!(matches!(region, Region::Polygon(_)), suite.scenes().layout == RenderLayout::Vot);
            // The target's center never leaves the frame.
            let (x, y) = region.rect().center();
            let inside = (0.0..f.width() as f64).contains(&x) && (0.0..f.height() as f64).contains(&y);
            assert!(inside, "{} {t}: {x} {y}", q.name);
            let flat: Vec<f64> = region.corners().iter().flat_map(|c| [c.0, c.1]).collect();
            assert!(Region::from_numbers(&flat).is_ok(), "{} {t}", q.name);
        }
    }
    for suite in &SUITES {
        let names: Vec<_> = suite.scenes().names().collect();
        assert!(names.is_sorted() && names.windows(2).all(|w| w[0] != w[1]));
        assert!(suite.scenes().title.starts_with(&names.len().to_string()));
    }
    let digests: std::collections::BTreeSet<_> =
        all().map(|(_, q)| q.digest().unwrap().to_string()).collect();
    assert_eq!(digests.len(), all().count());
    assert!(suite("synthetic-otb").is_some() && suite("otb").is_none());
}

#[test]
fn coordinates_survive_counting_from_one() {
    for (_, q) in all() {
        for region in q.truth.iter().flatten() {
            for v in region.numbers() {
                assert_eq!((v * 64.0).fract(), 0.0);
                let text = format!("{}", v + 1.0);
                assert_eq!((text.parse::<f64>().unwrap() - 1.0).to_bits(), (v + 0.0).to_bits(), "{text}");
            }
        }
    }
}

#[test]
fn frames_do_not_depend_on_the_order() {
    let again = suite("synthetic-otb").unwrap();
    for (a, b) in suite("synthetic-otb").unwrap().iter().zip(&again).take(3) {
        let forward: Vec<_> = [3, 40, 100].map(|t| frame(a, t)).into();
        let backward: Vec<_> = [100, 40, 3].map(|t| frame(b, t)).into();
        assert!(forward.iter().eq(backward.iter().rev()), "{}", a.name);
        assert_ne!(forward[0], forward[1]);
    }
}

/// The pixels that change when the target is removed are those of the annotated box.
#[test]
fn the_truth_is_where_the_target_is() {
    for suite in &SUITES {
        suite.scenes().plans.par_iter().for_each(|plan| {
            let (front, light, shadow) = (Vec::new(), Vec::new(), Vec::new());
            let bare = ScenePlan { front, light, shadow, exposure: 0.0, noise: 0.0, ..plan.clone() };
            let gone = without_target(&bare);
            let with = scene::sequence(suite.name, &bare);
            let without = scene::sequence(suite.name, &gone);
            for t in [0, plan.frames / 3, plan.frames / 2, plan.frames - 1] {
                let (a, b) = (frame(&with, t), frame(&without, t));
                let (mut low, mut high) = ((f64::MAX, f64::MAX), (f64::MIN, f64::MIN));
                for y in 0..a.height() {
                    for x in 0..a.width() {
                        if a.pixel(x, y) != b.pixel(x, y) {
                            low = (low.0.min(x as f64), low.1.min(y as f64));
                            high = (high.0.max(x as f64 + 1.0), high.1.max(y as f64 + 1.0));
                        }
                    }
                }
                let bounds = with.truth[t].as_ref().unwrap().bounds();
                let [l, r] = [bounds.x, bounds.x + bounds.w].map(|x| x.clamp(0.0, a.width() as f64));
                let [o, u] = [bounds.y, bounds.y + bounds.h].map(|y| y.clamp(0.0, a.height() as f64));
                // Card corners stick out of an inscribed ellipse's bounds by up to a sixth.
                let is_turned = suite.scenes().layout == RenderLayout::Otb && !plan.target.turn.is_empty();
                let slack = 1.6 + if is_turned { 0.2 * (r - l).max(u - o) } else { 0.0 };
                let name = format!("{} {t}: {low:?} {high:?} in {bounds:?}", plan.name);
                assert!(low.0 >= l - slack && high.0 <= r + slack, "{name}");
                assert!(low.1 >= o - slack && high.1 <= u + slack, "{name}");
                // And the box is not much larger than the target (a walker with closed legs is thin).
                assert!(high.0 - low.0 > 0.55 * (r - l) && high.1 - low.1 > 0.7 * (u - o), "{name}");
            }
        });
    }
}

/// Suites that stand in for data sets, and share the properties of those.
const NAMES: [&str; 2] = ["synthetic-d1", "synthetic-d2"];

fn plans(name: &str) -> &'static [ScenePlan] {
    &SUITES.iter().find(|s| s.name == name).unwrap().scenes().plans
}

/// The plan without light and noise, so that a pixel has the color drawn there.
fn bare(plan: &ScenePlan) -> ScenePlan {
    ScenePlan { light: Vec::new(), shadow: Vec::new(), noise: 0.0, ..plan.clone() }
}

fn without_target(plan: &ScenePlan) -> ScenePlan {
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
        for q in suite(name).unwrap() {
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
