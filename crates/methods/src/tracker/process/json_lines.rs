//! The client's side of the protocol of signals and detectors. Messages are lines of JSON, and the first one
//! is not answered.

use super::child::Child;
use super::peer::{command, read_line};
use super::programs::Program;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::path::Path;

/// Version of the protocol, in the first line.
/// - 1: first version.
pub const PROTOCOL: u32 = 1;

/// A running program. It cannot be used after an error.
pub struct JsonPeer {
    child: Child<String>,
}

/// Parameters that are handed over to a program.
pub type Handed = serde_json::Map<String, serde_json::Value>;

/// The first message: protocol and track.
#[derive(Serialize)]
struct Meta<'a> {
    protocol: u32,
    program: &'a str,
    role: &'static str,
    #[serde(flatten)]
    track: &'a Track<'a>,
}

/// Facts about a track that the program is told.
#[derive(Serialize)]
pub struct Track<'a> {
    /// Number of frames.
    pub frames: usize,
    /// Width and height of the frames; `None` unless the program reads pixels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<(usize, usize)>,
    /// Parameters that are handed over to the program.
    pub params: &'a Handed,
}

impl JsonPeer {
    /// Starts a program with additional `variables` in its environment, and sends the first message. If there
    /// is a `folder`, it is deleted when our own process dies.
    pub fn start(
        program: &Program,
        variables: &[(&str, String)],
        folder: Option<&Path>,
        track: &Track<'_>,
    ) -> Result<Self, String> {
        let mut command = command(program)?;
        command.envs(variables.iter().map(|(name, value)| (name, value)));
        let limits = (program.start_timeout + program.answer_timeout, program.answer_timeout);
        let mut child = Child::start(command, folder, limits, None, read_line)?;
        let role = program.role.word();
        let meta = Meta { protocol: PROTOCOL, program: &program.name, role, track };
        child.send(line(&BTreeMap::from([("meta", meta)]))?, |_| None)?;
        Ok(Self { child })
    }

    /// Sends the message about a frame and waits for the answer; `expected` describes it for messages. If the
    /// answer has an index, which `given` returns, it must be the index of the frame.
    pub fn ask<A: DeserializeOwned>(
        &mut self,
        index: usize,
        message: &impl Serialize,
        expected: &str,
        given: fn(&A) -> Option<usize>,
    ) -> Result<A, String> {
        self.child.ask(line(message)?, expected, |answer| {
            let answer: A = serde_json::from_str(answer).map_err(|e| e.to_string())?;
            match given(&answer).filter(|given| *given != index) {
                Some(given) => Err(format!("the answer to index {given}, but {index} was asked")),
                None => Ok(answer),
            }
        })
    }

    /// Closes the stdin of the program after the last answer.
    ///
    /// # Errors
    /// When the program answers once more, or ends with an exit status other than 0.
    pub fn finish(mut self) -> Result<(), String> {
        self.child.finish(|_| true)
    }
}

fn line(message: &impl Serialize) -> Result<String, String> {
    let text = serde_json::to_string(message).map_err(|e| e.to_string())?;
    Ok(text + "\n")
}
