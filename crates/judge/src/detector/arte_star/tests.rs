use super::super::track_quality::Condition;
use super::super::track_quality::testing::{Fake, check_alarms, letters, levels, marks, quality, rows, with};
use super::*;
use crate::detector::testing::{alone, plugin};
use crate::signal::uncertainty_change::{Form, changes};
use proptest::prelude::*;
use rand::RngExt;

fn built(text: &str) -> ArteStar {
    plugin(text)
}

/// Sums of two values; beta_1 is 1, beta_2 is 0.5.
const PLAIN: &str = "length = 2, beta = 1.0, locking_in_limit = 2";

/// Changes with known events: s is above 1 in frames 1 to 2, 5 to 7, 11 and 14 to 17. The track is lost in
/// frame 1, on a distractor in frame 3, recovered in frame 8; lost in 11 and recovered in 12; lost in 14;
/// waiting is over in 17.
const SCRIPT: [f64; 19] =
    [0.0, 1.2, 0.0, 0.0, 0.0, 1.2, 1.2, 0.0, 0.9, 0.0, 0.9, 0.9, 0.05, 0.0, 1.5, 0.0, 1.5, 0.0, 0.0];

#[test]
fn changes_go_through_the_rows_that_onsets_can_reach() {
    let reverse = Fake::new(|from, _| Some(if from == 3 { 0.8 } else { 0.5 }));
    let output = built(&format!("{{ {PLAIN} }}")).detect(&with(&SCRIPT, &reverse));
    assert_eq!(letters(&output), "osioossiooosoosiioo");
    assert_eq!(marks(&output.alarm), ".xxxxxxx...x..xxx..");
    assert_eq!(reverse.asked(), [(3, 0), (8, 0), (12, 10), (17, 13)]);
    let accepted: Vec<bool> = quality(&output).checks.iter().map(|c| c.accepted).collect();
    assert_eq!(accepted, [false, true, true, true]);
    // Rows 1 and 4 are increases of a tracker that is not locked on; see the head of the file.
    assert_eq!(rows(&output), [0, 3, 5, 0, 3, 5, 0, 2, 0, 3, 6]);
}

#[test]
fn checks_that_cannot_be_made_are_rejected() {
    let alarm = |text: &str, reverse: Option<&Fake>| {
        let reverse = reverse.map(|r| r as &dyn crate::detector::Reverse);
        marks(&built(text).detect(&Input { reverse, ..alone(&SCRIPT) }).alarm)
    };
    let good = Fake::always(Some(0.0));
    let text = format!("{{ {PLAIN} }}");
    assert!(built(&text).facts().needs_reverse);
    assert_eq!(alarm(&text, None), ".xxxxxxxxxxxxxxxxxx");
    assert_eq!(alarm(&text, Some(&Fake::always(None))), ".xxxxxxxxxxxxxxxxxx");
    assert_eq!(alarm(&text, Some(&good)), ".xx..xxx...x..xxx..");
    // The first loss is three frames long, the second three, the third two, the last four.
    let good = Fake::always(Some(0.0));
    assert_eq!(alarm(&format!("{{ {PLAIN}, reverse_limit = 3 }}"), Some(&good)), ".xx..xxxxxxxxxxxxxx");
    assert_eq!(good.asked(), [(3, 0)]);
}

#[test]
fn the_score_and_the_large_changes_are_those_of_avu() {
    let avu = super::super::accumulated_validation::ENTRY.build_from_text("{ length = 2, beta = 1.0 }");
    let good = Fake::always(Some(0.0));
    let theirs = avu.unwrap().detect(&with(&SCRIPT, &good));
    let detector = built(&format!("{{ {PLAIN} }}"));
    let (score, events) = detector.events(&with(&SCRIPT, &good));
    assert_eq!(score, theirs.score);
    assert_eq!(detector.facts().threshold, Some(1.0));
    for (t, change) in theirs.changes().iter().enumerate() {
        assert_eq!(events[t][..2], [*change == 1, *change == -1], "{t}");
    }
    // By hand: c falls below 0.5 in these frames.
    let small = |events: &[Events]| -> Vec<usize> { (0..events.len()).filter(|t| events[*t][2]).collect() };
    assert_eq!(small(&events), [2, 7, 9, 12, 15, 17]);
    // A value of beta_2 is no longer above it.
    assert_eq!(small(&detector.events(&with(&[0.6, 0.5, 0.4], &good)).1), [1]);
}

// Exponential c_t of mean 0.2, all consistent.
#[test]
fn it_learns_what_avu_learns() {
    let mut rng = crate::num::seed::rng(3);
    let signal: Vec<f64> = (0..600).map(|_| -rng.random_range(1e-9_f64..1.0).ln() * 0.2).collect();
    let examples = [Example::new(&signal, &[0.4; 600])];
    let avu = |length: usize| {
        let text = format!("{{ train = \"t\", length = {length}, alpha = 0.01, tau = 0.8 }}");
        super::super::accumulated_validation::ENTRY.build_from_text(&text).unwrap()
    };
    let theirs = avu(5);
    let theirs = theirs.learner().unwrap();
    let model = theirs.learn(&examples).unwrap();
    let cut = |length: usize| avu(length).learner().unwrap().with_model(&model).unwrap().facts().threshold;
    for (beta_2, second) in [("half", cut(5)), ("half-of-one", cut(1))] {
        let text = format!("{{ train = \"t\", length = 5, alpha = 0.01, tau = 0.8, beta_2 = \"{beta_2}\" }}");
        let detector = ENTRY.build_from_text(&text).unwrap();
        assert_eq!(detector.facts().threshold, None);
        let learner = detector.learner().unwrap();
        assert_eq!((learner.role(), learner.params()), ("t", theirs.params()));
        if beta_2 == "half" {
            assert_eq!(learner.learn(&examples).unwrap(), model);
        }
        let ready = learner.with_model(&model).unwrap();
        assert_eq!(ready.facts().threshold, cut(5));
        assert!(ready.facts().needs_reverse);
        assert!(learner.with_model(&serde_json::json!({ "beta": 1 })).is_err());
        // One large value, then one just above or below beta_2 while the sum is still too large.
        let half = second.unwrap() / 2.0;
        for (factor, want) in [(1.01, "oss"), (0.99, "osi")] {
            let series = [0.0, 9.0, half * factor];
            let output = ready.detect(&with(&series, &Fake::always(None)));
            assert_eq!(letters(&output), want, "{beta_2} {factor}");
        }
    }
    assert!(cut(1) < cut(5));
}

#[test]
fn it_is_silent_until_it_has_learned() {
    let output = built("{ train = \"t\" }").detect(&with(&SCRIPT, &Fake::always(Some(0.0))));
    assert_eq!(letters(&output), "o".repeat(19));
    assert!(!output.alarm.contains(&true));
    assert!(built("{ beta = 1.0 }").learner().is_none());
}

/// Changes that are small for some frames, then large.
fn series() -> impl Strategy<Value = Vec<f64>> {
    levels(prop_oneof![Just(0.05), Just(0.6), Just(3.0)], 0.1..1.0, 1..14)
}

proptest! {
    #[test]
    fn a_factor_of_the_uncertainty_changes_nothing(
        u in prop::collection::vec(0.1..10.0_f64, 1..120), power in -20..20_i32, length in 1..8_usize,
    ) {
        let detector = built(&format!("{{ length = {length}, beta = 6.0 }}"));
        let labels = |by: f64| {
            let scaled: Vec<f64> = u.iter().map(|u| u * by).collect();
            detector.detect(&with(&changes(&scaled, 25, Form::Absolute, 0.0), &Fake::mixed()))
        };
        prop_assert_eq!(labels(1.0), labels(2.0_f64.powi(power)));
    }

    #[test]
    fn alarms_begin_with_an_increase_and_end_with_an_accepted_check(
        c in series(), length in 1..8_usize, limit in 1..8_usize,
    ) {
        let detector =
            built(&format!("{{ length = {length}, beta = 1.0, locking_in_limit = {limit} }}"));
        let output = detector.detect(&with(&c, &Fake::mixed()));
        check_alarms(&output, 1.0);
        // Whoever is not locked on is inconsistent, so that nothing can become inconsistent.
        let mut frames = quality(&output).condition.iter().zip(&output.score);
        prop_assert!(frames.all(|(c, s)| *c == Condition::LockedOn || *s > 1.0));
        let used = rows(&output);
        prop_assert!(!used.contains(&1) && !used.contains(&4));
    }
}
