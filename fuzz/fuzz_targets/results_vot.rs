//! Result files of the VOT reset protocol; the first byte is the number of frames.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use trackfail::region::{Rect, Region};
use trackfail::tracker::results::{Base, rows, vot};

fuzz_target!(|data: &[u8]| {
    let Some((frames, data)) = data.split_first() else { return };
    let truth = vec![Some(Region::Rect(Rect::new(1.0, 2.0, 3.0, 4.0))); usize::from(*frames)];
    let path = Path::new("fuzz.txt");
    let Ok(rows) = rows::read(path, data) else { return };
    if let Ok(states) = vot::parse(path, rows, &truth, Base::Zero, None) {
        assert_eq!(states.len(), truth.len());
    }
});
