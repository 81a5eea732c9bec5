//! Helpers for tests of programs and result files.

use super::RunContext;
use std::sync::Arc;
use trackfail_core::image::Frame;
use trackfail_core::region::{Rect, Region};
use trackfail_core::sequence::SequenceInfo;
use trackfail_dataset::{Frames, Numbering, Render, Sequence};

/// Frames of 320 x 240 pixels, each with other colors.
pub struct Ramp;

impl Render for Ramp {
    fn render(&self, t: usize) -> Frame {
        Frame::from_fn(320, 240, |x, y| [x as u8, y as u8, t as u8])
    }

    fn size(&self) -> (usize, usize) {
        (320, 240)
    }
}

/// A sequence of frames of [`Ramp`], numbered from 1, with the same box in all.
pub fn rendered(name: &str, frames: usize) -> Sequence {
    Sequence {
        name: name.into(),
        numbering: Numbering { first: 1, official: (1, frames as u32) },
        truth: vec![Some(Region::Rect(Rect::new(9.0, 9.0, 9.0, 9.0))); frames],
        attributes: vec![],
        frame_attributes: vec![],
        digest: "0".to_string().into(),
        frames: Frames::Rendered(Arc::new(Ramp), frames),
    }
}

/// Context of run 0 that starts in the first frame, without a data root.
pub fn context(sequence: &dyn SequenceInfo, seed: u64) -> RunContext<'_> {
    RunContext { sequence, start_frame: 0, run: 0, seed, data_roots: &[] }
}
