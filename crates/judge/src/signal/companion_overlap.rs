//! `companion-overlap`: overlap of the tracker's region with the regions of other trackers, its companions, on the same
//! frame. Trackers that disagree cannot all be right.
//!
//! ```text
//! o[i] = |A ∩ C[i]| / |A ∪ C[i]|        of the tracker's region A with companion i's region C[i], exact areas
//! median    median of the o[i]
//! minimum   smallest of the o[i]
//! share     share of the companions with o[i] > 0
//! ```
//!
//! Values lie in `[0, 1]` and have no unit; high values are good. With the median, 0 says that at least half of the
//! companions are elsewhere. A companion that has no region in a frame, or one whose coordinates are no numbers,
//! overlaps nothing.
//!
//! Companions are one of two:
//! - `companions = "given"`: the first runs of the other trackers of the experiment, in its order; in `detect`, the
//!   companion's boxes that it is given. `at_most` takes only the first of them.
//! - a list of watchdogs that the signal runs itself: `{ tracker = "kcf" }`, started in the first frame with the tracker's own
//!   region. One that is itself lost is started again, see `companion_overlap/watchdog.rs`.
//!
//! Source: none for single objects; the disagreement of an ensemble is a common measure of uncertainty. Choices: the
//! median, which one bad companion in three does not change; the first `at_most` companions instead of drawn ones, so
//! that results are the same every time.

mod watchdog;

use crate::num::summary;
use crate::region::Areas;
use crate::signal::prelude::*;
use watchdog::{Companion, CompanionParams, RunningCompanion, SavedCompanion};

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<CompanionOverlap>(
    "companion-overlap",
    1,
    "overlap of the tracker's box with those of other trackers, or of a watchdog that it runs itself",
)
.example("{ statistic = \"median\" }");

/// Statistic that reduces the overlaps with several companions to one value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Statistic {
    /// Median of the overlaps.
    Median,
    /// Smallest overlap.
    Minimum,
    /// Share of the overlaps above 0.
    Share,
}

/// Source of the companions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "`companions` must be \"given\" or a list of `{ tracker = ... }`")]
pub enum Companions {
    /// Companions from outside, written as `given`.
    ExternalCompanions(ExternalCompanions),
    /// Companions that the signal runs itself.
    Own(Vec<CompanionParams>),
}

/// Companions from outside the signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ExternalCompanions {
    /// Other trackers of the experiment, or the boxes given to `detect`.
    Given,
}

/// Parameters of the signal.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Statistic that reduces several overlaps to one value.
    pub statistic: Statistic,
    /// `given`, or a list of companions that the signal runs itself.
    pub companions: Companions,
    /// Most given companions that are used, at least 1; by default all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most: Option<usize>,
}

impl Default for Params {
    fn default() -> Self {
        let companions = Companions::ExternalCompanions(ExternalCompanions::Given);
        Self { statistic: Statistic::Median, companions, at_most: None }
    }
}

/// The signal with checked parameters.
pub struct CompanionOverlap {
    params: Params,
    own: Vec<Companion>,
}

impl Plugin for CompanionOverlap {
    type Params = Params;

    const RANGES: &'static [Range] = &[Range::of("at_most").at_least(1.0)];

    fn make(params: Params) -> Result<Self, ParamError> {
        let own = match &params.companions {
            Companions::ExternalCompanions(_) => Vec::new(),
            Companions::Own(list) => {
                let rule = "a list with a companion, or `given`";
                ParamError::unless(!list.is_empty(), "companions", rule, "[]")?;
                list.iter().map(Companion::new).collect::<Result<_, _>>()?
            }
        };
        if let Some(n) = params.at_most {
            let rule = "left out when the companions are listed";
            ParamError::unless(own.is_empty(), "at_most", rule, n)?;
        }
        Ok(Self { params, own })
    }
}

impl Signal for CompanionOverlap {
    fn facts(&self) -> Facts {
        let reads = match self.params.companions {
            Companions::ExternalCompanions(_) => Reads::Companions,
            Companions::Own(_) => Reads::Pixels,
        };
        Facts { reads, symbol: "oₜ", ..Facts::of(Direction::HigherIsBetter, (0.0, 1.0)) }
    }

    fn start(&self, context: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError> {
        let own = self.own.iter().map(|companion| companion.start(context)).collect::<Result<_, _>>()?;
        Ok(Box::new(Agreement { params: self.params.clone(), own }))
    }
}

/// Overlap of one track with its companions.
struct Agreement {
    params: Params,
    own: Vec<RunningCompanion>,
}

impl Session for Agreement {
    fn push(&mut self, observation: &Observation<'_>) -> Result<Vec<f64>, TrackerError> {
        let most = self.params.at_most.unwrap_or(usize::MAX);
        let given = |other: &&Region| overlap(&observation.state.region, other);
        let overlaps: Vec<f64> = match self.own.as_mut_slice() {
            [] => observation.companions.iter().take(most).map(given).collect(),
            own => {
                own.iter_mut().map(|companion| companion.overlap(observation)).collect::<Result<_, _>>()?
            }
        };
        Ok(vec![statistic(self.params.statistic, overlaps)])
    }

    fn save(&self) -> Option<Vec<u8>> {
        let own: Option<Vec<_>> = self.own.iter().map(RunningCompanion::save).collect();
        saved::to_bytes(&own?)
    }

    fn restore(&mut self, saved: &[u8]) -> bool {
        let Some(own) = saved::from_bytes::<Vec<SavedCompanion>>(saved) else { return false };
        own.len() == self.own.len() && self.own.iter_mut().zip(own).all(|(own, saved)| own.restore(saved))
    }
}

/// Overlap of two regions; 0 if a coordinate is NaN.
pub(super) fn overlap(a: &Region, b: &Region) -> f64 {
    if a.is_finite() && b.is_finite() { Areas::Exact.overlap(a, b, None) } else { 0.0 }
}

/// Statistic of overlaps; NaN without any.
fn statistic(statistic: Statistic, mut overlaps: Vec<f64>) -> f64 {
    let value = match statistic {
        Statistic::Median => summary::median(&mut overlaps),
        Statistic::Minimum => overlaps.iter().copied().min_by(f64::total_cmp),
        Statistic::Share => {
            let some = overlaps.iter().filter(|overlap| **overlap > 0.0).count();
            (!overlaps.is_empty()).then(|| some as f64 / overlaps.len() as f64)
        }
    };
    value.unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests;
