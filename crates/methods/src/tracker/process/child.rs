//! A child process that gets lines and answers them, and that may misbehave in any way.
//!
//! Each of its three streams has a thread, so that no call here waits longer than its time limit; buffers are
//! bounded. It is [guarded](trackfail_dataset::guarded), so that it ends with this program.

use super::peer::received;
use std::io::{BufReader, Write};
use std::path::Path;
use std::process::{ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::time::{Duration, Instant};
use trackfail_dataset::guarded::{self, Guarded, STREAM_GRACE};
use trackfail_dataset::text::{shorten_to, visible};

/// Lines of stderr and characters per line that messages quote.
const MAX_LINES: usize = 5;
const MAX_LINE_CHARS: usize = 200;
/// Messages under way to it or from it; there is one at a time, unless it misbehaves.
const MAX_QUEUED: usize = 4;
/// Time that a process has to end after it was asked to, or after its stdout has ended.
const GRACE: Duration = Duration::from_secs(2);
const TICK: Duration = Duration::from_millis(5);
/// Time between two looks for an interruption.
const PAUSE: Duration = Duration::from_millis(50);
const UNASKED: &str = "it answered without being asked; one answer a frame was expected";

/// Why a program gave no answer: it could not be started, ended, was silent or sent something else than the expected answer;
/// with the last lines of its stderr.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ProgramFault(pub String);

/// A child process whose answers are of type `T`.
pub struct Child<T: Send + 'static> {
    process: Guarded,
    /// The first word of its command.
    name: String,
    lines: Option<SyncSender<String>>,
    answers: Receiver<Result<T, ProgramFault>>,
    /// Time limit of the next answer.
    within: Duration,
    /// Time limit of the answers after it.
    later: Duration,
    /// The line that asks it to end; without one the end of its stdin does.
    quit: Option<&'static str>,
}

impl<T: Send + 'static> Child<T> {
    /// Starts the process. `read` takes one answer from its stdout, `None` at the end; `folder`, if there is one, is
    /// deleted if this program dies. The first answer may take the time limit `first`, the others `later`; `quit` is the line
    /// that asks it to end, if there is one.
    pub fn start(
        command: Command,
        folder: Option<&Path>,
        (first, later): (Duration, Duration),
        quit: Option<&'static str>,
        mut read: impl FnMut(&mut BufReader<ChildStdout>) -> Option<Result<T, ProgramFault>> + Send + 'static,
    ) -> Result<Self, ProgramFault> {
        let name = command.get_program().to_string_lossy().into_owned();
        let mut process = Guarded::start(command, [Stdio::piped(), Stdio::piped()], folder)
            .map_err(|e| ProgramFault(format!("cannot start `{name}`: {e}")))?;
        let (lines, queue) = sync_channel::<String>(MAX_QUEUED);
        let (answer, answers) = sync_channel(MAX_QUEUED);
        if let Some(mut stdin) = process.stdin() {
            std::thread::spawn(move || {
                // Writing fails when the process reads no more; the missing answer is noticed elsewhere.
                while let Ok(line) = queue.recv() {
                    if stdin.write_all(line.as_bytes()).and_then(|()| stdin.flush()).is_err() {
                        break;
                    }
                }
            });
        }
        if let Some(stdout) = process.stdout() {
            let mut stdout = BufReader::new(stdout);
            std::thread::spawn(move || {
                while let Some(one) = read(&mut stdout) {
                    let last = one.is_err();
                    if answer.send(one).is_err() || last {
                        break;
                    }
                }
            });
        }
        Ok(Self { process, name, lines: Some(lines), answers, within: first, later, quit })
    }

    /// Sends a line without waiting for the answer.
    pub fn send(&mut self, line: String) -> Result<(), ProgramFault> {
        match self.answers.try_recv() {
            Err(TryRecvError::Empty | TryRecvError::Disconnected) => {}
            Ok(Err(e)) => return Err(self.fault(e.to_string())),
            Ok(Ok(_)) => {
                return Err(self.fault(UNASKED.into()));
            }
        }
        match self.lines.as_ref().map(|lines| lines.try_send(line)) {
            Some(Err(TrySendError::Full(_))) => Err(self.fault("it does not read what it is sent".into())),
            _ => Ok(()),
        }
    }

    /// Waits for the next answer; `expected` describes it in messages. An [interruption](guarded::interrupt) ends the wait.
    pub fn receive(&mut self, expected: &str) -> Result<T, ProgramFault> {
        let (start, within) = (Instant::now(), std::mem::replace(&mut self.within, self.later));
        let received = loop {
            let left = within.saturating_sub(start.elapsed());
            match self.answers.recv_timeout(left.min(PAUSE)) {
                Err(RecvTimeoutError::Timeout) if guarded::is_interrupted() => {
                    return Err(self.fault("interrupted".into()));
                }
                Err(RecvTimeoutError::Timeout) if left > PAUSE => {}
                received => break received,
            }
        };
        let message = match received {
            Ok(Ok(answer)) => return Ok(answer),
            Ok(Err(e)) => format!("{e}; expected {expected}"),
            Err(RecvTimeoutError::Timeout) => {
                format!("no answer within {} s; expected {expected}", within.as_secs_f64())
            }
            Err(RecvTimeoutError::Disconnected) => match self.ended(|_| false)? {
                Some(status) => format!("it ended ({status}); expected {expected}"),
                None => format!("it closed its stdout; expected {expected}"),
            },
        };
        Err(self.fault(message))
    }

    /// Kills the process; the error is `message` with the last lines of its stderr.
    pub fn fault(&mut self, message: String) -> ProgramFault {
        self.kill();
        let text = self.process.stderr();
        let lines: Vec<&str> = text.lines().filter(|l| !l.trim().is_empty()).collect();
        let last = &lines[lines.len().saturating_sub(MAX_LINES)..];
        if last.is_empty() {
            return ProgramFault(message);
        }
        let last: Vec<_> = last.iter().map(|l| shorten_to(&visible(l.trim_end()), MAX_LINE_CHARS)).collect();
        ProgramFault(format!("{message}; its stderr ends with: {}", last.join(" | ")))
    }

    /// Ends it after its last answer: asks it to end, and gives it [`GRACE`]. A further answer, as `is_answer` has it, is a
    /// fault: it may be the answer to the last frame, with all before it shifted. So is an end of its own with another status
    /// than 0: it says that something went wrong.
    pub fn finish(&mut self, is_answer: fn(&T) -> bool) -> Result<(), ProgramFault> {
        self.ask_to_end();
        match self.ended(is_answer)? {
            Some(status) if !status.success() => {
                Err(self.fault(format!("it ended after its last answer ({status}); expected exit status: 0")))
            }
            _ => {
                self.kill();
                Ok(())
            }
        }
    }

    /// Sends the line that asks it to end, and closes its stdin.
    fn ask_to_end(&mut self) {
        let _ = self.lines.take().zip(self.quit).map(|(lines, quit)| lines.try_send(quit.to_string()));
    }

    /// The exit status, or nothing if it goes on for [`GRACE`]. An answer meanwhile, as `is_answer` has it, is a fault.
    fn ended(&mut self, is_answer: fn(&T) -> bool) -> Result<Option<ExitStatus>, ProgramFault> {
        let mut end = Instant::now() + GRACE;
        let mut ended = None;
        while Instant::now() < end {
            match self.answers.recv_timeout(TICK) {
                Ok(Ok(last)) if is_answer(&last) => return Err(self.fault(UNASKED.into())),
                Ok(Err(e)) => return Err(self.fault(e.to_string())),
                Ok(Ok(_)) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) if ended.is_some() => break,
                Err(RecvTimeoutError::Disconnected) => std::thread::sleep(TICK),
            }
            if ended.is_none() {
                let status = self.process.try_wait();
                ended = status.map_err(|e| ProgramFault(format!("cannot start `{}`: {e}", self.name)))?;
                // Something that it has started may hold its stdout open.
                end = if ended.is_some() { end.min(Instant::now() + STREAM_GRACE) } else { end };
            }
        }
        Ok(ended)
    }

    fn kill(&mut self) {
        self.lines = None;
        self.process.end();
    }
}

impl Child<String> {
    /// Sends a line and reads the answer to it; `expected` describes it in messages, and `read` has a reason why it is none.
    pub fn ask<A>(
        &mut self,
        line: String,
        expected: &str,
        read: impl FnOnce(&str) -> Result<A, String>,
    ) -> Result<A, ProgramFault> {
        self.send(line)?;
        let answer = self.receive(expected)?;
        read(&answer).map_err(|why| self.fault(format!("{} ({why}); expected {expected}", received(&answer))))
    }
}

impl<T: Send + 'static> Drop for Child<T> {
    fn drop(&mut self) {
        if self.lines.is_some() && self.quit.is_some() {
            self.ask_to_end();
            let _ = self.ended(|_| false);
        }
        self.kill();
    }
}
