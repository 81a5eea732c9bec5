//! An oracle with scripted faults: reports the ground truth, except where its script loses the target.
//!
//! The answer in frame `t` (0-based) is the ground truth of frame `t` moved to the right by `o(t) w`,
//! where `w` is the truth's longest horizontal chord (a rectangle's width), plus jitter:
//!
//! ```text
//! o(t) = max(0, 1 - drift (frame - t))   before a loss, from the end of the loss before it on
//! o(t) = 1.25                            for frame <= t < frame + length
//! o(t) = 0                               else
//! ```
//!
//! So the box slides off the target and overlap, positive in `frame - 1`, is zero exactly in frames
//! `frame..frame + length`; a loss's failure event is at `frame`. Where `o(t) = 0` both coordinates of
//! the region are moved by independent jitter, uniform in `[-jitter, jitter]` pixels but at most a
//! quarter of the longest horizontal (vertical) chord, which leaves a rectangle an overlap of at least
//! 9/16 of its area. The region of a start is never moved. In a frame without truth the last answer repeats.
//!
//! The script goes by the numbers of the frames, wherever the tracker starts. Losses after
//! the end of the sequence have no effect. This tracker is not from any paper; tests use it because its
//! events are known.

use crate::num::seed::{rng, seed};
use crate::tracker::prelude::*;
use rand::RngExt;

/// A scripted loss of the target.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Loss {
    /// First frame without overlap, 0-based, at least 1.
    pub frame: usize,
    /// Number of frames without overlap, at least 1.
    pub length: usize,
}

/// Parameters of the tracker.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Losses in order of time, with at least one frame between the end of one and the next.
    pub losses: Vec<Loss>,
    /// Speed at which the box slides off before a loss, in widths per frame: above 0, at most 1.
    #[default(0.1)]
    pub drift: f64,
    /// Largest deviation of a good answer in pixels, at least 0.
    pub jitter: f64,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] =
        &[Range::of("drift").above(0.0).at_most(1.0), Range::of("jitter").at_least(0.0)];

    fn check(&self) -> Result<(), ParamError> {
        let mut first = 1;
        for loss in &self.losses {
            if loss.frame < first || loss.length == 0 {
                let got = format!("frame = {}, length = {}", loss.frame, loss.length);
                let rule = format!(
                    "in order, each of length at least 1 and here not before frame {first} (frame 0 is the \
                     initialization; a frame with overlap lies between two losses)"
                );
                return Err(ParamError::out_of_range("losses", &rule, got));
            }
            first = loss.frame.saturating_add(loss.length).saturating_add(1);
        }
        Ok(())
    }
}

impl Params {
    /// Offset of the box to the right of the target in frame `t`, in widths of the target.
    fn offset(&self, t: usize) -> f64 {
        let Some(loss) = self.losses.iter().find(|l| t < l.frame.saturating_add(l.length)) else {
            return 0.0;
        };
        if t >= loss.frame {
            return AWAY;
        }
        (1.0 - self.drift * (loss.frame - t) as f64).max(0.0)
    }
}

/// Offset of a lost box, in widths of the target.
const AWAY: f64 = 1.25;

/// The scripted tracker in the list.
pub const ENTRY: Entry<dyn TrackerConfig> =
    Entry::of::<Params>("scripted", 2, "ground truth with losses at stated frames, for tests")
        .example("{ losses = [{ frame = 12, length = 6 }] }");

impl TrackerConfig for Params {
    fn facts(&self) -> Facts {
        let uses_seed = self.jitter > 0.0;
        Facts { uses_seed, needs_truth: true, reads_pixels: false, ..Facts::BOXES }
    }

    fn start(&self, context: &RunContext<'_>, _: &Frame, region: &Region) -> StartResult {
        let truth = context.sequence.truth().to_vec();
        let (next, last) = (context.start_frame + 1, region.clone());
        let tracker = Tracking { script: self.clone(), truth, seed: context.seed, next, last };
        Ok((Box::new(tracker), TrackerState::initialized(region.clone())))
    }
}

struct Tracking {
    script: Params,
    truth: Vec<Option<Region>>,
    seed: u64,
    /// Index of the next frame.
    next: usize,
    last: Region,
}

impl Tracker for Tracking {
    fn update(&mut self, _: &Frame) -> Result<TrackerState, TrackerError> {
        let t = self.next;
        self.next += 1;
        if let Some(Some(truth)) = self.truth.get(t) {
            self.last = self.displaced(t, truth);
        }
        Ok(TrackerState::tracked(self.last.clone()))
    }
}

impl Tracking {
    fn displaced(&self, t: usize, truth: &Region) -> Region {
        let corners = truth.corners();
        let turned: Vec<_> = corners.iter().map(|c| (c.1, c.0)).collect();
        let (w, h) = (longest_chord(&corners), longest_chord(&turned));
        let offset = self.script.offset(t);
        let jitter = self.script.jitter;
        if offset > 0.0 || jitter == 0.0 {
            return truth.shifted(offset * w, 0.0);
        }
        // Seeded by the frame, so that a restart does not shift the numbers.
        let mut random = rng(seed(self.seed, &["scripted", &t.to_string()]));
        let mut draw = |most: f64| (2.0 * random.random::<f64>() - 1.0) * jitter.min(most);
        truth.shifted(draw(w / 4.0), draw(h / 4.0))
    }
}

/// Length of the longest horizontal chord of a convex polygon, which ends in a corner. A polygon moved
/// sideways by more than this does not overlap itself.
fn longest_chord(corners: &[(f64, f64)]) -> f64 {
    let chord = |y: f64| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            if (a.1 - y) * (b.1 - y) <= 0.0 {
                let s = if a.1 == b.1 { 0.0 } else { (y - a.1) / (b.1 - a.1) };
                let x = a.0 + s * (b.0 - a.0);
                // A horizontal edge counts with both ends; its other end is the next edge's start.
                (low, high) = (low.min(x), high.max(x));
            }
        }
        high - low
    };
    corners.iter().map(|c| chord(c.1)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::testing::track;
    use proptest::prelude::*;
    use trackfail_dataset::synthetic;

    fn overlaps(params: &str, suite: &str, which: usize, seed: u64) -> Vec<f64> {
        let config = ENTRY.build_from_text(params).unwrap();
        let sequence = synthetic::suite(suite).unwrap().swap_remove(which);
        let frames = vec![Frame::new(1, 1, vec![0; 3]); sequence.len()];
        let truth: Vec<_> = sequence.truth.iter().flatten().collect();
        let states = track(&*config, &sequence, seed, truth[0], &frames);
        states.iter().zip(truth).map(|(s, g)| s.region.intersection(g) / g.area()).collect()
    }

    // By hand: losses at 30 for 5 frames and at 41 for 2; width fractions 1, then 1 - 0.25 k.
    #[test]
    fn overlap_is_what_the_script_says() {
        let losses = "[{ frame = 30, length = 5 }, { frame = 38, length = 2 }]";
        let v = overlaps(&format!("{{ losses = {losses}, drift = 0.25 }}"), "synthetic-otb", 3, 1);
        let want = [1.0, 1.0, 0.75, 0.5, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.75, 0.5, 0.25, 0.0, 0.0, 1.0];
        for (k, w) in want.into_iter().enumerate() {
            assert!((v[25 + k] - w).abs() < 1e-9, "frame {}: {} {w}", 25 + k, v[25 + k]);
        }
        assert!(v[..25].iter().chain(&v[41..]).all(|&o| (o - 1.0).abs() < 1e-9));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn events_are_where_they_are_put(
            gaps in proptest::collection::vec((1_usize..30, 1_usize..12), 0..5),
            drift in 0.01_f64..1.0, jitter in 0.0_f64..200.0, seed: u64, which in 0_usize..9, vot: bool,
        ) {
            let (mut text, mut lost, mut at) = (vec![], vec![], 0);
            for (gap, length) in gaps {
                text.push(format!("{{ frame = {}, length = {length} }}", at + gap));
                lost.extend(at + gap..at + gap + length);
                at += gap + length;
            }
            let params = format!("{{ losses = [{}], drift = {drift:?}, jitter = {jitter:?} }}", text.join(", "));
            let v = overlaps(&params, if vot { "synthetic-vot" } else { "synthetic-otb" }, which, seed);
            for (t, o) in v.iter().enumerate() {
                prop_assert_eq!(*o == 0.0, lost.contains(&t), "frame {}: {}", t, o);
            }
        }
    }

    #[test]
    fn a_later_start_goes_on_with_the_script() {
        let config =
            ENTRY.build_from_text("{ losses = [{ frame = 60, length = 3 }], jitter = 2.0 }").unwrap();
        let mut sequence = synthetic::suite("synthetic-otb").unwrap().swap_remove(4);
        // The target is where it was in the beginning.
        sequence.truth[58] = sequence.truth[0].clone();
        let region = sequence.truth[0].clone().unwrap();
        let frames = vec![Frame::new(1, 1, vec![0; 3]); sequence.truth.len()];
        let whole = track(&*config, &sequence, 5, &region, &frames);
        let context = RunContext { start_frame: 58, ..crate::tracker::testing::context(&sequence, 5) };
        let (mut later, _) = config.start(&context, &frames[58], &region).unwrap();
        assert!(frames[59..].iter().zip(&whole[59..]).all(|(f, want)| later.update(f).unwrap() == *want));
    }

    // By hand: a square of side 10, the same on its tip, and one turned by 3-4-5, whose chord through a
    // corner is side * 5 / 4.
    #[test]
    fn chords_of_turned_squares() {
        assert_eq!(longest_chord(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]), 10.0);
        assert_eq!(longest_chord(&[(5.0, 0.0), (10.0, 5.0), (5.0, 10.0), (0.0, 5.0)]), 10.0);
        let tilted = [(0.0, 0.0), (8.0, 6.0), (2.0, 14.0), (-6.0, 8.0)];
        assert!((longest_chord(&tilted) - 12.5).abs() < 1e-12);
    }

    #[test]
    fn refuses_scripts_that_make_no_sense() {
        for (losses, is_sound) in [
            ("{ frame = 0, length = 3 }", false),
            ("{ frame = 5, length = 0 }", false),
            ("{ frame = 5, length = 3 }, { frame = 8, length = 1 }", false),
            ("{ frame = 5, length = 3 }, { frame = 9, length = 1 }", true),
            ("{ frame = 5 }", false),
            ("{ frame = 5, length = 3, depth = 1 }", false),
        ] {
            let text = format!("{{ losses = [{losses}] }}");
            assert_eq!(ENTRY.build_from_text(&text).is_ok(), is_sound, "{losses}");
        }
    }
}
