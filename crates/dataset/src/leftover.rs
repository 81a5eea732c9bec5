//! Temporary folders, and the removal of those that killed processes left behind.

use std::fs::{File, TryLockError};
use std::path::Path;
use tempfile::TempDir;

/// Age in seconds from which on a folder counts as abandoned.
const OLD: u64 = 3600;

/// Name of the file in a temporary folder that its process holds a lock on. Folders without it are not
/// touched.
const LOCK: &str = "trackfail.lock";

/// A folder in the system's temporary folder, deleted when the value is dropped. If the process is killed,
/// the next process that creates such a folder deletes it.
#[derive(Debug)]
pub struct TemporaryFolder {
    folder: TempDir,
    _lock: File,
}

impl TemporaryFolder {
    /// Creates a folder, empty but for its lock file, whose name starts with `prefix`. Folders of the prefix
    /// that killed processes left are deleted.
    ///
    /// # Errors
    /// When the folder cannot be created.
    pub fn new(prefix: &str) -> std::io::Result<Self> {
        Self::new_in(&std::env::temp_dir(), prefix)
    }

    fn new_in(parent: &Path, prefix: &str) -> std::io::Result<Self> {
        remove(parent, prefix, is_free);
        loop {
            let folder = tempfile::Builder::new().prefix(prefix).tempdir_in(parent)?;
            let path = folder.path().join(LOCK);
            let lock = File::create(&path)?;
            // Before it was locked, another process may have taken it for left behind. Where there are no locks, none is.
            if !matches!(lock.try_lock(), Err(TryLockError::WouldBlock)) && path.exists() {
                return Ok(Self { folder, _lock: lock });
            }
        }
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// True if a folder has a lock file that no process holds.
fn is_free(folder: &Path) -> bool {
    let lock = folder.join(LOCK);
    // A pipe would be waited for, and a link may lead anywhere.
    lock.symlink_metadata().is_ok_and(|about| about.is_file())
        && File::options().write(true).open(lock).is_ok_and(|lock| lock.try_lock().is_ok())
}

/// Removes folders in `parent` whose names start with `prefix`, if nothing was put into them for an hour.
pub fn sweep(parent: &Path, prefix: &str) {
    remove(parent, prefix, is_old);
}

/// Removes folders in `parent` whose names start with `prefix`, if `is_left` accepts them.
pub(crate) fn remove(parent: &Path, prefix: &str, is_left: impl Fn(&Path) -> bool) {
    let Ok(entries) = std::fs::read_dir(parent) else { return };
    for path in entries.filter_map(|e| Some(e.ok()?.path())) {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        if name.starts_with(prefix.as_bytes()) && path.is_dir() && is_left(&path) {
            // Another process may be removing it too.
            let _ = std::fs::remove_dir_all(&path);
        }
    }
}

/// True if a folder is so old that its process must have been killed; a newer one may still be filled or
/// removed by a running process.
pub fn is_old(path: &Path) -> bool {
    let modified = path.symlink_metadata().and_then(|about| about.modified());
    modified.is_ok_and(|modified| modified.elapsed().is_ok_and(|age| age.as_secs() > OLD))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, SystemTime};
    use trackfail_testing::put;

    #[test]
    fn old_folders_of_the_prefix_are_removed() {
        let root = tempfile::tempdir().unwrap();
        for (name, age) in [(".work-a", 0), (".work-b", 2), (".other", 2)] {
            put(root.path(), format!("{name}/a"), "");
            let time = SystemTime::now() - Duration::from_secs(age * OLD);
            File::open(root.path().join(name)).unwrap().set_modified(time).unwrap();
        }
        sweep(root.path(), ".work-");
        let left = [".work-a", ".work-b", ".other"].map(|name| root.path().join(name).exists());
        assert_eq!(left, [true, false, true]);
    }

    #[test]
    fn temporary_folders_that_nobody_holds_are_removed() {
        let root = tempfile::tempdir().unwrap();
        let new = || TemporaryFolder::new_in(root.path(), "frames-").unwrap();
        let held = new();
        // A killed process holds no lock; a folder of the user's has none.
        let names = ["frames-killed", "frames-of-mine", "others"].map(|name| root.path().join(name));
        for (folder, file) in [(0, "000001.png"), (1, "000001.png"), (2, "000001.png"), (0, LOCK), (2, LOCK)]
        {
            put(&names[folder], file, "");
        }
        let other = new();
        assert_eq!(names.each_ref().map(|name| name.exists()), [false, true, true]);
        let paths = [&held, &other].map(|folder| folder.path().to_path_buf());
        assert!(paths.iter().all(|path| path.is_dir()));
        drop((held, other));
        assert!(paths.iter().all(|path| !path.exists()));
    }
}
