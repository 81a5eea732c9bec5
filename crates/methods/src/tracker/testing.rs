//! Helpers for tests of programs and result files.

use super::RunContext;
use std::sync::Arc;
use trackfail_core::image::Frame;
use trackfail_core::region::{Rect, Region};
use trackfail_core::sequence::SequenceInfo;
use trackfail_dataset::user_frames::without_frames;
use trackfail_dataset::{Frames, Sequence};

/// Frame of 320 x 240 pixels, each with other colors.
pub fn ramp(t: usize) -> Frame {
    Frame::from_fn(320, 240, |x, y| [x as u8, y as u8, t as u8])
}

/// A sequence of frames of [`ramp`], numbered from 1, with the same box in all.
pub fn rendered(name: &str, frames: usize) -> Sequence {
    Sequence {
        truth: vec![Some(Region::Rect(Rect::new(9.0, 9.0, 9.0, 9.0))); frames],
        digest: "0".to_string().into(),
        frames: Frames::Rendered(Arc::new(ramp), frames),
        ..without_frames(name, frames)
    }
}

/// Context of run 0 that starts in the first frame, without a data root.
pub fn context(sequence: &dyn SequenceInfo, seed: u64) -> RunContext<'_> {
    RunContext { sequence, start_frame: 0, run: 0, seed, data_roots: &[] }
}
