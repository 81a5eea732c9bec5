//! Watchdogs: companions that the signal runs itself. A watchdog is a built-in tracker that starts on the
//! first region of the observed tracker and then follows the target alone.
//!
//! A watchdog loses its target too. It is started again on the observed tracker's region when both hold:
//! - the two regions have not overlapped in the last `restart_after` frames, this one included, and
//! - the observed region looks more like the target in the first frame than the watchdog's: the similarity of the RGB
//!   histograms (Bhattacharyya coefficient of 8 x 8 x 8 bins) is larger by more than `restart_margin`.
//!
//! In the frame of a restart, the value still comes from the watchdog before. Without the second rule, a
//! watchdog on target would be moved to the background together with the lost tracker. Choices: 10 frames, in
//! which a briefly lost overlap returns; a margin of 0.1, so that two similar boxes on the background cause
//! no restart.

use super::overlap;
use crate::num::seed;
use crate::plugin::{self, ParamError, RawParams};
use crate::sequence::SequenceInfo;
use crate::signal::histogram::Reference;
use crate::signal::rgb_histogram;
use crate::signal::{Observation, Session, Signal};
use crate::tracker::{RunContext, TRACKERS, Tracker, TrackerConfig, TrackerError, TrackerState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Parameters of a watchdog.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompanionParams {
    /// Kind of a built-in tracker that needs only frames.
    pub tracker: String,
    /// Parameters of the tracker.
    #[serde(default, skip_serializing_if = "serde_json::Map::is_empty")]
    pub params: serde_json::Map<String, serde_json::Value>,
    /// Number of frames in a row without overlap after which a watchdog may be restarted; 0 for never.
    #[serde(default = "restart_after")]
    pub restart_after: usize,
    /// Least difference in similarity to the first frame for a restart, 0 to 1.
    #[serde(default = "restart_margin")]
    pub restart_margin: f64,
}

fn restart_after() -> usize {
    10
}

fn restart_margin() -> f64 {
    0.1
}

/// A watchdog with checked parameters.
pub struct Companion {
    params: CompanionParams,
    config: Arc<dyn TrackerConfig>,
}

impl Companion {
    /// Checks the parameters.
    ///
    /// # Errors
    /// When a parameter is out of range, or the tracker refuses its parameters.
    pub fn new(params: &CompanionParams) -> Result<Self, ParamError> {
        let margin = params.restart_margin;
        ParamError::unless((0.0..=1.0).contains(&margin), "restart_margin", "from 0 to 1", margin)?;
        let refuse = |message: String| ParamError { message, key: Some("companions"), span: None };
        let kind = params.tracker.as_str();
        let entry = plugin::find(TRACKERS, kind).ok_or_else(|| {
            refuse(plugin::unknown("companion tracker", kind, TRACKERS.iter().map(|e| e.kind)))
        })?;
        let config = (entry.build)(RawParams::Json(&params.params.clone().into()))
            .map_err(|e| refuse(format!("companion {kind}: {}", e.message)))?;
        if config.facts().needs_truth || !config.facts().reads_pixels {
            return Err(refuse(format!(
                "companion {kind}: a companion must follow the target in the frames"
            )));
        }
        Ok(Self { params: params.clone(), config: config.plugin })
    }

    /// Watchdog before its first frame.
    ///
    /// # Errors
    /// None is expected.
    pub fn start(&self, context: &RunContext<'_>) -> Result<RunningCompanion, TrackerError> {
        let likeness = self.params.restart_after > 0;
        let likeness =
            if likeness { Some([likeness_to_first(context)?, likeness_to_first(context)?]) } else { None };
        Ok(RunningCompanion {
            params: self.params.clone(),
            config: self.config.clone(),
            sequence: context.sequence.shared(),
            start_frame: context.start_frame,
            tracker: None,
            likeness,
            apart: 0,
        })
    }
}

/// Signal of similarity between a region and that of the first frame.
fn likeness_to_first(context: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError> {
    let params = rgb_histogram::Params { reference: Reference::First, ..rgb_histogram::Params::default() };
    params.start(context)
}

/// A running watchdog.
pub struct RunningCompanion {
    params: CompanionParams,
    config: Arc<dyn TrackerConfig>,
    sequence: Arc<dyn SequenceInfo>,
    start_frame: usize,
    tracker: Option<Box<dyn Tracker>>,
    /// Similarity to the first frame of the observed and of the watchdog's region, for watchdogs that may be
    /// restarted.
    likeness: Option<[Box<dyn Session>; 2]>,
    /// Number of frames in a row without overlap.
    apart: usize,
}

/// Saved state of a watchdog.
#[derive(Serialize, Deserialize)]
pub struct SavedCompanion {
    tracker: Option<Vec<u8>>,
    likeness: Option<[Vec<u8>; 2]>,
    apart: usize,
}

impl RunningCompanion {
    /// Saves the state; `None` if the tracker cannot be saved.
    pub fn save(&self) -> Option<SavedCompanion> {
        let tracker = match &self.tracker {
            Some(tracker) => Some(tracker.save()?),
            None => None,
        };
        let likeness = match &self.likeness {
            Some([observed, own]) => Some([observed.save()?, own.save()?]),
            None => None,
        };
        Some(SavedCompanion { tracker, likeness, apart: self.apart })
    }

    /// Restores a saved state. Returns `false` if it does not match this watchdog.
    pub fn restore(&mut self, saved: SavedCompanion) -> bool {
        self.apart = saved.apart;
        let like = match (&mut self.likeness, &saved.likeness) {
            (Some([a, b]), Some([saved_a, saved_b])) => a.restore(saved_a) && b.restore(saved_b),
            (own, saved) => own.is_none() && saved.is_none(),
        };
        self.tracker = saved.tracker.as_deref().and_then(|saved| self.config.resume(saved));
        like && self.tracker.is_some() == saved.tracker.is_some()
    }

    /// Starts the watchdog's tracker on the observed region.
    fn start_on(
        &self,
        observation: &Observation<'_>,
    ) -> Result<(Box<dyn Tracker>, TrackerState), TrackerError> {
        let context = RunContext {
            sequence: &*self.sequence,
            start_frame: self.start_frame,
            run: 0,
            seed: seed::seed(0, &["companion", &self.params.tracker]),
            data_roots: &[],
        };
        self.config.start(&context, observation.frame, &observation.state.region)
    }

    /// Overlap of the observed region with the watchdog's in the next frame.
    ///
    /// # Errors
    /// When the watchdog cannot start, or its tracker fails.
    pub fn overlap(&mut self, observation: &Observation<'_>) -> Result<f64, TrackerError> {
        let state = match &mut self.tracker {
            Some(tracker) => tracker.update(observation.frame)?,
            None => {
                let (tracker, state) = self.start_on(observation)?;
                self.tracker = Some(tracker);
                state
            }
        };
        let overlap = overlap(&observation.state.region, &state.region);
        self.apart = if overlap > 0.0 { 0 } else { self.apart.saturating_add(1) };
        if let Some([observed, own]) = &mut self.likeness {
            let mine = Observation::new(observation.frame, &state);
            let gain = observed.push(observation)?[0] - own.push(&mine)?[0];
            if self.apart >= self.params.restart_after && gain > self.params.restart_margin {
                self.tracker = Some(self.start_on(observation)?.0);
                self.apart = 0;
            }
        }
        Ok(overlap)
    }
}
