//! The client's side of the protocol of signals and detectors: lines of JSON, of which the first is not answered.

use super::child::Child;
use super::fault::ProgramFault;
use super::peer::{command, read_line, received};
use super::programs::Program;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;
use std::time::Duration;

/// Version of the protocol, in the first line.
/// - 1: first version.
pub const PROTOCOL: u32 = 1;

/// A running program. After an error it is dead.
pub struct JsonPeer {
    child: Child<String>,
    within: Duration,
    later: Duration,
}

/// Parameters that are handed over to a program.
pub type Handed = serde_json::Map<String, serde_json::Value>;

/// First line of the protocol.
#[derive(Serialize)]
struct First<'a> {
    meta: Meta<'a>,
}

#[derive(Serialize)]
struct Meta<'a> {
    protocol: u32,
    program: &'a str,
    role: &'static str,
    frames: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<(usize, usize)>,
    params: &'a Handed,
}

/// Facts of a track that its program is told.
pub struct Track<'a> {
    /// Number of frames.
    pub frames: usize,
    /// Width and height of the frames, for programs that look at them.
    pub size: Option<(usize, usize)>,
    /// Parameters that are handed over.
    pub params: &'a Handed,
}

/// An answer that may have the index of its frame.
pub trait Indexed {
    /// The index, from 0, if it is given.
    fn index(&self) -> Option<usize>;
}

impl JsonPeer {
    /// Starts a program with further `variables` in its environment, and sends it the first line; `folder`, if there is
    /// one, is deleted if this program dies.
    pub fn start(
        program: &Program,
        variables: &[(&str, String)],
        folder: Option<&Path>,
        track: &Track<'_>,
    ) -> Result<Self, ProgramFault> {
        let mut command = command(program)?;
        command.envs(variables.iter().map(|(name, value)| (name, value)));
        let child = Child::start(command, folder, read_line)?;
        let later = program.answer_timeout;
        let mut peer = Self { child, within: program.start_timeout + later, later };
        let Track { frames, size, params } = *track;
        let role = program.role.word();
        let meta = Meta { protocol: PROTOCOL, program: &program.name, role, frames, size, params };
        peer.send(&First { meta })?;
        Ok(peer)
    }

    fn send(&mut self, message: &impl Serialize) -> Result<(), ProgramFault> {
        let line = serde_json::to_string(message).map_err(|e| self.child.fault(e.to_string()))?;
        self.child.send(line + "\n")
    }

    /// Sends the message of a frame and waits for the answer, which may have the frame's `index`; `expected` describes
    /// it in messages.
    pub fn ask<A: DeserializeOwned + Indexed>(
        &mut self,
        index: usize,
        message: &impl Serialize,
        expected: &str,
    ) -> Result<A, ProgramFault> {
        self.send(message)?;
        let answer = self.child.receive(expected, self.within)?;
        self.within = self.later;
        read_answer(&answer, index).map_err(|why| {
            let message = format!("{} ({why}); expected {expected}", received(&answer));
            self.child.fault(message)
        })
    }

    /// Closes its stdin after the last answer.
    ///
    /// # Errors
    /// When it answers once more, or ends with another exit status than 0.
    pub fn finish(mut self) -> Result<(), ProgramFault> {
        self.child.finish(None, |_| true)
    }
}

/// An answer, which must be that to the frame of an index if it says so; or why it is none.
fn read_answer<A: DeserializeOwned + Indexed>(answer: &str, index: usize) -> Result<A, String> {
    let answer: A = serde_json::from_str(answer).map_err(|e| e.to_string())?;
    match answer.index() {
        Some(given) if given != index => Err(format!("the answer to index {given}, but {index} was asked")),
        _ => Ok(answer),
    }
}
