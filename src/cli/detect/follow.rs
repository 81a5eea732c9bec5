//! `--init`: a built-in tracker follows the target, and the program judges this track.

use super::{Args, inputs, methods};
use crate::cli::Failure;
use crate::cli::live::live_tracker;
use crate::dataset::frame_cache::FrameCache;
use crate::dataset::{Sequence, text};
use crate::detector::Input;
use crate::engine::Stop;
use crate::engine::execute::reverse::{self, FRAMES_IN_MEMORY, Reversal};
use crate::engine::execute::tracker_run::TrackerRun;
use crate::engine::store::StoreError;
use crate::image::Frame;
use crate::judge::judged::JudgedMethod;
use crate::judge::reader::{SignalReader, columns};
use crate::method::{Inputs, Method};
use crate::num::seed;
use crate::region::{Rect, Region};
use crate::report::user_track::UserTrack;
use crate::results::detections::JudgedTrack;
use crate::signal::Reads;
use crate::tracker::results::{self, Base, write};
use crate::tracker::{StartedTracker, Status, TrackerError, TrackerState};
use crate::user_file;
use rayon::prelude::*;
use std::fmt::Display;
use std::path::Path;
use std::sync::Arc;

/// Tracker for which the built-in model was learned.
pub const DEFAULT_TRACKER: &str = "color-particle-filter";

/// The model that AVU learned in `sanmiguel2015/built-in-model`.
const BUILT_IN_MODEL: &str = include_str!("../../../assets/models/color-particle-filter.json");

/// Largest model file, in bytes.
const MAX_MODEL_FILE: u64 = 1 << 24;

/// Runs the tracker from the target's first box, and judges the track.
pub fn track(
    args: &Args,
    init: &str,
    sequence: &Sequence,
    named: Vec<Method>,
    stop: &Stop,
) -> Result<(UserTrack, Vec<Method>), Failure> {
    let base = inputs::base(args).unwrap_or(Base::One);
    let first = first_box(init, base)?;
    let (width, height) = sequence.size().map_err(|e| Failure::data(e.to_string()))?;
    let frame = Region::Rect(Rect::new(0.0, 0.0, width as f64, height as f64));
    if first.clipped(&frame).is_none() {
        let frame = sequence.number(0);
        let message = format!(
            "--init {init} lies outside of the frame of {width}x{height} pixels, which is number {frame} of {}",
            inputs::shown_frames(args)
        );
        return Err(Failure::usage(message));
    }
    let mut sequence = sequence.clone();
    if let Some(truth) = sequence.truth.first_mut() {
        *truth = Some(first);
    }
    let sequence = Arc::new(sequence);
    let (entry, config) = live_tracker(&args.tracker, &args.params)?;
    let seed = seed::seed(args.seed, &["detect", entry.kind]);
    let broke = |e: &dyn Display| Failure::data(format!("{}: {e}", entry.kind));
    let model = model(args, config.params() == built_in_params())?;
    let frames = Arc::new(FrameCache::new(FRAMES_IN_MEMORY));
    let run = TrackerRun {
        sequence: sequence.clone(),
        frames,
        config: config.plugin,
        run: 0,
        seed,
        data_roots: Vec::new(),
    };
    let frame = run.frame(0).map_err(|e| Failure::data(e.to_string()))?;
    let started = run.start(&frame).map_err(|e| broke(&e))?;
    let methods = ready(args, named, &started.1, model.as_ref())?;
    let choices = methods.iter().flat_map(|method| &method.signals);
    let signals = choices.map(|choice| SignalReader::start(choice, &run.context()));
    let signals = signals.map(|signal| signal.map(|signal| (signal, Vec::new())));
    let mut signals: Vec<SignalValues> =
        signals.collect::<Result<_, TrackerError>>().map_err(|e| broke(&e))?;
    // Frames are needed again only by runs back in time.
    let goes_back = methods.iter().any(|method| method.detector.detector.facts().needs_reverse);
    let decode = |t: usize| match goes_back {
        true => run.frame(t).map_err(|e| Failure::data(e.to_string())),
        false => sequence.frame(t).map(Arc::new).map_err(Failure::data),
    };
    let states = follow(&sequence, started, &mut signals, (frame, &decode), &broke, stop)?;
    if let Some(path) = &args.save_boxes {
        save(path, &states, base).map_err(Failure::io)?;
    }
    let present: Vec<bool> = states.iter().map(|s| s.status != Status::Absent).collect();
    let regions: Vec<Region> = states.into_iter().map(|s| s.region).collect();
    let shown = regions.iter().cloned().map(Some).collect();
    let judged = judge(&methods, &signals, &Reversal::new(run, regions), &present)?;
    let judged = JudgedTrack { target: None, first: sequence.number(0), methods: judged };
    Ok((UserTrack { judged, regions: shown }, methods))
}

/// A signal with its values so far, one per frame.
type SignalValues = (SignalReader, Vec<f64>);

/// Decodes frame `t` (0-based).
type Decode<'a> = &'a (dyn Fn(usize) -> Result<Arc<Frame>, Failure> + Sync);

/// States of a started tracker in all frames. The signals are computed along the way, while another thread
/// decodes the next frame.
fn follow(
    sequence: &Sequence,
    (mut tracker, first): StartedTracker,
    signals: &mut [SignalValues],
    (mut frame, decode): (Arc<Frame>, Decode<'_>),
    broke: &(dyn Fn(&dyn Display) -> Failure + Sync),
    stop: &Stop,
) -> Result<Vec<TrackerState>, Failure> {
    let mut first = Some(first);
    let mut states = Vec::with_capacity(sequence.len());
    for t in 0..sequence.len() {
        if stop.is_set() {
            return Err(Failure::interrupted());
        }
        let step = || {
            let state = first.take().map_or_else(|| tracker.update(&frame), Ok).map_err(|e| broke(&e))?;
            let read = |(signal, values): &mut SignalValues| -> Result<(), Failure> {
                let read = signal.push(Some(&frame), &state, &[]);
                values.extend(read.map_err(|e| Failure::data(e.in_frame(sequence.number(t))))?);
                Ok(())
            };
            // The first signal that fails is the one that is told.
            let read: Vec<Result<(), Failure>> = signals.par_iter_mut().map(read).collect();
            read.into_iter().collect::<Result<(), Failure>>().map(|()| state)
        };
        let ahead = || (t + 1 < sequence.len()).then(|| decode(t + 1)).transpose();
        let (state, next) = rayon::join(step, ahead);
        states.push(state?);
        frame = next?.unwrap_or(frame);
    }
    Ok(states)
}

/// Judges the track by the signals of the methods.
fn judge(
    methods: &[Method],
    signals: &[SignalValues],
    reversal: &Reversal,
    present: &[bool],
) -> Result<Vec<JudgedMethod>, Failure> {
    let mut judged = Vec::new();
    // Detectors need no ground truth; only the oracle reads the error, and it is not among these methods.
    let unknown = vec![f64::NAN; present.len()];
    let columns = columns(signals.iter().map(|(reader, values)| (values.as_slice(), reader.width())));
    let mut columns = columns.iter().map(Vec::as_slice);
    for method in methods {
        let width: usize = method.signals.iter().map(|choice| choice.signal.width()).sum();
        let mine: Vec<&[f64]> = columns.by_ref().take(width).collect();
        let Some((signal, more)) = mine.split_first() else { continue };
        let detector = &*method.detector.detector;
        let seed = seed::seed(0, &[&method.name]);
        let input = Input { signal, more, error: &unknown, seed, reverse: None };
        let output = reverse::detect(detector, input, Some(reversal));
        let output = output.map_err(|e| Failure::data(e.to_string()))?;
        judged.push(JudgedMethod::new(&method.name, detector, &output, 0, present));
    }
    Ok(judged)
}

/// Parses the box of `--init`.
fn first_box(text: &str, base: Base) -> Result<Region, Failure> {
    let boxes = results::parse_boxes(Path::new("--init"), text.as_bytes(), base);
    match boxes.map_err(Failure::usage)?.as_slice() {
        [one] => Ok(one.clone()),
        _ => Err(Failure::usage(format!("--init takes one box, x,y,w,h, not `{text}`"))),
    }
}

/// Writes the boxes of a track, and beside them the confidence if the tracker gives one.
fn save(path: &Path, states: &[TrackerState], base: Base) -> Result<(), StoreError> {
    let regions: Vec<Region> = states.iter().map(|s| s.region.clone()).collect();
    let status: Vec<Status> = states.iter().map(|s| s.status).collect();
    user_file::write(path, write::boxes(&regions, &status, base).as_bytes())?;
    let confidence: Vec<Option<f64>> = states.iter().map(|s| s.confidence).collect();
    if confidence.iter().any(Option::is_some) {
        user_file::write(&write::confidence_path(path), write::confidence(&confidence).as_bytes())?;
    }
    Ok(())
}

/// Parameters of the default tracker for which the built-in model is valid.
fn built_in_params() -> serde_json::Value {
    live_tracker(DEFAULT_TRACKER, "{}").map_or(serde_json::Value::Null, |(_, config)| config.params())
}

/// Learned model of a consistent filter: the user's, else that of the default tracker; `None` if there is
/// neither.
fn model(args: &Args, is_default_tracker: bool) -> Result<Option<serde_json::Value>, Failure> {
    let (name, bytes) = match &args.model {
        Some(path) => {
            let bytes = text::read_at_most(path, MAX_MODEL_FILE).map_err(Failure::data)?;
            (path.display().to_string(), bytes)
        }
        None if is_default_tracker => ("the built-in model".to_string(), BUILT_IN_MODEL.into()),
        None => return Ok(None),
    };
    let data = |e: &dyn Display| Failure::data(format!("{name}: {e}"));
    let mut file: serde_json::Value = serde_json::from_slice(&bytes).map_err(|e| data(&e))?;
    let model = file.get_mut("model").map(serde_json::Value::take);
    model.map(Some).ok_or_else(|| data(&"holds no learned model; AVU and ARTE* write one"))
}

/// Methods that can judge the track of a tracker whose first state is `state`.
fn ready(
    args: &Args,
    named: Vec<Method>,
    state: &TrackerState,
    model: Option<&serde_json::Value>,
) -> Result<Vec<Method>, Failure> {
    let inputs = Inputs { frames: true, companions: false, confidence: state.confidence.is_some() };
    let lacks = |reads: Reads| match reads {
        Reads::Companions => Some("needs other trackers' boxes"),
        _ if reads.is_in(state) => None,
        Reads::Posterior => Some("needs a tracker with a posterior, such as color-particle-filter or ivt"),
        Reads::Response => Some("needs a tracker with a response map, such as kcf, dsst or samf"),
        _ => reads.need_of_tracker(),
    };
    let learns = |method: &Method| method.detector.detector.learner().is_some();
    let unlearned = "needs a model learned for this tracker; give --model";
    let need = |method: &Method| {
        method.reads().find_map(lacks).or((learns(method) && model.is_none()).then_some(unlearned))
    };
    let taught = |method: Method| match model.filter(|_| learns(&method)) {
        Some(model) => method.with_model(model).map_err(Failure::data),
        None => Ok(method),
    };
    methods::ready(args, named, inputs, need, String::new)?.into_iter().map(taught).collect()
}
