//! Folders that are put together aside and then take their place file by file.
//!
//! A results folder has files that belong together. They are written into a folder of their own first, so
//! that a full disk or a kill leaves the earlier results as they were; then each is renamed into its
//! place, which needs no space and hardly any time. The file that says that the folder is whole (the
//! manifest, the page) is taken away first and put back last: who is killed just then has results that
//! say they are not whole, and the next run makes them from the store.

use super::{StoreError, TEMPORARY, file};
use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};

/// A folder aside. It is removed when dropped; what a killed process left is removed by [`sweep`].
pub struct Staging {
    folder: PathBuf,
    /// Held as long as the folder is in use.
    _lock: File,
}

impl Drop for Staging {
    fn drop(&mut self) {
        // What cannot be removed now is swept by a later run.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Name of the lock inside a staging folder.
const LOCK: &str = ".lock";
/// A staging folder that has no lock yet starts like this.
const FRESH: &str = ".trackfail-new-";

impl Staging {
    /// A new folder below `parent`, which is made if need be.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn new(parent: &Path) -> Result<Self, StoreError> {
        let fail = |e| StoreError::new(parent, e);
        std::fs::create_dir_all(parent).map_err(fail)?;
        // It takes the name that `sweep` looks for when it is locked already, so that no other process
        // can take it for abandoned.
        let fresh = tempfile::Builder::new().prefix(FRESH).tempdir_in(parent).map_err(fail)?.keep();
        let lock = File::create(fresh.join(LOCK)).map_err(fail)?;
        // Where there are no locks, nothing is swept either.
        let _ = lock.try_lock();
        let name = fresh.file_name().unwrap_or_default().to_string_lossy().replacen(FRESH, TEMPORARY, 1);
        let folder = parent.join(name);
        std::fs::rename(&fresh, &folder).map_err(fail)?;
        Ok(Self { folder, _lock: lock })
    }

    /// Where to write.
    pub fn path(&self) -> &Path {
        &self.folder
    }

    /// Moves all files to `target`. `whole` names the file that comes last; files in the folders `owned`
    /// of the target that were not written anew are removed.
    ///
    /// # Errors
    /// When a file cannot be moved there, or a folder belongs to another experiment; the target is then as
    /// it was, unless the disk failed within the last renames: then it lacks `whole`.
    pub fn publish(self, target: &Path, whole: &str, owned: &[&str]) -> Result<(), StoreError> {
        let fail = |path: &Path, e: std::io::Error| StoreError::new(path, e);
        let files = files(self.path())?;
        for folder in owned {
            check_owned(&target.join(folder))?;
        }
        // First beside their places, where nothing refers to them; whatever can go wrong goes wrong here.
        let mut moved = Moved(Vec::new());
        let mut folders = BTreeSet::from([target.to_path_buf()]);
        std::fs::create_dir_all(target).map_err(|e| fail(target, e))?;
        sweep(target);
        for folder in owned.iter().map(|folder| target.join(folder)).filter(|folder| folder.is_symlink()) {
            // Files would go wherever it leads.
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
        let last = target.join(whole);
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

/// Files beside their places; what is not in its place in the end is removed.
struct Moved(Vec<(PathBuf, PathBuf)>);

impl Drop for Moved {
    fn drop(&mut self) {
        self.0.iter().for_each(|(beside, _)| drop(std::fs::remove_file(beside)));
    }
}

/// The files below a folder, relative to it, sorted; without the lock.
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

/// Experiments may lie below each other; a folder with another one's results or report is not ours.
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

/// Removes what is in `target/folder` but not among `kept`.
fn remove_others(target: &Path, folder: &str, kept: &BTreeSet<PathBuf>) -> Result<(), StoreError> {
    let path = target.join(folder);
    if !path.is_dir() {
        return Ok(());
    }
    for name in files(&path)?.iter().filter(|name| !kept.contains(&Path::new(folder).join(name))) {
        let stale = path.join(name);
        std::fs::remove_file(&stale).map_err(|e| StoreError::new(&stale, e))?;
        // A folder that has become empty goes too; one that has not, stays.
        let _ = stale.parent().map(std::fs::remove_dir);
    }
    Ok(())
}

/// Removes temporary files and folders below `parent` that no running process holds.
pub fn sweep(parent: &Path) {
    let Ok(entries) = std::fs::read_dir(parent) else { return };
    for path in entries.filter_map(|e| Some(e.ok()?.path())) {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        if name.starts_with(FRESH.as_bytes()) && is_old(&path) {
            let _ = std::fs::remove_dir_all(&path);
        }
        if !name.starts_with(TEMPORARY.as_bytes()) {
            continue;
        }
        if path.is_dir() {
            let free = File::open(path.join(LOCK)).is_ok_and(|lock| lock.try_lock().is_ok());
            if free {
                let _ = std::fs::remove_dir_all(&path);
            }
        } else {
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// Whether a folder without a lock was left by a killed process, and is not being made right now.
fn is_old(path: &Path) -> bool {
    let made = path.metadata().and_then(|about| about.modified());
    made.is_ok_and(|made| made.elapsed().is_ok_and(|age| age.as_secs() > 3600))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_take_their_places_and_stale_ones_go() {
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
        let refused = write(&["manifest.json"]).unwrap_err().to_string();
        assert!(refused.contains("another experiment"), "{refused}");
        assert_eq!(std::fs::read_to_string(target.join("manifest.json")).unwrap(), "manifest.json");
        assert!(target.join("tables/new.csv").exists(), "what was there is as it was");
    }
}
