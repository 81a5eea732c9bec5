//! Files that the user names: pages, figures, videos, tracks.

use std::path::Path;
use trackfail_engine::store::{self, StoreError};

/// Writes a file. A regular or new one is replaced atomically; a device, a pipe or a link is opened and
/// written to, and keeps its kind. Folders are not created.
///
/// # Errors
/// When the folder does not exist, or the file cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    check_folder(path)?;
    match std::fs::symlink_metadata(path) {
        Ok(about) if !about.is_file() => std::fs::write(path, bytes).map_err(|e| StoreError::new(path, e)),
        _ => store::write(path, bytes),
    }
}

/// Checks that the folder of a file exists.
///
/// # Errors
/// When it does not exist.
pub fn check_folder(path: &Path) -> Result<(), StoreError> {
    let folder = store::folder_of(path);
    if folder.is_dir() {
        return Ok(());
    }
    Err(StoreError::new(path, format!("there is no folder {}; make it first", folder.display())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn links_pipes_and_devices_stay_what_they_are() {
        use std::os::unix::fs::{FileTypeExt, PermissionsExt};
        let dir = tempfile::tempdir().unwrap();
        let [file, link, pipe] = ["file", "link", "pipe"].map(|name| dir.path().join(name));
        std::fs::write(&file, "a longer text").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write(&link, b"new").unwrap();
        assert!(write(dir.path(), b"x").is_err());
        assert!(link.is_symlink());
        assert_eq!(store::read_text(&file).unwrap(), "new");
        // A file that was there keeps its permissions.
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
        write(&file, b"private").unwrap();
        assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
        // A link that leads nowhere yet leads to the new file.
        std::fs::remove_file(&file).unwrap();
        write(&link, b"again").unwrap();
        assert!(link.is_symlink());
        assert_eq!(store::read_text(&file).unwrap(), "again");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read(pipe).unwrap()
        });
        write(&pipe, b"through").unwrap();
        assert_eq!(reader.join().unwrap(), b"through");
        assert!(std::fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
        write(Path::new("/dev/null"), b"gone").unwrap();
        assert!(std::fs::symlink_metadata("/dev/null").unwrap().file_type().is_char_device());
    }
}
