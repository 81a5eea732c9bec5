//! Frames of a video file, decoded once by `ffmpeg` into PNG files.
//!
//! ```text
//! DATA/caviar/Walk1/Walk1.mpg                            the video
//! DATA/.trackfail/frames/<SHA-256 of the video>/000001.png ...    its frames, all of them, from 1 on
//! ```
//!
//! Decoding starts when a frame is first asked for. It writes into a folder of another name beside the last
//! one and renames it when it is complete, so a folder of that name is never a part; what a killed run leaves
//! is named `.decoding-...`; a later run deletes it. The frames themselves may be deleted. One video is decoded at a time.
//!
//! The `ffmpeg` on the PATH is run without a shell. The file's name is given to it as `file:` and an absolute
//! path, so that it can be no option or network address; only files are read, and only formats of [`FORMATS`].
//! Time, frames and bytes are limited ([`VideoLimits`]). Every decoded frame is written, none is repeated or dropped
//! to keep a rate. Colors are converted by the exact, slower way, but another version of ffmpeg may still
//! give other pixels: the files digest of a sequence pins the video, not what was made of it.

use super::digest::file_digest;
use super::{DatasetError, ImageFiles, leftover};
use std::ffi::{OsStr, OsString};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Containers that are opened, by ffmpeg's names.
pub const FORMATS: &str = "mpeg,mpegvideo,mpegts,avi,mov,matroska,webm";

/// Start of the names of folders that are being filled.
const DECODING: &str = ".decoding-";

/// Folder of the decoded frames of the videos under a data root.
pub fn cache(data_root: &Path) -> PathBuf {
    data_root.join(".trackfail").join("frames")
}

/// Limits on decoding a video.
#[derive(Debug, Clone, Copy)]
pub struct VideoLimits {
    /// Time for decoding.
    pub time: Duration,
    /// Number of frames.
    pub frames: u32,
    /// Bytes of all frames together, as PNG files.
    pub bytes: u64,
    /// Whether damage ends the decoding; else ffmpeg makes up what is missing.
    pub damage_ends_it: bool,
}

/// VideoLimits far above the longest clip of any suite (CAVIAR: two minutes, half a GiB). The bytes of a suite's video are
/// pinned, so that its flaws are part of the data.
pub const DEFAULT_LIMITS: VideoLimits =
    VideoLimits { time: Duration::from_secs(3600), frames: 100_000, bytes: 64 << 30, damage_ends_it: false };

/// A range of a video's frames.
#[derive(Debug)]
pub struct Video {
    path: PathBuf,
    decoded: PathBuf,
    range: (u32, u32),
    files: OnceLock<ImageFiles>,
}

impl Video {
    /// Frames `range` of the video at `path`, numbered from 1, to be decoded below the folder `decoded`.
    pub fn new(path: PathBuf, decoded: PathBuf, range: (u32, u32)) -> Self {
        Self { path, decoded, range, files: OnceLock::new() }
    }

    /// The video file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The image files of the range in order, decoded if they are not there yet.
    ///
    /// # Errors
    /// No ffmpeg, a file it cannot decode, a limit, or a video with fewer frames than the range.
    pub fn files(&self) -> Result<&ImageFiles, DatasetError> {
        if let Some(files) = self.files.get() {
            return Ok(files);
        }
        let folder = self.decoded.join(file_digest(&self.path)?);
        decode(&self.path, &folder, OsStr::new("ffmpeg"), DEFAULT_LIMITS, &|| false)?;
        let (first, last) = self.range;
        let files: Vec<PathBuf> = (first..=last).map(|n| folder.join(frame_name(n))).collect();
        if let Some(absent) = files.iter().position(|f| !f.is_file()) {
            let message = format!(
                "frame {} is not in it, frames {first} to {last} are needed; fetch the video again, or delete {} \
                 if something in there was deleted",
                first as usize + absent,
                folder.display()
            );
            return Err(DatasetError::content(&self.path, message));
        }
        Ok(self.files.get_or_init(|| files.into()))
    }
}

/// Decodes all frames of a user's video into a folder that is not there yet, and returns their files in order. It ends
/// soon after `is_stopped` says so.
///
/// # Errors
/// No ffmpeg, a file it cannot decode, damage, a limit, or an interruption.
pub fn decode_all(
    video: &Path,
    folder: &Path,
    is_stopped: &dyn Fn() -> bool,
) -> Result<Vec<PathBuf>, DatasetError> {
    let limits = VideoLimits { damage_ends_it: true, ..DEFAULT_LIMITS };
    decode(video, folder, OsStr::new("ffmpeg"), limits, is_stopped)?;
    let files = (1..=DEFAULT_LIMITS.frames).map(|n| folder.join(frame_name(n)));
    Ok(files.take_while(|file| file.is_file()).collect())
}

/// Mean number of frames in a second, as `ffprobe` reads it; `None` where the video or the program does not tell.
pub fn rate(video: &Path) -> Option<f64> {
    let mut url = OsString::from("file:");
    url.push(video.canonicalize().ok()?);
    let mut command = Command::new("ffprobe");
    command
        .args(["-v", "error", "-protocol_whitelist", "file", "-format_whitelist", FORMATS])
        .args(["-select_streams", "v:0", "-show_entries", "stream=avg_frame_rate", "-of", "csv=p=0"])
        .arg(url)
        .stdin(Stdio::null());
    let output = command.output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    let (frames, seconds) = text.lines().next()?.trim().trim_end_matches(',').split_once('/')?;
    let rate = frames.parse::<f64>().ok()? / seconds.parse::<f64>().ok()?;
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

fn frame_name(n: u32) -> String {
    format!("{n:06}.png")
}

/// Decodes all frames of `video` into `folder` unless that is there.
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
    let io = |path: &Path| {
        let path = path.to_path_buf();
        move |e| DatasetError::io(&path, e)
    };
    std::fs::create_dir_all(parent).map_err(io(parent))?;
    leftover::sweep(parent, DECODING);
    let mut fresh = tempfile::Builder::new();
    #[cfg(unix)]
    fresh.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
    let fresh = fresh.prefix(DECODING).tempdir_in(parent).map_err(io(parent))?;
    let input = video.canonicalize().map_err(io(video))?;
    // Older versions (before 5.1) know the option under another name; newer ones may lose that.
    for option in ["-fps_mode", "-vsync"] {
        let child = command(program, &input, fresh.path(), option, limits).spawn().map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => DatasetError::content(
                video,
                "its frames have to be decoded, but there is no `ffmpeg` on the PATH; install it (Debian, Ubuntu: \
                 apt install ffmpeg; macOS: brew install ffmpeg; Windows: winget install ffmpeg)",
            ),
            _ => DatasetError::content(video, format!("ffmpeg does not start: {e}")),
        })?;
        match wait(child, fresh.path(), limits, is_stopped) {
            Ok(()) => break,
            Err(message) if option == "-fps_mode" && message.contains("fps_mode") => continue,
            Err(message) => return Err(DatasetError::content(video, message)),
        }
    }
    if !fresh.path().join(frame_name(1)).is_file() {
        return Err(DatasetError::content(video, "ffmpeg found no frame in it; fetch the file again"));
    }
    if fresh.path().join(frame_name(limits.frames.saturating_add(1))).is_file() {
        let message = format!("more than {} frames, which no sequence has", limits.frames);
        return Err(DatasetError::content(video, message));
    }
    match std::fs::rename(fresh.path(), folder) {
        // Another process was faster.
        Err(_) if folder.is_dir() => Ok(()),
        done => done.map_err(io(folder)),
    }
}

fn command(program: &OsStr, input: &Path, output: &Path, every_frame: &str, limits: VideoLimits) -> Command {
    let mut url = OsString::from("file:");
    url.push(input);
    let mut command = Command::new(program);
    command
        .args(["-nostdin", "-hide_banner", "-loglevel", "error"])
        .args(if limits.damage_ends_it { &["-xerror", "-err_detect", "explode"][..] } else { &[] })
        .args(["-protocol_whitelist", "file", "-format_whitelist", FORMATS, "-i"])
        .arg(url)
        .args(["-map", "0:v:0", every_frame, "passthrough", "-pix_fmt", "rgb24"])
        .args(["-sws_flags", "bicubic+accurate_rnd+full_chroma_int+bitexact"])
        .args(["-frames:v", &limits.frames.saturating_add(1).to_string()])
        // A pattern relative to the working folder: a `%` in the folder's own path would be one too.
        .args(["-c:v", "png", "-f", "image2", "-start_number", "1", "%06d.png"])
        .current_dir(output)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command
}

/// Waits for the end, within the limits; what it said on stderr is in the message of a failure.
fn wait(
    mut child: Child,
    output: &Path,
    limits: VideoLimits,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(), String> {
    let stderr = child.stderr.take();
    let said = std::thread::spawn(move || stderr.map(last_words).unwrap_or_default());
    let until = Instant::now() + limits.time;
    let outcome = loop {
        match child.try_wait() {
            Ok(Some(status)) if status.success() => break Ok(()),
            Ok(Some(_)) if limits.damage_ends_it && output.join(frame_name(1)).is_file() => {
                break Err(
                    "the video is damaged, its frames would be wrong; take a whole copy of it, or the \
                           frames that are good as images. ffmpeg says"
                        .to_string(),
                );
            }
            Ok(Some(status)) if limits.damage_ends_it => {
                break Err(format!("no video, or a damaged one; ffmpeg ends with {status}"));
            }
            Ok(Some(status)) => break Err(format!("ffmpeg ends with {status}")),
            Err(e) => break Err(format!("ffmpeg: {e}")),
            Ok(None) if is_stopped() => break Err("interrupted".to_string()),
            Ok(None) if Instant::now() > until => {
                break Err(format!("ffmpeg takes more than {} s", limits.time.as_secs()));
            }
            Ok(None) if bytes_in(output) > limits.bytes => {
                break Err(format!("the frames take more than {} bytes", limits.bytes));
            }
            Ok(None) => std::thread::sleep(Duration::from_millis(100)),
        }
    };
    if outcome.is_err() {
        // It may have ended by itself meanwhile; then there is nothing to end.
        let _ = child.kill();
        let _ = child.wait();
    }
    let said = said.join().unwrap_or_default();
    outcome.map_err(|message| match said.trim() {
        "" => message,
        said => format!("{message}: {said}"),
    })
}

/// The end of a stream, at most 2000 bytes, without control characters.
fn last_words(mut stream: impl Read) -> String {
    const KEPT: usize = 2000;
    let mut kept = Vec::new();
    let mut block = [0; 4096];
    while let Ok(n @ 1..) = stream.read(&mut block) {
        kept.extend_from_slice(block.get(..n).unwrap_or_default());
        kept.drain(..kept.len().saturating_sub(KEPT));
    }
    let printable = |c: char| if c.is_control() { ' ' } else { c };
    String::from_utf8_lossy(&kept).chars().map(printable).collect()
}

fn bytes_in(folder: &Path) -> u64 {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    files.filter_map(|f| f.metadata().ok()).map(|m| m.len()).sum()
}

#[cfg(test)]
mod tests;
