//! One-to-one matching of detections with events in time.
//!
//! Among all pairs at most `tolerance` frames apart, the nearest pair is matched first, ties by the
//! earlier event, then by the earlier detection; both are then used up. Frames are 0-based indices.

/// Matched pairs `(event, detection)` as indices into the two lists, ordered by event.
///
/// Both lists must be ascending.
pub fn match_nearest(events: &[usize], detections: &[usize], tolerance: usize) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    for (i, &event) in events.iter().enumerate() {
        let from = detections.partition_point(|&d| d + tolerance < event);
        for (j, &detection) in detections.iter().enumerate().skip(from) {
            if detection > event + tolerance {
                break;
            }
            pairs.push((event.abs_diff(detection), i, j));
        }
    }
    pairs.sort_unstable();
    let mut event_used = vec![false; events.len()];
    let mut detection_used = vec![false; detections.len()];
    let mut matches = Vec::new();
    for (_, i, j) in pairs {
        if !event_used[i] && !detection_used[j] {
            event_used[i] = true;
            detection_used[j] = true;
            matches.push((i, j));
        }
    }
    matches.sort_unstable();
    matches
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    // Worked by hand.
    #[test]
    fn nearest_first_then_earliest() {
        // 10-12 is nearer than 10-7; 7 is then left without a partner.
        assert_eq!(match_nearest(&[10], &[7, 12], 5), [(0, 1)]);
        // Equal distances: the earlier detection.
        assert_eq!(match_nearest(&[10], &[8, 12], 5), [(0, 0)]);
        // One detection between two events goes to the earlier.
        assert_eq!(match_nearest(&[10, 14], &[12], 5), [(0, 0)]);
        // Greedy: 20-21 first, so 16 must take 12 and not 21.
        assert_eq!(match_nearest(&[16, 20], &[12, 21], 5), [(0, 0), (1, 1)]);
        // Exactly at the tolerance, and one beyond.
        assert_eq!(match_nearest(&[10], &[15], 5), [(0, 0)]);
        assert!(match_nearest(&[10], &[16], 5).is_empty());
    }

    fn frames() -> impl Strategy<Value = Vec<usize>> {
        proptest::collection::btree_set(0usize..120, 0..25).prop_map(|s| s.into_iter().collect())
    }

    proptest! {
        #[test]
        fn is_one_to_one_within_tolerance_and_maximal(e in frames(), d in frames(), tolerance in 0usize..8) {
            let m = match_nearest(&e, &d, tolerance);
            let mut used_e = vec![false; e.len()];
            let mut used_d = vec![false; d.len()];
            for &(i, j) in &m {
                prop_assert!(e[i].abs_diff(d[j]) <= tolerance);
                prop_assert!(!used_e[i] && !used_d[j]);
                used_e[i] = true;
                used_d[j] = true;
            }
            for (i, &ev) in e.iter().enumerate() {
                for (j, &de) in d.iter().enumerate() {
                    prop_assert!(used_e[i] || used_d[j] || ev.abs_diff(de) > tolerance);
                }
            }
        }

        #[test]
        fn starting_later_changes_nothing(e in frames(), d in frames(), shift in 0usize..50) {
            let moved = |v: &[usize]| v.iter().map(|x| x + shift).collect::<Vec<_>>();
            prop_assert_eq!(match_nearest(&e, &d, 5), match_nearest(&moved(&e), &moved(&d), 5));
        }
    }
}
