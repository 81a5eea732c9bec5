//! Frames of a video file, decoded by `ffmpeg`. A suite's video is decoded once, into PNG files; a user's
//! video is decoded for each pass over the frames, without files, see [`VideoStream`].
//!
//! ```text
//! DATA/caviar/Walk1/Walk1.mpg                            the video
//! DATA/.trackfail/frames/<SHA-256 of the video>/000001.png ...    its frames, all of them, from 1 on
//! ```
//!
//! Decoding starts when a frame is first requested. The frames are written into a folder `.decoding-...`
//! beside the final one, which is renamed when it is complete; so a folder with the final name is always
//! whole. A later run deletes what a killed run left. Users may delete the decoded frames. One video is
//! decoded at a time.
//!
//! The `ffmpeg` on the PATH is run without a shell and [guarded](mod@guarded). The file's name is given to it as `file:` and an absolute
//! path, so that it can be no option or network address; only files are read, and only formats of [`FORMATS`].
//! Time, frames and bytes are limited ([`VideoLimits`]). Every decoded frame is given, none is repeated or dropped
//! to keep a rate. Colors are converted by the exact, slower way, but another version of ffmpeg may still
//! give other pixels: the files digest of a sequence pins the video, not what was made of it.

mod stream;

pub use stream::VideoStream;

use super::digest::file_digest;
use super::guarded::{self, Guarded, Tail};
use super::text::{shorten_to, visible};
use super::{DatasetError, leftover::TemporaryFolder};
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Containers that may be opened, by ffmpeg's names.
pub const FORMATS: &str = "mpeg,mpegvideo,mpegts,avi,mov,matroska,webm";

/// Prefix of folders that are being filled with frames.
const DECODING: &str = ".decoding-";

/// Longest time for reading the frame rate of a video.
const PROBE_TIME: Duration = Duration::from_secs(60);
/// Most characters of ffmpeg's output that a message quotes.
const MAX_REASON: usize = 200;

/// Folder under a data root for the decoded frames of its videos.
pub fn cache(data_root: &Path) -> PathBuf {
    data_root.join(".trackfail").join("frames")
}

/// Limits on decoding a video.
#[derive(Debug, Clone, Copy)]
pub struct VideoLimits {
    /// Longest time for decoding.
    pub time: Duration,
    /// Most frames.
    pub frames: u32,
    /// Most bytes of all frames together, as PNG files.
    pub bytes: u64,
    /// True if damage stops the decoding; otherwise ffmpeg invents the damaged parts.
    pub damage_ends_it: bool,
}

/// Limits far above the longest clip of any suite (CAVIAR: two minutes, half a GiB). Damage is tolerated: the
/// bytes of a suite's video are pinned, so its flaws are part of the data.
pub const DEFAULT_LIMITS: VideoLimits =
    VideoLimits { time: Duration::from_secs(3600), frames: 100_000, bytes: 64 << 30, damage_ends_it: false };

/// A range of a video's frames.
#[derive(Debug)]
pub struct Video {
    path: PathBuf,
    decoded: PathBuf,
    range: (u32, u32),
    files: OnceLock<Vec<PathBuf>>,
}

impl Video {
    /// Frames `range` (numbered from 1) of the video at `path`, to be decoded below the folder `decoded`.
    pub fn new(path: PathBuf, decoded: PathBuf, range: (u32, u32)) -> Self {
        Self { path, decoded, range, files: OnceLock::new() }
    }

    /// The video file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Image files of the range in order. The video is decoded first, if needed.
    ///
    /// # Errors
    /// No ffmpeg, a video that ffmpeg cannot decode, a limit, or a video with fewer frames than the range.
    pub fn files(&self) -> Result<&[PathBuf], DatasetError> {
        if let Some(files) = self.files.get() {
            return Ok(files);
        }
        let folder = self.decoded.join(file_digest(&self.path)?);
        decode(&self.path, &folder, OsStr::new("ffmpeg"), DEFAULT_LIMITS, &guarded::is_interrupted)?;
        let (first, last) = self.range;
        let files: Vec<PathBuf> = (first..=last).map(|n| folder.join(format!("{n:06}.png"))).collect();
        if let Some(absent) = files.iter().position(|f| !f.is_file()) {
            let message = format!(
                "frame {} is not in it, frames {first} to {last} are needed; fetch the video again, or delete {} \
                 if something in there was deleted",
                first as usize + absent,
                folder.display()
            );
            return Err(DatasetError::content(&self.path, message));
        }
        Ok(self.files.get_or_init(|| files))
    }
}

/// Mean frames per second, as `ffprobe` reads them; `None` if the rate is unknown or `is_stopped` returns
/// true.
pub fn rate(video: &Path, is_stopped: &dyn Fn() -> bool) -> Option<f64> {
    let mut command = Command::new("ffprobe");
    command
        .args(["-v", "error", "-protocol_whitelist", "file", "-format_whitelist", FORMATS])
        .args(["-select_streams", "v:0", "-show_entries", "stream=avg_frame_rate", "-of", "csv=p=0"])
        .arg(url(&video.canonicalize().ok()?));
    let mut probe = Guarded::start(command, [Stdio::null(), Stdio::piped()], None).ok()?;
    let told = Tail::new(probe.stdout()?);
    let until = Instant::now() + PROBE_TIME;
    let check = || if is_stopped() || Instant::now() > until { Err(()) } else { Ok(()) };
    probe.wait(check).ok()?.ok().filter(ExitStatus::success)?;
    let text = told.text();
    let (frames, seconds) = text.lines().next()?.trim().trim_end_matches(',').split_once('/')?;
    let rate = frames.parse::<f64>().ok()? / seconds.parse::<f64>().ok()?;
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

/// Decodes all frames of `video` into `folder` unless the folder exists.
fn decode(
    video: &Path,
    folder: &Path,
    program: &OsStr,
    limits: VideoLimits,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(), DatasetError> {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    if folder.is_dir() {
        return Ok(());
    }
    let Some(parent) = folder.parent() else { return Err(DatasetError::content(folder, "no folder")) };
    let failed = |e| DatasetError::io(parent, e);
    std::fs::create_dir_all(parent).map_err(failed)?;
    let temporary = TemporaryFolder::new_in(parent, DECODING).map_err(failed)?;
    let fresh = &temporary.within("frames").map_err(failed)?;
    run_on(video, limits, |input, every_frame| {
        let mut command = command(program, input, every_frame, limits);
        // A pattern relative to the working folder: a `%` in the folder's own path would be one too.
        command.args(["-c:v", "png", "-f", "image2", "-start_number", "1", "%06d.png"]).current_dir(fresh);
        run(command, fresh, limits, is_stopped)
    })?;
    match std::fs::rename(fresh, folder) {
        // Another process was faster.
        Err(_) if folder.is_dir() => Ok(()),
        done => done.map_err(|e| DatasetError::io(folder, e)),
    }
}

/// Result of a run of ffmpeg.
struct Outcome {
    /// Exit status, or the reason why the run was stopped.
    status: Result<ExitStatus, String>,
    /// Last part of the stderr of ffmpeg.
    said: String,
    /// Number of frames written.
    frames: usize,
}

/// Decodes all frames of `video` by `attempt`, which is given a path and an option that makes ffmpeg keep
/// every frame. Returns the path and the option that worked, and the number of frames.
fn run_on(
    video: &Path,
    limits: VideoLimits,
    attempt: impl Fn(&Path, &'static str) -> std::io::Result<Outcome>,
) -> Result<(PathBuf, &'static str, usize), DatasetError> {
    let content = |message: String| DatasetError::content(video, message);
    // A pipe or a device would be waited for, also by ffmpeg.
    if !std::fs::metadata(video).map_err(|e| DatasetError::io(video, e))?.is_file() {
        return Err(content("not a file; frames are a video file, image files or a folder of them".into()));
    }
    let readable = File::open(video).and_then(|_| video.canonicalize());
    let input = readable.map_err(|e| DatasetError::io(video, e))?;
    // Older versions (before 5.1) know the option under another name; newer ones may lose that.
    let mut every_frame = "-fps_mode";
    loop {
        let Outcome { status, said, frames } =
            attempt(&input, every_frame).map_err(|e| not_started(video, &e))?;
        let status = status.map_err(content)?;
        let fault = match frames {
            _ if !status.success() && every_frame == "-fps_mode" && said.contains("fps_mode") => {
                every_frame = "-vsync";
                continue;
            }
            _ if !status.success() => refusal(status, &said, frames, limits),
            0 => "ffmpeg found no frame in it; fetch the file again".into(),
            _ if frames > limits.frames as usize => {
                format!("more than {} frames, which no sequence has", limits.frames)
            }
            _ => return Ok((input, every_frame, frames)),
        };
        return Err(content(fault));
    }
}

/// The error for an ffmpeg that cannot be started.
fn not_started(video: &Path, e: &std::io::Error) -> DatasetError {
    let message = match e.kind() {
        std::io::ErrorKind::NotFound => {
            "its frames have to be decoded, but there is no `ffmpeg` on the PATH; install it (Debian, Ubuntu: \
             apt install ffmpeg; macOS: brew install ffmpeg; Windows: winget install ffmpeg)"
                .into()
        }
        _ => format!("ffmpeg does not start: {e}"),
    };
    DatasetError::content(video, message)
}

/// Path in a form that ffmpeg can take only for a file.
fn url(path: &Path) -> OsString {
    let mut url = OsString::from("file:");
    url.push(path);
    url
}

/// Command of ffmpeg that decodes every frame. The caller adds the output.
fn command(program: &OsStr, input: &Path, every_frame: &str, limits: VideoLimits) -> Command {
    let mut command = Command::new(program);
    command
        .args(["-nostdin", "-hide_banner", "-loglevel", "error"])
        .args(if limits.damage_ends_it { &["-xerror", "-err_detect", "explode"][..] } else { &[] })
        .args(["-protocol_whitelist", "file", "-format_whitelist", FORMATS, "-i"])
        .arg(url(input))
        .args(["-map", "0:v:0", every_frame, "passthrough", "-pix_fmt", "rgb24"])
        .args(["-sws_flags", "bicubic+accurate_rnd+full_chroma_int+bitexact"])
        .args(["-frames:v", &limits.frames.saturating_add(1).to_string()]);
    command
}

/// Check that fails once the time is up or `is_stopped` returns true. Time counts from this call.
fn in_time(limits: VideoLimits, is_stopped: &dyn Fn() -> bool) -> impl Fn() -> Result<(), String> {
    let until = Instant::now() + limits.time;
    move || {
        if is_stopped() {
            return Err("interrupted".to_string());
        }
        if Instant::now() > until {
            return Err(format!("ffmpeg takes more than {} s", limits.time.as_secs()));
        }
        Ok(())
    }
}

/// Runs a program to its end that writes frames into a folder.
fn run(
    command: Command,
    output: &Path,
    limits: VideoLimits,
    is_stopped: &dyn Fn() -> bool,
) -> std::io::Result<Outcome> {
    let in_time = in_time(limits, is_stopped);
    let files = || std::fs::read_dir(output).into_iter().flatten().flatten();
    let check = || {
        in_time()?;
        let bytes: u64 = files().filter_map(|file| file.metadata().ok()).map(|about| about.len()).sum();
        let fits = bytes <= limits.bytes;
        fits.then_some(()).ok_or_else(|| format!("the frames take more than {} bytes", limits.bytes))
    };
    let mut program = Guarded::start(command, [Stdio::null(), Stdio::null()], Some(output))?;
    let status = program.wait(check)?;
    Ok(Outcome { status, said: program.stderr(), frames: files().count() })
}

/// Explanation of a failure of ffmpeg, with a remedy.
fn refusal(status: ExitStatus, said: &str, frames: usize, limits: VideoLimits) -> String {
    let meaning = match frames {
        _ if status.code().is_none() => format!("ffmpeg did not finish ({status}); try it again"),
        _ if !limits.damage_ends_it => "this is no video that ffmpeg reads; fetch the file again".into(),
        0 => {
            "this is no video that ffmpeg reads, or a damaged one; name a whole video file, image files or a folder of \
             them"
                .into()
        }
        _ => {
            "the video is damaged, its frames would be wrong; take a whole copy of it, or the frames that are good as \
             images"
                .into()
        }
    };
    match reason(said) {
        Some(reason) => format!("{meaning} (ffmpeg: {reason})"),
        None => meaning,
    }
}

/// Last line of ffmpeg's output, without the name of the component (`[mpeg @ 0x55d0]`) and of the file.
fn reason(said: &str) -> Option<String> {
    let line = said.lines().map(str::trim).rfind(|line| !line.is_empty())?;
    let line =
        if line.starts_with('[') { line.split_once("] ").map_or(line, |(_, rest)| rest) } else { line };
    let line =
        if line.starts_with("file:") { line.rsplit_once(": ").map_or(line, |(_, rest)| rest) } else { line };
    Some(shorten_to(&visible(line), MAX_REASON))
}

#[cfg(test)]
mod tests;
