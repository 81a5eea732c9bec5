//! Zip files, unpacked into an empty folder.
//!
//! The list of members is gone through first: their names, kinds and announced sizes. Nothing is written of an archive
//! in which one of them is refused, wanted or not. What is written then is no more than what was announced. A name that
//! any of the systems this runs on would read as leading elsewhere, or could not store, is refused on all of them, so
//! that an archive is good everywhere or nowhere. The modes, times and owners an archive has are ignored.

use super::error::{FetchError, shown};
use crate::archive::Archive;
use crate::lock::below;
use std::cell::Cell;
use std::collections::{BTreeSet, HashMap};
use std::fs::{self, File, OpenOptions};
use std::io::{BufReader, ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use zip::read::ZipFileEntry;
use zip::{CompressionMethod, ZipArchive};

/// Most parts of a path.
const DEPTH: usize = 16;

/// Longest name of a file or folder in bytes, as on most file systems.
const COMPONENT: usize = 255;

/// Names that Windows keeps for devices, whatever extension follows.
const DEVICES: [&str; 6] = ["con", "prn", "aux", "nul", "conin$", "conout$"];

/// Limits on what comes out of one archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Caps {
    /// Bytes in all.
    pub total: u64,
    /// Bytes in all for each packed byte, beyond `slack`; pictures do not shrink, text does tenfold.
    pub ratio: u64,
    /// Bytes that `ratio` does not count, so that small archives of text pass.
    pub slack: u64,
    /// Members, folders included.
    pub entries: u64,
}

impl Default for Caps {
    /// Room for several times the largest dataset in the field: 1 TiB in 500 000 members, a hundred bytes for each
    /// packed one after the first 64 MiB.
    fn default() -> Self {
        Self { total: 1 << 40, ratio: 100, slack: 1 << 26, entries: 500_000 }
    }
}

/// Unpacks the members of a zip file on disk that belong to `folders` into an empty folder.
///
/// # Errors
/// Any member that is refused, wanted or not; the caller then deletes the folder.
pub fn unpack(
    file: &Path,
    archive: &Archive,
    folders: &[String],
    caps: &Caps,
    into: &Path,
) -> Result<(), FetchError> {
    check_names(archive, folders)?;
    let unreadable =
        |why: String| data(format!("archive {}: {why}; nothing of it is kept, fetch it again", archive.name));
    let opened = File::open(file).and_then(|file| Ok((file.metadata()?.len(), BufReader::new(file))));
    let (packed, mut reader) = opened.map_err(|e| FetchError::disk(file, e))?;
    let is_page = starts_as_page(&mut reader);
    // The list of members is kept whole, so its bytes are limited before it is read: 640 for each.
    let left = Rc::new(Cell::new((1 << 20) + caps.entries.saturating_mul(640)));
    let metered = Metered { inner: reader, left: left.clone(), entries: caps.entries };
    let mut zip = ZipArchive::new(metered).map_err(|e| {
        unreadable(if is_page {
            "not a zip file but a web page".into()
        } else {
            format!("not a whole zip file: {e}")
        })
    })?;
    left.set(u64::MAX);
    if zip.has_duplicate_names() {
        return Err(unreadable("two of its members have the same name".into()));
    }
    let room = caps.slack.saturating_add(caps.ratio.saturating_mul(packed)).min(caps.total);
    let (mut seen, mut tops, mut announced) = (HashMap::new(), BTreeSet::new(), 0_u64);
    let mut wanted = Vec::new();
    for index in 0..zip.len() {
        let entry = zip.by_index_data(index).map_err(|e| unreadable(e.to_string()))?;
        let raw = entry.name_raw();
        let refuse = |why: String| refused(archive, raw, &why);
        if index as u64 >= caps.entries {
            return Err(refuse(format!("it is one of more than {} members", caps.entries)));
        }
        let is_file = is_file(&entry).map_err(refuse)?;
        let name = path_of(raw).map_err(refuse)?;
        if name.is_empty() && is_file {
            return Err(refuse(EMPTY.into()));
        }
        register(&mut seen, &name, is_file).map_err(|why| refuse(why.into()))?;
        announced = announced.saturating_add(entry.size());
        if announced > room {
            return Err(refuse(if room == caps.total {
                format!("with it the archive has more than {room} bytes")
            } else {
                format!("with it the archive unpacks to more than {} times its size", caps.ratio)
            }));
        }
        let Ok(inside) = Path::new(&name).strip_prefix(archive.below.as_deref().unwrap_or_default()) else {
            continue;
        };
        let root = Path::new(&archive.into);
        let place: PathBuf = root.iter().chain(inside).collect();
        tops.insert(root.iter().chain(inside.iter().take(1)).collect::<PathBuf>());
        if folders.iter().any(|folder| place.starts_with(folder)) {
            wanted.push((index, into.join(place), is_file));
        }
    }
    // Members that share packed bytes unpack to any number of times what the archive has.
    if zip.has_overlapping_entries().map_err(|e| unreadable(e.to_string()))? {
        return Err(unreadable("two of its members share packed bytes".into()));
    }
    for (index, path, is_file) in wanted {
        write(&mut zip, index, &path, is_file, archive)?;
    }
    match folders.iter().find(|folder| !below(into, folder).is_dir()) {
        Some(folder) => Err(no_folder(archive, folder, &tops)),
        None => Ok(()),
    }
}

/// Checks that names of archives and suites stay below the data root.
///
/// # Errors
/// The first one that does not.
pub(super) fn check_names(archive: &Archive, folders: &[String]) -> Result<(), FetchError> {
    let own = [Some(&archive.into), archive.below.as_ref()].into_iter().flatten().filter(|n| !n.is_empty());
    let check = |name: &String| match path_of(name.as_bytes()) {
        Ok(path) if path == *name => Ok(()),
        Ok(_) => Err(unusable(archive, name, EMPTY)),
        Err(why) => Err(unusable(archive, name, &why)),
    };
    if archive.name.contains('/') {
        return Err(unusable(archive, &archive.name, "it has a slash"));
    }
    folders.iter().chain(own).chain([&archive.name]).try_for_each(check)
}

/// Path below the data root of a download that is no archive but one file, whose name its address ends with.
///
/// # Errors
/// As [`check_names`].
pub(super) fn single_file(archive: &Archive, name: &str) -> Result<String, FetchError> {
    let path = if archive.into.is_empty() { name.into() } else { format!("{}/{name}", archive.into) };
    check_names(archive, std::slice::from_ref(&path))?;
    Ok(path)
}

fn unusable(archive: &Archive, name: &str, why: &str) -> FetchError {
    let archive = &archive.name;
    data(format!(
        "archive {archive}: {} of the built-in lists cannot be a path below the data root: {why}",
        shown(name)
    ))
}

fn data(message: String) -> FetchError {
    FetchError::Data(message)
}

fn refused(archive: &Archive, raw: &[u8], why: &str) -> FetchError {
    let member = shown(&String::from_utf8_lossy(raw));
    data(format!("archive {}, member {member}: {why}; nothing of it is kept", archive.name))
}

fn no_folder(archive: &Archive, folder: &str, tops: &BTreeSet<PathBuf>) -> FetchError {
    let found: Vec<_> =
        tops.iter().take(5).map(|top| shown(&top.to_string_lossy().replace('\\', "/"))).collect();
    let found = if found.is_empty() { "nothing at all".into() } else { found.join(", ") };
    data(format!(
        "archive {} has no folder {folder}, but {found}; `into` or `below` of its entry in datasets/archives.toml are wrong",
        archive.name
    ))
}

/// Whether a member is a file (`true`) or a folder.
fn is_file(entry: &ZipFileEntry) -> Result<bool, String> {
    let is_folder = entry.name_raw().ends_with(b"/");
    // The kind of file is in the upper half of the external attributes, as Unix has it.
    let special = match (entry.external_attributes() >> 16) & 0o170_000 {
        0 => None,
        0o100_000 if !is_folder => None,
        0o040_000 if is_folder => None,
        0o100_000 | 0o040_000 => return Err(BOTH.into()),
        0o120_000 => Some("symbolic link"),
        0o020_000 | 0o060_000 => Some("device"),
        0o010_000 => Some("named pipe"),
        _ => Some("special file"),
    };
    if let Some(kind) = special {
        return Err(format!("it is a {kind}; only files and folders are unpacked"));
    }
    if entry.encrypted() {
        return Err("it is encrypted".into());
    }
    match entry.compression() {
        CompressionMethod::Stored | CompressionMethod::Deflated => Ok(!is_folder),
        other => Err(format!("it is packed by the method {other}, not stored or deflated")),
    }
}

const EMPTY: &str = "its name is empty or a part of it is";
const BOTH: &str = "the path is a file and a folder";
const TWICE: &str = "the path is there twice, letters' case apart";

/// The path that a member's name is, without a `/` at its end; empty for the archive's own top folder (`./`).
///
/// # Errors
/// Every name that is not one or more plain names with `/` between them.
fn path_of(raw: &[u8]) -> Result<String, String> {
    let name = std::str::from_utf8(raw).map_err(|_| "its name is not UTF-8")?;
    let fault = if name.chars().any(char::is_control) {
        Some("its name has a control character")
    } else if name.contains('\\') {
        Some("its name has a backslash")
    } else if name.contains(':') {
        Some("its name has a colon")
    } else if name.starts_with('/') {
        Some("its path is absolute")
    } else if name.is_empty() {
        Some(EMPTY)
    } else {
        None
    };
    if let Some(fault) = fault {
        return Err(fault.into());
    }
    // Some programs write `./` before every path.
    let name = name.strip_suffix('/').unwrap_or(name);
    let name = if name == "." { "" } else { name.strip_prefix("./").unwrap_or(name) };
    if name.is_empty() {
        return Ok(String::new());
    }
    name.split('/').try_for_each(check_part)?;
    if name.split('/').count() > DEPTH {
        return Err(format!("its path has more than {DEPTH} parts"));
    }
    Ok(name.into())
}

fn check_part(part: &str) -> Result<(), String> {
    let stem = part.split('.').next().unwrap_or_default().trim_end_matches(' ').to_lowercase();
    let port = ["com", "lpt"].iter().find_map(|p| stem.strip_prefix(p)).unwrap_or_default();
    let is_port =
        port.chars().count() == 1 && port.contains(|c: char| c.is_ascii_digit() || "¹²³".contains(c));
    Err(if part.is_empty() {
        EMPTY.into()
    } else if part == "." || part == ".." {
        "its path has a `.` or `..`".into()
    } else if part.len() > COMPONENT {
        format!("a part of its name is longer than {COMPONENT} bytes")
    } else if part.ends_with(['.', ' ']) {
        "a part of its name ends with a dot or a space".into()
    } else if part.to_lowercase().starts_with(".trackfail") {
        "a part of its name starts with .trackfail, which this program keeps for itself".into()
    } else if is_port || DEVICES.contains(&stem.as_str()) {
        "its name is that of a device on Windows".into()
    } else {
        return Ok(());
    })
}

/// Enters a path and the folders above it; `seen` has them by their small letters: as they were written, and whether
/// they are files.
fn register(
    seen: &mut HashMap<String, (String, bool)>,
    path: &str,
    is_file: bool,
) -> Result<(), &'static str> {
    let ends = path.match_indices('/').map(|(end, _)| end).chain([path.len()]);
    for part in ends.map(|end| path.split_at(end).0) {
        let is_file = is_file && part == path;
        match seen.get(&part.to_lowercase()) {
            None => {
                seen.insert(part.to_lowercase(), (part.to_owned(), is_file));
            }
            Some((_, was_file)) if *was_file != is_file => return Err(BOTH),
            Some((spelled, _)) if is_file || spelled != part => return Err(TWICE),
            Some(_) => {}
        }
    }
    Ok(())
}

/// Writes a member: a folder, or a file with as many bytes as are announced.
fn write<R: Read + Seek>(
    zip: &mut ZipArchive<R>,
    index: usize,
    path: &Path,
    is_file: bool,
    archive: &Archive,
) -> Result<(), FetchError> {
    let disk = |e| FetchError::disk(path, e);
    if !is_file {
        return fs::create_dir_all(path).map_err(disk);
    }
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(disk)?;
    }
    let raw = zip.by_index_data(index).map(|e| e.name_raw().to_vec()).unwrap_or_default();
    let refuse = |why: String| refused(archive, &raw, &why);
    let mut out = match OpenOptions::new().write(true).create_new(true).open(path) {
        // Names that only this file system takes for the same, such as composed and decomposed accents.
        Err(e) if e.kind() == ErrorKind::AlreadyExists => return Err(refuse(TWICE.into())),
        opened => opened.map_err(disk)?,
    };
    let damaged = |e: String| refuse(format!("it is damaged ({e})"));
    let member = zip.by_index(index).map_err(|e| damaged(e.to_string()))?;
    let declared = member.size();
    let mut member = member.take(declared.saturating_add(1));
    let (mut buffer, mut got) = (vec![0; 1 << 16], 0_u64);
    loop {
        let n = match member.read(&mut buffer) {
            Ok(0) => break,
            Ok(n) => n,
            Err(e) if e.kind() == ErrorKind::Interrupted => continue,
            Err(e) => return Err(damaged(e.to_string())),
        };
        got += n as u64;
        if got > declared {
            return Err(refuse(format!("more bytes than the {declared} that the archive says")));
        }
        out.write_all(buffer.get(..n).unwrap_or_default()).map_err(disk)?;
    }
    if got != declared {
        return Err(refuse(format!("{got} bytes, the archive says {declared}")));
    }
    Ok(())
}

/// A reader that fails once more than `left` bytes have come through.
struct Metered<R> {
    inner: R,
    left: Rc<Cell<u64>>,
    entries: u64,
}

impl<R: Read> Read for Metered<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = self.inner.read(buffer)?;
        let left = self.left.get().checked_sub(n as u64);
        self.left
            .set(left.ok_or_else(|| std::io::Error::other(format!("more than {} members", self.entries)))?);
        Ok(n)
    }
}

impl<R: Seek> Seek for Metered<R> {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.inner.seek(to)
    }
}

/// Servers that have lost a file like to answer with a page.
fn starts_as_page(reader: &mut impl Read) -> bool {
    let mut start = [0; 64];
    let n = reader.read(&mut start).unwrap_or(0);
    start.iter().take(n).find(|b| !b.is_ascii_whitespace()) == Some(&b'<')
}

#[cfg(test)]
mod tests;
