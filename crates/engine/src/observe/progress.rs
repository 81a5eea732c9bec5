//! What a run is at, told to whoever looks while it goes on.
//!
//! A run counts in a [`ProgressWatch`]; [`tell`] writes what it has counted into the store's hidden folder every half
//! second, [`running`] reads what all runs of a results folder have told. None of it is part of results or of
//! anything that they are made from, and a run whose progress cannot be written is a run like any other.
//!
//! ```text
//! results/.store/running/
//!   lock                 advisory lock: held while a run enters and leaves the folder
//!   run-*/lock           advisory lock: held by the run as long as it lives
//!   run-*/progress.json  a [`ProgressSnapshot`], replaced whole
//! ```
//!
//! A run that is finished removes its folder. One that was interrupted, killed or has failed leaves it, with a lock
//! that nobody holds: it has stopped. The next run of the same experiment, or the same share of it, removes it.

use crate::dataset::text;
use crate::plan::Shard;
use crate::spec::Experiment;
use crate::store::{FOLDER, TEMPORARY};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Version of the file's format.
/// - 1: first version.
pub const FORMAT: u32 = 1;
/// How often a run tells what it is at.
const TICK: Duration = Duration::from_millis(500);
/// At most so many sequences are told to be worked on.
const MOST_NAMED: usize = 16;
/// At most so many runs are read.
const MOST_RUNS: usize = 1000;
/// Largest file that is read, in bytes.
const LARGEST: u64 = 64 << 10;
/// Where locks do not work, a run that has told nothing for so many seconds has stopped.
const SILENT: u64 = 30;
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

    /// Frames that are done, and all that there are to do.
    pub fn frames(&self, done: u64, all: u64) {
        // Threads tell in any order.
        self.frames[0].fetch_max(done, Ordering::Relaxed);
        self.frames[1].store(all, Ordering::Relaxed);
    }

    /// How many cells there are to judge.
    pub fn all_cells(&self, all: usize) {
        self.cells[1].store(all as u64, Ordering::Relaxed);
    }

    /// So many more cells are judged, or known to have no result.
    pub fn cells(&self, more: usize) {
        self.cells[0].fetch_add(more as u64, Ordering::Relaxed);
    }

    /// What part of the run begins.
    pub fn stage(&self, words: &'static str) {
        self.work().stage = words;
    }

    /// What is worked on as long as the answer is kept: the name of a sequence.
    pub fn at(&self, name: &str) -> At<'_> {
        let mut work = self.work();
        work.last += 1;
        let key = work.last;
        work.now.insert(key, name.to_string());
        At { watch: self, key }
    }

    fn told(&self, head: &ProgressSnapshot) -> ProgressSnapshot {
        let read = |pair: &[AtomicU64; 2]| [0, 1].map(|k: usize| pair[k].load(Ordering::Relaxed));
        let work = self.work();
        let mut now: Vec<String> = work.now.values().take(MOST_NAMED).cloned().collect();
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

/// Something that is worked on.
pub struct At<'w> {
    watch: &'w ProgressWatch,
    key: u64,
}

impl Drop for At<'_> {
    fn drop(&mut self) {
        self.watch.work().now.remove(&self.key);
    }
}

/// What a run has told.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgressSnapshot {
    /// [`FORMAT`] of the writer.
    pub format: u32,
    /// Name of the experiment.
    pub experiment: String,
    /// Title of the experiment.
    pub title: String,
    /// The share of the experiment that is run: `1/4`; empty for all of it.
    pub shard: String,
    /// When it began, in seconds since 1970.
    pub started: u64,
    /// When this was written, in seconds since 1970.
    pub updated: u64,
    /// What part of the run is under way.
    pub stage: String,
    /// Frames done and to do, without those whose tracks were in the store.
    pub frames: [u64; 2],
    /// Cells done and to do.
    pub cells: [u64; 2],
    /// Sequences that are worked on.
    pub now: Vec<String>,
}

/// A run that goes on or has stopped.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Running {
    /// Whether its process lives.
    pub alive: bool,
    /// What it has told.
    #[serde(flatten)]
    pub told: ProgressSnapshot,
}

/// Seconds since 1970.
pub fn clock() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs())
}

/// Keeps telling what a run is at, until dropped.
pub struct ProgressPublisher {
    folder: PathBuf,
    lock: File,
    head: ProgressSnapshot,
    watch: Arc<ProgressWatch>,
    thread: Option<(mpsc::Sender<()>, JoinHandle<()>)>,
    finished: bool,
}

/// Starts to tell what a run is at, below its results folder; `None` where that cannot be written.
pub fn tell(
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
        // Nobody can take the new folder for one that was left.
        let _alone = own(&parent.join(LOCK))?;
        sweep(&parent, &head);
        let folder = tempfile::Builder::new().prefix("run-").tempdir_in(&parent).ok()?.keep();
        let lock = File::options().create(true).truncate(false).write(true).open(folder.join(LOCK)).ok()?;
        // Where there are no locks, the time of the last word has to do.
        let _ = lock.try_lock();
        (folder, lock)
    };
    write(&folder, &watch.told(&head));
    let (stop, stopped) = mpsc::channel();
    let (theirs, told, counted) = (folder.clone(), head.clone(), watch.clone());
    let thread = std::thread::Builder::new().name("progress".into()).spawn(move || {
        while stopped.recv_timeout(TICK) == Err(mpsc::RecvTimeoutError::Timeout) {
            write(&theirs, &counted.told(&told));
        }
    });
    let thread = thread.ok().map(|thread| (stop, thread));
    Some(ProgressPublisher { folder, lock, head, watch: watch.clone(), thread, finished: false })
}

impl ProgressPublisher {
    /// The run has done what it was to do; nothing more is told of it.
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
            write(&self.folder, &self.watch.told(&self.head));
        }
        // A program that is being started has the file open too; see the store's own lock.
        let _ = self.lock.unlock();
    }
}

/// Opens and locks a file.
fn own(path: &Path) -> Option<File> {
    let file = File::options().create(true).truncate(false).write(true).open(path).ok()?;
    let _ = file.lock();
    Some(file)
}

/// Replaces what a run has told; readers see the old or the new. It need not survive a power cut, so the disk
/// is not waited for.
fn write(folder: &Path, told: &ProgressSnapshot) {
    let Ok(mut bytes) = serde_json::to_vec_pretty(told) else { return };
    bytes.push(b'\n');
    let replace = || -> Option<()> {
        let mut file = tempfile::Builder::new().prefix(TEMPORARY).tempfile_in(folder).ok()?;
        file.write_all(&bytes).ok()?;
        file.persist(folder.join(PROGRESS)).ok().map(|_| ())
    };
    // Nobody's run fails because nobody can look at it.
    let _ = replace();
}

/// Whether the process lives that made a run's folder; `None` where locks do not tell.
fn is_held(folder: &Path) -> Option<bool> {
    let path = folder.join(LOCK);
    // A pipe would be waited for.
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

fn read(folder: &Path) -> Option<Running> {
    let bytes = text::read_at_most(&folder.join(PROGRESS), LARGEST).ok()?;
    let told: ProgressSnapshot =
        serde_json::from_slice(&bytes).ok().filter(|told: &ProgressSnapshot| told.format == FORMAT)?;
    let alive = is_held(folder).unwrap_or_else(|| clock().saturating_sub(told.updated) < SILENT);
    Some(Running { alive, told })
}

/// The folders of runs, by name.
fn folders(parent: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(parent) else { return Vec::new() };
    let is_run = |e: &std::fs::DirEntry| {
        e.file_name().as_encoded_bytes().starts_with(b"run-") && e.file_type().is_ok_and(|t| t.is_dir())
    };
    let mut all: Vec<PathBuf> =
        entries.filter_map(Result::ok).filter(is_run).take(MOST_RUNS).map(|e| e.path()).collect();
    all.sort();
    all
}

/// Removes what runs left that have stopped, if they ran what now runs again or have told nothing.
fn sweep(parent: &Path, head: &ProgressSnapshot) {
    let same = |told: &ProgressSnapshot| (&told.experiment, &told.shard) == (&head.experiment, &head.shard);
    // A whole run goes on from what shares have left, too.
    let covers = |told: &ProgressSnapshot| head.shard.is_empty() && told.experiment == head.experiment;
    for folder in folders(parent) {
        let over = match read(&folder) {
            Some(run) => !run.alive && (same(&run.told) || covers(&run.told)),
            None => is_held(&folder) == Some(false),
        };
        if over {
            let _ = std::fs::remove_dir_all(&folder);
        }
    }
}

/// The runs that use a results folder: those that go on before those that have stopped, by experiment, share and
/// start.
pub fn running(results: &Path) -> Vec<Running> {
    let parent = results.join(FOLDER).join(RUNNING);
    let mut all: Vec<Running> = folders(&parent).iter().filter_map(|folder| read(folder)).collect();
    let number = |told: &ProgressSnapshot| told.shard.split('/').next().and_then(|n| n.parse::<u32>().ok());
    all.sort_by_cached_key(|r| {
        (!r.alive, r.told.experiment.clone(), number(&r.told), r.told.shard.clone(), r.told.started)
    });
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::{self, builtin};

    fn experiment() -> Experiment {
        let text = builtin::EXPERIMENTS.iter().find(|e| e.0 == builtin::QUICKSTART).unwrap().1;
        spec::parse("quickstart", text).unwrap()
    }

    fn left(results: &Path) -> usize {
        folders(&results.join(FOLDER).join(RUNNING)).len()
    }

    #[test]
    fn a_run_is_told_while_it_lives_and_gone_when_it_is_finished() {
        let dir = tempfile::tempdir().unwrap();
        let (experiment, watch) = (experiment(), Arc::new(ProgressWatch::default()));
        assert_eq!(running(dir.path()), []);
        watch.stage("judging");
        watch.frames(7, 9);
        watch.frames(3, 9);
        watch.all_cells(5);
        watch.cells(2);
        let girl = watch.at("Girl");
        drop(watch.at("Bolt"));
        let telling = tell(dir.path(), &experiment, None, &watch).unwrap();
        let shard = tell(dir.path(), &experiment, "2/3".parse().ok(), &watch).unwrap();
        let [all, share] = &running(dir.path())[..] else { panic!() };
        assert!(all.alive && share.alive);
        assert_eq!((all.told.shard.as_str(), share.told.shard.as_str()), ("", "2/3"));
        assert_eq!((all.told.frames, all.told.cells), ([7, 9], [2, 5]));
        assert_eq!((all.told.stage.as_str(), &all.told.now[..]), ("judging", &["Girl".to_string()][..]));
        drop(girl);
        // What is told last is told even if the next word was not due.
        drop(telling);
        let stopped = running(dir.path());
        assert_eq!(stopped.iter().map(|r| r.alive).collect::<Vec<_>>(), [true, false]);
        assert!(stopped[1].told.now.is_empty());
        shard.finish();
        assert_eq!(left(dir.path()), 1);
        // The next run of the same replaces what stopped.
        tell(dir.path(), &experiment, None, &watch).unwrap().finish();
        assert_eq!((running(dir.path()), left(dir.path())), (vec![], 0));
    }

    #[test]
    fn what_a_share_left_stays_until_it_or_the_whole_is_run_again() {
        let dir = tempfile::tempdir().unwrap();
        let (experiment, watch) = (experiment(), Arc::new(ProgressWatch::default()));
        let run = |shard: &str| tell(dir.path(), &experiment, shard.parse().ok(), &watch).unwrap();
        drop(run("10/10"));
        drop(run("2/10"));
        run("1/10").finish();
        let told: Vec<_> = running(dir.path()).into_iter().map(|r| r.told.shard).collect();
        assert_eq!(told, ["2/10", "10/10"]);
        run("2/10").finish();
        assert_eq!(left(dir.path()), 1);
        run("").finish();
        assert_eq!(left(dir.path()), 0);
    }

    #[test]
    fn foreign_files_are_passed_over_and_removed_by_the_next_run() {
        let dir = tempfile::tempdir().unwrap();
        let parent = dir.path().join(FOLDER).join(RUNNING);
        let broken = ["", "{", "[]", "{\"format\": 2}", "null"];
        for (k, text) in broken.iter().enumerate() {
            let folder = parent.join(format!("run-{k}"));
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join(PROGRESS), text).unwrap();
        }
        let huge = parent.join("run-huge");
        std::fs::create_dir_all(&huge).unwrap();
        File::create(huge.join(PROGRESS)).unwrap().set_len(LARGEST + 1).unwrap();
        assert_eq!((running(dir.path()), left(dir.path())), (vec![], broken.len() + 1));
        let experiment = experiment();
        tell(dir.path(), &experiment, None, &Arc::default()).unwrap().finish();
        assert_eq!(left(dir.path()), 0);
        // Where nothing can be written, nothing is told and nobody complains.
        let file = dir.path().join("file");
        std::fs::write(&file, "").unwrap();
        assert!(tell(&file, &experiment, None, &Arc::default()).is_none());
        assert_eq!(running(&file), []);
    }
}
