//! The working folder `.trackfail` of a data root, and the moves of unpacked folders from there to their
//! final place.

use super::{FetchError, Result};
use crate::leftover;
use crate::lock::below;
use rayon::prelude::*;
use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Name of the marker file in a fetched folder; the file names the archive. Readers of sequences ignore it.
pub const MARKER: &str = ".trackfail-complete";

/// Prefix of folders in which archives are being unpacked.
const UNPACK: &str = "unpack-";

/// A data root that is locked, so that this process alone fetches into it.
#[derive(Debug)]
pub struct Workspace {
    root: PathBuf,
    folder: PathBuf,
    // Held, and given back by the system however the process ends.
    lock: File,
}

impl Drop for Workspace {
    fn drop(&mut self) {
        // A program that was started at this moment has the file open too, until it takes the child's place;
        // closing it here alone would not give it back.
        let _ = self.lock.unlock();
    }
}

impl Workspace {
    /// Locks a data root and removes what a killed fetch left half unpacked.
    ///
    /// # Errors
    /// [`FetchError::Busy`] while another process fetches; [`FetchError::Disk`] on I/O errors.
    pub fn open(root: &Path) -> Result<Self> {
        let folder = root.join(".trackfail");
        let downloads = folder.join("downloads");
        fs::create_dir_all(&downloads).map_err(|e| FetchError::disk(&downloads, e))?;
        let path = folder.join("lock");
        let lock = File::create(&path).map_err(|e| FetchError::disk(&path, e))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(FetchError::Busy(path)),
            Err(TryLockError::Error(e)) => return Err(FetchError::disk(&path, e)),
        }
        leftover::remove(&folder, UNPACK, |_| Some(()));
        Ok(Self { root: root.into(), folder, lock })
    }

    /// The data root.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Folder of the downloads, complete or not.
    pub fn downloads(&self) -> PathBuf {
        self.folder.join("downloads")
    }

    /// True if the user has agreed to exactly this licence text for the suite.
    pub fn agreed(&self, suite: &str, text: &str) -> bool {
        fs::read(self.agreement(suite)).is_ok_and(|old| old == text.as_bytes())
    }

    /// Records that the user agreed to a licence text for a suite.
    ///
    /// # Errors
    /// [`FetchError::Disk`] if the record cannot be written.
    pub fn remember(&self, suite: &str, text: &str) -> Result<()> {
        let path = self.agreement(suite);
        fs::write(&path, text).map_err(|e| FetchError::disk(&path, e))
    }

    fn agreement(&self, suite: &str) -> PathBuf {
        self.folder.join(format!("licence-{suite}"))
    }

    /// Creates a folder in the file system of the data root. It is removed when the value is dropped.
    pub(super) fn temporary(&self) -> Result<TempDir> {
        let made = tempfile::Builder::new().prefix(UNPACK).tempdir_in(&self.folder);
        made.map_err(|e| FetchError::disk(&self.folder, e))
    }
}

/// The folders, or the single file, of an archive, sorted by what happened to them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Placed {
    /// Folders or file placed where nothing was before.
    pub new: Vec<String>,
    /// Folders or file that were present before and were not changed.
    pub kept: Vec<String>,
    /// Folders or file placed instead of those of an earlier fetch.
    pub replaced: Vec<String>,
    /// Replaced folders that had files of their own, each with the folder that the old files were moved to.
    pub moved: Vec<(String, PathBuf)>,
    /// Folders that are not as pinned and were not placed, each with its first difference.
    pub refused: Vec<(String, String)>,
}

/// True if a folder was put in its place by a fetch.
pub(super) fn was_fetched(folder: &Path) -> bool {
    folder.join(MARKER).is_file()
}

/// Moves complete folders to their final place and adds the marker to each. Folders in `again` replace those
/// of an earlier fetch. An old folder with files that the new one lacks is kept beside it: those files may be
/// the user's.
pub(super) fn folders(
    from: &Path,
    root: &Path,
    folders: &[&String],
    again: &[String],
    marker: &str,
) -> Result<Placed> {
    let mut placed = Placed::default();
    for name in folders.iter().copied() {
        let (source, target) = (below(from, name), below(root, name));
        let is_there = fs::symlink_metadata(&target).is_ok();
        let replaces = is_there && again.contains(name) && was_fetched(&target);
        if is_there && !replaces {
            placed.kept.push(name.clone());
            continue;
        }
        settle(&source)?;
        let path = source.join(MARKER);
        let written = File::create_new(&path).and_then(|mut file| {
            file.write_all(marker.as_bytes())?;
            file.sync_all()
        });
        written.map_err(|e| FetchError::disk(&path, e))?;
        if replaces {
            let is_kept = has_more(&target, &source)?;
            // What is not kept goes with the folder of what was unpacked.
            let aside = if is_kept { free_name(&target) } else { beside(&source, ".trackfail-old") };
            rename(&target, &aside)?;
            if let Err(e) = rename(&source, &target) {
                // What was there before is better than nothing.
                let _ = fs::rename(&aside, &target);
                return Err(e);
            }
            placed.moved.extend(is_kept.then(|| (name.clone(), aside)));
            placed.replaced.push(name.clone());
        } else {
            rename(&source, &target)?;
            placed.new.push(name.clone());
        }
    }
    Ok(placed)
}

/// True if a folder has a file that the other one lacks.
fn has_more(folder: &Path, other: &Path) -> Result<bool> {
    for entry in walkdir::WalkDir::new(folder) {
        let entry = entry.map_err(|e| FetchError::disk(folder, e.into()))?;
        let Ok(inside) = entry.path().strip_prefix(folder) else { continue };
        if !entry.file_type().is_dir() && fs::symlink_metadata(other.join(inside)).is_err() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Path of a folder with `end` appended to its name.
fn beside(folder: &Path, end: &str) -> PathBuf {
    let mut name = folder.file_name().unwrap_or_default().to_os_string();
    name.push(end);
    folder.with_file_name(name)
}

/// First free name among `NAME.replaced-1`, `NAME.replaced-2` and so on beside a folder.
fn free_name(folder: &Path) -> PathBuf {
    let name = |n: usize| beside(folder, &format!(".replaced-{n}"));
    let mut n = 1;
    while fs::symlink_metadata(name(n)).is_ok() {
        n += 1;
    }
    name(n)
}

/// Moves a single file to its final place.
pub(super) fn file(source: &Path, root: &Path, name: &str) -> Result<Placed> {
    let (target, name) = (below(root, name), name.to_owned());
    if fs::symlink_metadata(&target).is_ok() {
        return Ok(Placed { kept: vec![name], ..Placed::default() });
    }
    settle(source)?;
    rename(source, &target)?;
    Ok(Placed { new: vec![name], ..Placed::default() })
}

/// Flushes all files of a folder to disk, before its final name says that it is complete.
fn settle(folder: &Path) -> Result<()> {
    let listed: Result<Vec<_>, _> = walkdir::WalkDir::new(folder).into_iter().collect();
    let listed = listed.map_err(|e| FetchError::disk(folder, e.into()))?;
    listed.par_iter().try_for_each(|entry| {
        let (path, is_folder) = (entry.path(), entry.file_type().is_dir());
        match File::open(path).and_then(|file| file.sync_all()) {
            // Not every system can do that for folders.
            Err(e) if !is_folder => Err(FetchError::disk(path, e)),
            _ => Ok(()),
        }
    })
}

fn rename(source: &Path, target: &Path) -> Result<()> {
    let Some(parent) = target.parent() else { return Ok(()) };
    fs::create_dir_all(parent).map_err(|e| FetchError::disk(parent, e))?;
    fs::rename(source, target).map_err(|e| FetchError::disk(target, e))?;
    // It is only durable once the folder is; not every file system can do that.
    let _ = File::open(parent).and_then(|parent| parent.sync_all());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    // The old folders are put aside under names of their own, whatever dots are in them.
    #[test]
    fn folders_that_differ_behind_a_dot_are_all_replaced() {
        let root = tempfile::tempdir().unwrap();
        let (from, to) = (root.path().join("from"), root.path().join("to"));
        let names = ["otb/a.1", "otb/a.2"].map(String::from);
        for (place, text) in [(&from, "new"), (&to, "old")] {
            for folder in names.iter().map(|name| below(place, name)) {
                fs::create_dir_all(&folder).unwrap();
                fs::write(folder.join("1.jpg"), text).unwrap();
            }
        }
        names.iter().for_each(|name| fs::write(below(&to, name).join(MARKER), "").unwrap());
        let placed = folders(&from, &to, &names.each_ref(), &names, "").unwrap();
        assert_eq!((placed.replaced, placed.moved), (names.to_vec(), Vec::new()));
        assert!(names.iter().all(|name| fs::read(below(&to, name).join("1.jpg")).unwrap() == b"new"));
    }
}
