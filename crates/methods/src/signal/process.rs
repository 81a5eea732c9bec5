//! `process`: a signal that an external program computes, in any language.
//!
//! The command is in `plugins.toml`, never in an experiment. [Trackers](crate::tracker::process) describes
//! that file, and what happens if a program crashes, hangs or sends something else.
//!
//! ```toml
//! [signal.my-signal]
//! command = ["python3", "my_signal.py"]    # no shell; started in the folder of this file, once for each track
//! version = "1"                            # raise it when the answers change: it is part of every address
//! start_timeout = 30.0                     # seconds until it is ready (default 30)
//! answer_timeout = 30.0                    # seconds per frame (default 30)
//! environment = { OMP_NUM_THREADS = "1" }  # added to ours
//! digest = ["my_signal.py"]                # files whose bytes are part of the address
//! ```
//!
//! A message is one line of JSON. The program does not answer the first one. Each further message is about
//! one frame, in order, and the program answers it by one line on stdout, which it flushes. When its stdin
//! ends, the program ends with exit status 0. Text for people belongs on stderr.
//!
//! ```text
//! {"meta": {"protocol": 1, "program": "my-signal", "role": "signal", "frames": 87, "size": [320, 240], "params": {}}}
//! {"index": 0, "frame": "/data/0001.jpg", "box": [x, y, w, h], "absent": false, "confidence": null}
//! <- {"score": 0.3}
//! ```
//!
//! | key | meaning |
//! |---|---|
//! | `frames`, `index` | number of frames of the track; index of this one, from 0 |
//! | `size` | width and height of the frames in pixels; only if it `reads = "pixels"` |
//! | `params` | the table `params` of the experiment, as it stands there |
//! | `frame` | absolute path of a JPEG or PNG file; `null` unless it `reads = "pixels"` |
//! | `box` | the tracker's box: left, top, width, height in pixels from 0; of a polygon, the upright box that stands for it |
//! | `polygon` | its corners, `[x1, y1, x2, y2, ...]`; only where the tracker gives a polygon |
//! | `absent` | whether the tracker says that the target is absent |
//! | `confidence` | the tracker's own, or `null` |
//! | `posterior`, `response` | the tracker's posterior or response map in numbers, if it reads that |
//!
//! An answer should have the `index` of its frame, as in `{"score": 0.3, "index": 0}`: a wrong index is a
//! fault, so that an extra line cannot shift the scores. With or without an index, these are faults: a line
//! that is already there when the next message is sent, a line after the last answer, and an exit status
//! other than 0.
//!
//! Ground truth is never sent, nor anything that could tell it: names, failures, restarts. A score is any
//! finite number. The same frames and boxes must give the same scores: there is no seed. The experiment says
//! in `good` whether high or low scores are good, and in `reads` what the program needs; nothing else is
//! decoded or asked from trackers.
//!
//! A frame without a file is written as PNG into a temporary folder, which keeps the last two images.
//!
//! The address has all parameters, the version and the digests; command, environment and time limits are not part of it.

use crate::signal::{Direction, Facts, Observation, Reads, Session, Signal};
use crate::tracker::process::{
    Bind, Handed, Images, JsonPeer, Named, Place, Process, Programs, Role, Track, bind,
};
use crate::tracker::{Moments, Response, RunContext, Status, TrackerError, TrackerState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use trackfail_core::image::Frame;
use trackfail_core::plugin::{Configured, Entry, ParamError};
use trackfail_core::region::Region;

/// `process` in the list of signals.
pub const ENTRY: Entry<dyn Signal> =
    Entry::of::<Process<Params>>("process", 1, "a program that plugins.toml names, over lines of JSON")
        .example(r#"{ program = "my-signal", good = "high", reads = "boxes", params = {} }"#);

/// Direction of good scores.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Good {
    /// High scores.
    #[default]
    High,
    /// Low scores.
    Low,
}

/// Input of a program besides the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Need {
    /// Nothing else.
    #[default]
    Boxes,
    /// The frames.
    Pixels,
    /// The tracker's confidence.
    Confidence,
    /// The tracker's response map in numbers.
    Response,
    /// Moments of the tracker's posterior.
    Posterior,
}

/// Parameters of a signal in an external program.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Name of the program in `plugins.toml`.
    pub program: String,
    /// Direction of good scores: `high` or `low`.
    #[serde(default)]
    pub good: Good,
    /// Input of the program besides the box.
    #[serde(default)]
    pub reads: Need,
    /// Parameters that are handed over to the program.
    #[serde(default)]
    pub params: Handed,
}

impl Named for Params {
    const ROLE: Role = Role::Signal;

    fn program(&self) -> &str {
        &self.program
    }
}

impl Signal for Process<Params> {
    fn facts(&self) -> Facts {
        let direction = match self.params.good {
            Good::High => Direction::HigherIsBetter,
            Good::Low => Direction::LowerIsBetter,
        };
        let reads = match self.params.reads {
            Need::Boxes => Reads::Boxes,
            Need::Pixels => Reads::Pixels,
            Need::Confidence => Reads::Confidence,
            Need::Response => Reads::Response,
            Need::Posterior => Reads::Posterior,
        };
        Facts { reads, ..Facts::of(direction, (f64::NEG_INFINITY, f64::INFINITY)) }
    }

    fn inputs(&self, _: &RunContext<'_>) -> Result<Vec<PathBuf>, TrackerError> {
        Ok(self.files())
    }

    fn start(&self, context: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError> {
        let program = self.program()?;
        let (sequence, reads) = (context.sequence, self.params.reads);
        let place = Place::new(program, sequence);
        let (mut files, mut size) = (Vec::new(), None);
        if reads == Need::Pixels {
            files = sequence.files().map_err(TrackerError::File)?;
            size = Some(sequence.size().map_err(TrackerError::File)?);
        }
        let frames = sequence.frames();
        let track = Track { frames, size, params: &self.params.params };
        let start = || {
            let images = Images::new()?;
            let peer = JsonPeer::start(program, &[], Some(images.folder()), &track)?;
            Ok((peer, images))
        };
        let (peer, images) = start().map_err(|fault| place.error(0, fault))?;
        Ok(Box::new(Asking { place, reads, files, frames, next: 0, peer: Some(peer), images }))
    }
}

impl Bind for dyn Signal {
    fn bind(signal: &mut Configured<Self>, programs: &Programs) -> Result<(), ParamError> {
        bind::<_, Params>(signal, |signal| signal, programs)
    }
}

/// Message about a frame.
#[derive(Serialize)]
struct FrameLine<'a> {
    index: usize,
    frame: Option<String>,
    r#box: [f64; 4],
    #[serde(skip_serializing_if = "Option::is_none")]
    polygon: Option<Vec<f64>>,
    absent: bool,
    confidence: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    posterior: Option<&'a Moments>,
    #[serde(skip_serializing_if = "Option::is_none")]
    response: Option<&'a Response>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Answer {
    score: f64,
    index: Option<usize>,
}

/// Form of the expected answer, for messages.
const ANSWER: &str = "`{\"score\": 0.5}` with a finite number";

/// A running program on one track.
struct Asking {
    place: Place,
    reads: Need,
    files: Vec<PathBuf>,
    frames: usize,
    /// Index of the next frame.
    next: usize,
    /// `None` after the last frame and after a fault. Declared before the images, since fields are dropped in
    /// order and the program must end before its images are deleted.
    peer: Option<JsonPeer>,
    images: Images,
}

impl Asking {
    fn line<'a>(
        &mut self,
        t: usize,
        frame: &Frame,
        state: &'a TrackerState,
    ) -> Result<FrameLine<'a>, String> {
        let image = match self.reads {
            Need::Pixels => Some(self.images.path(self.files.get(t).map(PathBuf::as_path), frame)?),
            _ => None,
        };
        let rect = state.region.rect();
        Ok(FrameLine {
            index: t,
            frame: image.map(|path| path.to_string_lossy().into_owned()),
            r#box: [rect.x, rect.y, rect.w, rect.h],
            polygon: match &state.region {
                Region::Rect(_) => None,
                Region::Polygon(corners) => Some(corners.iter().flat_map(|c| [c.0, c.1]).collect()),
            },
            absent: state.status == Status::Absent,
            confidence: state.confidence,
            posterior: state.posterior.as_ref().filter(|_| self.reads == Need::Posterior),
            response: state.response.as_ref().filter(|_| self.reads == Need::Response),
        })
    }

    fn ask(&mut self, t: usize, frame: &Frame, state: &TrackerState) -> Result<f64, String> {
        let mut peer = self.peer.take().ok_or_else(|| "it has ended".to_string())?;
        let line = self.line(t, frame, state)?;
        let answer: Answer = peer.ask(t, &line, ANSWER, |answer: &Answer| answer.index)?;
        if t + 1 == self.frames {
            peer.finish()?;
        } else {
            self.peer = Some(peer);
        }
        Ok(answer.score)
    }
}

impl Session for Asking {
    fn push(&mut self, observation: &Observation<'_>) -> Result<Vec<f64>, TrackerError> {
        let t = self.next;
        self.next += 1;
        let answer = self.ask(t, observation.frame, observation.state);
        answer.map(|score| vec![score]).map_err(|fault| self.place.error(t, fault))
    }
}

#[cfg(test)]
mod tests;
