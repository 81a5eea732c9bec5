//! `--init`: a built-in tracker follows the target, and its own track is judged.

use super::methods::Wanted;
use super::{Args, inputs};
use crate::cli::Failure;
use crate::cli::live::live_tracker;
use crate::dataset::Sequence;
use crate::dataset::frame_cache::FrameCache;
use crate::detector::Input;
use crate::engine::Stop;
use crate::engine::execute::cores::Cores;
use crate::engine::execute::frame_loop::{Collected, Collector, run_frames_on};
use crate::engine::execute::frame_observer::FrameObserver;
use crate::engine::execute::lane::{Companions, Lane, LaneStep};
use crate::engine::execute::reverse::{self, FRAMES_IN_MEMORY, Reversal};
use crate::engine::execute::tracker_run::{TrackerRun, TrackingError};
use crate::engine::limits::Interrupted;
use crate::engine::store::{self, StoreError};
use crate::num::seed;
use crate::region::{Rect, Region};
use crate::report::user_track::UserTrack;
use crate::results::detections::JudgedTrack;
use crate::signal::Reads;
use crate::tracker::results::{self, Base, write};
use crate::tracker::{Status, TrackerState};
use std::path::Path;
use std::sync::Arc;
use trackfail_judge::judged::JudgedMethod;
use trackfail_judge::method::{Inputs, Method};
use trackfail_judge::reader::columns;

/// The tracker that the built-in model is about.
pub const DEFAULT_TRACKER: &str = "color-particle-filter";

/// The model that AVU learned in `sanmiguel2015/built-in-model`.
const BUILT_IN_MODEL: &str = include_str!("../../../assets/models/color-particle-filter.json");

/// Size of the largest model file, in bytes.
const MAX_MODEL_FILE: u64 = 1 << 24;

/// Tracks the target from its first box, and judges the track.
pub fn track(
    args: &Args,
    init: &str,
    sequence: &Sequence,
    wanted: Wanted,
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
    let failure = |e: TrackingError| match e {
        TrackingError::Interrupted(e) => Failure::Interrupted(e.into()),
        TrackingError::Tracker(e) => Failure::data(format!("{}: {e}", entry.kind)),
        e => Failure::data(e.to_string()),
    };
    let is_default_tracker = config.params() == built_in_params();
    let kept = Arc::new(FrameCache::new(FRAMES_IN_MEMORY));
    let run =
        TrackerRun { sequence: sequence.clone(), frames: kept, config, run: 0, seed, data_roots: Vec::new() };
    let started = run.frame(0).and_then(|frame| run.start(&frame)).map_err(failure)?;
    let confidence = started.1.confidence.is_some();
    let (methods, must_run) = wanted.methods(args, Inputs { frames: true, companions: false, confidence })?;
    let ready = ready_for(methods, &started.1, must_run, || model(args, is_default_tracker))?;
    let goes_back = ready.iter().any(|m| m.detector.detector.needs_reverse());
    let signals = || ready.iter().flat_map(|method| &method.signals).map(Some);
    let lane = Lane::of_started(started)
        .with_signals(&run.context(), &Companions::default(), signals())
        .map_err(failure)?;
    // Frames are needed again only by runs back in time.
    let once = FrameCache::new(0);
    let frames = if goes_back { &*run.frames } else { &once };
    let Collected { states, signals } =
        follow_frames(&sequence, frames, lane, signals().count(), stop).map_err(failure)?;
    if let Some(path) = &args.save_boxes {
        save(path, &states, base).map_err(Failure::io)?;
    }
    let present: Vec<bool> = states.iter().map(|s| s.status != Status::Absent).collect();
    let regions: Vec<Region> = states.into_iter().map(|s| s.region).collect();
    let shown = regions.iter().cloned().map(Some).collect();
    let reversal = Reversal::new(run, regions);
    let methods = judge(&ready, &signals, &reversal, &present).map_err(failure)?;
    let judged = JudgedTrack { target: None, first: sequence.number(0), methods };
    Ok((UserTrack { judged, regions: shown }, ready))
}

/// Judges the track by the signals of the methods.
fn judge(
    methods: &[Method],
    signals: &[Vec<f64>],
    reversal: &Reversal,
    present: &[bool],
) -> Result<Vec<JudgedMethod>, TrackingError> {
    let mut judged = Vec::new();
    // Detectors need no ground truth; only the oracle reads the error, and it is not among these methods.
    let unknown = vec![f64::NAN; present.len()];
    let mut signals = signals.iter().map(Vec::as_slice);
    for method in methods {
        let widths = method.signals.iter().map(|choice| choice.signal.width());
        let columns = columns(signals.by_ref().take(method.signals.len()).zip(widths));
        let mine: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let Some((signal, more)) = mine.split_first() else { continue };
        let detector = &*method.detector.detector;
        let seed = seed::seed(0, &[&method.name]);
        let input = Input { signal, more, error: &unknown, seed, reverse: None };
        let output = reverse::detect(detector, input, Some(reversal))?;
        judged.push(JudgedMethod::new(&method.name, detector, &output, 0, present));
    }
    Ok(judged)
}

/// Collects states and signals until the user interrupts.
struct Interruptible<'a> {
    collector: Collector,
    stop: &'a Stop,
}

impl FrameObserver for Interruptible<'_> {
    fn check_interrupted(&self) -> Result<(), Interrupted> {
        if self.stop.is_set() { Err(Interrupted) } else { Ok(()) }
    }

    fn tracked(&self, lane: usize, step: LaneStep<'_>) -> Result<(), TrackingError> {
        self.collector.tracked(lane, step)
    }

    fn measured(&self, lane: usize, signal: usize, values: &[f64]) {
        self.collector.measured(lane, signal, values);
    }
}

/// Gives all frames of a sequence to a lane with a number of signals, and collects its results.
fn follow_frames(
    sequence: &Arc<Sequence>,
    frames: &FrameCache,
    lane: Lane,
    signals: usize,
    stop: &Stop,
) -> Result<Collected, TrackingError> {
    let observer = Interruptible { collector: Collector::new([signals]), stop };
    let (cores, mut lanes) = (Cores::new(rayon::current_num_threads()), [Ok(lane)]);
    let _share = cores.enter();
    run_frames_on(&cores, sequence, frames, &mut lanes, &observer)?;
    let [lane] = lanes;
    lane?;
    Ok(observer.collector.into_collected().swap_remove(0))
}

/// The box of `--init`.
fn first_box(text: &str, base: Base) -> Result<Region, Failure> {
    let boxes = results::parse_boxes(Path::new("--init"), text.as_bytes(), base);
    let boxes = boxes.map_err(Failure::usage)?;
    match boxes.as_slice() {
        [one] => Ok(one.clone()),
        _ => Err(Failure::usage(format!("--init takes one box, x,y,w,h, not `{text}`"))),
    }
}

/// Writes the boxes of a track, and its confidence beside them if the tracker gives one.
fn save(path: &Path, states: &[TrackerState], base: Base) -> Result<(), StoreError> {
    let regions: Vec<Region> = states.iter().map(|s| s.region.clone()).collect();
    let status: Vec<Status> = states.iter().map(|s| s.status).collect();
    store::write_output(path, write::boxes(&regions, &status, base).as_bytes())?;
    let confidence: Vec<Option<f64>> = states.iter().map(|s| s.confidence).collect();
    if confidence.iter().any(Option::is_some) {
        store::write_output(&write::confidence_path(path), write::confidence(&confidence).as_bytes())?;
    }
    Ok(())
}

/// Parameters of the default tracker as the built-in model knows it.
fn built_in_params() -> serde_json::Value {
    live_tracker(DEFAULT_TRACKER, "{}").map_or(serde_json::Value::Null, |(_, config)| config.params())
}

/// The learned model of a consistent filter, if there is one for the tracker: the user's, else that of the default tracker.
fn model(args: &Args, is_default_tracker: bool) -> Result<Option<serde_json::Value>, Failure> {
    let (name, bytes) = match &args.model {
        Some(path) => {
            let bytes = crate::dataset::text::read_at_most(path, MAX_MODEL_FILE).map_err(Failure::data)?;
            (path.display().to_string(), bytes)
        }
        None if is_default_tracker => ("the built-in model".to_string(), BUILT_IN_MODEL.into()),
        None => return Ok(None),
    };
    let data = |e: &dyn std::fmt::Display| Failure::data(format!("{name}: {e}"));
    let mut file: serde_json::Value = serde_json::from_slice(&bytes).map_err(|e| data(&e))?;
    let model = file.get_mut("model").map(serde_json::Value::take);
    model.map(Some).ok_or_else(|| data(&"holds no learned model; AVU and ARTE* write one"))
}

/// A need of a method that a tracker with this first state does not meet.
fn lacks(method: &Method, state: &TrackerState) -> Option<&'static str> {
    let lacks = |reads: Reads| match reads {
        Reads::Companions => Some("needs other trackers' boxes"),
        _ if reads.is_in(state) => None,
        Reads::Posterior => Some("needs a tracker with a posterior, such as color-particle-filter or ivt"),
        Reads::Response => Some("needs a tracker with a response map, such as kcf, dsst or samf"),
        _ => reads.need_of_tracker(),
    };
    method.reads().find_map(lacks)
}

/// The methods that can judge the track of a tracker, which starts with this state.
fn ready_for(
    methods: Vec<Method>,
    state: &TrackerState,
    must_run: bool,
    model: impl Fn() -> Result<Option<serde_json::Value>, Failure>,
) -> Result<Vec<Method>, Failure> {
    let mut ready = Vec::new();
    for method in methods {
        let refuse = |reason: &str| Failure::usage(format!("method `{}` {reason}", method.name));
        let found = match (lacks(&method, state), method.detector.detector.learner()) {
            (Some(need), _) => Err(refuse(need)),
            (None, None) => Ok(method),
            (None, Some(_)) => match model()? {
                Some(model) => Ok(method.with_model(&model).map_err(Failure::data)?),
                None => Err(refuse("needs a model learned for this tracker; give --model")),
            },
        };
        match found {
            Ok(method) => ready.push(method),
            Err(_) if !must_run => {}
            Err(e) => return Err(e),
        }
    }
    Ok(ready)
}
