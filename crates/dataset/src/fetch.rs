//! Downloads of datasets, and their unpacking to where the suites look for them.
//!
//! Everything happens in `<data root>/.trackfail` until it is whole:
//!
//! | file | content |
//! |---|---|
//! | `lock` | held by the one process that fetches |
//! | `downloads/<archive>.part`, `.json` | a download and its state, from which it goes on after a cut |
//! | `unpack-*` | an archive that is being unpacked; the next fetch removes what a killed one left |
//! | `licence-<suite>` | the licence text that was agreed to |
//!
//! A sequence's folder is unpacked below `unpack-*`, compared with what is pinned of it, flushed, given the
//! file [`MARKER`] as its last one, and renamed. Renaming is one step for the file system, so a folder under
//! its final name is whole: with a marker it was fetched, without one the user has put it there. Both are
//! left alone. Only on request is a fetched folder that is not as pinned fetched again; the old folder is
//! moved away first. The download is removed afterwards, also if it is not the pinned file or is refused.
//!
//! Nothing a server sends becomes part of a path except names of archive members that have been
//! checked, see [`unpack()`]; only members that belong to a folder of a suite are written at all. Names of the built-in
//! lists are checked by a test.

mod download;
mod part;
mod place;
mod plan;
mod unpack;

pub use download::{Patience, Told};
pub use place::{MARKER, Placed, Workspace};
pub use plan::{FetchJob, FetchPlan, WantedSequences, plan};
pub use unpack::{Caps, unpack};

use crate::archive::Packing;
use crate::lock::pinned_suites;
use crate::suite::Finding;
use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Reason why a download or an archive failed.
#[derive(Debug, thiserror::Error)]
pub enum FetchError {
    /// An address that is malformed or neither http nor https.
    #[error("{0}; only complete http:// and https:// addresses are fetched")]
    Address(String),
    /// No connection, or one that breaks again and again.
    #[error("{0}")]
    Network(String),
    /// Data that are absent at the address, not as pinned, damaged or hostile.
    #[error("{0}")]
    Data(String),
    /// An I/O error.
    #[error("{0}")]
    Disk(String),
    /// Another process fetches into the data root; the path is its lock file.
    #[error("{}: another fetch is using this data root; wait until it has ended", .0.display())]
    Busy(PathBuf),
}

impl FetchError {
    fn disk(path: &Path, e: std::io::Error) -> Self {
        let advice = match e.kind() {
            ErrorKind::CrossesDevices => {
                "its folder is a link to another file system; give that one as the data root"
            }
            _ => "make room and check that the folder can be written to",
        };
        Self::Disk(format!("{}: {e}; {advice}", path.display()))
    }

    /// True if the data at the address are absent or not as pinned; false if the disk, the network or the
    /// arguments are at fault.
    pub fn is_data(&self) -> bool {
        matches!(self, Self::Data(_))
    }
}

/// Result of a download or of what comes after it.
type Result<T, E = FetchError> = std::result::Result<T, E>;

/// Settings of [`fetch`].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FetchOptions {
    /// Address that replaces the folder part of the pinned addresses; the file name is appended. `None` for
    /// the pinned ones.
    pub mirror: Option<String>,
    /// Timeouts and retries.
    pub patience: Patience,
    /// Limits on what archives unpack to.
    pub caps: Caps,
}

/// An archive that was downloaded and unpacked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fetched {
    /// Size of the archive in bytes.
    pub size: u64,
    /// SHA-256 of the archive in hexadecimal.
    pub sha256: String,
    /// Folders, or the single file, that came from the archive.
    pub placed: Placed,
}

/// Folders below `root` that differ from what is pinned, each with its first difference. A folder whose
/// sequence has a part in another download is not compared yet.
fn not_as_pinned(folders: &[String], root: &Path) -> Vec<(String, String)> {
    let roots = [root.to_path_buf()];
    let mut found: Vec<(String, String)> = Vec::new();
    for suite in pinned_suites() {
        for entry in suite.sequence.iter().filter(|entry| folders.contains(&entry.folder)) {
            if found.iter().any(|(folder, _)| *folder == entry.folder) {
                continue;
            }
            let difference = match suite.check(entry, &roots) {
                Finding::Differs(fact) => fact.replace(&root.display().to_string(), "..."),
                Finding::Missing(missing) if entry.truth_archive.is_none() => missing.how_to_get,
                Finding::Same | Finding::NoDigestPinned | Finding::Missing(_) => continue,
            };
            found.push((entry.folder.clone(), format!("{}/{}: {difference}", suite.name, entry.name)));
        }
    }
    found
}

/// Downloads an archive, unpacks it, and moves the folders that are as pinned to their final place.
///
/// # Errors
/// See [`FetchError`]. A refused archive leaves nothing behind; the bytes of an interrupted download stay for
/// the next call.
pub fn fetch(
    space: &Workspace,
    job: &FetchJob,
    options: &FetchOptions,
    watch: &dyn Fn(Told<'_>),
) -> Result<Fetched> {
    let archive = &job.archive;
    let downloads = space.downloads();
    let got = download::download(&downloads, archive, options.mirror.as_deref(), &options.patience, watch)?;
    let placed = match archive.packing {
        Packing::File => {
            let name = unpack::single_file(archive)?;
            let opened = File::open(&got.path).map_err(|e| FetchError::disk(&got.path, e));
            if unpack::is_page(&mut opened?) {
                download::discard(&downloads, archive)?;
                let told =
                    format!("archive {}: a web page and not {name}; nothing of it is kept", archive.name);
                return Err(FetchError::Data(told));
            }
            place::file(&got.path, space.root(), &name)?
        }
        Packing::Zip => {
            let temporary = space.temporary()?;
            let unpacked = unpack(&got.path, archive, &job.folders, &options.caps, temporary.path());
            if unpacked.as_ref().is_err_and(FetchError::is_data) {
                download::discard(&downloads, archive)?;
            }
            unpacked?;
            let refused = not_as_pinned(&job.folders, temporary.path());
            let is_good = |folder: &&String| !refused.iter().any(|(bad, _)| bad == *folder);
            let good: Vec<&String> = job.folders.iter().filter(is_good).collect();
            let marker = format!("archive {}\nsha256 {}\nfrom {}\n", archive.name, got.sha256, got.url);
            let placed = place::folders(temporary.path(), space.root(), &good, &job.again, &marker)?;
            Placed { refused, ..placed }
        }
    };
    download::discard(&downloads, archive)?;
    Ok(Fetched { size: got.size, sha256: got.sha256, placed })
}
