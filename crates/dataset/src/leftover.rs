//! Temporary folders that killed processes have left behind.

use std::path::Path;

/// Age in seconds from which on nobody is still at work in a folder.
const OLD: u64 = 3600;

/// Removes the folders in `parent` whose names start with `prefix`, if nothing has been put into them for an hour.
pub fn sweep(parent: &Path, prefix: &str) {
    let Ok(entries) = std::fs::read_dir(parent) else { return };
    for path in entries.filter_map(|e| Some(e.ok()?.path())) {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        if name.starts_with(prefix.as_bytes()) && path.is_dir() && is_old(&path) {
            // Another process may be removing it too.
            let _ = std::fs::remove_dir_all(&path);
        }
    }
}

/// Whether a folder is old enough to be a killed process's, not one that is just being filled or removed.
pub fn is_old(path: &Path) -> bool {
    let modified = path.symlink_metadata().and_then(|about| about.modified());
    modified.is_ok_and(|modified| modified.elapsed().is_ok_and(|age| age.as_secs() > OLD))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;
    use std::time::{Duration, SystemTime};

    #[test]
    fn old_folders_of_the_prefix_are_removed() {
        let root = tempfile::tempdir().unwrap();
        for (name, age) in [(".work-a", 0), (".work-b", 2), (".other", 2)] {
            let folder = root.path().join(name);
            std::fs::create_dir(&folder).unwrap();
            std::fs::write(folder.join("a"), "").unwrap();
            let time = SystemTime::now() - Duration::from_secs(age * OLD);
            File::open(&folder).unwrap().set_modified(time).unwrap();
        }
        sweep(root.path(), ".work-");
        let left = [".work-a", ".work-b", ".other"].map(|name| root.path().join(name).exists());
        assert_eq!(left, [true, false, true]);
    }
}
