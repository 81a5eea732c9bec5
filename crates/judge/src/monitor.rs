//! Live monitoring: tells frame by frame, while a tracker runs, if it has lost its target.
//!
//! ```
//! use trackfail_judge::monitor::{Monitor, Options, TargetState, Update};
//! use trackfail_judge::region::{Rect, Region};
//! # use trackfail_judge::{image::Frame, monitor::MonitorError};
//! # let frame = Frame::from_fn(64, 48, |x, y| [(5 * x) as u8, (3 * y) as u8, (x * y) as u8]);
//! # let camera = vec![(frame.clone(), Rect::new(20.0, 10.0, 16.0, 12.0)); 3];
//! let options = Options { method: Some("Watchdog".into()), ..Options::default() };
//! let mut monitor = Monitor::new(&options)?;
//! for (frame, target) in camera {
//!     let region = Region::Rect(target);
//!     let answer = monitor.update(&Update { frame: Some(&frame), region: Some(&region), ..Update::default() })?;
//!     assert_eq!(answer.state, TargetState::Tracking);
//! }
//! // The tracker has no box for this frame.
//! let answer = monitor.update(&Update::default())?;
//! assert_eq!((answer.index, answer.state), (3, TargetState::Absent));
//! # Ok::<(), MonitorError>(())
//! ```
//!
//! A [`Monitor`] receives the data of each frame once, in order: pixels, the tracker's region and confidence,
//! and the regions of companions (other trackers on the same frames). Regions are in 0-based pixels; the top
//! left corner of the first pixel is (0, 0). All data except the first region may be missing, in some or all
//! frames. A signal value that cannot be computed is then missing for the detector, too; this is neither an
//! error nor an alarm. In a frame without a region the tracker reports the target as absent. Signals are then
//! read at its last region, and an alarm that they raise ends with the absence.
//!
//! Without a method name, the recommended method for the inputs of the first frame with a region is used;
//! with a budget, it is one that has a budget. A method that does not read frames is replaced when frames
//! arrive. After a restart of the tracker ([`Update::restart`]) the monitor starts over. The memory of a
//! monitor does not grow with the number of frames.

mod chosen;
mod saved;
mod targets;

pub use crate::detector::labels::TargetState;
pub use chosen::able;
pub use targets::{Id, MAX_TARGETS, Targets};

use crate::detector::StateOfTarget;
use crate::image::Frame;
use crate::judged::Raising;
use crate::method::{Inputs, MethodError};
use crate::reader::Seen;
use crate::region::{Region, RegionError};
use crate::tracker::TrackerError;
use chosen::Chosen;
use serde::{Deserialize, Serialize, Serializer};

/// Most reasons in an answer.
const MAX_REASONS: usize = 3;
/// Probability from which on reasons are given.
const TOLD: f64 = 0.1;

/// Options of a monitor.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// Name of the method; `None` for the recommended one.
    pub method: Option<String>,
    /// Largest number of false alarms per 1000 frames, for methods that have a budget.
    pub budget: Option<f64>,
    /// Inputs that will be available, for the recommendation; `None` for those of the first frame with a
    /// region.
    pub inputs: Option<Inputs>,
    /// Number of the top left pixel in the boxes from which the regions are made; `None` for 0, or for that
    /// of a saved state. It has no effect except that a state cannot be resumed with another number.
    pub base: Option<u8>,
}

/// Data of one frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct Update<'a> {
    /// Pixels of the frame. All frames have the same size.
    pub frame: Option<&'a Frame>,
    /// Region of the tracker; `None` or NaN coordinates if it has none.
    pub region: Option<&'a Region>,
    /// Confidence of the tracker in its own scale, high if it is sure.
    pub confidence: Option<f64>,
    /// Regions of other trackers, in the same order in all frames. NaN coordinates mean that a tracker has no
    /// region.
    pub companions: &'a [Region],
    /// True if the tracker was restarted on its target, with the region of this frame. Earlier frames then no
    /// longer count.
    pub restart: bool,
}

/// Result for one frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// Index of the frame in the stream, from 0.
    pub index: u64,
    /// Probability that the target is lost, in `[0, 1]`, serialized with four digits. `None` before the first
    /// region, and for methods that estimate none.
    #[serde(serialize_with = "four_digits")]
    pub probability: Option<f64>,
    /// State of the target.
    pub state: TargetState,
    /// At most three features that speak for a loss, the strongest first; empty for a probability below a
    /// tenth.
    pub reasons: Vec<String>,
    /// Reason why an input was left out, or why the frame could not be judged; the state is then that of the
    /// frame before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

fn four_digits<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    value.map(|value| (value * 1e4).round() / 1e4).serialize(serializer)
}

/// Reason why a frame cannot be judged, or a monitor cannot start or resume.
#[derive(Debug, thiserror::Error)]
pub enum MonitorError {
    /// There is no such method, or it has no budget.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The method cannot judge frame by frame, or needs inputs that a stream lacks.
    #[error("method `{method}` {reason}; methods that can monitor: {}", able().join(", "))]
    Unfit {
        /// Name of the method.
        method: String,
        /// Reason, as words that follow the name.
        reason: &'static str,
    },
    /// A signal cannot start.
    #[error(transparent)]
    Signal(#[from] TrackerError),
    /// The size of the frame differs from that of earlier frames.
    #[error("the frame has {}x{} pixels, those before had {}x{}", got.0, got.1, expected.0, expected.1)]
    FrameSize {
        /// Width and height of earlier frames.
        expected: (usize, usize),
        /// Width and height of this frame.
        got: (usize, usize),
    },
    /// The numbers of the box do not make a region.
    #[error("box: {0}")]
    Region(#[from] RegionError),
    /// The method has a signal whose state cannot be saved.
    #[error("the state of signal `{0}` cannot be kept")]
    NotSaved(&'static str),
    /// The bytes are not a saved state.
    #[error("not a state of `trackfail monitor`")]
    NoState,
    /// The bytes are the state of a stream with several targets, or with one that was begun anew.
    #[error(
        "a state of several targets, or of one that was begun anew, which only `trackfail monitor` goes on from"
    )]
    SeveralTargets,
    /// The state was saved by another version of the program.
    #[error("a state of format {0}, which this program does not read")]
    OtherFormat(String),
    /// The state is damaged or truncated.
    #[error("the state is damaged")]
    Damaged,
    /// The state was saved with other options.
    #[error("the state is one {saved}, not {given}")]
    OtherOptions {
        /// Option that the state was saved with, in words.
        saved: String,
        /// Option that is asked for, in words.
        given: String,
    },
    /// The method has changed since the state was saved.
    #[error("the state is one of another version of method `{0}`")]
    OtherVersion(String),
}

/// A monitor of one track.
pub struct Monitor {
    state: State,
    chosen: Option<Chosen>,
}

/// State of a monitor beside its method, in the order of the saved format.
#[derive(Clone, Default, Serialize, Deserialize)]
struct State {
    /// Index of the next frame.
    index: u64,
    /// Width and height of the frames; `None` before the first frame.
    size: Option<(usize, usize)>,
    /// Last region; it is known here between saving and restoring, else to the reader of the signals.
    last: Option<Region>,
    raising: Raising,
    target: StateOfTarget,
    base: u8,
    budget: Option<f64>,
    inputs: Option<Inputs>,
    /// True if neither a method nor inputs were given, so that the method may still change.
    is_free: bool,
}

impl Monitor {
    /// Creates a monitor before its first frame.
    ///
    /// # Errors
    /// An unknown method, one that cannot judge frame by frame, and a budget for a method without one.
    pub fn new(options: &Options) -> Result<Self, MonitorError> {
        let Options { budget, inputs, base, .. } = *options;
        let chosen = match (&options.method, inputs) {
            (Some(name), _) => Some(Chosen::start(name, budget)?),
            (None, Some(inputs)) => Some(Chosen::recommended(inputs, budget)?),
            (None, None) => {
                // A budget that one of them refuses is refused by all, and later it is too late.
                if budget.is_some() {
                    Chosen::recommended(Inputs::default(), budget)?;
                }
                None
            }
        };
        let (base, is_free) = (base.unwrap_or(0), chosen.is_none());
        Ok(Self { state: State { base, budget, inputs, is_free, ..State::default() }, chosen })
    }

    /// Judges the next frame.
    ///
    /// # Errors
    /// A frame of another size, or a region without area or beyond any image. The frame is counted, but has
    /// no other effect.
    pub fn update(&mut self, update: &Update<'_>) -> Result<Answer, MonitorError> {
        let index = self.state.index;
        self.skip();
        let region = match update.region.map(checked) {
            Some(Err(RegionError::NotFinite)) | None => None,
            Some(region) => Some(region?),
        };
        if let Some(frame) = update.frame {
            self.check_size((frame.width(), frame.height()))?;
        }
        if update.restart {
            let name = self.chosen.take().map(|chosen| chosen.name);
            self.chosen = name.map(|name| Chosen::start(&name, self.state.budget)).transpose()?;
            (self.state.raising, self.state.target) = Default::default();
        }
        let choice = if region.is_some() { self.choose(update)? } else { None };
        let companions: Vec<&Region> = update.companions.iter().collect();
        let seen = Seen {
            frame: update.frame,
            region: region.as_ref(),
            confidence: update.confidence,
            companions: &companions,
        };
        let has_box = region.is_some();
        let judged = self.chosen.as_mut().and_then(|chosen| {
            let (now, note) = chosen.push(&seen)?;
            let raised = self.state.raising.push(&chosen.facts, has_box, now.alarm, now.compared);
            Some((raised, now, note))
        });
        let Some((raised, judgement, note)) = judged else {
            let state = TargetState::Absent;
            return Ok(Answer { index, probability: None, state, reasons: Vec::new(), note: None });
        };
        let state = self.state.target.push(has_box, judgement.lost, raised, judgement.probability);
        let probability = Some(judgement.probability).filter(|p| !p.is_nan());
        let told = if probability.is_some_and(|p| p < TOLD) { 0 } else { MAX_REASONS };
        let reasons = judgement.reasons.into_iter().take(told).collect();
        Ok(Answer { index, probability, state, reasons, note: note.or(choice) })
    }

    /// Chooses a method if none was given, for the inputs of the first frame with a region, and another one
    /// when frames arrive. The text is a note if the choice may surprise the user.
    fn choose(&mut self, update: &Update<'_>) -> Result<Option<String>, MonitorError> {
        let is_free = self.state.is_free;
        let stays = |chosen: &Chosen| !is_free || update.frame.is_none() || chosen.reader.reads_frames();
        if self.chosen.as_ref().is_some_and(stays) {
            return Ok(None);
        }
        let (frames, companions) = (update.frame.is_some(), !update.companions.is_empty());
        let inputs = Inputs { frames, companions, confidence: update.confidence.is_some() };
        let chosen = Chosen::recommended(inputs, self.state.budget)?;
        let name = chosen.name.clone();
        Ok(match (self.chosen.replace(chosen), update.frame) {
            (Some(_), _) => Some(format!("frames have come: {name} from here on")),
            (None, None) => Some(format!("without frames: {name}, until frames come")),
            (None, Some(_)) => None,
        })
    }

    /// Counts a frame whose data cannot be used.
    pub fn skip(&mut self) {
        self.state.index = self.state.index.saturating_add(1);
    }

    /// Index of the next frame, from 0.
    pub fn index(&self) -> u64 {
        self.state.index
    }

    /// Number of the top left pixel in the boxes from which the regions are made.
    pub fn base(&self) -> u8 {
        self.state.base
    }

    /// Options of a monitor that goes on as this one began.
    pub(super) fn options(&self) -> Options {
        let State { is_free, budget, inputs, base, .. } = self.state;
        let method = if is_free { None } else { self.method().map(str::to_owned) };
        Options { method, budget, inputs, base: Some(base) }
    }

    /// Name of the method; `None` until it is chosen.
    pub fn method(&self) -> Option<&str> {
        self.chosen.as_ref().map(|chosen| chosen.name.as_str())
    }

    /// True if frames are used: by the method, or because they may change the choice of the method.
    pub fn reads_frames(&self) -> bool {
        self.state.is_free || self.chosen.as_ref().is_none_or(|chosen| chosen.reader.reads_frames())
    }

    /// Checks width and height of a frame, in pixels; [`Monitor::update`] does so for frames that it is given.
    ///
    /// # Errors
    /// Another size than that of the first frame.
    pub fn check_size(&mut self, got: (usize, usize)) -> Result<(), MonitorError> {
        let expected = *self.state.size.get_or_insert(got);
        if got == expected { Ok(()) } else { Err(MonitorError::FrameSize { expected, got }) }
    }
}

/// Checks that the region is valid.
fn checked(region: &Region) -> Result<Region, RegionError> {
    match region {
        // Two corners would be read as a box.
        Region::Polygon(corners) if corners.len() < 3 => Err(RegionError::Count(2 * corners.len())),
        region => Region::from_numbers(&region.numbers()),
    }
}

#[cfg(test)]
mod tests;
