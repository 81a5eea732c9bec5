//! `watchdog-agreement`: agreement of a deep watchdog with the tracker. A watchdog is a NanoTrack
//! (tracker/nanotrack.rs) that starts on the tracker's first region and then follows the target alone, with
//! the template of that first frame.
//!
//! ```text
//! overlap        I = IoU(watchdog, tracker)                     in [0, 1], good
//! score          s = score of the watchdog's chosen place       in [0, 1], good
//! disagreement   (1 - I) s                                      in [0, 1], bad
//! apart          s if I = 0, else 0                             in [0, 1], bad
//! distance       min(3, |centers| / sqrt(w h))                  of the tracker's box w x h, in [0, 3], bad
//! ```
//!
//! `values` lists the signal's values in order. Most detectors read one; the direction of the signal is that
//! of the first. In the first frame the boxes coincide, with score 1. Regions are compared by exact areas. A
//! region with NaN coordinates overlaps nothing and has the largest distance.
//!
//! A watchdog with a high score at a place away from the tracker speaks for a loss; one that lost its target
//! itself usually has a lower score. It is never restarted, since a lost tracker would take it along.
//!
//! Source: none; that trackers which disagree cannot all be right is commonly used. Choices: the watchdog's own score as
//! a weight; NanoTrack, which is small and fails otherwise than hand-made trackers do.

use crate::signal::companion_overlap::overlap;
use crate::signal::prelude::*;
use crate::tracker::nanotrack::Version;
use crate::tracker::nanotrack::follower::{Follower, Memory};
use crate::tracker::nanotrack::look::Look;
use std::sync::Arc;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "watchdog-agreement",
    1,
    "how a deep watchdog, which follows the target from the first frame on, agrees with the tracker",
)
.more(&["{ version = \"v3\", values = [\"overlap\", \"score\", \"distance\", \"apart\"] }"]);

/// Largest distance, in units of the tracker's box.
pub(super) const FAR: f64 = 3.0;

/// A value of the signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Value {
    /// Overlap of watchdog and tracker.
    Overlap,
    /// Score of the watchdog at the watchdog's own place.
    Score,
    /// Product `(1 - overlap) score`.
    Disagreement,
    /// Score if the two boxes do not overlap, else 0.
    Apart,
    /// Distance of their centers in units of the tracker's box, at most 3.
    Distance,
}

impl Value {
    /// Direction in which the value is good.
    pub(super) fn direction(self) -> Direction {
        match self {
            Self::Overlap | Self::Score => Direction::HigherIsBetter,
            Self::Disagreement | Self::Apart | Self::Distance => Direction::LowerIsBetter,
        }
    }

    /// Least and largest value.
    pub(super) fn bounds(self) -> (f64, f64) {
        (0.0, if self == Self::Distance { FAR } else { 1.0 })
    }
}

#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Version of the watchdog's network.
    pub version: Version,
    /// Values that the signal gives for each frame, each at most once.
    #[default(vec![Value::Disagreement])]
    pub values: Vec<Value>,
}

impl PlainParams for Params {
    fn check(&self) -> Result<(), ParamError> {
        once("values", &self.values)?;
        ParamError::unless(!self.values.is_empty(), "values", "at least one", "[]")
    }
}

/// Checks that a list has no repetitions.
pub(super) fn once<T: PartialEq + std::fmt::Debug>(
    key: &'static str,
    values: &[T],
) -> Result<(), ParamError> {
    let differ = values.iter().enumerate().all(|(i, value)| !values[..i].contains(value));
    ParamError::unless(differ, key, "a list of different values", format!("{values:?}"))
}

impl Signal for Params {
    fn facts(&self) -> Facts {
        let (values, first) = (&self.values, self.values[0]);
        Facts { symbol: "dₜ", width: values.len(), ..Facts::of(first.direction(), first.bounds()) }
    }

    fn start(&self, _: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError> {
        let Params { version, values } = self.clone();
        Ok(Box::new(Watching { values, watchdog: Watchdog::new(version) }))
    }
}

/// A watchdog of a track, with the values that are requested.
struct Watching {
    values: Vec<Value>,
    watchdog: Watchdog,
}

impl Session for Watching {
    fn push(&mut self, observation: &Observation<'_>) -> Result<Vec<f64>, TrackerError> {
        let Some((seen, _)) = self.watchdog.look(observation) else { return Ok(vec![f64::NAN]) };
        Ok(self.values.iter().map(|value| seen.value(*value)).collect())
    }

    fn save(&self) -> Option<Vec<u8>> {
        saved::to_bytes(&self.watchdog.memory())
    }

    fn restore(&mut self, saved: &[u8]) -> bool {
        saved::from_bytes(saved).is_some_and(|memory| self.watchdog.restore(memory))
    }
}

/// A NanoTrack that runs beside a track.
pub(super) struct Watchdog {
    version: Version,
    /// The running NanoTrack; `None` before the first frame.
    follower: Option<Follower>,
}

/// Comparison of a watchdog with the tracker in one frame.
pub(super) struct Seen {
    /// Score of the watchdog at the watchdog's own place.
    pub score: f64,
    /// Overlap of the watchdog's box with the tracker's region.
    pub overlap: f64,
    /// Distance of the two centers in units of the tracker's box, at most [`FAR`].
    pub distance: f64,
    /// Box of the watchdog.
    pub rect: Rect,
}

impl Seen {
    /// Compares a look with this score and box with a region.
    pub fn of(score: f64, rect: Rect, region: &Region) -> Self {
        Self { score, overlap: overlap(&Region::Rect(rect), region), distance: distance(&rect, region), rect }
    }

    /// Value of the signal.
    pub fn value(&self, value: Value) -> f64 {
        match value {
            Value::Overlap => self.overlap,
            Value::Score => self.score,
            Value::Disagreement => (1.0 - self.overlap) * self.score,
            Value::Apart if self.overlap > 0.0 => 0.0,
            Value::Apart => self.score,
            Value::Distance => self.distance,
        }
    }
}

impl Watchdog {
    /// Creates a watchdog before its first frame.
    pub fn new(version: Version) -> Self {
        Self { version, follower: None }
    }

    /// Compares watchdog and tracker in the next frame; `None` if the watchdog cannot start. The look of the
    /// watchdog is `None` in the first frame.
    pub fn look(&mut self, observation: &Observation<'_>) -> Option<(Seen, Option<Arc<Look>>)> {
        let (frame, region) = (observation.frame, &observation.state.region);
        let Some(follower) = &mut self.follower else {
            self.follower = Some(Follower::start(self.version, frame, region)?);
            return Some((Seen { score: 1.0, overlap: 1.0, distance: 0.0, rect: region.bounds() }, None));
        };
        let look = follower.step(frame);
        Some((Seen::of(look.chosen().score, follower.rect(), region), Some(look)))
    }

    /// Output of the watchdog's network around a box; `None` before the first frame.
    pub fn look_at(&self, frame: &Frame, rect: &Rect) -> Option<Arc<Look>> {
        self.follower.as_ref().map(|follower| follower.look_at(frame, rect))
    }

    /// Saves the state of the watchdog.
    pub fn memory(&self) -> Option<Memory> {
        self.follower.as_ref().map(Follower::memory)
    }

    /// Restores a saved state. Returns false if it is of another version.
    pub fn restore(&mut self, memory: Option<Memory>) -> bool {
        let is_none = memory.is_none();
        self.follower = memory.and_then(|memory| Follower::remembered(self.version, memory));
        is_none || self.follower.is_some()
    }
}

/// Distance of the centers of the watchdog's box and the tracker's region, in units of the latter.
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
