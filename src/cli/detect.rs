//! `trackfail detect --frames DIR --boxes FILE [--method NAME]...` and
//! `trackfail detect --frames DIR --init X,Y,W,H [--method NAME]...`

use super::live::live_tracker;
use super::{Failure, output};
use crate::dataset::format::otb;
use crate::dataset::frame_cache::FrameCache;
use crate::dataset::{DatasetError, Sequence};
use crate::detector::Input;
use crate::engine::execute::cores::Cores;
use crate::engine::execute::frame_loop::{Collected, Collector, run_frames_on};
use crate::engine::execute::lane::{Companions, Lane};
use crate::engine::execute::reverse::{self, FRAMES_IN_MEMORY, Reversal};
use crate::engine::execute::tracker_run::{TrackerRun, TrackingError};
use crate::engine::store::{self, StoreError};
use crate::num::seed;
use crate::region::Region;
use crate::results::detections::{self, MethodOutput};
use crate::signal::Reads;
use crate::spec::builtin;
use crate::spec::method::{DetectorChoice, FixedDetector, Method, SignalChoice, Variant};
use crate::tracker::results::{self, Base, write};
use crate::tracker::{RunContext, Status, TrackerState};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Arguments of `detect`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Prints CSV: frame,method,score,label,change,state. label is 1 in frames with an alarm, change is 1 where alarms begin and \
-1 where they end, state is lost from an alarm until the recovery is confirmed, else tracking. Methods run with their published \
thresholds. With --init the video is tracked first; methods that read a tracker's posterior (AVU, ARTE*, ...) need that. \
Their model of a consistent filter is built in for the default tracker, learned on rendered sequences; --model takes \
another one."
)]
#[command(group = clap::ArgGroup::new("track").required(true).args(["boxes", "init"]))]
pub struct Args {
    /// Folder of the video's frames (.jpg or .png, numbered)
    #[arg(long, value_name = "DIR")]
    frames: PathBuf,
    /// The tracker's boxes, a line `x,y,w,h` for each frame; a header line is allowed
    #[arg(long, value_name = "FILE")]
    boxes: Option<PathBuf>,
    /// Instead of boxes: where the target is in the first frame, `x,y,w,h`; a built-in tracker follows it
    #[arg(long, value_name = "BOX", allow_hyphen_values = true)]
    init: Option<String>,
    /// Method (may be given several times; default: all)
    #[arg(long, value_name = "NAME")]
    method: Vec<String>,
    /// Number of the top left pixel in the boxes: 1 as in OTB, or 0
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(0..=1))]
    base: u8,
    /// With --init: the tracker (see `trackfail list trackers`)
    #[arg(long, value_name = "KIND", default_value = DEFAULT_TRACKER, requires = "init")]
    tracker: String,
    /// With --init: the tracker's parameters as a TOML table
    #[arg(long, value_name = "TABLE", default_value = "{}", requires = "init")]
    params: String,
    /// With --init: seed of trackers that draw random numbers
    #[arg(long, value_name = "N", default_value_t = 0, requires = "init")]
    seed: u64,
    /// With --init: a model learned by AVU or ARTE*, a file of the folder `models` of an experiment's results
    #[arg(long, value_name = "FILE", requires = "init")]
    model: Option<PathBuf>,
    /// With --init: where to write the tracker's boxes, a line `x,y,w,h` for each frame; its confidence, if it gives one,
    /// goes beside them
    #[arg(long, value_name = "FILE", requires = "init")]
    save_boxes: Option<PathBuf>,
}

/// The tracker that the built-in model is about.
const DEFAULT_TRACKER: &str = "color-particle-filter";

/// The model that AVU learned in `sanmiguel2015/built-in-model`.
const BUILT_IN_MODEL: &str = include_str!("../../assets/models/color-particle-filter.json");

/// Size of the largest model file, in bytes.
const MAX_MODEL_FILE: u64 = 1 << 24;

/// A method with its detector.
struct ReadyMethod {
    method: Method,
    detector: FixedDetector,
}

impl ReadyMethod {
    /// Its signals; `None` for a method without one.
    fn signals(&self) -> Vec<Option<&SignalChoice>> {
        let more = self.method.variants.iter().take(1).flat_map(|v| &v.more_signals).map(Some);
        let first = self.method.variants.first().and_then(|v| v.signal.as_ref());
        std::iter::once(first).chain(more).collect()
    }
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let all = published()?;
    let mut named: Vec<Method> = Vec::new();
    for name in &args.method {
        let again = named.iter().any(|m| m.name == *name);
        let method = all.iter().position(|m| m.name == *name);
        match method {
            _ if again => return Err(Failure::usage(format!("method `{name}` is given twice"))),
            None => {
                let known = all.iter().map(|m| m.name.as_str());
                return Err(Failure::usage(crate::plugin::unknown("method", name, known)));
            }
            Some(_) => named.extend(published()?.into_iter().filter(|m| m.name == *name)),
        }
    }
    let is_default = named.is_empty();
    let methods = if is_default { all } else { named };
    let options = otb::Options { truth: otb::Truth::Ignored, ..otb::Options::default() };
    let data = |e: DatasetError| Failure::data(e.to_string());
    match (&args.boxes, &args.init) {
        (Some(boxes), _) => {
            let methods = on_boxes(methods, is_default)?;
            let regions = results::read_boxes(boxes, base(args)).map_err(data)?;
            let sequence = otb::load(&args.frames, &options).map_err(data)?;
            if regions.len() != sequence.len() {
                return Err(Failure::data(format!(
                    "{} has {} boxes, but {} has {} frames; there must be one box for each frame",
                    boxes.display(),
                    regions.len(),
                    args.frames.display(),
                    sequence.len()
                )));
            }
            let states = regions.into_iter().map(TrackerState::tracked).collect();
            let sequence = Arc::new(sequence);
            let context =
                RunContext { sequence: &sequence, start_frame: 0, run: 0, seed: 0, data_roots: &[] };
            let lane = Lane::of_states(Arc::new(states));
            let lane = lane.with_signals(&context, &Companions::default(), signals_of(&methods));
            let frames = FrameCache::new(0);
            let collected =
                lane.and_then(|lane| follow(&sequence, &frames, lane, signals_of(&methods).len()));
            let Collected { signals, .. } = collected.map_err(|e| Failure::data(e.to_string()))?;
            print(&sequence, &methods, &signals, None)
        }
        (None, init) => {
            let first = first_box(init.as_deref().unwrap_or_default(), base(args))?;
            let mut sequence = otb::load(&args.frames, &options).map_err(data)?;
            if let Some(truth) = sequence.truth.first_mut() {
                *truth = Some(first);
            }
            track(args, Arc::new(sequence), methods, is_default)
        }
    }
}

fn base(args: &Args) -> Base {
    if args.base == 0 { Base::Zero } else { Base::One }
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

fn published() -> Result<Vec<Method>, Failure> {
    let methods = builtin::method_names().into_iter().filter_map(builtin::published_method);
    methods.map(|m| m.map_err(Failure::io)).collect()
}

/// The methods that need only frames and boxes.
fn on_boxes(methods: Vec<Method>, is_default: bool) -> Result<Vec<ReadyMethod>, Failure> {
    let fits = |v: &Variant| {
        let given = v.signals().all(|s| matches!(s.signal.reads(), Reads::Boxes | Reads::Pixels));
        given && matches!(v.detector, DetectorChoice::Given(_)) && !v.detector.needs_reverse()
    };
    let mut ready = Vec::new();
    for method in methods {
        match method.variants.first().map(|v| (fits(v), &v.detector)) {
            Some((true, DetectorChoice::Given(fixed))) => {
                let detector = fixed.clone();
                ready.push(ReadyMethod { method, detector });
            }
            _ if is_default => {}
            _ => {
                let all = on_boxes(published()?, true)?;
                let names: Vec<&str> = all.iter().map(|r| r.method.name.as_str()).collect();
                return Err(Failure::usage(format!(
                    "method `{}` needs more of a tracker than boxes; give --init instead of --boxes. Methods that \
                     need only boxes: {}",
                    method.name,
                    names.join(", ")
                )));
            }
        }
    }
    Ok(ready)
}

/// Tracks the target from its first box, and prints where the track cannot be trusted.
fn track(
    args: &Args,
    sequence: Arc<Sequence>,
    methods: Vec<Method>,
    is_default: bool,
) -> Result<(), Failure> {
    let (entry, config) = live_tracker(&args.tracker, &args.params)?;
    let seed = seed::seed(args.seed, &["detect", entry.kind]);
    let goes_back = |m: &Method| m.variants.iter().any(|v| v.detector.needs_reverse());
    let goes_back = methods.iter().any(goes_back);
    let frames = Arc::new(FrameCache::new(if goes_back { FRAMES_IN_MEMORY } else { 0 }));
    let failure = |e: TrackingError| match e {
        TrackingError::Tracker(e) => Failure::data(format!("{}: {e}", entry.kind)),
        e => Failure::data(e.to_string()),
    };
    let model = Models { args, is_default_tracker: config.params() == built_in_params() };
    let run = TrackerRun { sequence: sequence.clone(), frames, config, run: 0, seed, data_roots: Vec::new() };
    if sequence.is_empty() {
        return Err(Failure::data(format!("{} has no frame", args.frames.display())));
    }
    let started = run.frame(0).and_then(|frame| run.start(&frame)).map_err(failure)?;
    let ready = ready_for(methods, &started.1, is_default, &model)?;
    let lane = Lane::of_started(started)
        .with_signals(&run.context(), &Companions::default(), signals_of(&ready))
        .map_err(failure)?;
    let Collected { states, signals } =
        follow(&sequence, &run.frames, lane, signals_of(&ready).len()).map_err(failure)?;
    if let Some(path) = &args.save_boxes {
        save(path, &states, base(args)).map_err(Failure::io)?;
    }
    let regions: Vec<Region> = states.into_iter().map(|s| s.region).collect();
    let reversal = Reversal::new(run, regions);
    print(&sequence, &ready, &signals, Some(&reversal))
}

/// Writes the boxes of a track, and its confidence beside them if the tracker gives one.
fn save(path: &Path, states: &[TrackerState], base: Base) -> Result<(), StoreError> {
    let regions: Vec<Region> = states.iter().map(|s| s.region.clone()).collect();
    let status: Vec<Status> = states.iter().map(|s| s.status).collect();
    store::write(path, write::boxes(&regions, &status, base).as_bytes())?;
    let confidence: Vec<Option<f64>> = states.iter().map(|s| s.confidence).collect();
    if confidence.iter().any(Option::is_some) {
        store::write(&write::confidence_path(path), write::confidence(&confidence).as_bytes())?;
    }
    Ok(())
}

/// Parameters of the default tracker as the built-in model knows it.
fn built_in_params() -> serde_json::Value {
    live_tracker(DEFAULT_TRACKER, "{}").map_or(serde_json::Value::Null, |(_, config)| config.params())
}

/// Source of the learned model of a consistent filter.
struct Models<'a> {
    args: &'a Args,
    /// Whether the tracker is the one of the built-in model.
    is_default_tracker: bool,
}

impl Models<'_> {
    /// The model, if there is one for the tracker.
    fn model(&self) -> Result<Option<serde_json::Value>, Failure> {
        let (name, bytes) = match &self.args.model {
            Some(path) => {
                let bytes = crate::dataset::text::read_at_most(path, MAX_MODEL_FILE);
                (path.display().to_string(), bytes.map_err(|e| Failure::data(e.to_string()))?)
            }
            None if self.is_default_tracker => ("the built-in model".to_string(), BUILT_IN_MODEL.into()),
            None => return Ok(None),
        };
        let data = |e: &dyn std::fmt::Display| Failure::data(format!("{name}: {e}"));
        let file: serde_json::Value = serde_json::from_slice(&bytes).map_err(|e| data(&e))?;
        let model = file.get("model").cloned();
        model.map(Some).ok_or_else(|| data(&"holds no learned model; AVU and ARTE* write one"))
    }
}

/// A need of a method that a tracker with this first state does not meet.
fn lacks(variant: &Variant, state: &TrackerState) -> Option<&'static str> {
    let lacks = |reads: Reads| match reads {
        Reads::Companions => Some("needs other trackers' boxes"),
        _ if reads.is_in(state) => None,
        Reads::Posterior => Some("needs a tracker with a posterior, such as color-particle-filter or ivt"),
        Reads::Response => Some("needs a tracker with a response map, such as kcf, dsst or samf"),
        _ => reads.need_of_tracker(),
    };
    variant.signals().find_map(|s| lacks(s.signal.reads()))
}

/// The methods that can judge the track of a tracker, which starts with this state.
fn ready_for(
    methods: Vec<Method>,
    state: &TrackerState,
    is_default: bool,
    models: &Models<'_>,
) -> Result<Vec<ReadyMethod>, Failure> {
    let mut ready = Vec::new();
    for method in methods {
        let Some(variant) = method.variants.first() else { continue };
        let refuse = |reason: &str| Failure::usage(format!("method `{}` {reason}", method.name));
        let found = match &variant.detector {
            _ if lacks(variant, state).is_some() => Err(refuse(lacks(variant, state).unwrap_or_default())),
            DetectorChoice::Given(fixed) => Ok(fixed.clone()),
            DetectorChoice::Trained(_) => {
                Err(refuse("has a threshold that is trained on annotated sequences"))
            }
            DetectorChoice::Learned(fixed) => match (models.model()?, fixed.detector.learner()) {
                (Some(model), Some(learner)) => {
                    let detector = learner.with_model(&model).map_err(Failure::data)?;
                    Ok(FixedDetector { detector: Arc::from(detector), ..fixed.clone() })
                }
                _ => Err(refuse("needs a model learned for this tracker; give --model")),
            },
        };
        match found {
            Ok(detector) => ready.push(ReadyMethod { method, detector }),
            Err(_) if is_default => {}
            Err(e) => return Err(e),
        }
    }
    Ok(ready)
}

/// The signals of each method, one after the other; `None` for methods without one.
fn signals_of(methods: &[ReadyMethod]) -> Vec<Option<&SignalChoice>> {
    methods.iter().flat_map(ReadyMethod::signals).collect()
}

/// Gives all frames of a sequence to a lane with a number of signals, and collects its results.
fn follow(
    sequence: &Arc<Sequence>,
    frames: &FrameCache,
    lane: Lane,
    signals: usize,
) -> Result<Collected, TrackingError> {
    let collector = Collector::new([signals]);
    let (cores, mut lanes) = (Cores::new(rayon::current_num_threads()), [Ok(lane)]);
    let _share = cores.enter();
    run_frames_on(&cores, sequence, frames, &mut lanes, &collector)?;
    let [lane] = lanes;
    lane?;
    Ok(collector.into_collected().swap_remove(0))
}

fn print(
    sequence: &Sequence,
    methods: &[ReadyMethod],
    signals: &[Vec<f64>],
    reversal: Option<&Reversal>,
) -> Result<(), Failure> {
    let mut detected = Vec::new();
    // Detectors need no ground truth; only the oracle reads the error, and it is not among these methods.
    let unknown = vec![f64::NAN; sequence.len()];
    let mut signals = signals.iter().map(Vec::as_slice);
    for ready in methods {
        let mine: Vec<&[f64]> = signals.by_ref().take(ready.signals().len()).collect();
        let Some((signal, more)) = mine.split_first() else { continue };
        let ReadyMethod { method, detector } = ready;
        let seed = seed::seed(0, &[&method.name]);
        let input = Input { signal, more, error: &unknown, seed, reverse: None };
        let result = reverse::detect(&*detector.detector, input, reversal);
        detected.push(MethodOutput {
            method: &method.name,
            output: result.map_err(|e| Failure::data(e.to_string()))?,
            frames_to_recover: detector.detector.frames_to_recover(),
        });
    }
    let bytes = detections::csv(sequence, &detected).map_err(Failure::io)?;
    output::write(&String::from_utf8_lossy(&bytes))
}
