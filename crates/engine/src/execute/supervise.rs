//! Jobs that may panic, take too long or be interrupted.

use crate::error::{RunError, StepError};
use crate::limits::RunLimits;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Once;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A job of many steps, on any threads. The time is checked after each step; a running step is never cut off.
pub struct Job<'a> {
    limits: &'a RunLimits,
    /// Nanoseconds that all steps took together.
    spent: AtomicU64,
}

impl<'a> Job<'a> {
    /// Creates a job that has not begun.
    pub fn new(limits: &'a RunLimits) -> Self {
        Self { limits, spent: AtomicU64::new(0) }
    }

    /// Time that all steps took together.
    pub fn spent(&self) -> Duration {
        Duration::from_nanos(self.spent.load(Ordering::Relaxed))
    }

    /// Runs one step.
    ///
    /// # Errors
    /// The error of the step. Also when the step panics, the job has used up its time, or the user has
    /// interrupted.
    pub fn step<T>(&self, step: impl FnOnce() -> Result<T, StepError>) -> Result<T, StepError> {
        if self.limits.stop.is_set() {
            return Err(RunError::Interrupted.into());
        }
        let start = Instant::now();
        let outcome = catch(step).unwrap_or_else(|panic| Err(StepError::Here(panic)));
        let nanoseconds = u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.spent.fetch_add(nanoseconds, Ordering::Relaxed);
        match self.limits.timeout.filter(|timeout| self.spent() > *timeout) {
            // An interruption ends programs, too.
            _ if outcome.is_err() && self.limits.stop.is_set() => Err(RunError::Interrupted.into()),
            Some(timeout) => {
                Err(StepError::Here(format!("took longer than {} s (--timeout)", timeout.as_secs_f64())))
            }
            None => outcome,
        }
    }
}

/// Runs a job of a single step on a thread of its own. A pool thread that waits may be given other work,
/// whose time would count for this job.
///
/// # Errors
/// The errors of [`Job::step`].
pub fn run_single<T: Send>(
    limits: &RunLimits,
    step: impl FnOnce() -> Result<T, StepError> + Send,
) -> Result<T, StepError> {
    let done = std::thread::scope(move |scope| scope.spawn(move || Job::new(limits).step(step)).join());
    done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

thread_local! {
    static CATCHING: Cell<bool> = const { Cell::new(false) };
    static CAUGHT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Calls `f` and catches a panic, without printing it.
///
/// # Errors
/// The message of the panic, and its place if that is in this program's source.
pub fn catch<T>(f: impl FnOnce() -> T) -> Result<T, String> {
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
    outcome.map_err(|_| CAUGHT.take().unwrap_or_else(|| "panicked".to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    type Done = Result<u32, StepError>;

    fn limits(timeout: Duration) -> RunLimits {
        RunLimits { timeout: Some(timeout), ..RunLimits::default() }
    }

    #[test]
    fn a_panic_is_an_error_with_its_place() {
        let (limits, mut said) = (limits(Duration::from_secs(60)), Vec::new());
        let job = Job::new(&limits);
        said.push(job.step(|| -> Done { panic!("no {}", "way") }).unwrap_err().to_string());
        said.push(run_single(&limits, || -> Done { panic!("no {}", "way") }).unwrap_err().to_string());
        for said in said {
            assert!(said.starts_with("panicked at crates/engine") && said.ends_with(": no way"), "{said}");
        }
        // It goes on, where its owner wants that.
        assert!(job.step(|| -> Done { Ok(3) }).is_ok_and(|done| done == 3));
    }

    #[test]
    fn the_time_of_all_steps_counts_and_is_looked_at_when_one_ends() {
        let limits = limits(Duration::from_millis(500));
        let job = Job::new(&limits);
        assert!(job.step(|| -> Done { Ok(1) }).is_ok());
        let slow = || -> Done {
            std::thread::sleep(Duration::from_millis(300));
            Ok(2)
        };
        let said = [job.step(slow).and(job.step(slow)), job.step(|| Ok(3))];
        for said in said {
            assert_eq!(said.unwrap_err().to_string(), "took longer than 0.5 s (--timeout)");
        }
        assert!(job.spent() >= Duration::from_millis(600));
    }

    #[test]
    fn what_an_interruption_ends_is_no_failure_and_nothing_begins_after_it() {
        let limits = RunLimits::default();
        let ended = || -> Done {
            limits.stop.set();
            Err(StepError::failed("interrupted"))
        };
        let never = || -> Done { unreachable!() };
        let job = || Job::new(&limits);
        for outcome in [job().step(ended), job().step(never), run_single(&limits, never)] {
            assert!(matches!(outcome, Err(StepError::Run(RunError::Interrupted))));
        }
    }
}
