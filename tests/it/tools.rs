//! What the tests of the program share.

use assert_cmd::Command;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The program, in an environment without the user's settings.
pub fn trackfail() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
    command.env_remove("TRACKFAIL_DATA").env_remove("TRACKFAIL_PLUGINS").env_remove("HOME");
    command
}

/// Runs with arguments and gives exit code, stdout and stderr.
pub fn output(arguments: &[&str]) -> (i32, String, String) {
    let output = trackfail().args(arguments).output().expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
}

/// `../shared/data` beside the checkout, or `TRACKFAIL_DATA`; says so when there is none.
pub fn real_data(test: &str) -> Option<PathBuf> {
    let root = std::env::var_os("TRACKFAIL_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"), PathBuf::from);
    if root.is_dir() {
        return Some(root);
    }
    eprintln!("SKIPPED {test}: no real data (set TRACKFAIL_DATA to a data root)");
    None
}

/// Every file below a folder with its bytes; `manifest.json` has times and is left out, and so is the
/// store, which is a cache.
pub fn files(root: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![root.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let store = path.file_name().is_some_and(|n| n == ".store");
            if path.is_dir() {
                open.extend((!store).then_some(path));
            } else if path.file_name().is_some_and(|n| n != "manifest.json") {
                let bytes = std::fs::read(&path).expect("a file");
                found.insert(path.strip_prefix(root).expect("below the root").to_path_buf(), bytes);
            }
        }
    }
    found
}

/// Fails with the name of the first file that differs.
pub fn assert_same_files(a: &Path, b: &Path) {
    let (a, b) = (files(a), files(b));
    assert!(!a.is_empty());
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in &a {
        assert!(bytes == &b[name], "{} differs", name.display());
    }
}

/// The rows of a CSV file without quoted fields, as column -> value.
pub fn rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    lines
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            assert_eq!(fields.len(), header.len(), "{line}");
            header.iter().zip(fields).map(|(h, f)| (h.to_string(), f.to_string())).collect()
        })
        .collect()
}
