//! Tracks that detectors learn from.

/// One track to learn from.
#[derive(Debug, Clone, Default)]
pub struct Example<'a> {
    /// The signal, one value a frame.
    pub signal: &'a [f64],
    /// The further signals of detectors that read several, one value a frame each.
    pub more: Vec<&'a [f64]>,
    /// Tracking error O_t a frame in `[0, 1]`, NaN where there is no ground truth.
    pub error: &'a [f64],
    /// The video that the sequence is of; examples of one video say the same of what was not learned from.
    pub video: String,
    /// The source of videos that it comes from: what holds on one need not hold on another.
    pub source: String,
}

impl<'a> Example<'a> {
    /// A track with one signal, of a video of no name.
    pub fn new(signal: &'a [f64], error: &'a [f64]) -> Self {
        Self { signal, error, ..Self::default() }
    }
}
