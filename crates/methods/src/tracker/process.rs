//! An external program, in any language, as a tracker. Programs may also be [signals](crate::signal::process) and
//! [detectors](crate::detector::process).
//!
//! The command is in a local file, `plugins.toml`. An experiment has only `name = "process"` and `program =
//! "my-tracker"`, so that somebody else's experiment can only run programs that are in your own file.
//!
//! ```toml
//! [tracker.my-tracker]
//! command = ["python3", "my_tracker.py"]   # no shell; started in the folder of this file
//! version = "1"                            # raise it when the answers change: it is part of every address
//! protocol = "lines"                       # or "trax", the default
//! regions = "rectangle"                    # lines only: what it reads, "rectangle" (default) or "polygon"
//! confidence = "confidence"                # it gives a confidence: the property of TraX that has it (default: none)
//! start_timeout = 30.0                     # seconds until it is ready (default 30)
//! answer_timeout = 30.0                    # seconds per frame (default 30)
//! deterministic = true                     # its answers depend neither on seed nor on run (default false)
//! environment = { OMP_NUM_THREADS = "1" }  # added to ours
//! digest = ["my_tracker.py"]               # files whose bytes are part of the address
//! ```
//!
//! The address of a track is made of name, version, protocol, `regions`, `confidence`, the digests, and the
//! seed unless the program is deterministic. Command, environment and time limits are not part of it.
//!
//! # Lines
//!
//! A message is one line of UTF-8 text with one tab between words. The program answers each message by one
//! line on stdout and flushes it.
//!
//! | we write | it answers |
//! |---|---|
//! | `init<TAB>IMAGE<TAB>REGION` | `REGION`, `REGION CONFIDENCE`, `REGION #N` or `REGION CONFIDENCE #N` |
//! | `frame<TAB>IMAGE` | the same |
//! | `quit` | nothing; it ends |
//!
//! `REGION` is `x,y,w,h` (left, top, width, height) or the corners of a convex polygon, `x1,y1,x2,y2,...`, in
//! pixels; coordinates are continuous and 0-based: pixel column `j` covers `[j, j + 1)`. A confidence is any
//! finite number; a high one means that the tracker is sure. It is always checked, but used only if
//! `confidence` is set (the name does not matter here). `IMAGE` is the absolute path of a JPEG or PNG file,
//! without tabs and line ends. `init` is the first message and comes once: for a restart the program is
//! started again. Everything on stdout is an answer; text for people belongs on stderr.
//!
//! An extra line would shift all answers by one frame. So it is a fault if a line is already there when the
//! next message is sent, or if one comes after the answer to the last frame. `#N` reveals a shift at once: N
//! is the number of the answered message, 0 for `init`, then 1, 2, ... A program that counts its messages
//! should give it. A wrong number is a fault.
//!
//! The environment has `TRACKFAIL_SEED`, a number below 2^64 from the names of experiment, sequence,
//! tracker and run, and `TRACKFAIL_RUN`, the repetition from 0.
//!
//! # TraX
//!
//! Versions 1 to 4, see [`trax`](super::trax); the environment has the same two variables and `TRAX=1`. The
//! program must read images by path. It gets a polygon if the target is a polygon and the program reads
//! polygons, or if it reads nothing else; otherwise a rectangle. Coordinates are passed on unchanged. An
//! answer that is only a code repeats the last region. The property that `confidence` names is the
//! confidence, in the frames whose answer has it; other properties are not used.
//!
//! # Common to both
//!
//! The answer to the first frame must be a region (in TraX a code will do). It is then replaced by the given region, as in the OTB and
//! VOT protocols. Images are the dataset's files. Frames without a file, and files whose path has control
//! characters or is not UTF-8, are written as PNG files into a temporary folder, which keeps the last two
//! images.
//!
//! If a program cannot be started, ends, does not answer in time or sends something else, its cell fails: the
//! reason names the frame and the expected answer and quotes the last lines of its stderr. The cell also
//! fails if the program ends with an exit status other than 0 after its last answer, since its answers may be
//! wrong, too. The first answer in the lines protocol, which has no greeting, may take both time limits
//! together. At the end the program is asked to quit, has two seconds for it, and is killed with all
//! processes that it started. No program outlives this process, however this process ends: on Linux in all
//! cases, since a [guard](trackfail_dataset::guarded) is the parent of all processes that it leaves behind,
//! on other Unix systems unless it leaves its process group. What a program has started ends with it, too.

mod child;
mod images;
mod json_lines;
mod peer;
mod programs;
#[cfg(all(test, unix))]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

pub use programs::{Bind, Program, Programs, Protocol, Regions, Role};

pub(crate) use images::Images;
pub(crate) use json_lines::{Handed, JsonPeer, Track};
pub(crate) use programs::{Named, Process, bind, refused};

use super::{Facts, RunContext, StartResult, Tracker, TrackerConfig, TrackerError, TrackerState};
use peer::Peer;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::PathBuf;
use trackfail_core::image::Frame;
use trackfail_core::plugin::{Configured, Entry, ParamError, show_params};
use trackfail_core::region::Region;
use trackfail_core::sequence::SequenceInfo;

/// Parameters of a tracker in an external program.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Name of the program in `plugins.toml`.
    pub program: String,
}

/// `process` in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> = Entry::of::<Process<Params>>(
    "process",
    1,
    "a program that plugins.toml names, over TraX or lines of text",
)
.example(r#"{ program = "my-tracker" }"#);

impl Named for Params {
    const ROLE: Role = Role::Tracker;

    fn program(&self) -> &str {
        &self.program
    }

    fn facts(program: &Program) -> Result<Vec<(&'static str, Value)>, ParamError> {
        let regions = (program.protocol == Protocol::Lines).then(|| show_params(&program.regions));
        let confidence = program.confidence.as_deref().map(Value::from);
        let more = [("regions", regions), ("confidence", confidence)];
        let more = more.into_iter().filter_map(|(key, value)| Some((key, value?)));
        let protocol = ("protocol", Value::from(program.protocol.word()));
        Ok(std::iter::once(protocol).chain(more).collect())
    }
}

impl TrackerConfig for Process<Params> {
    fn facts(&self) -> Facts {
        Facts { uses_seed: self.depends_on_seed(), ..Facts::BOXES }
    }

    fn gives_confidence(&self, _: &RunContext<'_>) -> bool {
        self.program().is_ok_and(|p| p.confidence.is_some())
    }

    fn inputs(&self, _: &RunContext<'_>) -> Result<Vec<PathBuf>, TrackerError> {
        Ok(self.files())
    }

    fn start(&self, context: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        let program = self.program()?;
        let files = context.sequence.files().map_err(TrackerError::File)?;
        let place = Place::new(program, context.sequence);
        let index = context.start_frame;
        let start = || {
            let mut images = Images::new()?;
            let mut peer = peer::start(program, context.seed, context.run, images.folder())?;
            let image = images.path(files.get(index).map(PathBuf::as_path), frame)?;
            let answer = peer.init(&image, region)?;
            Ok((peer, images, answer))
        };
        let (mut peer, images, answer) = start().map_err(|fault| place.error(index, fault))?;
        let last = context.sequence.frames().saturating_sub(1);
        if index == last {
            peer.finish().map_err(|fault| place.error(index, fault))?;
        }
        let tracker = Tracking { place, files, next: index + 1, last, peer, images };
        let confidence = answer.confidence;
        Ok((Box::new(tracker), TrackerState { confidence, ..TrackerState::initialized(region.clone()) }))
    }
}

impl Bind for dyn TrackerConfig {
    fn bind(tracker: &mut Configured<Self>, programs: &Programs) -> Result<(), ParamError> {
        bind::<_, Params>(tracker, |tracker| tracker, programs)
    }
}

/// Program, sequence, and number of the first frame, for messages.
pub(crate) struct Place {
    program: String,
    sequence: String,
    first: u32,
}

impl Place {
    /// The place of a program that runs on a sequence.
    pub(crate) fn new(program: &Program, sequence: &dyn SequenceInfo) -> Self {
        let (name, first) = (sequence.name().to_string(), sequence.numbering().first);
        Self { program: program.name.clone(), sequence: name, first }
    }

    /// Error for a fault in the frame with this index.
    pub(crate) fn error(&self, index: usize, fault: String) -> TrackerError {
        let (program, sequence) = (self.program.clone(), self.sequence.clone());
        let frame = u64::from(self.first) + index as u64;
        TrackerError::Program { program, frame, sequence, source: fault.into() }
    }
}

/// A running program on a sequence.
struct Tracking {
    place: Place,
    files: Vec<PathBuf>,
    /// Index of the next frame.
    next: usize,
    /// Index of the last frame.
    last: usize,
    /// Declared before the images, since fields are dropped in order and the program must end before its
    /// images are deleted.
    peer: Box<dyn Peer>,
    images: Images,
}

impl Tracker for Tracking {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        let index = self.next;
        self.next += 1;
        let file = self.files.get(index).map(PathBuf::as_path);
        let state = self.images.path(file, frame).and_then(|image| {
            let state = self.peer.frame(&image)?;
            if index == self.last {
                self.peer.finish()?;
            }
            Ok(state)
        });
        state.map_err(|fault| self.place.error(index, fault))
    }
}
