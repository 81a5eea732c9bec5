//! Models of `fused` detectors as JSON. One that is taken judges ordinary values, and gives probabilities.

#![no_main]

use libfuzzer_sys::fuzz_target;
use trackfail::method::Method;

fuzz_target!(|data: &[u8]| {
    let Ok(read) = serde_json::from_slice::<serde_json::Value>(data) else { return };
    // The files of the program have it under a key.
    let model = read.get("model").unwrap_or(&read);
    let method = Method::named("Fused boxes", None).expect("a built-in method");
    let inputs = method.signals.len();
    let Ok(method) = method.with_model(model) else { return };
    let mut stream = method.detector.detector.stream().expect("it judges frame by frame");
    for frame in 0..50 {
        let values: Vec<f64> = (0..inputs).map(|i| f64::from(frame % 7) * 0.1 * (i + 1) as f64).collect();
        let judgement = stream.push(&values);
        assert!((0.0..=1.0).contains(&judgement.probability), "{}", judgement.probability);
    }
});
