//! Work on threads that do not hold the interpreter.
//!
//! The threads are of a pool of this module's own: a process that was forked has none of its parent's threads, and waiting
//! for these would never end, so that it starts a pool anew. `RAYON_NUM_THREADS` limits their number.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Pause between two looks at whether the user interrupts.
const PAUSE: Duration = Duration::from_millis(50);

/// The pool, and the process that its threads belong to.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// The pool of this process. The lock is held under that of the interpreter alone, so that a fork never finds it taken.
fn pool(_: Python<'_>) -> PyResult<Arc<ThreadPool>> {
    let mut kept = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((owner, pool)) = &*kept
        && *owner == process
    {
        return Ok(pool.clone());
    }
    let pool = ThreadPoolBuilder::new().build();
    let pool = pool.map_err(|e| PyRuntimeError::new_err(format!("cannot start worker threads: {e}")))?;
    let pool = Arc::new(pool);
    // The end of a pool waits for its threads.
    std::mem::forget(kept.replace((process, pool.clone())));
    Ok(pool)
}

/// The exception of a panic, which is a fault of this package.
fn fault(panic: Box<dyn Any + Send>) -> PyErr {
    let text = panic.downcast_ref::<&str>().copied();
    let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no words");
    PyRuntimeError::new_err(format!("a fault of trackfail itself, please report it: {text}"))
}

/// Does work that does not take long.
///
/// # Errors
/// A panic in it.
pub fn work<T: Send>(py: Python<'_>, task: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = pool(py)?;
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(|| pool.install(task))));
    done.map_err(fault)
}

/// Does work that may take long; it is told to end when the user interrupts.
///
/// # Errors
/// A panic in it, and the interruption.
pub fn work_until_stopped<T: Send>(
    py: Python<'_>,
    task: impl FnOnce(&AtomicBool) -> T + Send,
) -> PyResult<T> {
    let pool = pool(py)?;
    if pool.current_thread_index().is_some() {
        // Frames of other work ask for this: their thread would wait for a task in its own queue.
        return work(py, || task(&AtomicBool::new(false)));
    }
    let (done, interruption) = py.detach(|| {
        let (stop, mut result, mut interruption) = (AtomicBool::new(false), None, None);
        let (running, ended) = mpsc::channel::<()>();
        let all = AssertUnwindSafe(|| {
            pool.in_place_scope(|scope| {
                let (stop, result) = (&stop, &mut result);
                scope.spawn(move |_| {
                    // Dropped at the end, also at that of a panic.
                    let _running = running;
                    *result = Some(task(stop));
                });
                // Signals reach the thread that has called, and no other one.
                while ended.recv_timeout(PAUSE) == Err(RecvTimeoutError::Timeout) {
                    if let Err(signal) = Python::attach(|py| py.check_signals()) {
                        interruption = Some(signal);
                        stop.store(true, Ordering::Relaxed);
                        break;
                    }
                }
            });
        });
        let done = catch_unwind(all);
        (done.map(|()| result), interruption)
    });
    match (done.map_err(fault)?, interruption) {
        (Some(result), None) => Ok(result),
        (_, interruption) => {
            Err(interruption.unwrap_or_else(|| PyRuntimeError::new_err("the work has no result")))
        }
    }
}
