//! Live monitoring: whether a tracker has lost its target, frame by frame, while it tracks.
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
//! A [`Monitor`] is given what is known of each frame once, in order: the frame, the tracker's region, its confidence,
//! and the regions of companions, other trackers on the same frames. Regions are 0-based pixels with the top left
//! corner of the first pixel at (0, 0). Everything but the first region may be missing, in all frames or in some: a
//! value that cannot be computed is missing for the detector too, which is no error and no alarm. A frame without a
//! region is one in which the tracker says that the target is absent; the signals are then read at its last region, and an
//! alarm that they raise ends with the absence.
//!
//! Without a name of a method, the first frame with a region decides: its inputs are those that the recommendation is
//! made for; with a budget it is that among the methods that take one. A method without frames gives way to another one when
//! frames come. A tracker that was started again on its target is followed anew from there, see [`Update::restart`]. The memory of a monitor does not grow with the
//! number of frames.

mod chosen;
mod saved;
mod targets;

pub use crate::detector::labels::TargetState;
pub use targets::{Id, MAX_TARGETS, Targets};

use crate::detector::StateOfTarget;
use crate::image::Frame;
use crate::method::{Inputs, MethodError};
use crate::reader::Seen;
use crate::region::{Region, RegionError};
use crate::tracker::TrackerError;
use chosen::Chosen;
use serde::{Serialize, Serializer};

/// Reasons of an answer, at most.
const MAX_REASONS: usize = 3;
/// Probability from which on there are reasons.
const TOLD: f64 = 0.1;

/// Options of a monitor.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Name of the method; otherwise the one that is recommended for the inputs.
    pub method: Option<String>,
    /// Largest number of false alarms per 1000 frames, for methods that take one.
    pub budget: Option<f64>,
    /// Inputs that will come, for the recommendation; otherwise those of the first frame with a region.
    pub inputs: Option<Inputs>,
    /// Number of the top left pixel in the boxes that the regions are made of; otherwise 0, or that of the state. It is kept, so
    /// that a state goes on under no other one, and changes nothing else.
    pub base: Option<u8>,
}

/// Everything that is known of a frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct Update<'a> {
    /// The frame; all have the same size.
    pub frame: Option<&'a Frame>,
    /// The tracker's region; `None`, or one whose coordinates are no numbers, where the tracker has none.
    pub region: Option<&'a Region>,
    /// The tracker's own confidence, in its scale; high values are sure.
    pub confidence: Option<f64>,
    /// Regions of other trackers, in the same order in all frames; one whose coordinates are no numbers is nowhere.
    pub companions: &'a [Region],
    /// Whether the tracker was started again on its target, with the region of this frame: nothing from before it counts.
    pub restart: bool,
}

/// Judgement of a frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// Number of the frame in the stream, from 0.
    pub index: u64,
    /// Probability that the target is lost, in `[0, 1]`; `None` before the first region, and from methods that estimate
    /// none. Written with four digits.
    #[serde(serialize_with = "four_digits")]
    pub probability: Option<f64>,
    /// State of the target.
    pub state: TargetState,
    /// At most three features that speak for a loss, the loudest first; none at a probability below a tenth.
    pub reasons: Vec<String>,
    /// Why an input was left out, or that there is none to judge by; the state then is that of the frame before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

fn four_digits<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    value.map(|value| (value * 1e4).round() / 1e4).serialize(serializer)
}

/// Why a frame is not judged, or a monitor cannot start or go on.
#[derive(Debug, thiserror::Error)]
pub enum MonitorError {
    /// There is no such method, or it takes no such budget.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The method does not judge frame by frame, or needs more than a stream has.
    #[error("method `{method}` {reason}; methods that can monitor: {}", known.join(", "))]
    Unfit {
        /// Name of the method.
        method: String,
        /// Reason, in words that follow its name.
        reason: &'static str,
        /// Names of the methods that can monitor.
        known: Vec<&'static str>,
    },
    /// A signal cannot start.
    #[error(transparent)]
    Signal(#[from] TrackerError),
    /// The frame is of another size than those before.
    #[error("the frame has {}x{} pixels, those before had {}x{}", got.0, got.1, expected.0, expected.1)]
    FrameSize {
        /// Width and height of the frames before.
        expected: (usize, usize),
        /// Width and height of this one.
        got: (usize, usize),
    },
    /// The numbers of the box are no region.
    #[error("box: {0}")]
    Region(#[from] RegionError),
    /// The method has a signal that cannot be saved.
    #[error("the state of signal `{0}` cannot be kept")]
    NotSaved(&'static str),
    /// The bytes are no state.
    #[error("not a state of `trackfail monitor`")]
    NoState,
    /// The state is of another version of the program.
    #[error("a state of format {0}, which this program does not read")]
    OtherFormat(String),
    /// The state is damaged or cut short.
    #[error("the state is damaged")]
    Damaged,
    /// The state is that of another method.
    #[error("the state is one of method `{saved}`, not of `{given}`")]
    OtherMethod {
        /// Method of the state.
        saved: String,
        /// Method that was asked for.
        given: String,
    },
    /// The state is one with another budget.
    #[error("the state is one with {}, not with {}", budget(*saved), budget(*given))]
    OtherBudget {
        /// Budget of the state.
        saved: Option<f64>,
        /// Budget that was asked for.
        given: Option<f64>,
    },
    /// The state is one for other inputs.
    #[error("the state is one for {}, not for {}", in_words(*saved), in_words(*given))]
    OtherInputs {
        /// Inputs of the state.
        saved: Option<Inputs>,
        /// Inputs that were named.
        given: Option<Inputs>,
    },
    /// The state is one of boxes that count pixels from another number.
    #[error("the state is one of boxes that count pixels from {saved}, not from {given}")]
    OtherBase {
        /// Number of the top left pixel in the state.
        saved: u8,
        /// The one that was asked for.
        given: u8,
    },
    /// The method of the state has changed since.
    #[error("the state is one of another version of method `{0}`")]
    OtherVersion(String),
}

fn budget(budget: Option<f64>) -> String {
    budget.map_or_else(|| "the usual budget".to_string(), |budget| format!("a budget of {budget}"))
}

fn in_words(inputs: Option<Inputs>) -> String {
    let Some(Inputs { frames, companions, confidence }) = inputs else {
        return "no inputs in particular".to_string();
    };
    let named = [(frames, "frames"), (confidence, "confidence"), (companions, "companions")];
    let named = named.into_iter().filter_map(|(is_named, word)| is_named.then_some(word));
    std::iter::once("boxes").chain(named).collect::<Vec<_>>().join(", ")
}

/// A track being monitored.
pub struct Monitor {
    budget: Option<f64>,
    inputs: Option<Inputs>,
    base: u8,
    /// Number of the frame that comes next.
    index: u64,
    /// Width and height of the frames, once there was one.
    size: Option<(usize, usize)>,
    target: StateOfTarget,
    chosen: Option<Chosen>,
    /// Whether nobody has named a method or inputs.
    is_free: bool,
}

impl Monitor {
    /// A monitor before its first frame.
    ///
    /// # Errors
    /// For a method that does not exist, cannot judge frame by frame, or takes no budget if one is given.
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
        Ok(Self {
            is_free: chosen.is_none(),
            budget,
            inputs,
            base: base.unwrap_or(0),
            index: 0,
            size: None,
            target: StateOfTarget::default(),
            chosen,
        })
    }

    /// Judges the next frame.
    ///
    /// # Errors
    /// For a frame of another size, or a region without area or beyond any image. The frame then counts, and nothing else is
    /// changed by it.
    pub fn update(&mut self, update: &Update<'_>) -> Result<Answer, MonitorError> {
        let index = self.index;
        self.index += 1;
        let region = match update.region.map(checked) {
            Some(Err(RegionError::NotFinite)) | None => None,
            Some(region) => Some(region?),
        };
        self.check_size(update.frame)?;
        if update.restart {
            let name = self.chosen.take().map(|chosen| chosen.name);
            self.chosen = name.map(|name| Chosen::start(&name, self.budget)).transpose()?;
            self.target = StateOfTarget::default();
        }
        let choice = if region.is_some() { self.choose(update)? } else { None };
        let companions: Vec<&Region> = update.companions.iter().collect();
        let seen = Seen {
            frame: update.frame,
            region: region.as_ref(),
            confidence: update.confidence,
            companions: &companions,
        };
        let Some((judgement, note)) = self.chosen.as_mut().and_then(|chosen| chosen.push(&seen)) else {
            let state = TargetState::Absent;
            return Ok(Answer { index, probability: None, state, reasons: Vec::new(), note: None });
        };
        let state =
            self.target.push(region.is_some(), judgement.lost, judgement.raised, judgement.probability);
        let probability = Some(judgement.probability).filter(|p| !p.is_nan());
        let told = if probability.is_some_and(|p| p < TOLD) { 0 } else { MAX_REASONS };
        let reasons = judgement.reasons.into_iter().take(told).map(|reason| reason.text).collect();
        Ok(Answer { index, probability, state, reasons, note: note.or(choice) })
    }

    /// Chooses a method where nobody has named one, for the inputs of the first frame with a region, and another one when
    /// frames come; the text says so where the choice may not be meant.
    fn choose(&mut self, update: &Update<'_>) -> Result<Option<String>, MonitorError> {
        let stays = |chosen: &Chosen| !self.is_free || update.frame.is_none() || chosen.reader.reads_frames();
        if self.chosen.as_ref().is_some_and(stays) {
            return Ok(None);
        }
        let chosen = Chosen::recommended(inputs_of(update), self.budget)?;
        let name = chosen.name.clone();
        Ok(match (self.chosen.replace(chosen), update.frame) {
            (Some(_), _) => Some(format!("frames have come: {name} from here on")),
            (None, None) => Some(format!("without frames: {name}, until frames come")),
            (None, Some(_)) => None,
        })
    }

    /// Counts a frame of which nothing can be read.
    pub fn skip(&mut self) {
        self.index += 1;
    }

    /// Number of the frame that comes next, from 0.
    pub fn index(&self) -> u64 {
        self.index
    }

    /// Number of the top left pixel in the boxes that the regions are made of.
    pub fn base(&self) -> u8 {
        self.base
    }

    /// Name of the method, once it is chosen.
    pub fn method(&self) -> Option<&str> {
        self.chosen.as_ref().map(|chosen| chosen.name.as_str())
    }

    /// Whether frames are looked at: by the method, or because they may change the choice of it.
    pub fn reads_frames(&self) -> bool {
        self.is_free || self.chosen.as_ref().is_none_or(|chosen| chosen.reader.reads_frames())
    }

    fn check_size(&mut self, frame: Option<&Frame>) -> Result<(), MonitorError> {
        let Some(got) = frame.map(|frame| (frame.width(), frame.height())) else { return Ok(()) };
        let expected = *self.size.get_or_insert(got);
        if got == expected { Ok(()) } else { Err(MonitorError::FrameSize { expected, got }) }
    }
}

/// The inputs of a frame.
fn inputs_of(update: &Update<'_>) -> Inputs {
    Inputs {
        frames: update.frame.is_some(),
        companions: !update.companions.is_empty(),
        confidence: update.confidence.is_some(),
    }
}

/// The region, if it is one.
fn checked(region: &Region) -> Result<Region, RegionError> {
    match region {
        Region::Rect(r) => Region::from_numbers(&[r.x, r.y, r.w, r.h]),
        Region::Polygon(corners) => {
            let numbers: Vec<f64> = corners.iter().flat_map(|(x, y)| [*x, *y]).collect();
            // Two corners would be read as a box.
            if corners.len() < 3 {
                Err(RegionError::Count(numbers.len()))
            } else {
                Region::from_numbers(&numbers)
            }
        }
    }
}

#[cfg(test)]
mod tests;
