//! Numbers of claims, with the uncertainty that comes from the choice of sequences.

use super::judge::{Measured, Spread};
use crate::results::{Measure, Results};
use crate::sampling::{
    BySequence, MIN_SEQUENCES, Units, along, by_sequence, counts_of_column, mean_of_sum, metric_of_sum,
    sum_of, total_of_sum,
};
use crate::table::layout;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use trackfail_engine::execute::analyse::Analysed;
use trackfail_engine::spec::claim::{Quantity, Reference};
use trackfail_engine::spec::table::FindingName;
use trackfail_methods::score::metric::Source;
use trackfail_methods::score::{Metric, TrackerMetric};

/// Computes a number from counts summed over sequences; `None` if it has no value.
type Statistic = fn(&[i64; 4]) -> Option<f64>;

/// Statistic by which a column of values by sequence gives the number: the mean or the total; `None` if
/// neither does.
fn statistic_of(sum: &[i64; 4], value: f64) -> Option<Statistic> {
    // Values of a column are rounded to billionths.
    let gives = |statistic: &Statistic| {
        statistic(sum).is_some_and(|v| (v - value).abs() <= 1e-8 * value.abs().max(1.0))
    };
    [mean_of_sum as Statistic, total_of_sum].into_iter().find(gives)
}

/// Name of a metric, with tracker, method and grid point.
type Drawn<'a> = (&'static str, [&'a str; 3]);

/// Numbers of an experiment, all computed from the same samples of its sequences.
pub struct Samples<'a> {
    results: &'a Results,
    units: &'a Units,
    sequences: BTreeSet<&'a String>,
    /// Samples computed so far. Claims use the same numbers again and again.
    known: RefCell<BTreeMap<Drawn<'a>, Spread>>,
}

impl<'a> Samples<'a> {
    /// Numbers of `results`; `units` has their counts by sequence.
    pub fn new(results: &'a Results, units: &'a Units) -> Self {
        Self { results, units, sequences: units.sequences(), known: RefCell::default() }
    }

    /// Number of a reference that names its tracker, with its uncertainty. Numbers of counts have samples, as
    /// have analysis numbers that are the mean or total of a column by sequence. Measures of frames have
    /// bounds. All others are taken as exact.
    pub fn measured(&self, r: &Reference) -> Option<Measured> {
        let tracker = r.tracker.as_deref()?;
        match &r.quantity {
            Quantity::Metric(metric, method) => {
                let measure = layout::measure_of(&self.results.measures, tracker, method, &r.point)?;
                let value = measure.value(*metric)?;
                Some(Measured { value, spread: self.of_metric(*metric, measure) })
            }
            Quantity::Finding(made) => {
                let mine = |a: &&Analysed| a.analysis == made.analysis && a.tracker == tracker;
                let value = self.results.analyses.iter().find(mine)?.findings.number(&made.part)?;
                let spread = self.of_column(made, tracker, value).unwrap_or(Spread::Exact);
                Some(Measured { value, spread })
            }
        }
    }

    fn of_metric(&self, metric: Metric, measure: &'a Measure) -> Spread {
        match metric.source {
            Source::Counts => {
                let counts = self.units.of_measure(measure);
                let of = |sum: &[i64; 4]| metric_of_sum(metric, measure.pooled.chance, sum);
                let drawn = || self.draws(counts, self.sequences.iter().copied(), of);
                let key = [&measure.tracker, &measure.method, &measure.params].map(String::as_str);
                self.known.borrow_mut().entry((metric.name(), key)).or_insert_with(drawn).clone()
            }
            Source::Frames => {
                let bounds = metric.interval(&measure.pooled);
                bounds.map_or(Spread::TooFew, |(low, high)| Spread::Bounds(low, high))
            }
            Source::Scores | Source::Delays | Source::Effort => Spread::Exact,
        }
    }

    /// Samples of an analysis number that is the mean or the total of its column by sequence; `None` for
    /// other numbers.
    fn of_column(&self, made: &FindingName, tracker: &str, value: f64) -> Option<Spread> {
        let column = |a: &'a Analysed| {
            let table = by_sequence(a).filter(|_| a.analysis == made.analysis)?;
            let is_it =
                |heading: &String| TrackerMetric::of_heading(heading).is_some_and(|m| m.name == made.part);
            let column = table.columns.iter().position(is_it)?;
            Some((a.tracker.as_str(), counts_of_column(table, column)))
        };
        let columns: Vec<_> = self.results.analyses.iter().filter_map(column).collect();
        let (_, counts) = columns.iter().find(|(label, _)| *label == tracker)?;
        let statistic = statistic_of(&sum_of(counts.values()), value)?;
        // Those of all trackers: a claim compares numbers from the same samples.
        let sequences: BTreeSet<&String> = columns.iter().flat_map(|(_, counts)| counts.keys()).collect();
        Some(self.draws(Some(counts), sequences, statistic))
    }

    /// Values of a statistic in samples of some sequences.
    fn draws<'s>(
        &self,
        counts: Option<&BySequence>,
        sequences: impl IntoIterator<Item = &'s String>,
        of: impl Fn(&[i64; 4]) -> Option<f64>,
    ) -> Spread {
        let counts = counts.filter(|counts| counts.len() >= MIN_SEQUENCES);
        let values = counts.and_then(|counts| self.units.sampling.values(&along(counts, sequences), of));
        values.map_or(Spread::TooFew, Spread::Draws)
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
