//! The null tracker: reports the first region in all frames.
//!
//! It is the baseline of all trackers and a check of the tables: its overlap is that of the target with its
//! own first place. It has no parameters and no randomness.

use crate::tracker::prelude::*;

/// The still tracker in the list.
pub const ENTRY: Entry<dyn TrackerConfig> =
    Entry::of::<Still>("still", 1, "never moves: the first region in every frame");

#[derive(Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct Still {}

impl PlainParams for Still {}

impl TrackerConfig for Still {
    fn facts(&self) -> Facts {
        Facts { reads_pixels: false, ..Facts::BOXES }
    }

    fn start(&self, _: &RunContext<'_>, _: &Frame, region: &Region) -> StartResult {
        Ok((Box::new(Tracking(region.clone())), TrackerState::initialized(region.clone())))
    }
}

struct Tracking(Region);

impl Tracker for Tracking {
    fn update(&mut self, _: &Frame) -> Result<TrackerState, TrackerError> {
        Ok(TrackerState::tracked(self.0.clone()))
    }
}
