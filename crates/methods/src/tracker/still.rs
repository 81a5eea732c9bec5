//! The null tracker: answers the first region for ever.
//!
//! What any tracker has to beat, and a check of the tables: its overlap is that of the target with its
//! own first place. No parameters, no randomness, no source.

use super::{RunContext, Tracker, TrackerConfig, TrackerError, TrackerState};
use crate::image::Frame;
use crate::plugin::{Entry, RawParams, read_params, show_params};
use crate::region::Region;
use serde::{Deserialize, Serialize};

/// Parameters: none.
#[derive(Debug, Clone, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {}

/// The list's line.
pub const ENTRY: Entry<dyn TrackerConfig> = Entry {
    kind: "still",
    version: 1,
    summary: "never moves: the first region in every frame",
    example: "{}",
    build: |raw: RawParams<'_>| Ok(Box::new(Still(read_params(raw)?))),
    schema: || schemars::schema_for!(Params),
};

struct Still(Params);

impl TrackerConfig for Still {
    fn params(&self) -> serde_json::Value {
        show_params(&self.0)
    }

    fn uses_seed(&self) -> bool {
        false
    }

    fn open(&self, _: &RunContext<'_>) -> Result<Box<dyn Tracker>, TrackerError> {
        Ok(Box::new(Tracking(None)))
    }
}

struct Tracking(Option<Region>);

impl Tracker for Tracking {
    fn init(&mut self, _: &Frame, region: &Region) -> Result<TrackerState, TrackerError> {
        self.0 = Some(region.clone());
        Ok(TrackerState::initialised(region.clone()))
    }

    fn update(&mut self, _: &Frame) -> Result<TrackerState, TrackerError> {
        match &self.0 {
            Some(region) => Ok(TrackerState::tracked(region.clone())),
            None => Err(TrackerError::Broken("still: a frame before the initialisation".into())),
        }
    }

    fn reset(&mut self) {
        self.0 = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::Rect;

    #[test]
    fn stays_until_it_is_started_again() {
        let setup = ENTRY.build_from_text("{}").unwrap();
        let sequence = crate::dataset::synthetic::suite("synthetic-otb").unwrap().swap_remove(0);
        let start = RunContext { sequence: &sequence, run: 0, seed: 0, data_root: None };
        let mut t = setup.open(&start).unwrap();
        let frame = Frame::new(2, 2, vec![0; 12]);
        assert!(t.update(&frame).is_err());
        for x in [3.0, 7.5] {
            let region = Region::Rect(Rect::new(x, 1.0, 2.0, 2.0));
            t.init(&frame, &region).unwrap();
            assert_eq!(t.update(&frame).unwrap(), TrackerState::tracked(region.clone()));
            assert_eq!(t.update(&frame).unwrap().region, region);
        }
        assert!(ENTRY.build_from_text("{ speed = 1 }").is_err());
    }
}
