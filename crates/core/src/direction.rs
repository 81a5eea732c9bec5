//! Whether larger or smaller values of a metric or a signal are better.

use serde::Serialize;

/// Whether larger or smaller values are better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Direction {
    /// Larger is better: scores, similarities.
    #[serde(rename = "up")]
    HigherIsBetter,
    /// Smaller is better: errors, distances, uncertainties.
    #[serde(rename = "down")]
    LowerIsBetter,
    /// Neither: a description.
    #[serde(rename = "neither")]
    Neither,
}
