//! Sequences annotated in CVML: CAVIAR (List, Fisher, 2004) and PETS2009 (annotation by Anton Milan).
//!
//! ```text
//! S2L1/PETS2009-S2L1.xml           the annotation, the folder's only .xml file, see `parse`
//! S2L1/img1/000001.jpg ...         frames under their own numbers, .jpg or .png; in img1, img or the folder
//!
//! Walk1/wk1gt.xml
//! Walk1/Walk1.mpg                  or a video, the folder's only one
//! ```
//!
//! XML frame `n` is image `n + 1`, and the `n + 1`-th frame of the video. One object (`target`) of the file is a
//! sequence; frames in which it is not annotated have no truth (`None`). Boxes are center and size in
//! continuous pixels; neither dataset says whether its pixels count from 0 or 1, they are taken as written.
//!
//! Without a target the object annotated in most frames is taken, of several the one with the smallest id.
//! Without a range the sequence goes from the target's first to its last annotated frame.

mod parse;

pub use parse::{Annotation, parse};

use super::FormatEntry;
use super::shared::name_of;
use crate::files::{entries, is_image};
use crate::lock::Entry;
use crate::video::{self, Video};
use crate::{DatasetError, Frames, Numbering, Result, Sequence, text};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackfail_core::region::Region;

/// CVML in the list of formats.
pub const FORMAT: FormatEntry = FormatEntry {
    word: "cvml",
    summary: "one `.xml` file of boxes of all objects, with images or a video",
    truth_file: "annotation.xml",
    load,
    parse_truth,
    image_folders: &["img1", "img"],
    reads: |name| is_xml(name) || is_video_name(name),
    belongs: |entry, _, image| match (image, entry.range) {
        (Some(n), Some((first, last))) => first <= n && n <= last,
        _ => true,
    },
    absent,
    find_targets: None,
    ..FormatEntry::BASE
};

const ANNOTATION: &str = "annotation (.xml)";

/// Loads one sequence. Reads lists of files and the XML file; no image, no video.
///
/// # Errors
/// No or several XML files or videos, a broken annotation, an object that the annotation lacks, a missing
/// frame.
pub fn load(root: &Path, entry: &Entry) -> Result<Sequence> {
    let folder = entry.path(root);
    let names = names(&folder)?;
    let xml = only(&folder, &names, ANNOTATION, is_xml)?;
    let annotation = parse(&xml, &text::read(&xml)?)?;
    let content = |message: String| DatasetError::content(&xml, message);
    let target = entry.target.or_else(|| annotation.longest()).ok_or_else(|| content(NOBODY.into()))?;
    let presence = annotation.presence(target).ok_or_else(|| {
        let known: Vec<String> = annotation.objects().map(|id| id.to_string()).collect();
        content(format!("no object {target}; annotated are {}", text::shorten(&known.join(", "))))
    })?;
    let (first, last) = entry.range.unwrap_or(presence);
    if first < 1 || first > last || last > annotation.last() {
        let end = annotation.last();
        return Err(content(format!(
            "frames {first} to {last} are not all in it; its last is {end}, as image numbers"
        )));
    }
    let frames = if is_video(&folder, &names) {
        let video = only(&folder, &names, "video", is_video_name)?;
        Frames::Video(Arc::new(Video::new(video, video::cache(root), (first, last))))
    } else {
        let images = FORMAT.images(&folder)?;
        if images.files.contains_key(&0) {
            let message =
                "the first image is 0, but frame N of the annotation is image N + 1: number them from 1";
            return Err(DatasetError::content(&images.folder, message));
        }
        Frames::Files(images.range((first, last))?)
    };
    let numbering = Numbering { first, official: entry.official.unwrap_or(presence) };
    let (name, truth) = (name_of(&folder, entry), annotation.regions(target, (first, last)));
    Ok(Sequence { name, numbering, truth, frames, ..Sequence::default() })
}

const NOBODY: &str = "no object is annotated";

/// Boxes of the object annotated in most frames, from its first to its last frame.
///
/// # Errors
/// Bytes that are not a CVML annotation, or one without an object.
fn parse_truth(path: &Path, bytes: &[u8]) -> Result<Vec<Option<Region>>> {
    let annotation = parse(path, text::decode(path, bytes)?)?;
    let longest = annotation.longest().and_then(|id| Some(annotation.regions(id, annotation.presence(id)?)));
    longest.ok_or_else(|| DatasetError::content(path, NOBODY))
}

/// True if the folder has a video and no folder of images.
fn is_video(folder: &Path, names: &[String]) -> bool {
    FORMAT.image_folder(folder) == folder && names.iter().any(|name| is_video_name(name))
}

/// Tells what a folder lacks: annotation or frames, which are downloaded apart, or the last images of a range.
fn absent(format: &FormatEntry, folder: &Path, entry: &Entry) -> Result<Option<String>> {
    let names = names(folder)?;
    if !names.iter().any(|name| is_xml(name)) {
        return Ok(Some(format!("no {ANNOTATION}")));
    }
    let has_frames = FORMAT.image_folder(folder) != folder
        || names.iter().any(|name| is_video_name(name) || is_image(Path::new(name)));
    match is_video(folder, &names) {
        _ if !has_frames => Ok(Some("no images or video".into())),
        true => Ok(None),
        false => format.cut_off(folder, entry),
    }
}

fn is_xml(name: &str) -> bool {
    ending(name, &["xml"])
}

/// True if the name is that of a video file.
fn is_video_name(name: &str) -> bool {
    ending(name, &["mpg", "mpeg", "avi", "mp4", "mov", "mkv", "webm"])
}

fn ending(name: &str, endings: &[&str]) -> bool {
    let of_name = Path::new(name).extension().unwrap_or_default().to_ascii_lowercase();
    !name.starts_with('.') && endings.iter().any(|e| of_name == *e)
}

/// The names of a folder's files, sorted; names that are not UTF-8 are left out.
fn names(folder: &Path) -> Result<Vec<String>> {
    let name = |path: PathBuf| Some(path.file_name()?.to_str()?.to_owned());
    let mut names: Vec<String> = entries(folder)?.into_iter().filter_map(name).collect();
    names.sort();
    Ok(names)
}

/// The only file of a folder that `fits` accepts; no or several such files are an error.
fn only(folder: &Path, names: &[String], what: &str, fits: fn(&str) -> bool) -> Result<PathBuf> {
    let mut fitting = names.iter().filter(|name| fits(name));
    let message = match (fitting.next(), fitting.next()) {
        (Some(one), None) => return Ok(folder.join(one)),
        (Some(first), Some(second)) => {
            format!("{first} and {second}: only one {what} may be there; move the other away")
        }
        (None, _) => format!("no {what}; one is needed"),
    };
    Err(DatasetError::content(folder, message))
}

#[cfg(test)]
mod tests;
