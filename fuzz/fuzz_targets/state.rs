//! States of `trackfail monitor`, as they are and under a digest that makes them believable; the first byte says of which kind.

#![no_main]

use libfuzzer_sys::fuzz_target;
use sha2::{Digest, Sha256};
use trackfail::cli::monitor::Lines;
use trackfail::monitor::{Options, Targets};

fn resume(saved: &[u8]) {
    let Ok(targets) = Targets::resume(Options::default(), saved) else { return };
    let mut lines = Lines::of(targets);
    for line in [&br#"{"box": [1, 2, 3, 4]}"#[..], br#"{"box": [2, 2, 3, 4], "id": 1}"#, b"{}"] {
        lines.answer(line);
    }
    let _ = lines.targets().save();
}

fuzz_target!(|data: &[u8]| {
    resume(data);
    let Some((first, memory)) = data.split_first() else { return };
    let head: &[u8] = if first % 2 == 0 { b"trackfail-monitor 4\n" } else { b"trackfail-monitors 2\n" };
    resume(&[head, Sha256::digest(memory).as_slice(), memory].concat());
});
