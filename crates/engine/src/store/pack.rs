//! Packs: immutable files of records, written once and whole.
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
//! The index holds the digest of every record, so that every changed byte is detected: in the index when the store is
//! opened, in a record when it is read. A pack is named after the digest of its index.

use super::StoreError;
use super::address::{Address, Recipe, Stage};
use super::file;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use trackfail_core::num::hexadecimal;

const MAGIC: &[u8; 16] = b"trackfail-pack/1";
const TAIL: u64 = 8 + 32 + 16;
/// Largest index or record in bytes; one that claims to be larger is damaged.
const MAX_LENGTH: u64 = 1 << 30;

/// A pack that could not be read.
#[derive(Debug, thiserror::Error)]
pub enum PackError {
    /// Its content is not what was written.
    #[error(transparent)]
    Damaged(StoreError),
    /// The operating system refused; the pack may be whole.
    #[error(transparent)]
    Unreadable(StoreError),
}

impl PackError {
    fn damaged(path: &Path, source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Self::Damaged(StoreError::new(path, source))
    }

    fn io(path: &Path, e: std::io::Error) -> Self {
        match e.kind() {
            std::io::ErrorKind::UnexpectedEof => Self::damaged(path, "is truncated"),
            _ => Self::Unreadable(StoreError::new(path, e)),
        }
    }
}

/// Description of a record, stored with it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Head {
    /// Name of the result in the experiment that made it; for `why` only, never an ingredient.
    pub name: Name,
    /// Recipe of the result.
    pub recipe: Recipe,
    /// Number of rows (frames, or 1) the payload must have.
    pub rows: u64,
}

/// Name of a result in the experiment that made it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Name {
    /// The experiment.
    pub experiment: String,
    /// `suite/sequence/tracker/run/method`, as far as the stage has them.
    pub cell: String,
}

/// Place of a record in a pack, and the digest it must have.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// Its address.
    pub address: Address,
    /// [`name_key`] of its name.
    pub name: u64,
    /// First byte in the pack.
    pub offset: u64,
    /// Bytes of head and payload.
    pub length: u64,
    /// SHA-256 of head and payload.
    pub digest: [u8; 32],
}

/// A record to be written.
pub struct Record {
    /// Its description.
    pub head: Head,
    /// Its content, encoded.
    pub payload: Vec<u8>,
}

/// Key of a cell's name in the index, whichever experiment the cell was made for.
pub fn name_key(stage: Stage, cell: &str) -> u64 {
    trackfail_core::num::seed::seed(0, &[stage.word(), cell])
}

/// Writes a pack into `folder`. Returns its path and index.
///
/// # Errors
/// When the folder cannot be written to.
pub fn write(folder: &Path, records: &[Record]) -> Result<(PathBuf, Vec<Place>), StoreError> {
    let fail = |e: std::io::Error| StoreError::new(folder, e);
    let not_encoded = |e: postcard::Error| StoreError::new(folder, e);
    let mut temporary = file::temporary_in(folder).map_err(fail)?;
    let mut bytes = MAGIC.to_vec();
    let mut index = Vec::with_capacity(records.len());
    for record in records {
        let offset = bytes.len();
        bytes = postcard::to_extend(&record.head, bytes).map_err(not_encoded)?;
        bytes.extend_from_slice(&record.payload);
        if (bytes.len() - offset) as u64 > MAX_LENGTH {
            return Err(StoreError::new(folder, "a record of more than 1 GiB"));
        }
        let digest = Sha256::digest(&bytes[offset..]).into();
        let length = (bytes.len() - offset) as u64;
        let name = name_key(record.head.recipe.stage, &record.head.name.cell);
        index.push(Place {
            address: record.head.recipe.address(),
            name,
            offset: offset as u64,
            length,
            digest,
        });
    }
    let listed = postcard::to_stdvec(&index).map_err(not_encoded)?;
    let digest = Sha256::digest(&listed);
    bytes.extend_from_slice(&listed);
    bytes.extend_from_slice(&(listed.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&digest);
    bytes.extend_from_slice(MAGIC);
    temporary.write_all(&bytes).map_err(fail)?;
    let path = folder.join(format!("{}.pack", hexadecimal(&digest[..20])));
    file::persist(temporary, &path)?;
    Ok((path, index))
}

/// The index of a pack; `Ok(None)` when the file does not exist.
///
/// # Errors
/// When the file is not a whole pack.
pub fn read_index(path: &Path) -> Result<Option<Vec<Place>>, PackError> {
    open(path)?.map(|mut pack| index_of(&mut pack, path)).transpose()
}

fn open(path: &Path) -> Result<Option<std::fs::File>, PackError> {
    match std::fs::File::open(path) {
        Ok(pack) => Ok(Some(pack)),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(PackError::io(path, e)),
    }
}

/// The index of a pack from any reader; `path` is for errors.
///
/// # Errors
/// When it is not a whole pack.
pub fn index_of<R: Read + Seek>(pack: &mut R, path: &Path) -> Result<Vec<Place>, PackError> {
    let damaged = |what: &str| PackError::damaged(path, what);
    let size = pack.seek(SeekFrom::End(0)).map_err(|e| PackError::io(path, e))?;
    let mut tail = [0; TAIL as usize];
    let read = |pack: &mut R, from: u64, into: &mut [u8]| {
        pack.seek(SeekFrom::Start(from))
            .and_then(|_| pack.read_exact(into))
            .map_err(|e| PackError::io(path, e))
    };
    let first = MAGIC.len() as u64;
    let Some(end) = size.checked_sub(TAIL).filter(|end| *end >= first) else {
        return Err(damaged("is truncated"));
    };
    read(pack, end, &mut tail)?;
    let (length, rest) = tail.split_at(8);
    let (digest, magic) = rest.split_at(32);
    let length = length.iter().rev().fold(0_u64, |n, byte| (n << 8) | u64::from(*byte));
    if magic != MAGIC {
        return Err(damaged("is truncated"));
    }
    let Some(start) = end.checked_sub(length).filter(|s| *s >= first && length <= MAX_LENGTH) else {
        return Err(damaged("has an index that cannot be its own"));
    };
    let mut index = vec![0; length as usize];
    read(pack, start, &mut index)?;
    if Sha256::digest(&index).as_slice() != digest {
        return Err(damaged("has a damaged index"));
    }
    let index: Vec<Place> = postcard::from_bytes(&index).map_err(|e| PackError::damaged(path, e))?;
    let mut head = [0; MAGIC.len()];
    read(pack, 0, &mut head)?;
    let inside = |p: &Place| p.offset >= first && p.offset.checked_add(p.length).is_some_and(|e| e <= start);
    if &head != MAGIC || !index.iter().all(inside) {
        return Err(damaged("is damaged"));
    }
    Ok(index)
}

/// Head and payload of a record; `Ok(None)` when the file does not exist.
///
/// # Errors
/// When it is not the record that `place` describes.
pub fn read_record(path: &Path, place: &Place) -> Result<Option<(Head, Vec<u8>)>, PackError> {
    open(path)?.map(|mut pack| record_of(&mut pack, place, path)).transpose()
}

/// Head and payload of a record of a pack from any reader; `path` is for errors.
///
/// # Errors
/// When it is not the record that `place` describes.
pub fn record_of<R: Read + Seek>(
    pack: &mut R,
    place: &Place,
    path: &Path,
) -> Result<(Head, Vec<u8>), PackError> {
    let damaged = || PackError::damaged(path, "holds a damaged record");
    if place.length > MAX_LENGTH {
        return Err(damaged());
    }
    let mut bytes = vec![0; place.length as usize];
    let read = pack.seek(SeekFrom::Start(place.offset)).and_then(|_| pack.read_exact(&mut bytes));
    read.map_err(|e| PackError::io(path, e))?;
    if Sha256::digest(&bytes).as_slice() != place.digest {
        return Err(damaged());
    }
    let (head, payload): (Head, &[u8]) = postcard::take_from_bytes(&bytes).map_err(|_| damaged())?;
    if head.recipe.address() != place.address {
        return Err(damaged());
    }
    let payload = payload.to_vec();
    Ok((head, payload))
}
