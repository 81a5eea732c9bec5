//! The numbers of claims, with how far other sequences might move them.

use crate::results::{CellScore, Measure, Results, method_label};
use crate::sampling::{
    MIN_SEQUENCES, Sampling, UnitCounts, counts_of_column, counts_of_sequences, mean_of_sum, metric_of_sum,
    sum_of, total_of_sum,
};
use crate::table::layout;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use trackfail_engine::execute::analyse::Analysed;
use trackfail_engine::spec::claim::{Measured, Quantity, Reference, Spread};
use trackfail_engine::spec::table::FindingName;
use trackfail_methods::score::metric::Source;
use trackfail_methods::score::{Metric, TrackerMetric};

/// A number of a sum over sequences, where it has one.
type Statistic = fn(&[i64; 4]) -> Option<f64>;

/// The statistic of a column by sequence that gives a number: the mean or the total.
fn statistic_of(sum: &[i64; 4], value: f64) -> Option<Statistic> {
    // Values of a column are rounded to billionths.
    let gives = |statistic: &Statistic| {
        statistic(sum).is_some_and(|v| (v - value).abs() <= 1e-8 * value.abs().max(1.0))
    };
    [mean_of_sum as Statistic, total_of_sum].into_iter().find(gives)
}

/// A metric by name, and of what tracker and method.
type Drawn = (&'static str, (String, String));

/// Numbers of an experiment, computed from the same samples of its sequences.
pub struct Samples<'a> {
    results: &'a Results,
    counts: UnitCounts,
    sequences: Vec<&'a str>,
    sampling: Sampling,
    /// What was drawn before: claims speak of the same numbers again and again.
    known: RefCell<BTreeMap<Drawn, Spread>>,
}

impl<'a> Samples<'a> {
    /// Draws the samples; `scores` are those of [`Results::scores`].
    pub fn new(results: &'a Results, scores: &'a [CellScore]) -> Self {
        let sequences: BTreeSet<&str> = scores.iter().map(|s| s.sequence.as_str()).collect();
        let (counts, sampling) = (counts_of_sequences(scores), Sampling::new(&results.experiment));
        let sequences = sequences.into_iter().collect();
        Self { results, counts, sequences, sampling, known: RefCell::default() }
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

    /// The number with its spread: samples for what is made of counts, and for numbers of analyses that are the mean or
    /// the total of their column by sequence; bounds for measures of frames; all others are taken as they are.
    pub fn measured(&self, r: &Reference) -> Option<Measured> {
        let value = self.value(r)?;
        Some(Measured { value, spread: self.spread(r, value) })
    }

    fn spread(&self, r: &Reference, value: f64) -> Spread {
        let Some(tracker) = r.tracker.as_deref() else { return Spread::Exact };
        let (metric, method) = match &r.quantity {
            Quantity::Metric(metric, method) => (metric, method),
            Quantity::Finding(made) => return self.of_column(made, tracker, value).unwrap_or(Spread::Exact),
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

    /// The spread of a number of an analysis that is the mean or the total of its column in the table `sequences`; `None`
    /// where it is neither.
    fn of_column(&self, made: &FindingName, tracker: &str, value: f64) -> Option<Spread> {
        let mine = self.results.analyses.iter().filter(|a| a.analysis == made.analysis);
        let tables = mine.filter_map(|a| {
            let table = a.findings.tables.iter().find(|table| table.name == "sequences")?;
            let is_it =
                |heading: &String| TrackerMetric::of_heading(heading).is_some_and(|m| m.name == made.part);
            let column = table.columns.iter().position(is_it)?;
            Some((a.tracker.as_str(), counts_of_column(table, column)))
        });
        let tables: Vec<_> = tables.collect();
        let (_, counts) = tables.iter().find(|(label, _)| *label == tracker)?;
        let statistic = statistic_of(&sum_of(counts), value)?;
        if counts.len() < MIN_SEQUENCES {
            return Some(Spread::TooFew);
        }
        // Those of all trackers: a claim compares numbers from the same samples.
        let sequences: BTreeSet<&String> = tables.iter().flat_map(|(_, counts)| counts.keys()).collect();
        let units: Vec<[i64; 4]> =
            sequences.iter().map(|s| counts.get(*s).copied().unwrap_or_default()).collect();
        let values = self.sampling.draws(units.len()).and_then(|draws| draws.values(&units, statistic));
        Some(values.map_or(Spread::TooFew, Spread::Draws))
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
            let draws = self.sampling.draws(units.len());
            let values = draws.and_then(|d| d.values(&units, |sum| metric_of_sum(metric, chance, sum)));
            values.map_or(Spread::TooFew, Spread::Draws)
        };
        self.known.borrow_mut().entry((metric.name(), key)).or_insert_with(drawn).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // By hand: 0.2, 0.4 and 0.9 have the mean 0.5 and the total 1.5; 0.6 is neither, for example weighted by frames.
    #[test]
    fn a_number_of_an_analysis_is_sampled_as_what_it_is_of_its_column() {
        let unit = |billionths: i64| [billionths, 1, 0, 0];
        let units = [unit(200_000_000), unit(400_000_000), unit(900_000_000)];
        let sum = [1_500_000_000, 3, 0, 0];
        let mean = statistic_of(&sum, 0.5).expect("a mean");
        let total = statistic_of(&sum, 1.5).expect("a total");
        assert_eq!((mean(&units[2]), total(&units[2])), (Some(0.9), Some(0.9)));
        assert_eq!((mean(&sum), total(&sum)), (Some(0.5), Some(1.5)));
        assert!(statistic_of(&sum, 0.6).is_none() && statistic_of(&[0; 4], 0.0).is_none());
    }
}
