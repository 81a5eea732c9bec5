//! Properties that all detectors of the list and the example of the documentation must have.

use super::{DETECTORS, Detector, DetectorOutput, Input, Quality, deviation, lost};
use crate::direction::Direction;
use crate::plugin::{Configured, Entry};
use proptest::prelude::*;
use sha2::{Digest, Sha256};

/// Entries of the list, and the example of the documentation.
fn entries() -> impl Iterator<Item = &'static Entry<dyn Detector>> {
    DETECTORS.iter().chain([&deviation::ENTRY])
}

/// Kind, parameters and detector, for the example and the further parameters of each entry.
fn all_detectors() -> Vec<(&'static str, &'static str, Configured<dyn Detector>)> {
    let built = |entry: &'static Entry<dyn Detector>, text: &'static str| {
        let detector = entry.build_from_text(text).unwrap_or_else(|e| panic!("{} {text}: {e}", entry.kind));
        (entry.kind, text, detector)
    };
    let texts = |entry: &'static Entry<dyn Detector>| {
        std::iter::once(entry.example).chain(entry.more.iter().copied())
    };
    entries().flat_map(|entry| texts(entry).map(move |text| built(entry, text))).collect()
}

/// A smooth signal with steps and kinks, made of integers, and an error with two failures and a gap.
fn series() -> (Vec<f64>, Vec<f64>) {
    let signal = (0..120_i32)
        .map(|t| {
            let wave = f64::from((t * 37 % 64 - 32).abs()) / 4096.0;
            let level = if (40..70).contains(&t) { 0.028 } else { 0.045 };
            level + wave
        })
        .collect();
    let error = (0..120)
        .map(|t| match t {
            42..60 | 90..95 => 1.0,
            60..64 => f64::NAN,
            _ => 0.25,
        })
        .collect();
    (signal, error)
}

fn digest(output: &DetectorOutput) -> String {
    let mut hash = Sha256::new();
    let forecast = output.forecast.as_deref().unwrap_or_default();
    let alarm_score = output.alarm_score.as_deref().unwrap_or_default();
    for value in output.score.iter().chain(forecast).chain(alarm_score) {
        // NaN has many bit patterns, all of them the same answer.
        hash.update(if value.is_nan() { u64::MAX } else { value.to_bits() }.to_le_bytes());
    }
    hash.update(output.alarm.iter().map(|&a| u8::from(a)).collect::<Vec<_>>());
    hash.update(output.changes.iter().flatten().map(|&c| c as u8).collect::<Vec<_>>());
    if let Some(quality) = &output.quality {
        hash.update(quality.condition.iter().map(|&c| c as u8).collect::<Vec<_>>());
        for check in &quality.checks {
            hash.update([check.frame as u64, check.reference as u64].map(u64::to_le_bytes).concat());
            hash.update([u8::from(check.error.is_some()), u8::from(check.accepted)]);
        }
    }
    hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}

/// First `frames` frames of an output.
fn cut(output: &DetectorOutput, frames: usize) -> DetectorOutput {
    DetectorOutput {
        score: output.score[..frames].to_vec(),
        alarm_score: output.alarm_score.as_ref().map(|a| a[..frames].to_vec()),
        alarm: output.alarm[..frames].to_vec(),
        forecast: output.forecast.as_ref().map(|f| f[..frames].to_vec()),
        changes: output.changes.as_ref().map(|c| c[..frames].to_vec()),
        quality: output.quality.as_ref().map(|q| Quality {
            condition: q.condition[..frames].to_vec(),
            checks: q.checks.iter().filter(|c| c.frame < frames).copied().collect(),
            transitions: q.transitions.iter().filter(|t| t.0 < frames).copied().collect(),
        }),
        failure: output.failure.clone(),
    }
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
fn kinds_are_unique_and_described() {
    for (i, entry) in entries().enumerate() {
        assert!(entries().take(i).all(|other| other.kind != entry.kind), "{} twice", entry.kind);
        assert!(!entry.summary.is_empty() && entry.version >= 1);
        let schema = (entry.schema)();
        assert_eq!(schema.get("additionalProperties"), Some(&serde_json::json!(false)), "{}", entry.kind);
    }
}

#[test]
fn ranges_are_what_is_accepted() {
    crate::range_tests::check(DETECTORS);
    trackfail_testing::check_pins("range detector", crate::range_tests::pins(DETECTORS));
    crate::range_tests::check(&[deviation::ENTRY]);
}

#[test]
fn outputs_are_as_long_as_the_signal() {
    let (signal, error) = series();
    for (kind, text, detector) in all_detectors() {
        let label = format!("{kind} {text}");
        for frames in [0, 1, 2, 20, 21, 120] {
            let input = Input {
                signal: &signal[..frames],
                error: &error[..frames],
                seed: 3,
                reverse: None,
                more: &[],
            };
            check_shape(&label, &detector.detect(&input), frames);
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
            let input = Input { signal, error: &[f64::NAN; 60], seed: 3, reverse: None, more: &[] };
            check_shape(&format!("{kind} {text}"), &detector.detect(&input), 60);
        }
    }
}

#[test]
fn forecasts_of_a_constant_are_exact() {
    for (kind, text, detector) in all_detectors() {
        let output = detector.detect(&Input {
            signal: &[0.04; 60],
            error: &[0.0; 60],
            seed: 3,
            reverse: None,
            more: &[],
        });
        if output.forecast.is_some() {
            assert!(output.score.iter().all(|&z| z == 0.0), "{kind} {text}");
        }
    }
}

#[test]
fn the_same_input_gives_the_same_output() {
    let (signal, error) = series();
    let input = Input { signal: &signal, error: &error, seed: 3, reverse: None, more: &[] };
    for ((kind, text, one), (_, _, two)) in all_detectors().into_iter().zip(all_detectors()) {
        let first = digest(&one.detect(&input));
        assert_eq!(first, digest(&one.detect(&input)), "{kind} {text}: second call");
        assert_eq!(first, digest(&two.detect(&input)), "{kind} {text}: second instance");
    }
}

#[test]
fn anchors_do_not_read_the_signal() {
    let (signal, error) = series();
    let other = vec![-3.5; signal.len()];
    for (kind, text, detector) in all_detectors().into_iter().filter(|d| !d.2.needs_signal()) {
        let [a, b] = [&signal, &other].map(|signal| {
            detector.detect(&Input { signal, error: &error, seed: 3, reverse: None, more: &[] })
        });
        assert_eq!(digest(&a), digest(&b), "{kind} {text}");
        assert!(a.score.iter().zip(&a.alarm).all(|(&s, &a)| s == f64::from(u8::from(a))), "{kind} {text}");
        assert_eq!(detector.threshold(), None, "{kind} {text}");
    }
}

/// The mean score of alarm frames is on the bad side of the mean score of other frames.
#[test]
fn alarms_have_scores_on_the_bad_side() {
    let (signal, error) = series();
    let mut seen = 0;
    for (kind, text, detector) in all_detectors() {
        let more = vec![signal.as_slice(); detector.signals().saturating_sub(1)];
        let input = Input { signal: &signal, error: &error, seed: 3, reverse: None, more: &more };
        let output = detector.detect(&input);
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
        match detector.score_direction() {
            Direction::HigherIsBetter => assert!(alarms < others, "{kind} {text}: {alarms} {others}"),
            Direction::LowerIsBetter => assert!(alarms > others, "{kind} {text}: {alarms} {others}"),
            Direction::Neither => panic!("{kind} {text}: a score without direction"),
        }
        assert!(!detector.scores_signal() || output.score == signal, "{kind} {text}");
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn only_anchors_read_error_and_seed() {
    let (signal, error) = series();
    for (kind, text, detector) in all_detectors().into_iter().filter(|d| d.2.needs_signal()) {
        let a = detector.detect(&Input { signal: &signal, error: &error, seed: 3, reverse: None, more: &[] });
        let b = detector.detect(&Input { signal: &signal, error: &[], seed: 4, reverse: None, more: &[] });
        assert_eq!(digest(&a), digest(&b), "{kind} {text}");
        // A detector without a threshold must find its changes itself.
        assert!(detector.threshold().is_some() || a.changes.is_some(), "{kind} {text}");
    }
}

#[test]
fn unknown_parameters_are_refused() {
    for entry in entries() {
        let mut table: toml::Table = toml::from_str(&format!("v = {}", entry.example)).unwrap();
        let params = table["v"].as_table_mut().unwrap();
        params.insert("no_such_parameter".into(), toml::Value::Integer(1));
        let error = entry.build_from_text(&table["v"].to_string()).err();
        let error = error.unwrap_or_else(|| panic!("{} takes an unknown parameter", entry.kind));
        assert!(error.message.contains("no_such_parameter"), "{}: {error}", entry.kind);
        assert!(error.span.is_some(), "{}: no place in the text", entry.kind);
        assert!(entry.build_from_text("{ ").is_err() && entry.build_from_text("3").is_err());
    }
}

#[test]
fn checked_parameters_make_the_same_detector() {
    let (signal, error) = series();
    let input = Input { signal: &signal, error: &error, seed: 3, reverse: None, more: &[] };
    for (kind, text, detector) in all_detectors() {
        let params = detector.params();
        let table = toml::Value::try_from(&params).unwrap().to_string();
        let entry = entries().find(|e| e.kind == kind).unwrap();
        let again = entry.build_from_text(&table).unwrap_or_else(|e| panic!("{kind} {table}: {e}"));
        assert_eq!(params, again.params(), "{kind} {text}");
        assert_eq!(digest(&detector.detect(&input)), digest(&again.detect(&input)), "{kind} {text}");
    }
}

#[test]
fn outputs_are_pinned() {
    let (signal, error) = series();
    let pin = |entry: &Entry<dyn Detector>| {
        let detector = entry.build_from_text(entry.example).unwrap();
        let input = Input { signal: &signal, error: &error, seed: 2016, reverse: None, more: &[] };
        format!("{} {} {}", entry.kind, entry.version, digest(&detector.detect(&input)))
    };
    trackfail_testing::check_pins("output detector", DETECTORS.iter().map(pin));
}

#[test]
fn detectors_that_use_no_seed_give_the_same_labels_with_any() {
    let (signal, error) = series();
    for (kind, text, detector) in all_detectors() {
        let labels = [1, 2].map(|seed| {
            digest(&detector.detect(&Input {
                signal: &signal,
                error: &error,
                seed,
                reverse: None,
                more: &[],
            }))
        });
        assert_eq!(detector.uses_seed(), labels[0] != labels[1], "{kind} {text}: `uses_seed` is not true");
    }
}

#[test]
fn what_no_experiment_learns_can_judge_a_track_that_goes_on() {
    let able = [
        "arma-forecast",
        "naive-forecast",
        "level",
        "standard-score",
        "relative-drop",
        "joint-drop",
        "fused",
        "cusum",
        "page-hinkley",
        "sequential-test",
        "conformal-forecast",
    ];
    // Those of the AVU paper judge whole tracks, and anchors are of no use live. A new detector may be either.
    let unable = [
        "accumulated-validation",
        "two-model-chi-square",
        "matched-kalman-bank",
        "arte",
        "arte-star",
        "never",
        "always",
        "periodic",
        "random",
        "oracle",
        "deviation",
    ];
    for (kind, text, detector) in all_detectors() {
        assert!(!able.contains(&kind) || detector.stream().is_some(), "{kind} {text}");
        assert!(!unable.contains(&kind) || detector.stream().is_none(), "{kind} {text}");
    }
}

/// Alarms that last until the detector finds the track good again end the loss at once; other alarms need ten
/// frames.
#[test]
fn frames_to_recover_are_those_of_the_kind_of_alarm() {
    let lasting = [
        "fused",
        "cusum",
        "page-hinkley",
        "sequential-test",
        "accumulated-validation",
        "two-model-chi-square",
        "matched-kalman-bank",
        "arte",
        "arte-star",
        "never",
        "always",
        "oracle",
    ];
    let single = [
        "arma-forecast",
        "naive-forecast",
        "level",
        "standard-score",
        "relative-drop",
        "joint-drop",
        "conformal-forecast",
        "periodic",
        "random",
        "agreement",
        "deviation",
    ];
    for (kind, text, detector) in all_detectors() {
        assert!(lasting.contains(&kind) != single.contains(&kind), "{kind}");
        let is_restarted = text.contains("\"restart\"");
        let expected = if lasting.contains(&kind) && !is_restarted { 1 } else { 10 };
        assert_eq!(detector.frames_to_recover(), expected, "{kind} {text}");
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
        let frames = (at * signal.len() as f64) as usize;
        for (kind, text, detector) in all_detectors() {
            let whole = detector.detect(&Input { signal: &signal, error: &error, seed, reverse: None, more: &[] });
            let part = detector.detect(&Input { signal: &signal[..frames], error: &error[..frames], seed, reverse: None, more: &[] });
            prop_assert_eq!(digest(&cut(&whole, frames)), digest(&part), "{} {}", kind, text);
        }
    }

    #[test]
    fn a_stream_says_what_a_whole_track_does(
        rows in prop::collection::vec(prop::array::uniform3(-0.5_f64..1.0), 0..64),
        interrupted in 0_usize..64,
    ) {
        for (kind, text, detector) in all_detectors() {
            let Some(mut stream) = detector.stream() else { continue };
            let columns: Vec<Vec<f64>> =
                (0..detector.signals()).map(|k| rows.iter().map(|row| row[k % 3]).collect()).collect();
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            let (signal, more) = (columns[0], &columns[1..]);
            let alarm = detector.detect(&Input { signal, more, error: &[], seed: 0, reverse: None }).alarm;
            let want = lost(&alarm, detector.frames_to_recover());
            for t in 0..rows.len() {
                if t == interrupted {
                    stream = detector.resume(&stream.save()).unwrap();
                }
                if t % 7 == 3 && kind != "fused" {
                    // A frame without a value changes nothing.
                    let said = stream.push(&vec![f64::NAN; columns.len()]);
                    prop_assert_eq!((said.lost, said.raised), (want[t - 1], false), "{} {} {}", kind, text, t);
                }
                let said = stream.push(&columns.iter().map(|column| column[t]).collect::<Vec<_>>());
                prop_assert_eq!(said.lost, want[t], "{} {} {}", kind, text, t);
                prop_assert!(kind == "fused" || said.raised == alarm[t], "{} {} {}", kind, text, t);
                // Every alarm has one reason, but for one that is only held.
                let holds = kind == "fused";
                prop_assert!(holds || said.reasons.len() == usize::from(alarm[t]), "{} {} {}", kind, text, t);
            }
        }
    }

    #[test]
    fn alarms_are_monotone_in_the_threshold(
        signal in prop::collection::vec(0.0_f64..1.0, 0..64),
        one in 0.001_f64..1.0,
        two in 0.001_f64..1.0,
    ) {
        let (low, high) = (one.min(two), one.max(two));
        let cases = [
            ("arma-forecast", "threshold"),
            ("naive-forecast", "threshold"),
            ("level", "above"),
            ("level", "below"),
        ];
        for (kind, key) in cases {
            let entry = crate::plugin::find(DETECTORS, kind).unwrap();
            let [few, many] = if key == "below" { [low, high] } else { [high, low] }.map(|value| {
                let detector = entry.build_from_text(&format!("{{ {key} = {value:?} }}")).unwrap();
                detector.detect(&Input { signal: &signal, error: &[], seed: 0, reverse: None, more: &[] })
            });
            prop_assert_eq!(&few.score, &many.score);
            prop_assert!(few.alarm.iter().zip(&many.alarm).all(|(f, m)| *m || !*f), "{} {}", kind, key);
        }
    }
}
