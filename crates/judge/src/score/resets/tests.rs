use super::*;
use crate::region::{Rect, Region};

const RULES: Rules = Rules { areas: Areas::Exact, bounded: false, burn_in: 2 };

fn square(x: f64) -> Region {
    Region::Rect(Rect::new(x, 0.0, 10.0, 10.0))
}

/// Trajectory over a target that stays at 0.
fn trajectory<'a>(
    regions: &'a [Region],
    status: &'a [Status],
    truth: &'a [Option<Region>],
) -> Trajectory<'a> {
    let (attributes, frame_attributes) = (&[], &[]);
    Trajectory {
        sequence: "a",
        regions,
        status,
        truth,
        frame: Some((40, 40)),
        attributes,
        frame_attributes,
        ..Trajectory::default()
    }
}

// Worked by hand. Frames: start, burn-in, .6 (shift 2.5), 1/3 (shift 5), failure, skipped, start, burn-in, 1, 1.
// Accuracy (.6 + 1/3 + 1 + 1) / 4. Runs: [0, 1, .6, 1/3] failed and [0, 1, 1, 1] to the end.
// E(1) = 1; E(2) = (.8 + 1) / 2; E(3) = ((1 + .6 + 1/3) / 3 + 1) / 2. The second run leaves, the first does not: none
// is longer than 4 frames.
#[test]
fn a_track_worked_by_hand() {
    use Status::{Failed, Initialized as Started, Skipped, Tracked};
    let status = [Started, Tracked, Tracked, Tracked, Failed, Skipped, Started, Tracked, Tracked, Tracked];
    let shift = [0.0, 0.0, 2.5, 5.0, 5.0, 5.0, 0.0, 0.0, 0.0, 0.0];
    let (regions, truth) = (shift.map(square), vec![Some(square(0.0)); 10]);
    let trajectory = trajectory(&regions, &status, &truth);
    let measured = RULES.measure(&trajectory);
    assert_eq!(measured.failures, 1);
    assert!((measured.accuracy.unwrap() - (0.6 + 1.0 / 3.0 + 2.0) / 4.0).abs() < 1e-12);
    let curve = expected_overlap(&[(trajectory, measured)]);
    let expected = [0.0, 1.0, 0.9, ((1.6 + 1.0 / 3.0) / 3.0 + 1.0) / 2.0];
    assert_eq!(curve.len(), 4);
    for (got, expected) in curve.iter().zip(expected) {
        assert!((got.unwrap() - expected).abs() < 1e-12, "{curve:?}");
    }
    let eao = expected_average_overlap(&curve, 1, 2).unwrap();
    assert!((eao - 0.95).abs() < 1e-12);
    assert_eq!(expected_average_overlap(&curve, 4, 9), None);
}

// By hand: half of the tracker's box is off the frame, and the other half is the target.
#[test]
fn a_start_never_counts_and_an_absent_target_counts_as_missed() {
    use Status::{Absent, Initialized as Started, Tracked};
    let regions = vec![Region::Rect(Rect::new(-10.0, 0.0, 20.0, 10.0)); 3];
    let truth = vec![Some(square(0.0)); 3];
    for (bounded, overlap) in [(false, 0.5), (true, 1.0)] {
        let rules = Rules { bounded, burn_in: 0, ..RULES };
        let measured = rules.measure(&trajectory(&regions, &[Started, Tracked, Absent], &truth));
        assert_eq!(measured.overlaps, [0.0, overlap, 0.0]);
        assert_eq!((measured.counts, measured.accuracy), (vec![false, true, true], Some(overlap / 2.0)));
    }
}

#[test]
fn a_failed_run_goes_on_with_nothing_and_a_finished_one_leaves() {
    use Status::{Failed, Initialized as Started, Tracked};
    let truth = vec![Some(square(0.0)); 5];
    let regions = vec![square(0.0); 5];
    let failed = trajectory(&regions[..3], &[Started, Tracked, Failed], &truth[..3]);
    let finished = trajectory(&regions, &[Started, Tracked, Tracked, Tracked, Tracked], &truth);
    let with = |list: &[Trajectory<'_>]| {
        expected_overlap(&list.iter().map(|c| (*c, RULES.measure(c))).collect::<Vec<_>>())
    };
    assert_eq!(with(&[failed, finished]), [0.0, 1.0, 0.75, (1.0 / 3.0 + 1.0) / 2.0, 0.625].map(Some));
    let short = trajectory(&regions[..2], &[Started, Tracked], &truth[..2]);
    assert_eq!(with(&[short, finished]), [0.0, 1.0, 1.0, 1.0, 1.0].map(Some));
    assert!(expected_overlap(&[]).is_empty());
}

#[test]
fn frames_without_truth_or_a_start_do_not_count() {
    use Status::{Initialized as Started, Tracked, Waiting};
    let truth = [None, Some(square(0.0)), Some(square(0.0)), Some(square(0.0)), None];
    let regions = vec![square(0.0); 5];
    let measured =
        RULES.measure(&trajectory(&regions, &[Waiting, Started, Tracked, Tracked, Tracked], &truth));
    assert_eq!(measured.counts, [false, false, false, true, false]);
    assert_eq!((measured.accuracy, measured.failures), (Some(1.0), 0));
    let nothing = RULES.measure(&trajectory(&regions[..1], &[Started], &truth[1..2]));
    assert_eq!(nothing.accuracy, None);
    assert_eq!(of_sequence(&[&measured, &nothing]), Some((0.5, 0.0)));
}
