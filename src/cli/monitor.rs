//! `trackfail monitor`: a JSON line in and a JSON line out for each frame.
//!
//! Each input line is a frame of the stream. It is answered before the next line is read.

mod line;

use super::{Cause, Exit, Failure, io_at, output};
use crate::dataset::text::{shorten_to, without_mark};
use crate::engine::store;
use crate::method::Inputs;
use crate::monitor::{Answer, Id, MAX_TARGETS, Monitor, MonitorError, Options, Targets, Update};
use line::{Line, MAX_LINE};
use serde::Serialize;
use std::fs::{File, TryLockError};
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Longest error message, in characters. Messages may quote the input.
const MAX_ERROR: usize = 1000;

/// Arguments of `monitor`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "In, a line for each frame: {\"frame\": \"path.jpg\", \"box\": [x, y, w, h], \"confidence\": 0.9, \
\"companions\": [[x, y, w, h]]}. Every key may be left out or null; without a box, the tracker says that the target is absent. A frame \
may also be {\"raw\": {\"width\": 640, \"height\": 480, \"format\": \"bgr\", \"data\": \"base64\"}}, or have the file of these bytes as \
\"path\" instead of \"data\". Out, a line for each line, at once: {\"index\": 51, \"probability\": 0.97, \"state\": \"lost\", \
\"reasons\": [\"...\"]}, or {\"index\": 52, \"error\": \"...\"} for a line that cannot be used; the stream goes on. States: tracking, \
lost, absent. Lines about several targets have an \"id\", a whole number or a text, which stands in the answers, too; each target is judged \
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
    #[arg(value_parser = ["frames", "confidence", "companions"])]
    inputs: Vec<String>,
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

/// Runs the verb.
///
/// # Errors
/// See [`Failure`]: `Usage` for a method that cannot monitor, `Data` for a state that does not fit, `Io` when stdin,
/// stdout or the state fails, `Interrupted` when stopped.
pub fn run(args: &Args) -> Result<(), Failure> {
    let state = args.state.as_deref().map(place).transpose()?;
    let _lock = state.as_deref().map(lock).transpose()?;
    let lines = Arc::new(Mutex::new(start(args, state.as_deref())?));
    if let (None, Some(chosen)) = (&args.method, &locked(&lines).method) {
        output::note(&format!("method: {chosen}"));
    }
    stop_on_signals(lines.clone(), state.clone());
    let ended = serve(args, &lines, state.as_deref());
    keep(&locked(&lines), state.as_deref())?;
    ended
}

/// Starts a thread that ends the program at a signal, between two lines, even if the stream is blocked.
fn stop_on_signals(lines: Arc<Mutex<Lines>>, state: Option<PathBuf>) {
    // Without a handler a signal ends the program, and its state is the last one that was written.
    let _ = ctrlc::set_handler(move || {
        // Nothing is judged from here on.
        let lines = locked(&lines);
        let kept = state.as_ref().map(|state| format!("; the state is kept in {}", state.display()));
        let end = || Failure::new(Exit::Interrupted, format!("interrupted{}", kept.unwrap_or_default()));
        let ended = keep(&lines, state.as_deref()).err().unwrap_or_else(end);
        std::process::exit(ended.tell().into());
    });
}

fn locked(lines: &Mutex<Lines>) -> MutexGuard<'_, Lines> {
    lines.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Answers line after line, until the input ends or the reader of the answers is gone.
fn serve(args: &Args, lines: &Mutex<Lines>, state: Option<&Path>) -> Result<(), Failure> {
    let mut input = BufReader::with_capacity(1 << 18, io::stdin().lock());
    let mut out = io::stdout().lock();
    let mut is_first = true;
    while let Some(line) = read_line(&mut input).map_err(|e| Failure::io(format!("stdin: {e}")))? {
        // Some programs write a byte-order mark before their text.
        let line = if std::mem::take(&mut is_first) { without_mark(&line) } else { &line[..] };
        let (answer, method) = locked(lines).judged(line);
        method.iter().for_each(|method| output::note(&format!("method: {method}")));
        match out.write_all(answer.as_bytes()).and_then(|()| out.flush()) {
            Err(e) if e.kind() == io::ErrorKind::BrokenPipe => return Ok(()),
            written => written.map_err(|e| Failure::io(format!("stdout: {e}")))?,
        }
        let lines = locked(lines);
        if lines.targets.index().is_multiple_of(args.state_every) {
            keep(&lines, state)?;
        }
    }
    Ok(())
}

/// Reads the next line, without its end. Of a line that is too long, only the beginning is returned, one byte
/// longer than a line may be.
fn read_line(input: &mut impl BufRead) -> io::Result<Option<Vec<u8>>> {
    let mut line = Vec::new();
    input.take(MAX_LINE as u64 + 1).read_until(b'\n', &mut line)?;
    if line.is_empty() {
        return Ok(None);
    }
    if line.last() == Some(&b'\n') {
        line.pop();
    } else if line.len() > MAX_LINE {
        input.skip_until(b'\n')?;
    }
    Ok(Some(line))
}

/// Answer to a line, with the id of its target if it has one.
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
    /// Answer to a line that cannot be used.
    Refused {
        index: u64,
        error: String,
    },
}

/// A stream of lines: the monitors of its targets, and the state between lines.
pub struct Lines {
    targets: Targets,
    /// Method of the last answer.
    method: Option<String>,
}

impl Lines {
    /// Creates a stream before its first line.
    ///
    /// # Errors
    /// The errors of [`Monitor::new`](crate::monitor::Monitor::new).
    pub fn new(options: Options) -> Result<Self, MonitorError> {
        Ok(Self::of(Targets::new(options)?))
    }

    /// A stream that goes on.
    pub fn of(targets: Targets) -> Self {
        let method = targets.method().map(str::to_string);
        Self { targets, method }
    }

    /// The monitors of its targets.
    pub fn targets(&self) -> &Targets {
        &self.targets
    }

    /// The answer to the next line, with the end of a line.
    pub fn answer(&mut self, line: &[u8]) -> String {
        let index = self.targets.count();
        let (id, judged) = match Line::read(line) {
            Ok(mut line) => {
                let id = line.id.take();
                let judged = self.judge(id.as_ref(), line);
                (id, judged)
            }
            // It counts as a frame of the stream without targets.
            Err(error) => (None, self.monitor(None).map(Monitor::skip).and(Err(error))),
        };
        let what = match judged {
            Ok(Some(answer)) => What::Judged(Answer { index, ..answer }),
            Ok(None) => What::Ended { index, ended: true },
            Err(error) => What::Refused { index, error: shorten_to(&error.to_string(), MAX_ERROR) },
        };
        serde_json::to_string(&Answered { id, what }).unwrap_or_default() + "\n"
    }

    /// Answers the next line, and returns the method if it differs from that of the last answer.
    fn judged(&mut self, line: &[u8]) -> (String, Option<String>) {
        let known = self.method.clone();
        let answer = self.answer(line);
        (answer, self.method.clone().filter(|method| known.as_ref() != Some(method)))
    }

    fn monitor(&mut self, id: Option<&Id>) -> Result<&mut Monitor, Cause> {
        let refused = || {
            let remedy = r#"one that is gone makes room: {"id": 7, "end": true}"#;
            format!("{MAX_TARGETS} targets are followed already; {remedy}")
        };
        Ok(self.targets.of(id)?.ok_or_else(refused)?)
    }

    /// Answer of the monitor of a target; `None` if the line ends the target.
    fn judge(&mut self, id: Option<&Id>, line: Line) -> Result<Option<Answer>, Cause> {
        if line.end == Some(true) {
            let ended = self.targets.end(id).then_some(None);
            return Ok(ended.ok_or("no target of this id is followed")?);
        }
        let monitor = self.monitor(id)?;
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

fn judged(monitor: &mut Monitor, line: Line) -> Result<Answer, Cause> {
    let base = monitor.base().into();
    let region = line.region(base)?;
    let companions = line.companions(base)?;
    let (confidence, restart) = (line.confidence, line.restart == Some(true));
    let frame = if monitor.reads_frames() { line.frame()? } else { None };
    let (frame, region) = (frame.as_ref(), region.as_ref());
    Ok(monitor.update(&Update { frame, region, confidence, companions: &companions, restart })?)
}

/// Creates the stream from the arguments, or restores it from the state if there is one.
fn start(args: &Args, state: Option<&Path>) -> Result<Lines, Failure> {
    let has = |input: &str| args.inputs.iter().any(|given| given == input);
    let [frames, companions, confidence] = ["frames", "companions", "confidence"].map(has);
    let inputs = (!args.inputs.is_empty()).then_some(Inputs { frames, companions, confidence });
    let of_tier = args.tier.map(|tier| tier.method().to_string());
    let method = args.method.clone().or(of_tier);
    let options = Options { method, budget: args.budget, inputs, base: args.base };
    let Some(state) = state else { return Lines::new(options).map_err(Failure::usage) };
    let saved = match std::fs::read(state) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            let lines = Lines::new(options).map_err(Failure::usage)?;
            // Whether the state can be kept shows now, not at the end of a long stream.
            keep(&lines, Some(state))?;
            return Ok(lines);
        }
        saved => saved.map_err(io_at(state))?,
    };
    let remedy = "remove the file to begin anew, or name another one";
    let targets = Targets::resume(options, &saved).map_err(|e| match e {
        e @ (MonitorError::Method(_) | MonitorError::Unfit { .. }) => Failure::usage(e),
        e => Failure::data(format!("{}: {e}; {remedy}", state.display())),
    })?;
    output::note(&format!("{}: goes on with frame {}", state.display(), targets.index()));
    Ok(Lines::of(targets))
}

/// Locks the state against other monitors as long as the returned file is open. The lock is a separate file,
/// since the file of the state is replaced.
fn lock(state: &Path) -> Result<File, Failure> {
    let mut path = state.as_os_str().to_owned();
    path.push(".lock");
    let path = PathBuf::from(path);
    let opened = File::options().create(true).truncate(false).write(true).open(&path);
    let file = opened.map_err(io_at(&path))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            return Err(Failure::data(format!(
                "{}: another `trackfail monitor` has its state there; end it, or name another file",
                state.display()
            )));
        }
        Err(TryLockError::Error(e)) => output::note(&format!(
            "{}: cannot be locked ({e}); no other monitor may use this state",
            path.display()
        )),
        Ok(()) => {}
    }
    Ok(file)
}

/// Writes the state, if there is a file for it. Readers of the file see the old or the new state.
fn keep(lines: &Lines, state: Option<&Path>) -> Result<(), Failure> {
    let Some(state) = state else { return Ok(()) };
    let bytes = lines.targets.save().map_err(Failure::usage)?;
    store::write(state, &bytes).map_err(Failure::io)
}

/// Path of the file that is replaced when the state is written. A link is resolved, so that it stays a link;
/// devices are refused.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_their_end_or_at_that_of_the_input() {
        let mut input = &b"one\n\nlast"[..];
        let mut next = || read_line(&mut input).unwrap();
        assert_eq!([next(), next(), next()], [&b"one"[..], b"", b"last"].map(|line| Some(line.to_vec())));
        assert_eq!(next(), None);
    }

    #[test]
    fn of_a_line_without_end_no_more_than_the_limit_is_kept() {
        let endless = io::repeat(b'x').take(MAX_LINE as u64 + 5_000_000);
        let mut input = BufReader::new(endless.chain(&b"\nnext\n"[..]));
        assert_eq!(read_line(&mut input).unwrap().unwrap().len(), MAX_LINE + 1);
        assert_eq!(read_line(&mut input).unwrap().unwrap(), b"next");
    }
}
