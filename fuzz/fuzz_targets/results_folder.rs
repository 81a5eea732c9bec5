//! `manifest.json` (first part) and `measures.csv` (after the first NUL) of a results folder.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use trackfail::results::{manifest, measures};

fuzz_target!(|data: &[u8]| {
    let mut parts = data.splitn(2, |b| *b == 0);
    let first = parts.next().unwrap_or_default();
    if let Ok(read) = manifest::parse(Path::new("manifest.json"), first) {
        assert!(read.format <= manifest::FORMAT);
    }
    if let Some(table) = parts.next() {
        let _ = measures::read(table.to_vec());
    }
});
