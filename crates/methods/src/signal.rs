//! Signals: one real number for each frame, computed from the frame and the tracker's state.
//!
//! A plugin is one file with parameters, a [`Signal`] and an `ENTRY` in [`SIGNALS`]. Signals are
//! online: the value of frame `t` uses frames up to `t` only.

pub mod box_motion;
#[cfg(test)]
mod conformance;
pub mod distribution_field;
pub mod forward_backward;
mod histogram;
#[cfg(test)]
mod oracles;
pub mod region_covariance;
pub mod rgb_histogram;
pub mod rgb_lbp_histogram;
pub mod template_correlation;
pub mod uncertainty;
pub mod uncertainty_change;

pub use crate::direction::Direction;
use crate::image::Frame;
use crate::plugin::Entry;
use crate::tracker::TrackerState;

/// Input of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reads {
    /// The frame, and the tracker's region.
    Pixels,
    /// The moments of the tracker's posterior; frames are not decoded for it.
    Posterior,
    /// The tracker's region alone; frames are not decoded for it, and the one it is given may have any size.
    Boxes,
}

/// A checked configuration of a signal.
pub trait Signal: Send + Sync {
    /// Checked parameters, defaults filled in.
    fn params(&self) -> serde_json::Value;

    /// Which values are good; the others speak for a failure.
    fn direction(&self) -> Direction;

    /// Its input.
    fn reads(&self) -> Reads {
        Reads::Pixels
    }

    /// Its symbol in figures.
    fn symbol(&self) -> &'static str {
        "yₜ"
    }

    /// Smallest and largest value it can take.
    fn bounds(&self) -> (f64, f64);

    /// Starts the computation for one track.
    fn start(&self) -> Box<dyn Session>;
}

/// A signal being computed; `push` is called once a frame, in order, from the first frame on.
pub trait Session: Send {
    /// The signal's value at this frame; not finite where the state lacks what the signal reads.
    fn push(&mut self, frame: &Frame, state: &TrackerState) -> f64;
}

/// Every signal, by kind.
pub static SIGNALS: &[Entry<dyn Signal>] = &[
    box_motion::ENTRY,
    distribution_field::ENTRY,
    forward_backward::ENTRY,
    region_covariance::ENTRY,
    rgb_histogram::ENTRY,
    rgb_lbp_histogram::ENTRY,
    template_correlation::ENTRY,
    uncertainty::ENTRY,
    uncertainty_change::ENTRY,
];
