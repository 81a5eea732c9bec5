//! Packs: immutable files of records, written in one go.
//!
//! ```text
//! magic   16 bytes   "trackfail-pack/1"
//! record  *          head (postcard of [`Head`]), then the payload
//! index              postcard of a list of [`Place`]
//! length  8 bytes    of the index, little-endian
//! digest  32 bytes   SHA-256 of the index
//! magic   16 bytes   again: a truncated pack lacks it
//! ```
//!
//! The index holds the digest of each record, so that any changed byte is detected: in the index when the
//! store is opened, in a record when it is read. A pack is named after the digest of its index.

use super::StoreError;
use super::address::{Address, Recipe, Stage};
use super::file;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use trackfail_core::num::hexadecimal;

const MAGIC: &[u8; 16] = b"trackfail-pack/1";
const TAIL: u64 = 8 + 32 + 16;
/// Largest index or record in bytes. A larger length in a file is a sign of damage.
const MAX_LENGTH: u64 = 1 << 30;

/// Description of a record, stored with it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Head {
    /// Name of the result in the experiment that made it, used by `why` only, not an ingredient.
    pub name: Name,
    /// Recipe of the result.
    pub recipe: Recipe,
    /// Number of rows (frames, or 1) that the payload must have.
    pub rows: u64,
}

/// Name of a result in the experiment that made it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Name {
    /// Name of the experiment.
    pub experiment: String,
    /// `suite/sequence/tracker/run/method`, or the first parts of it, depending on the stage.
    pub cell: String,
}

/// Place of a record in a pack, and its digest.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// Address of the record.
    pub address: Address,
    /// [`name_key`] of the record's name.
    pub name: u64,
    /// Offset of the first byte in the pack.
    pub offset: u64,
    /// Length of head and payload in bytes.
    pub length: u64,
    /// SHA-256 of head and payload.
    pub digest: [u8; 32],
}

/// A record to be written.
pub struct Record {
    /// Description of the record.
    pub head: Head,
    /// Encoded content.
    pub payload: Vec<u8>,
}

/// Key of a cell's name in the index, independent of the experiment.
pub fn name_key(stage: Stage, cell: &str) -> u64 {
    trackfail_core::num::seed::seed(0, &[stage.word(), cell])
}

/// Writes a pack into `folder`. Returns its path and index.
///
/// # Errors
/// When the folder cannot be written to.
pub fn write(folder: &Path, records: &[Record]) -> Result<(PathBuf, Vec<Place>), StoreError> {
    let not_encoded = |e: postcard::Error| StoreError::new(folder, e);
    let mut bytes = MAGIC.to_vec();
    let mut index = Vec::with_capacity(records.len());
    for Record { head, payload } in records {
        let offset = bytes.len();
        bytes = postcard::to_extend(head, bytes).map_err(not_encoded)?;
        bytes.extend_from_slice(payload);
        let length = (bytes.len() - offset) as u64;
        if length > MAX_LENGTH {
            return Err(StoreError::new(folder, "a record of more than 1 GiB"));
        }
        index.push(Place {
            address: head.recipe.address(),
            name: name_key(head.recipe.stage, &head.name.cell),
            offset: offset as u64,
            length,
            digest: Sha256::digest(&bytes[offset..]).into(),
        });
    }
    let listed = postcard::to_stdvec(&index).map_err(not_encoded)?;
    let digest = Sha256::digest(&listed);
    bytes.extend_from_slice(&listed);
    bytes.extend_from_slice(&(listed.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&digest);
    bytes.extend_from_slice(MAGIC);
    let path = folder.join(format!("{}.pack", hexadecimal(&digest[..20])));
    file::write(&path, &bytes)?;
    Ok((path, index))
}

/// Opens a pack.
///
/// # Errors
/// When the operating system refuses; the source is an [`std::io::Error`] then, and the pack may be
/// undamaged.
pub fn open(path: &Path) -> Result<File, StoreError> {
    File::open(path).map_err(|e| StoreError::new(path, e))
}

/// Reads `length` bytes of a pack from an offset on.
fn read<R: Read + Seek>(pack: &mut R, offset: u64, length: u64, path: &Path) -> Result<Vec<u8>, StoreError> {
    let mut bytes = vec![0; length as usize];
    let read = pack.seek(SeekFrom::Start(offset)).and_then(|_| pack.read_exact(&mut bytes));
    read.map(|()| bytes).map_err(|e| match e.kind() {
        ErrorKind::UnexpectedEof => StoreError::new(path, "is truncated"),
        _ => StoreError::new(path, e),
    })
}

/// Reads the index of a pack; `path` is for errors.
///
/// # Errors
/// When the pack is incomplete or damaged; as [`open`] when it cannot be read.
pub fn index_of<R: Read + Seek>(pack: &mut R, path: &Path) -> Result<Vec<Place>, StoreError> {
    let damaged = |what: &str| StoreError::new(path, what);
    let size = pack.seek(SeekFrom::End(0)).map_err(|e| StoreError::new(path, e))?;
    let first = MAGIC.len() as u64;
    let end = size.checked_sub(TAIL).filter(|end| *end >= first);
    let end = end.ok_or_else(|| damaged("is truncated"))?;
    let tail = read(pack, end, TAIL, path)?;
    let Some((length, rest)) = tail.split_first_chunk::<8>().filter(|_| tail.ends_with(MAGIC)) else {
        return Err(damaged("is truncated"));
    };
    let length = u64::from_le_bytes(*length);
    let start = end.checked_sub(length).filter(|start| *start >= first && length <= MAX_LENGTH);
    let start = start.ok_or_else(|| damaged("has an index that cannot be its own"))?;
    let listed = read(pack, start, length, path)?;
    if !rest.starts_with(&Sha256::digest(&listed)) {
        return Err(damaged("has a damaged index"));
    }
    let index: Vec<Place> = postcard::from_bytes(&listed).map_err(|e| StoreError::new(path, e))?;
    let inside = |p: &Place| p.offset >= first && p.offset.checked_add(p.length).is_some_and(|e| e <= start);
    if read(pack, 0, first, path)? != MAGIC || !index.iter().all(inside) {
        return Err(damaged("is damaged"));
    }
    Ok(index)
}

/// Reads head and payload of a record of a pack; `path` is for errors.
///
/// # Errors
/// When the bytes are not the record that `place` describes; as [`open`] when they cannot be read.
pub fn record_of<R: Read + Seek>(
    pack: &mut R,
    place: &Place,
    path: &Path,
) -> Result<(Head, Vec<u8>), StoreError> {
    let damaged = || StoreError::new(path, "holds a damaged record");
    if place.length > MAX_LENGTH {
        return Err(damaged());
    }
    let bytes = read(pack, place.offset, place.length, path)?;
    if Sha256::digest(&bytes).as_slice() != place.digest {
        return Err(damaged());
    }
    let (head, payload): (Head, &[u8]) = postcard::take_from_bytes(&bytes).map_err(|_| damaged())?;
    if head.recipe.address() != place.address {
        return Err(damaged());
    }
    Ok((head, payload.to_vec()))
}
