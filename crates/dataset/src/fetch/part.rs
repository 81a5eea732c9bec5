//! A download on disk: `<name>.part` and, beside it, `<name>.json` with what is known of it.
//!
//! A part belongs to one state of the file at one address; the note beside it has the address and the server's
//! mark of that state (ETag, else Last-Modified), so that the rest of another state is never added to it.

use super::error::FetchError;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::{self, File, OpenOptions};
use std::io::{BufRead, BufReader, ErrorKind};
use std::path::{Path, PathBuf};

/// Facts about a download.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Note {
    /// The address asked, before redirects.
    pub url: String,
    /// The server's mark of this state of the file: its ETag if that is a strong one, else Last-Modified.
    pub mark: Option<String>,
    /// Bytes of the whole file.
    pub total: Option<u64>,
    /// SHA-256 of the whole file, once it is whole.
    pub sha256: Option<String>,
}

/// A download on disk.
#[derive(Debug)]
pub(super) struct Part {
    path: PathBuf,
    beside: PathBuf,
    pub note: Note,
}

impl Part {
    /// Opens a download; its bytes are dropped if they are from another address, or if its note cannot be read.
    pub fn open(folder: &Path, name: &str, url: &str, pinned: bool) -> Result<Self, FetchError> {
        let (path, beside) = (folder.join(format!("{name}.part")), folder.join(format!("{name}.json")));
        let read = fs::read(&beside).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
        let mut part = Self { path, beside, note: read.unwrap_or_default() };
        if part.note.url != url {
            // The mark is another server's, but with a digest to compare with none is needed.
            let known = !part.note.url.is_empty();
            part.note = Note { url: url.into(), total: part.note.total, ..Note::default() };
            if !(known && pinned) {
                part.reset()?;
            }
        }
        Ok(part)
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Bytes that are there.
    pub fn len(&self) -> Result<u64, FetchError> {
        match fs::metadata(&self.path) {
            Ok(metadata) => Ok(metadata.len()),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(0),
            Err(e) => Err(FetchError::disk(&self.path, e)),
        }
    }

    /// Drops the bytes, and what was known of them.
    pub fn reset(&mut self) -> Result<(), FetchError> {
        for path in [&self.path, &self.beside] {
            match fs::remove_file(path) {
                Err(e) if e.kind() != ErrorKind::NotFound => return Err(FetchError::disk(path, e)),
                _ => {}
            }
        }
        self.note = Note { url: std::mem::take(&mut self.note.url), ..Note::default() };
        Ok(())
    }

    /// Writes the note, which must be on disk before the bytes that it describes.
    pub fn write_note(&self) -> Result<(), FetchError> {
        let text = serde_json::to_vec(&self.note).map_err(|e| FetchError::disk(&self.beside, e.into()))?;
        fs::write(&self.beside, text).map_err(|e| FetchError::disk(&self.beside, e))
    }

    /// For writing behind the last byte.
    pub fn append(&self) -> Result<File, FetchError> {
        let opened = OpenOptions::new().append(true).create(true).open(&self.path);
        opened.map_err(|e| FetchError::disk(&self.path, e))
    }

    /// SHA-256 in hexadecimal of the bytes that are there.
    pub fn sha256(&self) -> Result<String, FetchError> {
        let disk = |e| FetchError::disk(&self.path, e);
        let mut file = BufReader::with_capacity(1 << 20, File::open(&self.path).map_err(disk)?);
        let mut hash = Sha256::new();
        loop {
            let bytes = file.fill_buf().map_err(disk)?;
            if bytes.is_empty() {
                break;
            }
            hash.update(bytes);
            let n = bytes.len();
            file.consume(n);
        }
        Ok(trackfail_core::num::hexadecimal(&hash.finalize()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arrived(folder: &Path, note: &Note) -> Part {
        let part = Part { path: folder.join("a.part"), beside: folder.join("a.json"), note: note.clone() };
        part.write_note().unwrap();
        fs::write(&part.path, b"abc").unwrap();
        part
    }

    #[test]
    fn a_part_is_kept_for_its_address_or_a_digest() {
        let folder = tempfile::tempdir().unwrap();
        let note = Note { url: "u".into(), mark: Some("\"1\"".into()), total: Some(9), ..Note::default() };
        for (url, pinned, length, mark) in
            [("u", false, 3, true), ("u", true, 3, true), ("v", true, 3, false), ("v", false, 0, false)]
        {
            arrived(folder.path(), &note);
            let part = Part::open(folder.path(), "a", url, pinned).unwrap();
            assert_eq!((part.len().unwrap(), part.note.mark.is_some()), (length, mark), "{url} {pinned}");
        }
    }

    #[test]
    fn a_part_with_a_damaged_note_is_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let note = Note { url: "u".into(), ..Note::default() };
        let whole = serde_json::to_vec(&note).unwrap();
        for cut in 0..whole.len() {
            arrived(folder.path(), &note);
            fs::write(folder.path().join("a.json"), &whole[..cut]).unwrap();
            assert_eq!(Part::open(folder.path(), "a", "u", true).unwrap().len().unwrap(), 0, "{cut}");
        }
    }

    // python3 -c "import hashlib; print(hashlib.sha256(b'abc').hexdigest())"
    #[test]
    fn digest_of_the_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let digest = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(arrived(folder.path(), &Note::default()).sha256().unwrap(), digest);
    }
}
