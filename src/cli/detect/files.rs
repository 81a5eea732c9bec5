//! `--report`, `--plot` and `--annotate`: the track as a page, as a figure, and drawn on its frames.

use super::Args;
use crate::cli::output::replace::{Output, check_inputs, check_outputs};
use crate::cli::{Failure, io_at};
use crate::dataset::{Frames, Sequence};
use crate::engine::Stop;
use crate::engine::store;
use crate::image::{self, Frame};
use crate::report::user_track::UserVideo;
use crate::report::user_track::video::{self, CONTAINERS, VideoError};
use crate::tracker::results::write;
use crate::user_file;
use std::path::Path;

/// Frames per second of a video made of single images.
const RATE: f64 = 25.0;

/// Checks the names of outputs, before anything is computed.
pub fn check(args: &Args) -> Result<(), Failure> {
    if let Some(path) = args.plot.as_ref().filter(|path| !["svg", "png", "pdf"].contains(&&*end(path))) {
        let message = format!("--plot {}: a figure is a .svg, a .pdf or a .png file", path.display());
        return Err(Failure::usage(message));
    }
    if let Some(path) = &args.annotate {
        if args.frames.is_empty() {
            return Err(Failure::usage("--annotate draws on the frames; give --frames"));
        }
        if !is_folder(path) && video::container(path).is_none() {
            let ends: Vec<String> = CONTAINERS.iter().map(|(end, _)| format!(".{end}")).collect();
            return Err(Failure::usage(format!(
                "--annotate {}: a video is a file {}, and a folder has no ending",
                path.display(),
                ends.join(", ")
            )));
        }
    }
    let outputs = outputs(args);
    check_outputs(&outputs)?;
    let several = args.companion.iter().map(|path| ("--companion", path));
    let several = several.chain(args.frames.iter().map(|path| ("--frames", path)));
    let files = [("--boxes", &args.boxes), ("--confidence", &args.confidence), ("--model", &args.model)];
    let files = files.into_iter().filter_map(|(option, path)| Some((option, path.as_ref()?)));
    check_inputs(&outputs, files.chain(several).map(|(option, path)| (option, path.as_path())))
}

/// Checks that outputs do not replace the frames, once the files of the frames are known.
pub fn check_frames(args: &Args, sequence: &Sequence) -> Result<(), Failure> {
    let Frames::Files(frames) = &sequence.frames else { return Ok(()) };
    check_inputs(&outputs(args), frames.iter().map(|path| ("--frames", path.as_path())))
}

/// Files and folders to be written, each with its option.
fn outputs(args: &Args) -> Vec<Output> {
    // The tracker's confidence goes beside its boxes.
    let beside = args.save_boxes.as_deref().map(write::confidence_path);
    let named = [
        ("--report", &args.report),
        ("--plot", &args.plot),
        ("--annotate", &args.annotate),
        ("--save-boxes", &args.save_boxes),
        ("--save-boxes", &beside),
    ];
    named.into_iter().filter_map(|(option, path)| Some((option, path.clone()?))).collect()
}

/// Ending of a file name, in lower case.
fn end(path: &Path) -> String {
    path.extension().map(|end| end.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// True if the annotated frames go into a folder.
fn is_folder(path: &Path) -> bool {
    path.is_dir() || path.extension().is_none()
}

/// Writes the requested outputs; `rate` is that of the video, if the frames are from one.
pub fn write(args: &Args, video: &UserVideo<'_>, rate: Option<f64>, stop: &Stop) -> Result<(), Failure> {
    if let Some(path) = &args.report {
        let page = video.page().map_err(Failure::data)?;
        user_file::write(path, page.as_bytes()).map_err(Failure::io)?;
    }
    if let Some(path) = &args.plot {
        let figure = video.plot().map_err(Failure::data)?;
        let bytes = match &*end(path) {
            "svg" => figure.to_svg().map(String::into_bytes),
            "pdf" => figure.to_pdf(),
            _ => figure.to_png(),
        };
        user_file::write(path, &bytes.map_err(Failure::data)?).map_err(Failure::io)?;
    }
    match &args.annotate {
        Some(path) if is_folder(path) => annotate_images(path, video, stop),
        Some(path) => annotate_video(path, video, rate.unwrap_or(RATE), stop),
        None => Ok(()),
    }
}

/// Frame `t` with boxes, state and score drawn on it.
fn drawn(video: &UserVideo<'_>, t: usize, stop: &Stop) -> Result<Frame, Failure> {
    if stop.is_set() {
        return Err(Failure::interrupted());
    }
    Ok(video.drawn(t, &video.sequence.frame(t).map_err(Failure::data)?))
}

/// Writes the annotated frames as PNG files named by frame number.
fn annotate_images(folder: &Path, video: &UserVideo<'_>, stop: &Stop) -> Result<(), Failure> {
    if !folder.is_dir() {
        std::fs::create_dir(folder).map_err(io_at(folder))?;
    }
    for t in 0..video.sequence.len() {
        let frame = drawn(video, t, stop)?;
        let png = image::encode_png(&frame).map_err(Failure::io)?;
        let path = folder.join(format!("{:06}.png", video.sequence.number(t)));
        store::write_derived(&path, &png).map_err(Failure::io)?;
    }
    Ok(())
}

fn annotate_video(path: &Path, video: &UserVideo<'_>, rate: f64, stop: &Stop) -> Result<(), Failure> {
    let frame = |t| drawn(video, t, stop);
    video::write(path, rate, video.sequence.len(), frame, &|| stop.is_set()).map_err(|e| match e {
        VideoError::Frame(e) => e,
        e @ VideoError::NoFfmpeg(_) => Failure::data(e.to_string()),
        e => Failure::io(e.to_string()),
    })
}
