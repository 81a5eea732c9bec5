//! The numbers of claims, with how far other sequences might move them.

use crate::engine::execute::analyse::Analysed;
use crate::num::pooled::Draws;
use crate::num::seed;
use crate::results::{CellScore, Results};
use crate::score::metric::Source;
use crate::score::{Counts, Metric, Pooled};
use crate::spec::claim::{Measured, Quantity, Reference, Spread};
use crate::table::layout;
use crate::table::leaderboard::MIN_SEQUENCES;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

/// Samples of the sequences for each interval.
const DRAWS: usize = 2000;

/// Tracker, method and grid point -> sequence -> TP, FP, FN and TN of all runs.
type CountsBySequence<'a> = BTreeMap<(&'a str, &'a str, &'a str), BTreeMap<&'a str, [i64; 4]>>;

/// Numbers of an experiment, computed from the same samples of its sequences.
pub struct Samples<'a> {
    results: &'a Results,
    counts: CountsBySequence<'a>,
    sequences: Vec<&'a str>,
    draws: Draws,
    /// What was drawn before: claims speak of the same numbers again and again.
    known: RefCell<BTreeMap<[String; 4], Spread>>,
}

impl<'a> Samples<'a> {
    /// Draws the samples; `scores` are those of [`Results::scores`].
    pub fn new(results: &'a Results, scores: &'a [CellScore]) -> Self {
        let mut counts: CountsBySequence<'_> = BTreeMap::new();
        for row in scores {
            let of_method = counts.entry((&row.tracker, &row.method, &row.params)).or_default();
            let Counts { tp, fp, fn_, tn } = row.counts;
            let sum = of_method.entry(&row.sequence).or_default();
            // More than any sequence has; the limit keeps sums of forged counts from overflowing.
            let new = [tp, fp, fn_, tn].map(|c| c.min(1 << 40) as i64);
            sum.iter_mut().zip(new).for_each(|(s, c)| *s = (*s + c).min(1 << 40));
        }
        let sequences: BTreeSet<&str> = scores.iter().map(|s| s.sequence.as_str()).collect();
        let seed = seed::seed(results.manifest.seed, &["claims", &results.experiment.name]);
        let draws = Draws::new(sequences.len(), if scores.is_empty() { 0 } else { DRAWS }, seed);
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
            Source::Counts => self.draws(*metric, (tracker, method, &found.params)),
            Source::Frames => {
                metric.interval(&found.pooled).map_or(Spread::TooFew, |(low, high)| Spread::Bounds(low, high))
            }
            Source::Scores | Source::Delays | Source::Effort => Spread::Exact,
        }
    }

    fn draws(&self, metric: Metric, key: (&str, &str, &str)) -> Spread {
        let Some(counts) = self.counts.get(&key).filter(|c| c.len() >= MIN_SEQUENCES) else {
            return Spread::TooFew;
        };
        let chance = self.results.experiment.chance_of(key.1);
        let units: Vec<[i64; 4]> =
            self.sequences.iter().map(|s| counts.get(s).copied().unwrap_or_default()).collect();
        let value = |sum: &[i64; 4]| {
            let [tp, fp, fn_, tn] = sum.map(|c| u64::try_from(c).unwrap_or(0));
            let counts = Counts { tp, fp, fn_, tn };
            metric.value(&Pooled { counts, chance, ..Pooled::default() })
        };
        let name = [metric.name(), key.0, key.1, key.2].map(String::from);
        let mut known = self.known.borrow_mut();
        let drawn = || self.draws.values(&units, value).map_or(Spread::TooFew, Spread::Draws);
        known.entry(name).or_insert_with(drawn).clone()
    }
}
