//! What observers see of a run: its progress while it goes on, and how much was computed or cached.

pub mod progress;
pub mod tally;
