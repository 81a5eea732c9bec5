//! The null tracker: reports the first region in all frames.
//!
//! It is the baseline of all trackers and a check of the tables: its overlap is that of the target with its
//! own first place. It has no parameters and no randomness.

use super::{Facts, RunContext, StartResult, Tracker, TrackerConfig, TrackerError, TrackerState};
use crate::image::Frame;
use crate::plugin::{Entry, NoParams, ParamError, Plugin};
use crate::region::Region;

/// The still tracker in the list.
pub const ENTRY: Entry<dyn TrackerConfig> =
    Entry::of::<Still>("still", 1, "never moves: the first region in every frame");

struct Still;

impl Plugin for Still {
    type Params = NoParams;

    fn make(_: NoParams) -> Result<Self, ParamError> {
        Ok(Self)
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::Rect;
    use crate::tracker::testing::track;

    #[test]
    fn stays_where_it_is_started() {
        let sequence = trackfail_dataset::synthetic::suite("synthetic-otb").unwrap().swap_remove(0);
        let region = Region::Rect(Rect::new(3.0, 1.0, 2.0, 2.0));
        let frames = vec![Frame::new(2, 2, vec![0; 12]); 3];
        let states = track(&*ENTRY.build_from_text("{}").unwrap(), &sequence, 0, &region, &frames);
        assert_eq!(states[0], TrackerState::initialized(region.clone()));
        assert_eq!(states[1..], [TrackerState::tracked(region.clone()), TrackerState::tracked(region)]);
        assert!(ENTRY.build_from_text("{ speed = 1 }").is_err());
    }
}
