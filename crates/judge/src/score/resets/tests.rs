use super::*;
use crate::score::testing::{rect, square, status, trajectory};
use trackfail_testing::assert_near;

const RULES: Rules = Rules { areas: Areas::Exact, bounded: false, burn_in: 2 };

// Worked by hand. Frames: start, burn-in, .6 (shift 2.5), 1/3 (shift 5), failure, skipped, start, burn-in, 1, 1.
// Accuracy (.6 + 1/3 + 1 + 1) / 4. Runs: [0, 1, .6, 1/3] failed and [0, 1, 1, 1] to the end.
// E(1) = 1; E(2) = (.8 + 1) / 2; E(3) = ((1 + .6 + 1/3) / 3 + 1) / 2. The second run leaves, the first does not: none
// is longer than 4 frames.
#[test]
fn a_track_worked_by_hand() {
    let status = status("itttfsittt");
    let shift = [0.0, 0.0, 2.5, 5.0, 5.0, 5.0, 0.0, 0.0, 0.0, 0.0];
    let (regions, truth) = (shift.map(square), vec![Some(square(0.0)); 10]);
    let trajectory = trajectory(&regions, &status, &truth);
    let measured = RULES.measure(&trajectory);
    assert_eq!(measured.failures, 1);
    assert_near(measured.accuracy, [(0.6 + 1.0 / 3.0 + 2.0) / 4.0], 1e-12, "accuracy");
    let curve = expected_overlap(&[(trajectory, measured)]);
    let expected = [0.0, 1.0, 0.9, ((1.6 + 1.0 / 3.0) / 3.0 + 1.0) / 2.0];
    assert_near(curve.iter().map(|overlap| overlap.unwrap()), expected, 1e-12, "curve");
    assert_near(expected_average_overlap(&curve, 1, 2), [0.95], 1e-12, "mean");
    assert_eq!(expected_average_overlap(&curve, 4, 9), None);
}

// By hand: half of the tracker's box is off the frame, and the other half is the target.
#[test]
fn a_start_never_counts_and_an_absent_target_counts_as_missed() {
    let regions = vec![rect(-10.0, 0.0, 20.0, 10.0); 3];
    let (status, truth) = (status("ita"), vec![Some(square(0.0)); 3]);
    let trajectory = Trajectory { frame: Some((40, 40)), ..trajectory(&regions, &status, &truth) };
    for (bounded, overlap) in [(false, 0.5), (true, 1.0)] {
        let rules = Rules { bounded, burn_in: 0, ..RULES };
        let measured = rules.measure(&trajectory);
        assert_eq!(measured.overlaps, [0.0, overlap, 0.0]);
        assert_eq!((measured.counts, measured.accuracy), (vec![false, true, true], Some(overlap / 2.0)));
    }
}

#[test]
fn a_failed_run_goes_on_with_nothing_and_a_finished_one_leaves() {
    let (truth, regions) = (vec![Some(square(0.0)); 5], vec![square(0.0); 5]);
    let statuses = ["itf", "itttt", "it"].map(status);
    let [failed, finished, short] = statuses.each_ref().map(|status| {
        let frames = status.len();
        trajectory(&regions[..frames], status, &truth[..frames])
    });
    let with = |list: &[Trajectory<'_>]| {
        expected_overlap(&list.iter().map(|c| (*c, RULES.measure(c))).collect::<Vec<_>>())
    };
    assert_eq!(with(&[failed, finished]), [0.0, 1.0, 0.75, (1.0 / 3.0 + 1.0) / 2.0, 0.625].map(Some));
    assert_eq!(with(&[short, finished]), [0.0, 1.0, 1.0, 1.0, 1.0].map(Some));
    assert!(expected_overlap(&[]).is_empty());
}

#[test]
fn frames_without_truth_or_a_start_do_not_count() {
    let truth = [None, Some(square(0.0)), Some(square(0.0)), Some(square(0.0)), None];
    let regions = vec![square(0.0); 5];
    let measured = RULES.measure(&trajectory(&regions, &status("wittt"), &truth));
    assert_eq!(measured.counts, [false, false, false, true, false]);
    assert_eq!((measured.accuracy, measured.failures), (Some(1.0), 0));
    let nothing = RULES.measure(&trajectory(&regions[..1], &status("i"), &truth[1..2]));
    assert_eq!(nothing.accuracy, None);
    assert_eq!(of_sequence(&[&measured, &nothing]), Some((0.5, 0.0)));
}
