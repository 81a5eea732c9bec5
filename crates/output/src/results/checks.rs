//! Checks of a track, of methods that follow the tracker's condition.

/// A check of a track by running the tracker backwards.
#[derive(Debug, Clone, PartialEq)]
pub struct ReverseCheck {
    /// Number of the frame in which it was made.
    pub frame: i64,
    /// Number of the frame that was run back to.
    pub reference: i64,
    /// Error there between both ways; none where nothing was run.
    pub error: Option<f64>,
    /// Whether the track is taken to be successful again.
    pub accepted: bool,
}
