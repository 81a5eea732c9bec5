//! Trackers: the built-in ones of [`trackfail_judge::tracker`], result files and external programs.

pub mod process;
pub mod replay;
pub mod results;
pub mod trax;

#[cfg(test)]
pub(crate) mod testing;

pub use trackfail_judge::tracker::*;

use trackfail_core::plugin::{Entry, joined};

/// All trackers, by kind.
pub static TRACKERS: &[Entry<dyn TrackerConfig>] =
    &joined::<_, { trackfail_judge::tracker::TRACKERS.len() + 2 }>(
        trackfail_judge::tracker::TRACKERS,
        &[replay::ENTRY, process::ENTRY],
    );
