//! DetectorOutput and scoring: from tracks with their signals to judged cells.

use super::context::Context;
use super::detector_outputs::{CachedDetectorOutput, StoredDetectorOutput};
use super::reverse::{self, Reversal};
use super::supervise::{JobError, Watchdog, supervised};
use super::track::Track;
use super::tracker_run::TrackingError;
use crate::error::{CellError, RunError};
use crate::limits::Interrupted;
use crate::observe::tally::Work;
use crate::plan::SignalSet;
use crate::plan::recipes::{self, DetectorKey, Read};
use crate::spec::method::{FixedDetector, Method};
use crate::store::address::{Address, Recipe};
use crate::store::{self, Name, Record};
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

/// A detector with its parameters or model, and their source.
#[derive(Clone)]
pub struct ReadyDetector {
    /// The detector.
    pub fixed: FixedDetector,
    /// Source of its parameters or model.
    pub source: ParameterSource,
}

/// Source of a detector's parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterSource {
    /// The experiment gives them.
    Given,
    /// One of them is trained; the address is that of the trained parameter.
    Trained(Address),
    /// The experiment gives them, except for a learned model with this address.
    Learned(Address),
}

impl ReadyDetector {
    fn key(&self) -> DetectorKey {
        match self.source {
            ParameterSource::Given => DetectorKey::given(&self.fixed),
            ParameterSource::Trained(address) => DetectorKey::model(address, &self.fixed),
            ParameterSource::Learned(address) => DetectorKey::learned(address, &self.fixed),
        }
    }
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
    let mut whole = DetectorOutput::default();
    for piece in pieces {
        let more: Vec<&[f64]> = more.iter().map(|series| &series[piece.clone()]).collect();
        let (signal, error) = (&signal[piece.clone()], &track.error[piece.clone()]);
        let output = reverse::detect(&*fixed.detector, Input { signal, more: &more, error, ..input }, None)?;
        fill(&mut whole, piece.start);
        append(&mut whole, output);
    }
    fill(&mut whole, track.error.len());
    Ok(whole)
}

/// Lengthens an output by silent frames up to a number of frames.
fn fill(whole: &mut DetectorOutput, frames: usize) {
    let last = whole.score.last().copied().unwrap_or_default();
    whole.score.resize(frames, last);
    whole.alarm.resize(frames, false);
    whole.alarm_score.iter_mut().for_each(|scores| {
        let last = scores.last().copied().unwrap_or_default();
        scores.resize(frames, last);
    });
    whole.forecast.iter_mut().for_each(|forecast| forecast.resize(frames, f64::NAN));
    whole.changes.iter_mut().for_each(|changes| changes.resize(frames, 0));
}

/// Puts the output on a piece behind those before it.
fn append(whole: &mut DetectorOutput, piece: DetectorOutput) {
    let before = whole.score.len();
    if let Some(scores) = piece.alarm_score {
        whole.alarm_score.get_or_insert_with(|| whole.score.clone()).extend(scores);
    }
    whole.score.extend(piece.score);
    whole.alarm.extend(piece.alarm);
    if let Some(forecast) = piece.forecast {
        whole.forecast.get_or_insert_with(|| vec![f64::NAN; before]).extend(forecast);
    }
    if let Some(changes) = piece.changes {
        whole.changes.get_or_insert_with(|| vec![0; before]).extend(changes);
    }
}

/// A cell to be judged.
#[derive(Clone)]
pub struct PendingCell {
    /// Name in the store.
    pub name: Name,
    /// The track.
    pub track: Arc<Track>,
    /// Input of the detector: the signal on the track, or the track.
    pub read: Read,
    /// The signals that the method reads.
    pub signals: SignalSet,
    /// The detector.
    pub ready_detector: ReadyDetector,
    /// Its seed.
    pub seed: u64,
    /// Protocol that scores its labels.
    pub protocol: &'static Protocol,
}

impl PendingCell {
    /// A cell of the test suite; `cell` is its name in the plan.
    pub fn new(
        context: &Context<'_>,
        cell: &str,
        (track, read): (&Arc<Track>, Read),
        (variant, method): (usize, &Method),
        ready_detector: ReadyDetector,
        seed: u64,
    ) -> Self {
        let plan = context.plan;
        Self {
            protocol: method.protocol,
            name: Name { experiment: plan.experiment.name.clone(), cell: plan.stored_name(cell) },
            track: track.clone(),
            read,
            signals: plan.signals_of(variant).clone(),
            ready_detector,
            seed,
        }
    }
}

/// Judges cells and returns a result for each, in order; outputs of detectors that the store has are not computed again.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn judge(
    context: &Context<'_>,
    cells: Vec<PendingCell>,
) -> Result<Vec<Result<Judged, CellError>>, RunError> {
    let recipe = |cell: &PendingCell| recipes::labels(cell.read, &cell.ready_detector.key(), cell.seed);
    let recipes: Vec<_> = cells.iter().map(recipe).collect();
    let cached = |(cell, recipe): (&PendingCell, &Recipe)| {
        let stored = context.cached::<StoredDetectorOutput>(&recipe.address(), cell.track.error.len());
        stored.and_then(|output| output.on(&cell.track.signal(cell.signals.first)))
    };
    let mut outputs: Vec<Option<Result<DetectorOutput, CellError>>> =
        cells.iter().zip(&recipes).map(|pair| cached(pair).map(Ok)).collect();
    outputs.iter().for_each(|output| context.tally.add(Work::Labels, output.is_some()));
    let pending: Vec<usize> = (0..cells.len()).filter(|k| outputs[*k].is_none()).collect();
    if !pending.is_empty() {
        let computed = compute(context, pending.iter().map(|k| cells[*k].clone()).collect())?;
        let mut records: Vec<Record> = Vec::new();
        for (k, output) in pending.into_iter().zip(computed) {
            let cell = &cells[k];
            let output = output.map_err(|e| CellError::Failed(format!("{}: {e}", cell.name.cell)));
            if let Ok(output) = &output {
                let signal = cell.track.signal(cell.signals.first);
                let content = StoredDetectorOutput::new(output, &signal);
                records.push(store::record(cell.name.clone(), recipes[k].clone(), signal.len(), &content)?);
            }
            outputs[k] = Some(output);
        }
        context.put(records)?;
    }
    let judged =
        |((cell, recipe), output): ((&PendingCell, _), Option<Result<DetectorOutput, CellError>>)| {
            let output = output.unwrap_or_else(|| Err(CellError::Failed("was not judged".to_string())))?;
            let (score, pieces) = cell.track.judge(cell.protocol, &output);
            let effort = output.quality.as_ref().map_or_else(Effort::default, Quality::effort);
            let follows = output.quality.is_some();
            Ok(Judged { output: context.outputs.insert(recipe, output), score, effort, follows, pieces })
        };
    Ok(cells.iter().zip(&recipes).zip(outputs).map(judged).collect())
}

/// Outputs of the cells' detectors, supervised.
fn compute(
    context: &Context<'_>,
    cells: Vec<PendingCell>,
) -> Result<Vec<Result<DetectorOutput, TrackingError>>, Interrupted> {
    let tracks: Vec<Arc<Track>> = cells.iter().map(|cell| cell.track.clone()).collect();
    let jobs = cells.len();
    let work = move |watch: &Watchdog, left_out: &[Option<JobError>]| {
        let mut outputs = Vec::with_capacity(cells.len());
        for (k, (cell, left_out)) in cells.iter().zip(left_out).enumerate() {
            watch.check_interrupted()?;
            let fixed = &cell.ready_detector.fixed;
            outputs.push(match left_out {
                Some(reason) => Err(reason.clone().into()),
                None => watch.step(k, || detect(&cell.track, &cell.signals, fixed, cell.seed)),
            });
        }
        Ok(outputs)
    };
    let outputs = supervised(jobs, &context.options.limits, work)?;
    tracks.iter().filter_map(|track| track.reversal.as_deref()).for_each(Reversal::free_trackers);
    Ok(outputs)
}
