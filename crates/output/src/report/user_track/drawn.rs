//! Frames of a user's video with the boxes, the state and the score drawn on them.

use super::{UserTrack, UserVideo};
use crate::figure::{AnnotatedBox, Color, Dash, annotate};
use crate::report::verdict::comparison;
use crate::results::detections::TargetState;
use trackfail_core::image::Frame;

/// Color of a state: green, vermilion, gray.
pub fn color(state: TargetState) -> Color {
    match state {
        TargetState::Tracking => Color::Green,
        TargetState::Lost => Color::Vermilion,
        TargetState::Absent => Color::Gray,
    }
}

impl UserVideo<'_> {
    /// Frame `t`, from 0, whose pixels are `frame`: each box in the color of its state, dashed where it is the last one
    /// again; above, the number of the frame, and for a single target the state and the score.
    pub fn drawn(&self, t: usize, frame: &Frame) -> Frame {
        let boxes = self.boxes(t);
        let number = self.sequence.number(t);
        match self.tracks.as_slice() {
            [track] => {
                let state = track.state(t);
                let score = track.first_method().and_then(|method| comparison(method, t));
                let text = format!("{number}  {}  {}", state.word(), score.unwrap_or_default());
                annotate(frame, &boxes, text.trim_end(), color(state))
            }
            _ => annotate(frame, &boxes, &number.to_string(), Color::Black),
        }
    }

    /// The boxes of frame `t`.
    pub(super) fn boxes(&self, t: usize) -> Vec<AnnotatedBox> {
        let several = self.tracks.len() > 1;
        self.tracks.iter().filter_map(|track| annotated(track, t, several)).collect()
    }
}

fn annotated(track: &UserTrack, t: usize, several: bool) -> Option<AnnotatedBox> {
    let region = track.regions.get(t)?.clone()?;
    let state = track.state(t);
    let label = if several { track.judged.target.map(|id| format!("{id} {}", state.word())) } else { None };
    let dash = if state == TargetState::Absent { Dash::Dashed } else { Dash::Solid };
    Some(AnnotatedBox { region, color: color(state), dash, label: label.unwrap_or_default() })
}
