//! Readers of `tests/oracles`, whose files scripts of the same names have written.

use serde_json::Value;

/// An oracle's file by its name.
pub fn oracle(name: &str) -> Value {
    let path = format!("{}/../../tests/oracles/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    serde_json::from_str(&text).unwrap()
}

/// The cases of a part of an oracle's file.
pub fn cases(name: &str, part: &str) -> Vec<Value> {
    let cases = oracle(name)[part].as_array().unwrap().clone();
    assert!(!cases.is_empty(), "{name}: {part}");
    cases
}

/// A list of numbers.
pub fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(number).collect()
}

/// A number.
pub fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

/// A whole number.
pub fn count(v: &Value) -> usize {
    v.as_u64().unwrap() as usize
}
