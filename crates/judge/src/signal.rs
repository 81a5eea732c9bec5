//! Signals: one real number for each frame, or a few of one kind, computed from the frame and the tracker's state.
//!
//! A plugin is one file with parameters, a [`Signal`] that is a [`Plugin`](crate::plugin::Plugin), and an `ENTRY` in
//! [`SIGNALS`]. Signals are online: the value of frame `t` uses frames up to `t` only.
//! Most signals only say what one frame does to their memory, see `causal.rs`.

mod box_motion;
mod causal;
mod companion_overlap;
pub mod confidence;
#[cfg(test)]
mod conformance;
mod deep_verification;
pub mod distribution_field;
mod effective_particles;
mod forward_backward;
mod histogram;
mod object_color;
#[cfg(test)]
mod oracles;
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

/// Input of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reads {
    /// The frame, and the tracker's region.
    Pixels,
    /// The moments of the tracker's posterior; frames are not decoded for it.
    Posterior,
    /// The tracker's response map in numbers; frames are not decoded for it.
    Response,
    /// The tracker's own confidence, or the likelihood of its estimate; frames are not decoded for it.
    Confidence,
    /// The regions of the tracker and of other trackers on the same sequence; frames are not decoded for it.
    Companions,
    /// The tracker's region alone; frames are not decoded for it, and the one it is given may have any size.
    Boxes,
}

impl Reads {
    /// Needs of a signal with this input beside the tracker's boxes, in words.
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

    /// The need that a tracker, or the other trackers, do not meet, as a cell that is not run states it; `None` for what
    /// every tracker gives.
    pub fn need_of_tracker(self) -> Option<&'static str> {
        match self {
            Self::Pixels | Self::Boxes => None,
            Self::Posterior => Some("needs a tracker that gives its posterior"),
            Self::Response => Some("needs a tracker that gives its response map"),
            Self::Confidence => Some("needs a tracker that gives its confidence"),
            Self::Companions => Some("needs other trackers on the sequence"),
        }
    }

    /// Whether a tracker's state has it; frames and other trackers are not part of a state.
    pub fn is_in(self, state: &TrackerState) -> bool {
        match self {
            Self::Posterior => state.posterior.is_some(),
            Self::Response => state.response.is_some(),
            Self::Confidence => state.confidence_or_likelihood().is_some(),
            Self::Pixels | Self::Boxes | Self::Companions => true,
        }
    }
}

/// Everything that a signal is given of a frame.
#[derive(Clone, Copy)]
pub struct Observation<'a> {
    /// The frame; of any size for a signal that does not read pixels.
    pub frame: &'a Frame,
    /// The tracker's answer.
    pub state: &'a TrackerState,
    /// Regions of other trackers on the same sequence, in an order that stays the same from frame to frame; empty
    /// unless the signal reads [companions](Reads::Companions).
    pub companions: &'a [&'a Region],
}

impl<'a> Observation<'a> {
    /// A frame with the tracker's answer, without companions.
    pub fn new(frame: &'a Frame, state: &'a TrackerState) -> Self {
        Self { frame, state, companions: &[] }
    }
}

/// Properties of a signal's values that do not depend on the track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facts {
    /// Values that speak for a good track; those at the other end speak for a failure.
    pub direction: Direction,
    /// Smallest and largest value it can take; of several the first.
    pub bounds: (f64, f64),
    /// Its input.
    pub reads: Reads,
    /// Its symbol in figures.
    pub symbol: &'static str,
    /// Whether its values are probabilities: that the tracker is on target where high values are good, else that it is not.
    pub is_probability: bool,
    /// Number of its values in a frame, at least 1. Those after the first are for detectors that read several.
    pub width: usize,
}

impl Facts {
    /// The facts of a signal that has one value in a frame, which it reads from the pixels.
    pub const fn of(direction: Direction, bounds: (f64, f64)) -> Self {
        Self { direction, bounds, reads: Reads::Pixels, symbol: "yₜ", is_probability: false, width: 1 }
    }
}

/// A checked configuration of a signal.
pub trait Signal: Any + Send + Sync {
    /// Properties of its values.
    fn facts(&self) -> Facts;

    /// Its input.
    fn reads(&self) -> Reads {
        self.facts().reads
    }

    /// Number of its values in a frame.
    fn width(&self) -> usize {
        self.facts().width
    }

    /// The files that it reads besides the frames; their digests are part of a signal's address.
    ///
    /// # Errors
    /// When one of them is absent.
    fn inputs(&self, _context: &RunContext<'_>) -> Result<Vec<std::path::PathBuf>, TrackerError> {
        Ok(Vec::new())
    }

    /// Starts the computation for one track; the context is that of its tracker.
    ///
    /// # Errors
    /// When a file that it reads is absent or broken.
    fn start(&self, context: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError>;
}

impl<P: Signal> Role<P> for dyn Signal {
    fn hold(plugin: P) -> Arc<Self> {
        Arc::new(plugin)
    }
}

/// A signal being computed; `push` is called once a frame, in order, from the first frame on.
pub trait Session: Send {
    /// The signal's value at this frame; not finite where the state lacks what the signal reads.
    fn push(&mut self, observation: &Observation<'_>) -> f64;

    /// The further values of the last frame, as many as [`Signal::width`] has beyond the first.
    fn more(&self) -> &[f64] {
        &[]
    }

    /// The reason why the last value is not finite, from signals that run trackers or programs of their own.
    fn fault(&mut self) -> Option<TrackerError> {
        None
    }

    /// Everything that it remembers, for [`Session::restore`]; `None` from signals that cannot be interrupted.
    fn save(&self) -> Option<Vec<u8>> {
        None
    }

    /// Gives a session before its first frame the memory of another one of the same signal, so that both go on with the
    /// same values; `false`, and the session is of no more use, if the bytes are not what [`Session::save`] gave.
    fn restore(&mut self, _saved: &[u8]) -> bool {
        false
    }
}

/// Every signal, by kind.
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
