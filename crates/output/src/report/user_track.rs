//! A user's own track as a page, a figure, or drawn on its frames: what `trackfail detect` shows beside its verdict.
//!
//! | module | makes |
//! |---|---|
//! | [`page`] | an HTML file that needs nothing beside it: verdict, strip, viewer, thumbnails |
//! | [`picture`] | a figure of stills over a panel for each method; a frame with the boxes, the state and the score |
//! | [`video`] | frames as a video file |

pub mod page;
pub mod picture;
pub mod video;

use crate::results::detections::{JudgedMethod, JudgedTrack, TargetState};
use std::collections::BTreeSet;
use trackfail_core::region::Region;
use trackfail_dataset::Sequence;

/// A user's tracks on a video, with what the methods say of them.
#[derive(Debug)]
pub struct UserVideo<'a> {
    /// The frames; without pixels where the user has none.
    pub sequence: &'a Sequence,
    /// The targets.
    pub tracks: Vec<UserTrack>,
    /// Program, inputs and methods that the results rest on: names and values.
    pub facts: Vec<(String, String)>,
}

impl UserVideo<'_> {
    /// The target of a video that has only one.
    fn lone(&self) -> Option<&UserTrack> {
        self.tracks.first().filter(|_| self.tracks.len() == 1)
    }
}

/// A target.
#[derive(Debug)]
pub struct UserTrack {
    /// Judgements of the methods.
    pub judged: JudgedTrack,
    /// The region in each frame, the last one again where the target is absent; `None` before the first and after the last.
    pub regions: Vec<Option<Region>>,
}

impl UserTrack {
    /// The method that the user is told of first.
    fn first_method(&self) -> Option<&JudgedMethod> {
        self.judged.methods.first()
    }

    /// State of the target in a frame, by the first method.
    fn state(&self, t: usize) -> TargetState {
        let state = self.first_method().and_then(|method| method.states.get(t));
        state.copied().unwrap_or(TargetState::Absent)
    }

    /// `tracker`, or `target 3` in a file of several.
    fn name(&self) -> String {
        self.judged.target.map_or_else(|| "tracker".to_string(), |id| format!("target {id}"))
    }
}

/// Frames that say most about the tracks, the most important ones first: where losses begin and end, the first and the last
/// frame, then frames that divide the video evenly, at most `most` in all.
fn telling_frames(tracks: &[UserTrack], frames: usize, most: usize) -> Vec<usize> {
    let losses: Vec<_> =
        tracks.iter().filter_map(UserTrack::first_method).flat_map(JudgedMethod::losses).collect();
    let begins = losses.iter().map(|run| run.start).chain([0, frames.saturating_sub(1)]);
    let others =
        losses.iter().flat_map(|run| [run.end, run.start + run.len() / 2, run.start.saturating_sub(5)]);
    let even = most.min(frames);
    let all = begins.chain(others).chain((0..even).map(|k| k * frames / even));
    let mut known = BTreeSet::new();
    all.filter(|t| *t < frames && known.insert(*t)).take(most).collect()
}

#[cfg(test)]
mod tests;
