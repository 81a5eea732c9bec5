use super::*;
use crate::format::{SequenceOptions, cvml};
use crate::{Frames, Sequence};
use trackfail_testing::needs;

/// ffmpeg's test picture, 64x48, `frames` of them.
fn testsrc(frames: u32, output: &[&str]) -> Vec<u8> {
    let frames = frames.to_string();
    let done = Command::new("ffmpeg")
        .args([
            "-nostdin",
            "-v",
            "error",
            "-f",
            "lavfi",
            "-i",
            "testsrc=size=64x48:rate=25",
            "-frames:v",
            &frames,
        ])
        .args(output)
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    done.stdout
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
        name: "clip".into(),
        numbering: crate::Numbering { first: 3, official: (1, 7) },
        truth: vec![None; 4],
        attributes: Vec::new(),
        frame_attributes: Vec::new(),
        digest: Default::default(),
        frames: Frames::Video(std::sync::Arc::new(Video::new(path.clone(), cache(root.path()), (3, 6)))),
    };
    assert_eq!(s.size().unwrap(), (64, 48));
    for (t, expected) in pixels.chunks(64 * 48 * 3).skip(2).take(4).enumerate() {
        assert!(s.frame(t).unwrap().bytes() == expected, "frame {t}");
    }
    assert!(matches!(s.frame(4), Err(DatasetError::NoFrame { .. })));
    let folder = cache(root.path()).join(file_digest(&path).unwrap());
    assert_eq!(count(&folder), 7);
    assert_eq!(count(&cache(root.path())), 1, "nothing else is left");
    // Decoded frames are not decoded again: a new handle gets by without a program.
    decode(&path, &folder, OsStr::new("no-such-ffmpeg"), DEFAULT_LIMITS, &|| false).unwrap();
    std::fs::remove_file(folder.join("000004.png")).unwrap();
    let again = Video::new(path, cache(root.path()), (3, 6)).files().unwrap_err().to_string();
    assert!(again.contains("frame 4 is not in it"), "{again}");
}

#[needs(ffmpeg)]
#[test]
fn a_clip_with_its_annotation_is_a_sequence() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("caviar/Walk2");
    std::fs::create_dir_all(&folder).unwrap();
    mpeg(&folder.join("Walk2.mpg"), 20);
    let frame = |n: u32| {
        format!(
            "<frame number=\"{n}\"><objectlist><object id=\"0\"><box xc=\"{n}\" yc=\"9\" w=\"4\" h=\"6\"/>\
             </object></objectlist></frame>"
        )
    };
    let frames: String = (5..20).map(frame).collect();
    std::fs::write(folder.join("wk2gt.xml"), format!("<dataset>{frames}</dataset>")).unwrap();
    let loaded = crate::suite::Catalog::default().suite("caviar").unwrap().load(&[root.path().to_path_buf()]);
    let [walk] = loaded.sequences.as_slice() else { panic!("{:?}", loaded.broken) };
    assert_eq!((walk.len(), walk.number(0)), (15, 6));
    let last = walk.frame(14).unwrap();
    assert_eq!((last.width(), last.height()), (64, 48));

    let short = folder.join("Walk2.mpg");
    mpeg(&root.path().join("short.mpg"), 10);
    std::fs::rename(root.path().join("short.mpg"), short).unwrap();
    let options = SequenceOptions { decoded: cache(root.path()), ..Default::default() };
    let error = cvml::load(&folder, &options).unwrap().frame(0).unwrap_err().to_string();
    assert!(error.contains("frame 11 is not in it, frames 6 to 20 are needed"), "{error}");
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
        decode(&path, &folder, OsStr::new("ffmpeg"), DEFAULT_LIMITS, &|| false).unwrap();
        assert_eq!(count(&folder), 2, "{name}");
    }
}

#[test]
fn no_ffmpeg_says_what_to_install() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("a.mpg");
    std::fs::write(&path, "x").unwrap();
    let folder = root.path().join("frames/x");
    let error = decode(&path, &folder, OsStr::new("no-such-ffmpeg"), DEFAULT_LIMITS, &|| false)
        .unwrap_err()
        .to_string();
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
        let error =
            decode(&path, &folder, OsStr::new("ffmpeg"), DEFAULT_LIMITS, &|| false).unwrap_err().to_string();
        assert!(error.contains("a.mpg: ffmpeg ends with") && error.len() > 60, "{error}");
        assert!(!folder.exists());
    }
    assert_eq!(count(folder.parent().unwrap()), 0, "nothing is left");
}

#[needs(ffmpeg)]
#[test]
fn damage_ends_the_decoding_of_a_users_video() {
    let root = tempfile::tempdir().unwrap();
    let codecs = [("a.avi", "mjpeg"), ("a.mp4", "mpeg4"), ("a.mpg", "mpeg2video"), ("a.mkv", "ffv1")];
    for (name, codec) in codecs {
        let path = root.path().join(name);
        testsrc(20, &["-c:v", codec, "-bf", "0", &format!("file:{}", path.display())]);
        let whole = decode_all(&path, &root.path().join(codec), &|| false).unwrap();
        assert_eq!(whole.len(), 20, "{name}");
    }
    // Zeros inside of a frame near the middle, and of the first.
    let path = root.path().join("a.avi");
    let whole = std::fs::read(&path).unwrap();
    let first = whole.windows(2).position(|w| w == [0xFF, 0xDA]).unwrap() + 20;
    for (place, words) in [(whole.len() / 2, "the video is damaged"), (first, "no video, or a damaged one")] {
        let mut bytes = whole.clone();
        bytes[place..place + 600].fill(0);
        std::fs::write(&path, bytes).unwrap();
        let folder = root.path().join("damaged");
        let error = decode_all(&path, &folder, &|| false).unwrap_err().to_string();
        assert!(error.contains(&format!("a.avi: {words}")), "{error}");
        assert!(!folder.exists());
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
    let few = with(VideoLimits { frames: 9, ..DEFAULT_LIMITS }).unwrap_err();
    assert!(few.contains("more than 9 frames"), "{few}");
    assert_eq!(count(folder.parent().unwrap()), 0);
    with(VideoLimits { frames: 10, ..DEFAULT_LIMITS }).unwrap();
    assert_eq!(count(&folder), 10);
}

/// A program that writes and never ends stands in for a decoder that does.
#[cfg(unix)]
#[test]
fn time_and_bytes_are_limited() {
    let out = tempfile::tempdir().unwrap();
    let sleep = || {
        let mut command = Command::new("sleep");
        command.arg("600").stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let time = wait(sleep(), out.path(), VideoLimits { time: Duration::ZERO, ..DEFAULT_LIMITS }, &|| false)
        .unwrap_err();
    assert!(time.contains("more than 0 s"), "{time}");
    std::fs::write(out.path().join("000001.png"), [0; 100]).unwrap();
    let bytes =
        wait(sleep(), out.path(), VideoLimits { bytes: 99, ..DEFAULT_LIMITS }, &|| false).unwrap_err();
    assert!(bytes.contains("more than 99 bytes"), "{bytes}");
}

#[test]
fn the_end_of_a_long_message_is_kept() {
    let long = format!("{}\u{1b}[31mlast", "x".repeat(100_000));
    let kept = last_words(long.as_bytes());
    assert!(kept.len() == 2000 && kept.ends_with("x [31mlast"), "{}", kept.len());
}
