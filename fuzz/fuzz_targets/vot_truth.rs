//! `groundtruth.txt` of VOT sequences.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    if let Ok(truth) = trackfail::dataset::vot::parse_truth(Path::new("fuzz.txt"), data) {
        assert!(!truth.is_empty());
        assert!(truth.iter().flatten().all(|r| r.area() > 0.0));
    }
});
