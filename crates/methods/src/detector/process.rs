//! `process`: a detector in an external program, in any language.
//!
//! The program is named in `plugins.toml`, under `[detector.my-detector]`, with the keys of a
//! [signal](crate::signal::process) and with `deterministic = true` if its answers do not depend on the seed
//! (default false). The protocol is the one of signals, with other messages. Ground truth is never sent.
//!
//! ```text
//! {"meta": {"protocol": 1, "program": "my-detector", "role": "detector", "frames": 87, "params": {}}}
//! {"index": 0, "value": 0.25}
//! <- {"score": 0.3, "label": 0}
//! ```
//!
//! `index` is a 0-based frame, `value` the signal there, and `more` the list of the values of the other
//! signals if `signals` is 2 or more. `score` is any finite number, and a high score means a failure; `label`
//! is 1 in frames that the detector calls inconsistent (the tracker has failed), else 0. A message is sent
//! only after the answer to the message before it, so that a label cannot use later frames. An answer may
//! have the `index` of its message, which is checked. The environment has `TRACKFAIL_SEED`.
//!
//! If a program crashes, hangs, sends something else or ends with an exit status other than 0, it has no
//! labels: the cell fails, and the reason has the index of the frame and the last lines of its stderr.

use super::{Detector, DetectorOutput, Facts, Input};
use crate::tracker::process::{
    Bind, Handed, JsonPeer, Named, Process, Program, Programs, Role, Track, bind, refused,
};
use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use trackfail_core::plugin::{Configured, Entry, ParamError, Range};
use trackfail_dataset::file_digest;

/// `process` in the list of detectors.
pub const ENTRY: Entry<dyn Detector> =
    Entry::of::<Process<Params>>("process", 1, "a program that plugins.toml names, over lines of JSON")
        .example(r#"{ program = "my-detector", signals = 1, params = {} }"#);

/// Parameters of a detector in an external program.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Name of the program in `plugins.toml`.
    pub program: String,
    /// Number of signals that the program reads, 1 to 64.
    #[serde(default = "one")]
    pub signals: usize,
    /// Parameters that are handed over to the program.
    #[serde(default)]
    pub params: Handed,
}

fn one() -> usize {
    1
}

impl Named for Params {
    const ROLE: Role = Role::Detector;

    const RANGES: &'static [Range] = &[Range::within("signals", 1.0, 64.0)];

    fn program(&self) -> &str {
        &self.program
    }

    /// Names and digests of the files of the program; empty if it has none.
    fn facts(program: &Program) -> Result<Vec<(&'static str, Value)>, ParamError> {
        let file = |path: &std::path::PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let digest = file_digest(path).map_err(|e| refused(e.to_string()))?;
            Ok(format!("{name} {digest}"))
        };
        let files = program.digest.iter().map(file).collect::<Result<Vec<String>, ParamError>>()?;
        Ok(if files.is_empty() { Vec::new() } else { vec![("files", files.into())] })
    }
}

impl Params {
    /// The labels of all frames, or the frame and the reason of a fault.
    fn run(&self, program: &Program, input: &Input<'_>) -> Result<DetectorOutput, (usize, String)> {
        let frames = input.signal.len();
        let track = Track { frames, size: None, params: &self.params };
        let seed = [("TRACKFAIL_SEED", input.seed.to_string())];
        let mut peer = JsonPeer::start(program, &seed, None, &track).map_err(|fault| (0, fault))?;
        let mut output = DetectorOutput::default();
        for (index, value) in input.signal.iter().enumerate() {
            let more = input.more.iter().filter_map(|signal| signal.get(index).copied()).collect();
            let message = FrameLine { index, value: *value, more };
            let answer = peer.ask(index, &message, ANSWER, |answer: &Answer| answer.index);
            let answer = answer.map_err(|fault| (index, fault))?;
            output.score.push(answer.score);
            output.alarm.push(answer.label);
        }
        peer.finish().map_err(|fault| (frames.saturating_sub(1), fault))?;
        Ok(output)
    }
}

impl Bind for dyn Detector {
    fn bind(detector: &mut Configured<Self>, programs: &Programs) -> Result<(), ParamError> {
        bind::<_, Params>(detector, |detector| detector, programs)
    }
}

impl Detector for Process<Params> {
    fn facts(&self) -> Facts {
        Facts { signals: self.params.signals, uses_seed: self.depends_on_seed(), ..Facts::default() }
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let failed = |message: String| DetectorOutput { failure: Some(message), ..DetectorOutput::default() };
        let program = match self.program() {
            Ok(program) => program,
            Err(e) => return failed(e.to_string()),
        };
        self.params.run(program, input).unwrap_or_else(|(index, fault)| {
            failed(format!("{}: frame of index {index}: {fault}", program.name))
        })
    }
}

/// Message about a frame.
#[derive(Serialize)]
struct FrameLine {
    index: usize,
    value: f64,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    more: Vec<f64>,
}

/// Form of the expected answer, for messages.
const ANSWER: &str = "`{\"score\": 0.5, \"label\": 0}`, the label being 0 or 1";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Answer {
    score: f64,
    #[serde(deserialize_with = "label")]
    label: bool,
    index: Option<usize>,
}

/// Label in an answer: 0 or 1, for a tracker that has failed.
fn label<'de, D: Deserializer<'de>>(answer: D) -> Result<bool, D::Error> {
    match u8::deserialize(answer)? {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(D::Error::custom("a label is 0 or 1")),
    }
}

#[cfg(test)]
mod tests;
