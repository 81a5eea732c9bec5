//! Helpers of the tests of all crates.

#[path = "../../needs/src/conditions.rs"]
pub mod conditions;
pub mod hostile;
pub mod server;

use proptest::prelude::*;
use std::borrow::Borrow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use std::time::{Duration, Instant};
use tempfile::TempDir;
pub use trackfail_needs::{met_when_compiled, needs};
use walkdir::{DirEntry, WalkDir};

/// A data root with links to [the real data that tests look at](conditions::REAL_DATA), and nothing else, so that no
/// test depends on what lies beside them.
///
/// A test that calls it is marked `#[needs(real_data)]`, which leaves it out where these data are not.
///
/// # Panics
/// If they have gone since the tests were compiled, or links cannot be made.
pub fn real_data() -> PathBuf {
    static ROOT: LazyLock<PathBuf> = LazyLock::new(|| {
        let places = conditions::real_data();
        let places = places.expect("the real data that were there when this test was compiled have gone");
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/real-data");
        for (name, place) in conditions::REAL_DATA.iter().zip(places) {
            let place = place.canonicalize().expect("a place that is there");
            link(&place, &root.join(name)).unwrap_or_else(|e| panic!("{}: {e}", root.join(name).display()));
        }
        root.canonicalize().expect("a folder that was just made")
    });
    ROOT.clone()
}

/// Makes `path` a link to `place`, also while other tests do so.
#[cfg(unix)]
fn link(place: &Path, path: &Path) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(path);
    std::fs::create_dir_all(folder)?;
    let aside =
        folder.join(format!(".{}-{}", std::process::id(), path.file_name().unwrap_or_default().display()));
    std::os::unix::fs::symlink(place, &aside)?;
    std::fs::rename(aside, path)
}

#[cfg(not(unix))]
fn link(_: &Path, _: &Path) -> std::io::Result<()> {
    Err(std::io::Error::other("tests on real data need links"))
}

/// Writes a file below a folder, makes the folders on the way to it, and gives its path.
///
/// # Panics
/// If it cannot be written.
pub fn put(root: &Path, name: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = root.join(name);
    std::fs::create_dir_all(path.parent().unwrap_or(root)).expect("a folder that can be written to");
    std::fs::write(&path, bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    path
}

/// A new folder with files; of two of one name the later one is there.
///
/// # Panics
/// If it cannot be made.
pub fn folder<N: AsRef<Path>, B: AsRef<[u8]>>(files: impl IntoIterator<Item = (N, B)>) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    for (name, bytes) in files {
        put(folder.path(), name, bytes);
    }
    folder
}

/// Fails unless there are as many numbers as wanted, each at most so far from its own; `what` is told with them.
///
/// # Panics
/// If they differ by more.
#[track_caller]
pub fn assert_near<G, W>(got: G, want: W, within: f64, what: impl Display)
where
    G: IntoIterator<Item: Borrow<f64>>,
    W: IntoIterator<Item: Borrow<f64>>,
{
    let got: Vec<f64> = got.into_iter().map(|v| *Borrow::<f64>::borrow(&v)).collect();
    let want: Vec<f64> = want.into_iter().map(|v| *Borrow::<f64>::borrow(&v)).collect();
    let is_near = got.len() == want.len() && got.iter().zip(&want).all(|(a, b)| (a - b).abs() <= within);
    assert!(is_near, "{what}: {got:?} is not {want:?} within {within}");
}

/// Fails unless a text, such as a message, has these words in it.
///
/// # Panics
/// If it has not.
#[track_caller]
pub fn assert_says(text: impl Display, words: impl AsRef<str>) {
    let (text, words) = (text.to_string(), words.as_ref());
    assert!(text.contains(words), "`{words}` is not in: {text}");
}

/// Every file below a folder with its bytes. `run.json`, which differs from run to run, and the store, which is a
/// cache, are left out.
pub fn files(root: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let is_store = |e: &DirEntry| e.depth() > 0 && e.file_type().is_dir() && e.file_name() == ".store";
    let walk = WalkDir::new(root).follow_links(true).into_iter().filter_entry(|e| !is_store(e));
    let entries = walk.map(|e| e.expect("an entry"));
    let files = entries.filter(|e| !e.file_type().is_dir() && e.file_name() != "run.json");
    let read = |e: DirEntry| {
        let name = e.path().strip_prefix(root).expect("below the root").to_path_buf();
        (name, std::fs::read(e.path()).expect("a file"))
    };
    files.map(read).collect()
}

/// Fails with the name of the first file that differs between two folders; see [`files`].
pub fn assert_same_files(a: &Path, b: &Path) {
    let (a, b) = (files(a), files(b));
    assert!(!a.is_empty());
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in &a {
        assert!(bytes == &b[name], "{} differs", name.display());
    }
}

/// The rows of a CSV file, as column -> value.
pub fn rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = hostile::csv(text).into_iter();
    let header = lines.next().unwrap_or_default();
    let row = |fields: Vec<String>| {
        assert_eq!(fields.len(), header.len(), "{fields:?}");
        header.iter().cloned().zip(fields).collect()
    };
    lines.map(row).collect()
}

/// Makes `path` a shell script that can be run.
///
/// # Panics
/// If it cannot be written.
#[cfg(unix)]
pub fn script(path: &Path, text: &str) {
    let source = path.with_extension("source");
    std::fs::write(&source, format!("#!/bin/sh\n{text}\n")).expect("a folder that can be written to");
    // By another process, since one that this one is just starting may still hold a file open, which then cannot be run.
    let made = Command::new("install").args(["-m", "755"]).arg(&source).arg(path).status();
    assert!(made.is_ok_and(|status| status.success()), "{} cannot be made", path.display());
}

/// Compares what was found with the lines of `tests/pins.txt` that begin with `section`; with `UPDATE=1` in the environment it
/// writes them instead. A pin holds what must not change unseen, such as the digest of a plugin's output.
///
/// # Panics
/// If they differ, with the remedy, or if the file cannot be read or written.
pub fn check_pins(section: &str, found: impl IntoIterator<Item = String>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/pins.txt");
    let found: BTreeSet<String> = found.into_iter().map(|line| format!("{section} {line}")).collect();
    let file = std::fs::File::options().read(true).write(true).open(&path).expect("tests/pins.txt");
    // Tests run side by side, and each writes its own lines.
    file.lock().expect("a file that can be locked");
    let text = std::fs::read_to_string(&path).expect("tests/pins.txt");
    let begins = format!("{section} ");
    let (known, others): (BTreeSet<String>, BTreeSet<String>) =
        text.lines().map(String::from).partition(|line| line.starts_with(&begins));
    if std::env::var_os("UPDATE").is_some() {
        let all: Vec<String> = found.into_iter().chain(others).collect::<BTreeSet<_>>().into_iter().collect();
        std::fs::write(&path, all.join("\n") + "\n").expect("tests/pins.txt can be written");
        return;
    }
    let new: Vec<&String> = found.difference(&known).collect();
    let gone: Vec<&String> = known.difference(&found).collect();
    assert!(
        new.is_empty() && gone.is_empty(),
        "found, but not in tests/pins.txt: {new:#?}\nthere, but not found: {gone:#?}\nIf that is meant, raise `version` in \
         the ENTRY of what has changed, and write the pins by UPDATE=1 cargo test"
    );
}

/// True if something is so, or becomes so within a while.
pub fn within(limit: Duration, mut is_so: impl FnMut() -> bool) -> bool {
    let end = Instant::now() + limit;
    while !is_so() {
        if Instant::now() > end {
            return false;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    true
}

/// Sends a signal, `-TERM` and the like, to a process.
///
/// # Panics
/// If that is not there.
#[track_caller]
pub fn kill(process: u32, signal: &str) {
    let sent = Command::new("kill").args([signal, &process.to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()), "{process} got no {signal}");
}

/// True if a process is there and has not ended.
///
/// # Panics
/// Where there is no `ps`.
pub fn is_running(pid: &str) -> bool {
    let shown = Command::new("ps").args(["-o", "stat=", "-p", pid]).output().expect("ps");
    let state = String::from_utf8_lossy(&shown.stdout).trim().to_string();
    !state.is_empty() && !state.starts_with('Z')
}

/// True if a process has ended, or does within a while.
///
/// # Panics
/// Where there is no `ps`.
pub fn is_gone(pid: &str) -> bool {
    within(Duration::from_secs(20), || !is_running(pid))
}

/// A valid document with a piece cut out and something else in its place.
pub fn damaged(valid: &'static [u8]) -> impl Strategy<Value = Vec<u8>> {
    let bytes = prop::collection::vec(any::<u8>(), 0..9);
    let words = r#"-?[0-9]{1,22}|1e999|nan|inf|"|\[{1,200}|\{"a":|[,;. \t\r\n]{1,3}"#;
    let insert = prop_oneof![bytes, words.prop_map(String::into_bytes)];
    (any::<prop::sample::Index>(), 0..20_usize, insert).prop_map(|(at, length, insert)| {
        let at = at.index(valid.len() + 1);
        [&valid[..at], &insert, valid.get(at + length..).unwrap_or_default()].concat()
    })
}
