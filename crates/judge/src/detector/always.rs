//! The anchor that alarms in every frame: one run of alarms, which begins in the first frame.
//!
//! ```text
//! alarm at t: always
//! ```
//!
//! `t` is a 0-based frame. It does not read the signal; its score is 1.0 in every frame.

use super::{Detector, DetectorOutput, Input};
use crate::plugin::{Entry, RawParams, read_params, show_params};
use serde::{Deserialize, Serialize};

/// The list's entry.
pub const ENTRY: Entry<dyn Detector> = Entry {
    kind: "always",
    version: 1,
    summary: "an anchor: alarm in every frame",
    example: "{}",
    more: &[],
    build: |raw: RawParams<'_>| Ok(Box::new(Always(read_params(raw)?))),
    schema: || schemars::schema_for!(Params),
};

/// Parameters: none.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {}

/// The detector.
#[derive(Debug, Clone)]
pub struct Always(pub Params);

impl Detector for Always {
    fn params(&self) -> serde_json::Value {
        show_params(&self.0)
    }

    fn needs_signal(&self) -> bool {
        false
    }

    fn frames_to_recover(&self) -> usize {
        1
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let frames = input.signal.len();
        DetectorOutput { score: vec![1.0; frames], alarm: vec![true; frames], ..DetectorOutput::default() }
    }
}
