//! Readers of `tests/oracles`, whose files are written by scripts of the same names, and mixtures of the tests.

use crate::num::gamma_mixture::{Component, Mixture};
use serde_json::Value;

/// Parses the file of an oracle.
pub fn oracle(name: &str) -> Value {
    let path = format!("{}/../../tests/oracles/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    serde_json::from_str(&text).unwrap()
}

/// Cases in one part of an oracle's file.
pub fn cases(name: &str, part: &str) -> Vec<Value> {
    let cases = oracle(name)[part].as_array().unwrap().clone();
    assert!(!cases.is_empty(), "{name}: {part}");
    cases
}

/// Converts a JSON list to numbers.
pub fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(number).collect()
}

/// Converts a JSON value to a number.
pub fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

/// Converts a JSON value to a whole number.
pub fn count(v: &Value) -> usize {
    v.as_u64().unwrap() as usize
}

/// A mixture of components, each with its weight, shape and scale.
pub fn mixture(components: &[(f64, f64, f64)]) -> Mixture {
    let component = |&(weight, shape, scale): &(f64, f64, f64)| Component { weight, shape, scale };
    Mixture::new(components.iter().map(component).collect()).unwrap()
}

/// A mixture of random components, each with a share of the weight, and the decimal logarithms of shape and mean.
pub fn drawn_mixture(parts: &[(f64, f64, f64)]) -> Mixture {
    let all: f64 = parts.iter().map(|part| part.0).sum();
    let component = |&(share, shape, mean): &(f64, f64, f64)| {
        let shape = 10.0_f64.powf(shape);
        (share / all, shape, 10.0_f64.powf(mean) / shape)
    };
    mixture(&parts.iter().map(component).collect::<Vec<_>>())
}
