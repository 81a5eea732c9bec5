//! What unit tests share.

use std::path::PathBuf;

/// The folder of real sequences, when there is one: `TRACKFAIL_DATA`, else `../shared/data` beside the
/// checkout. Says on stderr that the test is skipped when there is none.
pub fn real_data(test: &str) -> Option<PathBuf> {
    let root = std::env::var_os("TRACKFAIL_DATA")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data"), PathBuf::from);
    if root.is_dir() {
        return Some(root);
    }
    eprintln!("SKIPPED {test}: no real data (set TRACKFAIL_DATA to a data root)");
    None
}
