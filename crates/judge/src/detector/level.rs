//! A fixed level of the signal itself: RAW, RgbHist, RLHist (alarm below) and CovF (alarm above) in
//! Khalid, Cavallaro and Rinner (BMVC 2016), section 4.1.
//!
//! ```text
//! alarm at t when y[t] < below          or          alarm at t when y[t] >= above
//! ```
//!
//! `y` and the level are in the signal's unit; `t` is a 0-based frame. The score is the signal.
//!
//! The paper says "above" and "below" and leaves equality open; `above` includes it as Eq. 9 of the same
//! paper does, and `below` does not, so that the two labels of one level are each other's opposite.

use super::prelude::*;

/// The level detector in the list.
pub const ENTRY: Entry<dyn Detector> =
    Entry::of::<Level>("level", 1, "alarm while the signal is below (or at and above) a fixed level")
        .example("{ below = 0.039 }")
        .more(&["{ above = 0.5 }"]);

/// Parameters; exactly one of `below` and `above` is given.
#[derive(Debug, Clone, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Alarm if the signal is less than this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub below: Option<f64>,
    /// Alarm if the signal is this or more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub above: Option<f64>,
}

/// A fixed level of the signal.
#[derive(Debug, Clone, Copy)]
pub struct Level {
    /// Value of the level.
    pub value: f64,
    /// True if low values are alarms, false if high ones are.
    pub is_least: bool,
}

impl Plugin for Level {
    type Params = Params;

    const RANGES: &'static [Range] = &[Range::of("below"), Range::of("above")];

    fn make(params: Params) -> Result<Self, ParamError> {
        let message = match (params.below, params.above) {
            (Some(value), None) => return Ok(Self { value, is_least: true }),
            (None, Some(value)) => return Ok(Self { value, is_least: false }),
            (Some(_), Some(_)) => "give `below` or `above`, not both",
            (None, None) => "give `below` (low values are alarms) or `above` (high values are alarms)",
        };
        Err(ParamError { message: message.to_string(), key: None, span: None })
    }
}

impl Level {
    /// True if the value is an alarm.
    pub fn is_alarm(self, y: f64) -> bool {
        if self.is_least { y < self.value } else { y >= self.value }
    }

    /// Direction in which values are good.
    pub fn direction(self) -> Direction {
        if self.is_least { Direction::HigherIsBetter } else { Direction::LowerIsBetter }
    }

    /// Name of the parameter that sets the level.
    pub(super) fn key(self) -> &'static str {
        if self.is_least { "below" } else { "above" }
    }
}

impl Causal for Level {
    type Memory = ();

    fn facts(&self) -> Facts {
        let (threshold, direction) = (Some(self.value), self.direction());
        Facts { threshold, direction, scores_signal: true, ..Facts::default() }
    }

    fn step(&self, (): &mut (), values: &[f64]) -> Step {
        Step::new(values[0], self.is_alarm(values[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alarms(text: &str, signal: &[f64]) -> Vec<bool> {
        crate::detector::testing::detect(&ENTRY, text, signal).alarm
    }

    #[test]
    fn the_level_itself_is_above() {
        let signal = [0.5, 0.75, 1.0];
        assert_eq!(alarms("{ below = 0.75 }", &signal), [true, false, false]);
        assert_eq!(alarms("{ above = 0.75 }", &signal), [false, true, true]);
    }

    // By hand: three decimals, or as many as it takes to see on which side the value is.
    #[test]
    fn a_reason_shows_the_difference() {
        let of = |text: &str, value: f64| {
            let mut stream = ENTRY.build_from_text(text).unwrap().stream().unwrap();
            stream.push(&[value]).reasons.remove(0)
        };
        assert_eq!(of("{ above = 0.004 }", 0.0043), "value 0.0043 is above 0.004");
        assert_eq!(of("{ below = 0.039 }", 0.0387), "value 0.0387 is below 0.039");
        assert_eq!(of("{ above = 0.0442 }", 0.0443), "value 0.0443 is above 0.0442");
        assert_eq!(of("{ below = 0.0447 }", 0.0446), "value 0.0446 is below 0.0447");
        assert_eq!(of("{ below = 0.039 }", 0.021), "value 0.021 is below 0.039");
        assert_eq!(of("{ above = 0.039 }", 0.039), "value reaches 0.039");
    }
}
