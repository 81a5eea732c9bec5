//! Readers of `tests/oracles`, whose files are written by scripts of the same names.

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
