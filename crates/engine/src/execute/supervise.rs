//! Work that may panic, hang or be interrupted, on a thread of its own.
//!
//! One thread, with its helpers, steps through several jobs and tells a [`Watchdog`] which of them it is at. A job that
//! panics or has used up its time is left out, the others go on. A job that hangs cannot be stopped: its thread is
//! abandoned, to end with the process, and the work starts again without that job.

use crate::error::StepError;
use crate::limits::{Interrupted, RunLimits};
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, Mutex, Once, PoisonError, mpsc};
use std::time::{Duration, Instant};

/// Why a supervised job has no result.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum JobError {
    /// It panicked.
    #[error(transparent)]
    Panicked(#[from] Panic),
    /// It used more than this time.
    #[error("took longer than {} s (--timeout)", .0.as_secs_f64())]
    TimedOut(Duration),
}

impl From<JobError> for StepError {
    fn from(e: JobError) -> Self {
        Self::failed(e)
    }
}

/// A panic: its place, if that is in this program's own source, and its message.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Panic(String);

/// Clock and limits of a supervised thread.
pub struct Watchdog {
    limits: RunLimits,
    clock: Mutex<Clock>,
}

#[derive(Default)]
struct Clock {
    /// The jobs that are running, and the starts of their steps.
    running: Vec<(usize, Instant)>,
    /// Time that each job has used in finished steps.
    used: Vec<Duration>,
}

impl Watchdog {
    fn new(jobs: usize, limits: &RunLimits) -> Self {
        let clock = Clock { running: Vec::new(), used: vec![Duration::ZERO; jobs] };
        Self { limits: limits.clone(), clock: Mutex::new(clock) }
    }

    fn clock(&self) -> std::sync::MutexGuard<'_, Clock> {
        self.clock.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Checks whether the run was interrupted.
    ///
    /// # Errors
    /// [`Interrupted`] if so.
    pub fn check_interrupted(&self) -> Result<(), Interrupted> {
        if self.limits.stop.is_set() { Err(Interrupted) } else { Ok(()) }
    }

    /// Runs one step of a job.
    ///
    /// # Errors
    /// That of the step; a [`JobError`] when it panics or the job has used up its time.
    pub fn step<T, E: From<JobError>>(
        &self,
        job: usize,
        step: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let start = Instant::now();
        self.clock().running.push((job, start));
        let outcome = catch(step);
        let mut clock = self.clock();
        if let Some(at) = clock.running.iter().position(|step| *step == (job, start)) {
            clock.running.swap_remove(at);
        }
        if let Some(used) = clock.used.get_mut(job) {
            *used += start.elapsed();
            if let Some(timeout) = self.limits.timeout.filter(|t| *used > *t) {
                return Err(JobError::TimedOut(timeout).into());
            }
        }
        outcome.unwrap_or_else(|panic| Err(JobError::Panicked(panic).into()))
    }

    /// A job that hangs: it is running and its time is over.
    fn hung(&self) -> Option<(usize, Duration)> {
        let timeout = self.limits.timeout?;
        let clock = self.clock();
        let used = |(job, since): (usize, Instant)| {
            clock.used.get(job).copied().unwrap_or_default() + since.elapsed()
        };
        clock.running.iter().find(|step| used(**step) > timeout).map(|(job, _)| (*job, timeout))
    }
}

/// Time between two looks for a hung job or an interruption.
const TICK: Duration = Duration::from_millis(20);

/// Runs `work` for `jobs` jobs on a thread of its own. `work` gets the watchdog and, for each job, why it is left out
/// (one that hung in an earlier attempt); it must call [`Watchdog::step`] around everything that may hang.
///
/// # Errors
/// Those of `work`; [`Interrupted`], also when a hung job keeps the thread from noticing. A panic outside of a step is
/// resumed: it is a bug of this program.
pub fn supervised<T, E, F>(jobs: usize, limits: &RunLimits, work: F) -> Result<T, E>
where
    T: Send + 'static,
    E: From<Interrupted> + Send + 'static,
    F: Fn(&Watchdog, &[Option<JobError>]) -> Result<T, E> + Send + Sync + 'static,
{
    let work = Arc::new(work);
    let mut left_out: Vec<Option<JobError>> = vec![None; jobs];
    loop {
        let watch = Arc::new(Watchdog::new(jobs, limits));
        let (send, receive) = mpsc::channel();
        let (watchdog, work, without) = (watch.clone(), work.clone(), left_out.clone());
        let thread = std::thread::spawn(move || {
            // The receiver is gone when the thread was abandoned.
            let _ = send.send(work(&watchdog, &without));
        });
        let hung = loop {
            match receive.recv_timeout(TICK) {
                Ok(done) => return done,
                Err(mpsc::RecvTimeoutError::Disconnected) => match thread.join() {
                    Err(panic) => std::panic::resume_unwind(panic),
                    Ok(()) => return Err(Interrupted.into()),
                },
                Err(mpsc::RecvTimeoutError::Timeout) => {
                    if let Some(hung) = watch.hung() {
                        break hung;
                    }
                    if limits.stop.is_set() {
                        // The thread has a moment to notice by itself.
                        return receive.recv_timeout(25 * TICK).unwrap_or_else(|_| Err(Interrupted.into()));
                    }
                }
            }
        };
        if let Some(reason) = left_out.get_mut(hung.0) {
            *reason = Some(JobError::TimedOut(hung.1));
        }
    }
}

/// Runs a single job of a single step.
///
/// # Errors
/// Those of the job, of its supervision, and [`Interrupted`].
pub fn run_single<T, E, F>(limits: &RunLimits, job: F) -> Result<T, E>
where
    T: Send + 'static,
    E: From<Interrupted> + From<JobError> + Send + 'static,
    F: Fn() -> Result<T, E> + Send + Sync + 'static,
{
    supervised(1, limits, move |watch, left_out| {
        if let Some(Some(reason)) = left_out.first() {
            return Err(reason.clone().into());
        }
        watch.check_interrupted()?;
        watch.step(0, &job)
    })
}

thread_local! {
    static CATCHING: Cell<bool> = const { Cell::new(false) };
    static CAUGHT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Calls `f` and catches a panic, which is not printed.
///
/// # Errors
/// The panic.
pub fn catch<T>(f: impl FnOnce() -> T) -> Result<T, Panic> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let others = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !CATCHING.get() {
                return others(panic);
            }
            let message = panic.payload().downcast_ref::<&str>().map(|s| s.to_string());
            let message = message.or_else(|| panic.payload().downcast_ref::<String>().cloned());
            // Locations in dependencies are paths of the machine that built the program.
            let place = panic.location().filter(|l| Path::new(l.file()).is_relative());
            let place = place.map(|l| format!(" at {}:{}", l.file(), l.line())).unwrap_or_default();
            CAUGHT
                .set(Some(format!("panicked{place}: {}", message.as_deref().unwrap_or("without a message"))));
        }));
    });
    let outer = CATCHING.replace(true);
    let outcome = catch_unwind(AssertUnwindSafe(f));
    CATCHING.set(outer);
    outcome.map_err(|_| Panic(CAUGHT.take().unwrap_or_else(|| "panicked".to_string())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Stop;

    fn limits(milliseconds: u64) -> RunLimits {
        RunLimits { timeout: Some(Duration::from_millis(milliseconds)), stop: Stop::default() }
    }

    type Results = Vec<Result<usize, JobError>>;

    /// Two steps for each of three jobs; `bad` is called in the second step of job 1.
    fn work(
        bad: impl Fn() + Send + Sync + 'static,
    ) -> impl Fn(&Watchdog, &[Option<JobError>]) -> Result<Results, Interrupted> + Send + Sync {
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
                        Ok(())
                    });
                    *result = one.map(|()| *done + 1);
                }
            }
            Ok(results)
        }
    }

    #[test]
    fn a_panic_ends_its_job_only() {
        let results = supervised(3, &limits(60_000), work(|| panic!("no {}", "way"))).unwrap();
        assert_eq!((&results[0], &results[2]), (&Ok(2), &Ok(2)));
        let said = results[1].as_ref().unwrap_err().to_string();
        assert!(said.starts_with("panicked at crates/engine") && said.ends_with(": no way"), "{said}");
    }

    #[test]
    fn a_job_that_hangs_is_abandoned_and_the_others_finish() {
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
        assert_eq!(results, [Ok(2), Err(JobError::TimedOut(Duration::from_millis(200))), Ok(2)]);
    }

    #[test]
    fn a_slow_job_fails_when_its_step_ends() {
        let limits = RunLimits { timeout: Some(Duration::ZERO), stop: Stop::default() };
        let watch = Watchdog::new(1, &limits);
        let slow: JobError = watch.step(0, || Ok(())).unwrap_err();
        assert_eq!(slow.to_string(), "took longer than 0 s (--timeout)");
    }

    #[test]
    fn an_interruption_ends_the_work_even_when_a_job_hangs() {
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
