//! The learned model of the fused detector, and a track that is judged by it.
//!
//! ```text
//! d[j,t] = (f[j,t] - center[j]) / scale[j], cut at 6; 0 for a feature without a value
//! s[t] = b + sum_j w[j] d[j,t]
//! p[t] = 1 / (1 + exp(-(a s[t] + c)))                          the probability of a loss
//! n[t] = 1 while each watchdog has touched the tracker's box within the last `window` frames, else .001
//! a[t] = n[t] p[t]                                             compared with the threshold
//! ```

use super::features::InputHistory;
use super::inputs::FusedInput;
use super::logistic::sigmoid;
use crate::detector::labels::LossState;
use crate::detector::{Judgement, Reason, Stream, threshold_within};
use crate::num::fixed;
use crate::saved;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Standardized features are cut here, in both directions.
const MAX_DEVIATION: f64 = 6.0;
/// Factor of what is no news.
const OLD: f64 = 0.001;
/// Most reasons that are given for a frame.
const MAX_REASONS: usize = 3;

/// A learned model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FusedModel {
    /// Names of the inputs, in the order of the signals.
    pub inputs: Vec<String>,
    /// The features of each input, in the order of the inputs and of the list in `fused/features.rs`.
    pub features: Vec<Weight>,
    /// b.
    pub bias: f64,
    /// a and c, which make the score a probability.
    pub calibration: (f64, f64),
    /// Budgets of false alarms per 1000 good frames, ascending, each with the lowest probability at which frames that
    /// the model was not made on kept to it.
    pub thresholds: Vec<(f64, f64)>,
}

/// Mean and deviation that a feature is compared with, and its weight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weight {
    /// Mean of the feature in training.
    pub center: f64,
    /// Its standard deviation.
    pub scale: f64,
    /// w.
    pub weight: f64,
}

impl Weight {
    /// The standardized feature, cut; 0 for one without a value.
    pub fn deviation(&self, value: f64) -> f64 {
        let deviation = (value - self.center) / self.scale;
        if deviation.is_finite() { deviation.clamp(-MAX_DEVIATION, MAX_DEVIATION) } else { 0.0 }
    }
}

/// Frames since each watchdog touched the tracker's box.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct News {
    apart: Vec<u32>,
}

impl News {
    /// n of the next frame, from the values of the inputs. A missing value changes nothing.
    pub fn push(&mut self, inputs: &[&'static FusedInput], values: &[f64], window: u32) -> f64 {
        let overlaps = inputs.iter().zip(values).filter(|(input, _)| input.is_watchdog_overlap);
        let overlaps: Vec<f64> = overlaps.map(|(_, overlap)| *overlap).collect();
        self.apart.resize(overlaps.len(), 0);
        for (apart, overlap) in self.apart.iter_mut().zip(overlaps) {
            if overlap > 0.0 {
                *apart = 0;
            } else if overlap <= 0.0 {
                *apart = apart.saturating_add(1);
            }
        }
        if self.apart.iter().all(|apart| *apart <= window) { 1.0 } else { OLD }
    }
}

/// The score before calibration.
pub fn score(bias: f64, weights: &[Weight], features: &[f64]) -> f64 {
    bias + part(weights, features)
}

/// The part of the score that some features add.
fn part(weights: &[Weight], features: &[f64]) -> f64 {
    weights.iter().zip(features).map(|(feature, value)| feature.weight * feature.deviation(*value)).sum()
}

/// The probability that a score stands for.
pub fn probability((a, c): (f64, f64), score: f64) -> f64 {
    sigmoid(a * score + c)
}

impl FusedModel {
    /// Whether it is a model of these inputs, and complete.
    pub fn fits(&self, inputs: &[&'static FusedInput]) -> bool {
        let features: usize = inputs.iter().map(|input| input.features).sum();
        let is_complete = self.features.len() == features && !self.thresholds.is_empty();
        self.inputs.iter().eq(inputs.iter().map(|input| input.name)) && is_complete
    }

    /// The largest budget of the model that is within `budget`, with its probability; of those that are all larger, the
    /// smallest.
    pub fn threshold(&self, budget: f64) -> f64 {
        threshold_within(&self.thresholds, budget).unwrap_or(1.0)
    }
}

/// The memory of a track.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Memory {
    histories: Vec<InputHistory>,
    news: News,
    state: LossState,
}

/// How a model is used.
#[derive(Debug, Clone, Copy)]
pub struct Use {
    /// Most false alarms per 1000 good frames.
    pub budget: f64,
    /// Frames in a row below the threshold that confirm a recovery.
    pub confirm: usize,
    /// Frames for which a disagreement is news.
    pub window: u32,
}

/// A track that is judged by a model.
pub struct FusedStream {
    model: Arc<FusedModel>,
    inputs: Vec<&'static FusedInput>,
    threshold: f64,
    how: Use,
    memory: Memory,
}

/// Judgement of a frame, but for the reasons.
pub struct FusedStep {
    /// The parts of the score that the inputs add.
    parts: Vec<f64>,
    /// The probability of a loss.
    pub probability: f64,
    /// Number that is compared with the threshold.
    pub compared: f64,
    /// Whether an alarm is on.
    pub alarm: bool,
}

impl FusedStream {
    /// A track before its first frame.
    pub fn new(model: Arc<FusedModel>, inputs: Vec<&'static FusedInput>, how: Use) -> Self {
        let histories = vec![InputHistory::default(); inputs.len()];
        let memory = Memory { histories, news: News::default(), state: LossState::default() };
        Self { threshold: model.threshold(how.budget), model, inputs, how, memory }
    }

    /// The track as it was when it was saved; `None` if these bytes are of another detector.
    pub fn resumed(self, saved: &[u8]) -> Option<Self> {
        let memory: Memory = saved::from_bytes(saved)?;
        (memory.histories.len() == self.inputs.len()).then_some(Self { memory, ..self })
    }

    /// The next frame.
    pub fn step(&mut self, values: &[f64]) -> FusedStep {
        let mut values = values.to_vec();
        values.resize(self.inputs.len(), f64::NAN);
        let (mut weights, mut parts) = (&self.model.features[..], Vec::with_capacity(values.len()));
        for ((input, history), value) in self.inputs.iter().zip(&mut self.memory.histories).zip(&values) {
            let features: Vec<f64> = history.features(input, *value).collect();
            let (mine, others) = weights.split_at(features.len());
            parts.push(part(mine, &features));
            weights = others;
        }
        let score = self.model.bias + parts.iter().sum::<f64>();
        let probability = probability(self.model.calibration, score);
        let compared = probability * self.memory.news.push(&self.inputs, &values, self.how.window);
        // Raised by news, held by the state.
        let is_on = self.memory.state.is_lost(self.how.confirm);
        let alarm = compared >= self.threshold || (is_on && probability >= self.threshold);
        FusedStep { parts, probability, compared, alarm: self.memory.state.push(alarm, self.how.confirm) }
    }
}

impl Stream for FusedStream {
    fn push(&mut self, values: &[f64]) -> Judgement {
        let usual: Vec<Option<f64>> = self
            .inputs
            .iter()
            .zip(&self.memory.histories)
            .map(|(input, history)| history.usual(input))
            .collect();
        let FusedStep { parts, probability, compared, alarm: lost } = self.step(values);
        let mut loudest: Vec<usize> = (0..parts.len()).filter(|k| parts[*k] > 0.0).collect();
        loudest.sort_by(|a, b| parts[*b].total_cmp(&parts[*a]));
        let reason = |k: usize| {
            let (words, value) = (self.inputs[k].words, values.get(k).copied().unwrap_or(f64::NAN));
            let shown = fixed(value, 3);
            let text = match usual[k].map(|usual| fixed(usual, 3)) {
                _ if !value.is_finite() => format!("{words}: missing"),
                // What is as always explains nothing: it speaks for a loss by the frames before.
                Some(usual) if usual == shown => return None,
                Some(usual) => format!("{words}: {shown}, usually {usual}"),
                None => format!("{words}: {shown}"),
            };
            Some(Reason { text, weight: self.model.calibration.0 * parts[k] })
        };
        let reasons = loudest.into_iter().filter_map(reason).take(MAX_REASONS).collect();
        Judgement { probability, lost, raised: compared >= self.threshold, reasons }
    }

    fn save(&self) -> Vec<u8> {
        saved::to_bytes(&self.memory).unwrap_or_default()
    }
}
