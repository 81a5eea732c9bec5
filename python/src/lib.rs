//! The extension module of the Python package `trackfail`: conversions between Python and the judging crate.
//!
//! | module | has |
//! |---|---|
//! | `threads` | threads without the interpreter, also after a fork; faults and interruptions as exceptions |
//! | `frame` | frames from arrays, bytes and files |
//! | `region` | boxes |
//! | `monitor` | a monitor, frame by frame |
//! | `tracks` | judgements of whole tracks |
//! | `score` | protocols and measures |
//!
//! `_trackfail.pyi` types what Python sees of it, and the modules around it document that.

mod frame;
mod monitor;
mod region;
mod score;
mod threads;
mod tracks;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::fmt::Display;

/// The exception of an input that is refused, with the words of the error.
fn refused(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A number that may be missing: `None`, which also is what NaN says.
///
/// # Errors
/// Infinity.
fn finite(given: Option<f64>, what: impl Display) -> PyResult<Option<f64>> {
    match given.filter(|number| !number.is_nan()) {
        Some(number) if number.is_infinite() => {
            Err(refused(format!("{what}: {number} is not a finite number; where there is none, give None")))
        }
        number => Ok(number),
    }
}

/// The extension module.
#[pymodule]
fn _trackfail(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<frame::Frame>()?;
    module.add_class::<monitor::Monitor>()?;
    module.add_function(wrap_pyfunction!(tracks::judge, module)?)?;
    module.add_function(wrap_pyfunction!(tracks::methods, module)?)?;
    module.add_function(wrap_pyfunction!(tracks::recommended, module)?)?;
    module.add_function(wrap_pyfunction!(score::errors, module)?)?;
    module.add_function(wrap_pyfunction!(score::found_at, module)?)?;
    module.add_function(wrap_pyfunction!(score::frame_measures, module)?)?;
    module.add_function(wrap_pyfunction!(score::protocols, module)?)?;
    module.add_function(wrap_pyfunction!(score::score, module)?)?;
    Ok(())
}
