//! Cells: outputs of detectors on the tracks of a sequence, and their scores.

use super::context::Context;
use super::detector_outputs::StoredDetectorOutput;
use super::outcome::Cell;
use super::reverse;
use super::supervise::Job;
use super::track::{Track, Tracks};
use crate::error::{CellError, RunError, StepError};
use crate::plan::recipes::{self, DetectorKey};
use crate::plan::{Key, variants};
use crate::spec::method::FixedDetector;
use crate::store;
use crate::store::address::{Address, Stage};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use trackfail_methods::detector::track_quality::Effort;
use trackfail_methods::detector::{DetectorOutput, Input, Quality};
use trackfail_methods::score::TrackScore;

/// Result of a cell: the score of one method on one track.
#[derive(Debug, Clone)]
pub struct Judged {
    /// Output of the detector, if it is kept in memory.
    pub output: Option<Arc<DetectorOutput>>,
    /// Address of the output in the store.
    pub address: Address,
    /// Score by the protocol of the method.
    pub score: TrackScore,
    /// Use of reverse runs by the detector; `None` if its output has no [`Quality`], the condition of the tracker.
    pub effort: Option<Effort>,
    /// Frame ranges of the pieces that were scored separately, if restarts begin new tracks; otherwise empty.
    pub pieces: Vec<Range<usize>>,
}

/// A detector with its parameters or model.
pub struct ReadyDetector {
    /// Detector with all parameters set, learned ones included.
    pub fixed: FixedDetector,
    /// Part of the detector in the recipes of labels.
    pub key: DetectorKey,
}

/// Detectors by variant, tracker and part. An error where training was impossible; combinations that are
/// absent here have no cells.
pub type ReadyDetectors = BTreeMap<Key, Result<Arc<ReadyDetector>, CellError>>;

/// Computes the cells of `jobs` on a sequence of the test suite, in ascending order. `tracks` and `ready`
/// must have the tracks and detectors. Outputs in the store are not computed again.
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
    let (mut cells, mut records) = (Vec::new(), Vec::new());
    let is_mine = |(j, _): &(usize, usize)| jobs.binary_search(j).is_ok();
    for (j, v) in plan.cells_on(&planned.sequence.origin.source).into_iter().filter(is_mine) {
        let (job, (method, variant)) = (plan.jobs[j], variants[v]);
        let Some(detector) = ready.get(&(v, job.tracker, plan.part(variant, sequence))) else { continue };
        let (params, signals) = (variant.params(), plan.signals_of(v));
        let mut judge = || -> Result<Judged, StepError> {
            let read = plan.input(planned, j, v)?;
            let track = tracks[j].as_ref().map_err(CellError::clone)?;
            track.check(signals)?;
            let ReadyDetector { fixed, key } = &**detector.as_ref().map_err(CellError::clone)?;
            let seed = plan.seed(&method.name, &params, &planned.sequence.name, job);
            let recipe = key.labels(recipes::labels_on(read), seed);
            let (address, signal) = (recipe.address(), track.signal(signals.first().copied()));
            let stored = context.cached::<StoredDetectorOutput>(&address, signal.len());
            let cached = stored.and_then(|stored| stored.on(&signal));
            context.tally.add(Stage::Labels, cached.is_some());
            let detect = || -> Result<DetectorOutput, StepError> {
                let name = plan.name(plan.cell_name(&planned.sequence.name, job, &method.name, &params));
                let output = Job::new(&context.options.limits).step(|| detect(track, signals, fixed, seed));
                let output = output.map_err(|e| e.within(&name.cell))?;
                let content = StoredDetectorOutput::new(&output, &signal);
                records.push(store::record(name, recipe, signal.len(), &content)?);
                Ok(output)
            };
            let output = cached.map_or_else(detect, Ok)?;
            let (score, pieces) = track.judge(method.protocol, &output);
            let effort = output.quality.as_ref().map(Quality::effort);
            let output = context.outputs.keep(output);
            Ok(Judged { output, address, score, effort, pieces })
        };
        let result = StepError::settled(judge())?;
        cells.push(Cell {
            sequence,
            tracker: plan.experiment.trackers[job.tracker].label.clone(),
            run: job.run,
            method: method.name.clone(),
            params,
            job: j,
            signal: signals.first().copied(),
            threshold: detector.as_ref().ok().and_then(|ready| ready.fixed.detector.facts().threshold),
            result,
        });
    }
    context.store.put(&records)?;
    let reversals = jobs.iter().filter_map(|j| tracks[*j].as_ref().ok()?.reversal.as_ref());
    reversals.for_each(|reversal| reversal.free_trackers());
    Ok(cells)
}

/// Output of a detector on a track. `seed` is for detectors that draw random numbers.
///
/// A detector that begins again at each restart is given the pieces one by one. Frames between pieces get no
/// alarm and the score of the frame before.
///
/// # Errors
/// When a reverse run failed.
pub fn detect(
    track: &Track,
    signals: &[usize],
    fixed: &FixedDetector,
    seed: u64,
) -> Result<DetectorOutput, StepError> {
    let (signal, more) = (track.signal(signals.first().copied()), track.more(signals));
    let input = Input { signal: &signal, more: &more, error: &track.error, seed, reverse: None };
    let pieces = fixed.restarts.pieces(&track.status);
    if pieces.len() < 2 && pieces.first().is_none_or(|piece| piece.end == track.error.len()) {
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

/// Extends scores to `frames` values by repeating the last one.
fn hold(scores: &mut Vec<f64>, frames: usize) {
    let last = scores.last().copied().unwrap_or_default();
    scores.resize(frames, last);
}
