//! What trackers and signals may ask of a sequence beside the frames that they are given.

use crate::region::Region;
use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

/// Frame numbers of a sequence in its dataset, for readers of result files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Numbering {
    /// Number of the sequence's first frame here.
    pub first: u32,
    /// First and last frame of the dataset's own, uncut range (OTB: David 300..=770).
    pub official: (u32, u32),
}

/// A sequence as trackers and signals know it.
pub trait SequenceInfo: Send + Sync {
    /// Its name, unique in its suite: `Jogging-1`.
    fn name(&self) -> &str;

    /// Its frame numbers.
    fn numbering(&self) -> Numbering;

    /// Ground truth, one entry a frame; `None` where the target is not annotated.
    fn truth(&self) -> &[Option<Region>];

    /// Attributes of the whole sequence, sorted: `occlusion`, `scale-change` ...
    fn attributes(&self) -> &[String];

    /// Width and height of its frames, in pixels.
    ///
    /// # Errors
    /// When it has no frames, or the first one cannot be read.
    fn size(&self) -> Result<(usize, usize), Box<dyn Error + Send + Sync>>;

    /// The image files of its frames; none where its frames have no files.
    ///
    /// # Errors
    /// When the frames of a video cannot be decoded.
    fn files(&self) -> Result<Vec<PathBuf>, Box<dyn Error + Send + Sync>>;

    /// The same sequence, for those who keep it.
    fn shared(&self) -> Arc<dyn SequenceInfo>;

    /// Number of frames.
    fn frames(&self) -> usize {
        self.truth().len()
    }
}
