//! All measures of a detector frame by frame, pooled over the tracks of a suite.

use super::alarms::Losses;
use super::bootstrap::{Samples, interval};
use super::calibration::expected_calibration_error;
use super::coverage::areas;
use super::nab;
use super::range::{self, RANGE_1};
use super::ranking::{auroc, average_precision};
use super::sweep::Sorted;
use super::truth::{Rule, ScoredTrack};
use crate::direction::Direction;

/// Measures of one detector on the tracks of a suite. What has no value is `None`; `low` and `high` are the bounds of
/// bootstrap intervals over sequences at 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameMeasures {
    /// Annotated frames that are not lost by `frames/1`.
    pub good_frames: Option<f64>,
    /// Lost frames.
    pub lost_frames: Option<f64>,
    /// Ranges of lost frames that follow a frame that was not lost.
    pub losses: Option<f64>,
    /// Area under the ROC curve, `frames/1`.
    pub auroc: Option<f64>,
    /// Its lower bound.
    pub auroc_low: Option<f64>,
    /// Its upper bound.
    pub auroc_high: Option<f64>,
    /// Average precision, `frames/1`.
    pub auprc: Option<f64>,
    /// Its lower bound.
    pub auprc_low: Option<f64>,
    /// Its upper bound.
    pub auprc_high: Option<f64>,
    /// Area under the ROC curve, `frames-clear/1`.
    pub auroc_clear: Option<f64>,
    /// Its lower bound.
    pub auroc_clear_low: Option<f64>,
    /// Its upper bound.
    pub auroc_clear_high: Option<f64>,
    /// Average precision, `frames-clear/1`.
    pub auprc_clear: Option<f64>,
    /// False alarms per 1000 good frames at the threshold that finds half of the losses.
    pub false_alarms_at_half: Option<f64>,
    /// Its lower bound.
    pub false_alarms_at_half_low: Option<f64>,
    /// Its upper bound.
    pub false_alarms_at_half_high: Option<f64>,
    /// Mean delay there, in frames.
    pub delay_at_half: Option<f64>,
    /// Good frames for each false alarm there.
    pub arl0_at_half: Option<f64>,
    /// Share of the losses found at 2 false alarms per 1000 good frames.
    pub found_at_2: Option<f64>,
    /// Share of the losses found at 5 false alarms per 1000 good frames.
    pub found_at_5: Option<f64>,
    /// Its lower bound.
    pub found_at_5_low: Option<f64>,
    /// Its upper bound.
    pub found_at_5_high: Option<f64>,
    /// Area under the risk-coverage curve.
    pub aurc: Option<f64>,
    /// Area under the generalized risk-coverage curve.
    pub augrc: Option<f64>,
    /// Expected calibration error of a score that is a probability.
    pub ece: Option<f64>,
    /// Precision of alarm ranges, `range/1`.
    pub range_precision: Option<f64>,
    /// Recall of lost ranges, `range/1`.
    pub range_recall: Option<f64>,
    /// Harmonic mean of the two.
    pub range_f: Option<f64>,
    /// Score of the Numenta Anomaly Benchmark, `nab/1`.
    pub nab: Option<f64>,
}

impl FrameMeasures {
    /// The bounds of a measure that has an interval, by the measure's name.
    pub fn interval(&self, name: &str) -> Option<(f64, f64)> {
        match name {
            "auroc" => self.auroc_low.zip(self.auroc_high),
            "auprc" => self.auprc_low.zip(self.auprc_high),
            "auroc_clear" => self.auroc_clear_low.zip(self.auroc_clear_high),
            "false_alarms_at_half" => self.false_alarms_at_half_low.zip(self.false_alarms_at_half_high),
            "found_at_5" => self.found_at_5_low.zip(self.found_at_5_high),
            _ => None,
        }
    }
}

/// How the scores of a method are to be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Method {
    /// Which scores are good.
    pub direction: Direction,
    /// Whether a score is a probability: that the tracker is on target where high scores are good, else that it is not.
    pub is_probability: bool,
}

/// Measures in bootstrap samples of sequences, which are the same for all detectors on the same sequences.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sampled {
    /// Area under the ROC curve in each sample, NaN where it has none.
    pub auroc: Vec<f64>,
    /// Share of the losses found at 5 false alarms per 1000 good frames in each sample, NaN where there is no loss.
    pub found_at_5: Vec<f64>,
}

/// Computes the measures. The scores of the tracks are as the detector gives them; with a seed there are intervals.
pub fn measure(tracks: &[ScoredTrack<'_>], method: Method, seed: Option<u64>) -> FrameMeasures {
    with_alarms(of_scores(tracks, method, seed).0, tracks)
}

/// The measures of scores, all but those of [`with_alarms`], and those in bootstrap samples.
pub fn of_scores(tracks: &[ScoredTrack<'_>], method: Method, seed: Option<u64>) -> (FrameMeasures, Sampled) {
    let turned: Vec<Vec<f64>> = match method.direction {
        Direction::HigherIsBetter => tracks.iter().map(|t| t.score.iter().map(|s| -s).collect()).collect(),
        Direction::LowerIsBetter | Direction::Neither => Vec::new(),
    };
    let turned: Vec<ScoredTrack<'_>> = match turned.is_empty() {
        true => tracks.to_vec(),
        false => tracks.iter().zip(&turned).map(|(track, score)| with_score(track, score)).collect(),
    };
    let sorted = Sorted::new(&turned);
    let (all, clear) = (sorted.sweep(Rule::NoOverlap), sorted.sweep(Rule::Clear));
    let losses = Losses::new(&turned);
    let half = losses.at_half(&all);
    let reached = losses.reached(&all);
    let areas = areas(&all);
    let (lost, good) = all.totals();
    let mut measures = FrameMeasures {
        good_frames: Some(good as f64),
        lost_frames: Some(lost as f64),
        losses: Some(losses.count() as f64),
        auroc: auroc(&all),
        auprc: average_precision(&all),
        auroc_clear: auroc(&clear),
        auprc_clear: average_precision(&clear),
        false_alarms_at_half: half.and_then(|h| h.false_alarms),
        delay_at_half: half.map(|h| h.delay),
        arl0_at_half: half.and_then(|h| h.arl0),
        found_at_2: reached.found(2.0),
        found_at_5: reached.found(5.0),
        aurc: areas.map(|a| a.aurc),
        augrc: areas.map(|a| a.augrc),
        ece: if method.is_probability { ece(tracks, method.direction) } else { None },
        ..FrameMeasures::default()
    };
    let mut sampled = Sampled::default();
    if let Some(seed) = seed {
        let samples = Samples::new(all.lost.len(), seed);
        sampled = Sampled { auroc: samples.auroc(&all), found_at_5: reached.found_in(5.0, &samples) };
        let put = |low: &mut Option<f64>, high: &mut Option<f64>, bounds: Option<(f64, f64)>| {
            (*low, *high) = bounds.unzip();
        };
        let m = &mut measures;
        put(&mut m.auroc_low, &mut m.auroc_high, interval(sampled.auroc.clone()));
        put(&mut m.auprc_low, &mut m.auprc_high, samples.average_precision(&all));
        put(&mut m.auroc_clear_low, &mut m.auroc_clear_high, interval(samples.auroc(&clear)));
        let bounds = reached.interval(&samples);
        put(&mut m.false_alarms_at_half_low, &mut m.false_alarms_at_half_high, bounds);
        put(&mut m.found_at_5_low, &mut m.found_at_5_high, interval(sampled.found_at_5.clone()));
    }
    (measures, sampled)
}

/// A track with other scores.
fn with_score<'a>(track: &ScoredTrack<'a>, score: &'a [f64]) -> ScoredTrack<'a> {
    ScoredTrack { score, ..*track }
}

/// Measures of scores with those of the alarms beside them.
pub fn with_alarms(of_scores: FrameMeasures, tracks: &[ScoredTrack<'_>]) -> FrameMeasures {
    let range = range::score(tracks, &RANGE_1);
    FrameMeasures {
        range_precision: range.precision,
        range_recall: range.recall,
        range_f: range.f_score(),
        nab: nab::score(tracks),
        ..of_scores
    }
}

/// Calibration of scores that are probabilities.
fn ece(tracks: &[ScoredTrack<'_>], direction: Direction) -> Option<f64> {
    let frame = |(error, score): (&f64, &f64)| {
        let p = if direction == Direction::HigherIsBetter { *score } else { 1.0 - score };
        Some((p, !Rule::NoOverlap.judge(*error)?))
    };
    expected_calibration_error(tracks.iter().flat_map(|t| t.error.iter().zip(t.score)).filter_map(frame))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use serde::Deserialize;

    /// Values of the reference programs, made by `tests/oracles/frames.py`.
    #[derive(Deserialize)]
    pub struct Oracle {
        pub ranking: Vec<Ranking>,
        pub coverage: Vec<Coverage>,
        pub calibration: Vec<Calibration>,
        pub range: Vec<RangeCase>,
        pub nab: Vec<Nab>,
    }

    #[derive(Deserialize)]
    pub struct Ranking {
        pub lost: Vec<u8>,
        pub score: Vec<f64>,
        pub auroc: f64,
        pub average_precision: f64,
    }

    #[derive(Deserialize)]
    pub struct Coverage {
        pub lost: Vec<u8>,
        pub score: Vec<f64>,
        pub aurc: f64,
        pub augrc: f64,
    }

    #[derive(Deserialize)]
    pub struct Calibration {
        pub good: Vec<u8>,
        pub p: Vec<f64>,
        pub ece: f64,
    }

    #[derive(Deserialize)]
    pub struct RangeCase {
        pub lost: Vec<u8>,
        pub alarm: Vec<u8>,
        pub alpha: f64,
        pub bias: String,
        pub precision: f64,
        pub recall: f64,
    }

    #[derive(Deserialize)]
    pub struct Nab {
        pub lost: Vec<u8>,
        pub alarm: Vec<u8>,
        pub score: f64,
        pub windows: u64,
    }

    pub fn oracle() -> Oracle {
        serde_json::from_str(include_str!("../../../../../tests/oracles/frames.json")).unwrap()
    }

    const SIGNAL: [f64; 8] = [0.9, 0.8, 0.9, 0.2, 0.3, 0.1, 0.7, 0.9];
    const ERROR: [f64; 8] = [0.0, 0.1, 0.2, 1.0, 1.0, f64::NAN, 0.4, 0.1];

    fn tracks<'a>(score: &'a [f64], alarm: &'a [bool]) -> Vec<ScoredTrack<'a>> {
        (0..4).map(|sequence| ScoredTrack { sequence, error: &ERROR, score, alarm }).collect()
    }

    #[test]
    fn signals_of_which_low_values_are_bad_are_turned() {
        let alarm = SIGNAL.map(|y| y < 0.5);
        let good = Method { direction: Direction::HigherIsBetter, is_probability: true };
        let found = measure(&tracks(&SIGNAL, &alarm), good, Some(1));
        assert_eq!((found.auroc, found.auprc, found.auroc_clear), (Some(1.0), Some(1.0), Some(1.0)));
        assert_eq!((found.false_alarms_at_half, found.delay_at_half), (Some(0.0), Some(2.0)));
        assert_eq!((found.good_frames, found.lost_frames, found.losses), (Some(20.0), Some(8.0), Some(4.0)));
        assert_eq!(found.interval("auroc"), Some((1.0, 1.0)));
        assert_eq!((found.range_precision, found.range_recall), (Some(1.0), Some(1.0)));
        assert!(found.nab.is_some() && found.ece.is_some_and(|e| e > 0.0));
        // Suspicion in place of confidence is the same detector.
        let turned = SIGNAL.map(|y| 1.0 - y);
        let bad = Method { direction: Direction::LowerIsBetter, is_probability: true };
        let other = measure(&tracks(&turned, &alarm), bad, Some(1));
        assert!((found.ece.unwrap() - other.ece.unwrap()).abs() < 1e-15);
        assert_eq!(FrameMeasures { ece: None, ..found }, FrameMeasures { ece: None, ..other });
    }

    #[test]
    fn what_says_nothing_has_half_the_area_and_no_track_has_no_measure() {
        let method = Method { direction: Direction::LowerIsBetter, is_probability: false };
        for says in [false, true] {
            let score = [f64::from(u8::from(says)); 8];
            let found = measure(&tracks(&score, &[says; 8]), method, Some(1));
            assert_eq!((found.auroc, found.ece), (Some(0.5), None));
        }
        let nothing = measure(&[], method, Some(1));
        assert_eq!((nothing.auroc, nothing.nab, nothing.interval("auroc")), (None, None, None));
    }

    #[test]
    fn the_order_of_tracks_does_not_matter() {
        let scores: Vec<Vec<f64>> =
            (0..5).map(|k| (0..40).map(|t| f64::from((t * (k + 3)) % 11)).collect()).collect();
        let errors: Vec<Vec<f64>> =
            (0..5).map(|k| (0..40).map(|t| if (t + k) % 13 > 8 { 1.0 } else { 0.1 }).collect()).collect();
        let alarms: Vec<Vec<bool>> = scores.iter().map(|s| s.iter().map(|s| *s > 6.0).collect()).collect();
        let track =
            |k: usize| ScoredTrack { sequence: k, error: &errors[k], score: &scores[k], alarm: &alarms[k] };
        let method = Method { direction: Direction::LowerIsBetter, is_probability: false };
        let of = |order: [usize; 5]| measure(&order.map(track), method, Some(3));
        let (one, other) = (of([0, 1, 2, 3, 4]), of([3, 1, 4, 0, 2]));
        assert_eq!(
            (one.auroc, one.auroc_low, one.arl0_at_half),
            (other.auroc, other.auroc_low, other.arl0_at_half)
        );
        let near = |a: Option<f64>, b: Option<f64>| (a.unwrap() - b.unwrap()).abs() < 1e-12;
        assert!(near(one.auprc, other.auprc) && near(one.nab, other.nab) && near(one.range_f, other.range_f));
    }
}
