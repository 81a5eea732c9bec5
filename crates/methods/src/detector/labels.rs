//! From labels to changes and states: where a run of alarms begins and ends, and between which the target is lost.

use serde::{Deserialize, Serialize};

/// The change into each frame: +1 from consistent to inconsistent, -1 back, 0 where the label stays.
///
/// A track is consistent before its first frame, so an alarm in the first frame counts as +1. This is the
/// difference of labels in the text under Eq. 9 of Khalid et al. (BMVC 2016).
pub fn changes(alarm: &[bool]) -> Vec<i32> {
    let mut before = false;
    alarm
        .iter()
        .map(|&now| {
            let change = i32::from(now) - i32::from(before);
            before = now;
            change
        })
        .collect()
}

/// The 0-based frames where runs of alarms begin; an alarm in frame 0 begins one.
pub fn run_starts(alarm: &[bool]) -> Vec<usize> {
    (0..alarm.len()).filter(|&t| alarm[t] && (t == 0 || !alarm[t - 1])).collect()
}

/// Frames in a row without an alarm that confirm a recovery, for detectors that alarm in single frames.
///
/// Two alarms no further apart than this can belong to one loss: the protocols accept a detection up to five frames before
/// and five frames after it.
pub const RECOVERY_FRAMES: usize = 10;

/// Whether the target counts as lost, for each frame: from an alarm on, until `recovery` frames in a row (at least 1)
/// have none. The last of these is the first that is not lost, so that the state of a frame needs no later one.
pub fn lost(alarm: &[bool], recovery: usize) -> Vec<bool> {
    let mut state = LossState::default();
    alarm.iter().map(|alarm| state.push(*alarm, recovery)).collect()
}

/// The state of [`lost`] while a track goes on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LossState {
    /// Frames since the last alarm; `None` before the first.
    quiet: Option<usize>,
}

impl LossState {
    /// Whether the target is lost in the next frame.
    pub fn push(&mut self, alarm: bool, recovery: usize) -> bool {
        self.quiet = if alarm { Some(0) } else { self.quiet.map(|quiet| quiet.saturating_add(1)) };
        self.is_lost(recovery)
    }

    /// Whether the target is lost in the last frame.
    pub fn is_lost(self, recovery: usize) -> bool {
        self.quiet.is_some_and(|quiet| quiet < recovery.max(1))
    }
}

/// State of the target in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TargetState {
    /// The tracker is on the target, as far as can be told.
    Tracking,
    /// The tracker has lost the target: from an alarm until the recovery is confirmed.
    Lost,
    /// The tracker itself has no box, or has not had one yet.
    Absent,
}

impl TargetState {
    /// Its word in files.
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

    #[test]
    fn by_hand() {
        let alarm = [true, true, false, false, true, false, true];
        assert_eq!(changes(&alarm), [1, 0, -1, 0, 1, -1, 1]);
        assert_eq!(run_starts(&alarm), [0, 4, 6]);
        assert!(changes(&[]).is_empty() && run_starts(&[]).is_empty());
    }

    #[test]
    fn lost_by_hand() {
        let alarm = [0, 1, 0, 0, 1, 0, 0, 0, 0, 1].map(|a| a == 1);
        let states = |recovery| lost(&alarm, recovery).into_iter().map(u8::from).collect::<Vec<_>>();
        assert_eq!(states(1), [0, 1, 0, 0, 1, 0, 0, 0, 0, 1]);
        assert_eq!(states(3), [0, 1, 1, 1, 1, 1, 1, 0, 0, 1]);
        assert_eq!(states(2), [0, 1, 1, 0, 1, 1, 0, 0, 0, 1]);
        assert_eq!(states(usize::MAX), [0, 1, 1, 1, 1, 1, 1, 1, 1, 1]);
        assert!(lost(&[], 3).is_empty());
    }

    #[test]
    fn states_have_the_same_word_in_json() {
        for state in [TargetState::Tracking, TargetState::Lost, TargetState::Absent] {
            assert_eq!(serde_json::to_value(state).unwrap(), state.word());
        }
    }

    proptest! {
        #[test]
        fn a_state_is_never_without_its_alarm_and_knows_no_later_frame(
            alarm in prop::collection::vec(any::<bool>(), 0..40),
            recovery in 1_usize..12,
            cut in 0_usize..40,
        ) {
            let states = lost(&alarm, recovery);
            prop_assert!(states.iter().zip(&alarm).all(|(lost, alarm)| *lost || !alarm));
            prop_assert_eq!(lost(&alarm, 1), alarm.clone());
            let longer = lost(&alarm, recovery + 1);
            prop_assert!(states.iter().zip(&longer).all(|(short, long)| !short || *long));
            let cut = cut.min(alarm.len());
            prop_assert_eq!(&lost(&alarm[..cut], recovery)[..], &states[..cut]);
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
