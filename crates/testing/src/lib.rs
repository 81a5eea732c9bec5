//! Helpers of the tests of all crates.

use proptest::prelude::*;
use std::path::PathBuf;

/// The folder of real sequences, when there is one: `TRACKFAIL_DATA`, else `../shared/data` beside the
/// checkout. Says on stderr that the test is skipped when there is none.
pub fn real_data(test: &str) -> Option<PathBuf> {
    let root = std::env::var_os("TRACKFAIL_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    if root.is_dir() {
        return Some(root);
    }
    eprintln!("SKIPPED {test}: no real data (set TRACKFAIL_DATA to a data root)");
    None
}

/// A valid document with a piece cut out and something else in its place.
pub fn damaged(valid: &'static [u8]) -> impl Strategy<Value = Vec<u8>> {
    let bytes = prop::collection::vec(any::<u8>(), 0..9);
    let words = r#"-?[0-9]{1,22}|1e999|nan|inf|"|\[{1,200}|\{"a":|[,;. \t\r\n]{1,3}"#;
    let insert = prop_oneof![bytes, words.prop_map(String::into_bytes)];
    (any::<prop::sample::Index>(), 0..20_usize, insert).prop_map(|(at, length, insert)| {
        let at = at.index(valid.len() + 1);
        let rest = valid.get(at + length..).unwrap_or_default();
        [&valid[..at], &insert, rest].concat()
    })
}
