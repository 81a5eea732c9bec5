//! Tracks from which detectors learn.

/// One track to learn from.
#[derive(Debug, Clone, Default)]
pub struct Example<'a> {
    /// First signal, one value per frame.
    pub signal: &'a [f64],
    /// Further signals, for detectors that read several; each has one value per frame.
    pub more: Vec<&'a [f64]>,
    /// Tracking error O_t per frame in `[0, 1]`, NaN where there is no ground truth.
    pub error: &'a [f64],
    /// Name of the video that the sequence is from. Examples from one video are not independent, so folds
    /// keep them together.
    pub video: String,
    /// Source of the video. Findings on one source need not hold on another.
    pub source: String,
}

impl<'a> Example<'a> {
    /// A track with one signal, from an unnamed video.
    pub fn new(signal: &'a [f64], error: &'a [f64]) -> Self {
        Self { signal, error, ..Self::default() }
    }
}
