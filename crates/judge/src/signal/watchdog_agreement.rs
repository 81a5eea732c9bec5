//! `watchdog-agreement`: how a deep watchdog agrees with the tracker. A watchdog is a NanoTrack
//! (tracker/nanotrack.rs) that starts on the tracker's first region and then follows the target alone, with the look of
//! that first frame for ever.
//!
//! ```text
//! overlap        I = IoU(watchdog, tracker)                     in [0, 1], good
//! score          s = score of the watchdog's chosen place       in [0, 1], good
//! disagreement   (1 - I) s                                      in [0, 1], bad
//! apart          s if I = 0, else 0                             in [0, 1], bad
//! distance       min(3, |centers| / sqrt(w h))                  of the tracker's box w x h, in [0, 3], bad
//! ```
//!
//! `values` names those that the signal has, in their order; most detectors read one, and its direction is that of
//! the first. In the first frame the boxes are one, with score 1. Regions are compared by exact areas; a region whose
//! coordinates are no numbers overlaps nothing, and is as far away as can be.
//!
//! A watchdog that is sure of a place at which the tracker is not speaks for a loss; one that has lost its target itself is
//! usually less sure. It is never started again: a tracker that is lost would take it along.
//!
//! Source: none; that trackers which disagree cannot all be right is commonly used. Choices: the watchdog's own score as
//! a weight; NanoTrack, which is small and fails otherwise than hand-made trackers do.

use crate::num::readable;
use crate::plugin::{Entry, ParamError, read_params, show_params};
use crate::region::{Rect, Region};
use crate::saved;
use crate::signal::companion_overlap::overlap;
use crate::signal::{Direction, Observation, Session, Signal};
use crate::tracker::nanotrack::Version;
use crate::tracker::nanotrack::follower::{Follower, Memory};
use crate::tracker::{RunContext, TrackerError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The list's entry.
pub const ENTRY: Entry<dyn Signal> = Entry {
    kind: "watchdog-agreement",
    version: 1,
    summary: "how a deep watchdog, which follows the target from the first frame on, agrees with the tracker",
    example: "{}",
    more: &["{ version = \"v3\", values = [\"overlap\", \"score\", \"distance\", \"apart\"] }"],
    build: |raw| Ok(Box::new(WatchdogAgreement::new(read_params(raw)?)?)),
    schema: || schemars::schema_for!(Params),
};

/// Largest distance, in sides of the tracker's box.
const FAR: f64 = 3.0;

/// A number of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Value {
    /// Overlap of watchdog and tracker.
    Overlap,
    /// Score of the watchdog at its place.
    Score,
    /// `(1 - overlap) score`.
    Disagreement,
    /// The score where the two do not overlap, else 0.
    Apart,
    /// Distance of their centers in sides of the tracker's box, at most 3.
    Distance,
}

/// Parameters.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Version of the watchdog's network.
    pub version: Version,
    /// The values of a frame, each at most once.
    pub values: Vec<Value>,
}

impl Default for Params {
    fn default() -> Self {
        Self { version: Version::default(), values: vec![Value::Disagreement] }
    }
}

/// The agreement with a watchdog, with checked parameters.
pub struct WatchdogAgreement(Params);

impl WatchdogAgreement {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Without any value, and for one that is named twice.
    pub fn new(params: Params) -> Result<Self, ParamError> {
        let values = &params.values;
        let twice = values.iter().enumerate().any(|(i, value)| values[..i].contains(value));
        if values.is_empty() || twice {
            let rule = "a list of different values, at least one";
            return Err(ParamError::out_of_range("values", rule, readable(format!("{values:?}"))));
        }
        Ok(Self(params))
    }
}

impl Signal for WatchdogAgreement {
    fn params(&self) -> serde_json::Value {
        show_params(&self.0)
    }

    fn direction(&self) -> Direction {
        match self.0.values[0] {
            Value::Overlap | Value::Score => Direction::HigherIsBetter,
            Value::Disagreement | Value::Apart | Value::Distance => Direction::LowerIsBetter,
        }
    }

    fn symbol(&self) -> &'static str {
        "dₜ"
    }

    fn bounds(&self) -> (f64, f64) {
        (0.0, if self.0.values[0] == Value::Distance { FAR } else { 1.0 })
    }

    fn width(&self) -> usize {
        self.0.values.len()
    }

    fn start(&self, _: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError> {
        Ok(Box::new(Watching { params: self.0.clone(), watchdog: None, more: Vec::new() }))
    }
}

/// A watchdog beside a track.
struct Watching {
    params: Params,
    /// Before the first frame there is none.
    watchdog: Option<Follower>,
    /// The values of the last frame after the first one.
    more: Vec<f64>,
}

impl Watching {
    /// Score of the watchdog in the next frame, its overlap with the region and its distance; `None` where it cannot start.
    fn step(&mut self, observation: &Observation<'_>) -> Option<[f64; 3]> {
        let (frame, region) = (observation.frame, &observation.state.region);
        let Some(watchdog) = &mut self.watchdog else {
            self.watchdog = Some(Follower::start(self.params.version, frame, region)?);
            return Some([1.0, 1.0, 0.0]);
        };
        let score = watchdog.step(frame).chosen().score;
        let rect = watchdog.rect();
        Some([score, overlap(&Region::Rect(rect), region), distance(&rect, region)])
    }
}

impl Session for Watching {
    fn push(&mut self, observation: &Observation<'_>) -> f64 {
        let Some([score, overlap, distance]) = self.step(observation) else { return f64::NAN };
        let of = |value: &Value| match value {
            Value::Overlap => overlap,
            Value::Score => score,
            Value::Disagreement => (1.0 - overlap) * score,
            Value::Apart => {
                if overlap > 0.0 {
                    0.0
                } else {
                    score
                }
            }
            Value::Distance => distance,
        };
        let mut values = self.params.values.iter().map(of);
        let first = values.next().unwrap_or(f64::NAN);
        self.more = values.collect();
        first
    }

    fn more(&self) -> &[f64] {
        &self.more
    }

    fn save(&self) -> Option<Vec<u8>> {
        saved::to_bytes(&self.watchdog.as_ref().map(Follower::memory))
    }

    fn restore(&mut self, saved: &[u8]) -> bool {
        let Some(memory) = saved::from_bytes::<Option<Memory>>(saved) else { return false };
        let is_none = memory.is_none();
        self.watchdog = memory.and_then(|memory| Follower::remembered(self.params.version, memory));
        is_none || self.watchdog.is_some()
    }
}

/// Distance of the centers of the watchdog's box and the tracker's region, in sides of the latter.
fn distance(watchdog: &Rect, region: &Region) -> f64 {
    if !region.is_finite() {
        return FAR;
    }
    let (bounds, (x, y)) = (region.bounds(), watchdog.center());
    let (u, v) = bounds.center();
    let side = (bounds.w * bounds.h).sqrt().max(1.0);
    (((x - u) * (x - u) + (y - v) * (y - v)).sqrt() / side).min(FAR)
}

#[cfg(test)]
mod tests;
