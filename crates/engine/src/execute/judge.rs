//! Cells: outputs of detectors on the tracks of a sequence, and their scores.

use super::context::Context;
use super::detector_outputs::{CachedDetectorOutput, StoredDetectorOutput};
use super::outcome::Cell;
use super::reverse::{self, Reversal};
use super::supervise::Job;
use super::track::{Track, Tracks};
use super::tracker_run::TrackingError;
use crate::error::{CellError, RunError};
use crate::limits::{Interrupted, RunLimits};
use crate::observe::tally::Work;
use crate::plan::recipes::{self, DetectorKey};
use crate::plan::{SignalSet, variants};
use crate::spec::method::FixedDetector;
use crate::store::address::Recipe;
use crate::store::{self, Name};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use trackfail_methods::detector::track_quality::Effort;
use trackfail_methods::detector::{DetectorOutput, Input, Quality};
use trackfail_methods::score::{Protocol, TrackScore};

/// One method on one track, judged.
#[derive(Debug, Clone)]
pub struct Judged {
    /// Output of the detector.
    pub output: CachedDetectorOutput,
    /// Its score by the protocol.
    pub score: TrackScore,
    /// Its use of reverse runs.
    pub effort: Effort,
    /// Whether the output holds a [`Quality`].
    pub follows: bool,
    /// The pieces of the track that were scored by themselves, where a restart begins a new track; else none.
    pub pieces: Vec<Range<usize>>,
}

/// A detector with its parameters or model.
pub struct ReadyDetector {
    /// The detector.
    pub fixed: FixedDetector,
    /// What it adds to the recipes of its labels.
    pub key: DetectorKey,
}

/// Detectors by variant, tracker and [part](crate::plan::ExperimentPlan::parts); an error where training was impossible.
/// Those without a place here have no cells.
pub type ReadyDetectors = BTreeMap<(usize, usize, usize), Result<Arc<ReadyDetector>, CellError>>;

/// A detector on a track.
struct Task {
    name: Name,
    track: Arc<Track>,
    signals: SignalSet,
    detector: Arc<ReadyDetector>,
    seed: u64,
    protocol: &'static Protocol,
    recipe: Recipe,
    /// The output that the store has.
    cached: Option<Arc<DetectorOutput>>,
}

type Output = Result<Arc<DetectorOutput>, CellError>;

impl Task {
    /// The output of the detector.
    fn output(&self, limits: &RunLimits) -> Result<Output, Interrupted> {
        if let Some(output) = &self.cached {
            return Ok(Ok(output.clone()));
        }
        let detect = || detect(&self.track, &self.signals, &self.detector.fixed, self.seed);
        match Job::new(limits).step(detect) {
            Err(TrackingError::Interrupted(e)) => Err(e),
            Err(e) => Ok(Err(CellError::Failed(format!("{}: {e}", self.name.cell)))),
            Ok(output) => Ok(Ok(Arc::new(output))),
        }
    }
}

/// The cells of `jobs`, in ascending order, on a sequence of the test suite, which have their `tracks` and `ready`
/// detectors. Outputs that the store has are not computed again.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn cells(
    context: &Context<'_>,
    sequence: usize,
    jobs: &[usize],
    tracks: &Tracks,
    ready: &ReadyDetectors,
) -> Result<Vec<Cell>, RunError> {
    let plan = context.plan;
    let planned = &plan.test().sequences[sequence];
    let variants: Vec<_> = variants(plan.experiment).collect();
    let (mut cells, mut tasks) = (Vec::new(), Vec::new());
    for (j, v) in
        plan.cells_on(&planned.origin.source).into_iter().filter(|(j, _)| jobs.binary_search(j).is_ok())
    {
        let (job, (method, variant)) = (plan.jobs[j], variants[v]);
        let Some(detector) = ready.get(&(v, job.tracker, plan.part(variant, sequence))) else { continue };
        let params = variant.params();
        let task = || -> Result<Task, CellError> {
            let read = plan.input(planned, j, v)?;
            let (track, detector) = (tracks[j].clone()?, detector.clone()?);
            let seed = plan.seed(&method.name, &params, &planned.sequence.name, job);
            let cell = plan.cell_name(&planned.sequence.name, job, &method.name, &params);
            let (signals, recipe) = (plan.signals_of(v).clone(), recipes::labels(read, &detector.key, seed));
            let stored = context.cached::<StoredDetectorOutput>(&recipe.address(), track.error.len());
            let cached = stored.and_then(|stored| stored.on(&track.signal(signals.first))).map(Arc::new);
            context.tally.add(Work::Labels, cached.is_some());
            let name = Name { experiment: plan.experiment.name.clone(), cell: plan.stored_name(&cell) };
            Ok(Task { name, track, signals, detector, seed, protocol: method.protocol, recipe, cached })
        };
        tasks.push(task());
        cells.push(move |result| Cell {
            sequence,
            tracker: plan.experiment.trackers[job.tracker].label.clone(),
            run: job.run,
            method: method.name.clone(),
            params,
            job: j,
            signal: plan.signal(v),
            threshold: detector.as_ref().ok().and_then(|ready| ready.fixed.detector.threshold()),
            result,
        });
    }
    let judged = judge(context, tasks)?;
    Ok(cells.into_iter().zip(judged).map(|(cell, judged)| cell(judged)).collect())
}

/// A result for each task, in order.
fn judge(
    context: &Context<'_>,
    tasks: Vec<Result<Task, CellError>>,
) -> Result<Vec<Result<Judged, CellError>>, RunError> {
    let output = |task: &Result<Task, CellError>| match task {
        Ok(task) => task.output(&context.options.limits),
        Err(e) => Ok(Err(e.clone())),
    };
    let outputs = tasks.iter().map(output).collect::<Result<Vec<Output>, Interrupted>>()?;
    let mut records = Vec::new();
    for (task, output) in tasks.iter().zip(&outputs) {
        if let (Ok(task @ Task { cached: None, .. }), Ok(output)) = (task, output) {
            let signal = task.track.signal(task.signals.first);
            let content = StoredDetectorOutput::new(output, &signal);
            records.push(store::record(task.name.clone(), task.recipe.clone(), signal.len(), &content)?);
        }
    }
    context.put(records)?;
    tasks
        .iter()
        .flatten()
        .filter_map(|task| task.track.reversal.as_deref())
        .for_each(Reversal::free_trackers);
    let judged = |(task, output): (&Result<Task, CellError>, Output)| {
        let task = task.as_ref().map_err(Clone::clone)?;
        let output = output?;
        let (score, pieces) = task.track.judge(task.protocol, &output);
        let effort = output.quality.as_ref().map_or_else(Effort::default, Quality::effort);
        let follows = output.quality.is_some();
        Ok(Judged { output: context.outputs.insert(&task.recipe, output), score, effort, follows, pieces })
    };
    Ok(tasks.iter().zip(outputs).map(judged).collect())
}

/// Output of a detector on a track. `seed` is for detectors that draw random numbers.
///
/// A detector that begins again with each restart sees one piece after the other; the frames between them have no alarm
/// and the score of the frame before.
///
/// # Errors
/// When a reverse run failed.
pub fn detect(
    track: &Track,
    signals: &SignalSet,
    fixed: &FixedDetector,
    seed: u64,
) -> Result<DetectorOutput, TrackingError> {
    let (signal, more) = (track.signal(signals.first), track.more(signals));
    let input = Input { signal: &signal, more: &more, error: &track.error, seed, reverse: None };
    let pieces = fixed.restarts.pieces(&track.status);
    if pieces.len() < 2 {
        return reverse::detect(&*fixed.detector, input, track.reversal.as_deref());
    }
    let frames = track.error.len();
    let mut whole = DetectorOutput { alarm: vec![false; frames], ..DetectorOutput::default() };
    for piece in pieces {
        let more: Vec<&[f64]> = more.iter().map(|series| &series[piece.clone()]).collect();
        let (signal, error) = (&signal[piece.clone()], &track.error[piece.clone()]);
        let output = reverse::detect(&*fixed.detector, Input { signal, more: &more, error, ..input }, None)?;
        hold(&mut whole.score, piece.start);
        if let Some(scores) = output.alarm_score {
            let before = whole.alarm_score.get_or_insert_with(|| whole.score.clone());
            hold(before, piece.start);
            before.extend(scores);
        }
        whole.score.extend(output.score);
        whole.alarm[piece.clone()].copy_from_slice(&output.alarm);
        if let Some(forecast) = output.forecast {
            let all = whole.forecast.get_or_insert_with(|| vec![f64::NAN; frames]);
            all[piece.clone()].copy_from_slice(&forecast);
        }
        if let Some(changes) = output.changes {
            whole.changes.get_or_insert_with(|| vec![0; frames])[piece].copy_from_slice(&changes);
        }
    }
    hold(&mut whole.score, frames);
    whole.alarm_score.iter_mut().for_each(|scores| hold(scores, frames));
    Ok(whole)
}

/// Lengthens scores to a number of frames, with the last one.
fn hold(scores: &mut Vec<f64>, frames: usize) {
    let last = scores.last().copied().unwrap_or_default();
    scores.resize(frames, last);
}
