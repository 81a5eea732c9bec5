//! Signals: one real number per frame, or a few related ones, computed from the frame and the tracker's
//! state.
//!
//! A plugin is one file with parameters, a [`Signal`] that is a [`Plugin`](crate::plugin::Plugin), and an
//! `ENTRY` in [`SIGNALS`]. Signals are online: the value of frame `t` uses frames up to `t` only. Most
//! signals only define how one frame changes their memory, see `causal.rs`.

mod box_motion;
mod causal;
mod companion_overlap;
pub mod confidence;
#[cfg(test)]
mod conformance_tests;
mod deep_verification;
pub mod distribution_field;
mod effective_particles;
mod forward_backward;
mod histogram;
mod object_color;
#[cfg(test)]
mod oracle_tests;
mod particle_entropy;
mod region_covariance;
mod response_apce;
mod response_peak;
mod response_psr;
mod rgb_histogram;
mod rgb_lbp_histogram;
mod template_correlation;
#[cfg(test)]
mod testing;
pub(crate) mod uncertainty;
pub(crate) mod uncertainty_change;
mod watchdog_agreement;

pub use crate::direction::Direction;
use crate::image::Frame;
use crate::plugin::{Entry, Role};
use crate::region::Region;
use crate::tracker::{RunContext, TrackerError, TrackerState};
use std::any::Any;
use std::sync::Arc;

/// Names that most files of signals import.
mod prelude {
    pub use super::causal::{Causal, SIZE_HISTORY, is_default};
    pub use super::{Direction, Facts, Observation, Reads, Session, Signal};
    pub use crate::image::{Frame, Window};
    pub use crate::plugin::{Entry, ParamError, PlainParams, Plugin, Range};
    pub use crate::region::{Rect, Region};
    pub(super) use crate::saved;
    pub use crate::tracker::{RunContext, TrackerError};
    pub use schemars::JsonSchema;
    pub use serde::{Deserialize, Serialize};
    pub use smart_default::SmartDefault;
}

/// Input of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reads {
    /// Pixels of the frame, and the tracker's region.
    Pixels,
    /// Moments of the tracker's posterior; frames are not decoded for it.
    Posterior,
    /// Numbers of the tracker's response map; frames are not decoded for it.
    Response,
    /// Confidence of the tracker, or the likelihood of its estimate; frames are not decoded for it.
    Confidence,
    /// Regions of the tracker and of other trackers on the same sequence; frames are not decoded for it.
    Companions,
    /// Region of the tracker alone; frames are not decoded for it, and the given frame may have any size.
    Boxes,
}

impl Reads {
    /// Inputs that a signal needs beside the tracker's boxes, in words.
    pub fn need(self) -> &'static str {
        match self {
            Self::Pixels => "frames",
            Self::Posterior => "the tracker's posterior",
            Self::Response => "the tracker's response map",
            Self::Confidence => "the tracker's confidence",
            Self::Boxes => "boxes alone",
            Self::Companions => "other trackers' boxes",
        }
    }

    /// Reason shown for a cell that cannot run, such as "needs a posterior"; `None` if every tracker provides
    /// this input.
    pub fn need_of_tracker(self) -> Option<&'static str> {
        match self {
            Self::Pixels | Self::Boxes => None,
            Self::Posterior => Some("needs a tracker that gives its posterior"),
            Self::Response => Some("needs a tracker that gives its response map"),
            Self::Confidence => Some("needs a tracker that gives its confidence"),
            Self::Companions => Some("needs other trackers on the sequence"),
        }
    }

    /// True if the tracker's state contains this input. Frames and other trackers are not part of a state.
    pub fn is_in(self, state: &TrackerState) -> bool {
        match self {
            Self::Posterior => state.posterior.is_some(),
            Self::Response => state.response.is_some(),
            Self::Confidence => state.confidence_or_likelihood().is_some(),
            Self::Pixels | Self::Boxes | Self::Companions => true,
        }
    }
}

/// Data of one frame for a signal.
#[derive(Clone, Copy)]
pub struct Observation<'a> {
    /// Pixels of the frame; of any size for signals that do not read them.
    pub frame: &'a Frame,
    /// State of the tracker in this frame.
    pub state: &'a TrackerState,
    /// Regions of other trackers on the same sequence, in the same order in all frames; empty unless the
    /// signal reads [companions](Reads::Companions).
    pub companions: &'a [&'a Region],
}

impl<'a> Observation<'a> {
    /// Observation of a frame and the tracker's state, without companions.
    pub fn new(frame: &'a Frame, state: &'a TrackerState) -> Self {
        Self { frame, state, companions: &[] }
    }
}

/// Properties of a signal's values that are independent of the track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facts {
    /// Direction in which values are good. Values at the other end speak for a failure.
    pub direction: Direction,
    /// Least and largest possible value; for several values, those of the first.
    pub bounds: (f64, f64),
    /// Input of the signal.
    pub reads: Reads,
    /// Symbol of the signal in figures.
    pub symbol: &'static str,
    /// Number of its values in a frame, at least 1. Those after the first are for detectors that read several.
    pub width: usize,
}

impl Facts {
    /// Facts of a signal with one value per frame, computed from pixels.
    pub const fn of(direction: Direction, bounds: (f64, f64)) -> Self {
        Self { direction, bounds, reads: Reads::Pixels, symbol: "yₜ", width: 1 }
    }
}

/// A signal with checked parameters.
pub trait Signal: Any + Send + Sync {
    /// Properties of the signal's values.
    fn facts(&self) -> Facts;

    /// Input of the signal.
    fn reads(&self) -> Reads {
        self.facts().reads
    }

    /// Number of values per frame.
    fn width(&self) -> usize {
        self.facts().width
    }

    /// Files that the signal reads besides the frames. Their digests are part of the signal's address.
    ///
    /// # Errors
    /// When one of the files is absent.
    fn inputs(&self, _context: &RunContext<'_>) -> Result<Vec<std::path::PathBuf>, TrackerError> {
        Ok(Vec::new())
    }

    /// Starts the computation for one track, with the context of its tracker.
    ///
    /// # Errors
    /// When a file that the signal reads is absent or broken.
    fn start(&self, context: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError>;
}

impl<P: Signal> Role<P> for dyn Signal {
    fn hold(plugin: P) -> Arc<Self> {
        Arc::new(plugin)
    }
}

/// A signal on one track. `push` is called once per frame, in order, from the first frame on.
pub trait Session: Send {
    /// Values of the signal in this frame, as many as its [width](Signal::width); not finite if the state lacks
    /// the signal's input.
    ///
    /// # Errors
    /// When a tracker or a program that the signal runs fails, or the reason why the value is not finite.
    fn push(&mut self, observation: &Observation<'_>) -> Result<Vec<f64>, TrackerError>;

    /// Saves the state for [`Session::restore`]; `None` from signals that cannot be interrupted.
    fn save(&self) -> Option<Vec<u8>> {
        None
    }

    /// Restores a state of the same signal in a session before its first frame; the values then continue as
    /// before. Returns `false` if the bytes are not from [`Session::save`]; the session can then no longer be
    /// used.
    fn restore(&mut self, _saved: &[u8]) -> bool {
        false
    }
}

/// All signals, by kind.
pub static SIGNALS: &[Entry<dyn Signal>] = &[
    box_motion::ENTRY,
    companion_overlap::ENTRY,
    confidence::ENTRY,
    deep_verification::ENTRY,
    distribution_field::ENTRY,
    effective_particles::ENTRY,
    forward_backward::ENTRY,
    object_color::ENTRY,
    particle_entropy::ENTRY,
    region_covariance::ENTRY,
    response_apce::ENTRY,
    response_peak::ENTRY,
    response_psr::ENTRY,
    rgb_histogram::ENTRY,
    rgb_lbp_histogram::ENTRY,
    template_correlation::ENTRY,
    uncertainty::ENTRY,
    uncertainty_change::ENTRY,
    watchdog_agreement::ENTRY,
];
