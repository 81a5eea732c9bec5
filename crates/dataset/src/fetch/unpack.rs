//! Zip files, unpacked into an empty folder.
//!
//! The names, kinds and announced sizes of all members are checked first. If one member is refused, wanted or
//! not, nothing is written. No member may write more than its announced size. A name that could lead out of
//! the folder is refused. The modes, times and owners in the archive are ignored.

use super::{FetchError, Result, download};
use crate::archive::Archive;
use crate::lock::below;
use crate::text;
use std::cell::Cell;
use std::fs::{self, File};
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;
use std::rc::Rc;
use zip::ZipArchive;

/// Largest list of members in an archive, in bytes, plus `MEMBER` bytes for each member that [`Caps`] allow.
const LIST: u64 = 1 << 20;
const MEMBER: u64 = 640;
/// Most parts of a member's path. Deeper folders might be hard to remove again.
const DEPTH: usize = 16;
/// Longest name of a file or folder in bytes, as on most file systems.
const COMPONENT: usize = 255;

/// Limits on the content of one archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Caps {
    /// Most bytes of all members together.
    pub total: u64,
    /// Most unpacked bytes per packed byte, beyond `slack`. Pictures barely shrink, text shrinks tenfold.
    pub ratio: u64,
    /// Bytes that `ratio` leaves out of account, so that small archives of text pass.
    pub slack: u64,
    /// Most members, folders included.
    pub entries: u64,
}

impl Default for Caps {
    /// Several times the largest dataset in the field: 1 TiB in 500 000 members, and a hundred bytes per
    /// packed byte after the first 64 MiB.
    fn default() -> Self {
        Self { total: 1 << 40, ratio: 100, slack: 1 << 26, entries: 500_000 }
    }
}

/// True if a download begins as a web page, with which servers like to answer that have lost a file.
pub fn is_page(download: &mut impl Read) -> bool {
    let mut start = [0; 64];
    let n = download.read(&mut start).unwrap_or(0);
    let start = start[..n].trim_ascii_start().to_ascii_lowercase();
    start.starts_with(b"<!doctype html") || start.starts_with(b"<html")
}

/// Unpacks the members of a zip file that belong to `folders` into the empty folder `into`.
///
/// # Errors
/// A member that is refused, wanted or not. The caller then deletes the folder.
pub fn unpack(file: &Path, archive: &Archive, folders: &[String], caps: &Caps, into: &Path) -> Result<()> {
    let unreadable = |why: String| {
        FetchError::Data(format!("archive {}: {why}; nothing of it is kept, fetch it again", archive.name))
    };
    let opened = File::open(file).and_then(|file| Ok((file.metadata()?.len(), BufReader::new(file))));
    let (packed, mut reader) = opened.map_err(|e| FetchError::disk(file, e))?;
    let is_page = is_page(&mut reader);
    let left = Rc::new(Cell::new(LIST.saturating_add(caps.entries.saturating_mul(MEMBER))));
    let metered = Metered { inner: reader, left: left.clone(), entries: caps.entries };
    let mut zip = ZipArchive::new(metered).map_err(|e| match is_page {
        true => unreadable("not a zip file but a web page".into()),
        false => unreadable(format!("not a whole zip file: {e}")),
    })?;
    left.set(u64::MAX);
    if zip.len() as u64 > caps.entries {
        return Err(unreadable(format!("more than {} members", caps.entries)));
    }
    if zip.has_duplicate_names() {
        return Err(unreadable("two of its members have the same name".into()));
    }
    let room = caps.slack.saturating_add(caps.ratio.saturating_mul(packed)).min(caps.total);
    let (mut announced, mut wanted) = (0_u64, Vec::new());
    for index in 0..zip.len() {
        let entry = zip.by_index_data(index).map_err(|e| unreadable(e.to_string()))?;
        let refuse = |why: String| refused(archive, entry.name_raw(), &why);
        // The kind of file is in the upper half of the external attributes, as Unix has it.
        if ![0, 0o040_000, 0o100_000].contains(&((entry.external_attributes() >> 16) & 0o170_000)) {
            let kinds = "it is a symbolic link, a device, a named pipe or another special file";
            return Err(refuse(format!("{kinds}; only files and folders are unpacked")));
        }
        let name = path_of(entry.name_raw()).map_err(refuse)?;
        announced = announced.saturating_add(entry.size());
        if announced > room {
            return Err(refuse(match room == caps.total {
                true => format!("with it the archive has more than {room} bytes"),
                false => format!("with it the archive unpacks to more than {} times its size", caps.ratio),
            }));
        }
        let below = archive.below.as_deref().unwrap_or_default();
        let Ok(inside) = Path::new(&name).strip_prefix(below) else { continue };
        let place = Path::new(&archive.into).join(inside);
        if folders.iter().any(|folder| place.starts_with(folder)) {
            wanted.push((index, into.join(place)));
        }
    }
    // Members that share packed bytes unpack to any number of times what the archive has.
    if zip.has_overlapping_entries().map_err(|e| unreadable(e.to_string()))? {
        return Err(unreadable("two of its members share packed bytes".into()));
    }
    for (index, path) in wanted {
        write(&mut zip, index, &path, archive)?;
    }
    let Some(folder) = folders.iter().find(|folder| !below(into, folder).is_dir()) else { return Ok(()) };
    let first = zip.by_index_data(0).map(|entry| shown(entry.name_raw()));
    Err(FetchError::Data(format!(
        "archive {} has no folder {folder}, and begins with {}; `into` or `below` of its entry in datasets/archives.toml \
         are wrong",
        archive.name,
        first.unwrap_or_else(|_| "nothing".into())
    )))
}

/// Reader that stops after a number of bytes. The list of members is read whole before it can be checked.
struct Metered<R> {
    inner: R,
    left: Rc<Cell<u64>>,
    entries: u64,
}

impl<R: Read> Read for Metered<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        let left = self.left.get().checked_sub(n as u64);
        self.left.set(left.ok_or_else(|| io::Error::other(format!("more than {} members", self.entries)))?);
        Ok(n)
    }
}

impl<R: Seek> Seek for Metered<R> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.inner.seek(to)
    }
}

/// A foreign name, made safe for printing.
fn shown(raw: &[u8]) -> String {
    format!("`{}`", text::shorten_to(&text::visible(&String::from_utf8_lossy(raw)), 120))
}

fn refused(archive: &Archive, raw: &[u8], why: &str) -> FetchError {
    let (name, member) = (&archive.name, shown(raw));
    FetchError::Data(format!("archive {name}, member {member}: {why}; nothing of it is kept"))
}

/// Path below the data root of a download that is a single file. Its name is the last part of the address.
///
/// # Errors
/// A malformed address, and a name with separators or other characters that a plain file name lacks.
pub(super) fn single_file(archive: &Archive) -> Result<String> {
    let address = download::address(&archive.url)?;
    let name = download::file_name(&address);
    let path = if archive.into.is_empty() { name.to_string() } else { format!("{}/{name}", archive.into) };
    match path_of(path.as_bytes()) {
        Ok(plain) if plain == path => Ok(path),
        Ok(_) => Err(refused(archive, path.as_bytes(), "its address ends with no name of a file")),
        Err(why) => Err(refused(archive, path.as_bytes(), &why)),
    }
}

/// Path of a member, without a `/` at the end; empty for the top folder of the archive (`./`).
///
/// # Errors
/// A name that is not one or more plain names separated by `/`.
fn path_of(raw: &[u8]) -> Result<String, String> {
    let name = std::str::from_utf8(raw).map_err(|_| "its name is not UTF-8")?;
    if name.chars().any(|c| c.is_control() || c == '\\' || c == ':') {
        return Err("its name has a backslash, a colon or a control character".into());
    }
    if name == "./" || name == "." {
        return Ok(String::new());
    }
    // Some programs write `./` before every path.
    let path = name.strip_prefix("./").unwrap_or(name);
    let path = path.strip_suffix('/').unwrap_or(path);
    if path.split('/').count() > DEPTH {
        return Err(format!("its path has more than {DEPTH} parts"));
    }
    for part in path.split('/') {
        if matches!(part, "" | "." | "..") {
            return Err("its path is absolute, or a part of it is empty, `.` or `..`".into());
        }
        if part.len() > COMPONENT || part.ends_with(['.', ' ']) {
            let long = format!("longer than {COMPONENT} bytes");
            return Err(format!("a part of its name is {long}, or ends with a dot or a space"));
        }
        if part.to_lowercase().starts_with(".trackfail") {
            return Err(
                "a part of its name starts with .trackfail, which this program keeps for itself".into()
            );
        }
    }
    Ok(path.into())
}

/// Writes a member: a folder, or a file of exactly the announced size.
fn write(zip: &mut ZipArchive<impl Read + Seek>, index: usize, path: &Path, archive: &Archive) -> Result<()> {
    let raw = zip.by_index_data(index).map(|entry| entry.name_raw().to_vec()).unwrap_or_default();
    let failed = |e: io::Error| match e.kind() {
        // Of names that this file system takes for the same, too.
        ErrorKind::AlreadyExists | ErrorKind::NotADirectory => {
            refused(archive, &raw, "the path is there twice, or is a file and a folder")
        }
        ErrorKind::InvalidData
        | ErrorKind::InvalidFilename
        | ErrorKind::InvalidInput
        | ErrorKind::UnexpectedEof
        | ErrorKind::Unsupported => {
            refused(archive, &raw, &format!("it is damaged or not packed in the usual way ({e})"))
        }
        _ => FetchError::disk(path, e),
    };
    let member = zip.by_index(index).map_err(|e| failed(e.into()))?;
    if member.is_dir() {
        return fs::create_dir_all(path).map_err(failed);
    }
    fs::create_dir_all(path.parent().unwrap_or(path)).map_err(failed)?;
    let mut out = File::create_new(path).map_err(failed)?;
    let declared = member.size();
    // One byte more shows that there are more.
    let got = io::copy(&mut member.take(declared.saturating_add(1)), &mut out).map_err(failed)?;
    if got != declared {
        return Err(refused(archive, &raw, &format!("{got} bytes, the archive says {declared}")));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
