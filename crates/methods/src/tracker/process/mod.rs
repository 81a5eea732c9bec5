//! A program of one's own, in any language, as a tracker.
//!
//! The program is named in a local file, `plugins.toml`, never in an experiment, which says only
//! `name = "process"` and `program = "my-tracker"`: who runs somebody's experiment runs nothing that is not
//! in a file of their own.
//!
//! ```toml
//! [tracker.my-tracker]
//! command = ["python3", "my_tracker.py"]   # no shell; started in the folder of this file
//! version = "1"                            # raise it when the answers change: it is part of every address
//! protocol = "lines"                       # or "trax", the default
//! regions = "rectangle"                    # lines only: what it reads, "rectangle" (default) or "polygon"
//! start_timeout = 30.0                     # seconds until it is ready (default 30)
//! answer_timeout = 30.0                    # seconds a frame (default 30)
//! deterministic = true                     # its answers depend neither on seed nor on run (default false)
//! environment = { OMP_NUM_THREADS = "1" }  # added to ours
//! digest = ["my_tracker.py"]               # files whose bytes are part of the address
//! ```
//!
//! The address of a track has name, version, protocol, `regions`, the digests, and the seed unless the
//! program is deterministic; command, environment and time limits are not in it.
//!
//! # Lines
//!
//! One line of UTF-8 text a message, its words separated by one tab; the program answers each by one line
//! on stdout and flushes it.
//!
//! | we write | it answers |
//! |---|---|
//! | `init<TAB>IMAGE<TAB>REGION` | `REGION` or `REGION CONFIDENCE` |
//! | `frame<TAB>IMAGE` | the same |
//! | `quit` | nothing; it ends |
//!
//! `REGION` is `x,y,w,h` (left, top, width, height) or the corners of a convex polygon, `x1,y1,x2,y2,...`,
//! in pixels; coordinates are continuous and 0-based: pixel column `j` covers `[j, j + 1)`. A confidence is
//! any finite number; it is checked and not used. `IMAGE` is the absolute path of a JPEG or PNG file, without
//! tabs and line ends. `init` may come again, then the program starts anew there; frames in between may be
//! left out. Everything on stdout is an answer: what people should read belongs on stderr.
//!
//! The environment has `TRACKFAIL_SEED`, a number below 2^64 from the names of experiment, sequence,
//! tracker and run, and `TRACKFAIL_RUN`, the repetition from 0.
//!
//! # TraX
//!
//! Versions 1 to 4, see [`trax`](super::trax); also with the two variables, and `TRAX=1`. The program must
//! read images by path. It is given a polygon where the target is one and it reads polygons, or where it
//! reads nothing else; otherwise a rectangle. Coordinates are passed on as they are. An answer that is a mere
//! code has no place: the last region stands. Properties such as a confidence are not used.
//!
//! # Common to both
//!
//! The answer to the first frame must be a region and is then replaced by the one given, as the OTB and VOT
//! protocols do. Images are the dataset's files. Frames that have none, and files whose path cannot be said,
//! are written as PNG files into a temporary folder, in which the last two are kept.
//!
//! A program that cannot be started, ends, does not answer in time or answers something else fails its cell:
//! the reason names the frame and what was expected and quotes the last lines of its stderr. The first answer
//! in the lines protocol, which knows no greeting, may take both time limits together. At the end the
//! program is asked to quit, has two seconds for it, and is killed with all that it started. No program
//! outlives this one, however that ends (on Unix; what leaves its process group is not found).

mod child;
mod images;
mod peer;
mod programs;
#[cfg(test)]
mod tests;

pub use programs::{Program, Programs, Protocol, Regions};

use super::{RunContext, Tracker, TrackerConfig, TrackerError, TrackerState};
use crate::dataset::Frames;
use crate::image::Frame;
use crate::plugin::{Entry, ParamError, RawParams, read_params, show_params};
use crate::region::Region;
use images::Images;
use peer::Peer;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// Parameters.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Name of the program in `plugins.toml`.
    pub program: String,
}

/// The line in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> = Entry {
    kind: "process",
    version: 1,
    summary: "a program that plugins.toml names, over TraX or lines of text",
    example: r#"{ program = "my-tracker" }"#,
    build: |raw: RawParams<'_>| Ok(Box::new(Process { params: read_params(raw)?, program: None })),
    schema: || schemars::schema_for!(Params),
};

struct Process {
    params: Params,
    /// `None` until it is bound, as when only a report is made.
    program: Option<Arc<Program>>,
}

impl TrackerConfig for Process {
    fn params(&self) -> serde_json::Value {
        let mut params = show_params(&self.params);
        if let Some(program) = &self.program {
            params["version"] = program.version.as_str().into();
            params["protocol"] = program.protocol.word().into();
            if program.protocol == Protocol::Lines {
                params["regions"] = show_params(&program.regions);
            }
        }
        params
    }

    fn uses_seed(&self) -> bool {
        self.program.as_ref().is_none_or(|p| !p.deterministic)
    }

    fn bind(&mut self, programs: &Programs) -> Result<(), ParamError> {
        let found = programs.find(&self.params.program);
        self.program =
            Some(found.map_err(|message| ParamError { message, key: Some("program"), span: None })?);
        Ok(())
    }

    fn inputs(&self, _: &RunContext<'_>) -> Result<Vec<PathBuf>, TrackerError> {
        Ok(self.program.as_ref().map_or_else(Vec::new, |p| p.digest.clone()))
    }

    fn open(&self, start: &RunContext<'_>) -> Result<Box<dyn Tracker>, TrackerError> {
        let Some(program) = self.program.clone() else {
            let name = &self.params.program;
            return Err(TrackerError::Missing(format!("the program {name} is not known here")));
        };
        let files = match &start.sequence.frames {
            Frames::Files(files) => files.to_vec(),
            Frames::Video(video) => video.files().map_err(|e| TrackerError::Missing(e.to_string()))?.to_vec(),
            Frames::Rendered(..) => Vec::new(),
        };
        let name = start.sequence.name.clone();
        let first = start.sequence.numbering.first;
        let (seed, run) = (start.seed, start.run);
        Ok(Box::new(Tracking { program, seed, run, name, first, files, at: None, next: 0, running: None }))
    }
}

struct Tracking {
    program: Arc<Program>,
    seed: u64,
    run: u32,
    /// The sequence's name and the number of its first frame, for messages.
    name: String,
    first: u32,
    files: Vec<PathBuf>,
    /// The frame that the next call is about, where we were told.
    at: Option<usize>,
    /// The frame that it is about where we were not.
    next: usize,
    running: Option<Running>,
}

/// A program at work. It ends before its images go.
struct Running {
    peer: Box<dyn Peer>,
    images: Images,
}

impl Tracking {
    /// What the program says of a frame, which is the first one if it comes with a region. After a fault the
    /// program is gone.
    fn ask(&mut self, frame: &Frame, region: Option<&Region>) -> Result<Region, TrackerError> {
        let told = self.at.take();
        let index = told.unwrap_or(self.next);
        self.next = index + 1;
        let answer = self.answer(told, frame, region);
        answer.map_err(|fault| {
            self.running = None;
            let (program, number) = (&self.program.name, u64::from(self.first) + index as u64);
            TrackerError::Broken(format!("{program}: frame {number} of {}: {fault}", self.name))
        })
    }

    fn answer(
        &mut self,
        told: Option<usize>,
        frame: &Frame,
        region: Option<&Region>,
    ) -> Result<Region, String> {
        let running = match (&mut self.running, region) {
            (Some(running), _) => running,
            (None, None) => return Err("a frame before the initialisation".into()),
            (empty @ None, Some(_)) => {
                let images = Images::new()?;
                let peer = peer::start(&self.program, self.seed, self.run, images.folder())?;
                empty.insert(Running { peer, images })
            }
        };
        let file = told.and_then(|t| self.files.get(t));
        let image = running.images.path(file.map(PathBuf::as_path), frame)?;
        match region {
            Some(region) => running.peer.init(&image, region),
            None => running.peer.frame(&image),
        }
    }
}

impl Tracker for Tracking {
    fn at(&mut self, frame: usize) {
        self.at = Some(frame);
    }

    fn init(&mut self, frame: &Frame, region: &Region) -> Result<TrackerState, TrackerError> {
        self.ask(frame, Some(region)).map(|_| TrackerState::initialised(region.clone()))
    }

    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        self.ask(frame, None).map(TrackerState::tracked)
    }

    fn reset(&mut self) {
        (self.at, self.next, self.running) = (None, 0, None);
    }
}
