//! Counts of matched and unmatched detections and events, and ratios computed from these counts.
//!
//! ```text
//! precision P = TP / (TP + FP)      recall R = TP / (TP + FN)      FPR = FP / (FP + TN)
//! F = 2 TP / (2 TP + FP + FN)       the harmonic mean of P and R
//! accuracy = (TP + TN) / (TP + FP + FN + TN)              informedness J = R - FPR
//! miss rate = 1 - R              false alarms per 1000 frames = 1000 FP / (TP + FP + FN + TN)
//! ```
//!
//! All lie in `[0, 1]` except false alarms, which have no unit but their 1000 frames, and J in `[-1, 1]`, which is 0
//! for labels that are independent of the truth (Youden, "Index for rating diagnostic tests", Cancer 3, 1950). High
//! is good except for FPR, miss rate and false alarms. A ratio whose denominator is 0 has no value (`None`), which
//! is never written as 0. Pooled measures come from summed counts.

use serde::{Deserialize, Serialize};

/// True and false positives and negatives. The protocol defines what is positive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counts {
    /// Detections that match an event.
    pub tp: u64,
    /// Detections that match no event.
    pub fp: u64,
    /// Events that no detection matches.
    pub fn_: u64,
    /// Frames that are correctly silent.
    pub tn: u64,
}

/// One of the four counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// True positive.
    TruePositive,
    /// False positive.
    FalsePositive,
    /// False negative.
    FalseNegative,
    /// True negative.
    TrueNegative,
}

impl Place {
    /// Count of a case that is or is not positive, and was or was not called positive.
    pub fn of(is_positive: bool, is_called: bool) -> Self {
        match (is_positive, is_called) {
            (true, true) => Self::TruePositive,
            (false, true) => Self::FalsePositive,
            (true, false) => Self::FalseNegative,
            (false, false) => Self::TrueNegative,
        }
    }

    /// Name of the count's column.
    pub fn name(self) -> &'static str {
        match self {
            Self::TruePositive => "tp",
            Self::FalsePositive => "fp",
            Self::FalseNegative => "fn",
            Self::TrueNegative => "tn",
        }
    }
}

impl FromIterator<Place> for Counts {
    fn from_iter<I: IntoIterator<Item = Place>>(places: I) -> Self {
        let mut counts = Self::default();
        for place in places {
            *match place {
                Place::TruePositive => &mut counts.tp,
                Place::FalsePositive => &mut counts.fp,
                Place::FalseNegative => &mut counts.fn_,
                Place::TrueNegative => &mut counts.tn,
            } += 1;
        }
        counts
    }
}

impl std::iter::Sum for Counts {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |a, b| Self {
            tp: a.tp.saturating_add(b.tp),
            fp: a.fp.saturating_add(b.fp),
            fn_: a.fn_.saturating_add(b.fn_),
            tn: a.tn.saturating_add(b.tn),
        })
    }
}

pub(super) fn ratio(numerator: u64, denominator: u64) -> Option<f64> {
    (denominator > 0).then(|| numerator as f64 / denominator as f64)
}

impl Counts {
    /// Share of detections that match an event.
    pub fn precision(&self) -> Option<f64> {
        ratio(self.tp, self.tp + self.fp)
    }

    /// Share of events that are matched.
    pub fn recall(&self) -> Option<f64> {
        ratio(self.tp, self.tp + self.fn_)
    }

    /// Harmonic mean of precision and recall; 0 for a silent detector if there are events.
    pub fn f_score(&self) -> Option<f64> {
        ratio(2 * self.tp, 2 * self.tp + self.fp + self.fn_)
    }

    /// Share of frames that should be silent but are false positives.
    pub fn fpr(&self) -> Option<f64> {
        ratio(self.fp, self.fp + self.tn)
    }

    /// Share of frames that are labeled correctly.
    pub fn accuracy(&self) -> Option<f64> {
        ratio(self.tp + self.tn, self.tp + self.fp + self.fn_ + self.tn)
    }

    /// Share of events that are not detected.
    pub fn miss_rate(&self) -> Option<f64> {
        ratio(self.fn_, self.tp + self.fn_)
    }

    /// Number of such cases per 1000 frames that the protocol counts.
    pub fn per_1000(&self, cases: u64) -> Option<f64> {
        Some(1000.0 * ratio(cases, self.tp + self.fp + self.fn_ + self.tn)?)
    }

    /// Recall minus false positive rate.
    pub fn informedness(&self) -> Option<f64> {
        Some(self.recall()? - self.fpr()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Khalid et al. 2016, Table 1, DTEF: the counts implied by its ratios.
    #[test]
    fn reproduces_the_papers_ratios_from_its_counts() {
        let c = Counts { tp: 30, fp: 242, fn_: 12, tn: 6475 - 242 };
        let shown = [c.precision(), c.recall(), c.f_score(), c.fpr()].map(|v| format!("{:.3}", v.unwrap()));
        assert_eq!(shown, ["0.110", "0.714", "0.191", "0.037"]);
    }

    #[test]
    fn a_ratio_without_denominator_has_no_value() {
        let (silent, none) = (Counts { tp: 0, fp: 0, fn_: 3, tn: 10 }, Counts::default());
        assert_eq!([silent.precision(), none.f_score(), none.accuracy(), none.fpr()], [None; 4]);
        assert_eq!([none.miss_rate(), none.per_1000(0)], [None; 2]);
        assert_eq!([silent.recall(), silent.f_score(), silent.informedness()], [Some(0.0); 3]);
    }
}
