//! Inputs and outputs that the tests of many detectors have.

use super::{Detector, DetectorOutput, Input};
use crate::plugin::{Configured, Entry, Plugin, RawParams, read_params};

/// The input of a signal alone.
pub fn alone(signal: &[f64]) -> Input<'_> {
    Input { signal, error: &[], seed: 0, reverse: None, more: &[] }
}

/// The detector of parameters as a file has them.
pub fn built(entry: &Entry<dyn Detector>, text: &str) -> Configured<dyn Detector> {
    entry.build_from_text(text).unwrap_or_else(|e| panic!("{} {text}: {e}", entry.kind))
}

/// The plugin itself of parameters as a file has them.
pub fn plugin<P: Plugin>(text: &str) -> P {
    let params = toml::de::ValueDeserializer::parse(text).unwrap();
    P::new(read_params(RawParams::Toml(params)).unwrap()).unwrap()
}

/// The output of a detector on a signal alone.
pub fn detect(entry: &Entry<dyn Detector>, text: &str, signal: &[f64]) -> DetectorOutput {
    built(entry, text).detect(&alone(signal))
}
