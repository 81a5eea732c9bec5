//! `hysteresis`: two levels of the signal, one that loses the target and one that finds it again, as in the
//! long-term version of SiamRPN++ (pysot, `siamrpnlt_tracker.py`).
//!
//! ```text
//! not in an alarm at t - 1:   alarm at t when y[t] < below     or     when y[t] >= above
//! in an alarm at t - 1:       alarm at t when y[t] < found     or     when y[t] >= found
//! ```
//!
//! `y` and the levels are in the signal's unit; `t` is a 0-based frame, and before frame 0 there is no alarm.
//! The left column is for signals where high values are good (`below`, with `found` at or above it), the right one
//! for the others (`above`, with `found` at or below it). The score is the signal.
//!
//! SiamRPN++ has `below = 0.85, found = 0.998` for its own confidence. It is found only above 0.998; here a value equal
//! to `found` is found too, so that `found = below` (or `above`) is the detector `level`.

use super::level::{self, Level};
use super::stream::{self, Causal, Step};
use super::{Detector, DetectorOutput, Input, Stream};
use crate::direction::Direction;
use crate::plugin::{Entry, ParamError, RawParams, read_params, show_params};
use serde::{Deserialize, Serialize};

/// The list's entry.
pub const ENTRY: Entry<dyn Detector> = Entry {
    kind: "hysteresis",
    version: 1,
    summary: "alarm from a level of the signal that loses the target to another one that finds it again",
    example: "{ below = 0.85, found = 0.998 }",
    more: &["{ above = 0.5, found = 0.2 }"],
    build: |raw: RawParams<'_>| Ok(Box::new(Hysteresis::new(read_params(raw)?)?)),
    schema: || schemars::schema_for!(Params),
};

/// Parameters; exactly one of `below` and `above` is given.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// An alarm begins when the signal is less than this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub below: Option<f64>,
    /// An alarm begins when the signal is this or more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub above: Option<f64>,
    /// The alarm ends when the signal is this or more (with `below`), or less than this (with `above`).
    pub found: f64,
}

/// The detector.
#[derive(Debug, Clone)]
pub struct Hysteresis {
    params: Params,
    lost: Level,
    found: Level,
}

impl Hysteresis {
    /// Checks the parameters.
    ///
    /// # Errors
    /// When none or both of `below` and `above` are given, one is not finite, or `found` is on their wrong side.
    pub fn new(params: Params) -> Result<Self, ParamError> {
        let Params { below, above, found } = params;
        let lost = Level::new(level::Params { below, above })?;
        let (ordered, rule) = match lost {
            Level::Below(level) => (found >= level, "finite and at least `below`"),
            Level::Above(level) => (found <= level, "finite and at most `above`"),
        };
        if !(found.is_finite() && ordered) {
            return Err(ParamError::out_of_range("found", rule, found));
        }
        Ok(Self { params, lost, found: lost.moved_to(found) })
    }
}

impl Detector for Hysteresis {
    fn params(&self) -> serde_json::Value {
        show_params(&self.params)
    }

    fn threshold(&self) -> Option<f64> {
        Some(self.lost.value())
    }

    fn score_direction(&self) -> Direction {
        self.lost.direction()
    }

    fn scores_signal(&self) -> bool {
        true
    }

    fn frames_to_recover(&self) -> usize {
        1
    }

    fn stream(&self) -> Option<Box<dyn Stream>> {
        stream::follow(self)
    }

    fn resume(&self, saved: &[u8]) -> Option<Box<dyn Stream>> {
        stream::go_on(self, saved)
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        stream::whole(self, input)
    }
}

impl Causal for Hysteresis {
    /// Whether an alarm is on.
    type Memory = bool;

    fn begin(&self) -> bool {
        false
    }

    fn step(&self, alarm: &mut bool, values: &[f64]) -> Step {
        let level = if *alarm { self.found } else { self.lost };
        *alarm = level.is_alarm(values[0]);
        Step::new(values[0], *alarm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn alarms(entry: &Entry<dyn Detector>, text: &str, signal: &[f64]) -> Vec<bool> {
        let detector = entry.build_from_text(text).unwrap();
        detector.detect(&Input { signal, error: &[], seed: 0, reverse: None, more: &[] }).alarm
    }

    // By hand: .5 loses, .6 and .7 are between the levels, .75 finds; .7 then is still found.
    #[test]
    fn between_the_levels_the_label_stays() {
        let signal = [0.7, 0.5, 0.6, 0.7, 0.75, 0.7, 0.6, 0.59];
        let want = [false, true, true, true, false, false, false, true];
        assert_eq!(alarms(&ENTRY, "{ below = 0.6, found = 0.75 }", &signal), want);
        // High values are bad: .7 and .75 lose, only a value below .6 finds again.
        let want = [true, false, false, true, true, true, true, false];
        assert_eq!(alarms(&ENTRY, "{ above = 0.7, found = 0.6 }", &signal), want);
    }

    #[test]
    fn levels_in_the_wrong_order_are_refused() {
        let key = |text: &str| ENTRY.build_from_text(text).err().map(|e| e.key);
        for text in
            ["{ below = 0.6, found = 0.5 }", "{ above = 0.6, found = 0.7 }", "{ below = 0.6, found = nan }"]
        {
            assert_eq!(key(text), Some(Some("found")), "{text}");
        }
        assert_eq!(key("{ found = 0.5 }"), Some(None));
        assert_eq!(key("{ below = 0.1, above = 0.9, found = 0.5 }"), Some(None));
        assert_eq!(key("{ above = inf, found = 0.5 }"), Some(Some("above")));
    }

    proptest! {
        #[test]
        fn one_level_twice_is_the_detector_level(
            signal in prop::collection::vec(0.0_f64..1.0, 0..64),
            level in 0.0_f64..1.0,
        ) {
            for side in ["below", "above"] {
                let twice = alarms(&ENTRY, &format!("{{ {side} = {level:?}, found = {level:?} }}"), &signal);
                let once = alarms(&level::ENTRY, &format!("{{ {side} = {level:?} }}"), &signal);
                prop_assert_eq!(twice, once);
            }
        }

        #[test]
        fn a_gap_between_the_levels_only_adds_alarms(
            signal in prop::collection::vec(0.0_f64..1.0, 0..64),
            one in 0.0_f64..1.0,
            two in 0.0_f64..1.0,
        ) {
            let (low, high) = (one.min(two), one.max(two));
            for (side, lost, found) in [("below", low, high), ("above", high, low)] {
                let wide = alarms(&ENTRY, &format!("{{ {side} = {lost:?}, found = {found:?} }}"), &signal);
                let once = alarms(&level::ENTRY, &format!("{{ {side} = {lost:?} }}"), &signal);
                prop_assert!(once.iter().zip(&wide).all(|(once, wide)| *wide || !*once));
            }
        }
    }
}
