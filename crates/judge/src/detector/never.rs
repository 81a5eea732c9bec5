//! The anchor that never alarms: its recall is 0 and it has no false positive.
//!
//! ```text
//! alarm at t: never
//! ```
//!
//! `t` is a 0-based frame. It does not read the signal; its score is 0.0 in every frame.

use super::{Detector, DetectorOutput, Input};
use crate::plugin::{Entry, RawParams, read_params, show_params};
use serde::{Deserialize, Serialize};

/// The list's entry.
pub const ENTRY: Entry<dyn Detector> = Entry {
    kind: "never",
    version: 1,
    summary: "an anchor: no alarm in any frame",
    example: "{}",
    more: &[],
    build: |raw: RawParams<'_>| Ok(Box::new(Never(read_params(raw)?))),
    schema: || schemars::schema_for!(Params),
};

/// Parameters: none.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {}

/// The detector.
#[derive(Debug, Clone)]
pub struct Never(pub Params);

impl Detector for Never {
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
        DetectorOutput { score: vec![0.0; frames], alarm: vec![false; frames], ..DetectorOutput::default() }
    }
}
