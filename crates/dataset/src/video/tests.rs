use super::stream::read_picture;
use super::*;
use crate::format::cvml;
use crate::lock::Entry;
use crate::user_frames::without_frames;
use crate::{Frames, Sequence};
use std::sync::Arc;
use trackfail_core::image::ImageError;
use trackfail_testing::{assert_says, needs, put};

/// `frames` frames of ffmpeg's test picture (64x48), encoded with the options `output`.
fn testsrc(frames: u32, output: &[&str]) -> Vec<u8> {
    let input = format!("-nostdin -v error -f lavfi -i testsrc=size=64x48:rate=25 -frames:v {frames}");
    let done = Command::new("ffmpeg").args(input.split(' ')).args(output).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    done.stdout
}

/// Decodes a video into a folder with a program and returns the error as text.
fn decoded(path: &Path, folder: &Path, program: impl AsRef<OsStr>) -> Result<(), String> {
    decode(path, folder, program.as_ref(), DEFAULT_LIMITS, &|| false).map_err(|e| e.to_string())
}

fn mpeg(path: &Path, frames: u32) {
    testsrc(frames, &["-c:v", "mpeg2video", "-f", "mpeg", &format!("file:{}", path.display())]);
}

fn count(folder: &Path) -> usize {
    std::fs::read_dir(folder).map_or(0, |files| files.count())
}

// The oracle: `ffmpeg -f lavfi -i testsrc=... -f rawvideo -pix_fmt rgb24 -`, the pictures that were encoded
// without loss.
#[needs(ffmpeg)]
#[test]
fn frames_of_a_lossless_video_are_its_pixels() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("clip.mkv");
    testsrc(7, &["-c:v", "ffv1", "-pix_fmt", "bgr0", path.to_str().unwrap()]);
    let pixels = testsrc(7, &["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]);
    let s = Sequence {
        numbering: crate::Numbering { first: 3, official: (1, 7) },
        frames: Frames::Video(Arc::new(Video::new(path.clone(), cache(root.path()), (3, 6)))),
        ..without_frames("clip", 4)
    };
    assert_eq!(s.size().unwrap(), (64, 48));
    for (t, expected) in pixels.chunks(64 * 48 * 3).skip(2).take(4).enumerate() {
        assert!(s.frame(t).unwrap().bytes() == expected, "frame {t}");
    }
    assert_says(s.frame(4).unwrap_err(), "there is no frame 4");
    let folder = cache(root.path()).join(file_digest(&path).unwrap());
    assert_eq!(count(&folder), 7);
    assert_eq!(count(&cache(root.path())), 1, "nothing else is left");
    // Decoded frames are not decoded again: a new handle gets by without a program.
    decoded(&path, &folder, "no-such-ffmpeg").unwrap();
    std::fs::remove_file(folder.join("000004.png")).unwrap();
    assert_says(Video::new(path, cache(root.path()), (3, 6)).files().unwrap_err(), "frame 4 is not in it");
}

/// Opens a user's video.
fn opened(path: &Path) -> Result<VideoStream, DatasetError> {
    VideoStream::open(path, &|| false)
}

fn sequence(frames: Frames) -> Sequence {
    Sequence { frames, ..without_frames("clip", 40) }
}

// The oracle: the files that a suite's video is decoded into.
#[needs(ffmpeg)]
#[test]
fn frames_through_a_pipe_are_those_of_files() {
    let root = tempfile::tempdir().unwrap();
    for (name, codec, pixels) in
        [("a.mp4", "mpeg4", "yuv420p"), ("b.mkv", "ffv1", "yuv422p10"), ("c.avi", "ffv1", "gray")]
    {
        let path = root.path().join(name);
        testsrc(40, &["-c:v", codec, "-pix_fmt", pixels, path.to_str().unwrap()]);
        let files = Video::new(path.clone(), cache(root.path()), (1, 40));
        let files = sequence(Frames::Video(Arc::new(files)));
        let piped = sequence(Frames::Stream(Arc::new(opened(&path).unwrap())));
        assert_eq!(piped.size().unwrap(), files.size().unwrap());
        // In order, neighbours in another order, and back to frames that are no longer kept.
        for t in (0..40).chain([38, 39, 37, 3, 5, 4, 0, 39, 21]) {
            assert!(piped.frame(t).unwrap() == files.frame(t).unwrap(), "{name}, frame {t}");
        }
        assert_says(piped.frame(40).unwrap_err(), "there is no frame 40");
    }
}

#[needs(ffmpeg)]
#[test]
fn a_video_that_changes_after_it_was_counted_is_refused() {
    let root = tempfile::tempdir().unwrap();
    let (path, other) = (root.path().join("a.mpg"), root.path().join("b.mpg"));
    for frames in [10, 30] {
        mpeg(&path, 20);
        let video = opened(&path).unwrap();
        mpeg(&other, frames);
        std::fs::rename(&other, &path).unwrap();
        assert_says(video.frame(19).unwrap_err(), "a.mpg: it has changed since its frames were counted");
        std::fs::write(&path, "no video").unwrap();
        assert_says(video.frame(0).unwrap_err(), "a.mpg: this is no video that ffmpeg reads");
        std::fs::remove_file(&path).unwrap();
    }
}

// The bytes are those of the definition of PPM.
#[test]
fn pictures_that_are_whole_and_not_too_large_are_read() {
    let read = |mut bytes: &[u8]| read_picture(&mut bytes);
    let mut two: &[u8] = b"P6\n1 2\n255\nabcdefP6\n1 1\n255\nxyz";
    let pictures = std::iter::from_fn(|| read_picture(&mut two)).map(|p| p.unwrap().bytes().to_vec());
    assert_eq!(pictures.collect::<Vec<_>>(), [b"abcdef".to_vec(), b"xyz".to_vec()]);
    for large in ["P6\n16385 1\n255\n", "P6\n16000 16000\n255\n"] {
        assert!(matches!(read(large.as_bytes()), Some(Err(ImageError::TooLarge { .. }))), "{large}");
    }
    for size in
        ["0 1\n255\n", "-1 1\n255\nabc", "99999999999 1\n255\nabc", "", "1 1\n255\nab", "1 1\n65535\nabcdef"]
    {
        assert!(read(format!("P6\n{size}").as_bytes()).is_none(), "{size}");
    }
    assert!(read(b"").is_none() && read(b"P5\n1 1\n255\nabc").is_none());
    assert!(read(&[b'P'; 1 << 10]).is_none() && read(&[0xFF; 1 << 10]).is_none());
}

#[needs(ffmpeg)]
#[test]
fn a_clip_with_its_annotation_is_a_sequence() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("caviar/Walk2");
    let one = r#"<frame number="N"><objectlist><object id="0"><box xc="N" yc="9" w="4" h="6"/></object></objectlist></frame>"#;
    let frames: String = (5..20).map(|n| one.replace('N', &n.to_string())).collect();
    put(&folder, "wk2gt.xml", format!("<dataset>{frames}</dataset>"));
    mpeg(&folder.join("Walk2.mpg"), 20);
    let loaded = crate::suite::Catalog::default().suite("caviar").unwrap().load(&[root.path().to_path_buf()]);
    let [walk] = loaded.sequences.as_slice() else { panic!("{:?}", loaded.broken) };
    assert_eq!((walk.len(), walk.number(0)), (15, 6));
    let last = walk.frame(14).unwrap();
    assert_eq!((last.width(), last.height()), (64, 48));

    mpeg(&root.path().join("short.mpg"), 10);
    std::fs::rename(root.path().join("short.mpg"), folder.join("Walk2.mpg")).unwrap();
    let entry = Entry { folder: "caviar/Walk2".into(), ..Entry::default() };
    let error = cvml::load(root.path(), &entry).unwrap().frame(0).unwrap_err();
    assert_says(error, "frame 11 is not in it, frames 6 to 20 are needed");
}

#[needs(ffmpeg)]
#[test]
fn names_are_no_options_protocols_or_patterns() {
    let root = tempfile::tempdir().unwrap();
    let odd = root.path().join("%03d -i");
    std::fs::create_dir_all(&odd).unwrap();
    for (k, name) in
        ["-i.mpg", "concat:a.mpg", "a%03d.mpg", "a b'\"$(x);.mpg", "http:x.mpg"].iter().enumerate()
    {
        let path = odd.join(name);
        mpeg(&path, 2);
        let folder = odd.join(k.to_string());
        decoded(&path, &folder, "ffmpeg").unwrap();
        assert_eq!(count(&folder), 2, "{name}");
    }
}

#[test]
fn no_ffmpeg_says_what_to_install() {
    let root = tempfile::tempdir().unwrap();
    let path = put(root.path(), "a.mpg", "x");
    let folder = root.path().join("frames/x");
    let error = decoded(&path, &folder, "no-such-ffmpeg").unwrap_err();
    assert!(error.contains("a.mpg") && error.contains("install"), "{error}");
    assert_eq!(count(folder.parent().unwrap()), 0);
}

#[needs(ffmpeg)]
#[test]
fn what_is_no_video_is_an_error_with_what_ffmpeg_says() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("a.mpg");
    let folder = root.path().join("frames/x");
    // A playlist would have other files read; its format is not among those opened.
    for content in
        ["", "no video\n", "#EXTM3U\n#EXTINF:1,\n/etc/hostname\n", "ffconcat version 1.0\nfile b.mpg\n"]
    {
        std::fs::write(&path, content).unwrap();
        let error = decoded(&path, &folder, "ffmpeg").unwrap_err();
        let words = "a.mpg: this is no video that ffmpeg reads; fetch the file again (ffmpeg: ";
        // What it says neither names the file again nor spreads over lines.
        assert!(error.contains(words) && error.matches("a.mpg").count() == 1, "{error}");
        assert!(!error.contains('\n') && !error.contains('\u{fffd}'), "{error}");
        assert!(!folder.exists());
    }
    assert_eq!(count(folder.parent().unwrap()), 0, "nothing is left");
}

// The lines are those of ffmpeg 5.1 and 7.1 for `ffmpeg -loglevel error -i file:/tmp/x.txt`, and of a damaged file.
#[test]
fn the_last_line_of_ffmpeg_is_the_reason() {
    let invalid = "Invalid data found when processing input";
    for (said, expected) in [
        ("file:/tmp/x: y.txt: Invalid data found when processing input\n", Some(invalid)),
        (
            "[in#0 @ 0x5581] Error opening input: Invalid data\nError opening input file file:/tmp/x.txt.\n\
             Error opening input files: Invalid data found when processing input\n\n",
            Some("Error opening input files: Invalid data found when processing input"),
        ),
        ("[mjpeg @ 0x5581] overread 8\r\n", Some("overread 8")),
        ("[half of a line", Some("[half of a line")),
        ("\u{1b}[31mred", Some("\u{fffd}[31mred")),
        (" \n", None),
        ("", None),
    ] {
        assert_eq!(reason(said).as_deref(), expected, "{said:?}");
    }
    assert_eq!(reason(&"x".repeat(4096)).unwrap().len(), MAX_REASON + 3);
}

/// Shell script that stands in for ffmpeg.
#[cfg(unix)]
fn script(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("fake-ffmpeg");
    trackfail_testing::script(&path, text);
    path
}

#[cfg(unix)]
#[test]
fn what_ffmpeg_leaves_running_is_not_waited_for() {
    let root = tempfile::tempdir().unwrap();
    let path = put(root.path(), "a.mpg", "x");
    let program = script(root.path(), "echo > 000001.png; sleep 1000 & exit 0");
    let folder = root.path().join("frames/x");
    decoded(&path, &folder, program).unwrap();
    assert_eq!(count(&folder), 1);
    // The same with a child that is waited for, until the user interrupts.
    let program = script(root.path(), "echo > 000001.png; sleep 1000; exit 0");
    let other = root.path().join("frames/y");
    let began = || count(&root.path().join("frames")) == 2;
    let error = decode(&path, &other, program.as_os_str(), DEFAULT_LIMITS, &began).unwrap_err().to_string();
    assert!(error.ends_with("a.mpg: interrupted"), "{error}");
    assert_eq!(count(&root.path().join("frames")), 1);
}

#[cfg(unix)]
#[test]
fn an_end_by_a_signal_is_no_damage() {
    let root = tempfile::tempdir().unwrap();
    let path = put(root.path(), "a.mpg", "x");
    let program = script(root.path(), "echo > 000001.png; kill -s KILL $$");
    let limits = VideoLimits { damage_ends_it: true, ..DEFAULT_LIMITS };
    let ended = decode(&path, &root.path().join("frames"), program.as_os_str(), limits, &|| false);
    assert_says(ended.unwrap_err(), "ffmpeg did not finish (signal: 9");
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_refused_before_ffmpeg_starts() {
    let root = tempfile::tempdir().unwrap();
    let pipe = root.path().join("a.mpg");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let socket = root.path().join("b.mpg");
    let _listens = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    let link = root.path().join("c.mpg");
    std::os::unix::fs::symlink(&pipe, &link).unwrap();
    for path in [pipe.as_path(), &socket, &link, Path::new("/dev/null")] {
        let error = opened(path).err().unwrap().to_string();
        assert!(error.contains(": not a file; frames are a video file"), "{error}");
        let frames = crate::user_frames::load(&[path.to_path_buf()], &|| false).unwrap_err().to_string();
        assert_eq!(frames, error);
    }
}

#[needs(ffmpeg)]
#[test]
fn damage_ends_the_decoding_of_a_users_video() {
    let root = tempfile::tempdir().unwrap();
    for (name, codec) in [("a.avi", "mjpeg"), ("a.mp4", "mpeg4"), ("a.mpg", "mpeg2video"), ("a.mkv", "ffv1")]
    {
        let path = root.path().join(name);
        testsrc(20, &["-c:v", codec, "-bf", "0", &format!("file:{}", path.display())]);
        assert_eq!(opened(&path).unwrap().frames(), 20, "{name}");
    }
    // Zeros inside of a frame near the middle, and of the first.
    let path = root.path().join("a.avi");
    let whole = std::fs::read(&path).unwrap();
    let first = whole.windows(2).position(|w| w == [0xFF, 0xDA]).unwrap() + 20;
    let no_video = "this is no video that ffmpeg reads, or a damaged one";
    for (place, words) in [(whole.len() / 2, "the video is damaged"), (first, no_video)] {
        let mut bytes = whole.clone();
        bytes[place..place + 600].fill(0);
        std::fs::write(&path, bytes).unwrap();
        assert_says(opened(&path).err().unwrap(), format!("a.avi: {words}"));
    }
}

#[needs(ffmpeg)]
#[test]
fn limits_end_it_and_leave_nothing() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("a.mpg");
    mpeg(&path, 10);
    let folder = root.path().join("frames/x");
    let with =
        |limits| decode(&path, &folder, OsStr::new("ffmpeg"), limits, &|| false).map_err(|e| e.to_string());
    assert_says(with(VideoLimits { frames: 9, ..DEFAULT_LIMITS }).unwrap_err(), "more than 9 frames");
    assert_eq!(count(folder.parent().unwrap()), 0);
    with(VideoLimits { frames: 10, ..DEFAULT_LIMITS }).unwrap();
    assert_eq!(count(&folder), 10);
}

/// The stand-in for ffmpeg writes without end.
#[cfg(unix)]
#[test]
fn time_and_bytes_are_limited() {
    let out = tempfile::tempdir().unwrap();
    let sleep = |limits| {
        let mut command = Command::new("sleep");
        command.arg("600");
        run(command, out.path(), limits, &|| false).unwrap().status.unwrap_err()
    };
    assert_says(sleep(VideoLimits { time: Duration::ZERO, ..DEFAULT_LIMITS }), "more than 0 s");
    std::fs::write(out.path().join("000001.png"), [0; 100]).unwrap();
    assert_says(sleep(VideoLimits { bytes: 99, ..DEFAULT_LIMITS }), "more than 99 bytes");
}
