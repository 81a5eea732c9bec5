//! The metrics of trackers themselves: what the analyses `success`, `average-overlap`, `resets`, `longterm` and `oxuva` put
//! into tables.
//!
//! The functions are in [`super::success`], [`super::average_overlap`], [`super::resets`], [`super::longterm`] and
//! [`super::oxuva`]; the analyses take the names and headings of their numbers and columns from here, reports the directions.

use crate::direction::Direction::{self, HigherIsBetter, LowerIsBetter, Neither};

/// A number that says how well a tracker follows its targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrackerMetric {
    /// Name among the numbers of an analysis, in claims and comparisons.
    pub name: &'static str,
    /// Heading of its column.
    pub heading: &'static str,
    /// Whether larger or smaller is better.
    pub direction: Direction,
    /// The unit of its values; empty for a number without unit.
    pub unit: &'static str,
    /// How it is computed, in words.
    pub formula: &'static str,
}

impl TrackerMetric {
    /// Area under the success curve.
    pub const SUCCESS_AUC: Self = Self {
        name: "success_auc",
        heading: "success AUC",
        direction: HigherIsBetter,
        unit: "",
        formula: "mean over 21 thresholds from 0 to 1 of the share of frames whose overlap is larger",
    };
    /// Precision at 20 pixels.
    pub const PRECISION_20: Self = Self {
        name: "precision_20",
        heading: "precision@20",
        direction: HigherIsBetter,
        unit: "",
        formula: "share of frames whose center error is at most 20 pixels",
    };
    /// Average overlap.
    pub const AO: Self = Self {
        name: "ao",
        heading: "AO",
        direction: HigherIsBetter,
        unit: "",
        formula: "mean overlap of the frames with ground truth after the start, those of all sequences alike",
    };
    /// Success rate at 0.5.
    pub const SR_50: Self = Self {
        name: "sr_50",
        heading: "SR.5",
        direction: HigherIsBetter,
        unit: "",
        formula: "share of these frames whose overlap is larger than 0.5",
    };
    /// Success rate at 0.75.
    pub const SR_75: Self = Self {
        name: "sr_75",
        heading: "SR.75",
        direction: HigherIsBetter,
        unit: "",
        formula: "share of these frames whose overlap is larger than 0.75",
    };
    /// Accuracy of the reset protocol, weighted by frames.
    pub const ACCURACY: Self = Self {
        name: "accuracy",
        heading: "accuracy",
        direction: HigherIsBetter,
        unit: "",
        formula: "mean overlap of the frames that count, sequences weighted by their numbers of frames",
    };
    /// Accuracy of the reset protocol with equal weights.
    pub const ACCURACY_OF_SEQUENCES: Self = Self {
        name: "accuracy_of_sequences",
        heading: "accuracy (sequences)",
        direction: HigherIsBetter,
        unit: "",
        formula: "mean overlap of the frames that count, sequences with equal weights",
    };
    /// Accuracy of the reset protocol, a mean over attributes.
    pub const ACCURACY_OF_ATTRIBUTES: Self = Self {
        name: "accuracy_of_attributes",
        heading: "accuracy (attributes)",
        direction: HigherIsBetter,
        unit: "",
        formula: "mean over attributes, weighted by their numbers of frames, of the mean overlap of the frames that count",
    };
    /// Failures of the reset protocol, a mean over attributes.
    pub const FAILURES_OF_ATTRIBUTES: Self = Self {
        name: "failures_of_attributes",
        heading: "failures (attributes)",
        direction: LowerIsBetter,
        unit: "failures",
        formula: "mean over attributes, weighted by their numbers of frames, of the number of failures in them",
    };
    /// Failures of the reset protocol.
    pub const FAILURES: Self = Self {
        name: "failures",
        heading: "failures",
        direction: LowerIsBetter,
        unit: "failures",
        formula: "sum over sequences of the mean over repetitions of the number of restarts",
    };
    /// Expected average overlap.
    pub const EAO: Self = Self {
        name: "eao",
        heading: "EAO",
        direction: HigherIsBetter,
        unit: "",
        formula: "mean over run lengths of the expected average overlap of a run of that length",
    };

    /// Mean overlap of the frames with enough confidence, at the threshold with the largest F.
    pub const LT_PRECISION: Self = Self {
        name: "lt_precision",
        heading: "Pr",
        direction: HigherIsBetter,
        unit: "",
        formula: "mean overlap of the frames with enough confidence, at the threshold with the largest F",
    };
    /// Sum of these overlaps over the number of frames with target.
    pub const LT_RECALL: Self = Self {
        name: "lt_recall",
        heading: "Re",
        direction: HigherIsBetter,
        unit: "",
        formula: "sum of these overlaps over the number of frames with target",
    };
    /// Largest 2 Pr Re / (Pr + Re) over thresholds of the confidence.
    pub const LT_F: Self = Self {
        name: "lt_f",
        heading: "F",
        direction: HigherIsBetter,
        unit: "",
        formula: "largest 2 Pr Re / (Pr + Re) over thresholds of the confidence",
    };
    /// Lowest confidence that is enough there.
    pub const LT_THRESHOLD: Self = Self {
        name: "lt_threshold",
        heading: "threshold",
        direction: Neither,
        unit: "",
        formula: "lowest confidence that is enough there",
    };
    /// Share of the frames with target in which it is said to be present and found with an overlap of at least 1/2.
    pub const OXUVA_TPR: Self = Self {
        name: "oxuva_tpr",
        heading: "TPR",
        direction: HigherIsBetter,
        unit: "",
        formula: "share of the frames with target in which it is said to be present and found with an overlap of at least 1/2",
    };
    /// Share of the frames without target in which it is said to be absent.
    pub const OXUVA_TNR: Self = Self {
        name: "oxuva_tnr",
        heading: "TNR",
        direction: HigherIsBetter,
        unit: "",
        formula: "share of the frames without target in which it is said to be absent",
    };
    /// Geometric mean of TPR and TNR.
    pub const OXUVA_GM: Self = Self {
        name: "oxuva_gm",
        heading: "GM",
        direction: HigherIsBetter,
        unit: "",
        formula: "geometric mean of TPR and TNR",
    };
    /// Largest GM with absences said at random in addition.
    pub const OXUVA_MAX_GM: Self = Self {
        name: "oxuva_max_gm",
        heading: "MaxGM",
        direction: HigherIsBetter,
        unit: "",
        formula: "largest GM with absences said at random in addition",
    };

    /// The metric of a column's heading.
    pub fn of_heading(heading: &str) -> Option<Self> {
        TRACKER_METRICS.iter().find(|m| m.heading == heading).copied()
    }
}

/// Every metric of trackers.
pub const TRACKER_METRICS: &[TrackerMetric] = &[
    TrackerMetric::SUCCESS_AUC,
    TrackerMetric::PRECISION_20,
    TrackerMetric::AO,
    TrackerMetric::SR_50,
    TrackerMetric::SR_75,
    TrackerMetric::ACCURACY,
    TrackerMetric::ACCURACY_OF_SEQUENCES,
    TrackerMetric::ACCURACY_OF_ATTRIBUTES,
    TrackerMetric::FAILURES,
    TrackerMetric::FAILURES_OF_ATTRIBUTES,
    TrackerMetric::EAO,
    TrackerMetric::LT_PRECISION,
    TrackerMetric::LT_RECALL,
    TrackerMetric::LT_F,
    TrackerMetric::LT_THRESHOLD,
    TrackerMetric::OXUVA_TPR,
    TrackerMetric::OXUVA_TNR,
    TrackerMetric::OXUVA_GM,
    TrackerMetric::OXUVA_MAX_GM,
];
