//! A monitor at work, and lines for it.

use super::{Place, Ran, words};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// A running monitor.
pub struct Live {
    pub child: Child,
    pub input: Option<ChildStdin>,
    pub answers: BufReader<ChildStdout>,
}

impl Live {
    /// Starts it with a line of arguments.
    pub fn start(place: &Place, line: &str) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
        command.current_dir(place.root()).arg("monitor").args(words(line));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let input = child.stdin.take();
        let answers = BufReader::new(child.stdout.take().unwrap());
        Self { child, input, answers }
    }

    /// The answer to a line, read before anything else is written.
    pub fn ask(&mut self, line: &Value) -> Value {
        self.ask_text(&line.to_string())
    }

    /// The answer to a line that need not be JSON.
    pub fn ask_text(&mut self, line: &str) -> Value {
        writeln!(self.input.as_mut().unwrap(), "{line}").unwrap();
        let mut answer = String::new();
        self.answers.read_line(&mut answer).unwrap();
        serde_json::from_str(&answer).unwrap_or_else(|e| panic!("{line:.200}: {e}: {answer}"))
    }

    /// Sends it a signal, `-TERM` and the like.
    pub fn signal(&self, name: &str) {
        trackfail_testing::kill(self.child.id(), name);
    }

    /// Ends it without a chance to do anything.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// The exit code, after the input is closed.
    pub fn end(mut self) -> i32 {
        drop(self.input.take());
        self.child.wait().unwrap().code().unwrap()
    }
}

/// A monitor on a whole input.
pub fn monitor(place: &Place, line: &str, input: &str) -> Ran {
    Ran::of(place.command(&format!("monitor {line}")).write_stdin(input))
}

/// Values as lines.
pub fn lines<'a>(values: impl IntoIterator<Item = &'a Value>) -> String {
    values.into_iter().map(|line| format!("{line}\n")).collect()
}

/// The answers of a monitor.
pub fn answers(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Boxes that move a pixel a frame, and in frame `jump` by three times their size.
pub fn jumping(frames: usize, jump: usize) -> Vec<Value> {
    (0..frames).map(|t| json!({"box": [t + if t < jump { 0 } else { 60 }, 30, 20, 20]})).collect()
}
