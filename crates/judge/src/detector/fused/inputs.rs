//! Inputs of the fused detector: the signals that it knows by name, with their descriptions.

use super::features::FEATURES;
use crate::direction::Direction;

/// A signal that the fused detector can read.
#[derive(Debug, PartialEq)]
pub struct FusedInput {
    /// Name in the detector's parameters.
    pub name: &'static str,
    /// Name in reasons shown to users.
    pub words: &'static str,
    /// Direction in which values are good.
    pub good: Direction,
    /// True for motions: small positive numbers with large exceptions, which are compared by their
    /// logarithms.
    pub is_motion: bool,
    /// Number of features, the first ones of the list in fused/features.rs. Outputs of a network are
    /// comparable between tracks, so beyond the last frames their own past would mislead.
    pub features: usize,
    /// True for the overlap with a watchdog that follows the target from the first frame on. While the two
    /// overlap, a disagreement is news.
    pub is_watchdog_overlap: bool,
}

const fn high(name: &'static str, words: &'static str) -> FusedInput {
    FusedInput {
        name,
        words,
        good: Direction::HigherIsBetter,
        is_motion: false,
        features: FEATURES.len(),
        is_watchdog_overlap: false,
    }
}

const fn motion(name: &'static str, words: &'static str) -> FusedInput {
    FusedInput { good: Direction::LowerIsBetter, is_motion: true, ..high(name, words) }
}

/// A value of the signal `deep-verification` as an input.
const fn deep_high(name: &'static str, words: &'static str) -> FusedInput {
    FusedInput { features: 3, ..high(name, words) }
}

const fn deep_low(name: &'static str, words: &'static str) -> FusedInput {
    FusedInput { good: Direction::LowerIsBetter, ..deep_high(name, words) }
}

const fn deep_overlap(name: &'static str, words: &'static str) -> FusedInput {
    FusedInput { is_watchdog_overlap: true, ..deep_high(name, words) }
}

/// All inputs, by name.
pub static INPUTS: &[FusedInput] = &[
    motion("displacement", "displacement of the box"),
    motion("acceleration", "acceleration of the box"),
    motion("scale", "change of the box's area"),
    motion("aspect", "change of the box's aspect"),
    high("companions", "overlap with the other trackers"),
    high("share", "share of other trackers that overlap"),
    deep_overlap("v2-overlap", "overlap with watchdog v2"),
    deep_high("v2-score", "score of watchdog v2"),
    deep_low("v2-disagreement", "a sure other place of watchdog v2"),
    deep_low("v2-apart", "a sure place, off the box, of watchdog v2"),
    deep_low("v2-distance", "distance of watchdog v2"),
    deep_overlap("v3-overlap", "overlap with watchdog v3"),
    deep_high("v3-score", "score of watchdog v3"),
    deep_low("v3-disagreement", "a sure other place of watchdog v3"),
    deep_low("v3-apart", "a sure place, off the box, of watchdog v3"),
    deep_low("v3-distance", "distance of watchdog v3"),
    deep_low("both-product", "a sure other place of both watchdogs (product)"),
    deep_low("both-least", "a sure other place of both watchdogs"),
    deep_low("both-most", "a sure other place of one watchdog"),
    deep_high("both-overlap", "overlap of the watchdogs"),
    deep_low("both-against", "watchdogs that agree against the box"),
    deep_low("both-apart", "watchdogs that disagree"),
    deep_high("here-score", "score of a second look"),
    deep_high("here-overlap", "overlap with a second look"),
    deep_low("here-disagreement", "a sure other place in a second look"),
    deep_low("here-apart", "a sure place off the box in a second look"),
    deep_low("here-distance", "distance of a second look's place"),
    deep_high("here-middle", "score at the box's middle"),
    deep_high("here-inside", "best score at the box"),
    deep_low("here-outside", "best score off the box"),
    deep_low("here-elsewhere", "best score off the box against that at it"),
];

/// Input of this name.
pub fn find(name: &str) -> Option<&'static FusedInput> {
    INPUTS.iter().find(|input| input.name == name)
}
