//! `trackfail monitor`: a JSON line in and a JSON line out for each frame.
//!
//! Every line that comes in is a frame of the stream, and has its answer before the next one is read.

mod json;
mod line;
mod pipes;

use super::{Failure, output};
use crate::dataset::text::shorten_to;
use crate::engine::store;
use crate::method::Inputs;
use crate::monitor::{Answer, Id, Monitor, MonitorError, Options, Targets, Update};
use line::{Line, LineError};
use pipes::{End, Pipes};
use serde::Serialize;
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Most characters of an error, which may quote what was read.
const MAX_ERROR: usize = 1000;

/// Arguments of `monitor`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "In, a line for each frame: {\"frame\": \"path.jpg\", \"box\": [x, y, w, h], \"confidence\": 0.9, \
\"companions\": [[x, y, w, h]]}. Every key may be left out or null; without a box, the tracker says that the target is absent. A frame \
may also be {\"raw\": {\"width\": 640, \"height\": 480, \"format\": \"bgr\", \"data\": \"base64\"}}, or have the file of these bytes as \
\"path\" instead of \"data\". Out, a line for each line, at once: {\"index\": 51, \"probability\": 0.97, \"state\": \"lost\", \
\"reasons\": [\"...\"]}, or {\"index\": 52, \"error\": \"...\"} for a line that cannot be used; the stream goes on. States: tracking, \
lost, absent. Lines about several targets have an \"id\", a number or a text, which stands in the answers, too; each target is judged \
apart, at most 256 at once, and {\"id\": 7, \"end\": true} ends one."
)]
pub struct Args {
    /// Method (default: the one that is recommended for the inputs of the first line with a box)
    #[arg(long, value_name = "NAME")]
    method: Option<String>,
    /// Method for boxes and frames, by the time that it takes
    #[arg(long, value_name = "TIER", conflicts_with_all = ["method", "inputs"])]
    tier: Option<super::Tier>,
    /// Largest number of false alarms per 1000 frames, for methods that take one
    #[arg(long, value_name = "N", value_parser = super::budget)]
    budget: Option<f64>,
    /// Inputs that will come beside boxes, for the default method; may be given as a list: frames,confidence,companions
    #[arg(long, value_name = "INPUT", value_delimiter = ',', conflicts_with = "method")]
    inputs: Vec<Input>,
    /// Number of the top left pixel in the boxes: 0, or 1 as in OTB (default: that of the state, else 0)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=1))]
    base: Option<u8>,
    /// File that keeps the state, from which the next start goes on; it is written at the end, when the program is
    /// interrupted, and after every --state-every lines. One monitor at a time may use it
    #[arg(long, value_name = "FILE")]
    state: Option<PathBuf>,
    /// Lines after which the state is written
    #[arg(long, value_name = "N", default_value_t = 900, value_parser = clap::value_parser!(u64).range(1..), requires = "state")]
    state_every: u64,
}

/// An input of a stream beside the boxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Input {
    /// The frames.
    Frames,
    /// The tracker's own confidence.
    Confidence,
    /// Boxes of other trackers.
    Companions,
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`]: `Usage` for a method that cannot monitor, `Data` for a state that does not fit, `Io` when stdin,
/// stdout or the state fails, `Interrupted` when stopped.
pub fn run(args: &Args) -> Result<(), Failure> {
    let state = args.state.as_deref().map(place).transpose()?;
    let _lock = state.as_deref().map(lock).transpose()?;
    let mut lines = start(args, state.as_deref())?;
    let ended = serve(args, &mut lines, state.as_deref(), &Pipes::open());
    if let Some(state) = &state {
        keep(&lines, state)?;
    }
    match ended {
        End::Done => Ok(()),
        End::Failed(failure) => Err(failure),
        End::Stopped => {
            let kept = state.map(|state| format!("; the state is kept in {}", state.display()));
            Err(Failure::Interrupted(format!("interrupted{}", kept.unwrap_or_default()).into()))
        }
    }
}

/// Judges line after line.
fn serve(args: &Args, lines: &mut Lines, state: Option<&Path>, pipes: &Pipes) -> End {
    loop {
        let line = match pipes.next_line() {
            Ok(line) => line,
            Err(end) => return end,
        };
        let known = lines.method.clone();
        let answer = lines.answer(&line);
        if let Some(method) = lines.method.as_ref().filter(|method| known.as_ref() != Some(method)) {
            output::note(&format!("method: {method}"));
        }
        if let Err(end) = pipes.write(answer) {
            return end;
        }
        let due = lines.targets.index().is_multiple_of(args.state_every);
        if let Some(Err(failure)) = state.filter(|_| due).map(|state| keep(lines, state)) {
            return End::Failed(failure);
        }
    }
}

/// The answer to a line, with the id of its target if it has one.
#[derive(Serialize)]
struct Answered {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<Id>,
    #[serde(flatten)]
    what: What,
}

#[derive(Serialize)]
#[serde(untagged)]
enum What {
    Judged(Answer),
    Ended {
        index: u64,
        ended: bool,
    },
    /// A line that cannot be used.
    Refused {
        index: u64,
        error: String,
    },
}

/// A stream of lines and the answers to them.
pub struct Lines {
    targets: Targets,
    /// Method of the last line.
    method: Option<String>,
}

impl Lines {
    /// A stream before its first line.
    ///
    /// # Errors
    /// As [`Monitor::new`](crate::monitor::Monitor::new).
    pub fn new(options: Options) -> Result<Self, MonitorError> {
        Ok(Self::of(Targets::new(options)?))
    }

    fn of(targets: Targets) -> Self {
        let method = targets.method().map(str::to_string);
        Self { targets, method }
    }

    /// The answer to the next line, with the end of a line.
    pub fn answer(&mut self, line: &[u8]) -> String {
        let index = self.targets.count();
        let line = Line::read(line).and_then(|line| Ok((line.id()?, line)));
        let (id, judged) = match line {
            Ok((id, line)) => (id.clone(), self.judge(id.as_ref(), line)),
            Err(error) => (None, self.skip().and(Err(error))),
        };
        let what = match judged {
            Ok(Some(answer)) => What::Judged(Answer { index, ..answer }),
            Ok(None) => What::Ended { index, ended: true },
            Err(error) => What::Refused { index, error: shorten_to(&error.to_string(), MAX_ERROR) },
        };
        serde_json::to_string(&Answered { id, what }).unwrap_or_default() + "\n"
    }

    /// Counts a line that names no target.
    fn skip(&mut self) -> Result<(), LineError> {
        self.targets.of(None)?.ok_or(LineError::TooMany)?.skip();
        Ok(())
    }

    /// The answer of the target's monitor; `None` for a target that ends.
    fn judge(&mut self, id: Option<&Id>, line: Line) -> Result<Option<Answer>, LineError> {
        if line.end == Some(true) {
            return if self.targets.end(id) { Ok(None) } else { Err(LineError::NoTarget) };
        }
        let monitor = self.targets.of(id)?.ok_or(LineError::TooMany)?;
        let index = monitor.index();
        let answer = judged(monitor, line);
        // Every line counts for its target, whether it can be used or not.
        if monitor.index() == index {
            monitor.skip();
        }
        self.method = monitor.method().map(str::to_string);
        answer.map(Some)
    }
}

fn judged(monitor: &mut Monitor, line: Line) -> Result<Answer, LineError> {
    let base = monitor.base().into();
    let region = line.region(base)?;
    let companions = line.companions(base)?;
    let (confidence, restart) = (line.confidence, line.restart == Some(true));
    let frame = if monitor.reads_frames() { line.frame()? } else { None };
    let (frame, region) = (frame.as_ref(), region.as_ref());
    Ok(monitor.update(&Update { frame, region, confidence, companions: &companions, restart })?)
}

/// The stream of the arguments, or that of the state if there is one.
fn start(args: &Args, state: Option<&Path>) -> Result<Lines, Failure> {
    let has = |input: Input| args.inputs.contains(&input);
    let inputs = Inputs {
        frames: has(Input::Frames),
        companions: has(Input::Companions),
        confidence: has(Input::Confidence),
    };
    let inputs = (!args.inputs.is_empty()).then_some(inputs);
    let of_tier = args.tier.map(|tier| tier.method().to_string());
    let method = args.method.clone().or(of_tier);
    let options = Options { method, budget: args.budget, inputs, base: args.base };
    let Some(state) = state else { return Lines::new(options).map_err(Failure::usage) };
    let saved = match std::fs::read(state) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            let lines = Lines::new(options).map_err(Failure::usage)?;
            // Whether the state can be kept shows now, not at the end of a long stream.
            keep(&lines, state)?;
            return Ok(lines);
        }
        saved => saved.map_err(|e| Failure::io(format!("{}: {e}", state.display())))?,
    };
    let remedy = "remove the file to begin anew, or name another one";
    let targets = Targets::resume(options, &saved).map_err(|e| match e {
        e @ (MonitorError::Method(_) | MonitorError::Unfit { .. }) => Failure::usage(e),
        e => Failure::data(format!("{}: {e}; {remedy}", state.display())),
    })?;
    output::note(&format!("{}: goes on with frame {}", state.display(), targets.index()));
    Ok(Lines::of(targets))
}

/// Keeps other monitors from the state as long as the file is open. It is another file, since the state's own is replaced.
fn lock(state: &Path) -> Result<File, Failure> {
    let mut path = state.as_os_str().to_owned();
    path.push(".lock");
    let path = PathBuf::from(path);
    let opened = File::options().create(true).truncate(false).write(true).open(&path);
    let file = opened.map_err(|e| Failure::io(format!("{}: {e}", path.display())))?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            let state = state.display();
            let told = format!(
                "{state}: another `trackfail monitor` has its state there; end it, or name another file"
            );
            return Err(Failure::data(told));
        }
        Err(TryLockError::Error(e)) => {
            let told =
                format!("{}: cannot be locked ({e}); no other monitor may use this state", path.display());
            output::note(&told);
        }
    }
    Ok(file)
}

/// Writes the state; a reader of the file sees the old one or the new one.
fn keep(lines: &Lines, state: &Path) -> Result<(), Failure> {
    let bytes = lines.targets.save().map_err(Failure::usage)?;
    store::write(state, &bytes).map_err(Failure::io)
}

/// The file itself that keeps the state: a link stays a link, and a device is not replaced.
fn place(state: &Path) -> Result<PathBuf, Failure> {
    let refuse = |why: &str| Failure::usage(format!("--state {}: {why}", state.display()));
    match std::fs::metadata(state) {
        Ok(about) if !about.is_file() => return Err(refuse("is no regular file")),
        Ok(_) => return std::fs::canonicalize(state).map_err(|e| refuse(&e.to_string())),
        Err(_) if state.is_symlink() => return Err(refuse("is a link that leads nowhere")),
        Err(_) => {}
    }
    let folder = state.parent().filter(|folder| !folder.as_os_str().is_empty());
    if folder.is_some_and(|folder| !folder.is_dir()) {
        return Err(refuse("there is no such folder"));
    }
    Ok(state.to_path_buf())
}
