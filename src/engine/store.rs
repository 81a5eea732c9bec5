//! The only place where results touch the disk: whole files, written beside their target and renamed.

use std::io::Write;
use std::path::{Path, PathBuf};

/// A file that could not be written or read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {what}", path.display())]
pub struct StoreError {
    /// The file.
    pub path: PathBuf,
    /// What went wrong.
    pub what: String,
}

impl StoreError {
    /// An error about `path`.
    pub fn new(path: &Path, what: impl std::fmt::Display) -> Self {
        Self { path: path.to_path_buf(), what: what.to_string() }
    }
}

/// Writes a file so that it is either the old or the new one, whole, whatever happens in between.
///
/// # Errors
/// When the folder cannot be made or written to.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let fail = |e: &dyn std::fmt::Display| StoreError::new(path, e);
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|e| fail(&e))?;
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(|e| fail(&e))?;
    file.write_all(bytes).map_err(|e| fail(&e))?;
    file.as_file().sync_all().map_err(|e| fail(&e))?;
    make_readable(file.as_file()).map_err(|e| fail(&e))?;
    file.persist(path).map_err(|e| fail(&e))?;
    // The rename is only durable once the folder is; not every file system can do that.
    if let Ok(folder) = std::fs::File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// Temporary files are private; results are as readable as any other new file.
#[cfg(unix)]
fn make_readable(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn make_readable(_: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}

/// Reads a whole file.
///
/// # Errors
/// When it is not there or cannot be read.
pub fn read(path: &Path) -> Result<Vec<u8>, StoreError> {
    std::fs::read(path).map_err(|e| StoreError::new(path, e))
}

/// Reads a whole text file.
///
/// # Errors
/// When it is not there, cannot be read, or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, StoreError> {
    String::from_utf8(read(path)?).map_err(|_| StoreError::new(path, "is not UTF-8 text"))
}

/// Removes a folder that this program filled earlier; absent ones are fine.
///
/// Experiments may lie below each other: the folder for the figures of `a` would be that of `a/figures`.
///
/// # Errors
/// When something in it cannot be removed, and when it holds the results or the report of an experiment.
pub fn clear(folder: &Path) -> Result<(), StoreError> {
    let whole = |name: &std::ffi::OsStr| name == "manifest.json" || name == "index.html";
    let mut entries = walkdir::WalkDir::new(folder).into_iter().filter_map(Result::ok);
    if let Some(other) = entries.find(|e| whole(e.file_name())) {
        let what =
            format!("belongs to another experiment ({}); rename one of the two", other.path().display());
        return Err(StoreError::new(folder, what));
    }
    match std::fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(StoreError::new(folder, e)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_whole_files_and_makes_folders() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a/b.txt");
        write(&path, b"long first version").unwrap();
        write(&path, b"short").unwrap();
        assert_eq!(read_text(&path).unwrap(), "short");
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        clear(dir.path().join("a").as_path()).unwrap();
        clear(dir.path().join("a").as_path()).unwrap();
        write(&dir.path().join("figures/index.html"), b"of an experiment called figures").unwrap();
        assert!(clear(&dir.path().join("figures")).unwrap_err().to_string().contains("another experiment"));
        assert!(dir.path().join("figures/index.html").is_file());
        assert!(read(&path).unwrap_err().to_string().contains("b.txt"));
    }
}
