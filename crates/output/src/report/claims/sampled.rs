//! The numbers of claims, with how far other sequences might move them.

use crate::engine::execute::analyse::Analysed;
use crate::num::pooled::Draws;
use crate::num::seed;
use crate::report::units::{UnitCounts, counts_of_sequences, metric_of_sum};
use crate::results::{CellScore, Measure, Results, method_label};
use crate::score::Metric;
use crate::score::metric::Source;
use crate::spec::claim::{Measured, Quantity, Reference, Spread};
use crate::table::layout;
use crate::table::leaderboard::MIN_SEQUENCES;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

/// Samples of the sequences for each interval.
const DRAWS: usize = 2000;

/// A metric by name, and of what tracker and method.
type Drawn = (&'static str, (String, String));

/// Numbers of an experiment, computed from the same samples of its sequences.
pub struct Samples<'a> {
    results: &'a Results,
    counts: UnitCounts,
    sequences: Vec<&'a str>,
    draws: Draws,
    /// What was drawn before: claims speak of the same numbers again and again.
    known: RefCell<BTreeMap<Drawn, Spread>>,
}

impl<'a> Samples<'a> {
    /// Draws the samples; `scores` are those of [`Results::scores`].
    pub fn new(results: &'a Results, scores: &'a [CellScore]) -> Self {
        let sequences: BTreeSet<&str> = scores.iter().map(|s| s.sequence.as_str()).collect();
        let seed = seed::seed(results.manifest.seed, &["claims", &results.experiment.name]);
        let draws = Draws::new(sequences.len(), if scores.is_empty() { 0 } else { DRAWS }, seed);
        let counts = counts_of_sequences(scores);
        Self { results, counts, sequences: sequences.into_iter().collect(), draws, known: RefCell::default() }
    }

    /// The number of a reference that names its tracker, where there is one.
    pub fn value(&self, r: &Reference) -> Option<f64> {
        let tracker = r.tracker.as_deref()?;
        match &r.quantity {
            Quantity::Metric(metric, method) => {
                layout::measure_of(&self.results.measures, tracker, method, &r.point)?.value(*metric)
            }
            Quantity::Finding(made) => {
                let mine = |a: &&Analysed| a.analysis == made.analysis && a.tracker == tracker;
                self.results.analyses.iter().find(mine)?.findings.number(&made.part)
            }
        }
    }

    /// The number with its spread: samples for what is made of counts, bounds for measures of frames; effort and numbers
    /// of analyses are taken as they are.
    pub fn measured(&self, r: &Reference) -> Option<Measured> {
        let value = self.value(r)?;
        Some(Measured { value, spread: self.spread(r) })
    }

    fn spread(&self, r: &Reference) -> Spread {
        let (Quantity::Metric(metric, method), Some(tracker)) = (&r.quantity, r.tracker.as_deref()) else {
            return Spread::Exact;
        };
        let Some(found) = layout::measure_of(&self.results.measures, tracker, method, &r.point) else {
            return Spread::Exact;
        };
        match metric.source() {
            Source::Counts => self.draws(*metric, found),
            Source::Frames => {
                metric.interval(&found.pooled).map_or(Spread::TooFew, |(low, high)| Spread::Bounds(low, high))
            }
            Source::Scores | Source::Delays | Source::Effort => Spread::Exact,
        }
    }

    fn draws(&self, metric: Metric, measure: &Measure) -> Spread {
        let key = (measure.tracker.clone(), method_label(&measure.method, &measure.params));
        let Some(counts) = self.counts.get(&key).filter(|c| c.len() >= MIN_SEQUENCES) else {
            return Spread::TooFew;
        };
        let drawn = || {
            let chance = self.results.experiment.chance_of(&measure.method);
            let units: Vec<[i64; 4]> =
                self.sequences.iter().map(|s| counts.get(*s).copied().unwrap_or_default()).collect();
            let values = self.draws.values(&units, |sum| metric_of_sum(metric, chance, sum));
            values.map_or(Spread::TooFew, Spread::Draws)
        };
        self.known.borrow_mut().entry((metric.name(), key)).or_insert_with(drawn).clone()
    }
}
