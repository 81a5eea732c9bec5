//! Detectors that judge a live track, frame by frame.
//!
//! A `Causal` detector defines how one frame changes its memory. From that follows how it judges a whole track, and a
//! live one.

use super::labels::{LossState, changes};
use super::{Detector, DetectorOutput, Facts, Input};
use crate::direction::Direction;
use crate::num::{fixed, readable};
use crate::saved;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Result for one frame from a [`Stream`].
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// Probability that the target is lost in this frame, in `[0, 1]`; NaN for detectors that estimate none.
    pub probability: f64,
    /// True while an alarm is on: from the frame in which it was raised until the recovery is confirmed.
    pub lost: bool,
    /// True if this frame has an alarm.
    pub alarm: bool,
    /// Value that is compared with the threshold; NaN in a frame that could not be judged.
    pub compared: f64,
    /// Features that speak for a loss, the strongest first.
    pub reasons: Vec<String>,
}

/// A track that is judged live. `push` is called once per frame, in order, from the first frame on. The
/// memory does not grow.
pub trait Stream: Send {
    /// Judges the next frame from the values of the detector's signals, in their order. NaN is a value that
    /// is missing in this frame.
    fn push(&mut self, values: &[f64]) -> Judgement;

    /// Saves the state for [`Stream::restore`].
    fn save(&self) -> Vec<u8>;

    /// Restores a state; `false`, and nothing has changed, if the bytes are not from a stream of this detector.
    fn restore(&mut self, saved: &[u8]) -> bool;
}

/// A detector that judges frame by frame.
pub(super) trait Causal: Clone + Send + Sync + 'static {
    /// State between frames, of bounded size.
    type Memory: Default + Serialize + DeserializeOwned + Send;

    /// Properties of the detector.
    fn facts(&self) -> Facts {
        Facts::default()
    }

    /// State before the first frame.
    fn begin(&self) -> Self::Memory {
        Self::Memory::default()
    }

    /// Judges the next frame from the values of its signals, which are finite.
    fn step(&self, memory: &mut Self::Memory, values: &[f64]) -> Step;

    /// True if a saved state may be one of this detector.
    fn is_memory(&self, _memory: &Self::Memory) -> bool {
        true
    }

    /// Reason of an alarm in words; `None` if the score is the reason.
    fn reason(&self, _values: &[f64]) -> Option<String> {
        None
    }
}

/// Score, alarm and forecast of one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    /// Value that is compared with the threshold.
    pub score: f64,
    /// True if the frame is an alarm.
    pub alarm: bool,
    /// Forecast of the signal, NaN in frames without one; `None` for detectors that make no forecasts.
    pub forecast: Option<f64>,
    /// Value that is compared with the threshold, if it is not the score.
    pub alarm_score: Option<f64>,
}

impl Step {
    /// Step with a score and an alarm alone.
    pub fn new(score: f64, alarm: bool) -> Self {
        Self { score, alarm, forecast: None, alarm_score: None }
    }
}

impl<D: Causal> Detector for D {
    fn facts(&self) -> Facts {
        Causal::facts(self)
    }

    fn stream(&self) -> Option<Box<dyn Stream>> {
        let memory = (self.begin(), LossState::default());
        Some(Box::new(Following { detector: self.clone(), memory }))
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let mut memory = self.begin();
        let mut output = step_by_step(input, |values| self.step(&mut memory, values));
        // Others find the changes by the threshold.
        if Causal::facts(self).threshold.is_none() {
            output.changes = Some(changes(&output.alarm));
        }
        output
    }
}

/// Output of a detector that judges a track frame by frame, from the values of its signals in each frame.
pub(super) fn step_by_step(input: &Input<'_>, mut judge: impl FnMut(&[f64]) -> Step) -> DetectorOutput {
    let mut output = DetectorOutput::default();
    let mut values = Vec::new();
    for (t, y) in input.signal.iter().enumerate() {
        values.clear();
        values.push(*y);
        values.extend(input.more.iter().map(|signal| signal[t]));
        let Step { score, alarm, forecast, alarm_score } = judge(&values);
        output.score.push(score);
        output.alarm.push(alarm);
        if let Some(forecast) = forecast {
            output.forecast.get_or_insert_default().push(forecast);
        }
        if let Some(score) = alarm_score {
            output.alarm_score.get_or_insert_default().push(score);
        }
    }
    output
}

/// A detector on a live track. Frames without a value leave its state unchanged.
struct Following<D: Causal> {
    detector: D,
    memory: (D::Memory, LossState),
}

impl<D: Causal> Following<D> {
    /// Reason why a score is an alarm, in words.
    fn reason(&self, values: &[f64], score: f64) -> String {
        if let Some(text) = self.detector.reason(values) {
            return text;
        }
        let facts = Causal::facts(&self.detector);
        let what = if facts.scores_signal { "value" } else { "score" };
        let Some(level) = facts.threshold else {
            return format!("{what} {} is large for this track", fixed(score, 3));
        };
        let is_below = facts.direction == Direction::HigherIsBetter;
        // As many digits as it takes to see on which side it is.
        let is_true = |shown: &String| {
            shown.parse().is_ok_and(|shown: f64| if is_below { shown < level } else { shown > level })
        };
        match (3..9).map(|digits| fixed(score, digits)).find(is_true) {
            None => format!("{what} reaches {}", readable(level)),
            Some(shown) if is_below => format!("{what} {shown} is below {}", readable(level)),
            Some(shown) => format!("{what} {shown} is above {}", readable(level)),
        }
    }
}

impl<D: Causal> Stream for Following<D> {
    fn push(&mut self, values: &[f64]) -> Judgement {
        let Facts { frames_to_recover, signals, gives_probability, .. } = Causal::facts(&self.detector);
        let is_whole = values.len() == signals && values.iter().all(|value| value.is_finite());
        let (memory, state) = &mut self.memory;
        let step = is_whole.then(|| self.detector.step(memory, values));
        if let Some(step) = step {
            state.push(step.alarm, frames_to_recover);
        }
        let lost = state.is_lost(frames_to_recover);
        let alarm = step.filter(|step| step.alarm);
        let reason = |step: Step| self.reason(values, step.score);
        let probable = step.filter(|_| gives_probability);
        Judgement {
            probability: probable.map_or(f64::NAN, |step| step.score),
            lost,
            alarm: alarm.is_some(),
            compared: step.map_or(f64::NAN, |step| step.alarm_score.unwrap_or(step.score)),
            reasons: alarm.map(reason).into_iter().collect(),
        }
    }

    fn save(&self) -> Vec<u8> {
        saved::to_bytes(&self.memory).unwrap_or_default()
    }

    fn restore(&mut self, saved: &[u8]) -> bool {
        let memory = saved::from_bytes::<(D::Memory, LossState)>(saved);
        let mine = memory.filter(|(memory, _)| self.detector.is_memory(memory));
        mine.map(|memory| self.memory = memory).is_some()
    }
}
