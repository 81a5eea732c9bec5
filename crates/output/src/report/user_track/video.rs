//! Encodes frames as a video file, by `ffmpeg`.

use crate::user_file;
use std::cell::Cell;
use std::ffi::OsString;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};
use trackfail_core::image::Frame;
use trackfail_dataset::guarded::Guarded;
use trackfail_dataset::leftover::TemporaryFolder;
use trackfail_dataset::text::visible;
use trackfail_engine::limits::Interrupted;
use trackfail_engine::store::{self, StoreError};

/// Endings of video files, with ffmpeg's names of their formats.
pub const CONTAINERS: [(&str, &str); 4] =
    [("mp4", "mp4"), ("mov", "mov"), ("mkv", "matroska"), ("avi", "avi")];

/// Encoders in the order in which they are tried. All builds of ffmpeg have the second one.
const ENCODERS: [(&str, &[&str]); 2] =
    [("libx264", &["-preset", "veryfast", "-crf", "20"]), ("mpeg4", &["-q:v", "3"])];

/// Most frames that wait for ffmpeg.
const MAX_QUEUED: usize = 4;
/// Longest wait until ffmpeg takes a frame, and until it ends after the last one.
const PATIENCE: Duration = Duration::from_secs(600);

/// Reason why a video cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum VideoError<E: std::error::Error + 'static> {
    /// ffmpeg is not installed or cannot be started.
    #[error(
        "{0}: there is no `ffmpeg` on the PATH, which makes videos; install it (Debian, Ubuntu: apt install ffmpeg; macOS: \
         brew install ffmpeg; Windows: winget install ffmpeg), or name a folder for PNG files"
    )]
    NoFfmpeg(String),
    /// ffmpeg refuses the frames or the format: path of the video file, and text from the stderr of ffmpeg.
    #[error("{0}: ffmpeg: {1}")]
    Ffmpeg(String, String),
    /// The file cannot be written to.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A frame cannot be made.
    #[error(transparent)]
    Frame(E),
    /// The user interrupted.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Format of a video file, by its name; `None` if the name is not that of a video.
pub fn container(path: &Path) -> Option<&'static str> {
    let end = path.extension()?.to_ascii_lowercase();
    CONTAINERS.into_iter().find(|(known, _)| end == *known).map(|(_, format)| format)
}

/// Writes `count` frames of one size, `frame(t)` from 0 on, as a video of `rate` frames per second. A regular
/// file is replaced when the video is complete; a device, pipe or link is written to. The call ends soon
/// after `is_stopped` returns true.
///
/// # Errors
/// See [`VideoError`].
pub fn write<E: std::error::Error + Send + 'static>(
    path: &Path,
    rate: f64,
    count: usize,
    frame: impl Fn(usize) -> Result<Frame, E> + Sync,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(), VideoError<E>> {
    let folder = TemporaryFolder::new_in(&std::env::temp_dir(), "trackfail-video-");
    let folder = folder.map_err(|e| StoreError::new(&std::env::temp_dir(), e))?;
    let encoded = folder.path().join("video");
    let format = container(path).unwrap_or("mp4");
    let first = frame(0).map_err(VideoError::Frame)?;
    let size = format!("{}x{}", first.width(), first.height());
    let mut url = OsString::from("file:");
    url.push(&encoded);
    let shown = path.display().to_string();
    let mut message = String::new();
    for (encoder, options) in ENCODERS {
        let mut command = command(&size, rate, format);
        command.args(["-c:v", encoder, "-pix_fmt", "yuv420p"]).args(options).args(["-f", format]).arg(&url);
        match encode(command, folder.path(), &shown, count, &frame, is_stopped)? {
            None => return Ok(user_file::write(path, &store::read(&encoded)?)?),
            Some(refused) => message = refused,
        }
        // Another encoder helps only where this one is not built in.
        if !message.contains(encoder) {
            break;
        }
    }
    Err(VideoError::Ffmpeg(shown, message))
}

/// Command up to the choice of encoder. It uses one thread, because the bytes would depend on the number of
/// threads.
fn command(size: &str, rate: f64, format: &str) -> Command {
    let mut command = Command::new("ffmpeg");
    command
        .args(["-hide_banner", "-loglevel", "error", "-y", "-protocol_whitelist", "file,pipe"])
        .args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", &rate.to_string()])
        .args(["-i", "pipe:0", "-threads", "1", "-fflags", "+bitexact", "-flags:v", "+bitexact"])
        // The color planes have half the sides.
        .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"]);
    if ["mp4", "mov"].contains(&format) {
        command.args(["-movflags", "+faststart"]);
    }
    command
}

/// Sends all frames to a program and waits for its end. The error has its output.
fn encode<E: std::error::Error + Send + 'static>(
    mut command: Command,
    folder: &Path,
    shown: &str,
    count: usize,
    frame: &(impl Fn(usize) -> Result<Frame, E> + Sync),
    is_stopped: &dyn Fn() -> bool,
) -> Result<Option<String>, VideoError<E>> {
    let not_started = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::NotFound => VideoError::NoFfmpeg(shown.to_string()),
        _ => VideoError::Ffmpeg(shown.to_string(), e.to_string()),
    };
    command.current_dir(folder.parent().unwrap_or(folder));
    let mut program =
        Guarded::start(command, [Stdio::piped(), Stdio::null()], Some(folder)).map_err(not_started)?;
    let (frames, queue) = sync_channel::<Frame>(MAX_QUEUED);
    let stdin = program.stdin();
    // It may not read what it is sent, which this thread alone waits for. An encoder that refuses closes its pipe.
    std::thread::spawn(move || {
        let Some(mut stdin) = stdin else { return };
        while queue.recv().is_ok_and(|frame| stdin.write_all(frame.bytes()).is_ok()) {}
    });
    let given = &AtomicUsize::new(0);
    let last = Cell::new((0, Instant::now()));
    let check = || {
        let given = given.load(Ordering::Relaxed);
        if last.get().0 != given {
            last.set((given, Instant::now()));
        }
        match is_stopped() {
            true => Err(Some(Interrupted)),
            false if last.get().1.elapsed() > PATIENCE => Err(None),
            false => Ok(()),
        }
    };
    let (ended, made) = std::thread::scope(|scope| {
        let maker = scope.spawn(move || -> Result<(), E> {
            for t in 0..count {
                if frames.send(frame(t)?).is_err() {
                    break;
                }
                given.fetch_add(1, Ordering::Relaxed);
            }
            Ok(())
        });
        (program.wait(check), maker.join())
    });
    made.unwrap_or_else(|panic| std::panic::resume_unwind(panic)).map_err(VideoError::Frame)?;
    match ended.map_err(not_started)? {
        Err(Some(interrupted)) => Err(interrupted.into()),
        Err(None) => Ok(Some(format!("it does not go on for {} s", PATIENCE.as_secs()))),
        Ok(status) if status.success() => Ok(None),
        Ok(status) => Ok(Some(match visible(program.stderr().trim()) {
            said if said.is_empty() => format!("it ends with {status}"),
            said => said,
        })),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_dataset::{DatasetError, user_frames};
    use trackfail_testing::needs;

    fn frame(t: usize) -> Result<Frame, DatasetError> {
        Ok(Frame::from_fn(65, 49, |x, y| [(3 * x) as u8, (5 * y) as u8, (40 * t) as u8]))
    }

    #[needs(ffmpeg)]
    #[test]
    fn a_written_video_has_its_frames() {
        let root = tempfile::tempdir().unwrap();
        for (name, end) in [("a.mp4", 1), ("b.mkv", 6), ("c.avi", 6), ("d.mov", 6)] {
            let path = root.path().join(name);
            write(&path, 12.5, end, frame, &|| false).unwrap();
            let read = user_frames::load(&[path], &|| false).unwrap();
            assert_eq!(read.sequence.len(), end, "{name}");
            // Odd sides have a row more.
            assert_eq!(read.sequence.size().unwrap(), (66, 50));
            assert!((read.rate.unwrap() - 12.5).abs() < 1e-6, "{name} {:?}", read.rate);
            let (seen, meant) = (read.sequence.frame(end - 1).unwrap(), frame(end - 1).unwrap());
            let far = |c: usize| seen.pixel(30, 20)[c].abs_diff(meant.pixel(30, 20)[c]);
            assert!((0..3).all(|c| far(c) < 24), "{name} {:?} {:?}", seen.pixel(30, 20), meant.pixel(30, 20));
        }
        let again = root.path().join("again.mp4");
        write(&again, 12.5, 1, frame, &|| false).unwrap();
        assert_eq!(std::fs::read(&again).unwrap(), std::fs::read(root.path().join("a.mp4")).unwrap());
    }

    #[needs(ffmpeg)]
    #[test]
    fn what_stops_a_video_leaves_the_file_as_it_was() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("a.mp4");
        std::fs::write(&path, "as it was").unwrap();
        let broken = |t| if t < 3 { frame(t) } else { Err(DatasetError::Unknown("S".into())) };
        assert!(matches!(write(&path, 25.0, 6, broken, &|| false), Err(VideoError::Frame(_))));
        let message = write(&path, 0.0, 6, frame, &|| false).unwrap_err().to_string();
        assert!(message.contains("a.mp4: ffmpeg: "), "{message}");
        let absent = encode(Command::new("no-such-ffmpeg"), root.path(), "a.mp4", 6, &frame, &|| false);
        let message = absent.unwrap_err().to_string();
        assert!(message.contains("install it") && message.contains("folder for PNG"), "{message}");
        assert_eq!(std::fs::read(&path).unwrap(), b"as it was");
        let message =
            write(&root.path().join("none/a.mp4"), 25.0, 1, frame, &|| false).unwrap_err().to_string();
        assert!(message.contains("there is no folder"), "{message}");
    }

    #[cfg(unix)]
    #[test]
    fn a_program_that_takes_no_frames_is_not_waited_for_after_an_interruption() {
        let root = tempfile::tempdir().unwrap();
        let program = root.path().join("ffmpeg");
        trackfail_testing::script(&program, "sleep 1000");
        for count in [1, 100] {
            let asked = std::cell::Cell::new(0);
            let is_stopped = || asked.replace(asked.get() + 1) > 3;
            let outcome = encode(Command::new(&program), root.path(), "a.mp4", count, &frame, &is_stopped);
            assert!(matches!(outcome, Err(VideoError::Interrupted(_))), "{count}");
        }
    }

    #[test]
    fn names_tell_the_format() {
        assert_eq!(container(Path::new("x/A.MP4")), Some("mp4"));
        assert_eq!(container(Path::new("a.mkv")), Some("matroska"));
        assert_eq!(container(Path::new("folder")), None);
        assert_eq!(container(Path::new("a.gif")), None);
    }
}
