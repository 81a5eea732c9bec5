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

use super::labels::LossState;
use super::{Detector, DetectorOutput, Input, Judgement, RECOVERY_FRAMES, Reason, Stream};
use crate::direction::Direction;
use crate::num::{fixed, readable};
use crate::plugin::{Entry, ParamError, RawParams, read_params, show_params};
use crate::saved;
use serde::{Deserialize, Serialize};

/// The list's entry.
pub const ENTRY: Entry<dyn Detector> = Entry {
    kind: "level",
    version: 1,
    summary: "alarm while the signal is below (or at and above) a fixed level",
    example: "{ below = 0.039 }",
    build: |raw: RawParams<'_>| Ok(Box::new(Level::new(read_params(raw)?)?)),
    schema: || schemars::schema_for!(Params),
};

/// Parameters; exactly one of the two is given.
#[derive(Debug, Clone, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Alarm when the signal is less than this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub below: Option<f64>,
    /// Alarm when the signal is this or more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub above: Option<f64>,
}

/// The detector.
#[derive(Debug, Clone, Copy)]
pub enum Level {
    /// Low values are alarms.
    Below(f64),
    /// High values are alarms.
    Above(f64),
}

impl Level {
    /// Checks the parameters.
    ///
    /// # Errors
    /// When none or both are given, or the one is not finite.
    pub fn new(params: Params) -> Result<Self, ParamError> {
        let message = match (params.below, params.above) {
            (Some(level), None) if level.is_finite() => return Ok(Self::Below(level)),
            (None, Some(level)) if level.is_finite() => return Ok(Self::Above(level)),
            (Some(level), None) => return Err(ParamError::out_of_range("below", "finite", level)),
            (None, Some(level)) => return Err(ParamError::out_of_range("above", "finite", level)),
            (Some(_), Some(_)) => "give `below` or `above`, not both",
            (None, None) => "give `below` (low values are alarms) or `above` (high values are alarms)",
        };
        Err(ParamError { message: message.to_string(), key: None, span: None })
    }

    /// Whether a value is an alarm.
    pub fn is_alarm(self, y: f64) -> bool {
        match self {
            Self::Below(level) => y < level,
            Self::Above(level) => y >= level,
        }
    }

    /// The level itself.
    pub fn value(self) -> f64 {
        match self {
            Self::Below(level) | Self::Above(level) => level,
        }
    }

    /// Which values are good.
    pub fn direction(self) -> Direction {
        match self {
            Self::Below(_) => Direction::HigherIsBetter,
            Self::Above(_) => Direction::LowerIsBetter,
        }
    }

    /// Another level with alarms on the same side.
    pub fn moved_to(self, level: f64) -> Self {
        match self {
            Self::Below(_) => Self::Below(level),
            Self::Above(_) => Self::Above(level),
        }
    }

    /// The parameter that gives it.
    pub(super) fn key(self) -> &'static str {
        match self {
            Self::Below(_) => "below",
            Self::Above(_) => "above",
        }
    }
}

impl Detector for Level {
    fn params(&self) -> serde_json::Value {
        show_params(&match *self {
            Self::Below(level) => Params { below: Some(level), above: None },
            Self::Above(level) => Params { below: None, above: Some(level) },
        })
    }

    fn threshold(&self) -> Option<f64> {
        Some(self.value())
    }

    fn score_direction(&self) -> Direction {
        self.direction()
    }

    fn scores_signal(&self) -> bool {
        true
    }

    fn stream(&self) -> Option<Box<dyn Stream>> {
        Some(Box::new(LevelStream { level: *self, state: LossState::default() }))
    }

    fn resume(&self, saved: &[u8]) -> Option<Box<dyn Stream>> {
        Some(Box::new(LevelStream { level: *self, state: saved::from_bytes(saved)? }))
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let alarm = input.signal.iter().map(|&y| self.is_alarm(y)).collect();
        DetectorOutput { score: input.signal.to_vec(), alarm, ..DetectorOutput::default() }
    }
}

/// The level on a track that goes on. It knows no probability; a frame without a value changes nothing.
struct LevelStream {
    level: Level,
    state: LossState,
}

impl Stream for LevelStream {
    fn push(&mut self, values: &[f64]) -> Judgement {
        let value = values.first().copied().filter(|v| !v.is_nan());
        let alarm = value.filter(|v| self.level.is_alarm(*v));
        if value.is_some() {
            self.state.push(alarm.is_some(), RECOVERY_FRAMES);
        }
        let reason = |value: f64| {
            let (value, level) = (fixed(value, 3), readable(self.level.value()));
            let text = format!("value {value} is {} {level}", self.level.key());
            Reason { text, weight: 1.0 }
        };
        Judgement {
            probability: f64::NAN,
            lost: self.state.is_lost(RECOVERY_FRAMES),
            raised: alarm.is_some(),
            reasons: alarm.map(reason).into_iter().collect(),
        }
    }

    fn save(&self) -> Vec<u8> {
        saved::to_bytes(&self.state).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn alarms(text: &str, signal: &[f64]) -> Vec<bool> {
        ENTRY
            .build_from_text(text)
            .unwrap()
            .detect(&Input { signal, error: &[], seed: 0, reverse: None, more: &[] })
            .alarm
    }

    #[test]
    fn the_level_itself_is_above() {
        let signal = [0.5, 0.75, 1.0];
        assert_eq!(alarms("{ below = 0.75 }", &signal), [true, false, false]);
        assert_eq!(alarms("{ above = 0.75 }", &signal), [false, true, true]);
    }

    proptest! {
        #[test]
        fn a_stream_says_what_a_whole_track_does(
            signal in proptest::collection::vec(0.0..1.0_f64, 0..60), cut in 0_usize..60, low in 0.0..0.3_f64,
        ) {
            for level in [Level::Below(low), Level::Above(1.0 - low)] {
                let alarm = level.detect(&Input { signal: &signal, error: &[], seed: 0, reverse: None, more: &[] });
                let want = super::super::lost(&alarm.alarm, level.frames_to_recover());
                let mut stream = level.stream().unwrap();
                for (t, y) in signal.iter().enumerate() {
                    if t == cut {
                        stream = level.resume(&stream.save()).unwrap();
                    }
                    if t % 7 == 3 {
                        let before = t > 0 && want[t - 1];
                        prop_assert_eq!(stream.push(&[f64::NAN]).lost, before);
                    }
                    let said = stream.push(&[*y]);
                    prop_assert_eq!((said.lost, said.reasons.len()), (want[t], usize::from(alarm.alarm[t])));
                }
            }
        }
    }

    #[test]
    fn exactly_one_finite_level() {
        for text in ["{}", "{ below = 1.0, above = 2.0 }", "{ below = nan }", "{ above = inf }"] {
            assert!(ENTRY.build_from_text(text).is_err(), "{text}");
        }
    }
}
