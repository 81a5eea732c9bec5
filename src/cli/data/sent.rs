//! `trackfail data verify` of results: the folder of an experiment, or a file of `trackfail pack`.

use crate::cli::{Failure, io_at, output};
use crate::dataset::file_digest;
use crate::dataset::text::{shorten_to, visible};
use crate::engine::store::lock_exclusive;
use crate::results::ResultsError;
use crate::results::manifest::{FILE as MANIFEST, Manifest};
use crate::results::sent::{Received, Verified};
use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, is_separator};

/// True if a name can be meant for results: no suite has a `/` in its name.
pub fn is_results(name: &str) -> bool {
    let path = Path::new(name);
    let is_zip = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("zip"));
    is_zip || name.contains(is_separator) || path.join(MANIFEST).exists()
}

/// Checks results and prints what they rest on; those in a file are unpacked into a results folder if one is given.
///
/// # Errors
/// `Usage` for results that are not there or not finished, or would replace others; `Data` for what is not as the manifest
/// says, or refused; `Io` for what the file system refuses.
pub fn verify(path: &Path, unpack: Option<&Path>) -> Result<(), Failure> {
    let usage = |path: &Path, why: &str| Failure::usage(format!("{}: {why}", path.display()));
    if path.is_dir() && unpack.is_some() {
        return Err(usage(path, "a folder; --unpack takes a file of `trackfail pack`"));
    }
    if path.is_dir() {
        let lock = lock_of(path);
        let verified = Verified::read(path).map_err(failure)?;
        drop(lock);
        return output::write(&basis(path, "", &verified));
    }
    if !path.is_file() {
        return Err(usage(path, "no such file or folder; name results, or a suite of `trackfail data list`"));
    }
    let parent = unpack.map_or_else(std::env::temp_dir, Path::to_path_buf);
    std::fs::create_dir_all(&parent).map_err(io_at(&parent))?;
    let received = Received::open(path, &parent).map_err(failure)?;
    let text = basis(path, &file_digest(path).map_err(Failure::io)?, &received.verified);
    let Some(results) = unpack else { return output::write(&text) };
    let place = results.join(&received.verified.results.experiment.name);
    let _lock = lock_exclusive(results);
    let is_taken = || place.symlink_metadata().is_ok();
    let taken = || usage(&place, "there are results already; name another folder, or remove them first");
    if is_taken() {
        return Err(taken());
    }
    // A folder without a store has no lock.
    received.publish(&place).map_err(|e| if is_taken() { taken() } else { Failure::io(e) })?;
    output::write(&format!("{text}unpacked into {}\n", place.display()))
}

/// Keeps runs from replacing the results in a folder while they are read, where a folder above them has a store.
fn lock_of(folder: &Path) -> Option<File> {
    folder.canonicalize().ok()?.ancestors().find_map(lock_exclusive)
}

fn failure(e: ResultsError) -> Failure {
    match e {
        ResultsError::Unfinished(_) => Failure::usage(e),
        _ if e.is_io() => Failure::io(e),
        _ => Failure::data(e),
    }
}

/// The data, versions and parameters that results rest on, a line each.
fn basis(path: &Path, digest: &str, verified: &Verified) -> String {
    let manifest = &verified.results.manifest;
    let Manifest { version, format, suite, digests, trackers, cells_done, cells_failed, .. } = manifest;
    let (present, failed) = (suite.present.len(), cells_failed.len());
    let frames = suite.present.iter().fold(0_usize, |sum, (_, frames)| sum.saturating_add(*frames));
    let others = digests.iter().filter(|(name, _)| **name != suite.name);
    let others: Vec<String> = others.map(|(name, all)| format!("{name} ({} sequences)", all.len())).collect();
    let kinds = trackers.iter().map(|t| format!("{} ({} {})", t.label, t.kind, t.version));
    let unnamed = verified.unnamed.iter().map(|name| name.split('/').next().unwrap_or(name));
    let unnamed: Vec<&str> = unnamed.collect::<BTreeSet<_>>().into_iter().collect();
    let lines = [
        ("sha256", digest.to_string()),
        ("experiment", manifest.experiment.clone()),
        ("written by", format!("trackfail {version}, results format {format}")),
        ("protocol", manifest.protocol.clone()),
        ("seed", manifest.seed.to_string()),
        ("suite", format!("{}: {present} of {} sequences, {frames} frames", suite.name, suite.wanted)),
        ("other suites", others.join(", ")),
        ("not as pinned", manifest.differing.join(", ")),
        ("trackers", kinds.collect::<Vec<_>>().join(", ")),
        ("cells", format!("{cells_done} done, {failed} without a result")),
        ("not checked", unnamed.join(", ")),
    ];
    let files = manifest.files.len();
    let mut text = format!("{}: ok, {files} files as manifest.json names them\n", path.display());
    for (what, value) in lines.iter().filter(|(_, value)| !value.is_empty()) {
        text += &format!("  {what:<15}{}\n", shorten_to(&visible(value), 200));
    }
    text
}
