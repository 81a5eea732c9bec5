//! Result files in the JSON of OTB; the first byte chooses run and frame numbers.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use trackfail::dataset::Numbering;
use trackfail::tracker::results::{Base, otb_json};

fuzz_target!(|data: &[u8]| {
    let Some((choice, data)) = data.split_first() else { return };
    let first = u32::from(choice >> 4);
    let numbering = Numbering { first, official: (first, first + 9) };
    let run = u32::from(choice & 3);
    if let Ok(boxes) = otb_json::parse(Path::new("fuzz.json"), data, run, numbering, Base::One) {
        assert!(boxes.first >= first && !boxes.regions.is_empty() && boxes.regions.len() <= 10);
    }
});
