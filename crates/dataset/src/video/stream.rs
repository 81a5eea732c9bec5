//! Frames of a user's video in their order, through a pipe of `ffmpeg`, without files.
//!
//! A first run decodes the whole video and scales the frames down to a few pixels, which takes less than half
//! of the time of full decoding. It finds the number of frames, and damage before results depend on it. Each
//! pass over the frames is a further run, which must give the same number.

use super::{Outcome, VideoLimits, command, in_time, not_started, refusal, run_on};
use crate::DatasetError;
use crate::files::{bad_image, of_size};
use crate::guarded::{self, Guarded};
use std::collections::VecDeque;
use std::ffi::OsStr;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Duration;
use trackfail_core::image::{Frame, ImageError, MAX_PIXELS, MAX_SIDE};

/// Limits on a user's video. Unlike in suites, damage is an error.
const LIMITS: VideoLimits = VideoLimits { damage_ends_it: true, ..super::DEFAULT_LIMITS };
/// Most frames that are kept, since threads request neighboring frames in any order.
const MAX_KEPT: usize = 16;
/// Most bytes of the kept frames, unless a single frame is larger.
const MAX_KEPT_BYTES: usize = 64 << 20;
/// Interval at which a waiting thread checks for interruption.
const PAUSE: Duration = Duration::from_millis(50);
/// Number of pauses after the end of ffmpeg until its pipe counts as ended, too. Another process may hold the
/// pipe open.
const MAX_PAUSES: u32 = 100;
/// Longest line in the header of a picture, in bytes.
const MAX_LINE: u64 = 32;

/// Frames of a user's video. A request for a frame before the kept ones decodes the video from its start.
pub struct VideoStream {
    path: PathBuf,
    input: PathBuf,
    every_frame: &'static str,
    frames: usize,
    size: OnceLock<(usize, usize)>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    pass: Option<Pass>,
    /// Number of frames that the current pass has read. The last of them are kept.
    given: usize,
    kept: VecDeque<Frame>,
}

impl VideoStream {
    /// Opens a video and counts its frames. The call ends soon after `is_stopped` returns true.
    ///
    /// # Errors
    /// No ffmpeg, a video that ffmpeg cannot decode, damage, a limit, or an interruption.
    pub fn open(video: &Path, is_stopped: &dyn Fn() -> bool) -> Result<Self, DatasetError> {
        let count = |input: &Path, every_frame: &str| {
            let check = in_time(LIMITS, is_stopped);
            let mut pass = Pass::start(input, every_frame, &["-vf", "scale=8:8:flags=neighbor"])?;
            let mut frames = 0;
            loop {
                match pass.picture(&check) {
                    Ok(Some(_)) => frames += 1,
                    Ok(None) => return pass.outcome(&check, frames),
                    Err(reason) => return Ok(Outcome { status: Err(reason), said: String::new(), frames }),
                }
            }
        };
        let (input, every_frame, frames) = run_on(video, LIMITS, count)?;
        let (path, size, state) = (video.to_path_buf(), OnceLock::new(), Mutex::default());
        Ok(Self { path, input, every_frame, frames, size, state })
    }

    /// The video file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of frames, at least 1.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Width and height of the frames in pixels; `None` until one has been read.
    pub fn size(&self) -> Option<(usize, usize)> {
        self.size.get().copied()
    }

    /// Frame `t` (0-based); `None` if the video is shorter. The call ends soon after an
    /// [interruption](guarded::interrupt).
    ///
    /// # Errors
    /// No ffmpeg, a file that has changed, a frame that is too large or of another size, a limit, or an
    /// interruption.
    pub fn frame(&self, t: usize) -> Result<Option<Frame>, DatasetError> {
        if t >= self.frames {
            return Ok(None);
        }
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if t + state.kept.len() < state.given {
            *state = State::default();
        }
        while state.given <= t {
            if let Err(e) = self.read_next(&mut state) {
                *state = State::default();
                return Err(e);
            }
        }
        Ok(state.kept.iter().nth_back(state.given - t - 1).cloned())
    }

    /// Reads the next frame. After the last one, checks that ffmpeg ended well.
    fn read_next(&self, state: &mut State) -> Result<(), DatasetError> {
        let content = |message: String| DatasetError::content(&self.path, message);
        let io = |e: io::Error| not_started(&self.path, &e);
        let changed = || content("it has changed since its frames were counted; try it again".into());
        let check = in_time(LIMITS, &guarded::is_interrupted);
        let mut pass = match state.pass.take() {
            Some(pass) => pass,
            None => Pass::start(&self.input, self.every_frame, &[]).map_err(io)?,
        };
        if let Some(picture) = pass.picture(&check).map_err(content)? {
            let frame = picture.map_err(|e| bad_image(&self.path, e))?;
            let size = *self.size.get_or_init(|| (frame.width(), frame.height()));
            state.keep(of_size(frame, size, &self.path)?);
            if state.given < self.frames {
                state.pass = Some(pass);
                return Ok(());
            }
            if pass.picture(&check).map_err(content)?.is_some() {
                return Err(changed());
            }
        }
        let Outcome { status, said, .. } = pass.outcome(&check, state.given).map_err(io)?;
        match status.map_err(content)? {
            status if !status.success() => Err(content(refusal(status, &said, state.given, LIMITS))),
            _ if state.given < self.frames => Err(changed()),
            _ => Ok(()),
        }
    }
}

impl State {
    fn keep(&mut self, frame: Frame) {
        let most = (MAX_KEPT_BYTES / frame.bytes().len().max(1)).clamp(1, MAX_KEPT);
        self.given += 1;
        self.kept.push_back(frame);
        self.kept.drain(..self.kept.len().saturating_sub(most));
    }
}

/// A decoded frame, or the error of decoding it.
type Picture = Result<Frame, ImageError>;

/// A run of ffmpeg. Its thread reads a picture or two ahead.
struct Pass {
    program: Guarded,
    pictures: Receiver<Picture>,
}

impl Pass {
    fn start(input: &Path, every_frame: &str, filter: &[&str]) -> io::Result<Self> {
        let mut command = command(OsStr::new("ffmpeg"), input, every_frame, LIMITS);
        command.args(filter).args(["-c:v", "ppm", "-f", "image2pipe", "pipe:1"]);
        let mut program = Guarded::start(command, [Stdio::null(), Stdio::piped()], None)?;
        let (send, pictures) = sync_channel(1);
        let stdout = program.stdout();
        // It may write nothing, which this thread alone waits for.
        std::thread::spawn(move || {
            let mut stream = BufReader::new(stdout?);
            std::iter::from_fn(|| read_picture(&mut stream)).try_for_each(|picture| send.send(picture).ok())
        });
        Ok(Self { program, pictures })
    }

    /// Next picture; `None` at the end. The error is the reason why `check` stopped the wait.
    fn picture(&mut self, check: &impl Fn() -> Result<(), String>) -> Result<Option<Picture>, String> {
        let mut pauses = 0;
        loop {
            check()?;
            match self.pictures.recv_timeout(PAUSE) {
                Ok(picture) => return Ok(Some(picture)),
                Err(RecvTimeoutError::Timeout) if matches!(self.program.try_wait(), Ok(None)) => {}
                Err(RecvTimeoutError::Timeout) if pauses < MAX_PAUSES => {
                    self.program.end();
                    pauses += 1;
                }
                Err(_) => return Ok(None),
            }
        }
    }

    /// Result of the run, after `frames` frames were read.
    fn outcome(&mut self, check: &impl Fn() -> Result<(), String>, frames: usize) -> io::Result<Outcome> {
        let status = self.program.wait(check)?;
        Ok(Outcome { status, said: self.program.stderr(), frames })
    }
}

/// Next picture of a stream of PPM files of 8 bits; `None` at the end, or if the bytes are anything else.
pub(super) fn read_picture(stream: &mut impl BufRead) -> Option<Picture> {
    let mut header = String::new();
    for _ in 0..3 {
        stream.by_ref().take(MAX_LINE).read_line(&mut header).ok()?;
    }
    let numbers = header.strip_prefix("P6\n")?.split_ascii_whitespace().map(str::parse::<u32>);
    let numbers = numbers.collect::<Result<Vec<u32>, _>>().ok()?;
    let &[width, height, 255] = numbers.as_slice() else { return None };
    if width.min(height) == 0 {
        return None;
    }
    if width.max(height) > MAX_SIDE || u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Some(Err(ImageError::TooLarge { width, height }));
    }
    let (width, height) = (width as usize, height as usize);
    let mut rgb = vec![0; 3 * width * height];
    stream.read_exact(&mut rgb).ok()?;
    Some(Ok(Frame::new(width, height, rgb)))
}
