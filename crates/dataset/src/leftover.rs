//! Temporary folders, and the removal of those that killed processes left behind.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Name of the file in a temporary folder that its process holds a lock on.
pub const LOCK: &str = "trackfail.lock";

/// A temporary folder, deleted when the value is dropped. If the process is killed, the next process that
/// creates such a folder there deletes it.
#[derive(Debug)]
pub struct TemporaryFolder {
    folder: TempDir,
    _lock: File,
}

impl TemporaryFolder {
    /// Creates a folder in `parent`, empty but for the file [`LOCK`], whose name starts with `prefix`. Folders of
    /// the prefix that killed processes left are deleted; those without a lock file are not touched.
    ///
    /// # Errors
    /// When the folder cannot be created.
    pub fn new_in(parent: &Path, prefix: &str) -> std::io::Result<Self> {
        remove(parent, prefix, lock_of_left);
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

    /// Path of the folder, which is closed to other users.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Creates a folder within, which others may read as they may any other, to be moved to its place.
    ///
    /// # Errors
    /// When the folder cannot be created.
    pub fn within(&self, name: &str) -> std::io::Result<PathBuf> {
        let folder = self.path().join(name);
        std::fs::create_dir(&folder).map(|()| folder)
    }
}

/// The lock of a folder, if it has a lock file that no process held.
pub fn lock_of_left(folder: &Path) -> Option<File> {
    let lock = folder.join(LOCK);
    // A pipe would be waited for, and a link may lead anywhere.
    lock.symlink_metadata().ok().filter(|about| about.is_file())?;
    let lock = File::options().write(true).open(lock).ok()?;
    lock.try_lock().ok().map(|()| lock)
}

/// Removes folders in `parent` whose names start with `prefix`, if `left` accepts them. What it returns, such
/// as a lock, is held until the folder is removed.
pub fn remove<T>(parent: &Path, prefix: &str, left: impl Fn(&Path) -> Option<T>) {
    let Ok(entries) = std::fs::read_dir(parent) else { return };
    for path in entries.filter_map(|e| Some(e.ok()?.path())) {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        if name.starts_with(prefix.as_bytes())
            && path.is_dir()
            && let Some(_held) = left(&path)
        {
            // Another process may be removing it too.
            let _ = std::fs::remove_dir_all(&path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_testing::put;

    #[test]
    fn a_lock_is_held_until_the_folder_is_gone() {
        struct Held(PathBuf);
        impl Drop for Held {
            fn drop(&mut self) {
                assert!(!self.0.exists());
            }
        }
        let root = tempfile::tempdir().unwrap();
        put(root.path(), "frames-a/a", "");
        put(root.path(), "others/a", "");
        remove(root.path(), "frames-", |folder| Some(Held(folder.to_path_buf())));
        assert!(!root.path().join("frames-a").exists() && root.path().join("others").exists());
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
