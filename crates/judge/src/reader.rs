//! Gives the frames of a track to its signals: the one place where that is done, for experiments, for whole tracks of a
//! user, and live.

use crate::image::Frame;
use crate::method::SignalChoice;
use crate::region::Region;
use crate::signal::{Observation, Reads, Session};
use crate::tracker::{RunContext, Status, TrackerError, TrackerState};
use rayon::prelude::*;
use std::sync::LazyLock;

/// A frame for signals that do not look at it.
static BLANK: LazyLock<Frame> = LazyLock::new(|| Frame::new(1, 1, vec![0; 3]));

/// A signal of a track, with its memory.
pub struct SignalReader {
    kind: &'static str,
    reads: Reads,
    width: usize,
    session: Box<dyn Session>,
}

/// Why a signal has no value in a frame.
#[derive(Debug, thiserror::Error)]
pub enum SignalFault {
    /// There is no frame to look at.
    #[error("signal {0} needs frames")]
    NoFrame(&'static str),
    /// The tracker does not give what it reads.
    #[error("signal {kind} {need}")]
    Lacks {
        /// Its kind.
        kind: &'static str,
        /// The need that is not met.
        need: &'static str,
    },
    /// Its value is no finite number.
    #[error("signal {kind} is {value}")]
    NotFinite {
        /// Its kind.
        kind: &'static str,
        /// Its value.
        value: f64,
    },
    /// What it runs or reads broke.
    #[error(transparent)]
    Broke(TrackerError),
}

impl SignalFault {
    /// Its words, with the number of the frame where they do not tell the place.
    pub fn in_frame(&self, number: u32) -> String {
        match self {
            Self::NotFinite { .. } => format!("{self} in frame {number}"),
            other => other.to_string(),
        }
    }
}

impl SignalReader {
    /// The signal before the first frame of a track; the context is that of its tracker.
    ///
    /// # Errors
    /// When it cannot start, e.g. a file that it reads is absent.
    pub fn start(choice: &SignalChoice, context: &RunContext<'_>) -> Result<Self, TrackerError> {
        let signal = &choice.signal;
        let (reads, width, session) = (signal.reads(), signal.width(), signal.start(context)?);
        Ok(Self { kind: choice.kind, reads, width, session })
    }

    /// Its kind.
    pub fn kind(&self) -> &'static str {
        self.kind
    }

    /// Its input.
    pub fn reads(&self) -> Reads {
        self.reads
    }

    /// Number of its values in a frame.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Its values in the next frame.
    ///
    /// # Errors
    /// When it has none; the frame counts all the same, unless there is none to look at.
    pub fn push(
        &mut self,
        frame: Option<&Frame>,
        state: &TrackerState,
        companions: &[&Region],
    ) -> Result<Vec<f64>, SignalFault> {
        let kind = self.kind;
        // A confidence may be absent in single frames, for which the signal has a rule.
        let lacks = self.reads != Reads::Confidence && !self.reads.is_in(state);
        if let Some(need) = self.reads.need_of_tracker().filter(|_| lacks) {
            return Err(SignalFault::Lacks { kind, need });
        }
        let frame = match frame {
            None if self.reads == Reads::Pixels => return Err(SignalFault::NoFrame(kind)),
            frame => frame.unwrap_or(&BLANK),
        };
        let first = self.session.push(&Observation { frame, state, companions });
        let values: Vec<f64> = std::iter::once(first).chain(self.session.more().iter().copied()).collect();
        match (values.iter().find(|value| !value.is_finite()), self.session.fault()) {
            (None, _) => Ok(values),
            (_, Some(fault)) => Err(SignalFault::Broke(fault)),
            (Some(value), None) => Err(SignalFault::NotFinite { kind, value: *value }),
        }
    }

    /// Everything that it remembers; `None` from signals that cannot be interrupted.
    pub fn save(&self) -> Option<Vec<u8>> {
        self.session.save()
    }

    /// Takes over the memory of another one of the same signal; `false` if it does not fit.
    pub fn restore(&mut self, saved: &[u8]) -> bool {
        self.session.restore(saved)
    }
}

/// The series of each value of signals, from their values frame by frame and the numbers of them in a frame.
pub fn columns<'a>(signals: impl IntoIterator<Item = (&'a [f64], usize)>) -> Vec<Vec<f64>> {
    let of = |(values, width): (&'a [f64], usize)| {
        (0..width).map(move |k| values.iter().skip(k).step_by(width.max(1)).copied().collect())
    };
    signals.into_iter().flat_map(of).collect()
}

/// Everything that is known of a track in a frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seen<'a> {
    /// The frame.
    pub frame: Option<&'a Frame>,
    /// The tracker's region; `None` where it says that the target is absent.
    pub region: Option<&'a Region>,
    /// The tracker's own confidence, in its scale; high values are sure.
    pub confidence: Option<f64>,
    /// Regions of other trackers, in the same order in all frames.
    pub companions: &'a [&'a Region],
}

/// The signals of a track, from its first region on.
///
/// Where the tracker has no region, signals are read at its last one; where it has no confidence, the signal of the
/// confidence has its last value again.
pub struct Reader {
    signals: Vec<SignalReader>,
    last: Option<Region>,
}

impl Reader {
    /// The signals before the first frame of a track.
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

    /// Its signals.
    pub fn signals(&self) -> &[SignalReader] {
        &self.signals
    }

    /// Whether a signal looks at pixels.
    pub fn reads_frames(&self) -> bool {
        self.signals.iter().any(|signal| signal.reads == Reads::Pixels)
    }

    /// The last region, where signals are read while the tracker has none.
    pub fn last(&self) -> Option<&Region> {
        self.last.as_ref()
    }

    /// The values of the signals in the next frame, in their order; `None` before the first region.
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

    /// What its signals remember.
    ///
    /// # Errors
    /// The kind of a signal that cannot be saved.
    pub fn save(&self) -> Result<Vec<Vec<u8>>, &'static str> {
        self.signals.iter().map(|signal| signal.save().ok_or(signal.kind)).collect()
    }

    /// Takes over what another one of the same signals remembered; `false` if it does not fit.
    pub fn restore(&mut self, saved: &[Vec<u8>], last: Option<Region>) -> bool {
        self.last = last;
        let pairs = self.signals.iter_mut().zip(saved);
        saved.len() == pairs.len() && pairs.into_iter().all(|(signal, saved)| signal.restore(saved))
    }
}
