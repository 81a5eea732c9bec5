//! Outputs of detectors: the cache in memory, and their form in the store.

use serde::{Deserialize, Deserializer, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use trackfail_methods::detector::{DetectorOutput, Quality};

/// Most bytes of outputs in memory. Further outputs are read from the store when needed.
const MAX_BYTES_IN_MEMORY: usize = 128 << 20;

/// Bytes of outputs in memory at present.
#[derive(Debug, Default)]
pub struct DetectorOutputCache(AtomicUsize);

impl DetectorOutputCache {
    /// Keeps the output in memory; `None` if there is no room.
    pub fn keep(&self, output: DetectorOutput) -> Option<Arc<DetectorOutput>> {
        let more = [output.forecast.is_some(), output.quality.is_some(), output.alarm_score.is_some()];
        let bytes = output.score.len() * (9 + 8 * more.into_iter().filter(|has| *has).count());
        let has_room = self.0.fetch_add(bytes, Ordering::Relaxed) + bytes <= MAX_BYTES_IN_MEMORY;
        has_room.then(|| Arc::new(output))
    }
}

/// Stored form of an output. The score is left out if it equals the signal.
#[derive(Serialize, Deserialize)]
pub struct StoredDetectorOutput {
    score: Option<Vec<f64>>,
    alarm: Vec<bool>,
    forecast: Option<Vec<f64>>,
    changes: Option<Vec<i32>>,
    quality: Option<Quality>,
    /// Last field, since older records end before it.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "if_there")]
    alarm_score: Option<Vec<f64>>,
}

/// Reads a last field that may be absent.
fn if_there<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<f64>>, D::Error> {
    Ok(Option::deserialize(deserializer).unwrap_or_default())
}

impl StoredDetectorOutput {
    /// Converts an output to its stored form. The score is dropped if it equals `signal`.
    pub fn new(output: &DetectorOutput, signal: &[f64]) -> Self {
        let bits = |v: &[f64]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let score = (bits(&output.score) != bits(signal)).then(|| output.score.clone());
        let DetectorOutput { alarm, forecast, changes, quality, alarm_score, .. } = output.clone();
        Self { score, alarm, forecast, changes, quality, alarm_score }
    }

    /// Restores the output on a signal; `None` if their lengths differ.
    pub fn on(self, signal: &[f64]) -> Option<DetectorOutput> {
        let Self { score, alarm, forecast, changes, quality, alarm_score } = self;
        let score = score.unwrap_or_else(|| signal.to_vec());
        let lengths = [
            Some(score.len()),
            Some(alarm.len()),
            forecast.as_ref().map(Vec::len),
            changes.as_ref().map(Vec::len),
            quality.as_ref().map(|quality| quality.condition.len()),
            alarm_score.as_ref().map(Vec::len),
        ];
        let whole = lengths.into_iter().flatten().all(|length| length == signal.len());
        let output = DetectorOutput { score, alarm_score, alarm, forecast, changes, quality, failure: None };
        whole.then_some(output)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIGNAL: [f64; 3] = [0.5, 0.25, 1.0];

    fn output(alarm_score: Option<Vec<f64>>) -> DetectorOutput {
        let alarm = vec![false, true, true];
        DetectorOutput { score: vec![0.1, 0.9, 0.8], alarm_score, alarm, ..DetectorOutput::default() }
    }

    fn stored(output: &DetectorOutput) -> Vec<u8> {
        postcard::to_stdvec(&StoredDetectorOutput::new(output, &SIGNAL)).unwrap()
    }

    fn read(bytes: &[u8]) -> Option<DetectorOutput> {
        postcard::from_bytes::<StoredDetectorOutput>(bytes).unwrap().on(&SIGNAL)
    }

    #[test]
    fn outputs_are_read_as_they_were_stored() {
        for alarm_score in [None, Some(vec![0.1, 0.9, 0.0008])] {
            let output = output(alarm_score);
            assert_eq!(read(&stored(&output)), Some(output));
        }
    }

    // The form of outputs of detectors without an alarm score is that of earlier versions.
    #[test]
    fn an_output_without_an_alarm_score_has_nothing_in_its_place() {
        let (without, with) = (stored(&output(None)), stored(&output(Some(vec![]))));
        assert!(with.starts_with(&without) && with.len() > without.len());
    }
}
