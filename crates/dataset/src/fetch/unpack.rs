//! Unpacks an archive into an empty folder.

use super::error::{FetchError, shown};
use super::layout::{ArchiveLayout, join};
use super::sink::{Caps, Sink};
use super::{from_tar, from_zip};
use crate::archive::{Archive, Packing};
use std::fs::File;
use std::path::Path;

/// Unpacks the wanted members of the archive in `file` into the empty folder `into`.
///
/// # Errors
/// Any member that is refused, wanted or not; the caller then deletes the folder.
pub(super) fn unpack(
    file: &Path,
    archive: &Archive,
    layout: &ArchiveLayout,
    caps: &Caps,
    into: &Path,
) -> Result<(), FetchError> {
    let open = || File::open(file).map_err(|e| FetchError::disk(file, e));
    let packed = open()?.metadata().map_err(|e| FetchError::disk(file, e))?.len();
    let mut sink = Sink::new(archive, layout, caps, into, packed);
    match archive.packing {
        Packing::Zip => from_zip::unpack(open()?, &mut sink)?,
        Packing::TarGz => from_tar::unpack(open()?, &mut sink)?,
        Packing::File => return Ok(()),
    }
    for folder in layout.folders() {
        if !join(into, folder).is_dir() {
            let found = sink.tops().take(5).map(shown).collect();
            let (archive, folder) = (archive.name.clone(), folder.join("/"));
            return Err(FetchError::NoFolder { archive, folder, found });
        }
    }
    Ok(())
}
