//! How much of a run is written.

/// How much results say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Everything.
    Frames,
    /// Nothing of single frames, no models, no rows of sequences that are not there, and scores as Parquet: small enough to
    /// be kept.
    Sequences,
}
