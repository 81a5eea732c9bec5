//! Files that the user names: pages, figures, videos, tracks.

use std::path::Path;
use trackfail_engine::store::{self, StoreError};

/// Writes a file: a regular or new one is replaced atomically; a device, a pipe or a link is opened and written to, and
/// stays what it is. No folder is made.
///
/// # Errors
/// When there is no such folder, or the file cannot be written to.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    check_folder(path)?;
    match std::fs::symlink_metadata(path) {
        Ok(about) if !about.is_file() => std::fs::write(path, bytes).map_err(|e| StoreError::new(path, e)),
        _ => store::write(path, bytes),
    }
}

/// Checks that there is a folder for a file.
///
/// # Errors
/// When there is none.
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

    #[test]
    fn no_folder_is_made_for_an_output() {
        let dir = tempfile::tempdir().unwrap();
        let message = write(&dir.path().join("none/a.txt"), b"x").unwrap_err().to_string();
        assert!(message.contains("there is no folder") && message.contains("make it first"), "{message}");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
        assert!(write(dir.path(), b"x").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_pipes_and_devices_stay_what_they_are() {
        use std::os::unix::fs::{FileTypeExt, PermissionsExt};
        let dir = tempfile::tempdir().unwrap();
        let [file, link, pipe] = ["file", "link", "pipe"].map(|name| dir.path().join(name));
        std::fs::write(&file, "a longer text").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write(&link, b"new").unwrap();
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
