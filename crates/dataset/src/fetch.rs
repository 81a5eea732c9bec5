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
//! A sequence's folder is unpacked below `unpack-*`, flushed, given the file [`MARKER`] as its last one, and
//! renamed. Renaming is one step for the file system, so a folder under its final name is whole: with a marker
//! it was fetched, without one the user has put it there. Neither is ever touched again. The download is
//! removed after that; it is also removed when it turns out not to be the pinned file or to be refused.
//!
//! Nothing a server sends becomes part of a path except names of archive members that have been
//! checked, see [`MemberFault`]; only members that belong to a folder of `datasets.lock` are written at all.

mod address;
mod download;
mod error;
mod from_tar;
mod from_zip;
mod layout;
mod member;
mod part;
mod place;
mod plan;
mod sink;
mod unpack;

pub use download::{FetchWatch, Patience};
pub use error::FetchError;
pub use member::MemberFault;
pub use place::{MARKER, Placed, Workspace};
pub use plan::{FetchJob, FetchPlan, WantedSequences, plan};
pub use sink::Caps;

use crate::archive::{Archive, Packing};
use layout::{ArchiveLayout, entry_parts};
use std::path::Path;

/// Settings of [`fetch`].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FetchOptions {
    /// Start of the addresses that are asked instead of the pinned ones; the file name is appended.
    pub mirror: Option<String>,
    /// Patience with servers.
    pub patience: Patience,
    /// Limits of archives.
    pub caps: Caps,
}

/// A fetched archive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fetched {
    /// Bytes of the archive.
    pub size: u64,
    /// Its SHA-256 in hexadecimal.
    pub sha256: String,
    /// The folders or the file it was fetched for.
    pub placed: Placed,
}

/// Unpacks the members of an archive on disk that belong to `folders` into an empty folder.
///
/// # Errors
/// Any member that is refused, wanted or not; the caller then deletes the folder.
pub fn unpack(
    file: &Path,
    archive: &Archive,
    folders: &[String],
    caps: &Caps,
    into: &Path,
) -> Result<(), FetchError> {
    unpack::unpack(file, archive, &ArchiveLayout::new(archive, folders)?, caps, into)
}

/// Downloads an archive, unpacks it, and puts its folders in place.
///
/// # Errors
/// See [`FetchError`]. Nothing is left of an archive that is refused; the part of a download that was cut stays for
/// the next call.
pub fn fetch(
    space: &Workspace,
    job: &FetchJob,
    options: &FetchOptions,
    watch: &dyn FetchWatch,
) -> Result<Fetched, FetchError> {
    let archive = &job.archive;
    let fail =
        |reason| FetchError::Entry { archive: archive.name.clone(), name: archive.name.clone(), reason };
    if entry_parts(archive, &archive.name)?.len() != 1 {
        return Err(fail(MemberFault::Deep(1)));
    }
    let layout = ArchiveLayout::new(archive, &job.folders)?;
    let downloads = space.downloads();
    let got = download::download(&downloads, archive, options.mirror.as_deref(), &options.patience, watch)?;
    let temporary = space.temporary()?;
    let unpacked = unpack(&got.path, archive, &job.folders, &options.caps, temporary.path());
    if let Err(e) = unpacked {
        if e.is_data() {
            download::discard(&downloads, archive)?;
        }
        return Err(e);
    }
    let placed = match archive.packing {
        Packing::File => place::file(&got.path, space.root(), &layout.file(archive)?)?,
        Packing::Zip | Packing::TarGz => {
            let marker = format!("archive {}\nsha256 {}\nfrom {}\n", archive.name, got.sha256, got.url);
            place::folders(temporary.path(), space.root(), layout.folders(), &marker)?
        }
    };
    download::discard(&downloads, archive)?;
    Ok(Fetched { size: got.size, sha256: got.sha256, placed })
}
