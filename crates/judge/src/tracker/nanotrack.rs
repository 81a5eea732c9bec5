//! NanoTrack v2 and v3 (HonglinChu/SiamTrackers, after SiamRPN++ and LightTrack): a small Siamese network that compares a
//! search region with the target's first look.
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

pub(crate) mod look;

use super::correlation::response::{MapOptions, ResponseMap};
use super::{RunContext, StartResult, Tracker, TrackerConfig, TrackerError, TrackerState};
use crate::image::Frame;
pub use crate::network::nanotrack::Version;
use crate::plugin::{Entry, ParamError, RawParams, read_params, show_params};
use crate::region::{Rect, Region};
use crate::saved;
use look::{Look, Place, Target};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Parameters.
#[derive(Debug, Clone, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Version of the network.
    pub version: Version,
    /// How the response map is read.
    pub response: MapOptions,
}

/// A checked configuration.
#[derive(Debug, Clone)]
pub struct NanoTrack(Params);

impl NanoTrack {
    /// Checks the parameters.
    ///
    /// # Errors
    /// For parameters outside their range.
    pub fn new(p: Params) -> Result<Self, ParamError> {
        p.response.check()?;
        Ok(Self(p))
    }
}

/// The list's line.
pub const ENTRY: Entry<dyn TrackerConfig> = Entry {
    kind: "nanotrack",
    version: 1,
    summary: "small Siamese network (NanoTrack v2 or v3) with its weights",
    example: "{}",
    more: &[],
    build: |raw: RawParams<'_>| Ok(Box::new(NanoTrack::new(read_params(raw)?)?)),
    schema: || schemars::schema_for!(Params),
};

impl TrackerConfig for NanoTrack {
    fn params(&self) -> serde_json::Value {
        show_params(&self.0)
    }

    fn uses_seed(&self) -> bool {
        false
    }

    fn gives_posterior(&self) -> bool {
        true
    }

    fn gives_response(&self) -> bool {
        true
    }

    fn start(&self, _: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        if region.corners().iter().any(|c| !(c.0.is_finite() && c.1.is_finite())) {
            return Err(TrackerError::no_region("nanotrack"));
        }
        let room = [frame.width() as f64, frame.height() as f64];
        let place = inside(Place::of(&region.bounds()), room);
        let target = Arc::new(Target::new(self.0.version, frame, &place));
        let tracking = Tracking { params: self.0.clone(), target, place };
        let look = tracking.target.look(frame, &place);
        let state = tracking.state(&look, TrackerState::initialized(region.clone()));
        Ok((Box::new(tracking), state))
    }

    fn resume(&self, saved: &[u8]) -> Option<Box<dyn Tracker>> {
        let memory: Memory = saved::from_bytes(saved)?;
        let Place { center, sides } = memory.place;
        let is_place = center.iter().chain(&sides).all(|v| v.abs() <= 1e9) && sides.iter().all(|s| *s >= 1.0);
        if !is_place || !memory.color.iter().all(|c| (0.0..=255.0).contains(c)) {
            return None;
        }
        let target = Target::remembered(self.0.version, (memory.color, memory.features))?;
        Some(Box::new(Tracking { params: self.0.clone(), target: Arc::new(target), place: memory.place }))
    }
}

/// A place whose center is at most three of a frame's sides beyond it and whose sides are at most three of them.
fn inside(place: Place, room: [f64; 2]) -> Place {
    Place {
        center: std::array::from_fn(|k| place.center[k].clamp(-3.0 * room[k], 4.0 * room[k])),
        sides: std::array::from_fn(|k| place.sides[k].min(3.0 * room[k])),
    }
}

#[derive(Clone)]
struct Tracking {
    params: Params,
    target: Arc<Target>,
    place: Place,
}

/// Memory of a tracker at work.
#[derive(Serialize, Deserialize)]
struct Memory {
    place: Place,
    color: [f32; 3],
    features: Vec<f32>,
}

impl Tracking {
    /// An answer with confidence and response map.
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
        let look = self.target.look(frame, &self.place);
        self.place = look.next(self.params.version, frame);
        let Place { center: [x, y], sides: [w, h] } = self.place;
        let region = Region::Rect(Rect::new(x - w / 2.0, y - h / 2.0, w, h));
        Ok(self.state(&look, TrackerState::tracked(region)))
    }

    fn fork(&self, _seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        Some(Box::new(self.clone()))
    }

    fn save(&self) -> Option<Vec<u8>> {
        let (color, features) = self.target.memory();
        saved::to_bytes(&Memory { place: self.place, color, features })
    }
}

#[cfg(test)]
mod tests;
