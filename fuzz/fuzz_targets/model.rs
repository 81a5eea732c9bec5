//! Learned models as JSON: of the fused detector, and of consistency. One that is taken judges ordinary values, and gives
//! probabilities or a threshold.

#![no_main]

use libfuzzer_sys::fuzz_target;
use serde_json::{Value, json};
use trackfail::method::Method;

const INPUTS: [&str; 4] = ["displacement", "acceleration", "scale", "aspect"];

/// A method whose detector learns.
fn unready(signals: &[Value], detector: &Value) -> Method {
    Method::new("fuzz", signals, detector).expect("a method")
}

fn fused(model: &Value) {
    let signals = INPUTS.map(|measure| json!({ "kind": "box-motion", "measure": measure }));
    let method = unready(&signals, &json!({ "kind": "fused", "inputs": INPUTS, "train": "training" }));
    let Ok(method) = method.with_model(model) else { return };
    let mut stream = method.detector.detector.stream().expect("it judges frame by frame");
    for frame in 0..50 {
        let judgement = stream.push(&INPUTS.map(|name| f64::from(frame % 7) * 0.1 * name.len() as f64));
        assert!((0.0..=1.0).contains(&judgement.probability), "{}", judgement.probability);
    }
}

fn consistency(model: &Value) {
    for approximation in ["convolution", "normal", "empirical"] {
        let detector =
            json!({ "kind": "accumulated-validation", "train": "t", "approximation": approximation });
        let method = unready(&[json!({ "kind": "uncertainty-change" })], &detector);
        let Ok(method) = method.with_model(model) else { continue };
        let threshold = method.detector.detector.facts().threshold.expect("a model gives one");
        assert!(threshold.is_finite(), "{approximation}: {threshold}");
    }
}

fuzz_target!(|data: &[u8]| {
    let Ok(read) = serde_json::from_slice::<Value>(data) else { return };
    // The files of the program have it under a key.
    let model = read.get("model").unwrap_or(&read);
    fused(model);
    consistency(model);
});
