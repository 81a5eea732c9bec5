//! Zip files, by their central directory; two passes, so that nothing is written of one that is refused for
//! its names, kinds or announced sizes.

use super::error::FetchError;
use super::member::MemberFault;
use super::sink::{Metered, Sink};
use std::cell::Cell;
use std::collections::HashSet;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::rc::Rc;
use zip::read::ZipFileEntry;
use zip::result::ZipError;
use zip::{CompressionMethod, ZipArchive};

/// Bytes of a central directory's fixed part, and what is granted to each member for name and extra fields.
const HEADER: usize = 46;
const GRANTED: u64 = 640;

/// Kind of file in the upper half of the external attributes, as Unix has it.
const KIND: u32 = 0o170_000;

pub(super) fn unpack(file: File, sink: &mut Sink) -> Result<(), FetchError> {
    // The crate keeps the whole list of members, so its bytes are limited before it is read.
    let budget = (1 << 20) + GRANTED.saturating_mul(sink.caps.entries);
    let left = Rc::new(Cell::new(budget));
    let reason = MemberFault::Many(sink.caps.entries);
    let mut reader = Metered { inner: BufReader::new(file), left: left.clone(), reason };
    let starts_as_page = starts_as_page(&mut reader);
    let mut archive = ZipArchive::new(reader).map_err(|e| match e {
        ZipError::Io(e) => sink.no_archive(format!("not a whole zip file: {e}")),
        _ if starts_as_page => sink.no_archive("not a zip file but a web page"),
        e => sink.no_archive(format!("not a whole zip file: {e}")),
    })?;
    left.set(u64::MAX);
    if archive.has_duplicate_names() {
        let start = archive.central_directory_start();
        let name = first_repeated(archive.into_inner(), start).unwrap_or_default();
        return Err(sink.refuse(&name, MemberFault::Twice));
    }
    let mut wanted = Vec::new();
    let mut announced = 0_u64;
    for index in 0..archive.len() {
        let entry = archive.by_index_data(index).map_err(|e| sink.no_archive(e.to_string()))?;
        let raw = entry.name_raw();
        let is_file = kind(&entry).map_err(|reason| sink.refuse(raw, reason))?;
        let path = sink.admit(raw, is_file)?;
        announced = announced.saturating_add(entry.size());
        if entry.size() > sink.caps.member {
            return Err(sink.refuse(raw, MemberFault::Large(sink.caps.member)));
        }
        if announced > sink.room() {
            return Err(sink.refuse(raw, sink.no_room()));
        }
        wanted.extend(path.map(|path| (index, path, is_file)));
    }
    check_overlap(&mut archive, sink)?;
    for (index, path, is_file) in wanted {
        if !is_file {
            sink.folder(&path)?;
            continue;
        }
        let raw = archive.by_index_data(index).map(|e| e.name_raw().to_vec()).unwrap_or_default();
        let mut member =
            archive.by_index(index).map_err(|e| sink.refuse(&raw, MemberFault::Damaged(e.to_string())))?;
        let declared = member.size();
        sink.file(&raw, &path, declared, &mut member)?;
    }
    Ok(())
}

/// Whether a member is a file (`true`) or a folder.
fn kind(entry: &ZipFileEntry) -> Result<bool, MemberFault> {
    let is_folder = entry.name_raw().ends_with(b"/");
    match (entry.external_attributes() >> 16) & KIND {
        0 => {}
        0o100_000 if !is_folder => {}
        0o040_000 if is_folder => {}
        0o120_000 => return Err(MemberFault::Kind("symbolic link")),
        0o020_000 | 0o060_000 => return Err(MemberFault::Kind("device")),
        0o010_000 => return Err(MemberFault::Kind("named pipe")),
        0o100_000 | 0o040_000 => return Err(MemberFault::FileAndFolder),
        _ => return Err(MemberFault::Kind("special file")),
    }
    if entry.encrypted() {
        return Err(MemberFault::Encrypted);
    }
    match entry.compression() {
        CompressionMethod::Stored | CompressionMethod::Deflated => Ok(!is_folder),
        other => Err(MemberFault::Method(other.to_string())),
    }
}

/// Members that share packed bytes unpack to any number of times what the archive has.
fn check_overlap<R: Read + Seek>(archive: &mut ZipArchive<R>, sink: &Sink) -> Result<(), FetchError> {
    let mut ranges = Vec::with_capacity(archive.len());
    for index in 0..archive.len() {
        let raw = archive.by_index_data(index).map(|e| e.name_raw().to_vec()).unwrap_or_default();
        let damaged = |what: String| sink.refuse(&raw, MemberFault::Damaged(what));
        let member = archive.by_index_raw(index).map_err(|e| damaged(e.to_string()))?;
        let end = member.data_start().and_then(|start| start.checked_add(member.compressed_size()));
        let end = end.ok_or_else(|| damaged("it ends nowhere".into()))?;
        ranges.push((member.header_start(), end, raw));
    }
    ranges.sort();
    let list = archive.central_directory_start();
    let next = ranges.iter().skip(1).map(|r| r.0).chain([list]);
    match ranges.iter().zip(next).find(|((_, end, _), next)| end > next) {
        Some(((_, _, raw), _)) => Err(sink.refuse(raw, MemberFault::Overlap)),
        None => Ok(()),
    }
}

/// The first name that is in the list of members for the second time.
fn first_repeated(mut reader: impl Read + Seek, start: u64) -> Option<Vec<u8>> {
    reader.seek(SeekFrom::Start(start)).ok()?;
    let mut seen = HashSet::new();
    loop {
        let mut header = [0; HEADER];
        reader.read_exact(&mut header).ok()?;
        let length = |at: usize| -> Option<usize> {
            Some(u16::from_le_bytes([*header.get(at)?, *header.get(at + 1)?]).into())
        };
        let mut name = vec![0; length(28)?];
        reader.read_exact(&mut name).ok()?;
        let rest = i64::try_from(length(30)? + length(32)?).ok()?;
        reader.seek(SeekFrom::Current(rest)).ok()?;
        if !seen.insert(name.clone()) {
            return Some(name);
        }
    }
}

/// Servers that have lost a file like to answer with a page.
fn starts_as_page(reader: &mut (impl Read + Seek)) -> bool {
    let mut start = [0; 64];
    let n = reader.read(&mut start).unwrap_or(0);
    start.iter().take(n).find(|b| !b.is_ascii_whitespace()) == Some(&b'<')
}
