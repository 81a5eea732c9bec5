//! `oxuva`: whether a tracker finds its target, and whether it knows when there is none, by the rules of OxUvA.
//!
//! The measures are in [`crate::score::oxuva`]. The signal is used as the confidence; a high value means that
//! the tracker is sure. A tracker says that the target is absent by its status, or by a confidence below
//! `threshold`, where one is given. A frame without annotation counts as a frame without target. The frames
//! before a start, and the frame of the start, which OxUvA does not label, are left out. The frames of all
//! runs and sequences have equal weights. A frame without a box has overlap 0. If the signal is the tracker's
//! confidence, a frame without a confidence has confidence 0.
//!
//! Numbers: `oxuva_tpr`, `oxuva_tnr`, `oxuva_gm`, `oxuva_max_gm`. Table: `overall`. Chart: `rates`, TPR over TNR for every
//! threshold on the confidence.

use super::confident::{ConfidentFrame, sequences};
use super::consistent::ascending;
use super::prelude::*;
use crate::score::Counts;
use crate::score::oxuva::{Rates, place};

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<Params>(
    "oxuva",
    2,
    "true positive and true negative rate of presence, their geometric mean, and its maximum (OxUvA)",
)
.example("{ rules = \"oxuva/1\", threshold = 0.1 }");

/// Value of `rules`; there are no other rules.
const RULES: &str = "oxuva/1";

/// Largest number of points in the chart.
const POINTS: usize = 101;

#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Rules of the evaluation: `oxuva/1`.
    #[default(RULES.to_string())]
    pub rules: String,
    /// If the confidence is below this, the target is taken as absent; without a threshold only the status
    /// decides.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[Range::of("threshold")];

    fn check(&self) -> Result<(), ParamError> {
        if self.rules == RULES { Ok(()) } else { Err(unknown_rules(&self.rules, [RULES])) }
    }
}

/// The numbers of the analysis, and the columns of its table.
const NUMBERS: [TrackerMetric; 4] = [
    TrackerMetric::OXUVA_TPR,
    TrackerMetric::OXUVA_TNR,
    TrackerMetric::OXUVA_GM,
    TrackerMetric::OXUVA_MAX_GM,
];

/// Confidence in a frame; without any the program reads 0.
fn confidence(frame: &ConfidentFrame) -> f64 {
    frame.confidence.unwrap_or(0.0)
}

/// Counts of frames by presence of the target and the tracker's answer, at this threshold on the confidence.
fn count(frames: &[ConfidentFrame], threshold: f64) -> Counts {
    let is_present = |f: &ConfidentFrame| f.status != Status::Absent && confidence(f) >= threshold;
    let judged = frames.iter().filter(|f| f.status != Status::Initialized);
    judged.map(|f| place(f.overlap, is_present(f))).collect()
}

impl Analysis for Params {
    fn reads(&self) -> Reads {
        Reads::SignalAndRegions
    }

    fn layout(&self, _: usize) -> Layout {
        Layout::of_trackers(&NUMBERS).chart("rates", "true negative rate", "true positive rate")
    }

    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError> {
        let sequences = sequences(&populations[0], Areas::Exact, false)?;
        let frames: Vec<ConfidentFrame> =
            sequences.into_iter().flat_map(|(_, runs)| runs).flatten().collect();
        let counts = count(&frames, self.threshold.unwrap_or(f64::NEG_INFINITY));
        let rates = Rates::of(&counts).ok_or(AnalysisError::NoAbsence)?;
        let scores = ascending(frames.iter().map(confidence));
        let at = |k: usize| scores[k * (scores.len() - 1) / (POINTS - 1)];
        let thresholds = (0..POINTS).map(at).chain([f64::INFINITY]);
        let mut points: Vec<(f64, f64)> =
            thresholds.filter_map(|h| Rates::of(&count(&frames, h))).map(|r| (r.tnr, r.tpr)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
        points.dedup();
        let mut values = Values::of_tracker(&[rates.tpr, rates.tnr, rates.gm, rates.max_gm].map(Some));
        values.charts.push(vec![(format!("[{:.3}]", rates.max_gm), points)]);
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(status: Status, overlap: Option<f64>, confidence: f64) -> ConfidentFrame {
        ConfidentFrame { status, overlap, confidence: Some(confidence) }
    }

    // By hand: the first frame does not count; the tracker says absent once, and is unsure once.
    #[test]
    fn absence_is_said_by_status_or_confidence() {
        let frames = [
            frame(Status::Initialized, Some(1.0), 1.0),
            frame(Status::Tracked, Some(0.6), 0.9),
            frame(Status::Tracked, Some(0.4), 0.9),
            frame(Status::Absent, Some(0.0), 0.9),
            frame(Status::Absent, None, 0.9),
            frame(Status::Tracked, None, 0.1),
            frame(Status::Tracked, Some(0.9), 0.1),
        ];
        let all = count(&frames, f64::NEG_INFINITY);
        assert_eq!(all, Counts { tp: 2, fp: 1, fn_: 2, tn: 1 });
        assert_eq!(count(&frames, 0.5), Counts { tp: 1, fp: 0, fn_: 3, tn: 2 });
    }
}
