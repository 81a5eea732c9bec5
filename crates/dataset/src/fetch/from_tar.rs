//! Tar files compressed by gzip, in one pass.
//!
//! Headers are read one by one: the long names of GNU tar and the `path` of POSIX ones are applied here, with
//! a limit on their length. Whatever else would make one reader see other members than the next (a size in an
//! extended header, sparse files, global paths) is refused.

use super::error::FetchError;
use super::member::MemberFault;
use super::sink::{Metered, Sink, damaged};
use flate2::read::MultiGzDecoder;
use std::cell::Cell;
use std::fs::File;
use std::io::{BufReader, Read};
use std::rc::Rc;
use tar::{Archive, EntryType};

/// Most bytes of one extended header.
const MAX_HEADER: u64 = 1 << 16;

/// Bytes of headers and padding that are granted to each member beside its content.
const GRANTED: u64 = 2048;

pub(super) fn unpack(file: File, sink: &mut Sink) -> Result<(), FetchError> {
    let room = sink.room().saturating_add(GRANTED.saturating_mul(sink.caps.entries));
    let left = Rc::new(Cell::new(room));
    let inner = MultiGzDecoder::new(BufReader::new(file));
    let mut archive = Archive::new(Metered { inner, left, reason: sink.no_room() });
    let mut last: Vec<u8> = Vec::new();
    let mut renamed: Option<Vec<u8>> = None;
    let mut any = false;
    let entries = archive.entries().map_err(|e| sink.no_archive(e.to_string()))?.raw(true);
    for entry in entries {
        let mut entry = match entry {
            Ok(entry) => entry,
            Err(e) if !any => return Err(sink.no_archive(format!("not a tar.gz file: {e}"))),
            Err(e) => return Err(sink.refuse(&last, damaged(e))),
        };
        any = true;
        let own = entry.header().path_bytes().into_owned();
        let kind = entry.header().entry_type();
        if let EntryType::GNULongName | EntryType::XHeader | EntryType::XGlobalHeader = kind {
            sink.count(&own)?;
            let name = extended(&mut entry, kind).map_err(|reason| sink.refuse(&own, reason))?;
            if name.is_some() && renamed.is_some() {
                return Err(sink.refuse(&own, MemberFault::Twice));
            }
            renamed = name.or(renamed);
            continue;
        }
        let raw = renamed.take().unwrap_or(own);
        last.clone_from(&raw);
        let is_folder = match kind {
            EntryType::Directory => true,
            // Older than folders' own type.
            EntryType::Regular | EntryType::Continuous => raw.ends_with(b"/"),
            EntryType::Symlink => return Err(sink.refuse(&raw, MemberFault::Kind("symbolic link"))),
            EntryType::Link | EntryType::GNULongLink => {
                return Err(sink.refuse(&raw, MemberFault::Kind("hard link")));
            }
            EntryType::Char | EntryType::Block => return Err(sink.refuse(&raw, MemberFault::Kind("device"))),
            EntryType::Fifo => return Err(sink.refuse(&raw, MemberFault::Kind("named pipe"))),
            EntryType::GNUSparse => return Err(sink.refuse(&raw, MemberFault::Kind("sparse file"))),
            _ => return Err(sink.refuse(&raw, MemberFault::Kind("special file"))),
        };
        let declared = entry.size();
        if is_folder && declared != 0 {
            return Err(sink.refuse(&raw, MemberFault::FileAndFolder));
        }
        match sink.admit(&raw, !is_folder)? {
            Some(path) if is_folder => sink.folder(&path)?,
            Some(path) => sink.file(&raw, &path, declared, &mut entry)?,
            None if declared > sink.caps.member => {
                return Err(sink.refuse(&raw, MemberFault::Large(sink.caps.member)));
            }
            None => {}
        }
    }
    if !any || renamed.is_some() {
        return Err(sink.no_archive("a tar file without an end"));
    }
    // The checksum stands behind the last byte.
    let rest = std::io::copy(&mut archive.into_inner(), &mut std::io::sink());
    rest.map(|_| ()).map_err(|e| sink.refuse(&last, damaged(e)))
}

/// The name an extended header gives to the next member.
fn extended(entry: &mut impl Read, kind: EntryType) -> Result<Option<Vec<u8>>, MemberFault> {
    let mut text = Vec::new();
    entry.take(MAX_HEADER + 1).read_to_end(&mut text).map_err(damaged)?;
    if text.len() as u64 > MAX_HEADER {
        return Err(MemberFault::Large(MAX_HEADER));
    }
    if kind == EntryType::GNULongName {
        let end = text.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
        text.truncate(end);
        return Ok(Some(text));
    }
    let mut name = None;
    for (key, value) in records(&text)? {
        match key {
            "path" if kind == EntryType::XHeader && name.is_none() => name = Some(value.to_vec()),
            key if is_harmless(key) => {}
            other => {
                return Err(MemberFault::Header(
                    other.chars().take(40).flat_map(char::escape_debug).collect(),
                ));
            }
        }
    }
    Ok(name)
}

/// Whether a record gives times, owners and the like, which are ignored.
fn is_harmless(key: &str) -> bool {
    let plain =
        ["mtime", "atime", "ctime", "uid", "gid", "uname", "gname", "comment", "charset", "hdrcharset"];
    let vendor = key.starts_with("SCHILY.") || key.starts_with("LIBARCHIVE.");
    plain.contains(&key) || (vendor && key != "SCHILY.realsize")
}

/// The records `LENGTH KEY=VALUE\n` of an extended header; values may hold any bytes, newlines too.
fn records(mut text: &[u8]) -> Result<Vec<(&str, &[u8])>, MemberFault> {
    let damaged = || MemberFault::Damaged("an extended header that cannot be read".into());
    let mut records = Vec::new();
    while !text.is_empty() {
        let space = text.iter().position(|b| *b == b' ').ok_or_else(damaged)?;
        let (length, _) = text.split_at(space);
        let length = std::str::from_utf8(length).ok().and_then(|l| l.parse::<usize>().ok());
        let (record, rest) = length.and_then(|l| text.split_at_checked(l)).ok_or_else(damaged)?;
        let record = record.get(space + 1..).and_then(|r| r.strip_suffix(b"\n")).ok_or_else(damaged)?;
        let equals = record.iter().position(|b| *b == b'=').ok_or_else(damaged)?;
        let (key, value) = record.split_at(equals);
        let key = std::str::from_utf8(key).map_err(|_| damaged())?;
        records.push((key, value.get(1..).unwrap_or_default()));
        text = rest;
    }
    Ok(records)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    // POSIX.1-2024, pax, "pax Extended Header": the length counts itself, the space and the newline.
    #[test]
    fn records_of_extended_headers() {
        let text = b"30 mtime=1350244992.023960108\n21 path=a=b\nSCHILY.x\n";
        let wanted: [(&str, &[u8]); 2] = [("mtime", b"1350244992.023960108"), ("path", b"a=b\nSCHILY.x")];
        assert_eq!(records(text).unwrap(), wanted);
        for n in (1..30).chain(31..text.len()) {
            assert!(records(&text[..n]).is_err(), "{n}");
        }
        for bad in [
            "7 a=b\n",
            "5 a=b\n",
            "6 a-b\n",
            "x a=b\n",
            " a=b\n",
            "99999999999999999999 a=b\n",
            "1 a=b\n",
            "\0",
        ] {
            assert!(records(bad.as_bytes()).is_err(), "{bad}");
        }
        assert!(["mtime", "SCHILY.xattr.user.x", "LIBARCHIVE.creationtime"].into_iter().all(is_harmless));
        assert!(
            !["size", "linkpath", "GNU.sparse.major", "SCHILY.realsize", ""].into_iter().any(is_harmless)
        );
    }

    proptest! {
        #[test]
        fn any_bytes_are_records_or_an_error(text in "[0-9]{0,2}[ a=\n]{0,9}") {
            if let Ok(records) = records(text.as_bytes()) {
                let bytes: usize = records.iter().map(|(k, v)| k.len() + v.len()).sum();
                prop_assert!(bytes <= text.len());
            }
        }
    }
}
