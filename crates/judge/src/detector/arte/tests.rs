use super::super::track_quality::machine::TRANSITIONS;
use super::super::track_quality::testing::{Fake, letters, marks, rows};
use super::super::track_quality::{Check, Condition};
use super::*;
use proptest::prelude::*;

fn built(text: &str) -> Arte {
    let params: toml::Table = toml::from_str(&format!("v = {text}")).unwrap();
    Arte::new(params["v"].clone().try_into().unwrap()).unwrap()
}

fn detect(text: &str, signal: &[f64], reverse: &Fake) -> DetectorOutput {
    built(text).detect(&Input { signal, error: &[], seed: 0, reverse: Some(reverse), more: &[] })
}

fn checks(output: &DetectorOutput) -> Vec<Check> {
    output.quality.as_ref().map(|q| q.checks.clone()).unwrap()
}

// By hand: a rise from 1 to 5 is (5 - 1) / 1, a fall from 5 to 1 is (1 - 5) / 1, or (1 - 5) / 5.
#[test]
fn a_rise_and_a_fall_by_the_same_factor_are_as_large() {
    let ends = |text: &str, smoothed: &[f64]| built(text).changes(smoothed, smoothed.len() - 1);
    assert_eq!(ends("{}", &[1.0, 5.0]).long_increase, 4.0);
    assert_eq!(ends("{}", &[1.0, 5.0]).short_increase, 4.0);
    assert_eq!(ends("{}", &[5.0, 1.0]).long_decrease, -4.0);
    assert_eq!(ends("{}", &[5.0, 1.0]).short_decrease, -4.0);
    assert_eq!(ends("{ decrease = \"over-reference\" }", &[5.0, 1.0]).long_decrease, -0.8);
    assert_eq!(ends("{}", &[5.0]), Changes::default());
    // The short window has forgotten what the long one knows.
    let forgotten = ends("{ long = 3, short = 2 }", &[1.0, 4.0, 4.0, 4.0]);
    assert_eq!((forgotten.long_increase, forgotten.short_increase), (3.0, 0.0));
}

// python3: import numpy as np
// u = np.array([9, 7, 4, 1e-12, 2, 3, 8, 1, .5, 6, 5, 1.]); S = np.full(12, 1e-12); c = np.zeros((12, 4))
// for t in range(12):
//     w = u[max(2, t - 2):t + 1]; w = w[w > 1e-12]
//     if w.size: S[t] = w.mean()
// for t in range(2, 12):
//     for k, W in enumerate((5, 2)):
//         p = S[max(2, t - W):t]; p = p[p > 1e-12]
//         if p.size: c[t, k], c[t, 2 + k] = ((S[t] - p) / p).max(), ((S[t] - p) / S[t]).min()
// S.tolist(), c.tolist()          (and with ((S[t] - p) / p).min() for OVER_REFERENCE)
#[test]
fn agrees_with_numpy() {
    let u = [9.0, 7.0, 4.0, 1e-12, 2.0, 3.0, 8.0, 1.0, 0.5, 6.0, 5.0, 1.0];
    let near = |a: f64, b: f64| (a - b).abs() < 1e-14;
    for (form, decreases) in [("over-current", &OVER_CURRENT), ("over-reference", &OVER_REFERENCE)] {
        let arte =
            built(&format!("{{ long = 5, short = 2, smoothing = 3, settling = 2, decrease = \"{form}\" }}"));
        let smoothed = arte.smoothed(&u);
        assert!(smoothed.iter().zip(SMOOTHED).all(|(a, b)| near(*a, b)), "{smoothed:?}");
        for t in 0..u.len() {
            let c = arte.changes(&smoothed, t);
            let (long, short) =
                (t.checked_sub(4).map(|k| LONG_SHORT[k]), t.checked_sub(4).map(|k| decreases[k]));
            let (increase, decrease) = (long.unwrap_or_default(), short.unwrap_or_default());
            assert!(near(c.long_increase, increase[0]) && near(c.short_increase, increase[1]), "{t} {c:?}");
            assert!(near(c.long_decrease, decrease[0]) && near(c.short_decrease, decrease[1]), "{t} {c:?}");
        }
        let score = arte.events(&u).0;
        assert!(score[4..].iter().zip(LONG_SHORT).all(|(a, b)| near(*a, b[0].max(b[1]))), "{score:?}");
    }
}
const SMOOTHED: [f64; 12] = [
    1e-12,
    1e-12,
    4.0,
    4.0,
    3.0,
    2.5,
    4.333333333333333,
    4.0,
    3.1666666666666665,
    2.5,
    3.8333333333333335,
    4.0,
];
// From frame 4 on; before it all are 0.
const LONG_SHORT: [[f64; 2]; 8] = [
    [-0.25, -0.25],
    [-0.16666666666666666, -0.16666666666666666],
    [0.7333333333333332, 0.7333333333333332],
    [0.6, 0.6],
    [0.2666666666666666, -0.20833333333333337],
    [0.0, -0.21052631578947364],
    [0.5333333333333334, 0.5333333333333334],
    [0.6, 0.6],
];
const OVER_CURRENT: [[f64; 2]; 8] = [
    [-0.3333333333333333, -0.3333333333333333],
    [-0.6, -0.6],
    [0.07692307692307686, 0.30769230769230765],
    [-0.08333333333333326, -0.08333333333333326],
    [-0.3684210526315789, -0.3684210526315789],
    [-0.7333333333333332, -0.6],
    [-0.13043478260869554, 0.17391304347826095],
    [-0.08333333333333326, 0.04166666666666663],
];
const OVER_REFERENCE: [[f64; 2]; 8] = [
    [-0.25, -0.25],
    [-0.375, -0.375],
    [0.08333333333333326, 0.44444444444444436],
    [-0.07692307692307686, -0.07692307692307686],
    [-0.2692307692307692, -0.2692307692307692],
    [-0.423076923076923, -0.375],
    [-0.1153846153846153, 0.21052631578947378],
    [-0.07692307692307686, 0.043478260869565175],
];

/// Windows of three frames without smoothing; tau_1, tau_2 and tau_3 are 2, -2 and -1.
const PLAIN: &str = "smoothing = 1, long = 3, short = 3, tau_1 = 2.0, locking_in_limit = 3";

/// Uncertainties that take every row of the table. Changes by hand: 1 to 4 is +3, 4 to 1.6 is -1.5, 1.6 to 6
/// is +2.75, 4 to 1 is -3. The track is lost in frame 3, on a distractor in frame 7, recovered in frame 11,
/// lost in frame 14; waiting is over in frame 18.
const SCRIPT: [f64; 19] =
    [1.0, 1.0, 1.0, 4.0, 4.0, 1.6, 6.0, 1.0, 1.0, 4.0, 1.6, 1.0, 1.0, 1.0, 4.0, 1.6, 1.6, 1.6, 1.6];

#[test]
fn a_series_goes_through_every_row() {
    let reverse = Fake::new(|from, _| Some(if from == 7 { 0.9 } else { 0.3 }));
    let text = format!("{{ {PLAIN} }}");
    let output = detect(&text, &SCRIPT, &reverse);
    let quality = output.quality.as_ref().unwrap();
    assert_eq!(letters(quality), "ooossisoosiooosiiio");
    assert_eq!(marks(&output.alarm), "...xxxxxxxx...xxxx.");
    // The rise to the distractor's end in frame 9 has left the reference where it was.
    assert_eq!(reverse.asked(), [(7, 2), (11, 2), (18, 13)]);
    let accepted: Vec<bool> = quality.checks.iter().map(|c| c.accepted).collect();
    assert_eq!(accepted, [false, true, true]);
    assert_eq!(quality.effort().frames, 5 + 9 + 5);
    let used = rows(3, &built(&text).events(&SCRIPT).1, quality);
    assert_eq!(used, [0, 1, 3, 4, 2, 0, 3, 5, 0, 3, 6]);
    assert!((0..TRANSITIONS.len()).all(|k| used.contains(&k)));
}

#[test]
fn a_reference_that_is_too_far_is_not_run_to() {
    let reverse = Fake::new(|from, _| Some(if from == 7 { 0.9 } else { 0.3 }));
    let output = detect(&format!("{{ {PLAIN}, reverse_limit = 5 }}"), &SCRIPT, &reverse);
    assert_eq!(marks(&output.alarm), "...xxxxxxxxxxxxxxxx");
    assert_eq!(letters(output.quality.as_ref().unwrap()), "ooossisoosiooosiiio");
    assert_eq!(reverse.asked(), [(7, 2)]);
    let tried: Vec<_> = checks(&output).iter().map(|c| (c.frame, c.reference, c.error)).collect();
    assert_eq!(tried, [(7, 2, Some(0.9)), (11, 2, None), (18, 2, None)]);
}

#[test]
fn without_a_way_back_a_lost_track_stays_lost() {
    let arte = built(&format!("{{ {PLAIN} }}"));
    assert!(arte.needs_reverse());
    let alone = arte.detect(&Input { signal: &SCRIPT, error: &[], seed: 0, reverse: None, more: &[] });
    let broken = arte.detect(&Input {
        signal: &SCRIPT,
        error: &[],
        seed: 0,
        reverse: Some(&Fake::always(None)),
        more: &[],
    });
    assert_eq!(alone, broken);
    assert_eq!(marks(&alone.alarm), "...xxxxxxxxxxxxxxxx");
    assert!(checks(&alone).iter().all(|c| c.error.is_none() && !c.accepted));
    let strict = format!("{{ {PLAIN}, accept_below = 0.3 }}");
    assert_eq!(detect(&strict, &SCRIPT, &Fake::always(Some(0.3))).alarm, alone.alarm);
}

// After a rise to 20 and a fall to 5 both changes are large; as long as the 1 is in the window nothing is
// checked, and then once. By hand: frames 2 to 4 have the 1 of frame 1 in their window, frame 5 only 20 and 5.
#[test]
fn half_a_fall_is_no_recovery() {
    let reverse = Fake::always(Some(0.0));
    let output = detect(&format!("{{ {PLAIN} }}"), &[1.0, 1.0, 20.0, 5.0, 5.0, 5.0, 5.0], &reverse);
    assert_eq!(letters(output.quality.as_ref().unwrap()), "oosssoo");
    assert_eq!(reverse.asked(), [(5, 1)]);
}

#[test]
fn own_thresholds_take_the_place_of_tied_ones() {
    let reverse = Fake::always(Some(0.0));
    let run = |more: &str| {
        let output = detect(&format!("{{ {PLAIN}, {more} }}"), &[1.0, 1.0, 4.0, 1.6, 1.0, 1.0], &reverse);
        letters(output.quality.as_ref().unwrap())
    };
    assert_eq!(run("settling = 0"), "oosioo");
    assert_eq!(built("{ tau_1 = 3.05 }").threshold(), Some(3.05));
    assert_eq!(run("tau_2 = -1.4"), "oosooo");
    assert_eq!(run("tau_3 = -1.6"), "oossoo");
    assert_eq!(run("tau_2 = -3.5"), "oosiii");
    // A fall over the old value is more than -1, and the tied thresholds are out of its reach.
    assert_eq!(run("decrease = \"over-reference\""), "oossss");
    assert_eq!(run("decrease = \"over-reference\", tau_2 = -0.7, tau_3 = -0.5"), "oosioo");
}

// Smoothing: the mean of 1, 1, 1, 1, 11 is 3, so the score is (3 - 1) / 1.
#[test]
fn smoothing_is_causal() {
    let signal = [1.0, 1.0, 1.0, 1.0, 11.0, 1.0];
    let score = detect("{}", &signal, &Fake::always(None)).score;
    assert_eq!(score[..4], [0.0; 4]);
    assert!((score[4] - 2.0).abs() < 1e-12 && (score[5] - 2.0).abs() < 1e-12, "{score:?}");
}

#[test]
fn the_start_and_the_floor_are_no_reference() {
    let none = Fake::always(None);
    // A filter that starts without spread: nothing but the floor to be compared with.
    let start = [1e-12, 1.0, 1.0, 1.2, 1.0];
    let output = detect("{ smoothing = 1 }", &start, &none);
    assert_eq!(marks(&output.alarm), ".....");
    assert_eq!(output.score[..3], [0.0; 3]);
    // With another floor it is a rise.
    assert_eq!(marks(&detect("{ smoothing = 1, floor = 1e-13 }", &start, &none).alarm), ".xxxx");
    // A spread that grows at the start is a rise, unless it settles.
    let grows = [0.01, 0.1, 0.5, 1.0, 1.0, 1.0];
    assert_eq!(marks(&detect("{ smoothing = 2 }", &grows, &none).alarm), ".xxxxx");
    let settled = detect("{ smoothing = 2, settling = 3 }", &grows, &none);
    assert_eq!((marks(&settled.alarm), settled.score), ("......".to_string(), vec![0.0; 6]));
    assert_eq!(detect("{ settling = 9 }", &SCRIPT[..6], &none).score, [0.0; 6]);
    // A collapse is a fall when it comes, and no reference afterwards.
    let collapse = [1.0, 1.0, 5.0, 1e-12, 1.0, 1.0];
    let output = detect(&format!("{{ {PLAIN} }}"), &collapse, &Fake::always(Some(0.0)));
    assert_eq!(letters(output.quality.as_ref().unwrap()), "oosooo");
    assert_eq!(checks(&output).len(), 1);
}

// By hand, tau_1, tau_2, tau_3 = 2, -2, -1: 1 to 3 is +2, 3 to 1 is -2, 2 to 1 is -1.
#[test]
fn a_change_at_the_threshold_is_no_event() {
    use Event::{LargeDecrease, LargeIncrease, SmallDecrease};
    let all = [LargeIncrease, LargeDecrease, SmallDecrease];
    for (from, to, expected) in [
        (1.0, 3.0, [false, false, false]),
        (1.0, 3.5, [true, false, false]),
        (3.0, 1.0, [false, false, true]),
        (3.5, 1.0, [false, true, true]),
        (2.0, 1.0, [false, false, false]),
        (2.5, 1.0, [false, false, true]),
    ] {
        let events = built(&format!("{{ {PLAIN} }}")).events(&[from, to]).1[1];
        assert_eq!(all.map(|event| events.contains(event)), expected, "{from} {to}");
    }
}

/// Uncertainty with noise that stays at a level for some frames.
fn uncertainty() -> impl Strategy<Value = Vec<f64>> {
    let piece = (0.1..20.0_f64, prop::collection::vec(0.8..1.25_f64, 1..25));
    prop::collection::vec(piece, 1..12)
        .prop_map(|all| all.iter().flat_map(|(level, noise)| noise.iter().map(move |n| level * n)).collect())
}

/// Reverse runs whose errors depend on the frames alone; about half of them are good.
fn mixed() -> Fake {
    Fake::new(|from, to| Some(((from * 7 + to * 3) % 16) as f64 / 10.0))
}

proptest! {
    #[test]
    fn a_factor_of_the_uncertainty_changes_nothing(u in uncertainty(), by in 1e-3..1e3_f64, power in -20..20_i32) {
        let labels = |by: f64| {
            let scaled: Vec<f64> = u.iter().map(|u| u * by).collect();
            detect("{}", &scaled, &mixed())
        };
        // Exact for powers of two; otherwise the labels are, as no change is that near to a threshold.
        prop_assert_eq!(labels(1.0), labels(2.0_f64.powi(power)));
        prop_assert_eq!(labels(1.0).quality, labels(by).quality);
        prop_assert_eq!(labels(1.0).alarm, labels(by).alarm);
    }

    #[test]
    fn no_label_uses_a_later_frame(u in uncertainty(), share in 0.0..1.0_f64, settling in 0..30_usize) {
        let text = format!("{{ settling = {settling} }}");
        let whole = detect(&text, &u, &mixed());
        let frames = (share * u.len() as f64) as usize;
        let part = detect(&text, &u[..frames], &mixed());
        prop_assert_eq!(&whole.score[..frames], &part.score[..]);
        prop_assert_eq!(&whole.alarm[..frames], &part.alarm[..]);
        let early: Vec<Check> = checks(&whole).into_iter().filter(|c| c.frame < frames).collect();
        prop_assert_eq!(early, checks(&part));
        prop_assert_eq!(&whole.quality.unwrap().condition[..frames], &part.quality.unwrap().condition[..]);
    }

    #[test]
    fn alarms_begin_with_a_rise_and_end_with_an_accepted_check(u in uncertainty(), smoothing in 1..8_usize) {
        let output = detect(&format!("{{ smoothing = {smoothing} }}"), &u, &mixed());
        let quality = output.quality.as_ref().unwrap();
        for t in 0..u.len() {
            let before = t.checked_sub(1).is_some_and(|t| output.alarm[t]);
            let accepted = quality.checks.iter().any(|c| c.frame == t && c.accepted);
            if output.alarm[t] && !before {
                prop_assert!(output.score[t] > 2.05 && quality.condition[t] == Condition::Scanning);
            }
            prop_assert_eq!(before && !output.alarm[t], accepted);
        }
        // The reference is the last frame without an alarm.
        for check in &quality.checks {
            let last = (0..check.frame).rev().find(|t| !output.alarm[*t]);
            prop_assert_eq!(last, Some(check.reference));
        }
        // The short window is a part of the long one.
        let arte = built("{}");
        let smoothed = arte.smoothed(&u);
        prop_assert!((0..u.len()).map(|t| arte.changes(&smoothed, t)).all(|c|
            c.short_increase <= c.long_increase && c.short_decrease >= c.long_decrease));
    }

    #[test]
    fn beyond_every_change_nothing_happens(u in uncertainty()) {
        let output = detect("{ tau_1 = 1e300 }", &u, &mixed());
        prop_assert!(output.quality.unwrap().condition.iter().all(|c| *c == Condition::LockedOn));
        prop_assert!(!output.alarm.contains(&true));
    }
}
