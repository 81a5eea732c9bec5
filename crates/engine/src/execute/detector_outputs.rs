//! Outputs of detectors, in memory or in the store.

use crate::store::address::{Address, Recipe};
use serde::{Deserialize, Deserializer, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use trackfail_methods::detector::{DetectorOutput, Quality};

/// Bytes of outputs that are kept in memory; further ones are read from the store when they are needed.
const MAX_BYTES_IN_MEMORY: usize = 128 << 20;

/// Counts the outputs in memory.
#[derive(Debug, Default)]
pub struct DetectorOutputCache {
    bytes: AtomicUsize,
}

impl DetectorOutputCache {
    /// The output itself while there is room, else its address. `recipe` is that of its record in the store.
    pub fn insert(&self, recipe: &Recipe, output: DetectorOutput) -> CachedDetectorOutput {
        let extra = [output.forecast.is_some(), output.quality.is_some(), output.alarm_score.is_some()];
        let extra = 8 * extra.into_iter().filter(|has| *has).count();
        let bytes = output.score.len() * (9 + extra);
        if self.bytes.fetch_add(bytes, Ordering::Relaxed) + bytes <= MAX_BYTES_IN_MEMORY {
            CachedDetectorOutput::Here(Arc::new(output))
        } else {
            CachedDetectorOutput::Stored(recipe.address())
        }
    }
}

/// An output in memory, or its address in the store.
#[derive(Debug, Clone)]
pub enum CachedDetectorOutput {
    /// In memory.
    Here(Arc<DetectorOutput>),
    /// In the store.
    Stored(Address),
}

/// An output as it is stored: without the score where that is the signal itself.
#[derive(Serialize, Deserialize)]
pub struct StoredDetectorOutput {
    score: Option<Vec<f64>>,
    alarm: Vec<bool>,
    forecast: Option<Vec<f64>>,
    changes: Option<Vec<i32>>,
    quality: Option<Quality>,
    /// The last field: records of detectors without it end before.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "if_there")]
    alarm_score: Option<Vec<f64>>,
}

/// A last field that may be missing.
fn if_there<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<f64>>, D::Error> {
    Ok(Some(deserializer).and_then(|deserializer| Vec::deserialize(deserializer).ok()))
}

impl StoredDetectorOutput {
    /// The stored form of the output on `signal`.
    pub fn new(output: &DetectorOutput, signal: &[f64]) -> Self {
        let bits = |v: &[f64]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let score = (bits(&output.score) != bits(signal)).then(|| output.score.clone());
        let DetectorOutput { alarm, forecast, changes, quality, alarm_score, .. } = output.clone();
        Self { score, alarm, forecast, changes, quality, alarm_score }
    }

    /// The output on a signal; `None` if their lengths differ.
    pub fn on(self, signal: &[f64]) -> Option<DetectorOutput> {
        let score = self.score.unwrap_or_else(|| signal.to_vec());
        let whole = score.len() == signal.len()
            && self.alarm.len() == signal.len()
            && self.forecast.as_ref().is_none_or(|f| f.len() == signal.len())
            && self.changes.as_ref().is_none_or(|c| c.len() == signal.len())
            && self.quality.as_ref().is_none_or(|q| q.condition.len() == signal.len())
            && self.alarm_score.as_ref().is_none_or(|a| a.len() == signal.len());
        let Self { alarm, forecast, changes, quality, alarm_score, .. } = self;
        whole.then_some(DetectorOutput {
            score,
            alarm_score,
            alarm,
            forecast,
            changes,
            quality,
            failure: None,
        })
    }
}
