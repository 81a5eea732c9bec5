//! Frames as a user names them: a folder of images, a pattern of their names, image files one by one, or a video.
//!
//! | given | frames | their numbers |
//! |---|---|---|
//! | a folder | its `.jpg` and `.png` files, or those of its folder `img`, as [`otb`] reads them | those in the names |
//! | a pattern with `*`, `?` or `[...]` | these files, in the order of all numbers in their names | those in the names if they follow each other, else from 1 on |
//! | several files in the order of their numbers, or in that of a shell, which gives `10.png` before `2.png` | the same | the same |
//! | several files in another order | these files, in the order given | from 1 on |
//! | another file | those of the video, which ffmpeg decodes | from 1 on |

use crate::files::{folder_name, is_image};
use crate::format::otb;
use crate::frame_order::{natural_order, numbered, shown};
use crate::video::{self, VideoStream};
use crate::{DatasetError, Frames, Numbering, Sequence};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Frames that a user named, without annotation.
#[derive(Debug, Default)]
pub struct UserFrames {
    /// The frames as a sequence.
    pub sequence: Sequence,
    /// Frames per second, if the frames are from a video that tells.
    pub rate: Option<f64>,
    /// Note for the user that the files stay in the order given, which is not that of their numbers.
    pub note: Option<String>,
}

/// Finds the frames that the user names. Reads no image, but decodes a video to its end, until `is_stopped`
/// returns true.
///
/// # Errors
/// A name that does not exist, no image among the files, two files of one number, a doubtful order, an absent
/// ffmpeg or a video that it cannot decode, and an interruption.
pub fn load(given: &[PathBuf], is_stopped: &dyn Fn() -> bool) -> Result<UserFrames, DatasetError> {
    match given {
        [folder] if folder.is_dir() => {
            let name = folder_name(folder);
            // Such a folder has its name from the layout of a dataset.
            let name = if name == "img" { folder_name(&folder.join("..")) } else { name };
            Ok(UserFrames { sequence: otb::load_frames(folder, name, None)?, ..UserFrames::default() })
        }
        [file] if file.exists() && !is_image(file) => {
            let stream = VideoStream::open(file, is_stopped)?;
            let rate = video::rate(file, is_stopped);
            let sequence = sequence(file, 1, stream.frames(), Frames::Stream(Arc::new(stream)));
            Ok(UserFrames { sequence, rate, ..UserFrames::default() })
        }
        [pattern] if !pattern.exists() && is_pattern(pattern) => {
            Ok(of_numbered(pattern, numbered(matching(pattern)?)?))
        }
        files => listed(files),
    }
}

/// Sequence of `frames` frames, numbered from 1, without any pixels.
pub fn without_frames(name: &str, frames: usize) -> Sequence {
    let numbering = Numbering { first: 1, official: (1, frames as u32) };
    Sequence { name: name.to_string(), numbering, truth: vec![None; frames], ..Sequence::default() }
}

/// True if a name has wildcard characters.
fn is_pattern(name: &Path) -> bool {
    name.as_os_str().as_encoded_bytes().iter().any(|b| b"*?[".contains(b))
}

/// Image files whose names fit a pattern.
fn matching(pattern: &Path) -> Result<Vec<PathBuf>, DatasetError> {
    let fault = |message: String| DatasetError::content(pattern, message);
    let text = pattern.to_str().ok_or_else(|| fault("a pattern has to be UTF-8 text".into()))?;
    let as_a_shell = glob::MatchOptions { require_literal_leading_dot: true, ..glob::MatchOptions::new() };
    let found =
        glob::glob_with(text, as_a_shell).map_err(|e| fault(format!("no pattern of file names: {e}")))?;
    let io = |e: glob::GlobError| {
        let path = e.path().to_path_buf();
        DatasetError::io(&path, e.into())
    };
    let files: Vec<PathBuf> = found.collect::<Result<_, _>>().map_err(io)?;
    let images: Vec<PathBuf> = files.into_iter().filter(|path| is_image(path)).collect();
    if images.is_empty() { Err(fault("no .jpg or .png file fits this pattern".into())) } else { Ok(images) }
}

/// Frames of image files given one by one, with a note if they stay in the order given. An order that a shell
/// writes for a pattern is replaced by that of the numbers; any other order is taken as intended.
fn listed(files: &[PathBuf]) -> Result<UserFrames, DatasetError> {
    let first = files.first().ok_or_else(|| DatasetError::content(Path::new("--frames"), "no file"))?;
    if let Some(other) = files.iter().find(|file| !is_image(file)) {
        // A file that is absent is told as such.
        std::fs::metadata(other).map_err(|e| DatasetError::io(other, e))?;
        let message = "one of several files of frames has to be a .jpg or .png file";
        return Err(DatasetError::content(other, message));
    }
    let natural = natural_order(files.to_vec());
    let is_natural = natural == files;
    if is_natural || is_of_a_shell(files) {
        match numbered(files.to_vec()) {
            // The user gives one of the orders that may be meant.
            Err(DatasetError::FrameOrder { .. }) if is_natural => {}
            images => return Ok(of_numbered(first, images?)),
        }
    }
    if let Some(twice) = natural.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(DatasetError::content(&twice[0], "a frame given twice; keep one"));
    }
    let names = shown(files.iter().take(3).map(PathBuf::as_path));
    let note = Some(format!("{} frames in the order given: {names}", files.len()));
    let sequence = sequence(first, 1, files.len(), Frames::Files(files.to_vec()));
    Ok(UserFrames { sequence, note, ..UserFrames::default() })
}

/// True if the files are ordered as shells sort names: byte by byte, or by letters and digits alone.
fn is_of_a_shell(files: &[PathBuf]) -> bool {
    let letters = |path: &PathBuf| -> String {
        let name = path.to_string_lossy();
        name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
    };
    files.is_sorted_by_key(|path| path.as_os_str().as_encoded_bytes()) || files.is_sorted_by_key(letters)
}

/// Sequence of files by number. The numbers are kept if they are consecutive, else frames count from 1.
fn of_numbered(name: &Path, images: BTreeMap<u32, PathBuf>) -> UserFrames {
    let first = images.keys().next().copied().unwrap_or(1);
    let follow = images.keys().zip(first..).all(|(number, expected)| *number == expected);
    let (first, count) = (if follow { first } else { 1 }, images.len());
    let sequence = sequence(name, first, count, Frames::Files(images.into_values().collect()));
    UserFrames { sequence, ..UserFrames::default() }
}

fn sequence(name: &Path, first: u32, count: usize, frames: Frames) -> Sequence {
    let name = name.file_stem().map_or_else(|| folder_name(name), |stem| stem.to_string_lossy().into_owned());
    let last = first.saturating_add(count as u32).saturating_sub(1);
    let numbering = Numbering { first, official: (first, last) };
    Sequence { numbering, frames, ..without_frames(&name, count) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_testing::{assert_says, needs, put};

    /// Folder of empty files with these names.
    fn folder_of(names: &[&str]) -> tempfile::TempDir {
        trackfail_testing::folder(names.iter().map(|name| (name, "")))
    }

    fn shown(frames: &UserFrames) -> (u32, Vec<String>) {
        let Frames::Files(files) = &frames.sequence.frames else { panic!("{frames:?}") };
        let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
        (frames.sequence.numbering.first, files.iter().map(name).collect())
    }

    #[test]
    fn folders_patterns_and_files() {
        let root = folder_of(&["8.jpg", "9.jpg", "10.jpg", "notes.txt", "._9.jpg", ".11.jpg"]);
        let folder = root.path();
        let all = vec!["8.jpg".to_string(), "9.jpg".into(), "10.jpg".into()];
        for given in [vec![folder.to_path_buf()], vec![folder.join("*.jpg")], vec![folder.join("*")]] {
            assert_eq!(shown(&load(&given, &|| false).unwrap()), (8, all.clone()), "{given:?}");
        }
        // A shell gives names in their order as texts.
        let names = ["10.jpg", "8.jpg", "9.jpg"].map(|name| folder.join(name));
        assert_eq!(shown(&load(&names, &|| false).unwrap()), (8, all));
        // Numbers that leave some out are no numbers of frames that follow each other.
        let some = load(&[folder.join("[81]*.jpg")], &|| false).unwrap();
        assert_eq!(shown(&some), (1, vec!["8.jpg".into(), "10.jpg".into()]));
        assert_eq!(shown(&load(&[folder.join("9.jpg")], &|| false).unwrap()), (9, vec!["9.jpg".into()]));
    }

    #[test]
    fn a_list_in_an_order_of_its_own_is_kept() {
        let brackets = ["img (1).png", "img (2).jpeg", "img (10).PNG"];
        let others = ["8.jpg", "9.jpg", "10.jpg", "cam1_2.png", "cam2_1.png"];
        let root = folder_of(&[&brackets[..], &others].concat());
        let listed = |names: &[&str]| {
            let given: Vec<PathBuf> = names.iter().map(|name| root.path().join(name)).collect();
            load(&given, &|| false)
        };
        let found = |names: &[&str]| {
            let frames = listed(names).unwrap();
            let (first, shown) = shown(&frames);
            (first, shown.join(" "), frames.note)
        };
        let kept =
            |count: usize, names: &str| Some(format!("{count} frames in the order given: {names}, ..."));
        // In the order of numbers, of bytes, and of a locale that leaves out the brackets.
        for order in [[0, 1, 2], [0, 2, 1], [2, 0, 1]] {
            let names = order.map(|k| brackets[k]);
            assert_eq!(found(&names), (1, brackets.join(" "), None), "{names:?}");
        }
        let (first, names, note) = found(&["10.jpg", "9.jpg", "8.jpg"]);
        assert_eq!((first, &*names, note), (1, "10.jpg 9.jpg 8.jpg", kept(3, "10.jpg, 9.jpg, 8.jpg")));
        // Either order of names that leave it in doubt may be given, and a pattern gives none.
        for names in [["cam1_2.png", "cam2_1.png"], ["cam2_1.png", "cam1_2.png"]] {
            assert_eq!(found(&names), (1, names.join(" "), kept(2, &names.join(", "))));
        }
        assert_says(load(&[root.path().join("cam*")], &|| false).unwrap_err(), "in doubt");
        assert_says(listed(&["9.jpg", "8.jpg", "9.jpg"]).unwrap_err(), "9.jpg: a frame given twice");
    }

    #[test]
    fn a_folder_of_a_dataset_has_the_name_of_the_sequence() {
        let root = folder_of(&["Girl/img/1.jpg"]);
        for path in ["Girl", "Girl/img"].map(|name| root.path().join(name)) {
            assert_eq!(load(&[path], &|| false).unwrap().sequence.name, "Girl");
        }
    }

    #[test]
    fn what_is_not_there_is_told() {
        let root = folder_of(&["a.jpg", "b.jpg", "notes.txt"]);
        let message = |names: &[&str]| {
            let names: Vec<PathBuf> = names.iter().map(|name| root.path().join(name)).collect();
            load(&names, &|| false).unwrap_err()
        };
        for (names, words) in [
            (&["none.mp4"][..], "none.mp4"),
            (&["none"], "check that the file is there"),
            (&["*.gif"], "no .jpg or .png file fits"),
            (&["***/x"], "no pattern"),
            (&["a.jpg", "notes.txt"], "notes.txt: one of several files"),
            (&["a.jpg", "none.jpg", "notes.txt"], "notes.txt"),
        ] {
            assert_says(message(names), words);
        }
        assert!(load(&[], &|| false).is_err());
    }

    #[needs(ffmpeg)]
    #[test]
    fn a_video_has_frames_and_a_rate() {
        let root = tempfile::tempdir().unwrap();
        let clip = root.path().join("clip.mp4");
        let words = "-nostdin -v error -f lavfi -i testsrc=size=64x48:rate=30000/1001 -frames:v 9";
        let made = std::process::Command::new("ffmpeg").args(words.split(' ')).arg(&clip).status();
        assert!(made.unwrap().success());
        let frames = load(std::slice::from_ref(&clip), &|| false).unwrap();
        let sequence = &frames.sequence;
        assert_eq!((sequence.len(), sequence.number(0), &*sequence.name), (9, 1, "clip"));
        assert_eq!(sequence.size().unwrap(), (64, 48));
        assert!((frames.rate.unwrap() - 29.97).abs() < 0.01);
        assert!(sequence.frame(8).is_ok());
        assert_says(sequence.frame(9).unwrap_err(), "there is no frame 9");
        put(root.path(), "clip.mp4", "no video");
        assert_says(load(&[clip], &|| false).unwrap_err(), "clip.mp4: this is no video that ffmpeg reads");
    }
}
