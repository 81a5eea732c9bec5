//! Jobs: what is run on every sequence.

/// A tracker and a repetition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Job {
    /// Index of the tracker in the experiment.
    pub tracker: usize,
    /// Repetition, from 0.
    pub run: u32,
}
