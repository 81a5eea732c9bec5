//! Store of computed results under their content addresses, in `results/.store`, and files written whole.
//!
//! ```text
//! results/.store/
//!   format        the text "trackfail-store 1"
//!   lock          advisory lock: shared while a run uses the store, exclusive while it is cleaned
//!   place         advisory lock: exclusive while results are put in their place
//!   packs/*.pack  records, see [`pack`]
//!   staging/*     results being written, see [`staging`]
//! ```
//!
//! A pack is written once, whole, and never changed: a run that is killed loses only the records that it had not yet
//! packed. Every record has a digest and a number of rows. A truncated or damaged pack is reported
//! ([`Store::problems`]) and removed, and its records are computed again; a pack that cannot be read is reported and
//! left in place. Locks are the operating system's and end with the process that holds them, however it ends; where
//! the file system has none, the store works without and is never cleaned.
//!
//! When the packs are larger than the limit, the least recently used ones (by file time) are removed. Packs
//! that the current run used are always kept. Two runs may use one store at once. If both compute the same
//! record, the store has it twice, with the same content. Of several records under one address, that in the
//! newest pack counts, so that a record computed again replaces the earlier one.
//!
//! Format of the store:
//! - 1: first version.

pub mod address;
mod file;
pub mod pack;
pub mod staging;

pub use file::{folder_of, read, read_text, write, write_derived, write_with};
pub use pack::{Head, Name, Record};

use address::{Address, Recipe, Stage};
use pack::Place;
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::SystemTime;

/// Prefix of temporary files and folders.
pub(crate) const TEMPORARY: &str = ".trackfail-tmp-";
/// Name of the store's folder in the results folder.
pub const FOLDER: &str = ".store";
const FORMAT: &str = "trackfail-store 1\n";
/// Bytes of payload, approximately, that a merge packs at once.
const MAX_BATCH: usize = 64 << 20;

/// A file that could not be written or read.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct StoreError {
    /// File or folder that is concerned.
    pub path: PathBuf,
    /// Cause of the failure.
    pub source: Arc<dyn std::error::Error + Send + Sync>,
}

impl StoreError {
    /// Error about `path`; `source` is the cause, an error or a text.
    pub fn new(path: &Path, source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        let source: Box<dyn std::error::Error + Send + Sync> = source.into();
        Self { path: path.to_path_buf(), source: source.into() }
    }
}

/// An open store, which threads may share.
pub struct Store {
    folder: PathBuf,
    index: RwLock<Index>,
    lock: Option<File>,
    writable: bool,
}

/// Packs of an open store, and the place of each record in them.
#[derive(Default)]
struct Index {
    /// Path of each pack, and true if this run has read from it or written it. The oldest comes first.
    packs: Vec<(PathBuf, AtomicBool)>,
    /// Pack index and place of each record, by address.
    places: HashMap<Address, (usize, Place)>,
    /// Addresses of a cell's records, by the key of the cell's name.
    names: HashMap<u64, Vec<Address>>,
    /// Pairs of an older pack and a newer one that has a record of the same address.
    replaced: BTreeSet<(usize, usize)>,
    /// Reports of damage.
    problems: Vec<String>,
}

impl Index {
    /// Adds a pack. Its records replace earlier ones of the same address.
    fn add(&mut self, path: PathBuf, places: Vec<Place>, is_used: bool) {
        for place in places {
            let known = self.names.entry(place.name).or_default();
            if !known.contains(&place.address) {
                known.push(place.address);
            }
            let new = self.packs.len();
            if let Some((old, _)) = self.places.insert(place.address, (new, place)) {
                self.replaced.insert((old, new));
            }
        }
        self.packs.push((path, is_used.into()));
    }

    /// Removes a pack. Returns true if it had any record.
    fn drop_pack(&mut self, pack: usize) -> bool {
        let before = self.places.len();
        self.places.retain(|_, (p, _)| *p != pack);
        self.names.values_mut().for_each(|known| known.retain(|a| self.places.contains_key(a)));
        self.places.len() < before
    }
}

/// Numbers of records in [`Store::merge`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Merged {
    /// Number of records that were added.
    pub added: usize,
    /// Number of records that the store already had.
    pub known: usize,
}

impl Drop for Store {
    fn drop(&mut self) {
        // A child process that is being started has the file open too, until it executes its program: closing the
        // file here would not release the lock.
        if let Some(lock) = &self.lock {
            let _ = lock.unlock();
        }
    }
}

impl Store {
    /// Opens the store of a results folder for reading and writing. Creates both if needed.
    ///
    /// # Errors
    /// When the folder cannot be written to, or holds a store of another format.
    pub fn open(results: &Path) -> Result<Self, StoreError> {
        let folder = results.join(FOLDER);
        for part in ["packs", "staging"] {
            let path = folder.join(part);
            std::fs::create_dir_all(&path).map_err(|e| StoreError::new(&path, e))?;
        }
        let path = folder.join("lock");
        let lock = File::options().create(true).truncate(false).write(true).open(&path);
        let lock = lock.map_err(|e| StoreError::new(&path, e))?;
        if lock.try_lock().is_ok() {
            staging::sweep(&folder.join("packs"));
            let _ = lock.unlock();
        }
        staging::sweep(&folder.join("staging"));
        let locked = lock.lock_shared().is_ok();
        let format = folder.join("format");
        if !format.exists() {
            file::write(&format, FORMAT.as_bytes())?;
        }
        let mut store = Self::read(folder, true)?;
        store.lock = locked.then_some(lock);
        Ok(store)
    }

    /// Opens the store of a results folder for reading only; an absent store is an empty one.
    ///
    /// # Errors
    /// When the store has another format or cannot be read.
    pub fn open_read_only(results: &Path) -> Result<Self, StoreError> {
        Self::read(results.join(FOLDER), false)
    }

    fn read(folder: PathBuf, writable: bool) -> Result<Self, StoreError> {
        let format = folder.join("format");
        if format.exists() {
            let found = file::read_text(&format)?;
            if found != FORMAT {
                let found = found.trim().chars().take(40).collect::<String>();
                let what = format!(
                    "`{found}` is a store of another program version; remove the folder or use another --results"
                );
                return Err(StoreError::new(&format, what));
            }
        }
        let packs = packs(&folder.join("packs"))?;
        let index_of = |path: &Path| pack::index_of(&mut pack::open(path)?, path);
        let read = |(_, path, _): (_, PathBuf, _)| (index_of(&path), path);
        let mut index = Index::default();
        for (places, path) in packs.into_par_iter().map(read).collect::<Vec<_>>() {
            match places {
                Ok(places) => index.add(path, places, false),
                Err(e) => index.problems.push(give_up(&path, &e, writable)),
            }
        }
        Ok(Self { folder, index: RwLock::new(index), lock: None, writable })
    }

    fn index(&self) -> RwLockReadGuard<'_, Index> {
        self.index.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn index_mut(&self) -> RwLockWriteGuard<'_, Index> {
        self.index.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes the reports of damage found so far, one sentence each.
    pub fn problems(&self) -> Vec<String> {
        let mut problems = std::mem::take(&mut self.index_mut().problems);
        problems.sort();
        problems
    }

    /// True if the store has a record.
    pub fn contains(&self, address: &Address) -> bool {
        self.index().places.contains_key(address)
    }

    /// Number of records.
    pub fn len(&self) -> usize {
        self.index().places.len()
    }

    /// True if the store has no records.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// True if the store has a record of a cell of that name, from any recipe.
    pub fn knows(&self, stage: Stage, cell: &str) -> bool {
        self.index().names.get(&pack::name_key(stage, cell)).is_some_and(|known| !known.is_empty())
    }

    /// Descriptions of all records of a cell's name, in the order of their addresses.
    pub fn heads(&self, stage: Stage, cell: &str) -> Vec<Head> {
        let mut known = self.index().names.get(&pack::name_key(stage, cell)).cloned().unwrap_or_default();
        known.sort();
        known.iter().filter_map(|a| self.head(a)).filter(|head| head.name.cell == cell).collect()
    }

    /// Description of a record; `None` if it is absent.
    pub fn head(&self, address: &Address) -> Option<Head> {
        self.record(address, |head, _| Ok(head))
    }

    /// Content of a record; `None` if it is absent or damaged. `rows` is the number of rows that it must
    /// have.
    pub fn get<T: DeserializeOwned>(&self, address: &Address, rows: usize) -> Option<T> {
        self.record(address, |head, payload| {
            let content = postcard::from_bytes(&payload).ok().filter(|_| head.rows == rows as u64);
            content.ok_or_else(|| format!("a record of {} rows is not one of {rows}", head.rows))
        })
    }

    /// Reads a record with `decode`. If that fails, the whole pack is given up as damaged.
    fn record<T>(
        &self,
        address: &Address,
        decode: impl FnOnce(Head, Vec<u8>) -> Result<T, String>,
    ) -> Option<T> {
        let (pack, path, place) = {
            let index = self.index();
            let (pack, place) = index.places.get(address)?;
            let (path, is_used) = &index.packs[*pack];
            is_used.store(true, Ordering::Relaxed);
            (*pack, path.clone(), place.clone())
        };
        let read = pack::open(&path).and_then(|mut pack| pack::record_of(&mut pack, &place, &path));
        let decoded =
            read.and_then(|(head, payload)| decode(head, payload).map_err(|why| StoreError::new(&path, why)));
        match decoded {
            Ok(content) => Some(content),
            Err(e) => {
                let mut index = self.index_mut();
                // Another thread may have found the same.
                if index.drop_pack(pack) {
                    index.problems.push(give_up(&path, &e, self.writable));
                }
                None
            }
        }
    }

    /// Writes records, all or none. They replace earlier ones under the same addresses.
    ///
    /// # Errors
    /// When the disk is full or the folder cannot be written to.
    pub fn put(&self, records: &[Record]) -> Result<(), StoreError> {
        if !records.is_empty() {
            let (path, places) = pack::write(&self.folder.join("packs"), records)?;
            self.index_mut().add(path, places, true);
        }
        Ok(())
    }

    /// Adds those records of another store that this one lacks.
    ///
    /// # Errors
    /// When both stores have different contents under one address (the error names the cell, nothing is
    /// added), or when a record of the other store is damaged.
    pub fn merge(&self, other: &Store) -> Result<Merged, StoreError> {
        let theirs: BTreeSet<Address> = other.index().places.keys().copied().collect();
        let whole = |head, payload| Ok(Record { head, payload });
        let read = |address: &Address| {
            let damaged =
                || StoreError::new(&other.folder, "has a record that cannot be read; run its shard again");
            other.record(address, whole).ok_or_else(damaged)
        };
        let mut fresh = Vec::new();
        for address in &theirs {
            let Some(mine) = self.record(address, whole) else {
                fresh.push(address);
                continue;
            };
            let Record { head, payload } = read(address)?;
            if mine.payload != payload {
                let (stage, cell) = (head.recipe.stage.word(), mine.head.name.cell);
                let here = self.folder.display();
                let what = format!(
                    "the {stage} of {cell} is not what {here} has, though made from the same; run both again with --force"
                );
                return Err(StoreError::new(&other.folder, what));
            }
        }
        // A pack at a time, so that stores of any size can be merged.
        let (mut batch, mut size) = (Vec::new(), 0);
        for &address in &fresh {
            let record = read(address)?;
            size += record.payload.len();
            batch.push(record);
            if size > MAX_BATCH {
                self.put(&batch)?;
                batch.clear();
                size = 0;
            }
        }
        self.put(&batch)?;
        Ok(Merged { added: fresh.len(), known: theirs.len() - fresh.len() })
    }

    /// Marks the packs that this run used, and removes the least recently used others until at most `limit`
    /// bytes are left. Does nothing while another run uses the store. Returns the number of removed packs.
    pub fn evict(mut self, limit: u64) -> usize {
        let index = std::mem::take(&mut *self.index_mut());
        // A record that was replaced would count again in a pack that is newer than that of the new one.
        for (old, new) in &index.replaced {
            index.packs[*new].1.fetch_or(index.packs[*old].1.load(Ordering::Relaxed), Ordering::Relaxed);
        }
        let used = index.packs.iter().filter(|(_, is_used)| is_used.load(Ordering::Relaxed));
        let used: Vec<&PathBuf> = used.map(|(path, _)| path).collect();
        // One after the other, so that the newest pack stays the newest. The time decides what is removed first; without
        // it a pack counts as older than it is.
        for path in &used {
            let pack = File::options().append(true).open(path);
            let _ = pack.and_then(|pack| pack.set_modified(SystemTime::now()));
        }
        let found = packs(&self.folder.join("packs")).unwrap_or_default();
        let mut left: u64 = found.iter().map(|(.., bytes)| bytes).sum();
        let Some(lock) = self.lock.take_if(|_| left > limit) else { return 0 };
        let _ = lock.unlock();
        if lock.try_lock().is_err() {
            return 0;
        }
        let used: BTreeSet<&PathBuf> = used.into_iter().collect();
        let mut removed = 0;
        for (_, path, bytes) in found.iter().filter(|(_, path, _)| !used.contains(path)) {
            if left > limit && std::fs::remove_file(path).is_ok() {
                left -= bytes;
                removed += 1;
            }
        }
        removed
    }

    /// Creates a staging folder, in which results are written before they are moved to their final place.
    ///
    /// # Errors
    /// When the folder cannot be created.
    pub fn staging(&self) -> Result<staging::Staging, StoreError> {
        staging::Staging::new(&self.folder.join("staging"))
    }

    /// Path of the folder in which the store keeps its files.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

/// Report of a pack that cannot be used. A damaged pack is removed if `writable`: computing its other records
/// again is cheaper than trusting them. A pack that the operating system refuses may be whole and is kept.
fn give_up(path: &Path, error: &StoreError, writable: bool) -> String {
    if writable && !error.source.is::<std::io::Error>() {
        // A pack that cannot be removed is reported again next time, and does no harm.
        let _ = std::fs::remove_file(path);
    }
    format!("{error}; its records are computed again")
}

/// Waits until no other process is publishing results, and blocks others until the file is dropped. `None` on
/// file systems without locks; there users must not start two runs at once.
pub fn lock_exclusive(results: &Path) -> Option<File> {
    let path = results.join(FOLDER).join("place");
    let file = File::options().create(true).truncate(false).write(true).open(path).ok()?;
    file.lock().ok().map(|()| file)
}

/// Packs in a folder with time and size, the oldest first.
fn packs(folder: &Path) -> Result<Vec<(SystemTime, PathBuf, u64)>, StoreError> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(StoreError::new(folder, e)),
    };
    let paths = entries.filter_map(|e| Some(e.ok()?.path()));
    let paths = paths.filter(|path| path.extension().is_some_and(|e| e == "pack"));
    let with_time = |path: PathBuf| {
        let about = path.metadata().ok()?;
        Some((about.modified().unwrap_or(SystemTime::UNIX_EPOCH), path, about.len()))
    };
    let mut packs: Vec<_> = paths.filter_map(with_time).collect();
    packs.sort();
    Ok(packs)
}

/// Creates a record with `content` encoded.
///
/// # Errors
/// When the content cannot be encoded, which would be a bug of its type.
pub fn record<T: Serialize>(
    name: Name,
    recipe: Recipe,
    rows: usize,
    content: &T,
) -> Result<Record, StoreError> {
    let payload = postcard::to_stdvec(content).map_err(|e| StoreError::new(Path::new(&name.cell), e))?;
    Ok(Record { head: Head { name, recipe, rows: rows as u64 }, payload })
}

#[cfg(test)]
mod tests;
