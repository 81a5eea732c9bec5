//! `resets`: accuracy, failures and expected average overlap of trackers that were run under the VOT reset
//! protocol, or whose results come from it.
//!
//! The measures are in [`crate::score::resets`]. A track of another protocol has no failures and is scored as
//! one long run.
//!
//! Numbers: `accuracy` (by frames), `accuracy_of_sequences`, `failures`, `eao` where a run is long enough,
//! and `accuracy_of_attributes` and `failures_of_attributes` where frames have labels. Tables: `overall`,
//! `sequences`, `attributes` (with the attribute `empty`, and the row `overall`: the mean over the
//! attributes). Charts: `accuracy-robustness`, one point per tracker, with `robustness = exp(-S failures /
//! frames)`, the chance to get through S frames, and the 95 % intervals of both over sequences
//! ([`trackfail_core::num::pooled`]); `expected-overlap`, E(N).

use super::INTERVAL;
use super::prelude::*;
use crate::score::resets::attributes::{Weights, by_attribute, overall as of_attributes};
use crate::score::resets::{Measured, Rules, expected_average_overlap, expected_overlap, of_sequence};
use crate::score::trajectory::mean;
use trackfail_core::num::pooled::{Draws, LEVEL, MIN_UNITS, SAMPLES};
use trackfail_core::num::seed::seed;

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<Params>(
    "resets",
    4,
    "accuracy, failures and expected average overlap of trackers, VOT reset protocol",
);

#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How areas are measured: `exact`, `raster-2014` or `vot-toolkit`.
    #[default(Areas::Exact)]
    pub areas: Areas,
    /// If true, only the part of a region on the frame counts.
    #[default(true)]
    pub bounded: bool,
    /// Number of frames after each start that do not count for the accuracy.
    #[default(10)]
    pub burn_in: usize,
    /// Shortest run of the expected average overlap, in frames.
    #[default(108)]
    pub low: usize,
    /// Longest run of the expected average overlap, in frames.
    #[default(371)]
    pub high: usize,
    /// Frames S of the robustness, above 0.
    #[default(30.0)]
    pub sensitivity: f64,
    /// Weights of the attributes in the mean over attributes: `frames` (number of frames with the attribute,
    /// as in published results) or `equal`.
    #[default(Weights::Frames)]
    pub attribute_weights: Weights,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[Range::of("low").at_least(1.0), Range::of("sensitivity").above(0.0)];

    fn check(&self) -> Result<(), ParamError> {
        ParamError::unless(self.low <= self.high, "low", "1 to `high`", self.low)
    }
}

/// The numbers of the analysis, and the columns of `overall`.
const OVERALL: [TrackerMetric; 6] = [
    TrackerMetric::ACCURACY,
    TrackerMetric::ACCURACY_OF_SEQUENCES,
    TrackerMetric::ACCURACY_OF_ATTRIBUTES,
    TrackerMetric::FAILURES,
    TrackerMetric::FAILURES_OF_ATTRIBUTES,
    TrackerMetric::EAO,
];

/// The columns of `sequences` and `attributes`.
const PARTS: [TrackerMetric; 2] = [TrackerMetric::ACCURACY, TrackerMetric::FAILURES];

/// Means of a sequence's runs.
struct OfSequence<'a> {
    name: &'a str,
    accuracy: f64,
    failures: f64,
    frames: f64,
}

/// Corners of the 95 % intervals of robustness and accuracy over sequences, for a curve named [`INTERVAL`].
/// Trackers with the same number of sequences get the same bootstrap draws.
fn corners(sequences: &[OfSequence<'_>], robustness: impl Fn(f64, f64) -> f64) -> Option<[(f64, f64); 2]> {
    // Overlap, failures and frames, in billionths: both axes are ratios of their sums.
    let of =
        |s: &OfSequence<'_>| [s.accuracy * s.frames, s.failures, s.frames].map(|v| (v * 1e9).round() as i64);
    let sums: Vec<[i64; 3]> = sequences.iter().map(of).collect();
    if sums.len() < MIN_UNITS {
        return None;
    }
    let draws = Draws::new(sums.len(), SAMPLES, seed(0, &["resets"]));
    let whole = |sum: i64| sum as f64 / 1e9;
    let of_robustness = |&[_, failures, frames]: &[i64; 3]| Some(robustness(whole(failures), whole(frames)));
    let of_accuracy = |&[overlap, _, frames]: &[i64; 3]| Some(overlap as f64 / frames as f64);
    let (left, right) = draws.interval(&sums, of_robustness, LEVEL)?;
    let (lower, upper) = draws.interval(&sums, of_accuracy, LEVEL)?;
    Some([(left, lower), (right, upper)])
}

impl Analysis for Params {
    fn reads(&self) -> Reads {
        Reads::Regions
    }

    fn layout(&self, _: usize) -> Layout {
        let robustness = format!("robustness, exp(-{} failures / frames)", self.sensitivity);
        Layout::of_trackers(&OVERALL)
            .measures("sequences", "sequence", &PARTS)
            .measures("attributes", "attribute", &PARTS)
            .chart("accuracy-robustness", &robustness, "accuracy")
            .chart("expected-overlap", "frames", "expected average overlap")
    }

    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError> {
        let rules = Rules { areas: self.areas, bounded: self.bounded, burn_in: self.burn_in };
        let tracks: Vec<(Trajectory<'_>, Measured)> =
            populations[0].trajectories.iter().map(|c| (*c, rules.measure(c))).collect();
        let mut sequences = Vec::new();
        let repetitions: Vec<_> = tracks.chunk_by(|a, b| a.0.sequence == b.0.sequence).collect();
        for runs in &repetitions {
            let measured: Vec<&Measured> = runs.iter().map(|r| &r.1).collect();
            if let Some((accuracy, failures)) = of_sequence(&measured) {
                let (name, frames) = (runs[0].0.sequence, runs[0].0.regions.len() as f64);
                sequences.push(OfSequence { name, accuracy, failures, frames });
            }
        }
        let plain = mean(sequences.iter().map(|s| s.accuracy)).ok_or(AnalysisError::NoTrack)?;
        let frames: f64 = sequences.iter().map(|s| s.frames).sum();
        let accuracy = sequences.iter().map(|s| s.accuracy * s.frames).sum::<f64>() / frames;
        let failures: f64 = sequences.iter().map(|s| s.failures).sum();
        let curve = expected_overlap(&tracks);
        let eao = expected_average_overlap(&curve, self.low, self.high);
        let attributes = by_attribute(&repetitions);
        let (weighted_accuracy, weighted_failures) = of_attributes(&attributes, self.attribute_weights);
        let overall =
            [Some(accuracy), Some(plain), weighted_accuracy, Some(failures), weighted_failures, eao];
        let mut attribute_rows: Vec<Row> =
            attributes.into_iter().map(|a| (a.name, vec![a.accuracy, Some(a.failures)])).collect();
        if !attribute_rows.is_empty() {
            attribute_rows.push(("overall".into(), vec![weighted_accuracy, weighted_failures]));
        }
        let rows = sequences.iter().map(|s| (s.name.to_string(), vec![Some(s.accuracy), Some(s.failures)]));
        let robustness = |failures: f64, frames: f64| (-self.sensitivity * failures / frames).exp();
        let mut of_robustness = vec![(String::new(), vec![(robustness(failures, frames), accuracy)])];
        of_robustness
            .extend(corners(&sequences, robustness).map(|ends| (INTERVAL.to_string(), ends.to_vec())));
        let points = curve.iter().enumerate().skip(1).filter_map(|(n, e)| Some((n as f64, (*e)?))).collect();
        let eao_name = eao.map_or_else(String::new, |eao| format!("[{eao:.3}]"));
        let mut values = Values::of_tracker(&overall);
        values.tables.extend([rows.collect(), attribute_rows]);
        values.charts = vec![of_robustness, vec![(eao_name, points)]];
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_core::region::Rect;
    use trackfail_testing::assert_near;

    // Worked by hand: two runs of four frames, shift 5 of 10 in the second (overlap 1/3), lost in the third frame of
    // the second run; the attribute is on in frames 2 and 3 (from 0).
    #[test]
    fn attributes_count_their_own_frames() {
        let square = |x: f64| Region::Rect(Rect::new(x, 0.0, 10.0, 10.0));
        use Status::{Failed, Initialized as Started, Skipped, Tracked};
        let truth = vec![Some(square(0.0)); 4];
        let regions = [square(0.0), square(5.0), square(5.0), square(0.0)];
        let flags = vec![("occlusion".to_string(), vec![false, false, true, true])];
        let trajectory = |run, status| Trajectory {
            sequence: "a",
            run,
            regions: &regions,
            status,
            truth: &truth,
            frame: Some((99, 99)),
            frame_attributes: &flags,
            ..Trajectory::default()
        };
        let resets = Params { burn_in: 1, ..Params::default() };
        let trajectories = vec![
            trajectory(0, &[Started, Tracked, Tracked, Tracked]),
            trajectory(1, &[Started, Tracked, Failed, Skipped]),
        ];
        let population = Population { suite: "s", tracks: Vec::new(), trajectories, timings: vec![] };
        let findings = resets.analyze(&[population]).unwrap();
        let rows = &findings.tables[2].rows;
        let names: Vec<&str> = rows.iter().map(|row| row.0.as_str()).collect();
        assert_eq!(names, ["empty", "occlusion", "overall"]);
        // In frame 1 both runs have 1/3; frame 0 is a start.
        let values = rows.iter().flat_map(|(_, row)| [row[0].unwrap(), row[1].unwrap()]);
        assert_near(values, [1.0 / 3.0, 0.0, 2.0 / 3.0, 0.5, 0.5, 0.25], 1e-12, "");
        assert_eq!(findings.number("failures_of_attributes"), Some(0.25));
        // First run (1/3 + 1/3 + 1) / 3, second 1/3.
        assert_near(findings.number("accuracy"), [(5.0 / 9.0 + 1.0 / 3.0) / 2.0], 1e-12, "");
        assert_eq!((findings.number("failures"), findings.number("eao")), (Some(0.5), None));
    }

    // SciPy 1.17, scipy.stats.bootstrap of the two ratios, paired, 300,000 draws, percentiles.
    #[test]
    fn bars_have_the_intervals_of_ratios_of_sums() {
        let sequence = |(accuracy, failures, frames)| OfSequence { name: "", accuracy, failures, frames };
        let sequences = [
            (0.5, 1.0, 10.0),
            (0.8, 0.0, 20.0),
            (0.6, 2.0, 30.0),
            (0.7, 0.0, 15.0),
            (0.4, 3.0, 25.0),
            (0.9, 1.0, 40.0),
        ]
        .map(sequence);
        let robustness = |failures: f64, frames: f64| (-30.0 * failures / frames).exp();
        let [low, high] = corners(&sequences, robustness).unwrap();
        assert_near([low.0, high.0, low.1, high.1], [0.0695, 0.5979, 0.5087, 0.8243], 0.01, "");
        assert_eq!(corners(&sequences[..2], robustness), None);
    }
}
