//! The writer that unpacks the members of both kinds of archive.
//!
//! Every member is admitted first (its name, its kind, no path twice) and written then, if it belongs to a
//! folder that is wanted. The limits hold for the bytes that come out, whatever headers say. The modes, times and
//! owners an archive has are ignored.

use super::error::FetchError;
use super::layout::{ArchiveLayout, MAX_DEPTH, join};
use super::member::{MemberFault, parts};
use crate::archive::Archive;
use std::cell::Cell;
use std::collections::{BTreeSet, HashMap};
use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::rc::Rc;

/// Limits on what comes out of one archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Caps {
    /// Bytes in all.
    pub total: u64,
    /// Bytes of one member.
    pub member: u64,
    /// Bytes in all for each packed byte, beyond `slack`; pictures do not shrink, text does tenfold.
    pub ratio: u64,
    /// Bytes that `ratio` does not count, so that small archives of text pass.
    pub slack: u64,
    /// Members, folders and headers included.
    pub entries: u64,
    /// Parts of a path.
    pub depth: usize,
}

impl Default for Caps {
    /// Room for several times the largest dataset in the field: 1 TiB in 500 000 members of up to 64 GiB, a
    /// hundred bytes for each packed one after the first 64 MiB, 16 parts.
    fn default() -> Self {
        Self {
            total: 1 << 40,
            member: 1 << 36,
            ratio: 100,
            slack: 1 << 26,
            entries: 500_000,
            depth: MAX_DEPTH,
        }
    }
}

/// Writer of the members of an archive into an empty folder. It admits them, and enforces the limits.
pub(super) struct Sink<'a> {
    archive: &'a str,
    layout: &'a ArchiveLayout,
    pub caps: &'a Caps,
    into: &'a Path,
    /// Bytes of the archive.
    pub packed: u64,
    written: u64,
    entries: u64,
    /// By the path in small letters: as it was written, and whether it is a file.
    seen: HashMap<String, (String, bool)>,
    tops: BTreeSet<String>,
}

impl<'a> Sink<'a> {
    /// A sink for an archive of `packed` bytes.
    pub fn new(
        archive: &'a Archive,
        layout: &'a ArchiveLayout,
        caps: &'a Caps,
        into: &'a Path,
        packed: u64,
    ) -> Self {
        let (seen, tops) = (HashMap::new(), BTreeSet::new());
        Self { archive: &archive.name, layout, caps, into, packed, written: 0, entries: 0, seen, tops }
    }

    /// The archive's own top folders, as they would be under the data root.
    pub fn tops(&self) -> impl Iterator<Item = &str> {
        self.tops.iter().map(String::as_str)
    }
}

impl Sink<'_> {
    /// The error of a member.
    pub fn refuse(&self, raw: &[u8], reason: MemberFault) -> FetchError {
        let member = String::from_utf8_lossy(raw).into_owned();
        FetchError::Member { archive: self.archive.into(), member, reason }
    }

    /// The error of the archive as a whole.
    pub fn no_archive(&self, what: impl Into<String>) -> FetchError {
        FetchError::NotAnArchive { archive: self.archive.into(), reason: what.into() }
    }

    /// Most bytes that may come out.
    pub fn room(&self) -> u64 {
        self.caps.slack.saturating_add(self.caps.ratio.saturating_mul(self.packed)).min(self.caps.total)
    }

    /// Counts a member or header.
    pub fn count(&mut self, raw: &[u8]) -> Result<(), FetchError> {
        self.entries += 1;
        if self.entries > self.caps.entries {
            return Err(self.refuse(raw, MemberFault::Many(self.caps.entries)));
        }
        Ok(())
    }

    /// Checks a member; its path under the data root if it is wanted.
    pub fn admit(&mut self, raw: &[u8], is_file: bool) -> Result<Option<Vec<String>>, FetchError> {
        self.count(raw)?;
        let parts = parts(raw, self.caps.depth).map_err(|reason| self.refuse(raw, reason))?;
        if parts.is_empty() && is_file {
            return Err(self.refuse(raw, MemberFault::Empty));
        }
        let mut path = String::new();
        for (k, part) in parts.iter().enumerate() {
            path.push_str(part);
            let is_file = is_file && k + 1 == parts.len();
            self.register(&path, is_file).map_err(|reason| self.refuse(raw, reason))?;
            path.push('/');
        }
        if let Some(rest) = parts.strip_prefix(self.layout.below()) {
            let top = self.layout.into().iter().chain(rest.first()).map(String::as_str);
            self.tops.insert(top.collect::<Vec<_>>().join("/"));
        }
        Ok(self.layout.target(&parts))
    }

    fn register(&mut self, path: &str, is_file: bool) -> Result<(), MemberFault> {
        let folded = path.to_lowercase();
        match self.seen.get(&folded) {
            None => {
                self.seen.insert(folded, (path.to_owned(), is_file));
                Ok(())
            }
            Some((_, was_file)) if *was_file != is_file => Err(MemberFault::FileAndFolder),
            Some((spelled, _)) if is_file || spelled != path => Err(MemberFault::Twice),
            Some(_) => Ok(()),
        }
    }

    /// Makes a folder.
    pub fn folder(&self, path: &[String]) -> Result<(), FetchError> {
        let folder = join(self.into, path);
        fs::create_dir_all(&folder).map_err(|e| FetchError::disk(&folder, e))
    }

    /// Writes a member of which `declared` bytes are announced.
    pub fn file(
        &mut self,
        raw: &[u8],
        path: &[String],
        declared: u64,
        reader: &mut impl Read,
    ) -> Result<(), FetchError> {
        if declared > self.caps.member {
            return Err(self.refuse(raw, MemberFault::Large(self.caps.member)));
        }
        let file = join(self.into, path);
        let disk = |e| FetchError::disk(&file, e);
        if let Some(folder) = file.parent() {
            fs::create_dir_all(folder).map_err(disk)?;
        }
        let mut out = match OpenOptions::new().write(true).create_new(true).open(&file) {
            // Names that only this file system takes for the same, such as composed and decomposed accents.
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {
                return Err(self.refuse(raw, MemberFault::Twice));
            }
            opened => opened.map_err(disk)?,
        };
        let mut buffer = vec![0; 1 << 16];
        let mut got = 0;
        loop {
            let n = match reader.read(&mut buffer) {
                Ok(0) => break,
                Ok(n) => n,
                Err(e) if e.kind() == ErrorKind::Interrupted => continue,
                Err(e) => return Err(self.refuse(raw, damaged(e))),
            };
            got += n as u64;
            self.written += n as u64;
            if let Some(reason) = self.over(got) {
                return Err(self.refuse(raw, reason));
            }
            out.write_all(buffer.get(..n).unwrap_or_default()).map_err(disk)?;
        }
        if got != declared {
            return Err(self.refuse(raw, MemberFault::Length { got, declared }));
        }
        Ok(())
    }

    /// The limit that is passed, where a member has `got` bytes so far.
    fn over(&self, got: u64) -> Option<MemberFault> {
        if got > self.caps.member {
            return Some(MemberFault::Large(self.caps.member));
        }
        (self.written > self.room()).then(|| self.no_room())
    }

    /// Which of the limits in [`Sink::room`] it is.
    pub fn no_room(&self) -> MemberFault {
        if self.room() == self.caps.total {
            MemberFault::Total(self.caps.total)
        } else {
            MemberFault::Ratio(self.caps.ratio)
        }
    }
}

/// Why reading packed bytes failed.
pub(super) fn damaged(e: std::io::Error) -> MemberFault {
    e.downcast::<MemberFault>().unwrap_or_else(|e| MemberFault::Damaged(e.to_string()))
}

/// A reader that fails with `why` once more than `left` bytes have come through.
pub(super) struct Metered<R> {
    pub inner: R,
    pub left: Rc<Cell<u64>>,
    pub reason: MemberFault,
}

impl<R: Read> Read for Metered<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = self.inner.read(buffer)?;
        match self.left.get().checked_sub(n as u64) {
            Some(left) => self.left.set(left),
            None => return Err(std::io::Error::other(self.reason.clone())),
        }
        Ok(n)
    }
}

impl<R: std::io::Seek> std::io::Seek for Metered<R> {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.inner.seek(to)
    }
}

#[cfg(test)]
mod tests {
    use super::super::layout::tests::{archive, parts};
    use super::*;

    // Readers that give more than a header says do not get past the limits either.
    #[test]
    fn limits_hold_for_what_comes_out() {
        let folder = tempfile::tempdir().unwrap();
        let archive = archive();
        let layout = ArchiveLayout::new(&archive, &["otb/a".into()]).unwrap();
        let caps = Caps { total: 5000, member: 1000, ratio: 3, slack: 100, entries: 9, depth: 9 };
        let write = |name: &str, caps: &Caps, packed: u64, declared: u64, bytes: u64| {
            let mut sink = Sink::new(&archive, &layout, caps, folder.path(), packed);
            match sink.file(b"m", &parts(name), declared, &mut std::io::repeat(0).take(bytes)) {
                Err(FetchError::Member { reason, .. }) => Some(reason),
                other => {
                    other.unwrap();
                    None
                }
            }
        };
        assert_eq!(write("a/1", &caps, 900, 1000, 1000), None);
        assert_eq!(write("a/2", &caps, 900, 1000, 1001), Some(MemberFault::Large(1000)));
        assert_eq!(write("a/3", &caps, 900, 1001, 1000), Some(MemberFault::Large(1000)));
        assert_eq!(write("a/4", &caps, 100, 400, 401), Some(MemberFault::Ratio(3)));
        assert_eq!(write("a/5", &Caps { total: 300, ..caps }, 100, 300, 301), Some(MemberFault::Total(300)));
        assert_eq!(write("a/6", &caps, 900, 7, 8), Some(MemberFault::Length { got: 8, declared: 7 }));
        assert_eq!(write("a/7", &caps, 900, 8, 7), Some(MemberFault::Length { got: 7, declared: 8 }));
        assert_eq!(write("a/1", &caps, 900, 7, 7), Some(MemberFault::Twice));
    }
}
