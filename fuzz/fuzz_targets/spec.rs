//! Experiment files, which anybody may send. An error names a line that the file has.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Err(first) = trackfail::spec::parse("fuzz.toml", text) else { return };
    let lines = text.split('\n').count();
    for error in std::iter::once(&first).chain(&first.others) {
        assert!(error.file != "fuzz.toml" || (1..=lines).contains(&error.line), "{error}");
    }
});
