use super::features::{FEATURES, InputHistory};
use super::logistic::{self, Rows};
use super::model::{News, Weight};
use super::*;
use crate::detector::testing::{self, alone};
use proptest::prelude::*;
use trackfail_testing::{assert_near, assert_says};

fn input(name: &str) -> &'static FusedInput {
    inputs::find(name).unwrap()
}

fn feature(values: &[f64; FEATURES.len()], name: &str) -> f64 {
    values[FEATURES.iter().position(|f| *f == name).unwrap()]
}

/// Features after the last of these values.
fn last(name: &str, values: &[f64]) -> [f64; FEATURES.len()] {
    let mut history = InputHistory::default();
    values.iter().map(|v| history.push(input(name), *v)).last().unwrap()
}

fn learnt(examples: &[Example<'_>], params: &str) -> Arc<dyn Detector> {
    let fused = testing::built(&ENTRY, params);
    let learner = fused.learner().unwrap();
    learner.with_model(&learner.learn(examples).unwrap()).unwrap()
}

/// The model that is learnt with [`PARAMS`].
fn model(examples: &[Example<'_>]) -> Result<FusedModel, LearnError> {
    let learnt = testing::built(&ENTRY, PARAMS).learner().unwrap().learn(examples)?;
    Ok(FusedModel::deserialize(learnt).unwrap())
}

// By hand: the past of the last value is 1, 2, 3, 4, its median 2.5 and its median deviation 1.
#[test]
fn features_by_hand() {
    let features = last("companions", &[1.0, 2.0, 3.0, 4.0, 0.0]);
    let expected = [
        ("now", 0.0),
        ("worst5", 0.0),
        ("mean5", 2.0),
        ("worst20", 0.0),
        ("mean20", 2.0),
        // Line through 1, 2, 3, 4, 0: slope 0.
        ("slope20", 0.0),
        ("change", -2.0),
        ("z", -2.5 / (1.4826 + 0.02)),
        ("missing", 0.0),
    ];
    for (name, value) in expected {
        assert!((feature(&features, name) - value).abs() < 1e-12, "{name}: {features:?}");
    }
    let mut history = InputHistory::default();
    [1.0, 3.0, 2.0].iter().for_each(|v| history.pass(input("displacement"), *v));
    assert!((history.usual(input("displacement")).unwrap() - 2.0).abs() < 1e-12);
}

#[test]
fn a_missing_value_is_said_and_changes_no_memory() {
    let (with, without) = ([0.4, f64::NAN, f64::NAN, 0.2], [0.4, 0.2]);
    assert_eq!(last("companions", &with), last("companions", &without));
    let missing = last("companions", &with[..2]);
    assert_eq!(feature(&missing, "missing"), 1.0);
    assert!(feature(&missing, "now").is_nan() && (feature(&missing, "mean20") - 0.4).abs() < 1e-12);
}

// numpy: slope of np.polyfit(range(20), y, 1) times 20; y = (0, 1, 4, ..., 361) has slope 19.
#[test]
fn the_slope_is_that_of_least_squares() {
    let squares: Vec<f64> = (0..20).map(|k| f64::from(k * k)).collect();
    assert!((feature(&last("companions", &squares), "slope20") - 380.0).abs() < 1e-9);
}

// from sklearn.linear_model import LogisticRegression; numpy as np
// X = [[0, 1], [1, 0], [2, 1], [3, 3], [4, 0], [5, 2]]; y = [0, 0, 1, 0, 1, 1]
// m = LogisticRegression(C=2.0, tol=1e-12, max_iter=10000).fit(X, y, sample_weight=[1, 2, 1, 1, 1, 0.5])
#[test]
fn the_logistic_model_is_that_of_scikit_learn() {
    let rows = Rows {
        columns: 2,
        values: [0, 1, 1, 0, 2, 1, 3, 3, 4, 0, 5, 2].map(f64::from).to_vec(),
        lost: [0, 0, 1, 0, 1, 1].map(|l| l == 1).to_vec(),
        weight: vec![1.0, 2.0, 1.0, 1.0, 1.0, 0.5],
    };
    let (weights, bias) = logistic::fit(&rows, 0.5).unwrap();
    let expected = [1.137092314, -0.564906493, -2.403038975];
    assert_near([&weights[..], &[bias]].concat(), expected, 1e-6, "");
    // As above with C=100, X = [[2], [-3], [2], [-1], [3], [1], [2]], y = [0, 0, 0, 0, 1, 0, 0] and these weights. A whole
    // step of Newton's leads away from the minimum.
    let steep = Rows {
        columns: 1,
        values: vec![2.0, -3.0, 2.0, -1.0, 3.0, 1.0, 2.0],
        lost: vec![false, false, false, false, true, false, false],
        weight: vec![100.0, 20.0, 0.1, 1.0, 1.0, 0.1, 1.0],
    };
    let (weights, bias) = logistic::fit(&steep, 0.01).unwrap();
    assert_near([weights[0], bias], [9.27381845, -25.54080447], 1e-6, "");
    let one_kind = Rows { lost: vec![true; 6], ..rows };
    assert!(logistic::fit(&one_kind, 0.5).is_none());
}

/// Tracks of five videos. When the target is lost, the colors fall, by an amount that differs between tracks,
/// with noise.
fn tracks() -> Vec<(Vec<f64>, Vec<f64>, String)> {
    use rand::RngExt;
    let mut rng = crate::num::seed::rng(7);
    (0..20)
        .map(|k| {
            let (level, loss) = (0.6 + 0.02 * f64::from(k), 60 + 7 * k as usize);
            let error: Vec<f64> =
                (0..300).map(|t| if t >= loss && t < loss + 60 { 1.0 } else { 0.2 }).collect();
            let signal = error
                .iter()
                .map(|e| level - 0.3 * f64::from(u8::from(*e >= 1.0)) + rng.random_range(-0.1..0.1));
            (signal.collect(), error.clone(), format!("video{}", k % 5))
        })
        .collect()
}

const PARAMS: &str = "{ inputs = [\"companions\"], train = \"train\", budget = 2.0, stride = 3 }";

fn examples(tracks: &[(Vec<f64>, Vec<f64>, String)]) -> Vec<Example<'_>> {
    tracks.iter().map(|(s, e, video)| Example { video: video.clone(), ..Example::new(s, e) }).collect()
}

#[test]
fn it_learns_to_find_losses_within_its_budget() {
    let (all, unseen) = (tracks(), tracks().split_off(17));
    let detector = learnt(&examples(&all[..17]), PARAMS);
    for (signal, error, _) in &unseen {
        let output = detector.detect(&alone(signal));
        let loss = error.iter().position(|e| *e >= 1.0).unwrap();
        assert!(output.alarm[..loss].iter().all(|alarm| !alarm), "a false alarm");
        assert!(output.alarm[loss..loss + 15].contains(&true), "the loss is not found");
        assert!(!output.alarm[299], "the recovery is not found");
        assert!(output.score.iter().all(|p| (0.0..=1.0).contains(p)));
    }
}

// By hand: the watchdogs part in frames 1 and 2, and both have been away for more than two frames from frame 4 on.
#[test]
fn a_disagreement_is_news_while_each_watchdog_has_touched_lately() {
    let inputs = [input("v2-overlap"), input("scale"), input("v3-overlap")];
    let overlaps = [(0.5, 0.4), (0.0, 0.3), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (f64::NAN, 0.2), (0.1, 0.0)];
    let mut news = News::default();
    let factor = |(v2, v3): (f64, f64)| news.push(&inputs, &[v2, 0.0, v3], 2);
    assert_eq!(overlaps.map(factor), [1.0, 1.0, 1.0, 0.001, 0.001, 0.001, 1.0]);
    assert_eq!(News::default().push(&inputs[1..2], &[9.0], 0), 1.0);
}

// What holds on each source holds on all together, so that no threshold is below that of one source of all.
#[test]
fn a_budget_holds_on_the_worst_source() {
    let all = tracks();
    let noisy = |k: usize| if k.is_multiple_of(3) { "noisy" } else { "quiet" };
    let lower = |k: usize, t: usize| if noisy(k) == "noisy" && t.is_multiple_of(9) { 0.3 } else { 0.0 };
    let signal =
        |k: usize| -> Vec<f64> { all[k].0.iter().enumerate().map(|(t, v)| v - lower(k, t)).collect() };
    let signals: Vec<Vec<f64>> = (0..all.len()).map(signal).collect();
    let learnt = |source: &dyn Fn(usize) -> &'static str| {
        let of = |k: usize| {
            let (video, source) = (all[k].2.clone(), source(k).to_string());
            Example { video, source, ..Example::new(&signals[k], &all[k].1) }
        };
        model(&(0..all.len()).map(of).collect::<Vec<_>>()).unwrap()
    };
    let (apart, together) = (learnt(&noisy), learnt(&|_| "one"));
    assert_eq!(apart.features, together.features);
    let pairs = || apart.thresholds.iter().zip(&together.thresholds);
    assert!(pairs().all(|(a, b)| a.1 >= b.1) && pairs().any(|(a, b)| a.1 > b.1), "{apart:?} {together:?}");
}

// Of four videos each is judged by a model of the others. Of five the last one is left out together with the first, and
// then no loss is left.
#[test]
fn videos_are_dealt_out_to_four_folds() {
    let all = tracks();
    let quiet = vec![0.2; 300];
    let learn = |videos: usize| {
        let of = |k: usize| {
            let error = if k == 0 || k + 1 == videos { &all[k].1 } else { &quiet };
            Example { video: format!("video{k}"), ..Example::new(&all[k].0, error) }
        };
        model(&(0..videos).map(of).collect::<Vec<_>>())
    };
    assert!(learn(4).is_ok());
    assert!(matches!(learn(5), Err(LearnError::OneKind)));
}

// What is a loss in one of two videos is none in the other: a model of either is wrong on the one that it has not seen.
#[test]
fn the_calibration_is_of_videos_that_were_not_seen() {
    let all = tracks();
    let turned: Vec<f64> = all[1].0.iter().map(|v| 1.3 - v).collect();
    let of = |video: &str, signal, error| Example { video: video.into(), ..Example::new(signal, error) };
    let model = model(&[of("a", &all[0].0, &all[0].1), of("b", &turned, &all[1].1)]).unwrap();
    assert_eq!(model.calibration.0, 1e-3);
}

// By hand: a value counts three times, as the last, the worst and the mean of one.
#[test]
fn the_three_loudest_inputs_are_the_reasons() {
    let names = ["v2-apart", "v2-distance", "here-distance", "here-outside"];
    let mut stream = stream_of(&names, &[1.0; 12], 0.5);
    let reasons = stream.push(&[1.0, 4.0, 2.0, 3.0]).reasons;
    assert_eq!(stream_of(&names, &[1.0; 12], 0.5).step(&[1.0, 4.0, 2.0, 3.0]).1, [3.0, 12.0, 6.0, 9.0]);
    assert_eq!(reasons.len(), 3);
    for (reason, name) in reasons.iter().zip(["v2-distance", "here-outside", "here-distance"]) {
        assert!(reason.starts_with(input(name).words), "{reason:?}");
    }
}

/// Stream of a model with a weight for each feature of these inputs, a slope of its calibration, and a threshold of .5.
fn stream_of(names: &[&str], weights: &[f64], slope: f64) -> FusedStream {
    let feature = |weight: &f64| Weight { center: 0.0, scale: 1.0, weight: *weight };
    let model = FusedModel {
        inputs: names.iter().map(|name| String::from(*name)).collect(),
        features: weights.iter().map(feature).collect(),
        bias: 0.0,
        calibration: (slope, 0.0),
        thresholds: vec![(1.0, 0.5)],
    };
    let params =
        format!("{{ inputs = {names:?}, train = \"train\", budget = 1.0, confirm = 1, window = 0 }}");
    FusedStream::new(testing::plugin(&params), Arc::new(model))
}

// By hand: a score of 0 is a probability of .5, which reaches the threshold and needs no reason. An alarm lasts at .5 when
// it is old news, and is not raised by it.
#[test]
fn a_probability_at_the_threshold_is_an_alarm() {
    let mut stream = stream_of(&["v2-overlap"], &[0.0; 3], 1.0);
    let judged = [0.5, 0.0, 0.0].map(|overlap| stream.push(&[overlap]));
    let states: Vec<_> =
        judged.iter().map(|j| (j.compared >= 0.5, j.lost, j.probability, j.reasons.len())).collect();
    assert_eq!(states, [(true, true, 0.5, 0), (false, true, 0.5, 0), (false, true, 0.5, 0)]);
}

#[test]
fn reasons_name_the_value_and_what_is_usual() {
    let weights = FEATURES.map(|name| f64::from(["now", "missing"].contains(&name)));
    let mut stream = stream_of(&["companions"], &weights, 1.0);
    let words = input("companions").words;
    for (value, text) in [
        (1.0, ": 1.000"),
        (1.0, ""),
        (2.0, ": 2.000, usually 1.000"),
        (f64::NAN, ": missing"),
        (2.0, ": 2.000, usually 1.000"),
    ] {
        let expected = if text.is_empty() { vec![] } else { vec![format!("{words}{text}")] };
        assert_eq!(stream.push(&[value]).reasons, expected, "{value}");
    }
}

#[test]
fn the_order_of_the_tracks_of_a_video_changes_rounding_only_and_the_same_tracks_give_the_same_bytes() {
    let all = tracks();
    let bytes = || serde_json::to_string(&model(&examples(&all)).unwrap()).unwrap();
    assert_eq!(bytes(), bytes());
    let turned: Vec<_> = all.iter().cloned().rev().collect();
    let [one, other] = [&all, &turned].map(|tracks| model(&examples(tracks)).unwrap().bias);
    assert!((one - other).abs() < 1e-6);
}

#[test]
fn parameters_are_checked() {
    for (text, words) in [
        ("{ inputs = [\"companion\"], train = \"x\" }", "did you mean `companions`?"),
        ("{ inputs = [\"scale\"] }", "either `model`"),
        ("{ inputs = [], train = \"x\" }", "inputs"),
        ("{ inputs = [\"scale\"], train = \"x\", budget = 0.0 }", "budget"),
        ("{ inputs = [\"scale\"], model = \"none\" }", "model"),
    ] {
        assert_says(ENTRY.build_from_text(text).err().unwrap(), words);
    }
}

// The sum of finite weights may be infinite, and the probability not a number.
#[test]
fn a_model_without_bounds_is_refused() {
    let detector = testing::built(&ENTRY, PARAMS);
    let model = model(&examples(&tracks())).unwrap();
    let takes = |weight: f64, bias: f64, calibration: (f64, f64)| {
        let mut model = FusedModel { bias, calibration, ..model.clone() };
        model.features.iter_mut().for_each(|feature| feature.weight = weight);
        detector.learner().unwrap().with_model(&serde_json::to_value(model).unwrap()).is_ok()
    };
    // Nine features of a deviation of 6 at most.
    for (weight, bias, calibration, is_taken) in [
        (1e300, 0.0, (1.0, 0.0), true),
        (1e200, 1e200, (1.0, 1e200), true),
        (1e307, 0.0, (1.0, 0.0), false),
        (1e300, 0.0, (1e10, 0.0), false),
        (1e306, -1.7e308, (1.0, 0.0), false),
        (1e306, 0.0, (1.0, -1.7e308), false),
    ] {
        assert_eq!(takes(weight, bias, calibration), is_taken, "{weight} {bias} {calibration:?}");
    }
    assert!(detector.learner().unwrap().pools_trackers());
    type Damage = fn(&mut FusedModel);
    let damages: [Damage; 3] =
        [|m| m.thresholds.clear(), |m| m.features.truncate(8), |m| m.inputs[0] = "share".into()];
    for damage in damages {
        let mut model = model.clone();
        damage(&mut model);
        let refused = detector.learner().unwrap().with_model(&serde_json::to_value(model).unwrap());
        assert!(matches!(refused, Err(LearnError::OtherModel)));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn the_deviation_is_the_median_of_all_distances(values in prop::collection::vec(-5.0..5.0_f64, 1..130)) {
        let mut history = InputHistory::default();
        let features: Vec<_> = values.iter().map(|v| history.push(input("share"), *v)).collect();
        let Some((x, past)) = values.split_last() else { return Ok(()) };
        let mut past = past[past.len().saturating_sub(100)..].to_vec();
        if let Some(middle) = crate::num::summary::median(&mut past) {
            let mut away: Vec<f64> = past.iter().map(|v| (v - middle).abs()).collect();
            let spread = crate::num::summary::median(&mut away).unwrap();
            let z = ((x - middle) / (1.4826 * spread + 0.02)).clamp(-10.0, 10.0);
            prop_assert!((feature(features.last().unwrap(), "z") - z).abs() < 1e-9);
        }
    }
}

// A list of ascending values that was not that of the past would end in a panic as soon as the oldest is removed.
#[test]
fn a_forged_state_is_refused_or_judged_but_never_panics() {
    let all = tracks();
    let detector = learnt(&examples(&all), PARAMS);
    let quiet: Option<usize> = None;
    let resumed = |early: (f64, usize), past: Vec<f64>| {
        let saved = crate::saved::to_bytes(&(vec![(early, past)], Vec::<u32>::new(), quiet)).unwrap();
        let mut stream = detector.stream().unwrap();
        stream.restore(&saved).then_some(stream)
    };
    let mut stream = resumed((2.5, 5), vec![0.5; 5]).unwrap();
    assert!((0..200).all(|_| stream.push(&[0.5]).probability.is_finite()));
    let with_empty_list = (vec![((2.5, 5_usize), vec![0.5; 5], Vec::<f64>::new())], Vec::<u32>::new(), quiet);
    assert!(!detector.stream().unwrap().restore(&crate::saved::to_bytes(&with_empty_list).unwrap()));
    assert!(resumed((2.5, 5), vec![0.5; 100]).is_some());
    assert!(resumed((2.5, 5), vec![0.5; 101]).is_none());
    assert!(resumed((2.5, 5), vec![0.5, f64::NAN]).is_none());
    assert!(resumed((f64::INFINITY, 5), vec![0.5; 5]).is_none());
    assert!(resumed((2.5, 21), vec![0.5; 5]).is_none());
}

#[test]
fn every_input_has_a_name_of_its_own() {
    let names: std::collections::BTreeSet<_> = INPUTS.iter().map(|i| i.name).collect();
    assert_eq!(names.len(), INPUTS.len());
    assert!(INPUTS.iter().any(|i| i.good == Direction::LowerIsBetter));
}

#[test]
fn models_belong_to_the_version() {
    use sha2::{Digest, Sha256};
    let pin = |(name, text): &(&str, &str)| {
        let digest: String = Sha256::digest(text).iter().take(8).map(|byte| format!("{byte:02x}")).collect();
        format!("{name} {digest}")
    };
    let found: Vec<String> = MODELS.iter().map(pin).collect();
    let expected = "boxes ec5833468a06f4f7, deep ac263079af980dd3, deep-full 86eb8222d5a8b3f2, \
                    deep-v3 8fef5c2044f91858, deep-and-companions c49af5d79650c2b1, companions 23e9309fbb062b7e";
    assert_eq!(
        (ENTRY.version, found.join(", ").as_str()),
        (4, expected),
        "with another model, raise the version"
    );
    assert!(learned_from("boxes").unwrap().contains(&"Basketball".into()) && learned_from("none").is_none());
}

// A missing input is no zero: a similarity of 0 speaks for a loss, one that is missing does not.
#[test]
fn a_missing_input_is_not_the_worst_one() {
    let inputs = ["displacement", "acceleration", "scale", "aspect", "companions", "share"];
    let names = inputs.map(|name| format!("\"{name}\"")).join(", ");
    let detector = testing::built(&ENTRY, &format!("{{ inputs = [{names}], model = \"companions\" }}"));
    let after = |last: f64| {
        let mut stream = detector.stream().unwrap();
        (0..50).for_each(|_| drop(stream.push(&[0.01, 0.01, 0.01, 0.01, 0.8, 1.0])));
        (0..5).map(|_| stream.push(&[0.01, 0.01, 0.01, 0.01, last, last])).last().unwrap()
    };
    let (worst, missing) = (after(0.0), after(f64::NAN));
    assert!(worst.lost && worst.probability > 0.8, "{worst:?}");
    assert!(!missing.lost && missing.probability < 0.5, "{missing:?}");
    assert!(worst.reasons[0].contains("other trackers"), "{worst:?}");
}

/// Values of `Fused deep` in a frame: on target, or with both watchdog and second look confident of another
/// place.
fn deep_values(lost: bool) -> [f64; 14] {
    match lost {
        false => [0.8, 0.99, 0.2, 0.0, 0.1, 0.99, 0.8, 0.2, 0.0, 0.1, 0.99, 9.0, -6.0, -8.0],
        true => [0.0, 0.99, 0.99, 0.99, 3.0, 0.2, 0.0, 0.2, 0.2, 1.5, 0.05, -3.0, 1.0, 4.0],
    }
}

// An alarm of what the network sees begins while that is news, and the state stays for as long as it is so.
#[test]
fn a_disagreement_raises_an_alarm_while_it_is_news_and_stays_probable() {
    let named = crate::method::Method::named("Fused deep", None).unwrap();
    let detector = named.detector.detector;
    let values: Vec<[f64; 14]> = (0..120).map(|t| deep_values(t >= 50)).collect();
    let columns: Vec<Vec<f64>> = (0..14).map(|k| values.iter().map(|v| v[k]).collect()).collect();
    let more: Vec<&[f64]> = columns[1..].iter().map(Vec::as_slice).collect();
    let output = detector.detect(&Input { more: &more, ..alone(&columns[0]) });
    let first = output.alarm.iter().position(|alarm| *alarm).unwrap();
    assert!((50..55).contains(&first), "{first}");
    assert!(output.score[..50].iter().all(|p| *p < 0.05) && output.score[60..].iter().all(|p| *p > 0.9));
    let compared = output.compared();
    assert!(compared[69] == output.score[69] && compared[70] == 0.001 * output.score[70]);
    assert!(output.alarm[first..].iter().all(|alarm| *alarm));
    let mut stream = detector.stream().unwrap();
    let judged: Vec<_> = values.iter().map(|v| stream.push(v)).collect();
    assert!(judged[first].alarm && judged[80].alarm && judged[80].compared < judged[80].probability);
    let is_named = judged[first].reasons.iter().any(|reason| reason.contains("watchdog"));
    assert!(is_named, "{:?}", judged[first]);
}
