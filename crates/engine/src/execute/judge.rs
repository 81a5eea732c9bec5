//! DetectorOutput and scoring: from tracks with their signals to judged cells.

use super::context::Context;
use super::detector_outputs::{CachedDetectorOutput, StoredDetectorOutput};
use super::reverse::{self, Reversal};
use super::supervise::{Watchdog, supervised};
use super::track::Track;
use crate::detector::track_quality::Effort;
use crate::detector::{Detector, DetectorOutput, Input, Quality};
use crate::error::{CellError, RunError};
use crate::observe::tally::Work;
use crate::plan::recipes::{self, DetectorKey};
use crate::score::{Protocol, TrackScore};
use crate::spec::method::{FixedDetector, Method};
use crate::store::address::{Address, Recipe};
use crate::store::{self, Name, Record};
use std::sync::Arc;

/// One method on one track, judged.
#[derive(Debug, Clone)]
pub struct Judged {
    /// What the detector said.
    pub verdict: CachedDetectorOutput,
    /// What the protocol makes of it.
    pub score: TrackScore,
    /// How much it had the tracker run backwards.
    pub effort: Effort,
    /// Whether the verdict holds a [`Quality`].
    pub follows: bool,
}

/// A detector that is ready, and where its parameters come from.
#[derive(Clone)]
pub struct ReadyDetector {
    /// The detector.
    pub fixed: FixedDetector,
    /// Where its parameters or its model come from.
    pub source: Source,
}

/// Where a detector's parameters come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// They are given.
    Given,
    /// One was chosen; the address tells which and from what.
    Trained(Address),
    /// They are given, but for a model that was learned.
    Learned(Address),
}

impl ReadyDetector {
    fn by(&self) -> DetectorKey {
        match self.source {
            Source::Given => DetectorKey::given(&self.fixed),
            Source::Trained(address) => DetectorKey::model(address, &self.fixed),
            Source::Learned(address) => DetectorKey::learned(address, &self.fixed),
        }
    }
}

/// What a detector says of a track. `seed` is for detectors that draw random numbers.
///
/// # Errors
/// In words, when the tracker had to be run backwards and that broke.
pub fn detect(
    track: &Track,
    signal: Option<usize>,
    detector: &dyn Detector,
    seed: u64,
) -> Result<DetectorOutput, String> {
    let signal = track.signal(signal);
    let input = Input { signal: &signal, error: &track.error, seed, reverse: None };
    reverse::detect(detector, input, track.reversal.as_deref())
}

/// A cell that is to be judged.
#[derive(Clone)]
pub struct Case {
    /// Name in the store.
    pub name: Name,
    /// The track, if there is one.
    pub track: Arc<Track>,
    /// Which of its signals is read.
    pub signal: Option<usize>,
    /// The detector.
    pub ready_detector: ReadyDetector,
    /// Its seed.
    pub seed: u64,
    /// How its labels are scored.
    pub protocol: &'static Protocol,
}

impl Case {
    /// A cell of the test suite; `cell` is its name in the plan.
    pub fn new(
        context: &Context<'_>,
        cell: &str,
        track: &Arc<Track>,
        (variant, method): (usize, &Method),
        ready_detector: ReadyDetector,
        seed: u64,
    ) -> Self {
        let plan = context.plan;
        Self {
            protocol: method.protocol,
            name: Name { experiment: plan.experiment.name.clone(), cell: plan.stored_name(cell) },
            track: track.clone(),
            signal: plan.signal(variant),
            ready_detector,
            seed,
        }
    }
}

/// Judges cells, a result for each in order: with verdicts from the store where they are there.
///
/// # Errors
/// When the run is interrupted or the store cannot be written to.
pub fn judge(context: &Context<'_>, cases: Vec<Case>) -> Result<Vec<Result<Judged, CellError>>, RunError> {
    let plan = context.plan;
    let recipe = |case: &Case| {
        let read = plan.read(case.track.address, case.signal);
        recipes::labels(read, &case.ready_detector.by(), case.seed)
    };
    let recipes: Vec<_> = cases.iter().map(recipe).collect();
    let kept = |(case, recipe): (&Case, &Recipe)| {
        let rows = case.track.error.len();
        let stored = context.cached::<StoredDetectorOutput>(&recipe.address(), rows);
        stored.and_then(|v| v.on(&case.track.signal(case.signal)))
    };
    let mut verdicts: Vec<Option<Result<DetectorOutput, CellError>>> =
        cases.iter().zip(&recipes).map(|pair| kept(pair).map(Ok)).collect();
    verdicts.iter().for_each(|v| context.tally.add(Work::Labels, v.is_some()));
    let wanted: Vec<usize> = (0..cases.len()).filter(|k| verdicts[*k].is_none()).collect();
    if !wanted.is_empty() {
        let todo: Vec<Case> = wanted.iter().map(|k| cases[*k].clone()).collect();
        let work = move |watch: &Watchdog, out: &[Option<String>]| {
            let mut done = Vec::with_capacity(todo.len());
            for (k, (case, out)) in todo.iter().zip(out).enumerate() {
                watch.check_interrupted()?;
                done.push(match out {
                    Some(reason) => Err(reason.clone()),
                    None => watch
                        .step(k, || {
                            detect(&case.track, case.signal, &*case.ready_detector.fixed.detector, case.seed)
                        })
                        .flatten(),
                });
            }
            Ok(done)
        };
        let made = supervised(wanted.len(), &context.options.limits, work)?;
        cases.iter().filter_map(|case| case.track.reversal.as_deref()).for_each(Reversal::rest);
        let mut records: Vec<Record> = Vec::new();
        for (k, made) in wanted.into_iter().zip(made) {
            let case = &cases[k];
            let made = made.map_err(|reason| CellError::Failed(format!("{}: {reason}", case.name.cell)));
            if let Ok(verdict) = &made {
                let signal = case.track.signal(case.signal);
                let content = StoredDetectorOutput::new(verdict, &signal);
                records.push(store::record(case.name.clone(), recipes[k].clone(), signal.len(), &content)?);
            }
            verdicts[k] = Some(made);
        }
        context.put(records)?;
    }
    let judged = |((case, recipe), verdict): ((&Case, _), Option<Result<DetectorOutput, CellError>>)| {
        let verdict = verdict.unwrap_or_else(|| Err(CellError::Failed("was not judged".to_string())))?;
        let score = (case.protocol.score)(&case.track.error, &verdict.alarm, &verdict.changes());
        let effort = verdict.quality.as_ref().map_or_else(Effort::default, Quality::effort);
        let follows = verdict.quality.is_some();
        Ok(Judged { verdict: context.outputs.insert(recipe, verdict), score, effort, follows })
    };
    Ok(cases.iter().zip(&recipes).zip(verdicts).map(judged).collect())
}
