//! `readings.csv`: how far each reading of a paper is from the numbers that the paper prints.
//!
//! A reading is a method or tracker with other choices where the text leaves them open (`like` in the experiment), or the
//! one that it is like. Of every reading and every published statistic:
//!
//! ```text
//! d_s  = ours - published
//! e_s  = standard deviation of ours over bootstrap samples of sequences, for the reading that the others are like;
//!        at least sqrt(p (1 - p) / n) for a published share p of n events, detections or frames of ours (few sequences can
//!        agree by chance), and at least half a unit of the last digit that the paper prints
//! D    = sqrt( mean over s of (d_s / e_s)^2 )              the discrepancy of a reading
//! ```
//!
//! D is about 1 where another choice of sequences would explain the differences. It was stated before it was looked at: all
//! published statistics count alike but those made of F, which are shown and by which nothing is chosen, and plain counts, which
//! depend on how many sequences are there and are left out (their shares per 1000 frames are among the others). All readings of one method on one tracker use the
//! same e_s, so that one reading is not preferred because its numbers are unsteady. `first` is the share of bootstrap samples
//! in which a reading has the smallest D of them, the same samples for all. Low is good.

use super::cells::grouped;
use super::column::{Column, METHOD, SUITE, TRACKER, TableFile};
use super::frame::{TableError, to_csv};
use std::collections::BTreeMap;
use trackfail_core::num::seed;
use trackfail_engine::spec::Experiment;
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::score::frames::bootstrap::{Samples, interval};
use trackfail_methods::score::metric::Kind;
use trackfail_methods::score::restarts;
use trackfail_methods::score::{Counts, Metric, Pooled};

const NO_VALUE: &str = "there is none";
const OF_TRACKER: Column = Column::text("of_tracker", "Tracker that this one is a reading of, or itself");
const OF_METHOD: Column = Column::text("of_method", "Method that this one is a reading of, or itself");
const STATISTIC: Column = Column::text("statistic", "Name of the metric, or `discrepancy`");
const PUBLISHED: Column = Column::real("published", "", "The published number").empty(NO_VALUE);
const OURS: Column = Column::real("ours", "", "Our number").empty(NO_VALUE);
const DIFFERENCE: Column = Column::real("difference", "", "Ours less published").empty(NO_VALUE);
const LOW: Column = Column::real("low", "", "Lower bound of `ours`, 95 %").empty(NO_VALUE);
const HIGH: Column = Column::real("high", "", "Upper bound of `ours`, 95 %").empty(NO_VALUE);
const SCALE: Column =
    Column::real("scale", "", "The unit e_s of the difference in the discrepancy").empty(NO_VALUE);
const FIRST: Column =
    Column::real("first", "", "Share of bootstrap samples in which the discrepancy is the smallest")
        .empty("the row is not about the discrepancy, or there are fewer than three sequences");

/// The file; only experiments with readings have it.
pub const FILE: TableFile = TableFile {
    name: "readings.csv",
    about: "One row for each reading of a method on a reading of a tracker and each published statistic, and one with the \
            statistic `discrepancy`. Bounds are those of a bootstrap interval over sequences. Only experiments in which a \
            method or a tracker is `like` another have the file.",
    columns: &[
        SUITE, TRACKER, METHOD, OF_TRACKER, OF_METHOD, STATISTIC, PUBLISHED, OURS, DIFFERENCE, LOW, HIGH,
        SCALE, FIRST,
    ],
};

/// Name of the statistic of the rows that sum a reading up.
pub const DISCREPANCY: &str = "discrepancy";

/// One row of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Row {
    /// Label of the tracker.
    pub tracker: String,
    /// Method.
    pub method: String,
    /// The tracker that it is a reading of.
    pub of_tracker: String,
    /// The method that it is a reading of.
    pub of_method: String,
    /// Name of the metric, or [`DISCREPANCY`].
    pub statistic: String,
    /// The published number.
    pub published: Option<f64>,
    /// Our number.
    pub ours: Option<f64>,
    /// Bounds of our number.
    pub bounds: Option<(f64, f64)>,
    /// Unit of the difference.
    pub scale: Option<f64>,
    /// Share of samples in which it is the first.
    pub first: Option<f64>,
}

/// A published number of a method on a tracker.
#[derive(Debug, Clone, PartialEq)]
struct Statistic {
    metric: Metric,
    published: f64,
    /// Half a unit of its last digit.
    half_unit: f64,
}

impl Statistic {
    /// Whether it is part of the discrepancy.
    fn counts(&self) -> bool {
        !self.metric.name().starts_with("f_")
    }
}

/// The published numbers that count, of a method on a tracker, each metric once.
fn statistics(experiment: &Experiment, tracker: &str, method: &str) -> Vec<Statistic> {
    let mut all: Vec<Statistic> = Vec::new();
    for published in experiment.published.iter().filter(|p| p.tracker == tracker) {
        let text = published.values.iter().find(|(name, _)| name == method).map(|(_, text)| text);
        let (Some(metric), Some(text)) = (Metric::from_name(&published.row), text) else { continue };
        let metrics = match metric.kind() {
            Kind::MeanAndDeviation => vec![Metric::SCORE_MEAN, Metric::SCORE_STD],
            _ => vec![metric],
        };
        for (metric, part) in metrics.into_iter().zip(text.split('±')) {
            let Ok(number) = part.trim().parse::<f64>() else { continue };
            if metric.kind() == Kind::Count || all.iter().any(|s| s.metric == metric) {
                continue;
            }
            let digits = part.trim().split_once('.').map_or(0, |(_, digits)| digits.len());
            let half_unit = 0.5 * 10.0_f64.powi(-i32::try_from(digits).unwrap_or(i32::MAX));
            all.push(Statistic { metric, published: number, half_unit });
        }
    }
    all
}

/// Standard error of a published share on as many events, detections or frames as there are; 0 for what is no share.
fn share_error(metric: Metric, published: f64, counts: &Counts) -> f64 {
    let Counts { tp, fp, fn_, tn } = *counts;
    let (unit, of) = match metric.name() {
        "precision" => (1.0, tp + fp),
        "recall" => (1.0, tp + fn_),
        "fpr" => (1.0, fp + tn),
        "detections_per_1000" | "events_per_1000" | "false_alarms_per_1000" => (1000.0, tp + fp + fn_ + tn),
        _ => return 0.0,
    };
    let share = (published / unit).clamp(0.0, 1.0);
    unit * (share * (1.0 - share) / of.max(1) as f64).sqrt()
}

/// The part of one sequence in the numbers of a reading, over all runs.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Part {
    counts: Counts,
    /// Number, sum and sum of squares of the normalized scores.
    moments: [f64; 3],
}

impl Part {
    fn add(&mut self, other: &Self, times: u64) {
        let Counts { tp, fp, fn_, tn } = other.counts;
        let more = Counts { tp: tp * times, fp: fp * times, fn_: fn_ * times, tn: tn * times };
        self.counts = [self.counts, more].into_iter().sum();
        self.moments.iter_mut().zip(other.moments).for_each(|(sum, m)| *sum += times as f64 * m);
    }

    fn value(&self, metric: Metric) -> Option<f64> {
        let [count, sum, squares] = self.moments;
        let score = (count > 0.0).then(|| {
            let mean = sum / count;
            (mean, (squares / count - mean * mean).max(0.0).sqrt())
        });
        metric.value(&Pooled { counts: self.counts, score, ..Pooled::default() })
    }
}

/// Number, sum and sum of squares of scores that are min-max normalized, as in [`trackfail_methods::score::pooled`].
fn moments(scores: &[f64]) -> [f64; 3] {
    let low = scores.iter().copied().fold(f64::INFINITY, f64::min);
    let high = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if high <= low {
        return [0.0; 3];
    }
    scores.iter().map(|z| (z - low) / (high - low)).fold([0.0; 3], |[n, s, q], z| [n + 1.0, s + z, q + z * z])
}

/// A reading with its numbers.
struct Reading<'a> {
    tracker: &'a str,
    method: &'a str,
    of: (&'a str, &'a str),
    statistics: Vec<Statistic>,
    /// Sequence -> its part.
    parts: BTreeMap<usize, Part>,
    counts: Counts,
    ours: Vec<Option<f64>>,
    /// Our number of each statistic in every bootstrap sample, NaN where it has none.
    samples: Vec<Vec<f64>>,
}

/// The discrepancy of differences in their units; none without any.
fn discrepancy(scaled: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let squares: Vec<f64> = scaled.flatten().map(|z| z * z).collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

/// Standard deviation of the values that are numbers.
fn deviation(values: &[f64]) -> f64 {
    let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let count = known.len().max(1) as f64;
    let mean = known.iter().sum::<f64>() / count;
    (known.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}

impl<'a> Reading<'a> {
    fn new(
        experiment: &'a Experiment,
        outcome: &Outcome<'_>,
        cells: &[&'a Cell],
    ) -> Result<Option<Self>, StoreError> {
        let Some(first) = cells.first() else { return Ok(None) };
        let (tracker, method) = (first.tracker.as_str(), first.method.as_str());
        let statistics = statistics(experiment, tracker, method);
        if statistics.is_empty() {
            return Ok(None);
        }
        let like_tracker =
            experiment.trackers.iter().find(|t| t.label == tracker).and_then(|t| t.like.as_deref());
        let like_method =
            experiment.methods.iter().find(|m| m.name == method).and_then(|m| m.like.as_deref());
        let mut parts: BTreeMap<usize, Part> = BTreeMap::new();
        for cell in cells {
            let Ok(judged) = &cell.result else { continue };
            let output = outcome.detector_output(cell, judged)?;
            let moments = moments(&restarts::counted(&judged.pieces, &output.score));
            let part = Part { counts: judged.score.counts, moments };
            parts.entry(cell.sequence).or_default().add(&part, 1);
        }
        let all: Vec<Part> = parts.values().copied().collect();
        let samples = Samples::new(all.len(), seed::seed(experiment.seed, &["readings"]));
        let sum = |weights: &[u64]| {
            let mut sum = Part::default();
            all.iter().zip(weights).for_each(|(part, times)| sum.add(part, *times));
            sum
        };
        let whole = sum(&vec![1; all.len()]);
        let drawn: Vec<Part> = samples.each().map(|weights| sum(&weights)).collect();
        let in_samples =
            |s: &Statistic| drawn.iter().map(|p| p.value(s.metric).unwrap_or(f64::NAN)).collect();
        Ok(Some(Self {
            tracker,
            method,
            of: (like_tracker.unwrap_or(tracker), like_method.unwrap_or(method)),
            counts: whole.counts,
            ours: statistics.iter().map(|s| whole.value(s.metric)).collect(),
            samples: statistics.iter().map(in_samples).collect(),
            statistics,
            parts,
        }))
    }

    /// The discrepancy of our numbers, or of those in a sample.
    fn discrepancy(&self, scales: &BTreeMap<&str, f64>, sample: Option<usize>) -> Option<f64> {
        let scaled = |(k, s): (usize, &Statistic)| {
            if !s.counts() {
                return None;
            }
            let ours = match sample {
                None => self.ours[k]?,
                Some(draw) => *self.samples[k].get(draw).filter(|v| v.is_finite())?,
            };
            Some((ours - s.published) / scales.get(s.metric.name())?)
        };
        discrepancy(self.statistics.iter().enumerate().map(scaled))
    }

    fn row(&self, statistic: &str) -> Row {
        Row {
            tracker: self.tracker.to_string(),
            method: self.method.to_string(),
            of_tracker: self.of.0.to_string(),
            of_method: self.of.1.to_string(),
            statistic: statistic.to_string(),
            ..Row::default()
        }
    }
}

/// Share of the samples in which each of the readings has the smallest discrepancy; readings that are alike share it.
fn shares(readings: &[&Reading<'_>], scales: &BTreeMap<&str, f64>) -> Option<Vec<f64>> {
    let same = readings.windows(2).all(|pair| pair[0].parts.keys().eq(pair[1].parts.keys()));
    let draws = readings.first()?.samples.first()?.len();
    if !same || draws == 0 || readings.iter().any(|r| r.discrepancy(scales, None).is_none()) {
        return None;
    }
    let mut shares = vec![0.0; readings.len()];
    for draw in 0..draws {
        let all: Vec<f64> =
            readings.iter().map(|r| r.discrepancy(scales, Some(draw)).unwrap_or(f64::INFINITY)).collect();
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        let ties = all.iter().filter(|d| **d <= least).count() as f64;
        all.iter().zip(&mut shares).filter(|(d, _)| **d <= least).for_each(|(_, share)| *share += 1.0 / ties);
    }
    Some(shares.into_iter().map(|share| share / draws as f64).collect())
}

/// Whether an experiment has readings.
pub fn has_readings(experiment: &Experiment) -> bool {
    experiment.methods.iter().any(|m| m.like.is_some())
        || experiment.trackers.iter().any(|t| t.like.is_some())
}

/// The rows of an outcome: readings of the same method on the same tracker together, in the experiment's order.
///
/// # Errors
/// When a detection cannot be read from the store any more.
pub(super) fn rows(experiment: &Experiment, outcome: &Outcome<'_>) -> Result<Vec<Row>, StoreError> {
    let single = |cell: &&Cell| cell.params.is_empty();
    let groups = grouped(outcome.cells.iter().filter(single), |cell| (&cell.tracker, &cell.method));
    let readings = groups.iter().map(|cells| Reading::new(experiment, outcome, cells));
    let readings: Vec<Reading<'_>> =
        readings.collect::<Result<Vec<_>, StoreError>>()?.into_iter().flatten().collect();
    let mut bases: Vec<(&str, &str)> = Vec::new();
    for reading in &readings {
        if !bases.contains(&reading.of) {
            bases.push(reading.of);
        }
    }
    let mut rows = Vec::new();
    for base in bases {
        let mine: Vec<&Reading<'_>> = readings.iter().filter(|r| r.of == base).collect();
        let Some(first) = mine.iter().find(|r| (r.tracker, r.method) == base).or(mine.first()) else {
            continue;
        };
        if mine.len() < 2 {
            continue;
        }
        let scale = |(s, samples): (&Statistic, &Vec<f64>)| {
            let least = share_error(s.metric, s.published, &first.counts).max(s.half_unit);
            (s.metric.name(), deviation(samples).max(least))
        };
        let scales: BTreeMap<&str, f64> = first.statistics.iter().zip(&first.samples).map(scale).collect();
        let shares = shares(&mine, &scales);
        for (k, reading) in mine.iter().enumerate() {
            for (s, statistic) in reading.statistics.iter().enumerate() {
                rows.push(Row {
                    published: Some(statistic.published),
                    ours: reading.ours[s],
                    bounds: reading.ours[s].and(interval(reading.samples[s].clone())),
                    scale: scales.get(statistic.metric.name()).copied(),
                    ..reading.row(statistic.metric.name())
                });
            }
            let first = shares.as_ref().and_then(|shares| shares.get(k).copied());
            rows.push(Row { ours: reading.discrepancy(&scales, None), first, ..reading.row(DISCREPANCY) });
        }
    }
    Ok(rows)
}

/// Writes the file.
///
/// # Errors
/// When polars refuses.
pub(super) fn write(suite: &str, rows: &[Row]) -> Result<Vec<u8>, TableError> {
    let text = |f: fn(&Row) -> &str| rows.iter().map(f).collect::<Vec<_>>();
    let number = |column: &Column, f: &dyn Fn(&Row) -> Option<f64>| column.of_metric(rows.iter().map(f));
    to_csv(FILE.frame(vec![
        SUITE.of(vec![suite; rows.len()]),
        TRACKER.of(text(|r| &r.tracker)),
        METHOD.of(text(|r| &r.method)),
        OF_TRACKER.of(text(|r| &r.of_tracker)),
        OF_METHOD.of(text(|r| &r.of_method)),
        STATISTIC.of(text(|r| &r.statistic)),
        number(&PUBLISHED, &|r| r.published),
        number(&OURS, &|r| r.ours),
        number(&DIFFERENCE, &|r| Some(r.ours? - r.published?)),
        number(&LOW, &|r| r.bounds.map(|b| b.0)),
        number(&HIGH, &|r| r.bounds.map(|b| b.1)),
        number(&SCALE, &|r| r.scale),
        number(&FIRST, &|r| r.first),
    ])?)
}

/// Reads the file.
///
/// # Errors
/// When the columns are not those of the file, or a number is damaged.
pub fn read(bytes: Vec<u8>) -> Result<Vec<Row>, TableError> {
    let rows = FILE.read_csv(bytes)?;
    let (tracker, method) = (rows.texts(&TRACKER)?, rows.texts(&METHOD)?);
    let (of_tracker, of_method) = (rows.texts(&OF_TRACKER)?, rows.texts(&OF_METHOD)?);
    let statistic = rows.texts(&STATISTIC)?;
    let (published, ours) = (rows.numbers(&PUBLISHED)?, rows.numbers(&OURS)?);
    let (low, high): (Vec<Option<f64>>, Vec<Option<f64>>) = (rows.numbers(&LOW)?, rows.numbers(&HIGH)?);
    let (scale, first) = (rows.numbers(&SCALE)?, rows.numbers(&FIRST)?);
    let row = |i: usize| Row {
        tracker: tracker[i].to_string(),
        method: method[i].to_string(),
        of_tracker: of_tracker[i].to_string(),
        of_method: of_method[i].to_string(),
        statistic: statistic[i].to_string(),
        published: published[i],
        ours: ours[i],
        bounds: low[i].zip(high[i]),
        scale: scale[i],
        first: first[i],
    };
    Ok((0..rows.len()).map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discrepancies_by_hand() {
        // Differences of 3 and 4 units, one statistic without a value.
        assert_eq!(discrepancy([Some(3.0), None, Some(-4.0)].into_iter()), Some(12.5_f64.sqrt()));
        assert_eq!(discrepancy([None].into_iter()), None);
        assert_eq!(deviation(&[1.0, f64::NAN, 3.0]), 1.0);
        // A half of 16 events: .5 / 4.
        let counts = Counts { tp: 16, fp: 9, fn_: 0, tn: 975 };
        assert_eq!(share_error(Metric::RECALL, 0.5, &counts), 0.125);
        assert_eq!(share_error(Metric::SCORE_MEAN, 0.5, &counts), 0.0);
    }

    // numpy: z = [0, .5, 1, .25]; mean .4375, std .3698 (population).
    #[test]
    fn moments_are_those_of_the_metric() {
        let scores = [2.0, 4.0, 6.0, 3.0];
        let part = Part { moments: moments(&scores), ..Part::default() };
        let (mean, std) = trackfail_methods::score::pooled::normalized_mean_std([&scores]).unwrap();
        assert!((part.value(Metric::SCORE_MEAN).unwrap() - mean).abs() < 1e-15);
        assert!((part.value(Metric::SCORE_STD).unwrap() - std).abs() < 1e-15);
        assert!((mean - 0.4375).abs() < 1e-15 && (std - 0.369_754_986_443_726).abs() < 1e-14);
        assert_eq!(moments(&[7.0, 7.0]), [0.0; 3]);
    }

    #[test]
    fn the_reading_that_is_nearest_in_every_sample_has_all_of_them() {
        let statistic = Statistic { metric: Metric::RECALL, published: 0.5, half_unit: 0.0005 };
        let reading = |method, ours: f64| Reading {
            tracker: "t",
            method,
            of: ("t", "a"),
            statistics: vec![statistic.clone()],
            parts: BTreeMap::from([(0, Part::default())]),
            counts: Counts::default(),
            ours: vec![Some(ours)],
            samples: vec![vec![ours - 0.01, ours, ours + 0.01]],
        };
        let (far, near, same) = (reading("a", 0.9), reading("b", 0.52), reading("c", 0.52));
        let scales = BTreeMap::from([("recall", 0.1)]);
        assert_eq!(shares(&[&far, &near], &scales), Some(vec![0.0, 1.0]));
        assert_eq!(shares(&[&near, &far, &same], &scales), Some(vec![0.5, 0.0, 0.5]));
        assert!((far.discrepancy(&scales, None).unwrap() - 4.0).abs() < 1e-12);
    }
}
