//! Inputs from the user: frames, boxes, confidence, companions.

use super::{Args, Tracks, files};
use crate::cli::{Failure, output};
use crate::dataset::user_frames::{self, UserFrames};
use crate::dataset::{Numbering, Sequence, text};
use crate::engine::Stop;
use crate::region::Region;
use crate::tracker::results::user_boxes::{self, Candidate, Options, UserBoxes, UserBoxesError, UserTarget};
use crate::tracker::results::{Base, confidence};
use std::path::{Path, PathBuf};

/// Frames that the user gives; `None` without any. Checks that no output would replace them.
pub fn frames(args: &Args, stop: &Stop) -> Result<Option<UserFrames>, Failure> {
    if args.frames.is_empty() {
        return Ok(None);
    }
    let frames = user_frames::load(&args.frames, &|| stop.is_set()).map_err(Failure::data)?;
    if frames.sequence.is_empty() {
        return Err(Failure::data(format!("{} has no frame", shown_frames(args))));
    }
    frames.note.iter().for_each(|note| output::note(note));
    files::check_frames(args, &frames.sequence)?;
    Ok(Some(frames))
}

/// Frames as the user named them.
pub fn shown_frames(args: &Args) -> String {
    match args.frames.as_slice() {
        [] => String::new(),
        [one] => one.display().to_string(),
        [first, more @ ..] => format!("{} and {} more files", first.display(), more.len()),
    }
}

/// Number of the top left pixel; `None` if the user gives none.
pub fn base(args: &Args) -> Option<Base> {
    args.base.map(|base| if base == 0 { Base::Zero } else { Base::One })
}

/// Sequence of all frames, and the targets in it.
pub fn tracks(args: &Args, frames: Option<&UserFrames>) -> Result<(Sequence, Tracks), Failure> {
    let paths = args.boxes.iter().chain(&args.confidence).chain(&args.companion);
    if paths.filter(|path| *path == Path::new("-")).count() > 1 {
        return Err(Failure::usage("only one file can be `-`, stdin"));
    }
    let boxes_path = args.boxes.clone().unwrap_or_default();
    let size = frames.map(|frames| frames.sequence.size()).transpose().map_err(Failure::data)?;
    let options = Options {
        format: args.boxes_format.clone(),
        usual: None,
        base: base(args),
        absent: args.absent,
        frames: frames.map(|frames| frames.sequence.len()),
        first: None,
        number: frames.map(|frames| frames.sequence.numbering.first as usize).filter(|number| *number > 1),
        size,
    };
    let boxes = read(args, &boxes_path, &options)?;
    boxes.notes(&name(&boxes_path), &options).iter().for_each(|note| output::note(note));
    let whole = match frames {
        Some(frames) => frames.sequence.clone(),
        None => {
            let whole = user_frames::without_frames("boxes", boxes.frames);
            let first = boxes.first.map_or(1, |first| first as u32);
            let numbering = Numbering { first, official: (first, first + whole.len() as u32 - 1) };
            Sequence { numbering, ..whole }
        }
    };
    let several = boxes.targets.len() > 1;
    if several && (args.confidence.is_some() || !args.companion.is_empty()) {
        return Err(Failure::usage(format!(
            "{} has {} targets; --confidence and --companion need the boxes of one",
            name(&boxes_path),
            boxes.targets.len()
        )));
    }
    let options =
        Options { frames: Some(whole.len()), first: boxes.first, usual: Some(boxes.format), ..options };
    let companions = args.companion.iter().map(|path| companion(args, path, &options));
    let companions: Vec<Vec<Option<Region>>> = companions.collect::<Result<_, _>>()?;
    let confidence = match &args.confidence {
        None => vec![None; whole.len()],
        Some(path) => {
            let bytes = text::read_named(path).map_err(Failure::data)?;
            confidence::parse(&named(path), &bytes, whole.len()).map_err(Failure::data)?
        }
    };
    let has_box = |target: &UserTarget| target.regions.iter().any(Option::is_some);
    let targets = boxes.targets.into_iter().filter(has_box).collect();
    Ok((whole, Tracks { targets, confidence, companions }))
}

/// Path as messages name it.
fn named(path: &Path) -> PathBuf {
    if path == Path::new("-") { PathBuf::from("stdin") } else { path.to_path_buf() }
}

fn name(path: &Path) -> String {
    named(path).display().to_string()
}

/// Reads a file of boxes; one box for each frame if the frames are known.
fn read(args: &Args, path: &Path, options: &Options) -> Result<UserBoxes, Failure> {
    let bytes = text::read_named(path).map_err(Failure::data)?;
    let boxes = user_boxes::parse(&named(path), &bytes, options).map_err(|e| match e {
        UserBoxesError::Data(e) => Failure::data(e),
        UserBoxesError::Doubt { ref candidates, .. } => {
            Failure::usage(format!("{e}; say which:{}", commands(candidates)))
        }
    })?;
    match options.frames {
        Some(frames) if frames != boxes.frames => {
            let boxes_path = args.boxes.as_deref().filter(|_| args.frames.is_empty());
            let other = boxes_path.map_or_else(|| shown_frames(args), name);
            Err(Failure::data(format!(
                "{} has {} boxes, but {other} has {frames} frames; there must be one box for each frame",
                name(path),
                boxes.frames,
            )))
        }
        _ => Ok(boxes),
    }
}

/// The user's command, once for each candidate format.
fn commands(candidates: &[Candidate]) -> String {
    let words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let is_plain = |word: &str| {
        !word.is_empty() && word.chars().all(|c| c.is_ascii_alphanumeric() || "-_./,:=".contains(c))
    };
    let quoted = |word: String| if is_plain(&word) { word } else { output::quoted(&word) };
    let command = words.map(quoted).collect::<Vec<_>>().join(" ");
    let one = |c: &Candidate| format!("\n  trackfail {command} --boxes-format {}", c.format.option());
    candidates.iter().map(one).collect()
}

/// Boxes of a companion, one for each frame.
fn companion(args: &Args, path: &Path, options: &Options) -> Result<Vec<Option<Region>>, Failure> {
    let mut boxes = read(args, path, options)?;
    match (boxes.targets.pop(), boxes.targets.len()) {
        (Some(target), 0) => Ok(target.regions),
        (_, others) => {
            Err(Failure::usage(format!("{} has {} targets; a companion has one", name(path), others + 1)))
        }
    }
}
