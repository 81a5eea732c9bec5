//! Files of confidence, one value a frame; the first byte is the number of frames.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use trackfail::tracker::results::confidence;

fuzz_target!(|data: &[u8]| {
    let Some((frames, data)) = data.split_first() else { return };
    for name in ["fuzz.txt", "fuzz_confidence.value"] {
        if let Ok(values) = confidence::parse(Path::new(name), data, usize::from(*frames)) {
            assert_eq!(values.len(), usize::from(*frames));
            assert!(values.iter().flatten().all(|value| value.is_finite()));
        }
    }
});
