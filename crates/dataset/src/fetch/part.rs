//! A download on disk: `<name>.part` and, beside it, `<name>.json` with the facts known about the file.
//!
//! A part belongs to one state of the file at one address; the note beside it has the address and the server's
//! mark of that state (ETag, else Last-Modified), so that the rest of another state is never added to it.

use super::{FetchError, Result};
use serde::{Deserialize, Serialize};
use std::fs::{self, File, OpenOptions};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A download on disk, complete or not, and the facts that are kept beside its bytes.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Part {
    #[serde(skip)]
    pub path: PathBuf,
    #[serde(skip)]
    pub(super) beside: PathBuf,
    /// Address that was requested, before redirects.
    pub url: String,
    /// Mark of this state of the file, given by the server: the ETag if it is a strong one, else
    /// Last-Modified.
    pub mark: Option<String>,
    /// Size of the whole file in bytes; `None` if the server does not tell.
    pub total: Option<u64>,
}

impl Part {
    /// Opens a download. Bytes from another address, or with an unreadable note, are dropped.
    pub fn open(folder: &Path, name: &str, url: &str) -> Result<Self> {
        let (path, beside) = (folder.join(format!("{name}.part")), folder.join(format!("{name}.json")));
        let note: Option<Self> = fs::read(&beside).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
        if let Some(note) = note.filter(|note| note.url == url) {
            return Ok(Self { path, beside, ..note });
        }
        let mut part = Self { path, beside, url: url.into(), ..Self::default() };
        part.reset()?;
        Ok(part)
    }

    /// Number of bytes on disk.
    pub fn len(&self) -> Result<u64> {
        match fs::metadata(&self.path) {
            Ok(metadata) => Ok(metadata.len()),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(0),
            Err(e) => Err(FetchError::disk(&self.path, e)),
        }
    }

    /// Drops the bytes and their note.
    pub fn reset(&mut self) -> Result<()> {
        for path in [&self.path, &self.beside] {
            match fs::remove_file(path) {
                Err(e) if e.kind() != ErrorKind::NotFound => return Err(FetchError::disk(path, e)),
                _ => {}
            }
        }
        (self.mark, self.total) = (None, None);
        Ok(())
    }

    /// Starts the file again from its first byte. The note is on disk before the bytes that it describes.
    pub fn begin(&mut self, mark: Option<String>, total: Option<u64>) -> Result<()> {
        self.reset()?;
        (self.mark, self.total) = (mark, total);
        let text: std::io::Result<Vec<u8>> = serde_json::to_vec(self).map_err(Into::into);
        text.and_then(|text| fs::write(&self.beside, text)).map_err(|e| FetchError::disk(&self.beside, e))
    }

    /// Opens the file for appending.
    pub fn append(&self) -> Result<File> {
        let opened = OpenOptions::new().append(true).create(true).open(&self.path);
        opened.map_err(|e| FetchError::disk(&self.path, e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_kept_for_its_address_and_with_a_whole_note() {
        let folder = tempfile::tempdir().unwrap();
        let [bytes, beside] = ["a.part", "a.json"].map(|name| folder.path().join(name));
        let whole = br#"{"url":"u","mark":"\"1\"","total":9}"#;
        let cuts = (0..whole.len()).map(|cut| ("u", cut, 0));
        for (url, end, length) in cuts.chain([("u", whole.len(), 3), ("v", whole.len(), 0)]) {
            fs::write(&bytes, b"abc").unwrap();
            fs::write(&beside, &whole[..end]).unwrap();
            let part = Part::open(folder.path(), "a", url).unwrap();
            assert_eq!((part.len().unwrap(), part.mark.is_some()), (length, length > 0), "{url} {end}");
        }
    }
}
