//! Result files with a box a line.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use trackfail::tracker::results::{Base, otb_text};

fuzz_target!(|data: &[u8]| {
    if let Ok(boxes) = otb_text::parse_boxes(Path::new("fuzz.txt"), data, Base::One) {
        assert!(!boxes.is_empty() && boxes.iter().all(|r| r.area() > 0.0));
    }
});
