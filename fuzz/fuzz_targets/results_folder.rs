//! `manifest.json` (first part) and `measures.csv` (after the first NUL) of a results folder.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use trackfail::report::results;

fuzz_target!(|data: &[u8]| {
    let mut parts = data.splitn(2, |b| *b == 0);
    let manifest = parts.next().unwrap_or_default();
    if let Ok(manifest) = results::parse_manifest(Path::new("manifest.json"), manifest) {
        assert!(manifest.format <= trackfail::table::manifest::FORMAT);
    }
    if let Some(measures) = parts.next() {
        let _ = trackfail::table::records::read_measures(measures.to_vec());
    }
});
