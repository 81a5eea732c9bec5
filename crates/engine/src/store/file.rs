//! Plain files, written whole: beside their target, then renamed.

use super::{StoreError, TEMPORARY};
use std::io::Write;
use std::path::Path;

/// Replaces a file atomically: readers see the old or the new content, never a part.
///
/// # Errors
/// When the folder cannot be created or written to.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    write_with(path, |file| file.write_all(bytes).map_err(|e| StoreError::new(path, e)))
}

/// Replaces a file atomically, as [`write()`], and does not wait until it is on the disk: for what can be made again, such
/// as a report.
///
/// # Errors
/// When the folder cannot be created or written to.
pub fn write_derived(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let fail = |e| StoreError::new(path, e);
    let mut file = temporary_for(path)?;
    file.write_all(bytes).map_err(fail)?;
    file.persist(path).map(drop).map_err(|e| fail(e.error))
}

/// Replaces a file atomically by what `fill` writes, for content that is too large for the memory.
///
/// # Errors
/// When the folder cannot be created or written to, and those of `fill`.
pub fn write_with<E: From<StoreError>>(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let mut file = temporary_for(path)?;
    fill(&mut file)?;
    Ok(persist(file, path)?)
}

/// Writes a file that the user has named: a regular or new file is replaced atomically; a device, a pipe or a link is
/// opened and written to, and stays what it is. No folder is made.
///
/// # Errors
/// When there is no such folder, or the file cannot be written to.
pub fn write_output(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let fail = |e| StoreError::new(path, e);
    check_output(path)?;
    match std::fs::symlink_metadata(path) {
        Ok(about) if !about.is_file() => {
            let file = std::fs::OpenOptions::new().write(true).create(true).truncate(true).open(path);
            let mut file = file.map_err(fail)?;
            file.write_all(bytes).and_then(|()| file.flush()).map_err(fail)
        }
        Ok(about) => {
            let mut file = temporary_in(folder_of(path)).map_err(fail)?;
            file.write_all(bytes).map_err(fail)?;
            // The new file has the mode of the one that it replaces.
            file.as_file().set_permissions(about.permissions()).map_err(fail)?;
            persist(file, path)
        }
        Err(_) => write(path, bytes),
    }
}

/// Checks that there is a folder for a file that the user has named.
///
/// # Errors
/// When there is none.
pub fn check_output(path: &Path) -> Result<(), StoreError> {
    let folder = folder_of(path);
    if folder.is_dir() {
        return Ok(());
    }
    Err(StoreError::new(path, format!("there is no folder {}; make it first", folder.display())))
}

/// The folder of a file: the working one for a name alone.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A temporary file beside a path, in a folder that is made if need be.
fn temporary_for(path: &Path) -> Result<tempfile::NamedTempFile, StoreError> {
    let fail = |e: std::io::Error| StoreError::new(path, e);
    let folder = folder_of(path);
    std::fs::create_dir_all(folder).map_err(fail)?;
    temporary_in(folder).map_err(fail)
}

/// A temporary file in a folder, with the permissions of any other new file: those that the umask leaves. (Temporary files
/// are private otherwise, and keep that when they get their final names.)
pub(super) fn temporary_in(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.prefix(TEMPORARY).tempfile_in(folder)
}

/// Gives a temporary file its final name, and waits until both are on the disk.
pub(super) fn persist(file: tempfile::NamedTempFile, path: &Path) -> Result<(), StoreError> {
    let fail = |e: std::io::Error| StoreError::new(path, e);
    file.as_file().sync_all().map_err(fail)?;
    file.persist(path).map_err(|e| fail(e.error))?;
    sync_folder(folder_of(path));
    Ok(())
}

/// Makes renames in a folder durable, where the file system supports that.
pub(super) fn sync_folder(folder: &Path) {
    if let Ok(folder) = std::fs::File::open(folder) {
        let _ = folder.sync_all();
    }
}

/// Reads a whole file.
///
/// # Errors
/// When it is absent or cannot be read.
pub fn read(path: &Path) -> Result<Vec<u8>, StoreError> {
    std::fs::read(path).map_err(|e| StoreError::new(path, e))
}

/// Reads a whole text file.
///
/// # Errors
/// When it is absent, cannot be read, or is not UTF-8.
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
        write(&path, b"long first version").unwrap();
        write(&path, b"short").unwrap();
        assert_eq!(read_text(&path).unwrap(), "short");
        write_derived(&path, b"made again").unwrap();
        assert_eq!(read_text(&path).unwrap(), "made again");
        write(&path, b"short").unwrap();
        assert_eq!(read_text(&path).unwrap(), "short");
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        write_output(&path, b"by its name").unwrap();
        assert_eq!(read_text(&path).unwrap(), "by its name");
        std::fs::remove_file(&path).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("b.txt"));
    }
    #[test]
    fn no_folder_is_made_for_an_output() {
        let dir = tempfile::tempdir().unwrap();
        let message = write_output(&dir.path().join("none/a.txt"), b"x").unwrap_err().to_string();
        assert!(message.contains("there is no folder") && message.contains("make it first"), "{message}");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
        assert!(write_output(dir.path(), b"x").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn new_files_have_the_permissions_of_any_other() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
        let [plain, ours, derived, output] =
            ["plain", "ours", "derived", "output"].map(|name| dir.path().join(name));
        std::fs::write(&plain, "x").unwrap();
        write(&ours, b"x").unwrap();
        write_derived(&derived, b"x").unwrap();
        write_output(&output, b"x").unwrap();
        assert_eq!([&ours, &derived, &output].map(|path| mode(path)), [mode(&plain); 3]);
        // A file that was there keeps its own.
        std::fs::set_permissions(&output, std::fs::Permissions::from_mode(0o600)).unwrap();
        write_output(&output, b"y").unwrap();
        assert_eq!((mode(&output), std::fs::read(&output).unwrap()), (0o600, b"y".to_vec()));
    }

    #[cfg(unix)]
    #[test]
    fn links_pipes_and_devices_stay_what_they_are() {
        use std::os::unix::fs::FileTypeExt;
        let dir = tempfile::tempdir().unwrap();
        let (file, link) = (dir.path().join("file"), dir.path().join("link"));
        std::fs::write(&file, "a longer text").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_output(&link, b"new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(read_text(&file).unwrap(), "new");
        // A link that leads nowhere yet leads to the new file.
        std::fs::remove_file(&file).unwrap();
        write_output(&link, b"again").unwrap();
        assert!(link.is_symlink());
        assert_eq!(read_text(&file).unwrap(), "again");
        let pipe = dir.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read(pipe).unwrap()
        });
        write_output(&pipe, b"through").unwrap();
        assert_eq!(reader.join().unwrap(), b"through");
        assert!(std::fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
        write_output(Path::new("/dev/null"), b"gone").unwrap();
        assert!(std::fs::symlink_metadata("/dev/null").unwrap().file_type().is_char_device());
    }
}
