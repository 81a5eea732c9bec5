//! Store of computed results under their content addresses, in `results/.store`, and plain files written whole.
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
//! When the packs are larger than the limit, the least recently used ones (by the times of their files) are removed,
//! but never one that the current run has used. Two runs may use one store at once: both may compute the same record,
//! which the store then has twice, with the same content.
//!
//! Format of the store:
//! - 1: first version.

pub mod address;
mod file;
mod index;
pub mod pack;
pub mod staging;

pub use file::{check_output, folder_of, read, read_text, write, write_derived, write_output, write_with};
pub use pack::{Head, Name, Record};

use address::{Address, Recipe, Stage};
use index::Index;
use pack::{PackError, Place};
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError, RwLock};

/// Prefix of temporary files and folders.
pub(crate) const TEMPORARY: &str = ".trackfail-tmp-";
/// Name of the store's folder in the results folder.
pub const FOLDER: &str = ".store";
const FORMAT: &str = "trackfail-store 1\n";
/// Bytes of payload that a merge packs at once, about.
const MAX_BATCH: usize = 64 << 20;

/// A file that could not be written or read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct StoreError {
    /// The file or folder.
    pub path: PathBuf,
    /// Cause of the failure.
    pub source: Box<dyn std::error::Error + Send + Sync>,
}

impl StoreError {
    /// An error about `path`; its source is an error, or a text.
    pub fn new(path: &Path, source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Self { path: path.to_path_buf(), source: source.into() }
    }
}

/// An open store. Threads may share it.
pub struct Store {
    folder: PathBuf,
    index: RwLock<Index>,
    problems: Mutex<Vec<String>>,
    lock: Option<File>,
    writable: bool,
}

/// Result of [`Store::evict`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Evicted {
    /// Number of packs that were removed.
    pub packs: usize,
    /// Bytes of the packs that are left.
    pub bytes: u64,
}

/// Result of [`Store::merge`].
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
    /// Opens the store of a results folder for reading and writing; creates both if need be.
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
        let indices: Vec<_> = packs.into_par_iter().map(|path| (pack::read_index(&path), path)).collect();
        let mut index = Index::default();
        let mut problems = Vec::new();
        for (places, path) in indices {
            match places {
                Ok(Some(places)) => {
                    index.add(path, places);
                }
                Ok(None) => {}
                Err(e) => {
                    problems.push(format!("{e}; its records are computed again"));
                    if writable && matches!(e, PackError::Damaged(_)) {
                        // A pack that cannot be removed is reported again next time, and does no harm.
                        let _ = std::fs::remove_file(path);
                    }
                }
            }
        }
        let (index, problems) = (RwLock::new(index), Mutex::new(problems));
        Ok(Self { folder, index, problems, lock: None, writable })
    }

    fn index(&self) -> std::sync::RwLockReadGuard<'_, Index> {
        self.index.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn index_mut(&self) -> std::sync::RwLockWriteGuard<'_, Index> {
        self.index.write().unwrap_or_else(PoisonError::into_inner)
    }

    fn report(&self, problem: String) {
        self.problems.lock().unwrap_or_else(PoisonError::into_inner).push(problem);
    }

    /// Takes the reports of damage found so far, in sentences.
    pub fn problems(&self) -> Vec<String> {
        let mut problems = std::mem::take(&mut *self.problems.lock().unwrap_or_else(PoisonError::into_inner));
        problems.sort();
        problems
    }

    /// Whether the store has a record.
    pub fn contains(&self, address: &Address) -> bool {
        self.index().places.contains_key(address)
    }

    /// Number of records.
    pub fn len(&self) -> usize {
        self.index().places.len()
    }

    /// Whether the store has no record.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether a cell of that name was computed before, from any recipe.
    pub fn knows(&self, stage: Stage, cell: &str) -> bool {
        let index = self.index();
        !index.names.is_empty()
            && index.names.get(&pack::name_key(stage, cell)).is_some_and(|a| !a.is_empty())
    }

    /// Heads of all records of a cell's name, in the order of their addresses.
    pub fn heads(&self, stage: Stage, cell: &str) -> Vec<Head> {
        let addresses = self.index().names.get(&pack::name_key(stage, cell)).cloned().unwrap_or_default();
        let addresses: BTreeSet<Address> = addresses.into_iter().collect();
        addresses.iter().filter_map(|a| self.head(a)).filter(|head| head.name.cell == cell).collect()
    }

    /// Head of a record.
    pub fn head(&self, address: &Address) -> Option<Head> {
        self.raw(address).map(|(head, _)| head)
    }

    fn raw(&self, address: &Address) -> Option<(Head, Vec<u8>)> {
        let (pack, path, place) = {
            let index = self.index();
            let (pack, place) = index.places.get(address)?;
            (*pack, index.packs.get(*pack as usize)?.clone(), place.clone())
        };
        match pack::read_record(&path, &place) {
            Ok(Some(found)) => {
                if !self.index().used.contains(&pack) {
                    self.index_mut().used.insert(pack);
                }
                Some(found)
            }
            Ok(None) => None,
            Err(PackError::Damaged(e)) => {
                self.drop_damaged(pack, &path, &e.to_string());
                None
            }
            Err(PackError::Unreadable(e)) => {
                self.report(format!("{e}; its records are computed again"));
                self.index_mut().drop_pack(pack);
                None
            }
        }
    }

    /// Removes a pack with a damaged record: its other records are cheaper to compute again than to trust.
    fn drop_damaged(&self, pack: u32, path: &Path, why: &str) {
        self.report(format!("{why}; its records are computed again"));
        self.index_mut().drop_pack(pack);
        if self.writable {
            let _ = std::fs::remove_file(path);
        }
    }

    /// Content of a record; `None` when it is absent or damaged. `rows` is the number of rows it must have.
    pub fn get<T: DeserializeOwned>(&self, address: &Address, rows: usize) -> Option<T> {
        let (head, payload) = self.raw(address)?;
        let content = postcard::from_bytes(&payload).ok().filter(|_| head.rows == rows as u64);
        if content.is_none() {
            let pack = self.index().places.get(address).map(|(pack, _)| *pack)?;
            let path = self.index().packs.get(pack as usize)?.clone();
            let why = format!("{}: a record of {} rows is not one of {rows}", path.display(), head.rows);
            self.drop_damaged(pack, &path, &why);
        }
        content
    }

    /// Writes records, all of them or none.
    ///
    /// # Errors
    /// When the disk is full or the folder cannot be written to.
    pub fn put(&self, records: &[Record]) -> Result<(), StoreError> {
        if records.is_empty() {
            return Ok(());
        }
        let (path, places) = pack::write(&self.folder.join("packs"), records)?;
        let mut index = self.index_mut();
        let pack = index.add(path, places);
        index.used.insert(pack);
        Ok(())
    }

    /// Whether the store has another content under the record's address; if so, that is reported.
    pub fn differs(&self, record: &Record) -> bool {
        let address = record.head.recipe.address();
        let places: Vec<(PathBuf, Place)> = {
            let index = self.index();
            let all =
                index.places.get(&address).into_iter().chain(index.twins.get(&address).into_iter().flatten());
            all.filter_map(|(pack, place)| Some((index.packs.get(*pack as usize)?.clone(), place.clone())))
                .collect()
        };
        let contents =
            places.iter().filter_map(|(path, place)| pack::read_record(path, place).ok().flatten());
        let other = contents.into_iter().find(|(_, payload)| *payload != record.payload);
        let differs = other.is_some();
        if let Some((head, _)) = other {
            let (stage, cell) = (head.recipe.stage.word(), &head.name.cell);
            self.report(format!(
                "{cell}: computed again, its {stage} differ from the stored ones; a version was not raised, or a computation is not repeatable"
            ));
        }
        differs
    }

    /// Removes the packs that hold these records, because their contents differ from what is computed now.
    pub fn forget(&self, addresses: &[Address]) {
        let packs: BTreeSet<u32> = {
            let index = self.index();
            let twins = |a| index.twins.get(a).into_iter().flatten();
            let all = addresses.iter().flat_map(|a| index.places.get(a).into_iter().chain(twins(a)));
            all.map(|(pack, _)| *pack).collect()
        };
        for pack in packs {
            let path = self.index().packs.get(pack as usize).cloned();
            self.index_mut().drop_pack(pack);
            if let Some(path) = path {
                let _ = std::fs::remove_file(path);
            }
        }
    }

    /// Adds the records of another store that this one lacks.
    ///
    /// # Errors
    /// When the two have different contents under one address, naming the cell; nothing is added then. When
    /// a record of the other store is damaged.
    pub fn merge(&self, other: &Store) -> Result<Merged, StoreError> {
        let theirs: BTreeSet<Address> = other.index().places.keys().copied().collect();
        let read = |address: &Address| {
            let damaged =
                || StoreError::new(&other.folder, "has a record that cannot be read; run its shard again");
            other.raw(address).ok_or_else(damaged)
        };
        let mut fresh = Vec::new();
        for address in &theirs {
            let Some((mine, content)) = self.raw(address) else {
                fresh.push(*address);
                continue;
            };
            let (head, payload) = read(address)?;
            if content != payload {
                let (stage, cell, here) = (head.recipe.stage.word(), mine.name.cell, self.folder.display());
                let what = format!(
                    "the {stage} of {cell} is not what {here} has, though made from the same; run both again with --force"
                );
                return Err(StoreError::new(&other.folder, what));
            }
        }
        let merged = Merged { added: fresh.len(), known: theirs.len() - fresh.len() };
        // A pack at a time, so that stores of any size can be merged.
        let (mut batch, mut size) = (Vec::new(), 0);
        for address in &fresh {
            let (head, payload) = read(address)?;
            size += payload.len();
            batch.push(Record { head, payload });
            if size > MAX_BATCH {
                self.put(&batch)?;
                batch.clear();
                size = 0;
            }
        }
        self.put(&batch)?;
        Ok(merged)
    }

    /// Marks the packs that this run used, and removes the least recently used others until at most `limit` bytes are
    /// left. Nothing is removed while another run uses the store.
    pub fn evict(mut self, limit: u64) -> Evicted {
        let now = std::time::SystemTime::now();
        let index = std::mem::take(self.index.get_mut().unwrap_or_else(PoisonError::into_inner));
        let used: BTreeSet<&PathBuf> =
            index.used.iter().filter_map(|p| index.packs.get(*p as usize)).collect();
        for path in &used {
            // The time only decides what is removed first; without it the pack counts as older than it is.
            let _ = File::options().append(true).open(path).and_then(|pack| pack.set_modified(now));
        }
        let mut found: Vec<(std::time::SystemTime, PathBuf, u64)> = Vec::new();
        for path in packs(&self.folder.join("packs")).unwrap_or_default() {
            if let Ok(about) = path.metadata() {
                found.push((about.modified().unwrap_or(now), path, about.len()));
            }
        }
        let mut left = Evicted { packs: 0, bytes: found.iter().map(|(_, _, bytes)| bytes).sum() };
        let Some(lock) = self.lock.take() else { return left };
        let _ = lock.unlock();
        if left.bytes <= limit
            || matches!(lock.try_lock(), Err(TryLockError::WouldBlock | TryLockError::Error(_)))
        {
            return left;
        }
        found.sort();
        for (_, path, bytes) in found.iter().filter(|(_, path, _)| !used.contains(path)) {
            if left.bytes <= limit {
                break;
            }
            if std::fs::remove_file(path).is_ok() {
                left.bytes -= bytes;
                left.packs += 1;
            }
        }
        left
    }

    /// A new staging folder, in which results are written before they take their place.
    ///
    /// # Errors
    /// When it cannot be created.
    pub fn staging(&self) -> Result<staging::Staging, StoreError> {
        staging::Staging::new(&self.folder.join("staging"))
    }

    /// Folder of the store.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

/// Waits until no other process is putting results in their place, and keeps others from it until the file is dropped.
/// `None` where the file system has no locks; there the user must not start two runs at once.
pub fn lock_exclusive(results: &Path) -> Option<File> {
    let path = results.join(FOLDER).join("place");
    let file = File::options().create(true).truncate(false).write(true).open(path).ok()?;
    file.lock().ok().map(|()| file)
}

/// The packs in a folder, sorted by name.
fn packs(folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(StoreError::new(folder, e)),
    };
    let paths = entries.filter_map(|e| Some(e.ok()?.path()));
    let mut packs: Vec<PathBuf> = paths.filter(|p| p.extension().is_some_and(|e| e == "pack")).collect();
    packs.sort();
    Ok(packs)
}

/// A record with `content` encoded.
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
