//! Laws of several detectors: of their parameters, and of the unit and the sign of a signal.

use super::testing::detect;
use super::*;
use proptest::prelude::*;

fn entry(kind: &str) -> &'static Entry<dyn Detector> {
    crate::plugin::find(DETECTORS, kind).unwrap_or_else(|| panic!("no detector `{kind}`"))
}

#[test]
fn parameters_that_do_not_fit_together_are_refused() {
    let refused = |kind: &str, text: &str| entry(kind).build_from_text(text).err().map(|e| e.key);
    for kind in ["level", "standard-score", "relative-drop", "cusum", "page-hinkley", "sequential-test"] {
        assert_eq!(refused(kind, "{}"), Some(None), "{kind}");
        assert_eq!(refused(kind, "{ below = 0.5, above = 0.5 }"), Some(None), "{kind}");
        assert_eq!(refused(kind, "{ below = nan }"), Some(Some("below")), "{kind}");
        assert_eq!(refused(kind, "{ above = inf }"), Some(Some("above")), "{kind}");
    }
    let [none, sixteen, seventeen] = [0, 16, 17].map(|count| format!("{{ below = {:?} }}", vec![0.5; count]));
    for (kind, text, key) in [
        ("relative-drop", "{ below = 1.0 }", "below"),
        ("relative-drop", "{ above = 1.0 }", "above"),
        ("relative-drop", "{ rule = \"excess\", below = 0.0 }", "below"),
        ("relative-drop", "{ rule = \"excess\", above = 0.0 }", "above"),
        ("relative-drop", "{ below = 0.5, window = 3, least = 4 }", "least"),
        ("joint-drop", "{ below = [0.5], window = 3, least = 4 }", "least"),
        ("joint-drop", "{ below = [0.5, 1.0] }", "below"),
        ("joint-drop", "{ below = [0.5, nan] }", "below"),
        ("joint-drop", none.as_str(), "below"),
        ("joint-drop", seventeen.as_str(), "below"),
        ("sequential-test", "{ above = 7.0, high = 5.0 }", "above"),
        ("sequential-test", "{ below = 0.5, low = 1.0 }", "high"),
        ("sequential-test", "{ below = 0.5, low = -1e308, high = 1e308 }", "high"),
        ("sequential-test", "{ below = 1.0 }", "below"),
        ("accumulated-validation", "{ beta = 1.0, train = \"t\" }", "beta"),
        ("arte-star", "{ beta = 1.0, train = \"t\" }", "beta"),
        ("arte-star", "{ beta = 1.0, beta_2 = \"half-of-one\" }", "beta_2"),
        ("arte", "{ long = 2, short = 3 }", "short"),
        ("arma-forecast", "{ order = [2, 2], window = 3 }", "window"),
        ("matched-kalman-bank", "{ life = 4 }", "models"),
        ("periodic", "{ period = 3, phase = 3 }", "phase"),
        ("random", "{ rate = nan }", "rate"),
    ] {
        assert_eq!(refused(kind, text), Some(Some(key)), "{kind} {text}");
    }
    for kind in ["accumulated-validation", "arte-star", "periodic", "random"] {
        assert_eq!(refused(kind, "{}"), Some(None), "{kind}");
    }
    for (kind, text) in [
        ("relative-drop", "{ rule = \"excess\", below = -0.1 }"),
        ("relative-drop", "{ below = 0.5, window = 3, least = 3 }"),
        ("joint-drop", sixteen.as_str()),
        ("matched-kalman-bank", "{ life = 3 }"),
    ] {
        assert_eq!(refused(kind, text), None, "{kind} {text}");
    }
}

/// A parameter that has a unit: its name, its value, and the power of the signal's unit that is its own.
type InUnits = (&'static str, f64, i32);

const FLOOR: &[InUnits] = &[("variance_floor", 1e-4, 2)];
const VARIANCES: &[InUnits] =
    &[("start_variance", 10.0, 2), ("jump_variance", 1.0, 2), ("least_noise", 1e-8, 2)];

/// Kinds with their parameters without a unit, those with one, and the power of the signal's unit that is the score's.
const UNITS: [(&str, &str, &[InUnits], i32); 5] = [
    ("arma-forecast", "horizon = 5", &[("threshold", 0.004, 1)], 1),
    ("two-model-chi-square", "length = 3, least_reference = 4, test = \"mean\"", FLOOR, 0),
    ("two-model-chi-square", "length = 3, least_reference = 4, test = \"energy\"", FLOOR, 0),
    ("matched-kalman-bank", "forgetting = 0.75, start_window = 9", VARIANCES, 1),
    ("relative-drop", "below = 0.6", &[], 0),
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    // Powers of two, so that nothing is rounded.
    #[test]
    fn the_unit_of_the_signal_does_not_matter(
        signal in prop::collection::vec(-1.0_f64..1.0, 0..80), power in -6..6_i32,
    ) {
        for (kind, plain, in_units, of_score) in UNITS {
            let of = |unit: f64| {
                let mut text = plain.to_string();
                in_units.iter().for_each(|(key, value, power)| {
                    text += &format!(", {key} = {:?}", value * unit.powi(*power));
                });
                let signal: Vec<f64> = signal.iter().map(|y| y * unit).collect();
                detect(entry(kind), &format!("{{ {text} }}"), &signal)
            };
            let unit = 2.0_f64.powi(power);
            let (one, other) = (of(1.0), of(unit));
            let score: Vec<f64> = one.score.iter().map(|score| score * unit.powi(of_score)).collect();
            prop_assert_eq!(&score, &other.score, "{} {}", kind, plain);
            prop_assert_eq!((one.alarm, one.changes), (other.alarm, other.changes), "{} {}", kind, plain);
        }
    }

    #[test]
    fn the_negative_signal_is_judged_by_the_other_side(
        signal in prop::collection::vec(-2.0_f64..2.0, 0..80), h in 0.1_f64..8.0,
    ) {
        let negative: Vec<f64> = signal.iter().map(|y| -y).collect();
        for kind in ["cusum", "page-hinkley"] {
            let of = |side: &str, signal: &[f64]| {
                detect(entry(kind), &format!("{{ {side} = {h:?}, start = 5 }}"), signal)
            };
            prop_assert_eq!(of("above", &signal), of("below", &negative), "{}", kind);
        }
        for test in ["mean", "energy"] {
            let text = format!("{{ length = 3, least_reference = 4, test = \"{test}\" }}");
            let [one, other] =
                [&signal, &negative].map(|signal| detect(entry("two-model-chi-square"), &text, signal));
            let changes = other.changes.map(|all| all.iter().map(|c| -c).collect::<Vec<i32>>());
            prop_assert_eq!((one.score, one.changes), (other.score, changes), "{}", test);
        }
    }
}
