//! NanoTrack v2 and v3 (HonglinChu/SiamTrackers, after SiamRPN++ and LightTrack): a small Siamese network
//! that compares a search region with the target in the first frame.
//!
//! ```text
//! s = sqrt((w + p)(h + p)), p = (w + h) / 2        side of the template in the frame; that of the search region is 255/127 s
//! score      p(c) = 1 / (1 + exp(background - target))       of cell c of the maps
//! penalty    q(c) = exp(-k (change(size) change(shape) - 1)),   change(r) = max(r, 1 / r), against the last box
//! chosen     argmax_c  (1 - i) q(c) p(c) + i H(c)            H: Hann window
//! box        center of c's box; sides a (those of c's box) + (1 - a) (the last sides),   a = q p (learning rate)
//! ```
//!
//! | | v2 | v3 |
//! |---|---|---|
//! | window influence `i`, `k`, learning rate | .490, .150, .385 | .455, .138, .348 |
//! | cells of the maps | 16 x 16 | 15 x 15 |
//!
//! Frames are read as red, green and blue, `0..=255`. Squares are cut on whole pixels, filled beyond the frame with the
//! mean color of the first frame, resized without smoothing and rounded. The template is that of the first frame for
//! ever. The confidence is the score of the chosen cell, `0..=1`, high is good. The response map is that of all scores,
//! with borders; as a density it is the posterior of the center (tracker/correlation/response.rs). State and response of
//! the first frame are those of a look at it, its region is the given one.
//!
//! Source: the code of HonglinChu/SiamTrackers @ 248663f, NanoTrack, whose network and constants these are; weights in
//! models/nanotrack. Deviations: sums in another order (network.rs), and resizing rounds once, not in steps of 1/2048.

pub(crate) mod follower;
pub(crate) mod look;

use super::correlation::response::{MapOptions, ResponseMap};
pub use crate::network::nanotrack::Version;
use crate::saved;
use crate::tracker::prelude::*;
use follower::Follower;
use look::Look;

/// Parameters of the tracker.
#[derive(Debug, Clone, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Version of the network.
    pub version: Version,
    /// Options for reading the response map.
    pub response: MapOptions,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[MapOptions::NEIGHBORHOOD, MapOptions::THRESHOLD];
}

/// NanoTrack in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> =
    Entry::of::<Params>("nanotrack", 1, "small Siamese network (NanoTrack v2 or v3) with its weights");

impl TrackerConfig for Params {
    fn facts(&self) -> Facts {
        Facts::RESPONSES
    }

    fn start(&self, _: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        let follower = Follower::start(self.version, frame, region)
            .ok_or_else(|| TrackerError::no_region("nanotrack"))?;
        let tracking = Tracking { params: self.clone(), follower };
        let look = tracking.follower.look(frame);
        let state = tracking.state(&look, TrackerState::initialized(region.clone()));
        Ok((Box::new(tracking), state))
    }

    fn resume(&self, saved: &[u8]) -> Option<Box<dyn Tracker>> {
        let follower = Follower::remembered(self.version, saved::from_bytes(saved)?)?;
        Some(Box::new(Tracking { params: self.clone(), follower }))
    }
}

#[derive(Clone)]
struct Tracking {
    params: Params,
    follower: Follower,
}

impl Tracking {
    /// State with the confidence and the response map of a look.
    fn state(&self, look: &Look, state: TrackerState) -> TrackerState {
        let scores = look.cells.iter().map(|cell| cell.score as f32).collect();
        let map = ResponseMap::with_borders(scores, look.side, look.cell);
        let (x, y) = look.point(map.place());
        let state = map.describe_around((x + 0.5, y + 0.5), &self.params.response, state);
        TrackerState { confidence: Some(look.chosen().score), ..state }
    }
}

impl Tracker for Tracking {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        let look = self.follower.step(frame);
        Ok(self.state(&look, TrackerState::tracked(Region::Rect(self.follower.rect()))))
    }

    fn fork(&self, _seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        Some(Box::new(self.clone()))
    }

    fn save(&self) -> Option<Vec<u8>> {
        saved::to_bytes(&self.follower.memory())
    }
}

#[cfg(test)]
mod tests;
