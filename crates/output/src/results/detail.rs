//! How much of a run is written.

/// How much results say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Everything.
    Frames,
    /// Nothing of single frames, no models of folds, and no rows of sequences that are not there: small enough to be kept.
    Sequences,
}
