//! Signals: those of [`trackfail_judge::signal`], and programs.

pub mod process;

pub use trackfail_judge::signal::*;

use trackfail_core::plugin::{Entry, joined};

/// Every signal, by kind.
pub static SIGNALS: &[Entry<dyn Signal>] = &joined::<_, { trackfail_judge::signal::SIGNALS.len() + 1 }>(
    trackfail_judge::signal::SIGNALS,
    &[process::ENTRY],
);
