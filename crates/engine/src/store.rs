//! What was computed, kept under its content address in `results/.store`, and plain files written whole.
//!
//! ```text
//! results/.store/
//!   format        the text "trackfail-store 1"
//!   lock          advisory lock: shared while a run uses the store, exclusive while it is cleaned
//!   place         advisory lock: exclusive while results are put in their place
//!   packs/*.pack  records, see [`pack`]
//!   staging/*     results being written, see [`staging`]
//!   running/*     what runs are at, see [`progress`](crate::observe::progress)
//! ```
//!
//! A pack is written once, whole, and never changed: a run that is killed loses what it had not yet packed
//! and nothing else. Every record has a digest and a number of rows. What is cut short or damaged is
//! reported ([`Store::problems`]), removed and computed again; what cannot be read is left alone, and computed again. Locks are the operating system's and end with the
//! process that holds them, however it ends; where the file system has none, the store works without and
//! is never cleaned.
//!
//! When the packs are larger than the limit, those that were used longest ago (their files' times say
//! when) are removed, but never one that the run at hand has used. Two runs may use one store at once: both
//! may compute the same record, which is then there twice, with the same content.
//!
//! Format of the store:
//! - 1: first version.

pub mod address;
mod file;
mod index;
pub mod pack;
pub mod staging;

pub use file::{read, read_text, write};
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

/// Temporary files and folders start like this.
pub(crate) const TEMPORARY: &str = ".trackfail-tmp-";
/// Folder of the store, below the results.
pub const FOLDER: &str = ".store";
const FORMAT: &str = "trackfail-store 1\n";
/// Bytes that are joined at once, about.
const LARGEST_BATCH: usize = 64 << 20;

/// A file that could not be written or read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {what}", path.display())]
pub struct StoreError {
    /// The file.
    pub path: PathBuf,
    /// What went wrong.
    pub what: String,
}

impl StoreError {
    /// An error about `path`.
    pub fn new(path: &Path, what: impl std::fmt::Display) -> Self {
        Self { path: path.to_path_buf(), what: what.to_string() }
    }
}

/// A store that is open. May be shared by threads.
pub struct Store {
    folder: PathBuf,
    index: RwLock<Index>,
    problems: Mutex<Vec<String>>,
    lock: Option<File>,
    writable: bool,
}

/// What [`Store::collect`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Collected {
    /// Packs that were removed.
    pub packs: usize,
    /// Bytes that are left.
    pub bytes: u64,
}

/// What [`Store::join`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Joined {
    /// Records that were added.
    pub added: usize,
    /// Records that were there before.
    pub known: usize,
}

impl Drop for Store {
    fn drop(&mut self) {
        // A program that was started at this moment has the file open too, until it takes the child's place;
        // closing it here alone would not give it back.
        if let Some(lock) = &self.lock {
            let _ = lock.unlock();
        }
    }
}

impl Store {
    /// Opens the store below a results folder, which is made if need be.
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

    /// Opens the store below a results folder to look at; an absent one is an empty one.
    ///
    /// # Errors
    /// When it is there but of another format, or cannot be read.
    pub fn look(results: &Path) -> Result<Self, StoreError> {
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
                    problems.push(format!("{e}; what it held is computed again"));
                    if writable && matches!(e, PackError::Damaged(_)) {
                        // What cannot be removed is met again next time, and does no harm.
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

    /// Damage that was found, in sentences; each is told once.
    pub fn problems(&self) -> Vec<String> {
        let mut problems = std::mem::take(&mut *self.problems.lock().unwrap_or_else(PoisonError::into_inner));
        problems.sort();
        problems
    }

    /// Whether there is a record.
    pub fn contains(&self, address: &Address) -> bool {
        self.index().places.contains_key(address)
    }

    /// Number of records.
    pub fn len(&self) -> usize {
        self.index().places.len()
    }

    /// Whether there is no record.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether a cell of that name was computed before, from whatever.
    pub fn knows(&self, stage: Stage, cell: &str) -> bool {
        self.index().names.get(&pack::name_key(stage, cell)).is_some_and(|a| !a.is_empty())
    }

    /// What the records of a cell's name say of themselves, in the order of their addresses.
    pub fn named(&self, stage: Stage, cell: &str) -> Vec<Head> {
        let addresses = self.index().names.get(&pack::name_key(stage, cell)).cloned().unwrap_or_default();
        let addresses: BTreeSet<Address> = addresses.into_iter().collect();
        addresses.iter().filter_map(|a| self.head(a)).filter(|head| head.name.cell == cell).collect()
    }

    /// What a record says of itself.
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
                self.give_up(pack, &path, &e.to_string());
                None
            }
            Err(PackError::Unreadable(e)) => {
                self.report(format!("{e}; what it held is computed again"));
                self.index_mut().drop_pack(pack);
                None
            }
        }
    }

    /// Removes a pack with a damaged record: the other records of it are cheaper to compute than to trust.
    fn give_up(&self, pack: u32, path: &Path, why: &str) {
        self.report(format!("{why}; what it held is computed again"));
        self.index_mut().drop_pack(pack);
        if self.writable {
            let _ = std::fs::remove_file(path);
        }
    }

    /// The content of a record; `None` when it is not there or damaged.
    pub fn get<T: DeserializeOwned>(&self, address: &Address, rows: usize) -> Option<T> {
        let (head, payload) = self.raw(address)?;
        let content = postcard::from_bytes(&payload).ok().filter(|_| head.rows == rows as u64);
        if content.is_none() {
            let pack = self.index().places.get(address).map(|(pack, _)| *pack)?;
            let path = self.index().packs.get(pack as usize)?.clone();
            let why = format!("{}: a record of {} rows is not one of {rows}", path.display(), head.rows);
            self.give_up(pack, &path, &why);
        }
        content
    }

    /// Keeps records, all of them or none.
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

    /// Whether there is a record under the same address with another content; it is reported.
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
                "{cell}: computed anew, its {stage} is not what it was; a version was not raised, or a computation is not repeatable"
            ));
        }
        differs
    }

    /// Removes the packs that hold these records: they turned out to be other than what is computed now.
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

    /// Adds what another store has and this one has not.
    ///
    /// # Errors
    /// When the two have different content under one address, naming the cell; nothing is added then. When
    /// a record of the other store is damaged.
    pub fn join(&self, other: &Store) -> Result<Joined, StoreError> {
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
        let joined = Joined { added: fresh.len(), known: theirs.len() - fresh.len() };
        // A pack at a time, so that stores of any size can be joined.
        let (mut batch, mut size) = (Vec::new(), 0);
        for address in &fresh {
            let (head, payload) = read(address)?;
            size += payload.len();
            batch.push(Record { head, payload });
            if size > LARGEST_BATCH {
                self.put(&batch)?;
                batch.clear();
                size = 0;
            }
        }
        self.put(&batch)?;
        Ok(joined)
    }

    /// Marks what was used, and removes packs that were used longest ago until at most `limit` bytes are
    /// left; nothing is removed while another run uses the store.
    pub fn collect(mut self, limit: u64) -> Collected {
        let now = std::time::SystemTime::now();
        let index = std::mem::take(self.index.get_mut().unwrap_or_else(PoisonError::into_inner));
        let used: BTreeSet<&PathBuf> =
            index.used.iter().filter_map(|p| index.packs.get(*p as usize)).collect();
        for path in &used {
            // The time only says what to remove first; without it the pack is merely older than it is.
            let _ = File::options().append(true).open(path).and_then(|pack| pack.set_modified(now));
        }
        let mut found: Vec<(std::time::SystemTime, PathBuf, u64)> = Vec::new();
        for path in packs(&self.folder.join("packs")).unwrap_or_default() {
            if let Ok(about) = path.metadata() {
                found.push((about.modified().unwrap_or(now), path, about.len()));
            }
        }
        let mut left = Collected { packs: 0, bytes: found.iter().map(|(_, _, bytes)| bytes).sum() };
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

    /// A folder to put results together in before they take their place.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn staging(&self) -> Result<staging::Staging, StoreError> {
        staging::Staging::new(&self.folder.join("staging"))
    }

    /// Waits until no other run is putting results in their place; they may as long as this is kept.
    pub fn alone(&self) -> Option<File> {
        let file =
            File::options().create(true).truncate(false).write(true).open(self.folder.join("place")).ok()?;
        // Without locks in the file system, two runs at once are the user's to avoid.
        file.lock().ok().map(|()| file)
    }

    /// Where the store is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

/// Waits until nobody else is putting results in their place; nobody may as long as this is kept.
pub fn alone(results: &Path) -> Option<File> {
    let path = results.join(FOLDER).join("place");
    let file = File::options().create(true).truncate(false).write(true).open(path).ok()?;
    // Without locks in the file system, two runs at once are the user's to avoid.
    file.lock().ok().map(|()| file)
}

/// The packs of a folder by name.
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

/// A record of some content.
///
/// # Errors
/// When the content cannot be encoded, which would be a bug.
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
