//! Lines for `trackfail monitor`; the first byte says which options. A stream that goes on from its state in the middle gives
//! the same answers.

#![no_main]

use libfuzzer_sys::fuzz_target;
use trackfail::cli::monitor::Lines;
use trackfail::monitor::{Options, Targets};

const METHODS: [Option<&str>; 4] = [None, Some("Fused boxes"), Some("Agreement"), Some("Displacement")];

fn options(first: u8) -> Options {
    let method = METHODS[usize::from(first) % METHODS.len()].map(String::from);
    Options { method, base: (first >= 128).then_some(1), ..Options::default() }
}

fuzz_target!(|data: &[u8]| {
    let Some((&first, data)) = data.split_first() else { return };
    let Ok(mut lines) = Lines::new(options(first)) else { return };
    let input: Vec<&[u8]> = data.split(|b| *b == b'\n').collect();
    let (before, after) = input.split_at(input.len() / 2);
    for line in before {
        lines.answer(line);
    }
    let saved = lines.targets().save().expect("a stream can be saved");
    let mut resumed = Lines::of(Targets::resume(options(first), &saved).expect("what was saved can be read"));
    for line in after {
        assert_eq!(lines.answer(line), resumed.answer(line));
    }
});
