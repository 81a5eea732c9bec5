//! Learned model of the fused detector, and the stream that applies it to a track.
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
use super::{Fused, Params};
use crate::detector::labels::LossState;
use crate::detector::{Judgement, Stream, threshold_within};
use crate::num::fixed;
use crate::saved;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Bound at which standardized features are clipped, in both directions.
const MAX_DEVIATION: f64 = 6.0;
/// Factor of the probability if a watchdog has not overlapped the tracker's box for longer than the window,
/// so that the disagreement is old news.
const OLD: f64 = 0.001;
/// Most reasons given for a frame.
const MAX_REASONS: usize = 3;

/// A learned model of the fused detector.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FusedModel {
    /// Names of the inputs, in the order of the signals.
    pub inputs: Vec<String>,
    /// Weights of all features, in the order of the inputs and of the list in `fused/features.rs`.
    pub features: Vec<Weight>,
    /// Bias b of the score.
    pub bias: f64,
    /// Calibration a and c, which converts the score to a probability.
    pub calibration: (f64, f64),
    /// Budgets of false alarms per 1000 good frames, ascending, each with the lowest probability at which
    /// frames outside of the training kept the budget.
    pub thresholds: Vec<(f64, f64)>,
}

/// Mean and deviation of a feature, and its weight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weight {
    /// Mean of the feature in training.
    pub center: f64,
    /// Standard deviation of the feature in training.
    pub scale: f64,
    /// Weight w of the standardized feature.
    pub weight: f64,
}

impl Weight {
    /// Standardized feature, clipped; 0 for a feature without a value.
    pub fn deviation(&self, value: f64) -> f64 {
        let deviation = (value - self.center) / self.scale;
        if deviation.is_finite() { deviation.clamp(-MAX_DEVIATION, MAX_DEVIATION) } else { 0.0 }
    }
}

/// Number of frames since each watchdog overlapped the tracker's box.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct News {
    apart: Vec<u32>,
}

impl News {
    /// Factor n of the next frame, from the values of the inputs. A missing value leaves the state unchanged.
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

/// Score before calibration.
pub fn score(bias: f64, weights: &[Weight], features: &[f64]) -> f64 {
    bias + part(weights, features)
}

/// Contribution of some features to the score.
fn part(weights: &[Weight], features: &[f64]) -> f64 {
    weights.iter().zip(features).map(|(feature, value)| feature.weight * feature.deviation(*value)).sum()
}

/// Probability for a score, by the calibration `(a, c)`.
pub fn probability((a, c): (f64, f64), score: f64) -> f64 {
    sigmoid(a * score + c)
}

impl FusedModel {
    /// True if the model is complete, has these inputs and gives a probability for all values.
    pub fn fits(&self, inputs: &[&'static FusedInput]) -> bool {
        let features: usize = inputs.iter().map(|input| input.features).sum();
        let is_complete = self.features.len() == features && !self.thresholds.is_empty();
        self.inputs.iter().eq(inputs.iter().map(|input| input.name)) && is_complete && self.is_bounded()
    }

    /// True if the calibrated score is finite for the largest deviations.
    fn is_bounded(&self) -> bool {
        let weights: f64 = self.features.iter().map(|feature| feature.weight.abs()).sum();
        let (a, c) = self.calibration;
        (a.abs() * (self.bias.abs() + MAX_DEVIATION * weights) + c.abs()).is_finite()
    }

    /// Threshold on the probability for the largest budget of the model up to `budget`, or for the smallest
    /// one if all are larger.
    pub fn threshold(&self, budget: f64) -> f64 {
        threshold_within(&self.thresholds, budget).unwrap_or(1.0)
    }
}

/// State of the stream between frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Memory {
    histories: Vec<InputHistory>,
    news: News,
    state: LossState,
}

/// A track that is judged by a model, frame by frame.
pub struct FusedStream {
    fused: Fused,
    model: Arc<FusedModel>,
    threshold: f64,
    memory: Memory,
}

impl FusedStream {
    /// Stream before the first frame of a track.
    pub fn new(fused: Fused, model: Arc<FusedModel>) -> Self {
        let histories = vec![InputHistory::default(); fused.inputs.len()];
        let memory = Memory { histories, news: News::default(), state: LossState::default() };
        Self { threshold: model.threshold(fused.params.budget), fused, model, memory }
    }

    /// Judges the next frame without reasons, given the values of the signals. Also returns the contribution of each input to
    /// the score.
    pub fn step(&mut self, values: &[f64]) -> (Judgement, Vec<f64>) {
        let Fused { inputs, params: Params { confirm, window, .. }, .. } = &self.fused;
        let mut values = values.to_vec();
        values.resize(inputs.len(), f64::NAN);
        let (mut weights, mut parts) = (&self.model.features[..], Vec::with_capacity(values.len()));
        for ((input, history), value) in inputs.iter().zip(&mut self.memory.histories).zip(&values) {
            let features: Vec<f64> = history.features(input, *value).collect();
            let (mine, others) = weights.split_at(features.len());
            parts.push(part(mine, &features));
            weights = others;
        }
        let score = self.model.bias + parts.iter().sum::<f64>();
        let probability = probability(self.model.calibration, score);
        let compared = probability * self.memory.news.push(inputs, &values, *window);
        // Raised by news, held by the state.
        let is_on = self.memory.state.is_lost(*confirm);
        let alarm = compared >= self.threshold || (is_on && probability >= self.threshold);
        let lost = self.memory.state.push(alarm, *confirm);
        (Judgement { probability, lost, alarm: lost, compared, reasons: Vec::new() }, parts)
    }
}

impl Stream for FusedStream {
    fn push(&mut self, values: &[f64]) -> Judgement {
        let histories = self.fused.inputs.iter().zip(&self.memory.histories);
        let usual: Vec<Option<f64>> = histories.map(|(input, history)| history.usual(input)).collect();
        let (judged, parts) = self.step(values);
        let mut loudest: Vec<usize> = (0..parts.len()).filter(|k| parts[*k] > 0.0).collect();
        loudest.sort_by(|a, b| parts[*b].total_cmp(&parts[*a]));
        let reason = |k: usize| {
            let (words, value) = (self.fused.inputs[k].words, values.get(k).copied().unwrap_or(f64::NAN));
            let shown = fixed(value, 3);
            match usual[k].map(|usual| fixed(usual, 3)) {
                _ if !value.is_finite() => Some(format!("{words}: missing")),
                // What is as always explains nothing: it speaks for a loss by the frames before.
                Some(usual) if usual == shown => None,
                Some(usual) => Some(format!("{words}: {shown}, usually {usual}")),
                None => Some(format!("{words}: {shown}")),
            }
        };
        let reasons = loudest.into_iter().filter_map(reason).take(MAX_REASONS).collect();
        Judgement { reasons, ..judged }
    }

    fn save(&self) -> Vec<u8> {
        saved::to_bytes(&self.memory).unwrap_or_default()
    }

    fn restore(&mut self, saved: &[u8]) -> bool {
        let memory = saved::from_bytes::<Memory>(saved);
        let mine = memory.filter(|memory| memory.histories.len() == self.fused.inputs.len());
        mine.map(|memory| self.memory = memory).is_some()
    }
}
