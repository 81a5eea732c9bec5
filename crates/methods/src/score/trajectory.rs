//! The regions of a tracker over a sequence with their ground truth, the input of tracking protocols.

use crate::region::Region;
use crate::tracker::Status;

/// One track with its ground truth; every list has one entry for each frame.
#[derive(Debug, Clone, Copy)]
pub struct Trajectory<'a> {
    /// Name of the sequence.
    pub sequence: &'a str,
    /// Repetition, from 0.
    pub run: u32,
    /// The tracker's region in each frame.
    pub regions: &'a [Region],
    /// Status of the tracker in each frame.
    pub status: &'a [Status],
    /// Ground truth; `None` where the target is not annotated.
    pub truth: &'a [Option<Region>],
    /// Width and height of the frames in pixels, where there are frames.
    pub frame: Option<(usize, usize)>,
    /// Attributes of the sequence.
    pub attributes: &'a [String],
    /// Attributes of the frames, by name.
    pub frame_attributes: &'a [(String, Vec<bool>)],
}

impl Trajectory<'_> {
    /// Number of frames.
    pub fn len(&self) -> usize {
        self.regions.len()
    }

    /// Whether there is no frame.
    pub fn is_empty(&self) -> bool {
        self.regions.is_empty()
    }
}

/// Mean of the numbers; `None` without numbers.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0_usize), |(s, n), v| (s + v, n + 1));
    (count > 0).then(|| sum / count as f64)
}
