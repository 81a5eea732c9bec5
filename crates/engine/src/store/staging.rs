//! Staging folders: results are written there first and then moved to their final place, file by file.
//!
//! The files of a results folder belong together. They are written into a staging folder first, so that a
//! full disk or a kill leaves the earlier results as they were. Then each file is renamed to its final place,
//! which needs no space and hardly any time. The file that marks the folder as complete (the manifest, the
//! page) is removed first and put back last. If the run is killed in between, the mark is missing, and the
//! next run makes the results again from the store.

use super::{StoreError, TEMPORARY, file};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use trackfail_dataset::leftover::{LOCK, TemporaryFolder, lock_of_left, remove};

/// A staging folder, removed when dropped. [`sweep`] removes those that a killed process left.
pub struct Staging(TemporaryFolder);

/// Age in seconds from which on a folder without a lock counts as abandoned.
const OLD: u64 = 3600;

impl Staging {
    /// Creates a folder in `parent`; `parent` is created if needed.
    ///
    /// # Errors
    /// When the folder cannot be created.
    pub fn new(parent: &Path) -> Result<Self, StoreError> {
        let fail = |e| StoreError::new(parent, e);
        std::fs::create_dir_all(parent).map_err(fail)?;
        TemporaryFolder::new_in(parent, TEMPORARY).map(Self).map_err(fail)
    }

    /// Path of the folder to write into.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Moves all files to `target`. The file `marker` comes last and marks the target as complete. Files in
    /// the folders `owned` of the target that were not written again are removed.
    ///
    /// # Errors
    /// When a file cannot be moved, or a folder belongs to another experiment. The target is then unchanged,
    /// unless the disk failed during the last renames; then it lacks `marker`.
    pub fn publish(self, target: &Path, marker: &str, owned: &[&str]) -> Result<(), StoreError> {
        let fail = |path: &Path, e: std::io::Error| StoreError::new(path, e);
        let files = files(self.path())?;
        for folder in owned {
            check_owned(&target.join(folder))?;
        }
        // First beside their places, where nothing refers to them: here a full disk or a missing permission shows.
        let mut moved = Moved(Vec::new());
        let mut folders = BTreeSet::from([target.to_path_buf()]);
        std::fs::create_dir_all(target).map_err(|e| fail(target, e))?;
        sweep(target);
        for folder in owned.iter().map(|folder| target.join(folder)).filter(|folder| folder.is_symlink()) {
            // Files would be written wherever the link leads.
            std::fs::remove_file(&folder).map_err(|e| fail(&folder, e))?;
        }
        for name in &files {
            let to = target.join(name);
            let folder = to.parent().unwrap_or(target);
            if folders.insert(folder.to_path_buf()) {
                std::fs::create_dir_all(folder).map_err(|e| fail(folder, e))?;
                sweep(folder);
            }
            let file = to.file_name().unwrap_or_default().to_string_lossy();
            let beside = folder.join(format!("{TEMPORARY}{file}"));
            std::fs::rename(self.path().join(name), &beside).map_err(|e| fail(&to, e))?;
            moved.0.push((beside, to));
        }
        let last = target.join(marker);
        match std::fs::remove_file(&last) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(fail(&last, e)),
            _ => file::sync_folder(target),
        }
        let (whole, parts): (Vec<_>, Vec<_>) = moved.0.iter().partition(|(_, to)| *to == last);
        for (beside, to) in parts {
            std::fs::rename(beside, to).map_err(|e| fail(to, e))?;
        }
        for folder in owned {
            remove_others(target, folder, &files)?;
        }
        folders.iter().for_each(|folder| file::sync_folder(folder));
        for (beside, to) in whole {
            std::fs::rename(beside, to).map_err(|e| fail(to, e))?;
        }
        file::sync_folder(target);
        Ok(())
    }
}

/// Files copied beside their final places. Those not yet renamed are removed on drop.
struct Moved(Vec<(PathBuf, PathBuf)>);

impl Drop for Moved {
    fn drop(&mut self) {
        self.0.iter().for_each(|(beside, _)| drop(std::fs::remove_file(beside)));
    }
}

/// Files in a folder and its subfolders, as sorted relative paths, without the lock.
fn files(folder: &Path) -> Result<BTreeSet<PathBuf>, StoreError> {
    let mut files = BTreeSet::new();
    for entry in walkdir::WalkDir::new(folder).min_depth(1) {
        let entry = entry.map_err(|e| StoreError::new(folder, e))?;
        if let Ok(name) = entry.path().strip_prefix(folder)
            && !entry.file_type().is_dir()
            && name != Path::new(LOCK)
        {
            files.insert(name.to_path_buf());
        }
    }
    Ok(files)
}

/// Refuses a folder that holds the results or the report of another experiment.
fn check_owned(folder: &Path) -> Result<(), StoreError> {
    if folder.is_symlink() || !folder.is_dir() {
        return Ok(());
    }
    let another = |name: &PathBuf| name.ends_with("manifest.json") || name.ends_with("index.html");
    match files(folder)?.into_iter().find(another) {
        Some(other) => {
            let what = format!(
                "belongs to another experiment ({}); rename one of the two",
                folder.join(other).display()
            );
            Err(StoreError::new(folder, what))
        }
        None => Ok(()),
    }
}

/// Removes the files in `target/folder` that are not in `kept`.
fn remove_others(target: &Path, folder: &str, kept: &BTreeSet<PathBuf>) -> Result<(), StoreError> {
    let path = target.join(folder);
    if !path.is_dir() {
        return Ok(());
    }
    for name in files(&path)?.iter().filter(|name| !kept.contains(&Path::new(folder).join(name))) {
        let stale = path.join(name);
        std::fs::remove_file(&stale).map_err(|e| StoreError::new(&stale, e))?;
        // Removes the folder too if it has become empty.
        let _ = stale.parent().map(std::fs::remove_dir);
    }
    Ok(())
}

/// Removes temporary files and folders in `parent` that no running process holds. A folder without a lock is
/// being created or removed; after an hour it counts as left by a killed process.
pub fn sweep(parent: &Path) {
    let is_old = |path: &Path| {
        let modified = path.symlink_metadata().and_then(|about| about.modified());
        modified.is_ok_and(|modified| modified.elapsed().is_ok_and(|age| age.as_secs() > OLD))
    };
    remove(parent, TEMPORARY, lock_of_left);
    remove(parent, TEMPORARY, |path| (!path.join(LOCK).exists() && is_old(path)).then_some(()));
    let Ok(entries) = std::fs::read_dir(parent) else { return };
    for path in entries.filter_map(|e| Some(e.ok()?.path())) {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        if name.starts_with(TEMPORARY.as_bytes()) && !path.is_dir() {
            let _ = std::fs::remove_file(&path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_whose_removal_was_killed_is_swept_when_it_is_old() {
        let dir = tempfile::tempdir().unwrap();
        // The lock was removed first.
        let [fresh, old] = ["fresh", "old"].map(|name| dir.path().join(format!("{TEMPORARY}{name}")));
        for folder in [&fresh, &old] {
            std::fs::create_dir(folder).unwrap();
            std::fs::write(folder.join("scores.csv"), "").unwrap();
        }
        let yesterday = std::time::SystemTime::now() - std::time::Duration::from_secs(86_400);
        std::fs::File::open(&old).unwrap().set_modified(yesterday).unwrap();
        sweep(dir.path());
        assert_eq!((fresh.exists(), old.exists()), (true, false));
    }

    #[test]
    fn files_take_their_places_and_stale_ones_are_removed() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("a");
        let write = |files: &[&str]| {
            let aside = Staging::new(&dir.path().join("aside")).unwrap();
            for name in files {
                file::write(&aside.path().join(name), name.as_bytes()).unwrap();
            }
            aside.publish(&target, "manifest.json", &["tables"])
        };
        write(&["manifest.json", "tables/old.csv", "scores.csv"]).unwrap();
        write(&["manifest.json", "tables/new.csv"]).unwrap();
        let names: Vec<_> = files(&target).unwrap().into_iter().collect();
        assert_eq!(names, ["manifest.json", "scores.csv", "tables/new.csv"].map(PathBuf::from));
        assert_eq!(files(&dir.path().join("aside")).unwrap().len(), 0);
        file::write(&target.join("tables/index.html"), b"of an experiment called tables").unwrap();
        trackfail_testing::assert_says(write(&["manifest.json"]).unwrap_err(), "another experiment");
        assert_eq!(std::fs::read_to_string(target.join("manifest.json")).unwrap(), "manifest.json");
        assert!(target.join("tables/new.csv").exists(), "the earlier results are as they were");
    }
}
