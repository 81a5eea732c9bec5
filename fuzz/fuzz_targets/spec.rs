//! Experiment files, which anybody may send.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = trackfail::spec::parse("fuzz.toml", text);
    }
});
