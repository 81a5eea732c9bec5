use super::*;
use crate::detector::testing;
use crate::num::seed;
use proptest::prelude::*;
use rand_distr::{Distribution, Gamma, Normal};

fn detect(text: &str, signal: &[f64]) -> DetectorOutput {
    testing::detect(&ENTRY, text, signal)
}

#[derive(Deserialize)]
struct Case {
    name: String,
    params: toml::Table,
    signal: Vec<f64>,
    levels: Vec<f64>,
    changes: Vec<i32>,
}

#[test]
fn agrees_with_dense_normal_densities() {
    let cases: Vec<Case> =
        serde_json::from_str(include_str!("../../../../../tests/oracles/matched_kalman_bank.json")).unwrap();
    assert_eq!(cases.len(), 7);
    for case in cases {
        let output = detect(&toml::Value::Table(case.params).to_string(), &case.signal);
        assert_eq!(output.changes.unwrap(), case.changes, "{}", case.name);
        for (t, (a, b)) in output.score.iter().zip(&case.levels).enumerate() {
            // The dense covariances have a condition of up to 1e9.
            assert!((a - b).abs() < 1e-6, "{} {t}: {a} {b}", case.name);
        }
    }
}

// A first value that is far from the start is no jump, and of equally probable filters the oldest is taken.
#[test]
fn a_start_is_no_change_and_a_tie_the_oldest() {
    let output = detect("{ noise_variance = 1.0, start_level = 0.0 }", &[100.0; 3]);
    assert_eq!((output.changes.unwrap()[0], output.alarm[0]), (0, false));
    let detector = Params::default();
    let mut bank = detector.run(&[1.0, 2.0]);
    bank.filters = vec![bank.filters[0]; 2];
    assert_eq!(bank.most_probable(), 0);
}

#[test]
fn a_constant_never_changes() {
    for text in ["{}", "{ noise_variance = 0.01 }", "{ forgetting = 0.0, least_noise = 1e-12 }"] {
        for level in [0.0, 0.1, -3.3, 1e50] {
            let output = detect(text, &[level; 300]);
            assert_eq!(output.changes.unwrap(), [0; 300], "{text} {level}");
            assert_eq!(output.score, [level; 300], "{text} {level}");
        }
        let start: Vec<f64> =
            (0..300).map(|t| if t < 8 { 1.0 + f64::from(t * t % 7) / 4.0 } else { 1.3 }).collect();
        let changes = detect(text, &start).changes.unwrap();
        // The level and its noise are those of the constant after the first window, none of them 0.
        assert!(changes[25..].iter().all(|c| *c == 0), "{text} {changes:?}");
    }
}

// Averages of 20 series of 1000 samples: 12.9 and 1.8 with the estimated variance, 277 and 2.0 with one that
// is too small for the skewed noise, whose peaks a bank for normal noise takes for jumps.
#[test]
fn skewed_noise_makes_false_changes_and_normal_noise_few() {
    let per_thousand = |text: &str, draw: &dyn Fn(&mut rand_chacha::ChaCha8Rng) -> f64| {
        let series = (0..20).map(|k| {
            let mut rng = seed::rng(k);
            let signal: Vec<f64> = (0..1000).map(|_| draw(&mut rng)).collect();
            detect(text, &signal).changes.unwrap().iter().filter(|c| **c != 0).count()
        });
        series.sum::<usize>() as f64 / 20.0
    };
    let gamma = |rng: &mut rand_chacha::ChaCha8Rng| Gamma::new(0.7, 1.0).unwrap().sample(rng);
    let normal = |rng: &mut rand_chacha::ChaCha8Rng| Normal::new(0.0, 0.05_f64.sqrt()).unwrap().sample(rng);
    let estimated = [per_thousand("{}", &gamma), per_thousand("{}", &normal)];
    let fixed = "{ noise_variance = 0.05, merge = 1 }";
    let fixed = [per_thousand(fixed, &gamma), per_thousand(fixed, &normal)];
    assert!((5.0..25.0).contains(&estimated[0]) && estimated[1] < 3.0, "{estimated:?}");
    assert!((200.0..300.0).contains(&fixed[0]) && fixed[1] < 3.0, "{fixed:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_turned_signal_has_turned_changes(
        y in prop::collection::vec(-1.0_f64..1.0, 0..80), life in 0..4_usize, merge in 1..6_usize,
    ) {
        let params = format!("{{ life = {life}, merge = {merge}, forgetting = 0.7, start_window = 9 }}");
        let turned: Vec<f64> = y.iter().map(|v| -v).collect();
        let (a, b) = (detect(&params, &y), detect(&params, &turned));
        prop_assert_eq!(&a.score, &b.score.iter().map(|v| -v).collect::<Vec<_>>());
        let changes = a.changes.unwrap();
        prop_assert_eq!(&changes, &b.changes.unwrap().iter().map(|c| -c).collect::<Vec<_>>());
        // Labels are what the last change says.
        let mut label = false;
        for (change, alarm) in changes.iter().zip(&a.alarm) {
            label = *change > 0 || (*change == 0 && label);
            prop_assert_eq!(label, *alarm);
        }
    }
}
