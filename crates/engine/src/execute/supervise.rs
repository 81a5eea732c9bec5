//! Work that may panic, hang or be interrupted, on a thread of its own.
//!
//! One thread steps through several jobs in turn and says in a [`Watchdog`] which of them it is at. A job that
//! panics or has used up its time is out, the others go on. A job that does not come back at all cannot
//! be stopped: its thread is left behind, to end with the process, and the work starts anew without it.

use crate::limits::{Interrupted, RunLimits};
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, Mutex, Once, PoisonError, mpsc};
use std::time::{Duration, Instant};

/// What a supervised thread is at.
pub struct Watchdog {
    limits: RunLimits,
    clock: Mutex<Clock>,
}

#[derive(Default)]
struct Clock {
    /// The job that is being stepped, and since when.
    current: Option<(usize, Instant)>,
    /// Time used so far, by job.
    used: Vec<Duration>,
}

/// What is said of a job that has used up its time.
fn too_slow(timeout: Duration) -> String {
    format!("took longer than {} s (--timeout)", timeout.as_secs_f64())
}

impl Watchdog {
    fn new(jobs: usize, limits: &RunLimits) -> Self {
        let clock = Clock { current: None, used: vec![Duration::ZERO; jobs] };
        Self { limits: limits.clone(), clock: Mutex::new(clock) }
    }

    fn clock(&self) -> std::sync::MutexGuard<'_, Clock> {
        self.clock.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the run was interrupted.
    ///
    /// # Errors
    /// [`Interrupted`] if so.
    pub fn check_interrupted(&self) -> Result<(), Interrupted> {
        if self.limits.stop.is_set() { Err(Interrupted) } else { Ok(()) }
    }

    /// One step of a job.
    ///
    /// # Errors
    /// In words, when it panics or the job has used up its time.
    pub fn step<T>(&self, job: usize, step: impl FnOnce() -> T) -> Result<T, String> {
        let start = Instant::now();
        self.clock().current = Some((job, start));
        let outcome = catch(step);
        let mut clock = self.clock();
        clock.current = None;
        if let Some(used) = clock.used.get_mut(job) {
            *used += start.elapsed();
            if let Some(timeout) = self.limits.timeout.filter(|t| *used > *t) {
                return Err(too_slow(timeout));
            }
        }
        outcome
    }

    /// The job that does not come back, if its time is over.
    fn hung(&self) -> Option<(usize, Duration)> {
        let timeout = self.limits.timeout?;
        let clock = self.clock();
        let (job, since) = clock.current?;
        let used = clock.used.get(job).copied().unwrap_or_default() + since.elapsed();
        (used > timeout).then_some((job, timeout))
    }
}

/// How often a hung job or an interruption is looked for.
const TICK: Duration = Duration::from_millis(20);

/// Runs `work` for `jobs` jobs on a thread of its own. `work` is given the watch and, for each job, why it
/// is left out (a hung one, on the second try); it must call [`Watchdog::step`] around whatever may hang.
///
/// # Errors
/// [`Interrupted`], also when a hung job keeps the thread from noticing. A panic outside of a step is
/// handed on: it is a bug of this program.
pub fn supervised<T, F>(jobs: usize, limits: &RunLimits, work: F) -> Result<T, Interrupted>
where
    T: Send + 'static,
    F: Fn(&Watchdog, &[Option<String>]) -> Result<T, Interrupted> + Send + Sync + 'static,
{
    let work = Arc::new(work);
    let mut out: Vec<Option<String>> = vec![None; jobs];
    loop {
        let watch = Arc::new(Watchdog::new(jobs, limits));
        let (send, receive) = mpsc::channel();
        let (theirs, work, left_out) = (watch.clone(), work.clone(), out.clone());
        let thread = std::thread::spawn(move || {
            // Nobody listens any more when the thread was given up.
            let _ = send.send(work(&theirs, &left_out));
        });
        let hung = loop {
            match receive.recv_timeout(TICK) {
                Ok(done) => return done,
                Err(mpsc::RecvTimeoutError::Disconnected) => match thread.join() {
                    Err(panic) => std::panic::resume_unwind(panic),
                    Ok(()) => return Err(Interrupted),
                },
                Err(mpsc::RecvTimeoutError::Timeout) => {
                    if let Some(hung) = watch.hung() {
                        break hung;
                    }
                    if limits.stop.is_set() {
                        // It has a moment to notice by itself.
                        return receive.recv_timeout(25 * TICK).unwrap_or(Err(Interrupted));
                    }
                }
            }
        };
        if let Some(reason) = out.get_mut(hung.0) {
            *reason = Some(too_slow(hung.1));
        }
    }
}

/// Runs a single job of a single step.
///
/// # Errors
/// As [`supervised`]; what goes wrong in the job is inside, in words.
pub fn run_single<T, F>(limits: &RunLimits, job: F) -> Result<Result<T, String>, Interrupted>
where
    T: Send + 'static,
    F: Fn() -> Result<T, String> + Send + Sync + 'static,
{
    supervised(1, limits, move |watch, out| {
        if let Some(Some(reason)) = out.first() {
            return Ok(Err(reason.clone()));
        }
        watch.check_interrupted()?;
        Ok(watch.step(0, &job).flatten())
    })
}

thread_local! {
    static CATCHING: Cell<bool> = const { Cell::new(false) };
    static CAUGHT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Calls `f`; a panic becomes a sentence and is not printed.
///
/// # Errors
/// The sentence.
pub fn catch<T>(f: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let others = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !CATCHING.get() {
                return others(panic);
            }
            let said = panic.payload();
            let said = said.downcast_ref::<&str>().map(|s| s.to_string());
            let said = said.or_else(|| panic.payload().downcast_ref::<String>().cloned());
            // Places in other crates are paths of the machine that built the program.
            let place = panic.location().filter(|l| Path::new(l.file()).is_relative());
            let place = place.map(|l| format!(" at {}:{}", l.file(), l.line())).unwrap_or_default();
            CAUGHT.set(Some(format!("panicked{place}: {}", said.as_deref().unwrap_or("without a message"))));
        }));
    });
    let outer = CATCHING.replace(true);
    let outcome = catch_unwind(AssertUnwindSafe(f));
    CATCHING.set(outer);
    outcome.map_err(|_| CAUGHT.take().unwrap_or_else(|| "panicked".to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Stop;

    fn limits(milliseconds: u64) -> RunLimits {
        RunLimits { timeout: Some(Duration::from_millis(milliseconds)), stop: Stop::default() }
    }

    type Results = Vec<Result<usize, String>>;

    /// Two steps for each of three jobs; `bad` does what it does in the second step of job 1.
    fn work(
        bad: impl Fn() + Send + Sync + 'static,
    ) -> impl Fn(&Watchdog, &[Option<String>]) -> Result<Results, Interrupted> + Send + Sync {
        move |watch, left_out| {
            let mut results: Results = left_out.iter().map(|out| out.clone().map_or(Ok(0), Err)).collect();
            for step in 0..2 {
                watch.check_interrupted()?;
                for (job, result) in results.iter_mut().enumerate() {
                    let Ok(done) = result else { continue };
                    let one = watch.step(job, || {
                        if (job, step) == (1, 1) {
                            bad();
                        }
                    });
                    *result = one.map(|()| *done + 1);
                }
            }
            Ok(results)
        }
    }

    #[test]
    fn a_panic_takes_out_its_job_only() {
        let results = supervised(3, &limits(60_000), work(|| panic!("no {}", "way"))).unwrap();
        assert_eq!((&results[0], &results[2]), (&Ok(2), &Ok(2)));
        let said = results[1].as_ref().unwrap_err();
        assert!(said.starts_with("panicked at crates/engine") && said.ends_with(": no way"), "{said}");
    }

    #[test]
    fn a_job_that_hangs_is_left_behind_and_the_others_finish() {
        let results = supervised(
            3,
            &limits(200),
            work(|| {
                loop {
                    std::thread::park()
                }
            }),
        )
        .unwrap();
        assert_eq!(results, [Ok(2), Err("took longer than 0.2 s (--timeout)".to_string()), Ok(2)]);
    }

    #[test]
    fn a_slow_job_is_out_when_it_comes_back() {
        let limits = RunLimits { timeout: Some(Duration::ZERO), stop: Stop::default() };
        let watch = Watchdog::new(1, &limits);
        assert_eq!(watch.step(0, || ()), Err("took longer than 0 s (--timeout)".to_string()));
    }

    #[test]
    fn an_interruption_ends_it_even_when_a_job_hangs() {
        let limits = RunLimits::default();
        let stop = limits.stop.clone();
        let outcome = supervised(
            3,
            &limits,
            work(move || {
                stop.set();
                loop {
                    std::thread::park()
                }
            }),
        );
        assert_eq!(outcome, Err(Interrupted));
        assert_eq!(supervised(3, &limits, work(|| ())), Err(Interrupted), "set already");
    }
}
