//! Sequences and their ground truth.
//!
//! A [`Sequence`] is the frames of one target, in order, with one optional region per frame. Its frames come
//! from files or from the synthetic renderer and are decoded one at a time, so that a suite of any size needs
//! the memory of a few frames.

pub mod archive;
mod digest;
mod error;
pub mod fetch;
pub mod files;
pub mod format;
pub mod frame_cache;
mod frame_order;
pub mod guarded;
pub mod leftover;
pub mod lock;
pub mod suite;
pub mod synthetic;
pub mod text;
pub mod user_frames;
pub mod video;

pub use digest::{Digest, content_digest, file_digest};
pub use error::DatasetError;
pub(crate) use error::Result;

pub use trackfail_core::sequence::{Numbering, SequenceInfo};

use std::error::Error;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use suite::Origin;
use trackfail_core::image::Frame;
use trackfail_core::region::Region;

/// Computes frame `t`, 0-based.
pub type Render = dyn Fn(usize) -> Frame + Send + Sync;

/// Source of the pixels of a sequence.
#[derive(Clone, Default)]
pub enum Frames {
    /// Image files in order.
    Files(Vec<PathBuf>),
    /// Range of a suite's video, decoded into image files at the first use.
    Video(Arc<video::Video>),
    /// A user's video, decoded in order whenever frames are requested.
    Stream(Arc<video::VideoStream>),
    /// A renderer and the number of frames.
    Rendered(Arc<Render>, usize),
    /// No pixels: only the ground truth is known.
    #[default]
    Absent,
}

impl std::fmt::Debug for Frames {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Files(files) => write!(f, "Files({} files)", files.len()),
            Self::Video(video) => write!(f, "Video({})", video.path().display()),
            Self::Stream(stream) => write!(f, "Stream({})", stream.path().display()),
            Self::Rendered(_, n) => write!(f, "Rendered({n} frames)"),
            Self::Absent => f.write_str("Absent"),
        }
    }
}

/// The frames of one target with its ground truth. The default one has neither.
#[derive(Clone, Debug, Default)]
pub struct Sequence {
    /// Name, unique in the suite: `Jogging-1`.
    pub name: String,
    /// Where the sequence is from.
    pub origin: Origin,
    /// Mapping from frame indices to the dataset's frame numbers.
    pub numbering: Numbering,
    /// Ground truth, one entry per frame; `None` where the target is not annotated.
    pub truth: Vec<Option<Region>>,
    /// Attributes of the whole sequence, sorted: `occlusion`, `scale-change` ...
    pub attributes: Vec<String>,
    /// Attributes per frame: a name and one flag for each entry of `truth`. Empty if the dataset has none.
    pub frame_attributes: Vec<(String, Vec<bool>)>,
    /// Files digest, known from the start or computed by [`Sequence::digest`].
    pub digest: Digest,
    /// The pixels.
    pub frames: Frames,
    /// Width and height of the frames, known from the start or once the first image file has been read.
    pub size: OnceLock<(usize, usize)>,
}

impl Sequence {
    /// Number of frames.
    pub fn len(&self) -> usize {
        self.truth.len()
    }

    /// True if the sequence has no frames.
    pub fn is_empty(&self) -> bool {
        self.truth.is_empty()
    }

    /// True if the frames can be read; false if only the ground truth is known.
    pub fn has_frames(&self) -> bool {
        !matches!(self.frames, Frames::Absent)
    }

    /// Frame number of the dataset for index `t` (0-based).
    pub fn number(&self, t: usize) -> u32 {
        self.numbering.first + t as u32
    }

    /// Frame numbers of the first and the last frame, as in the dataset.
    fn range(&self) -> (u32, u32) {
        (self.number(0), self.number(self.len().saturating_sub(1)))
    }
}

impl SequenceInfo for Sequence {
    fn name(&self) -> &str {
        &self.name
    }

    fn numbering(&self) -> Numbering {
        self.numbering
    }

    fn truth(&self) -> &[Option<Region>] {
        &self.truth
    }

    fn attributes(&self) -> &[String] {
        &self.attributes
    }

    fn size(&self) -> Result<(usize, usize), Box<dyn Error + Send + Sync>> {
        Ok(self.size()?)
    }

    fn files(&self) -> Result<Vec<PathBuf>, Box<dyn Error + Send + Sync>> {
        Ok(match &self.frames {
            Frames::Files(files) => files.to_vec(),
            Frames::Video(video) => video.files()?.to_vec(),
            Frames::Stream(_) | Frames::Rendered(..) | Frames::Absent => Vec::new(),
        })
    }

    fn shared(&self) -> Arc<dyn SequenceInfo> {
        Arc::new(self.clone())
    }
}

/// Words sorted, without repetitions.
fn sorted(words: impl IntoIterator<Item = String>) -> Vec<String> {
    words.into_iter().collect::<std::collections::BTreeSet<_>>().into_iter().collect()
}
