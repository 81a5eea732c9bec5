//! `process`: a detector in an external program, in any language.
//!
//! The program is named in `plugins.toml`, under `[detector.my-detector]`, with the keys of a
//! [signal](crate::signal::process) and `deterministic = true` for one whose answers do not depend on the seed (default
//! false). The protocol is that of a signal, too, with other messages. Ground truth is never sent.
//!
//! ```text
//! {"meta": {"protocol": 1, "program": "my-detector", "role": "detector", "frames": 87, "params": {}}}
//! {"index": 0, "value": 0.25}
//! <- {"score": 0.3, "label": 0}
//! ```
//!
//! `index` is a 0-based frame, `value` the signal there, and `more` a list of the further signals of a method with
//! `signals = 2` and above. `score` is any finite number, and high ones speak for a failure; `label` is 1 in frames that the
//! detector calls inconsistent (the tracker has failed), else 0. A message is sent when the one before it is answered, so
//! that a label cannot use later frames. An answer may have the `index` of its message, which is checked. The environment has `TRACKFAIL_SEED`.
//!
//! A program that crashes, hangs, sends something else or ends with another exit status than 0 has no labels: its cell fails, with the index of the frame and
//! the last lines of its stderr.

use super::{Detector, DetectorOutput, Input};
use crate::tracker::process::{
    Bind, Handed, Indexed, JsonPeer, Program, ProgramFault, Programs, Role, Track, not_bound,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::sync::Arc;
use trackfail_core::plugin::{Configured, Entry, ParamError, Plugin, Range};
use trackfail_dataset::file_digest;

/// The list's entry.
pub const ENTRY: Entry<dyn Detector> =
    Entry::of::<Process>("process", 1, "a program that plugins.toml names, over lines of JSON")
        .example(r#"{ program = "my-detector", signals = 1, params = {} }"#);

/// Parameters.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Name of the program in `plugins.toml`.
    pub program: String,
    /// Number of signals that it reads, 1 to 64.
    #[serde(default = "one")]
    pub signals: usize,
    /// Parameters that are handed over to it.
    #[serde(default)]
    pub params: Handed,
}

fn one() -> usize {
    1
}

struct Process {
    params: Params,
    /// `None` until it is bound; reports do not need it.
    program: Option<Arc<Program>>,
}

impl Plugin for Process {
    type Params = Params;

    const RANGES: &'static [Range] = &[Range::within("signals", 1.0, 64.0)];

    fn make(params: Params) -> Result<Self, ParamError> {
        Ok(Self { params, program: None })
    }
}

impl Process {
    /// The labels, or the frame and the fault.
    fn run(&self, program: &Program, input: &Input<'_>) -> Result<DetectorOutput, (usize, ProgramFault)> {
        let frames = input.signal.len();
        let track = Track { frames, size: None, params: &self.params.params };
        let seed = [("TRACKFAIL_SEED", input.seed.to_string())];
        let mut peer = JsonPeer::start(program, &seed, None, &track).map_err(|fault| (0, fault))?;
        let mut output = DetectorOutput::default();
        for (index, value) in input.signal.iter().enumerate() {
            let more = input.more.iter().filter_map(|signal| signal.get(index).copied()).collect();
            let answer: Answer = peer
                .ask(index, &FrameLine { index, value: *value, more }, ANSWER)
                .map_err(|fault| (index, fault))?;
            output.score.push(answer.score);
            output.alarm.push(answer.label == Label::Failed);
        }
        peer.finish().map_err(|fault| (frames.saturating_sub(1), fault))?;
        Ok(output)
    }
}

impl Bind for dyn Detector {
    fn bind(detector: &mut Configured<Self>, programs: &Programs) -> Result<(), ParamError> {
        let Some(process) = (&*detector.plugin as &dyn Any).downcast_ref::<Process>() else { return Ok(()) };
        let params = process.params.clone();
        let program = programs.named(Role::Detector, &params.program)?;
        let file = |path: &std::path::PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let digest = file_digest(path).map_err(|e| ParamError {
                message: e.to_string(),
                key: Some("program"),
                span: None,
            });
            Ok(format!("{name} {}", digest?))
        };
        // Names and digests of its files.
        let files: Vec<String> = program.digest.iter().map(file).collect::<Result<_, ParamError>>()?;
        detector.show("version", program.version.as_str());
        if !files.is_empty() {
            detector.show("files", files);
        }
        detector.plugin = Arc::new(Process { params, program: Some(program) });
        Ok(())
    }
}

impl Detector for Process {
    fn signals(&self) -> usize {
        self.params.signals
    }

    fn uses_seed(&self) -> bool {
        self.program.as_ref().is_none_or(|p| !p.deterministic)
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let failed = |message: String| DetectorOutput { failure: Some(message), ..DetectorOutput::default() };
        let Some(program) = &self.program else { return failed(not_bound(&self.params.program).to_string()) };
        self.run(program, input).unwrap_or_else(|(index, fault)| {
            failed(format!("{}: frame of index {index}: {fault}", program.name))
        })
    }
}

/// Message of a frame.
#[derive(Serialize)]
struct FrameLine {
    index: usize,
    value: f64,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    more: Vec<f64>,
}

/// Form of an answer, for messages.
const ANSWER: &str = "`{\"score\": 0.5, \"label\": 0}`, the label being 0 or 1";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Answer {
    score: f64,
    label: Label,
    index: Option<usize>,
}

impl Indexed for Answer {
    fn index(&self) -> Option<usize> {
        self.index
    }
}

/// Label of a frame.
#[derive(PartialEq, Deserialize)]
#[serde(try_from = "u8")]
enum Label {
    Consistent,
    Failed,
}

impl TryFrom<u8> for Label {
    type Error = &'static str;

    fn try_from(number: u8) -> Result<Self, &'static str> {
        match number {
            0 => Ok(Self::Consistent),
            1 => Ok(Self::Failed),
            _ => Err("a label is 0 or 1"),
        }
    }
}

#[cfg(test)]
mod tests;
