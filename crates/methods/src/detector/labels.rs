//! From labels to changes: where a run of alarms begins and ends.

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

    proptest! {
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
