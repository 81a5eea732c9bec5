//! Files of confidence, one value a frame; the first byte is the number of frames.

#![no_main]

mod laws;

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use trackfail::tracker::results::confidence;

fuzz_target!(|data: &[u8]| {
    let Some((frames, data)) = data.split_first() else { return };
    for name in ["fuzz.txt", "fuzz_confidence.value"] {
        let read = |data: &[u8]| {
            confidence::parse(Path::new(name), data, usize::from(*frames)).map_err(|e| e.to_string())
        };
        let answer = read(data);
        for again in laws::other_spellings(data) {
            assert_eq!(read(&again), answer);
        }
        if let Ok(values) = answer {
            assert_eq!(values.len(), usize::from(*frames));
            assert!(values.iter().flatten().all(|value| value.is_finite()));
        }
    }
});
