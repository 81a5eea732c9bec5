//! Expected F1 score of a detector with the same number of detections, placed at random.
//!
//! ```text
//! E = TP + FN events      D = TP + FP detections      N = TP + FP + FN + TN frames      m frames of a window
//! P(0) = C(N - m, D) / C(N, D) = product over j < m of (N - D - j) / (N - j)     no detection in the window
//! P(1) = m D / N times the product over j < m - 1 of (N - 1 - (D - 1) - j) / (N - 1 - j)              exactly one
//! hit  = 1 - P(0), or 1 - P(0) - P(1) / 2 where signs must agree
//! TP_0 = min(E hit, D)      F_0 = 2 TP_0 / (E + D)      F over chance = (F - F_0) / (1 - F_0)
//! ```
//!
//! D and E are given, so the expected F is `2 E[TP] / (E + D)` exactly. Of D among N frames drawn without
//! replacement, k are in the window of m = 2 tolerance + 1 frames around an event, or m = delay + 1 frames from it on,
//! with the hypergeometric probability P(k). Where a protocol matches signs, detections alternate between the two: one alone has the right
//! sign half of the time, and of two neighbors one has it. Frame by frame (m = 1) TP_0 is E D / N, D being the
//! frames with an alarm and E those that are lost. So a random
//! detector has 0 in the mean, an oracle 1, a silent one 0 and one that avoids events less than 0.
//!
//! TP_0 is exact if the windows of events neither overlap nor leave the sequence. Otherwise it is an upper
//! bound, since a detection matches only one event and truncated windows hold fewer frames; the score is then
//! a lower bound, and says little if events are a few frames apart. There are two more limits. Counts are
//! those of a whole suite, so the random detector spreads its alarms evenly over all sequences. And
//! detections, being first frames of alarms, are never adjacent, unlike the draws: alarms drawn frame by
//! frame that begin in 1 of 25 frames hit 3 % more windows than expected here.
//!
//! The form is that of Cohen's kappa ("A coefficient of agreement for nominal scales", Educational and
//! Psychological Measurement 20, 1960).

use super::counts::Counts;

/// Rule by which random detections match events of a protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chance {
    /// Number of frames around an event in which a detection matches it.
    pub window: u64,
    /// True if detections alternate between two signs, of which one matches.
    pub is_signed: bool,
}

impl Chance {
    /// Rule by which a detection within `tolerance` frames of an event matches it.
    pub const fn within(tolerance: usize) -> Self {
        Self { window: 2 * tolerance as u64 + 1, is_signed: false }
    }

    /// Rule by which a detection in the frame of an event or up to `delay` frames later matches it.
    pub const fn after(delay: usize) -> Self {
        Self { window: delay as u64 + 1, is_signed: false }
    }

    /// Expected true positives of the same number of random detections.
    pub fn expected_true_positives(&self, counts: &Counts) -> f64 {
        let Counts { tp, fp, fn_, tn } = *counts;
        let frames = (tp + fp + fn_ + tn) as f64;
        let detections = (tp + fp) as f64;
        if detections == 0.0 {
            return 0.0;
        }
        let silent = (fn_ + tn) as f64;
        // The probability that all of `window` frames are silent, drawn from `frames`.
        let all_silent = |window: u64, frames: f64| -> f64 {
            let left = |j: f64| if frames > j { (silent - j).max(0.0) / (frames - j) } else { 0.0 };
            (0..window).map(|j| left(j as f64)).product()
        };
        let none = all_silent(self.window, frames);
        let one = self.window as f64 * detections / frames * all_silent(self.window - 1, frames - 1.0);
        let hit = 1.0 - none - if self.is_signed { 0.5 * one } else { 0.0 };
        ((tp + fn_) as f64 * hit.clamp(0.0, 1.0)).min(detections)
    }

    /// F_0, the expected F1 of the same number of random detections; `None` if F1 has no value.
    pub fn expected_f1(&self, counts: &Counts) -> Option<f64> {
        counts.f_score()?;
        let both = 2 * counts.tp + counts.fp + counts.fn_;
        Some(2.0 * self.expected_true_positives(counts) / both as f64)
    }

    /// (F - F_0) / (1 - F_0); `None` if F1 has no value or F_0 is 1.
    pub fn f_over_chance(&self, counts: &Counts) -> Option<f64> {
        let (f, chance) = (counts.f_score()?, self.expected_f1(counts)?);
        (chance < 1.0).then(|| (f - chance) / (1.0 - chance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::seed;
    use crate::score::testing::counts;
    use crate::score::{PROTOCOLS, TrackScore, frames, khalid2016, sanmiguel2015, segmentation};
    use proptest::prelude::*;
    use rand::RngExt;

    /// Mean and standard error of the true positives over `draws` random placements, and the expected number.
    fn simulated(
        score: impl Fn(&[bool]) -> Counts,
        chance: Chance,
        frames: usize,
        detections: usize,
        draws: usize,
    ) -> (f64, f64, f64) {
        let mut rng = seed::rng(seed::seed(1, &["chance"]));
        let mut found = Vec::new();
        let mut expected = 0.0;
        for _ in 0..draws {
            let mut at = vec![false; frames];
            let mut placed = 0;
            while placed < detections {
                let frame = rng.random_range(0..frames);
                placed += usize::from(!std::mem::replace(&mut at[frame], true));
            }
            let counts = score(&at);
            found.push(counts.tp as f64);
            expected += chance.expected_true_positives(&counts) / draws as f64;
        }
        let mean = found.iter().sum::<f64>() / draws as f64;
        let variance = found.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / draws as f64;
        (mean, (variance / draws as f64).sqrt(), expected)
    }

    /// Counts of detections placed at `at`, if all frames count.
    fn matched(events: &[usize], at: &[bool]) -> Counts {
        let detections: Vec<usize> = (0..at.len()).filter(|t| at[*t]).collect();
        let matches = crate::score::matching::match_nearest(events, &detections, khalid2016::TOLERANCE);
        TrackScore::of_matches(0..at.len(), events.to_vec(), detections, matches).counts
    }

    // Where windows overlap, the expectation is a bound.
    #[test]
    fn random_detections_match_as_often_as_expected() {
        for (detections, gap, frames) in [(3, 50, 800), (20, 30, 560), (60, 11, 332), (20, 3, 200)] {
            let events: Vec<usize> = (0..12).map(|k| 8 + gap * k).collect();
            let score = |at: &[bool]| matched(&events, at);
            let (mean, error, expected) =
                simulated(score, khalid2016::PROTOCOL.chance, frames, detections, 4000);
            let far = 4.0 * error;
            let is_so = if gap == 3 { mean + far < expected } else { (mean - expected).abs() < far };
            assert!(is_so, "{mean} {error} {expected}");
        }
    }

    // Detections alternate in sign, as changes of a label do; windows of events do not touch.
    #[test]
    fn random_changes_match_as_often_as_expected() {
        let error: Vec<f64> = (0..2000).map(|t| if (t / 100) % 2 == 1 { 1.0 } else { 0.3 }).collect();
        let score = |at: &[bool]| {
            let mut sign = -1;
            let mut change = |is_there: &bool| {
                sign = if *is_there { -sign } else { sign };
                sign * i32::from(*is_there)
            };
            let changes: Vec<i32> = at.iter().map(&mut change).collect();
            (sanmiguel2015::SIGNED.score)(&error, &[], &changes).counts
        };
        let (mean, error, expected) = simulated(score, sanmiguel2015::SIGNED.chance, 2000, 60, 4000);
        assert!((mean - expected).abs() < 4.0 * error, "{mean} {error} {expected}");
    }

    // Alarms at random frames, each for itself: every one hits a lost frame with the share of these.
    #[test]
    fn random_frames_are_lost_as_often_as_expected() {
        let error: Vec<f64> = (0..600).map(|t| if t % 50 >= 37 { 1.0 } else { 0.3 }).collect();
        let score = |at: &[bool]| (frames::protocols::FRAMES.score)(&error, at, &[]).counts;
        let (mean, deviation, expected) = simulated(score, frames::protocols::FRAMES.chance, 600, 70, 4000);
        assert!((expected - 70.0 * 156.0 / 600.0).abs() < 1e-9, "{expected}");
        assert!((mean - expected).abs() < 4.0 * deviation, "{mean} {deviation} {expected}");
    }

    // Losses that last longer than the frames in which they are to be found.
    #[test]
    fn random_alarms_begin_in_losses_as_often_as_expected() {
        let error: Vec<f64> = (0..1200).map(|t| if t % 100 >= 60 { 1.0 } else { 0.3 }).collect();
        for protocol in [frames::protocols::RANGE, frames::protocols::NAB] {
            // Alarms of one frame that do not touch.
            let apart = |at: &[bool]| at.iter().flat_map(|a| [*a, false]).collect::<Vec<_>>();
            let score = |at: &[bool]| (protocol.score)(&error, &apart(at)[..1200], &[]).counts;
            let (mean, deviation, expected) = simulated(score, protocol.chance, 600, 30, 4000);
            // Every other frame only, but sixteen frames hold eight of them whichever they are.
            assert!((mean - expected).abs() < 0.05 * expected, "{mean} {deviation} {expected}");
        }
    }

    // By hand: of the six ways to place 2 detections in 4 frames one leaves a window of 2 silent and four have one in it,
    // which half of the time has the wrong sign. A window of more frames than there are is hit for sure.
    #[test]
    fn short_tracks_by_hand() {
        let signed = Chance { window: 2, is_signed: true };
        let hit = 1.0 - 1.0 / 6.0 - 0.5 * 4.0 / 6.0;
        assert!((signed.expected_true_positives(&counts(1, 1, 0, 2)) - hit).abs() < 1e-15);
        assert_eq!(Chance::within(1).expected_true_positives(&counts(1, 1, 0, 0)), 1.0);
    }

    // Labels that have nothing to do with the truth: E D / N, as in a contingency table.
    #[test]
    fn frame_by_frame_it_is_the_product_of_the_shares() {
        let counts = counts(60, 20, 30, 90);
        let expected = segmentation::PROTOCOL.chance.expected_true_positives(&counts);
        assert!((expected - 90.0 * 80.0 / 200.0).abs() < 1e-12);
        // By hand: F = 120/170, F_0 = 72/170, so the score is 48/98.
        let score = segmentation::PROTOCOL.chance.f_over_chance(&counts).unwrap();
        assert!((score - 48.0 / 98.0).abs() < 1e-12);
    }

    #[test]
    fn anchors_have_their_closed_forms() {
        for protocol in PROTOCOLS {
            let of = |tp, fp, fn_, tn| protocol.chance.f_over_chance(&counts(tp, fp, fn_, tn));
            let oracle = of(10, 0, 0, 990).unwrap();
            assert!((oracle - 1.0).abs() < 1e-12, "{oracle}");
            assert_eq!((of(0, 0, 10, 990), of(0, 0, 0, 1000), of(10, 0, 0, 0)), (Some(0.0), None, None));
            assert!(of(0, 10, 10, 980).unwrap() < 0.0);
        }
    }

    proptest! {
        #[test]
        fn never_more_than_there_are_and_never_above_f(
            tp in 0..40_u64, fp in 0..40_u64, fn_ in 0..40_u64, tn in 0..400_u64,
        ) {
            let counts = Counts { tp, fp, fn_, tn };
            for protocol in PROTOCOLS {
                let expected = protocol.chance.expected_true_positives(&counts);
                prop_assert!((0.0..=((tp + fn_).min(tp + fp)) as f64 + 1e-9).contains(&expected));
                if let Some(score) = protocol.chance.f_over_chance(&counts) {
                    prop_assert!(score <= counts.f_score().unwrap() + 1e-12);
                }
            }
        }
    }
}
