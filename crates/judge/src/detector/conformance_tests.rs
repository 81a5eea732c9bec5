//! Properties that all detectors of the list and the example of the documentation must have.

use super::testing::{alone, built, detect};
use super::track_quality::testing::Fake;
use super::{DETECTORS, Detector, DetectorOutput, Input, StateOfTarget, deviation, lost};
use crate::direction::Direction;
use crate::judged::{JudgedMethod, Raising};
use crate::plugin::{Configured, Entry};
use crate::range_tests;
use proptest::prelude::*;
use sha2::{Digest, Sha256};

/// Entries of the list, and the example of the documentation.
fn entries() -> impl Iterator<Item = &'static Entry<dyn Detector>> {
    DETECTORS.iter().chain([&deviation::ENTRY])
}

/// Kind, parameters and detector, for the example and the further parameters of each entry.
fn all_detectors() -> Vec<(&'static str, &'static str, Configured<dyn Detector>)> {
    let all = |entry: &'static Entry<dyn Detector>| {
        let texts = std::iter::once(entry.example).chain(entry.more.iter().copied());
        texts.map(move |text| (entry.kind, text, built(entry, text)))
    };
    entries().flat_map(all).collect()
}

/// A smooth signal with steps and kinks, made of integers, and an error with two failures and a gap.
fn series() -> (Vec<f64>, Vec<f64>) {
    let level = |t: i32| if (40..70).contains(&t) { 0.028 } else { 0.045 };
    let signal = |t: i32| level(t) + f64::from((t * 37 % 64 - 32).abs()) / 4096.0;
    let error = |t: i32| match t {
        42..60 | 90..95 => 1.0,
        60..64 => f64::NAN,
        _ => 0.25,
    };
    ((0..120).map(signal).collect(), (0..120).map(error).collect())
}

/// The input of [`series`], with a seed.
fn input((signal, error): &(Vec<f64>, Vec<f64>), seed: u64) -> Input<'_> {
    Input { error, seed, ..alone(signal) }
}

fn digest(output: &DetectorOutput) -> String {
    digest_of_first(usize::MAX, output)
}

/// Digest of the first frames of an output.
fn digest_of_first(frames: usize, output: &DetectorOutput) -> String {
    let mut hash = Sha256::new();
    let forecast = output.forecast.as_deref().unwrap_or_default();
    let alarm_score = output.alarm_score.as_deref().unwrap_or_default();
    let lists = [&output.score[..], forecast, alarm_score];
    for value in lists.iter().flat_map(|list| list.iter().take(frames)) {
        // NaN has many bit patterns, all of them the same answer.
        hash.update(if value.is_nan() { u64::MAX } else { value.to_bits() }.to_le_bytes());
    }
    hash.update(output.alarm.iter().take(frames).map(|&a| u8::from(a)).collect::<Vec<_>>());
    hash.update(output.changes.iter().flatten().take(frames).map(|&c| c as u8).collect::<Vec<_>>());
    if let Some(quality) = &output.quality {
        hash.update(quality.condition.iter().take(frames).map(|&c| c as u8).collect::<Vec<_>>());
        for check in quality.checks.iter().filter(|check| check.frame < frames) {
            hash.update([check.frame as u64, check.reference as u64].map(u64::to_le_bytes).concat());
            hash.update([u8::from(check.error.is_some()), u8::from(check.accepted)]);
        }
    }
    hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}

/// Checks lengths, finite scores, and finite forecasts from the first one on.
fn check_shape(label: &str, output: &DetectorOutput, frames: usize) {
    assert_eq!(output.score.len(), frames, "{label}: length of score");
    assert_eq!(output.alarm.len(), frames, "{label}: length of alarm");
    assert!(output.score.iter().all(|v| v.is_finite()), "{label}: a score is not finite");
    if let Some(changes) = &output.changes {
        assert_eq!(changes.len(), frames, "{label}: length of changes");
        assert!(changes.iter().all(|c| (-1..=1).contains(c)), "{label}: a change is none of -1, 0, 1");
    }
    if let Some(quality) = &output.quality {
        assert_eq!(quality.condition.len(), frames, "{label}: length of condition");
        assert!(quality.checks.is_sorted_by_key(|c| c.frame), "{label}: order of checks");
        assert!(quality.checks.iter().all(|c| c.reference <= c.frame), "{label}: a check runs forwards");
    }
    if let Some(forecast) = &output.forecast {
        assert_eq!(forecast.len(), frames, "{label}: length of forecast");
        let begin = forecast.iter().position(|v| !v.is_nan()).unwrap_or(frames);
        assert!(forecast[begin..].iter().all(|v| v.is_finite()), "{label}: a forecast is not finite");
    }
}

#[test]
fn the_list_and_its_ranges_are_lawful() {
    [DETECTORS, &[deviation::ENTRY]].into_iter().for_each(range_tests::check);
    trackfail_testing::check_pins("range detector", range_tests::pins(DETECTORS));
    for entry in entries() {
        let schema = (entry.schema)();
        assert_eq!(schema.get("additionalProperties"), Some(&serde_json::json!(false)), "{}", entry.kind);
        let fault = entry.build_from_text("{ no_such_parameter = 1 }").err().unwrap();
        assert!(fault.span.is_some(), "{}: no place in the text", entry.kind);
        assert!(entry.build_from_text("{ ").is_err() && entry.build_from_text("3").is_err());
    }
}

#[test]
fn outputs_are_as_long_as_the_signal() {
    let (signal, error) = series();
    for (kind, text, detector) in all_detectors() {
        for frames in [0, 1, 2, 20, 21, 120] {
            let input = Input { error: &error[..frames], seed: 3, ..alone(&signal[..frames]) };
            check_shape(&format!("{kind} {text}"), &detector.detect(&input), frames);
        }
    }
}

#[test]
fn hard_signals_give_finite_scores() {
    let alternating: Vec<f64> = (0..60).map(|t| if t % 2 == 0 { 1.7e308 } else { -1.7e308 }).collect();
    let tiny: Vec<f64> = (0..60).map(|t| f64::from(t % 3) * 1e-310).collect();
    let spike: Vec<f64> = (0..60).map(|t| if t == 25 { 1e9 } else { 0.0 }).collect();
    let line: Vec<f64> = (0..60).map(f64::from).collect();
    let cases = [vec![0.0; 60], vec![0.04; 60], vec![-7e300; 60], alternating, tiny, spike, line];
    for (kind, text, detector) in all_detectors() {
        for signal in &cases {
            let output = detector.detect(&Input { error: &[f64::NAN; 60], seed: 3, ..alone(signal) });
            check_shape(&format!("{kind} {text}"), &output, 60);
            // Forecasts of a constant are exact.
            let is_exact = *signal != [0.04; 60] || output.score.iter().all(|z| *z == 0.0);
            assert!(output.forecast.is_none() || is_exact, "{kind} {text}");
        }
    }
}

#[test]
fn the_same_input_gives_the_same_output() {
    let series = series();
    let input = input(&series, 3);
    for (kind, text, detector) in all_detectors() {
        let first = digest(&detector.detect(&input));
        assert_eq!(first, digest(&detector.detect(&input)), "{kind} {text}: second call");
        // A second instance, with the parameters that the first has checked.
        let params = detector.params();
        let again = built(
            entries().find(|e| e.kind == kind).unwrap(),
            &toml::Value::try_from(&params).unwrap().to_string(),
        );
        assert_eq!(params, again.params(), "{kind} {text}");
        assert_eq!(first, digest(&again.detect(&input)), "{kind} {text}: second instance");
    }
}

#[test]
fn detectors_read_what_they_say() {
    let series = series();
    let usual = input(&series, 1);
    for (kind, text, detector) in all_detectors() {
        let (output, facts) = (detector.detect(&usual), detector.facts());
        let is_same = |other: Input<'_>| digest(&detector.detect(&other)) == digest(&output);
        let uses_seed = !is_same(Input { seed: 2, ..usual });
        assert_eq!(facts.uses_seed, uses_seed, "{kind} {text}: `uses_seed` is not true");
        if facts.needs_signal {
            assert!(!uses_seed && is_same(Input { error: &[], ..usual }), "{kind} {text}: not an anchor");
            // A detector without a threshold must find its changes itself.
            assert!(facts.threshold.is_some() || output.changes.is_some(), "{kind} {text}");
        } else {
            assert!(is_same(Input { signal: &[-3.5; 120], ..usual }), "{kind} {text}: an anchor");
            let is_alarm = |(score, alarm): (&f64, &bool)| *score == f64::from(u8::from(*alarm));
            assert!(output.score.iter().zip(&output.alarm).all(is_alarm), "{kind} {text}");
            assert_eq!(facts.threshold, None, "{kind} {text}");
        }
    }
}

/// The mean score of alarm frames is on the bad side of the mean score of other frames.
#[test]
fn alarms_have_scores_on_the_bad_side() {
    let series = series();
    let mut seen = 0;
    for (kind, text, detector) in all_detectors() {
        let facts = detector.facts();
        let more = vec![series.0.as_slice(); facts.signals.saturating_sub(1)];
        let output = detector.detect(&Input { more: &more, ..input(&series, 3) });
        let mean = |alarm: bool| {
            let mine = output.score.iter().zip(&output.alarm).filter(|(_, a)| **a == alarm).map(|(s, _)| *s);
            let (sum, n) = mine.fold((0.0, 0.0), |(sum, n), s| (sum + s, n + 1.0));
            sum / n
        };
        let (alarms, others) = (mean(true), mean(false));
        if alarms.is_nan() || others.is_nan() {
            continue;
        }
        seen += 1;
        match facts.direction {
            Direction::HigherIsBetter => assert!(alarms < others, "{kind} {text}: {alarms} {others}"),
            Direction::LowerIsBetter => assert!(alarms > others, "{kind} {text}: {alarms} {others}"),
            Direction::Neither => panic!("{kind} {text}: a score without direction"),
        }
        assert!(!facts.scores_signal || output.score == series.0, "{kind} {text}");
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn outputs_are_pinned() {
    let series = series();
    let pin = |entry: &Entry<dyn Detector>| {
        let output = built(entry, entry.example).detect(&input(&series, 2016));
        format!("{} {} {}", entry.kind, entry.version, digest(&output))
    };
    trackfail_testing::check_pins("output detector", DETECTORS.iter().map(pin));
}

/// Inputs that each detector asks for, all its parameters, and the meaning of its scores.
#[test]
fn traits_are_pinned() {
    let pin = |(kind, text, detector): (&str, &str, Configured<dyn Detector>)| {
        let facts = detector.facts();
        let flags = [
            ("signal", facts.needs_signal),
            ("seed", facts.uses_seed),
            ("reverse", facts.needs_reverse),
            ("learner", detector.learner().is_some()),
            ("pooled", detector.learner().is_some_and(|learner| learner.pools_trackers())),
            ("own-score", !facts.scores_signal),
            ("probability", facts.gives_probability),
        ];
        let flags: Vec<&str> =
            flags.into_iter().filter(|(_, is_set)| *is_set).map(|(name, _)| name).collect();
        // At nine digits.
        let threshold = facts.threshold.map_or("none".into(), |threshold| format!("{threshold:.8e}"));
        let (signals, params) = (facts.signals, detector.params());
        format!("{kind} {text} signals {signals}, threshold {threshold}: {} {params}", flags.join(" "))
    };
    trackfail_testing::check_pins("traits detector", all_detectors().into_iter().map(pin));
}

/// Detectors of the AVU paper judge whole tracks, and anchors are of no use live. Alarms that last until the detector
/// finds the track good again end the loss at once; other alarms need ten frames.
#[test]
fn frames_to_recover_and_streams_are_those_of_the_kind() {
    let [live, lasting] = [true; 2];
    let kinds = [
        ("fused cusum page-hinkley sequential-test", live, lasting),
        ("arma-forecast naive-forecast conformal-forecast agreement", live, !lasting),
        ("level standard-score relative-drop joint-drop", live, !lasting),
        ("accumulated-validation two-model-chi-square matched-kalman-bank arte arte-star", !live, lasting),
        ("never always oracle", !live, lasting),
        ("periodic random deviation", !live, !lasting),
    ];
    for (kind, text, detector) in all_detectors() {
        let expected = kinds.iter().find(|row| row.0.split(' ').any(|word| word == kind));
        let (_, is_live, is_lasting) = expected.unwrap_or_else(|| panic!("{kind}"));
        assert_eq!(detector.stream().is_some(), *is_live, "{kind} {text}");
        let is_restarted = text.contains("\"restart\"");
        let frames = if *is_lasting && !is_restarted { 1 } else { 10 };
        assert_eq!(detector.facts().frames_to_recover, frames, "{kind} {text}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn no_label_uses_a_later_frame(
        pairs in prop::collection::vec((-0.5_f64..1.0, 0.0_f64..1.5), 0..64),
        at in 0.0_f64..1.0,
        seed in any::<u64>(),
    ) {
        let signal: Vec<f64> = pairs.iter().map(|p| p.0).collect();
        let error: Vec<f64> = pairs.iter().map(|p| p.1.min(1.0)).collect();
        let (frames, fake) = ((at * signal.len() as f64) as usize, Fake::mixed());
        for (kind, text, detector) in all_detectors() {
            let input = Input { error: &error, seed, reverse: Some(&fake), ..alone(&signal) };
            let whole = detector.detect(&input);
            let part = detector.detect(&Input { signal: &signal[..frames], error: &error[..frames], ..input });
            prop_assert_eq!(digest_of_first(frames, &whole), digest(&part), "{} {}", kind, text);
        }
    }

    #[test]
    fn a_stream_says_what_a_whole_track_does(
        rows in prop::collection::vec(prop::array::uniform3(-0.5_f64..1.0), 0..64),
        interrupted in 0_usize..64,
    ) {
        for (kind, text, detector) in all_detectors() {
            let Some(mut stream) = detector.stream() else { continue };
            let facts = detector.facts();
            // The fused detector judges frames in which values are missing.
            let value = |value: f64| if kind == "fused" && value < -0.4 { f64::NAN } else { value };
            let columns: Vec<Vec<f64>> =
                (0..facts.signals).map(|k| rows.iter().map(|row| value(row[k % 3])).collect()).collect();
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            let output = detector.detect(&Input { more: &columns[1..], ..alone(columns[0]) });
            let (compared, DetectorOutput { score, alarm, .. }) = (output.compared(), &output);
            let is_beyond = |score: f64| match (facts.threshold, facts.direction) {
                (Some(level), Direction::HigherIsBetter) => score <= level,
                (level, _) => level.is_none_or(|level| score >= level),
            };
            let want = lost(alarm, facts.frames_to_recover);
            let present: Vec<bool> = rows.iter().map(|row| row[1] > 0.0).collect();
            let judged = JudgedMethod::new("M", &*detector, &output, 0, &present);
            let (mut raising, mut target) = (Raising::default(), StateOfTarget::default());
            for t in 0..rows.len() {
                if t == interrupted {
                    let saved = stream.save();
                    stream = detector.stream().unwrap();
                    prop_assert!(stream.restore(&saved), "{} {} {}", kind, text, t);
                }
                if t % 7 == 3 && kind != "fused" {
                    // A frame without a value changes nothing.
                    let said = stream.push(&vec![f64::NAN; columns.len()]);
                    prop_assert_eq!((said.lost, said.alarm), (want[t - 1], false), "{} {} {}", kind, text, t);
                    prop_assert!(said.compared.is_nan(), "{} {} {}", kind, text, t);
                }
                let said = stream.push(&columns.iter().map(|column| column[t]).collect::<Vec<_>>());
                prop_assert_eq!(said.lost, want[t], "{} {} {}", kind, text, t);
                prop_assert_eq!((said.alarm, said.compared), (alarm[t], compared[t]), "{} {} {}", kind, text, t);
                let has_box = rows[t][1] > 0.0;
                let raised = raising.push(&detector.facts(), has_box, said.alarm, said.compared);
                let state = target.push(has_box, said.lost, raised, said.probability);
                prop_assert_eq!(state, judged.states[t], "{} {} {}", kind, text, t);
                // Every alarm has one reason, and a score that it is true of, but for one that is only held.
                let holds = kind == "fused";
                prop_assert!(holds || said.reasons.len() == usize::from(alarm[t]), "{} {} {}", kind, text, t);
                prop_assert!(holds || !alarm[t] || is_beyond(score[t]), "{} {} {}", kind, text, t);
            }
        }
    }

    #[test]
    fn a_stricter_threshold_alarms_no_more(
        signal in prop::collection::vec(0.0_f64..1.0, 0..64),
        one in 0.001_f64..0.5,
        two in 0.001_f64..0.5,
    ) {
        let (low, high) = (one.min(two), one.max(two));
        for (kind, key, [strict, loose]) in [
            ("arma-forecast", "threshold", [high, low]),
            ("naive-forecast", "threshold", [high, low]),
            ("level", "above", [high, low]),
            ("level", "below", [low, high]),
            ("two-model-chi-square", "alpha", [low, high]),
            ("sequential-test", "below = 0.7, alpha", [low, high]),
        ] {
            let entry = crate::plugin::find(DETECTORS, kind).unwrap();
            let [few, many] =
                [strict, loose].map(|value| detect(entry, &format!("{{ {key} = {value:?} }}"), &signal).alarm);
            prop_assert!(few.iter().zip(&many).all(|(few, many)| *many || !*few), "{} {}", kind, key);
        }
    }
}
