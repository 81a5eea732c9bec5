//! A user's own track as a page, as a figure, or drawn on its frames: output of `trackfail detect` beside its
//! verdict.
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

/// A user's tracks on a video, with the results of the methods.
#[derive(Debug)]
pub struct UserVideo<'a> {
    /// Frames of the video; without pixels if the user has none.
    pub sequence: &'a Sequence,
    /// Tracks of the targets.
    pub tracks: Vec<UserTrack>,
    /// Names and values of the program, inputs and methods behind the results.
    pub facts: Vec<(String, String)>,
}

impl UserVideo<'_> {
    /// The only target of a video; `None` if there are several.
    fn lone(&self) -> Option<&UserTrack> {
        self.tracks.first().filter(|_| self.tracks.len() == 1)
    }
}

/// Track of one target.
#[derive(Debug)]
pub struct UserTrack {
    /// Results of the methods.
    pub judged: JudgedTrack,
    /// Region in each frame; the last one again where the target is absent. `None` before the first and after
    /// the last region.
    pub regions: Vec<Option<Region>>,
}

impl UserTrack {
    /// First method, whose verdict is shown to the user.
    fn first_method(&self) -> Option<&JudgedMethod> {
        self.judged.methods.first()
    }

    /// State of the target in frame `t`, by the first method.
    fn state(&self, t: usize) -> TargetState {
        let state = self.first_method().and_then(|method| method.states.get(t));
        state.copied().unwrap_or(TargetState::Absent)
    }

    /// Name of the target: `tracker`, or `target 3` in a file of several.
    fn name(&self) -> String {
        self.judged.target.map_or_else(|| "tracker".to_string(), |id| format!("target {id}"))
    }
}

/// At most `most` frames that show the tracks best, the most important first: both ends of losses, first and
/// last frame, then frames that divide the video evenly.
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
