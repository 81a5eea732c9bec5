//! Files of boxes of `trackfail detect`; the first three bytes say in which format, from which base, and for how many frames.

#![no_main]

mod laws;

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use trackfail::tracker::results::Base;
use trackfail::tracker::results::user_boxes::{BoxFormat, Options, parse};

const FORMATS: [Option<&str>; 6] =
    [None, Some("xywh"), Some("xyxy"), Some("mot"), Some("yolo"), Some("frame,id,cx,cy,w,h,conf")];

fuzz_target!(|data: &[u8]| {
    let Some(([format, how, frames], data)) = data.split_first_chunk() else { return };
    let options = Options {
        format: FORMATS[usize::from(*format) % FORMATS.len()].and_then(|words| BoxFormat::read(words).ok()),
        base: [None, Some(Base::Zero), Some(Base::One)][usize::from(*how) % 3],
        absent: how & 4 == 4,
        frames: (how & 8 == 8).then_some(usize::from(*frames)),
        size: (how & 16 == 16).then_some((640, 480)),
        ..Options::default()
    };
    let read = |data: &[u8]| parse(Path::new("fuzz.txt"), data, &options).map_err(|e| e.to_string());
    let answer = read(data);
    for again in laws::other_spellings(data) {
        assert_eq!(read(&again), answer);
    }
    let Ok(read) = answer else { return };
    for target in &read.targets {
        assert!(target.regions.iter().flatten().all(|region| region.area() > 0.0));
    }
});
