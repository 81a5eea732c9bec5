use super::*;

fn in_order(points: &[(f64, f64)], y: Metric) -> Vec<(f64, f64)> {
    let bounds = (f64::NAN, f64::NAN);
    let at = |p: &(f64, f64)| At { point: *p, bounds, worth: p.1, is_published: false };
    let mut all: Vec<At> = points.iter().map(at).collect();
    ordered(&mut all, y);
    all.into_iter().map(|at| at.point).collect()
}

// A threshold that finds less than a stricter one would turn the curve back.
#[test]
fn points_are_in_the_order_of_recall() {
    let points = [(0.4, 0.2), (0.1, 0.9), (0.4, 0.5), (0.3, 0.6)];
    let expected = [(0.1, 0.9), (0.3, 0.6), (0.4, 0.5), (0.4, 0.2)];
    assert_eq!(in_order(&points, Metric::PRECISION), expected);
    let points = [(0.2, 0.4), (0.1, 0.4), (0.3, 0.2)];
    assert_eq!(in_order(&points, Metric::RECALL), [(0.3, 0.2), (0.1, 0.4), (0.2, 0.4)]);
}

// By hand: .1 at .9, .2 more at .6 and .1 more at .5; the second point at .4 adds nothing.
#[test]
fn average_precision_is_a_sum_of_steps() {
    let points = [(0.1, 0.9), (0.3, 0.6), (0.4, 0.5), (0.4, 0.2), (0.5, f64::NAN)];
    assert!((average_precision(&points) - (0.09 + 0.12 + 0.05)).abs() < 1e-12);
    assert_eq!((SHORT.format(0.261), SHORT.format(1.0)), (".26".to_string(), "1.00".to_string()));
}

#[test]
fn shares_end_at_a_round_number_beyond_them() {
    let of = |metric, values: &[f64]| range(metric, values.iter().copied());
    assert_eq!(of(Metric::RECALL, &[0.1, 0.3]), Range::Fixed(0.0, 0.5));
    assert_eq!(of(Metric::DELAY_MEDIAN, &[0.5, -1.0]), Range::Auto);
    assert_eq!(of(Metric::F_OVER_CHANCE, &[0.5, -0.1]), Range::Auto);
}

fn score(events: &[usize], detections: &[usize], matches: &[(usize, usize)]) -> TrackScore {
    let (events, detections, matches) = (events.into(), detections.into(), matches.into());
    TrackScore { events, detections, matches, ..TrackScore::default() }
}

// By hand: four events on two tracks, found 2 frames early, at once and 5 frames late; one is missed.
#[test]
fn shares_add_up_to_the_recall() {
    let tracks = [
        score(&[20, 40, 80], &[3, 18, 85], &[(0, 1), (2, 2)]),
        score(&[30], &[30], &[(0, 0)]),
        score(&[], &[7], &[]),
    ];
    let sampling = Sampling::with_seed(7);
    let points = found_by(&tracks, window(tracks.iter()), &sampling).unwrap();
    let at = |d: f64| points.iter().find(|(p, _)| p.0 == d).map(|(p, _)| p.1);
    assert_eq!((points.len(), at(-5.0), at(-3.0)), (11, Some(0.0), Some(0.0)));
    assert_eq!((at(-2.0), at(-1.0), at(0.0), at(4.0)), (Some(0.25), Some(0.25), Some(0.5), Some(0.5)));
    assert_eq!(at(5.0), Some(0.75));
    assert_eq!(found_by(&tracks[2..], -5..=5, &sampling), None);
    // A later match is in the window, too.
    let late = [score(&[20, 40], &[20, 48], &[(0, 0), (1, 1)])];
    assert_eq!(found_by(&late, window(late.iter()), &sampling).unwrap().pop().unwrap().0, (8.0, 1.0));
}

#[test]
fn a_horizon_without_a_measure_is_a_gap() {
    let mut measures = FrameMeasures::default();
    for (column, value) in [
        ("auroc_within_5", 0.9),
        ("auroc_within_5_low", 0.8),
        ("auroc_within_5_high", 0.95),
        ("auroc_within_30", 0.7),
    ] {
        measures.set(column, Some(value));
    }
    let points = warned(&measures);
    assert_eq!(points[0], ((5.0, 0.9), (0.8, 0.95)));
    assert!(points[1].0.1.is_nan() && points[2].1.0.is_nan());
    assert_eq!(points[2].0, (30.0, 0.7));
}

// The share of each track is the same, so that every sample has it; two tracks are too few.
#[test]
fn bounds_of_shares_need_three_tracks() {
    let events = [20, 40, 60, 80];
    let matches = [0, 1, 2, 3].map(|k| (k, k));
    let last = |found: &[usize]| {
        let tracks: Vec<TrackScore> =
            found.iter().map(|n| score(&events, &events[..*n], &matches[..*n])).collect();
        found_by(&tracks, -5..=5, &Sampling::with_seed(7)).unwrap().pop().unwrap().1
    };
    assert_eq!(last(&[2; 3]), (0.5, 0.5));
    assert!(last(&[2; 2]).0.is_nan());
    let (low, high) = last(&[0, 2, 4, 1]);
    assert!((0.0..0.4375).contains(&low) && (0.4375..=1.0).contains(&high), "{low} {high}");
}
