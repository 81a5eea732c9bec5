use super::super::track_quality::machine::TRANSITIONS;
use super::super::track_quality::testing::{Fake, check_alarms, letters, levels, marks, quality, rows, with};
use super::super::track_quality::{Condition, Effort};
use super::*;
use crate::detector::testing::{alone, plugin};
use proptest::prelude::*;
use trackfail_testing::assert_near;

fn built(text: &str) -> Params {
    plugin(text)
}

fn detect(text: &str, signal: &[f64], reverse: &Fake) -> DetectorOutput {
    built(text).detect(&with(signal, reverse))
}

// By the definition: the largest of the rises from each value of a window, and the least of the falls. numpy has, of the
// values that are smoothed, 3.1666666666666665 and 3.8333333333333335 in frames 8 and 10.
#[test]
fn changes_are_those_of_the_definition() {
    let u = [9.0, 7.0, 4.0, 1e-12, 2.0, 3.0, 8.0, 1.0, 0.5, 6.0, 5.0, 1.0];
    let last = |list: &[f64], window: usize| -> Vec<f64> {
        let from = list.len().saturating_sub(window).max(2);
        list.iter().skip(from).copied().filter(|v| *v > 1e-12).collect()
    };
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let s: [f64; 12] = std::array::from_fn(|t| if t < 2 { 1e-12 } else { mean(last(&u[..=t], 3)) });
    assert_near([s[8], s[10]], [3.1666666666666665, 3.8333333333333335], 1e-14, "numpy");
    for form in ["over-current", "over-reference"] {
        let arte =
            built(&format!("{{ long = 5, short = 2, smoothing = 3, settling = 2, decrease = \"{form}\" }}"));
        let (smoothed, score) = (arte.smoothed(&u), arte.events(&u).0);
        assert_near(&smoothed, s, 1e-14, form);
        for t in 0..u.len() {
            let change = |window: usize| {
                let past = last(&s[..t], window);
                let over = |p: f64| if form == "over-current" { s[t] } else { p };
                let rise = past.iter().map(|p| (s[t] - p) / p).reduce(f64::max);
                let fall = past.iter().map(|p| (s[t] - p) / over(*p)).reduce(f64::min);
                [rise.unwrap_or_default(), fall.unwrap_or_default()]
            };
            let (long, short, got) = (change(5), change(2), arte.changes(&smoothed, t).map(<[f64; 2]>::from));
            assert_near(got.concat(), [long, short].concat(), 1e-14, t);
            assert_near([score[t]], [long[0].max(short[0])], 1e-14, t);
        }
    }
}

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
    let output = detect(&format!("{{ {PLAIN} }}"), &SCRIPT, &reverse);
    assert_eq!(letters(&output), "ooossisoosiooosiiio");
    assert_eq!(marks(&output.alarm), "...xxxxxxxx...xxxx.");
    // The rise to the distractor's end in frame 9 has left the reference where it was.
    assert_eq!(reverse.asked(), [(7, 2), (11, 2), (18, 13)]);
    let accepted: Vec<bool> = quality(&output).checks.iter().map(|c| c.accepted).collect();
    assert_eq!(accepted, [false, true, true]);
    assert_eq!(quality(&output).effort().frames, 5 + 9 + 5);
    let used = rows(&output);
    assert_eq!(used, [0, 1, 3, 4, 2, 0, 3, 5, 0, 3, 6]);
    assert!((0..TRANSITIONS.len()).all(|k| used.contains(&k)));
    let effort = [(2, 5), (3, 4)].map(|(runs, frames)| Effort { runs, frames }).into_iter().sum();
    assert_eq!(Effort { runs: 5, frames: 9 }, effort);
    use Condition::{LockedOn, LockingIn, Scanning};
    assert_eq!([LockedOn, LockingIn, Scanning].map(Condition::level), [1.0, 0.5, 0.0]);
}

#[test]
fn a_reference_that_is_too_far_is_not_run_to() {
    let reverse = Fake::new(|from, _| Some(if from == 7 { 0.9 } else { 0.3 }));
    let output = detect(&format!("{{ {PLAIN}, reverse_limit = 5 }}"), &SCRIPT, &reverse);
    assert_eq!(marks(&output.alarm), "...xxxxxxxxxxxxxxxx");
    assert_eq!(letters(&output), "ooossisoosiooosiiio");
    assert_eq!(reverse.asked(), [(7, 2)]);
    let tried: Vec<_> = quality(&output).checks.iter().map(|c| (c.frame, c.reference, c.error)).collect();
    assert_eq!(tried, [(7, 2, Some(0.9)), (11, 2, None), (18, 2, None)]);
}

#[test]
fn without_a_way_back_a_lost_track_stays_lost() {
    let arte = built(&format!("{{ {PLAIN} }}"));
    assert!(arte.facts().needs_reverse);
    let output = arte.detect(&alone(&SCRIPT));
    assert_eq!(output, arte.detect(&with(&SCRIPT, &Fake::always(None))));
    assert_eq!(marks(&output.alarm), "...xxxxxxxxxxxxxxxx");
    assert!(quality(&output).checks.iter().all(|c| c.error.is_none() && !c.accepted));
    let strict = format!("{{ {PLAIN}, accept_below = 0.3 }}");
    assert_eq!(detect(&strict, &SCRIPT, &Fake::always(Some(0.3))).alarm, output.alarm);
}

// After a rise to 20 and a fall to 5 both changes are large; as long as the 1 is in the window nothing is
// checked, and then once. By hand: frames 2 to 4 have the 1 of frame 1 in their window, frame 5 only 20 and 5.
#[test]
fn half_a_fall_is_no_recovery() {
    let reverse = Fake::always(Some(0.0));
    let output = detect(&format!("{{ {PLAIN} }}"), &[1.0, 1.0, 20.0, 5.0, 5.0, 5.0, 5.0], &reverse);
    assert_eq!(letters(&output), "oosssoo");
    assert_eq!(reverse.asked(), [(5, 1)]);
}

#[test]
fn own_thresholds_take_the_place_of_tied_ones() {
    let reverse = Fake::always(Some(0.0));
    assert_eq!(built("{ tau_1 = 3.05 }").facts().threshold, Some(3.05));
    // A fall over the old value is more than -1, and the tied thresholds are out of its reach.
    for (more, want) in [
        ("settling = 0", "oosioo"),
        ("tau_2 = -1.4", "oosooo"),
        ("tau_3 = -1.6", "oossoo"),
        ("tau_2 = -3.5", "oosiii"),
        ("decrease = \"over-reference\"", "oossss"),
        ("decrease = \"over-reference\", tau_2 = -0.7, tau_3 = -0.5", "oosioo"),
    ] {
        let output = detect(&format!("{{ {PLAIN}, {more} }}"), &[1.0, 1.0, 4.0, 1.6, 1.0, 1.0], &reverse);
        assert_eq!(letters(&output), want, "{more}");
    }
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
    assert_eq!((letters(&output).as_str(), quality(&output).checks.len()), ("oosooo", 1));
}

// By hand, tau_1, tau_2, tau_3 = 2, -2, -1: 1 to 3 is +2, 3 to 1 is -2, 2 to 1 is -1.
#[test]
fn a_change_at_the_threshold_is_no_event() {
    for (from, to, expected) in [
        (1.0, 3.0, [false, false, false]),
        (1.0, 3.5, [true, false, false]),
        (3.0, 1.0, [false, false, true]),
        (3.5, 1.0, [false, true, true]),
        (2.0, 1.0, [false, false, false]),
        (2.5, 1.0, [false, false, true]),
    ] {
        let events = built(&format!("{{ {PLAIN} }}")).events(&[from, to]).1;
        assert_eq!(events[1], expected, "{from} {to}");
    }
}

/// Uncertainty with noise that stays at a level for some frames.
fn uncertainty() -> impl Strategy<Value = Vec<f64>> {
    levels(0.1..20.0_f64, 0.8..1.25, 1..12)
}

proptest! {
    #[test]
    fn a_factor_of_the_uncertainty_changes_nothing(u in uncertainty(), by in 1e-3..1e3_f64, power in -20..20_i32) {
        let labels = |by: f64| {
            let scaled: Vec<f64> = u.iter().map(|u| u * by).collect();
            detect("{}", &scaled, &Fake::mixed())
        };
        // Exact for powers of two; otherwise the labels are, as no change is that near to a threshold.
        let (one, other) = (labels(1.0), labels(by));
        prop_assert_eq!(&one, &labels(2.0_f64.powi(power)));
        prop_assert_eq!((one.quality, one.alarm), (other.quality, other.alarm));
    }

    #[test]
    fn alarms_begin_with_a_rise_and_end_with_an_accepted_check(u in uncertainty(), smoothing in 1..8_usize) {
        check_alarms(&detect(&format!("{{ smoothing = {smoothing} }}"), &u, &Fake::mixed()), 2.05);
    }
}
