//! Signals: the built-in ones of [`trackfail_judge::signal`], and external programs.

pub mod process;

pub use trackfail_judge::signal::*;

use trackfail_core::plugin::{Entry, joined};

/// All signals, by kind.
pub static SIGNALS: &[Entry<dyn Signal>] = &joined::<_, { trackfail_judge::signal::SIGNALS.len() + 1 }>(
    trackfail_judge::signal::SIGNALS,
    &[process::ENTRY],
);
