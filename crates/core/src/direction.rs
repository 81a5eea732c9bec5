//! Direction in which values of a metric or a signal are better: larger or smaller.

use serde::Serialize;

/// Direction in which values are better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Direction {
    /// Larger is better: scores, similarities.
    #[serde(rename = "up")]
    HigherIsBetter,
    /// Smaller is better: errors, distances, uncertainties.
    #[serde(rename = "down")]
    LowerIsBetter,
    /// Neither direction is better: a description.
    #[serde(rename = "neither")]
    Neither,
}
