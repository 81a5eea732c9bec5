//! Ground truth of every format; the first byte says which.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use trackfail::dataset::format::FORMATS;

fuzz_target!(|data: &[u8]| {
    let Some((kind, bytes)) = data.split_first() else { return };
    let format = &FORMATS[usize::from(*kind) % FORMATS.len()];
    if let Ok(truth) = (format.parse_truth)(Path::new("fuzz.txt"), bytes) {
        assert!(!truth.is_empty());
        assert!(truth.iter().flatten().all(|r| r.area() > 0.0));
    }
});
