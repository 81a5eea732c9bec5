//! Measures of a detector by frame, independent of its threshold: how well its scores separate lost frames
//! from good ones.
//!
//! A detector gives every frame a score, here turned so that high scores speak for a failure. [`truth`] says
//! which frames are lost, [`sweep`] puts the frames of all tracks in the order of their scores. From that
//! order come [`ranking`] (AUROC, average precision), [`coverage`] (risk-coverage curve) and [`alarms`]
//! (false alarms and delay at the threshold that finds half of the losses); [`bootstrap`] shows how much they
//! depend on the choice of sequences. [`calibration`] is for scores that are probabilities, [`warning`] for
//! frames before a loss. [`range`] and [`nab`] judge the alarms of the detector's own threshold. [`list`] has
//! all of them, [`measures`] computes them, [`protocols`] has the rules that count alarms. An alarm in one
//! frame of a loss is never counted for all of its frames (as in "point adjustment").

pub mod alarms;
pub mod bootstrap;
pub mod calibration;
pub mod coverage;
pub mod list;
pub mod measures;
pub mod nab;
pub mod protocols;
pub mod range;
pub mod ranking;
pub mod sweep;
pub mod truth;
pub mod warning;

pub use measures::{FrameMeasures, Method, measure};
pub use truth::ScoredTrack;
