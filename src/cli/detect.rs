//! `trackfail detect --frames FRAMES --boxes FILE` and `trackfail detect --frames FRAMES --init X,Y,W,H`.

mod files;
mod follow;
mod inputs;
mod methods;
mod print;

use super::{Exit, Failure, output, run};
use crate::dataset::Sequence;
use crate::engine::Stop;
use crate::judge::judge::{FrameOf, JudgeError, Track, judge};
use crate::judge::judged::JudgedMethod;
use crate::method::Method;
use crate::region::Region;
use crate::report::user_track::{UserTrack, UserVideo};
use crate::report::verdict::{of_target, verdict};
use crate::results::detections::JudgedTrack;
use crate::tracker::results::user_boxes::{BoxFormat, UserTarget};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::Arc;

/// Arguments of `detect`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "On a terminal a verdict is printed, otherwise CSV: frame,method,score,label,change,state. label is 1 in \
frames with an alarm, change is 1 where alarms begin and -1 where they end, state is lost from an alarm until the recovery \
is confirmed, absent where there is no box, else tracking. The method is the one that the benchmark recommends for the \
inputs given. With --init the video is tracked first; methods that read a tracker's posterior (AVU, ARTE*, ...) need that. \
Their model of a consistent filter is built in for the default tracker, learned on rendered sequences; --model takes \
another one."
)]
#[command(group = clap::ArgGroup::new("track").required(true).args(["boxes", "init"]))]
pub struct Args {
    /// The frames: a folder of .jpg or .png files, some such files or a pattern of their names, or a video (ffmpeg decodes
    /// it). Without them only methods of boxes run
    #[arg(long, value_name = "FRAMES", num_args = 1.., required_unless_present = "boxes")]
    frames: Vec<PathBuf>,
    /// The tracker's boxes, a line for each frame; `-` is stdin
    #[arg(long, value_name = "FILE")]
    boxes: Option<PathBuf>,
    /// Form of a line of boxes: xywh (left,top,width,height), xyxy (left,top,right,bottom), mot (MOTChallenge:
    /// frame,id,left,top,width,height,...; a verdict for each id), vot (corners of a polygon, from pixel 0 on), yolo (center
    /// and size as shares of the frame's sides, perhaps after a class), or the columns in words, such as
    /// frame,x1,y1,x2,y2,confidence (default: what a header line says, else found out where the numbers leave no doubt)
    #[arg(long, value_parser = BoxFormat::read, value_name = "FORMAT", conflicts_with = "init")]
    boxes_format: Option<BoxFormat>,
    /// Lines that are empty, have NaN, no area or a box outside of the frame mean that the target is absent
    #[arg(long, conflicts_with = "init")]
    absent: bool,
    /// The tracker's own confidence, a number for each frame
    #[arg(long, value_name = "FILE", conflicts_with = "init")]
    confidence: Option<PathBuf>,
    /// Boxes of another tracker on the same frames, in the same format (may be given several times)
    #[arg(long, value_name = "FILE", conflicts_with = "init")]
    companion: Vec<PathBuf>,
    /// Instead of boxes: where the target is in the first frame, `x,y,w,h`; a built-in tracker follows it
    #[arg(long, value_name = "BOX", allow_hyphen_values = true)]
    init: Option<String>,
    /// Method (may be given several times; default: the one that the benchmark recommends for these inputs)
    #[arg(long, value_name = "NAME")]
    method: Vec<String>,
    /// Method for boxes and frames, by the time that it takes
    #[arg(long, value_name = "TIER", conflicts_with_all = ["method", "all"])]
    tier: Option<super::Tier>,
    /// All methods that these inputs allow
    #[arg(long, conflicts_with = "method")]
    all: bool,
    /// Largest number of false alarms per 1000 frames, for methods that take one
    #[arg(long, value_name = "N", value_parser = super::budget)]
    budget: Option<f64>,
    /// Form of the output (default: table on a terminal, else csv)
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<output::Format>,
    /// Writes a page with the verdict, a strip, a frame viewer and thumbnails, which needs nothing beside it
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Writes a figure of the scores, below frames that say most
    #[arg(long, value_name = "FILE.svg|pdf|png")]
    plot: Option<PathBuf>,
    /// Writes the frames with boxes, state and score drawn on them: a video (ffmpeg encodes it), or PNG files in a folder
    #[arg(long, value_name = "FILE.mp4|DIR")]
    annotate: Option<PathBuf>,
    /// Ends with exit code 6 if a method finds a loss
    #[arg(long)]
    fail_on_loss: bool,
    /// Number of the top left pixel in the boxes, 0 or 1 (default: 1 as in OTB, 0 for vot; none for yolo)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=1))]
    base: Option<u8>,
    /// With --init: the tracker (see `trackfail list trackers`)
    #[arg(long, value_name = "KIND", default_value = follow::DEFAULT_TRACKER, conflicts_with = "boxes")]
    tracker: String,
    /// With --init: the tracker's parameters as a TOML table
    #[arg(long, value_name = "TABLE", default_value = "{}", conflicts_with = "boxes")]
    params: String,
    /// With --init: seed of trackers that draw random numbers
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with = "boxes")]
    seed: u64,
    /// With --init: a model learned by AVU or ARTE*, a file of the folder `models` of an experiment's results
    #[arg(long, value_name = "FILE", conflicts_with = "boxes")]
    model: Option<PathBuf>,
    /// With --init: where to write the tracker's boxes, a line `x,y,w,h` for each frame; its confidence, if it gives one,
    /// goes beside them
    #[arg(long, value_name = "FILE", conflicts_with = "boxes")]
    save_boxes: Option<PathBuf>,
}

/// Tracks that the user gives beside the frames.
struct Tracks {
    /// Targets, each with a box in at least one frame.
    targets: Vec<UserTarget>,
    /// Confidence of the tracker in each frame of the video. Only with a single target.
    confidence: Vec<Option<f64>>,
    /// Boxes of other trackers in each frame. Only with a single target.
    companions: Vec<Vec<Option<Region>>>,
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    files::check(args)?;
    // Without frames there is nothing to clean up, and stdin may be waited for.
    let stop = if args.frames.is_empty() { Stop::default() } else { run::stop_on_signals() };
    // What an interruption ends is no failure of the video.
    run_until(args, &stop).map_err(|e| if stop.is_set() { Failure::interrupted() } else { e })
}

/// Runs the verb until it is finished or the user interrupts.
fn run_until(args: &Args, stop: &Stop) -> Result<(), Failure> {
    let named = methods::named(args)?;
    let (frames, whole, tracks, methods) = match &args.init {
        Some(init) => {
            let frames = inputs::frames(args, stop)?;
            let frames = frames.ok_or_else(|| Failure::usage("--init needs the frames; give --frames"))?;
            let (track, methods) = follow::track(args, init, &frames.sequence, named, stop)?;
            (Some(frames), None, vec![track], methods)
        }
        None => {
            let methods = methods::on_boxes(args, named)?;
            let frames = inputs::frames(args, stop)?;
            let (whole, tracks) = inputs::tracks(args, frames.as_ref())?;
            let judged = judge_all(tracks, &methods, &whole, stop)?;
            (frames, Some(whole), judged, methods)
        }
    };
    let Some(sequence) = whole.as_ref().or(frames.as_ref().map(|frames| &frames.sequence)) else {
        return Ok(());
    };
    let video = UserVideo { sequence, tracks, facts: facts(args, &methods) };
    let judged: Vec<&JudgedTrack> = video.tracks.iter().map(|track| &track.judged).collect();
    let is_terminal = std::io::stdout().is_terminal();
    let usual = if is_terminal { output::Format::Table } else { output::Format::Csv };
    print::print(args.format.unwrap_or(usual), &judged)?;
    files::write(args, &video, frames.as_ref().and_then(|frames| frames.rate), stop)?;
    let mut all = judged.iter().flat_map(|track| track.methods.iter().map(move |method| (track, method)));
    match all.find(|(_, method)| args.fail_on_loss && !method.losses().is_empty()) {
        Some((track, method)) => Err(Failure::new(Exit::Loss, of_target(track, &verdict(track, method)))),
        None => Ok(()),
    }
}

/// Names and values of the program, inputs and methods behind the results, for the page.
fn facts(args: &Args, methods: &[Method]) -> Vec<(String, String)> {
    let mut facts = vec![("program".to_string(), format!("trackfail {}", env!("CARGO_PKG_VERSION")))];
    let mut add = |name: &str, value: String| facts.push((name.to_string(), value));
    if !args.frames.is_empty() {
        add("frames", inputs::shown_frames(args));
    }
    for (name, path) in [("boxes", &args.boxes), ("confidence", &args.confidence)] {
        path.iter().for_each(|path| add(name, path.display().to_string()));
    }
    args.companion.iter().for_each(|path| add("companion", path.display().to_string()));
    if let Some(init) = &args.init {
        add("tracker", format!("{} from {init}", args.tracker));
    }
    methods.iter().for_each(|method| add(&format!("method {}", method.name), method.words()));
    facts
}

/// Judges the targets by all methods in one pass over the frames.
fn judge_all(
    tracks: Tracks,
    methods: &[Method],
    sequence: &Sequence,
    stop: &Stop,
) -> Result<Vec<UserTrack>, Failure> {
    let Tracks { targets, confidence, companions } = tracks;
    let companions: Vec<&[Option<Region>]> = companions.iter().map(Vec::as_slice).collect();
    let given: Vec<Track<'_>> = targets
        .iter()
        .map(|target| Track { regions: &target.regions, confidence: &confidence, companions: &companions })
        .collect();
    let frame = |t: usize| Ok(Arc::new(sequence.frame(t)?));
    let frames = sequence.has_frames().then_some(&frame as FrameOf<'_>);
    let judged = judge(methods, &given, frames, &|| stop.is_set());
    let of = |track: usize| {
        let id = targets.get(track).and_then(|target| target.id);
        id.map_or_else(String::new, |id| format!("target {id}: "))
    };
    let judged = judged.map_err(|e| {
        Failure::data(match e {
            JudgeError::Signal { track, t, source } => of(track) + &source.in_frame(sequence.number(t)),
            JudgeError::Detector { track, reason } => of(track) + &reason,
            e => e.to_string(),
        })
    })?;
    let first = sequence.number(0);
    let of = |(target, methods): (UserTarget, Vec<JudgedMethod>)| {
        let judged = JudgedTrack { target: target.id, first, methods };
        UserTrack { judged, regions: shown(target.regions) }
    };
    Ok(targets.into_iter().zip(judged).map(of).collect())
}

/// Boxes of a target as they are shown. Where a box is missing between two others, the last one is repeated.
fn shown(regions: Vec<Option<Region>>) -> Vec<Option<Region>> {
    let end = regions.iter().rposition(Option::is_some).unwrap_or(0);
    let mut last = None;
    let stay = |(t, region): (usize, Option<Region>)| {
        last = region.or_else(|| last.take().filter(|_| t <= end));
        last.clone()
    };
    regions.into_iter().enumerate().map(stay).collect()
}
