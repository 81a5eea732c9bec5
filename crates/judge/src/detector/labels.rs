//! From labels to changes and states: where runs of alarms begin and end, and in which frames the target is
//! lost.

use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// Change into each frame: +1 from consistent to inconsistent, -1 back, 0 if the label stays the same.
///
/// A track is consistent before its first frame, so an alarm in the first frame counts as +1. This is the
/// difference of labels in the text under Eq. 9 of Khalid et al. (BMVC 2016).
pub fn changes(alarm: &[bool]) -> Vec<i32> {
    let before = |t: usize| t > 0 && alarm[t - 1];
    (0..alarm.len()).map(|t| i32::from(alarm[t]) - i32::from(before(t))).collect()
}

/// 0-based frames in which runs of alarms begin, including frame 0.
pub fn run_starts(alarm: &[bool]) -> Vec<usize> {
    (0..alarm.len()).filter(|&t| alarm[t] && (t == 0 || !alarm[t - 1])).collect()
}

/// Frames in a row without an alarm that confirm a recovery, for detectors that alarm in single frames.
///
/// Two alarms at most this far apart can belong to one loss, since the protocols accept a detection up to
/// five frames before and five frames after it.
pub const RECOVERY_FRAMES: usize = 10;

/// For each frame, true if the target counts as lost: from an alarm on, until `recovery` frames in a row (at
/// least 1) have no alarm. The last of these frames is the first that is not lost, so the state of a frame
/// never depends on later ones.
pub fn lost(alarm: &[bool], recovery: usize) -> Vec<bool> {
    let mut state = LossState::default();
    alarm.iter().map(|alarm| state.push(*alarm, recovery)).collect()
}

/// State of [`lost`] for a track that is judged live.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LossState {
    /// Number of frames since the last alarm; `None` before the first alarm.
    quiet: Option<usize>,
}

impl LossState {
    /// Adds a frame. Returns true if the target is lost in it.
    pub fn push(&mut self, alarm: bool, recovery: usize) -> bool {
        self.quiet = if alarm { Some(0) } else { self.quiet.map(|quiet| quiet.saturating_add(1)) };
        self.is_lost(recovery)
    }

    /// True if the target is lost in the last frame.
    pub fn is_lost(self, recovery: usize) -> bool {
        self.quiet.is_some_and(|quiet| quiet < recovery.max(1))
    }
}

/// Probability from which on the target is more likely lost than not, whatever the alarm threshold.
pub const EVEN: f64 = 0.5;

/// State of the target on a track that is judged live.
///
/// A loss lasts until the detector's alarm is over and, for detectors with probabilities, until
/// [`RECOVERY_FRAMES`] frames in a row have one below [`EVEN`]. The end of the alarms alone does not prove
/// that the tracker is on the target again. Alarms raised in frames without a box do not count, since the
/// tracker itself reports the target as absent there; they end with the absence. A loss that began before an
/// absence continues after it, until the recovery is confirmed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StateOfTarget {
    /// True if the current loss was raised in a frame with a box.
    is_lost: bool,
    /// Number of further frames in which a loss continues because of a probability of [`EVEN`] or more.
    doubt: usize,
}

impl StateOfTarget {
    /// State in the next frame. `has_box` is true if the tracker has a box there, `lost` if the detector
    /// considers the target lost (see [`lost`]), `raised` if this frame alone is the reason; `probability` is
    /// that of a loss, or NaN in a frame that could not be judged, which ends nothing.
    pub fn push(&mut self, has_box: bool, lost: bool, raised: bool, probability: f64) -> TargetState {
        self.doubt = match probability.partial_cmp(&EVEN) {
            None => self.doubt,
            Some(Ordering::Less) => self.doubt.saturating_sub(1),
            Some(_) => RECOVERY_FRAMES,
        };
        self.is_lost = self.is_lost && (lost || self.doubt > 0) || lost && has_box && raised;
        match (has_box, self.is_lost) {
            (false, _) => TargetState::Absent,
            (true, true) => TargetState::Lost,
            (true, false) => TargetState::Tracking,
        }
    }
}

/// State of the target in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TargetState {
    /// The tracker is on the target, as far as known.
    Tracking,
    /// The tracker has lost the target: from an alarm in a frame with a box until the recovery is confirmed.
    Lost,
    /// The tracker has no box, or has not had one yet.
    Absent,
}

impl TargetState {
    /// Name of the state in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Tracking => "tracking",
            Self::Lost => "lost",
            Self::Absent => "absent",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// States of frames, given for each frame `has_box`, `lost` and `raised`.
    fn states(frames: impl IntoIterator<Item = (bool, bool, bool)>) -> Vec<TargetState> {
        let mut state = StateOfTarget::default();
        let of = |(has_box, lost, raised)| state.push(has_box, lost, raised, f64::NAN);
        frames.into_iter().map(of).collect()
    }

    /// The first letter of a state's word.
    fn letter(state: TargetState) -> char {
        state.word().chars().next().unwrap_or_default()
    }

    // By hand: the alarm is over after one frame; .6 says that the target is still more likely lost than not. An alarm of an
    // absence (`-`) is none after it, whatever the probability.
    #[test]
    fn a_loss_lasts_while_it_is_more_likely_than_not() {
        let of = |boxes: &str, probabilities: &[f64]| -> String {
            let mut state = StateOfTarget::default();
            let frames = boxes.chars().zip(probabilities);
            frames.map(|(b, p)| letter(state.push(b == 'b', *p >= 0.9, *p >= 0.9, *p))).collect()
        };
        let p = |list: &[(f64, usize)]| -> Vec<f64> {
            list.iter().flat_map(|(p, n)| std::iter::repeat_n(*p, *n)).collect()
        };
        let all = p(&[(0.6, 2), (0.95, 1), (0.6, 3), (0.4, 9), (0.5, 1), (0.1, 12)]);
        let want = format!("tt{}{}", "l".repeat(1 + 3 + 9 + 1 + 9), "t".repeat(3));
        assert_eq!(of(&"b".repeat(28), &all), want);
        assert_eq!(of("bb--bb", &p(&[(0.1, 2), (0.95, 2), (0.6, 2)])), "ttaatt");
        // Frames that nothing is known of do not count.
        let all = p(&[(0.95, 1), (f64::NAN, 30), (0.4, 10)]);
        assert_eq!(of(&"b".repeat(41), &all), format!("{}t", "l".repeat(40)));
    }

    // By hand. `b` is a frame with a box, `-` one without; `.` no alarm, `!` one that is raised, `h` one that is held.
    #[test]
    fn an_alarm_of_an_absence_ends_with_it_by_hand() {
        let of = |boxes: &str, alarms: &str| -> String {
            let frame = |(b, a): (char, char)| (b == 'b', a != '.', a == '!');
            states(boxes.chars().zip(alarms.chars()).map(frame)).into_iter().map(letter).collect()
        };
        assert_eq!(of("bb---bbbb", "..!!!hhh."), "ttaaatttt");
        // It is raised again where the tracker has a box.
        assert_eq!(of("bb---bbbb", "..!!!h!h."), "ttaaatllt");
        // One from before the absence goes on, unless the recovery is confirmed within it.
        assert_eq!(of("bb---bbbb", ".!!!hhh.."), "tlaaalltt");
        assert_eq!(of("bb----bbb", ".!h.!!hh."), "tlaaaattt");
        assert_eq!(of("--bb", "!!hh"), "aatt");
    }

    #[test]
    fn states_have_the_same_word_in_json() {
        let states = [TargetState::Tracking, TargetState::Lost, TargetState::Absent];
        assert!(states.iter().all(|state| serde_json::to_value(state).unwrap() == state.word()));
    }

    proptest! {
        // By the definition: one of the last frames, as many as a recovery needs, has an alarm.
        #[test]
        fn a_target_is_lost_for_as_long_as_a_recovery_takes(
            alarm in prop::collection::vec(prop::bool::weighted(0.2), 0..40),
            recovery in prop_oneof![1_usize..12, Just(usize::MAX)],
        ) {
            let has_alarm = |t: usize| alarm[(t + 1).saturating_sub(recovery)..=t].contains(&true);
            prop_assert_eq!(lost(&alarm, recovery), (0..alarm.len()).map(has_alarm).collect::<Vec<_>>());
        }

        // The law: a loss begins in a frame with a box that raises it, or is one from before the absence. Before the
        // first absence it is that of the alarms.
        #[test]
        fn no_loss_is_raised_by_an_absence(
            frames in prop::collection::vec((prop::bool::weighted(0.9), any::<bool>()), 0..60),
            recovery in 1_usize..12,
        ) {
            let alarm: Vec<bool> = frames.iter().map(|(_, alarm)| *alarm).collect();
            let lost = lost(&alarm, recovery);
            let said = states(frames.iter().zip(&lost).map(|((has_box, alarm), lost)| (*has_box, *lost, *alarm)));
            let first_absence = frames.iter().position(|(has_box, _)| !has_box).unwrap_or(frames.len());
            for (t, state) in said.iter().enumerate() {
                let is_lost = *state == TargetState::Lost;
                prop_assert_eq!(*state == TargetState::Absent, !frames[t].0);
                prop_assert!(t >= first_absence || is_lost == lost[t], "frame {}", t);
                let raised = || (0..=t).rev().take_while(|s| lost[*s]).any(|s| frames[s] == (true, true));
                prop_assert!(!is_lost || raised(), "frame {}", t);
            }
        }

        #[test]
        fn sums_of_changes_are_labels(alarm in prop::collection::vec(any::<bool>(), 0..40)) {
            let changes = changes(&alarm);
            let mut sum = 0;
            for (change, &label) in changes.iter().zip(&alarm) {
                sum += change;
                prop_assert_eq!(sum, i32::from(label));
            }
            let starts: Vec<usize> = (0..alarm.len()).filter(|&t| changes[t] == 1).collect();
            prop_assert_eq!(starts, run_starts(&alarm));
        }
    }
}
