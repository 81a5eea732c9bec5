//! Computes all measures of a detector by frame, pooled over the tracks of a suite.

use super::alarms::Losses;
use super::bootstrap::Samples;
use super::calibration::expected_calibration_error;
use super::coverage::areas;
use super::list::{Alarms, FRAME_METRICS, FrameMetric, Of, Scores};
use super::nab;
use super::range;
use super::sweep::Sorted;
use super::truth::{Rule, ScoredTrack};
use super::warning::{HORIZONS, imminent};
use crate::direction::Direction;
use std::borrow::Cow;

/// Names of the counts: annotated frames that are not lost and lost frames, both by `frames/1`, and ranges of lost frames
/// after a frame that was not lost.
const COUNTS: [&str; 3] = ["good_frames", "lost_frames", "losses"];

/// Measures of one detector on the tracks of a suite; `None` for those without a value.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameMeasures {
    /// Each of [`COUNTS`].
    counts: [Option<f64>; COUNTS.len()],
    /// Value of each measure of the list, with the lower and the upper bound of its interval.
    measured: [[Option<f64>; 3]; FRAME_METRICS.len()],
}

impl FrameMeasures {
    /// Number in the column of this name: a count, a measure, or a bound.
    pub fn get(&self, column: &str) -> Option<f64> {
        match COUNTS.iter().position(|name| *name == column) {
            Some(count) => self.counts[count],
            None => place(column).and_then(|(measure, part)| self.measured[measure][part]),
        }
    }

    /// Sets the number in the column of this name. Unknown names are ignored.
    pub fn set(&mut self, column: &str, number: Option<f64>) {
        if let Some(count) = COUNTS.iter().position(|name| *name == column) {
            self.counts[count] = number;
        } else if let Some((measure, part)) = place(column) {
            self.measured[measure][part] = number;
        }
    }

    /// Bounds of the measure of this name.
    pub fn bounds(&self, name: &str) -> Option<(f64, f64)> {
        let (measure, 0) = place(name)? else { return None };
        let [_, low, high] = self.measured[measure];
        low.zip(high)
    }
}

/// Index of a column's measure in the list, and of its number: value, lower or upper bound.
fn place(column: &str) -> Option<(usize, usize)> {
    let (name, part) = match column.rsplit_once('_') {
        Some((name, "low")) => (name, 1),
        Some((name, "high")) => (name, 2),
        _ => (column, 0),
    };
    let is_of =
        |measure: &FrameMetric| measure.metric.name() == name && (part == 0 || measure.bounds.is_some());
    Some((FRAME_METRICS.iter().position(is_of)?, part))
}

/// Meaning of a method's scores.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Method {
    /// Direction in which scores are good.
    pub direction: Direction,
    /// True if scores are probabilities: of being on target if high scores are good, else of a loss.
    pub is_probability: bool,
}

/// Measures in bootstrap samples of sequences. All detectors on the same sequences have the same samples.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sampled {
    /// Area under the ROC curve in each sample; NaN if it has no value.
    pub auroc: Vec<f64>,
    /// Share of the losses found at 5 false alarms per 1000 good frames in each sample; NaN without a loss.
    pub found_at_5: Vec<f64>,
}

/// Computes the measures. Scores are as the detector gives them; with a seed there are intervals. `compared`
/// has the values of each track that are compared with the threshold, if these are not the scores; the
/// measures of alarms are then computed from them.
pub fn measure(
    tracks: &[ScoredTrack<'_>],
    compared: Option<&[&[f64]]>,
    method: Method,
    seed: Option<u64>,
) -> FrameMeasures {
    with_alarms(of_scores(tracks, compared, method, seed).0, tracks)
}

/// Measures of scores (without those of [`with_alarms`]), and their values in bootstrap samples.
pub fn of_scores(
    tracks: &[ScoredTrack<'_>],
    compared: Option<&[&[f64]]>,
    method: Method,
    seed: Option<u64>,
) -> (FrameMeasures, Sampled) {
    let turned: Vec<Cow<'_, [f64]>> = tracks.iter().map(|track| turn(track.score, method)).collect();
    let turned: Vec<ScoredTrack<'_>> = with_scores(tracks, &turned);
    let sorted = Sorted::new(&turned);
    let (all, clear) = (sorted.sweep(Rule::NoOverlap), sorted.sweep(Rule::Clear));
    let warning = HORIZONS.map(|horizon| {
        let of_tracks: Vec<_> = tracks.iter().map(|track| imminent(track.error, horizon)).collect();
        sorted.sweep_of(&of_tracks)
    });
    let compared = compared.map(|of| of.iter().map(|scores| turn(scores, method)).collect::<Vec<_>>());
    let raising = compared.as_ref().map(|compared| with_scores(tracks, compared));
    let of_alarms = raising.as_ref().map(|raising| Sorted::new(raising).sweep(Rule::NoOverlap));
    let of_alarms = of_alarms.as_ref().unwrap_or(&all);
    let losses = Losses::new(raising.as_ref().unwrap_or(&turned), of_alarms);
    let half = losses.at_half();
    let areas = areas(&all);
    let (lost, good) = all.totals();
    let ece = if method.is_probability { ece(tracks, method.direction) } else { None };
    let samples = seed.map(|seed| Samples::new(all.lost.len(), seed));
    let in_samples =
        |samples: &Samples| Sampled { auroc: samples.auroc(&all), found_at_5: losses.found_in(5.0, samples) };
    let sampled = samples.as_ref().map(in_samples).unwrap_or_default();
    let scores =
        Scores { all: &all, clear: &clear, warning: &warning, half, losses: &losses, areas, ece, sampled };
    let counts = [good, lost, losses.count() as u64].map(|count| Some(count as f64));
    let mut measures = FrameMeasures { counts, ..FrameMeasures::default() };
    for (measure, [value, low, high]) in FRAME_METRICS.iter().zip(&mut measures.measured) {
        if let Of::Scores(of) = measure.of {
            *value = of(&scores);
        }
        let bounds = measure.bounds.zip(samples.as_ref());
        (*low, *high) = bounds.and_then(|(of, samples)| of(&scores, samples)).unzip();
    }
    (measures, scores.sampled)
}

/// Scores with a sign such that high values speak for a failure.
fn turn(scores: &[f64], method: Method) -> Cow<'_, [f64]> {
    match method.direction {
        Direction::HigherIsBetter => scores.iter().map(|s| -s).collect(),
        Direction::LowerIsBetter | Direction::Neither => scores.into(),
    }
}

/// The tracks with their scores replaced.
fn with_scores<'a>(tracks: &[ScoredTrack<'a>], scores: &'a [Cow<'a, [f64]>]) -> Vec<ScoredTrack<'a>> {
    tracks.iter().zip(scores).map(|(track, score)| ScoredTrack { score, ..*track }).collect()
}

/// Adds the measures of alarms to those of scores.
pub fn with_alarms(of_scores: FrameMeasures, tracks: &[ScoredTrack<'_>]) -> FrameMeasures {
    let alarms = Alarms { range: range::score(tracks), nab: nab::score(tracks) };
    let mut measures = of_scores;
    for (measure, [value, ..]) in FRAME_METRICS.iter().zip(&mut measures.measured) {
        if let Of::Alarms(of) = measure.of {
            *value = of(&alarms);
        }
    }
    measures
}

/// Calibration error of scores that are probabilities.
fn ece(tracks: &[ScoredTrack<'_>], direction: Direction) -> Option<f64> {
    let frame = |(error, score): (&f64, &f64)| {
        let p = if direction == Direction::HigherIsBetter { *score } else { 1.0 - score };
        Some((p, !Rule::NoOverlap.judge(*error)?))
    };
    expected_calibration_error(tracks.iter().flat_map(|t| t.error.iter().zip(t.score)).filter_map(frame))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::oracle;
    use std::collections::BTreeMap;
    use trackfail_testing::assert_near;

    const GOOD_IS_LOW: Method = Method { direction: Direction::LowerIsBetter, is_probability: false };
    const PROBABILITY: Method = Method { is_probability: true, ..GOOD_IS_LOW };
    const SIGNAL: [f64; 8] = [0.9, 0.8, 0.9, 0.2, 0.3, 0.1, 0.7, 0.9];
    const ERROR: [f64; 8] = [0.0, 0.1, 0.2, 1.0, 1.0, f64::NAN, 0.4, 0.1];

    fn tracks<'a>(score: &'a [f64], alarm: &'a [bool]) -> Vec<ScoredTrack<'a>> {
        (0..4).map(|sequence| ScoredTrack { sequence, error: &ERROR, score, alarm }).collect()
    }

    #[test]
    fn signals_of_which_low_values_are_bad_are_turned() {
        let alarm = SIGNAL.map(|y| y < 0.5);
        let good = Method { direction: Direction::HigherIsBetter, ..PROBABILITY };
        let found = measure(&tracks(&SIGNAL, &alarm), None, good, Some(1));
        for name in "auroc auprc auroc_clear auroc_low auroc_high range_precision range_recall".split(' ') {
            assert_eq!(found.get(name), Some(1.0), "{name}");
        }
        let columns = ["good_frames", "lost_frames", "losses", "false_alarms_at_half", "delay_at_half"];
        assert_eq!(columns.map(|name| found.get(name)), [20.0, 8.0, 4.0, 0.0, 2.0].map(Some));
        let mut read = FrameMeasures::default();
        columns.iter().for_each(|name| read.set(name, found.get(name)));
        assert_eq!(columns.map(|name| read.get(name)), columns.map(|name| found.get(name)));
        assert!(found.get("nab").is_some() && found.get("ece").is_some_and(|e| e > 0.0));
        // Suspicion in place of confidence is the same detector.
        let turned = SIGNAL.map(|y| 1.0 - y);
        let other = measure(&tracks(&turned, &alarm), None, PROBABILITY, Some(1));
        assert_near(found.get("ece"), other.get("ece"), 1e-15, "");
        let without_ece = |mut measures: FrameMeasures| {
            measures.set("ece", None);
            measures
        };
        assert_eq!(without_ece(found), without_ece(other));
    }

    /// Errors, scores and alarms of a track for which all measures differ. `measures` in
    /// `tests/oracles/frames.py` has the track of `kind` 0; other kinds have other scores.
    fn varied(kind: u32) -> (Vec<f64>, Vec<f64>, Vec<bool>) {
        let losses = [100_u32..140, 300..320, 450..480];
        let is_lost = |t: &u32| losses.iter().any(|loss| loss.contains(t));
        let error = |t: u32| match t {
            _ if is_lost(&t) => 1.0,
            200..210 => f64::NAN,
            _ if t % 10 == 3 => 0.95,
            _ if t % 10 == 7 => 0.7,
            _ => 0.2,
        };
        let lower = 0.03 * f64::from(kind);
        let peaks = [(105, 0.99 - lower), (308, 0.9 - lower), (460, 0.8 - lower)];
        let peaks = [[(30_u32, 0.95), (60, 0.85), (230, 0.75), (250, 0.65)].as_slice(), &peaks].concat();
        let score = |t: u32| {
            let rise = losses.iter().find(|loss| (loss.start - 20..loss.start).contains(&t));
            let rise = rise.map_or(0.0, |loss| 0.01 * f64::from(t + 20 - loss.start));
            let base = match is_lost(&t) {
                true => 0.2 + f64::from((t * 17 + kind * 7) % 23) / 46.0,
                false => f64::from((t * 37 + kind * 29) % 101) / 404.0,
            };
            let peak = peaks.iter().find(|peak| peak.0 == t).map(|peak| peak.1);
            peak.unwrap_or(base + f64::from(t) / 1_048_576.0 + rise)
        };
        let score: Vec<f64> = (0..600).map(score).collect();
        let alarm = score.iter().enumerate().map(|(t, s)| *s >= 0.4 || (90..110).contains(&t)).collect();
        ((0..600).map(error).collect(), score, alarm)
    }

    fn of_varied(kinds: &[u32], seed: Option<u64>) -> FrameMeasures {
        let all: Vec<_> = kinds.iter().map(|kind| varied(*kind)).collect();
        let track = |sequence: usize| {
            let (error, score, alarm) = &all[sequence];
            ScoredTrack { sequence, error, score, alarm }
        };
        let tracks: Vec<ScoredTrack<'_>> = (0..all.len()).map(track).collect();
        measure(&tracks, None, PROBABILITY, seed)
    }

    // Sequences that are all the same have the same value in every sample.
    #[test]
    fn every_measure_has_its_own_value_and_bounds() {
        let (found, expected) = (of_varied(&[0], None), oracle::<BTreeMap<String, f64>>("measures"));
        assert_eq!(expected.len(), FRAME_METRICS.len());
        let copies = of_varied(&[0; 3], Some(1));
        for measure in FRAME_METRICS {
            let name = measure.metric.name();
            let (value, repeated) = (found.get(name).unwrap(), copies.get(name).unwrap());
            assert!((value - expected[name]).abs() < 1e-12, "{name}: {value}, not {}", expected[name]);
            let bounds = copies.bounds(name);
            let is_near =
                |(low, high): (f64, f64)| [low, high].iter().all(|end| (end - repeated).abs() < 1e-12);
            assert_eq!(bounds.map(is_near), measure.bounds.map(|_| true), "{name}: {bounds:?} {repeated}");
        }
    }

    #[test]
    fn every_interval_holds_its_value() {
        let kinds: Vec<u32> = (0..12).collect();
        let found = of_varied(&kinds, Some(1));
        let mut names = Vec::new();
        for measure in FRAME_METRICS.iter().filter(|measure| measure.bounds.is_some()) {
            let name = measure.metric.name();
            let of = |end: &str| found.get(&format!("{name}{end}")).unwrap();
            let (low, value, high) = (of("_low"), of(""), of("_high"));
            assert!(low <= value && value <= high && low < high, "{name}: {low} {value} {high}");
            names.push(name);
        }
        let ranked = ["auroc", "auprc", "auroc_clear", "false_alarms_at_half", "found_at_5"];
        assert_eq!(names, [&ranked[..], &["auroc_within_5", "auroc_within_15", "auroc_within_30"]].concat());
    }

    // A state that is right everywhere, and alarms that are raised in good frames alone, or in the first of each loss.
    #[test]
    fn the_state_has_its_measures_and_alarms_have_theirs() {
        let score = SIGNAL.map(|y| 1.0 - y);
        let of = |compared: [f64; 8]| {
            measure(&tracks(&score, &[false; 8]), Some(&[&compared[..]; 4]), PROBABILITY, Some(1))
        };
        let (wrong, right) = (of(ERROR.map(|e| f64::from(e < 1.0))), of([0., 0., 0., 1., 0., 0., 0., 0.]));
        for found in [&wrong, &right] {
            assert_eq!(found.get("auroc"), Some(1.0));
            assert_eq!(found.get("ece"), measure(&tracks(&score, &[]), None, PROBABILITY, None).get("ece"));
        }
        let found = |measures: &FrameMeasures| {
            ["found_at_5", "false_alarms_at_half", "delay_at_half"].map(|name| measures.get(name))
        };
        assert_eq!(found(&wrong), [Some(0.0), Some(1000.0), Some(0.0)]);
        assert_eq!(found(&right), [Some(1.0), Some(0.0), Some(0.0)]);
    }

    #[test]
    fn what_says_nothing_has_half_the_area_and_no_track_has_no_measure() {
        for says in [false, true] {
            let score = [f64::from(u8::from(says)); 8];
            let found = measure(&tracks(&score, &[says; 8]), None, GOOD_IS_LOW, Some(1));
            assert_eq!((found.get("auroc"), found.get("ece")), (Some(0.5), None));
        }
        let nothing = measure(&[], None, GOOD_IS_LOW, Some(1));
        assert_eq!(["auroc", "nab", "auroc_low"].map(|name| nothing.get(name)), [None; 3]);
    }

    #[test]
    fn the_order_of_tracks_does_not_matter() {
        // Scores of which many are equal.
        let rounded = |kind| {
            let (error, score, alarm) = varied(kind);
            (error, score.iter().map(|s| (10.0 * s).round()).collect::<Vec<f64>>(), alarm)
        };
        let all: Vec<_> = (0..5).map(rounded).collect();
        let track =
            |k: usize| ScoredTrack { sequence: k, error: &all[k].0, score: &all[k].1, alarm: &all[k].2 };
        let of = |order: [usize; 5]| measure(&order.map(track), None, GOOD_IS_LOW, Some(3));
        let (one, other) = (of([0, 1, 2, 3, 4]), of([3, 1, 4, 0, 2]));
        // What is not a count of frames is rounded in another order.
        for (names, within) in [("auroc auroc_low arl0_at_half", 0.0), ("auprc nab range_f", 1e-12)] {
            for name in names.split(' ') {
                assert_near(one.get(name), [other.get(name).unwrap()], within, name);
            }
        }
    }
}
