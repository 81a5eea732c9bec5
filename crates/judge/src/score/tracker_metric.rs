//! Metrics of trackers themselves, which the analyses `success`, `average-overlap`, `resets`, `longterm` and
//! `oxuva` put into tables.
//!
//! The functions are in [`super::success`], [`super::average_overlap`], [`super::resets`], [`super::longterm`] and
//! [`super::oxuva`]; analyses take the names and headings of their numbers and columns from here, reports the directions.

use crate::direction::Direction::{self, HigherIsBetter, LowerIsBetter, Neither};

/// A metric of how well a tracker follows its targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrackerMetric {
    /// Name among the numbers of an analysis, in claims and comparisons.
    pub name: &'static str,
    /// Heading of the column in tables.
    pub heading: &'static str,
    /// Direction in which values are better.
    pub direction: Direction,
    /// Unit of the values; empty for numbers without a unit.
    pub unit: &'static str,
    /// Computation in words.
    pub formula: &'static str,
}

impl TrackerMetric {
    /// Metric with this column heading; `None` if there is none.
    pub fn of_heading(heading: &str) -> Option<Self> {
        TRACKER_METRICS.iter().find(|m| m.heading == heading).copied()
    }
}

/// Defines a constant for each line, and the list of all.
macro_rules! tracker_metrics {
    ($($constant:ident = $name:literal, $heading:literal, $direction:ident, $unit:literal, $formula:literal;)*) => {
        impl TrackerMetric {
            $(
                #[doc = $formula]
                pub const $constant: Self = Self {
                    name: $name,
                    heading: $heading,
                    direction: $direction,
                    unit: $unit,
                    formula: $formula,
                };
            )*
        }

        /// All metrics of trackers.
        pub const TRACKER_METRICS: &[TrackerMetric] = &[$(TrackerMetric::$constant),*];
    };
}

tracker_metrics! {
    SUCCESS_AUC = "success_auc", "success AUC", HigherIsBetter, "",
        "mean over 21 thresholds from 0 to 1 of the share of frames whose overlap is larger";
    PRECISION_20 = "precision_20", "precision@20", HigherIsBetter, "",
        "share of frames whose center error is at most 20 pixels";
    AO = "ao", "AO", HigherIsBetter, "",
        "mean overlap of the frames with ground truth after the start, those of all sequences alike";
    SR_50 = "sr_50", "SR.5", HigherIsBetter, "", "share of these frames whose overlap is larger than 0.5";
    SR_75 = "sr_75", "SR.75", HigherIsBetter, "", "share of these frames whose overlap is larger than 0.75";
    ACCURACY = "accuracy", "accuracy", HigherIsBetter, "",
        "mean overlap of the frames that count, sequences weighted by their numbers of frames";
    ACCURACY_OF_SEQUENCES = "accuracy_of_sequences", "accuracy (sequences)", HigherIsBetter, "",
        "mean overlap of the frames that count, sequences with equal weights";
    ACCURACY_OF_ATTRIBUTES = "accuracy_of_attributes", "accuracy (attributes)", HigherIsBetter, "",
        "mean over attributes, weighted by their numbers of frames, of the mean overlap of the \
         frames that count";
    FAILURES = "failures", "failures", LowerIsBetter, "failures",
        "sum over sequences of the mean over repetitions of the number of failures";
    FAILURES_OF_ATTRIBUTES = "failures_of_attributes", "failures (attributes)", LowerIsBetter, "failures",
        "mean over attributes, weighted by their numbers of frames, of the number of failures in them";
    EAO = "eao", "EAO", HigherIsBetter, "",
        "mean over run lengths of the expected average overlap of a run of that length";
    LT_PRECISION = "lt_precision", "Pr", HigherIsBetter, "",
        "mean overlap of the frames with enough confidence, at the threshold with the largest F";
    LT_RECALL = "lt_recall", "Re", HigherIsBetter, "",
        "sum of these overlaps over the number of frames with target";
    LT_F = "lt_f", "F", HigherIsBetter, "", "largest 2 Pr Re / (Pr + Re) over thresholds of the confidence";
    LT_THRESHOLD = "lt_threshold", "threshold", Neither, "", "lowest confidence that is enough there";
    OXUVA_TPR = "oxuva_tpr", "TPR", HigherIsBetter, "",
        "share of the frames with target in which it is said to be present and found with an \
         overlap of at least 1/2";
    OXUVA_TNR = "oxuva_tnr", "TNR", HigherIsBetter, "",
        "share of the frames without target in which it is said to be absent";
    OXUVA_GM = "oxuva_gm", "GM", HigherIsBetter, "", "geometric mean of TPR and TNR";
    OXUVA_MAX_GM = "oxuva_max_gm", "MaxGM", HigherIsBetter, "",
        "largest GM with absences said at random in addition";
}
