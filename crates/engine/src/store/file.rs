//! Files that are written whole: first beside their target, then renamed.

use super::{StoreError, TEMPORARY};
use std::io::Write;
use std::path::Path;
use tempfile::NamedTempFile;

/// Replaces a file atomically: readers see the old or the new content, never a mixture. The new file has the
/// permissions of the old one.
///
/// # Errors
/// When the folder cannot be created or written to.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    write_with(path, |file| file.write_all(bytes).map_err(|e| StoreError::new(path, e)))
}

/// Replaces a file atomically, like [`write()`], without waiting for the disk. For files that can be made
/// again, such as a report.
///
/// # Errors
/// When the folder cannot be created or written to.
pub fn write_derived(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let fail = |e| StoreError::new(path, e);
    let mut file = temporary_for(path).map_err(fail)?;
    file.write_all(bytes).map_err(fail)?;
    file.persist(path).map(drop).map_err(|e| fail(e.error))
}

/// Replaces a file atomically by the output of `fill`, for content that is too large for memory.
///
/// # Errors
/// When the folder cannot be created or written to, and the errors of `fill`.
pub fn write_with<E: From<StoreError>>(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let fail = |e| StoreError::new(path, e);
    let mut file = temporary_for(path).map_err(fail)?;
    fill(&mut file)?;
    file.as_file().sync_all().map_err(fail)?;
    file.persist(path).map_err(|e| fail(e.error))?;
    sync_folder(folder_of(path));
    Ok(())
}

/// Folder of a file; the current folder for a plain file name.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Creates a temporary file beside a path, with its folder if needed. It gets the permissions of the file
/// that it will replace, or those of a new file by the umask; temporary files would be private otherwise.
fn temporary_for(path: &Path) -> std::io::Result<NamedTempFile> {
    let folder = folder_of(path);
    std::fs::create_dir_all(folder)?;
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.prefix(TEMPORARY).tempfile_in(folder)?;
    if let Ok(about) = std::fs::symlink_metadata(path)
        && about.is_file()
    {
        file.as_file().set_permissions(about.permissions())?;
    }
    Ok(file)
}

/// Makes renames in a folder durable, if the file system supports that.
pub(super) fn sync_folder(folder: &Path) {
    if let Ok(folder) = std::fs::File::open(folder) {
        let _ = folder.sync_all();
    }
}

/// Reads a whole file.
///
/// # Errors
/// When the file is absent or cannot be read.
pub fn read(path: &Path) -> Result<Vec<u8>, StoreError> {
    std::fs::read(path).map_err(|e| StoreError::new(path, e))
}

/// Reads a whole text file.
///
/// # Errors
/// When the file is absent, cannot be read, or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, StoreError> {
    String::from_utf8(read(path)?).map_err(|_| StoreError::new(path, "is not UTF-8 text"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_whole_files_and_creates_folders() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a/b.txt");
        for write in [write, write_derived] {
            for text in ["long first version", "short"] {
                write(&path, text.as_bytes()).unwrap();
                assert_eq!(read_text(&path).unwrap(), text);
            }
        }
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        std::fs::remove_file(&path).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("b.txt"));
    }

    #[cfg(unix)]
    #[test]
    fn new_files_have_the_permissions_of_any_other_or_of_the_one_before() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
        let [plain, ours, derived] = ["plain", "ours", "derived"].map(|name| dir.path().join(name));
        std::fs::write(&plain, "x").unwrap();
        write(&ours, b"x").unwrap();
        write_derived(&derived, b"x").unwrap();
        assert_eq!([&ours, &derived].map(|path| mode(path)), [mode(&plain); 2]);
        std::fs::set_permissions(&ours, std::fs::Permissions::from_mode(0o600)).unwrap();
        write(&ours, b"y").unwrap();
        assert_eq!((mode(&ours), read(&ours).unwrap()), (0o600, b"y".to_vec()));
    }
}
