//! Facts about a sequence that trackers and signals may use, beside its frames.

use crate::region::Region;
use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

/// Frame numbers of a sequence in its dataset, for readers of result files.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Numbering {
    /// Number of the first frame that is used.
    pub first: u32,
    /// First and last frame of the dataset's own, uncut range (OTB: David 300..=770).
    pub official: (u32, u32),
}

/// A sequence from the view of trackers and signals.
pub trait SequenceInfo: Send + Sync {
    /// Name, unique in the suite: `Jogging-1`.
    fn name(&self) -> &str;

    /// Frame numbers in the dataset.
    fn numbering(&self) -> Numbering;

    /// Ground truth, one entry per frame; `None` where the target is not annotated.
    fn truth(&self) -> &[Option<Region>];

    /// Attributes of the whole sequence, sorted: `occlusion`, `scale-change` ...
    fn attributes(&self) -> &[String];

    /// Width and height of the frames, in pixels.
    ///
    /// # Errors
    /// When the sequence has no frames, or the first one cannot be read.
    fn size(&self) -> Result<(usize, usize), Box<dyn Error + Send + Sync>>;

    /// Image files of the frames; empty if the frames have no files.
    ///
    /// # Errors
    /// When the frames of a video cannot be decoded.
    fn files(&self) -> Result<Vec<PathBuf>, Box<dyn Error + Send + Sync>>;

    /// The sequence as a shared pointer, for owners beyond this borrow.
    fn shared(&self) -> Arc<dyn SequenceInfo>;

    /// Number of frames.
    fn frames(&self) -> usize {
        self.truth().len()
    }
}
