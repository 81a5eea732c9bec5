//! Progress of a running experiment, published to a file for `serve` and other observers.
//!
//! A run counts in a [`ProgressWatch`]; [`publish`] writes snapshots of it into the store's hidden folder every half
//! second, and [`running`] reads those of all runs of a results folder. Progress is no part of results or addresses,
//! and a run whose progress cannot be written goes on as usual.
//!
//! ```text
//! results/.store/running/
//!   lock                 advisory lock: held while a run enters and leaves the folder
//!   run-*/lock           advisory lock: held by the run until it ends
//!   run-*/progress.json  a [`ProgressSnapshot`], replaced whole
//! ```
//!
//! A run that finishes removes its folder. One that was interrupted, killed or has failed leaves it, with a lock that
//! no process holds: it has stopped. The next run of the same experiment, or of the same shard of it, removes it.

use crate::plan::Shard;
use crate::spec::Experiment;
use crate::store::{FOLDER, temporary_in};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use trackfail_dataset::text;

/// Version of the file's format.
/// - 1: first version.
pub const FORMAT: u32 = 1;
/// Time between two snapshots.
const TICK: Duration = Duration::from_millis(500);
/// Largest number of sequences that a snapshot names.
const MAX_NAMES: usize = 16;
/// Largest number of runs that are read.
const MAX_RUNS: usize = 1000;
/// Size of the largest file that is read, in bytes.
const MAX_FILE: u64 = 64 << 10;
/// Seconds without a snapshot after which a run counts as stopped, where locks do not work.
const MAX_SILENCE: u64 = 30;
const RUNNING: &str = "running";
const LOCK: &str = "lock";
const PROGRESS: &str = "progress.json";

/// Counters of a run.
#[derive(Debug, Default)]
pub struct ProgressWatch {
    frames: [AtomicU64; 2],
    cells: [AtomicU64; 2],
    work: Mutex<Work>,
}

#[derive(Debug, Default)]
struct Work {
    stage: &'static str,
    last: u64,
    now: BTreeMap<u64, String>,
}

impl ProgressWatch {
    fn work(&self) -> std::sync::MutexGuard<'_, Work> {
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the number of frames done, and of all frames to do.
    pub fn frames(&self, done: u64, all: u64) {
        // Threads report in any order.
        self.frames[0].fetch_max(done, Ordering::Relaxed);
        self.frames[1].store(all, Ordering::Relaxed);
    }

    /// Sets the number of cells to judge.
    pub fn all_cells(&self, all: usize) {
        self.cells[1].store(all as u64, Ordering::Relaxed);
    }

    /// Adds cells that are judged, or known to have no result.
    pub fn cells(&self, more: usize) {
        self.cells[0].fetch_add(more as u64, Ordering::Relaxed);
    }

    /// Sets the stage that begins.
    pub fn stage(&self, words: &'static str) {
        self.work().stage = words;
    }

    /// Shows a sequence as being worked on until the returned guard is dropped.
    pub fn enter(&self, name: &str) -> ActiveSequence<'_> {
        let mut work = self.work();
        work.last += 1;
        let key = work.last;
        work.now.insert(key, name.to_string());
        ActiveSequence { watch: self, key }
    }

    fn snapshot(&self, head: &ProgressSnapshot) -> ProgressSnapshot {
        let read = |pair: &[AtomicU64; 2]| [0, 1].map(|k: usize| pair[k].load(Ordering::Relaxed));
        let work = self.work();
        let mut now: Vec<String> = work.now.values().take(MAX_NAMES).cloned().collect();
        now.dedup();
        let stage = work.stage.to_string();
        ProgressSnapshot {
            stage,
            frames: read(&self.frames),
            cells: read(&self.cells),
            now,
            updated: clock(),
            ..head.clone()
        }
    }
}

/// A sequence that is being worked on.
pub struct ActiveSequence<'w> {
    watch: &'w ProgressWatch,
    key: u64,
}

impl Drop for ActiveSequence<'_> {
    fn drop(&mut self) {
        self.watch.work().now.remove(&self.key);
    }
}

/// Progress of a run at one time, as written to its file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgressSnapshot {
    /// [`FORMAT`] of the writer.
    pub format: u32,
    /// Name of the experiment.
    pub experiment: String,
    /// Title of the experiment.
    pub title: String,
    /// The shard of the experiment that is run, as in `1/4`; empty for the whole experiment.
    pub shard: String,
    /// When it began, in seconds since 1970.
    pub started: u64,
    /// When this was written, in seconds since 1970.
    pub updated: u64,
    /// The current stage.
    pub stage: String,
    /// Number of frames done and of all frames to do, without those whose tracks were in the store.
    pub frames: [u64; 2],
    /// Number of cells done and of all cells.
    pub cells: [u64; 2],
    /// Names of sequences that are being worked on.
    pub now: Vec<String>,
}

/// A run as its observers see it: running or stopped.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ObservedRun {
    /// Whether its process is running.
    pub alive: bool,
    /// Its last snapshot.
    #[serde(flatten)]
    pub snapshot: ProgressSnapshot,
}

/// Seconds since 1970.
pub fn clock() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs())
}

/// Publishes the progress of a run until dropped.
pub struct ProgressPublisher {
    folder: PathBuf,
    lock: File,
    head: ProgressSnapshot,
    watch: Arc<ProgressWatch>,
    thread: Option<(mpsc::Sender<()>, JoinHandle<()>)>,
    finished: bool,
}

/// Starts to publish the progress of a run in its results folder; `None` where that cannot be written.
pub fn publish(
    results: &Path,
    experiment: &Experiment,
    shard: Option<Shard>,
    watch: &Arc<ProgressWatch>,
) -> Option<ProgressPublisher> {
    let parent = results.join(FOLDER).join(RUNNING);
    std::fs::create_dir_all(&parent).ok()?;
    let now = clock();
    let head = ProgressSnapshot {
        format: FORMAT,
        experiment: experiment.name.clone(),
        title: experiment.title.chars().take(500).collect(),
        shard: shard.map_or_else(String::new, |s| format!("{}/{}", s.number, s.of)),
        started: now,
        updated: now,
        stage: String::new(),
        frames: [0; 2],
        cells: [0; 2],
        now: Vec::new(),
    };
    let (folder, lock) = {
        // While this lock is held, no other run can mistake the new folder for an abandoned one.
        let _lock = lock(&parent.join(LOCK))?;
        sweep(&parent, &head);
        let mut folder = tempfile::Builder::new();
        #[cfg(unix)]
        folder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
        let folder = folder.prefix("run-").tempdir_in(&parent).ok()?.keep();
        let lock = File::options().create(true).truncate(false).write(true).open(folder.join(LOCK)).ok()?;
        // Where locks do not work, observers go by the time of the last snapshot.
        let _ = lock.try_lock();
        (folder, lock)
    };
    write(&folder, &watch.snapshot(&head));
    let (stop, stopped) = mpsc::channel();
    let (to, template, counted) = (folder.clone(), head.clone(), watch.clone());
    let thread = std::thread::Builder::new().name("progress".into()).spawn(move || {
        while stopped.recv_timeout(TICK) == Err(mpsc::RecvTimeoutError::Timeout) {
            write(&to, &counted.snapshot(&template));
        }
    });
    let thread = thread.ok().map(|thread| (stop, thread));
    Some(ProgressPublisher { folder, lock, head, watch: watch.clone(), thread, finished: false })
}

impl ProgressPublisher {
    /// Ends the publication after a finished run, and removes its folder.
    pub fn finish(mut self) {
        self.finished = true;
    }
}

impl Drop for ProgressPublisher {
    fn drop(&mut self) {
        if let Some((stop, thread)) = self.thread.take() {
            drop(stop);
            let _ = thread.join();
        }
        if self.finished {
            let _ = std::fs::remove_dir_all(&self.folder);
        } else {
            write(&self.folder, &self.watch.snapshot(&self.head));
        }
        // A child process that is being started has the file open too; see the store's own lock.
        let _ = self.lock.unlock();
    }
}

/// Opens a file and waits for its lock.
fn lock(path: &Path) -> Option<File> {
    let file = File::options().create(true).truncate(false).write(true).open(path).ok()?;
    let _ = file.lock();
    Some(file)
}

/// Replaces the snapshot of a run atomically. It need not survive a power cut, so the disk is not synchronized.
fn write(folder: &Path, snapshot: &ProgressSnapshot) {
    let Ok(mut bytes) = serde_json::to_vec_pretty(snapshot) else { return };
    bytes.push(b'\n');
    let replace = || -> Option<()> {
        let mut file = temporary_in(folder).ok()?;
        file.write_all(&bytes).ok()?;
        file.persist(folder.join(PROGRESS)).ok().map(|_| ())
    };
    // A run does not fail because its progress cannot be written.
    let _ = replace();
}

/// Whether the process that created a run's folder is running; `None` where locks do not work.
fn is_held(folder: &Path) -> Option<bool> {
    let path = folder.join(LOCK);
    // Opening a pipe would block.
    if !path.symlink_metadata().is_ok_and(|about| about.is_file()) {
        return Some(false);
    }
    let Ok(lock) = File::open(path) else { return None };
    match lock.try_lock_shared() {
        Ok(()) => Some(false),
        Err(TryLockError::WouldBlock) => Some(true),
        Err(TryLockError::Error(_)) => None,
    }
}

fn read(folder: &Path) -> Option<ObservedRun> {
    let bytes = text::read_at_most(&folder.join(PROGRESS), MAX_FILE).ok()?;
    let snapshot: ProgressSnapshot = serde_json::from_slice(&bytes).ok()?;
    if snapshot.format != FORMAT {
        return None;
    }
    let alive = is_held(folder).unwrap_or_else(|| clock().saturating_sub(snapshot.updated) < MAX_SILENCE);
    Some(ObservedRun { alive, snapshot })
}

/// The folders of runs, sorted by name.
fn folders(parent: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(parent) else { return Vec::new() };
    let is_run = |e: &std::fs::DirEntry| {
        e.file_name().as_encoded_bytes().starts_with(b"run-") && e.file_type().is_ok_and(|t| t.is_dir())
    };
    let mut all: Vec<PathBuf> =
        entries.filter_map(Result::ok).filter(is_run).take(MAX_RUNS).map(|e| e.path()).collect();
    all.sort();
    all
}

/// Removes the folders of stopped runs that the run of `head` replaces, and those without a readable snapshot.
fn sweep(parent: &Path, head: &ProgressSnapshot) {
    let same = |of: &ProgressSnapshot| (&of.experiment, &of.shard) == (&head.experiment, &head.shard);
    // A whole run replaces the runs of shards, too.
    let covers = |of: &ProgressSnapshot| head.shard.is_empty() && of.experiment == head.experiment;
    for folder in folders(parent) {
        let over = match read(&folder) {
            Some(run) => !run.alive && (same(&run.snapshot) || covers(&run.snapshot)),
            None => is_held(&folder) == Some(false),
        };
        if over {
            let _ = std::fs::remove_dir_all(&folder);
        }
    }
}

/// The runs that use a results folder: running ones before stopped ones, each sorted by experiment, shard and start.
pub fn running(results: &Path) -> Vec<ObservedRun> {
    let parent = results.join(FOLDER).join(RUNNING);
    let mut all: Vec<ObservedRun> = folders(&parent).iter().filter_map(|folder| read(folder)).collect();
    let number = |of: &ProgressSnapshot| of.shard.split('/').next().and_then(|n| n.parse::<u32>().ok());
    all.sort_by_cached_key(|r| {
        let snapshot = &r.snapshot;
        let (experiment, shard) = (snapshot.experiment.clone(), snapshot.shard.clone());
        (!r.alive, experiment, number(snapshot), shard, snapshot.started)
    });
    all
}

#[cfg(test)]
mod tests;
