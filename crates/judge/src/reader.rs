//! Computes the signals of a track frame by frame. All uses share this code: experiments, whole tracks of a
//! user, and live monitoring.

use crate::image::Frame;
use crate::method::SignalChoice;
use crate::region::Region;
use crate::signal::{Observation, Reads, Session};
use crate::tracker::{RunContext, Status, TrackerError, TrackerState};
use rayon::prelude::*;
use std::sync::LazyLock;

/// A frame passed to signals that do not read pixels.
static BLANK: LazyLock<Frame> = LazyLock::new(|| Frame::new(1, 1, vec![0; 3]));

/// A signal with its state on a track.
pub struct SignalReader {
    kind: &'static str,
    reads: Reads,
    width: usize,
    session: Box<dyn Session>,
}

/// Reason why a signal has no value in a frame.
#[derive(Debug, thiserror::Error)]
pub enum SignalFault {
    /// There is no frame, or the tracker does not give an input of the signal.
    #[error("signal {kind} {need}")]
    Lacks {
        /// Kind of the signal.
        kind: &'static str,
        /// The unmet need.
        need: &'static str,
    },
    /// The value is not a finite number.
    #[error("signal {kind} is {value}")]
    NotFinite {
        /// Kind of the signal.
        kind: &'static str,
        /// Value of the signal.
        value: f64,
    },
    /// A program or file of the signal failed.
    #[error(transparent)]
    Broke(TrackerError),
}

impl SignalFault {
    /// Text of the fault, with the number of the frame if the fault does not name the place.
    pub fn in_frame(&self, number: u32) -> String {
        match self {
            Self::NotFinite { .. } => format!("{self} in frame {number}"),
            other => other.to_string(),
        }
    }
}

impl SignalReader {
    /// Signal before the first frame of a track, with the context of its tracker.
    ///
    /// # Errors
    /// When the signal cannot start, for example because a file that it reads is absent.
    pub fn start(choice: &SignalChoice, context: &RunContext<'_>) -> Result<Self, TrackerError> {
        let signal = &choice.signal;
        let (reads, width, session) = (signal.reads(), signal.width(), signal.start(context)?);
        Ok(Self { kind: choice.kind, reads, width, session })
    }

    /// Input of the signal.
    pub fn reads(&self) -> Reads {
        self.reads
    }

    /// Number of values per frame.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Values of the signal in the next frame.
    ///
    /// # Errors
    /// When the signal has no value. The frame is counted nevertheless, unless the signal needs pixels and
    /// there are none.
    pub fn push(
        &mut self,
        frame: Option<&Frame>,
        state: &TrackerState,
        companions: &[&Region],
    ) -> Result<Vec<f64>, SignalFault> {
        let kind = self.kind;
        // A confidence may be absent in single frames, for which the signal has a rule.
        let lacks = self.reads != Reads::Confidence && !self.reads.is_in(state);
        let need = match self.reads {
            Reads::Pixels if frame.is_none() => Some("needs frames"),
            reads => reads.need_of_tracker().filter(|_| lacks),
        };
        if let Some(need) = need {
            return Err(SignalFault::Lacks { kind, need });
        }
        let observation = Observation { frame: frame.unwrap_or(&BLANK), state, companions };
        let values = self.session.push(&observation).map_err(SignalFault::Broke)?;
        match values.iter().copied().find(|value| !value.is_finite()) {
            None => Ok(values),
            Some(value) => Err(SignalFault::NotFinite { kind, value }),
        }
    }
}

/// Series of each value of the signals. Each signal is given by its values frame by frame and their number
/// per frame.
pub fn columns<'a>(signals: impl IntoIterator<Item = (&'a [f64], usize)>) -> Vec<Vec<f64>> {
    let of = |(values, width): (&'a [f64], usize)| {
        (0..width).map(move |k| values.iter().skip(k).step_by(width.max(1)).copied().collect())
    };
    signals.into_iter().flat_map(of).collect()
}

/// Data of a track in one frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seen<'a> {
    /// Pixels of the frame, if available.
    pub frame: Option<&'a Frame>,
    /// Region of the tracker; `None` where it reports the target as absent.
    pub region: Option<&'a Region>,
    /// Confidence of the tracker in its own scale, high if it is sure.
    pub confidence: Option<f64>,
    /// Regions of other trackers, in the same order in all frames.
    pub companions: &'a [&'a Region],
}

/// Signals of a track, from its first region on.
///
/// Without a region, signals are read at the last one. Without a confidence, the confidence signal repeats
/// its last value.
pub struct Reader {
    signals: Vec<SignalReader>,
    last: Option<Region>,
}

impl Reader {
    /// Signals before the first frame of a track.
    ///
    /// # Errors
    /// When one of them cannot start.
    pub fn start<'s>(
        signals: impl IntoIterator<Item = &'s SignalChoice>,
        context: &RunContext<'_>,
    ) -> Result<Self, TrackerError> {
        let start = |choice: &SignalChoice| SignalReader::start(choice, context);
        Ok(Self { signals: signals.into_iter().map(start).collect::<Result<_, _>>()?, last: None })
    }

    /// Readers of the signals, in their order.
    pub fn signals(&self) -> &[SignalReader] {
        &self.signals
    }

    /// True if one of the signals reads pixels.
    pub fn reads_frames(&self) -> bool {
        self.signals.iter().any(|signal| signal.reads == Reads::Pixels)
    }

    /// Last region, at which signals are read while the tracker has none.
    pub fn last(&self) -> Option<&Region> {
        self.last.as_ref()
    }

    /// Values of the signals in the next frame, in their order; `None` before the first region.
    pub fn push(&mut self, seen: &Seen<'_>) -> Option<Vec<Result<Vec<f64>, SignalFault>>> {
        let region = seen.region.or(self.last.as_ref())?.clone();
        let status = if seen.region.is_some() { Status::Tracked } else { Status::Absent };
        let confidence = seen.confidence.filter(|c| c.is_finite());
        let state = TrackerState { confidence, ..TrackerState::new(region, status) };
        let read = |signal: &mut SignalReader| signal.push(seen.frame, &state, seen.companions);
        let values = match seen.frame {
            // Each signal has its own memory, so that the values do not depend on the threads.
            Some(_) if self.reads_frames() => self.signals.par_iter_mut().map(read).collect(),
            _ => self.signals.iter_mut().map(read).collect(),
        };
        self.last = Some(state.region);
        Some(values)
    }

    /// Saves the states of the signals.
    ///
    /// # Errors
    /// The kind of a signal that cannot be saved.
    pub fn save(&self) -> Result<Vec<Vec<u8>>, &'static str> {
        self.signals.iter().map(|signal| signal.session.save().ok_or(signal.kind)).collect()
    }

    /// Restores saved states of the same signals. Returns `false` if they do not match.
    pub fn restore(&mut self, saved: &[Vec<u8>], last: Option<Region>) -> bool {
        self.last = last;
        let pairs = self.signals.iter_mut().zip(saved);
        saved.len() == pairs.len() && pairs.into_iter().all(|(signal, saved)| signal.session.restore(saved))
    }
}
