//! Detectors: the built-in ones of [`trackfail_judge::detector`], and external programs.

pub mod process;

pub use trackfail_judge::detector::*;

use trackfail_core::plugin::{Entry, joined};

/// All detectors, by kind.
pub static DETECTORS: &[Entry<dyn Detector>] = &joined::<_, { trackfail_judge::detector::DETECTORS.len() + 1 }>(
    trackfail_judge::detector::DETECTORS,
    &[process::ENTRY],
);
