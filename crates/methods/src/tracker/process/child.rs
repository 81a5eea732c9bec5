//! A child process that gets lines and answers them. It may misbehave in any way.
//!
//! Each of its three streams has a thread, so that no call here waits longer than its time limit. Buffers are
//! bounded. The process is [guarded](trackfail_dataset::guarded), so that it ends with this program.

use super::peer::received;
use std::io::{BufReader, Write};
use std::path::Path;
use std::process::{ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::time::{Duration, Instant};
use trackfail_dataset::guarded::{self, Guarded, STREAM_GRACE};
use trackfail_dataset::text::{shorten_to, visible};

/// Largest number of lines of stderr in a message; `MAX_LINE_CHARS` bounds the characters per line.
const MAX_LINES: usize = 5;
const MAX_LINE_CHARS: usize = 200;
/// Capacity of the queues of messages in each direction. More than one message waits only if the process
/// misbehaves.
const MAX_QUEUED: usize = 4;
/// Time for a process to end after it was asked to, or after its stdout has ended.
const GRACE: Duration = Duration::from_secs(2);
const TICK: Duration = Duration::from_millis(5);
/// Time between two checks for an interruption.
const PAUSE: Duration = Duration::from_millis(50);
const UNASKED: &str = "it answered without being asked; one answer a frame was expected";

/// A child process whose answers are of type `T`. A fault is the reason why it gave no answer (not started, ended,
/// silent, or not the expected answer), with the last lines of its stderr.
pub struct Child<T: Send + 'static> {
    process: Guarded,
    /// First word of the command.
    name: String,
    lines: Option<SyncSender<String>>,
    answers: Receiver<Result<T, String>>,
    /// Time limit of the next answer.
    within: Duration,
    /// Time limit of all later answers.
    later: Duration,
    /// Line that asks the process to end; `None`: the end of its stdin does.
    quit: Option<&'static str>,
}

impl<T: Send + 'static> Child<T> {
    /// Starts the process. `read` takes one answer from its stdout, `None` at the end. If there is a
    /// `folder`, it is deleted when our own process dies. The time limit of the first answer is `first`, of
    /// the others `later`. `quit` is the line that asks the process to end; `None`: the end of its stdin
    /// does.
    pub fn start(
        command: Command,
        folder: Option<&Path>,
        (first, later): (Duration, Duration),
        quit: Option<&'static str>,
        mut read: impl FnMut(&mut BufReader<ChildStdout>) -> Option<Result<T, String>> + Send + 'static,
    ) -> Result<Self, String> {
        let name = command.get_program().to_string_lossy().into_owned();
        let mut process = Guarded::start(command, [Stdio::piped(), Stdio::piped()], folder)
            .map_err(|e| format!("cannot start `{name}`: {e}"))?;
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

    /// Sends a line and does not wait for the answer. `told` describes a message that says by itself why it came
    /// unasked.
    pub fn send(&mut self, line: String, told: impl FnOnce(&T) -> Option<String>) -> Result<(), String> {
        if self.lines.is_none() {
            return Err("it has ended".into());
        }
        match self.answers.try_recv() {
            Err(TryRecvError::Empty | TryRecvError::Disconnected) => {}
            Ok(Err(fault)) => return Err(self.fault(fault)),
            Ok(Ok(early)) => return Err(self.fault(told(&early).unwrap_or(UNASKED.into()))),
        }
        match self.lines.as_ref().map(|lines| lines.try_send(line)) {
            Some(Err(TrySendError::Full(_))) => Err(self.fault("it does not read what it is sent".into())),
            _ => Ok(()),
        }
    }

    /// Waits for the next answer; `expected` describes it for messages. An [interruption](guarded::interrupt)
    /// ends the wait.
    pub fn receive(&mut self, expected: &str) -> Result<T, String> {
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

    /// Kills the process. Returns the error: `message` and the last lines of its stderr.
    pub fn fault(&mut self, message: String) -> String {
        self.kill();
        let text = self.process.stderr();
        let lines: Vec<&str> = text.lines().filter(|l| !l.trim().is_empty()).collect();
        let last = &lines[lines.len().saturating_sub(MAX_LINES)..];
        if last.is_empty() {
            return message;
        }
        let last: Vec<_> = last.iter().map(|l| shorten_to(&visible(l.trim_end()), MAX_LINE_CHARS)).collect();
        format!("{message}; its stderr ends with: {}", last.join(" | "))
    }

    /// Asks the process to end after its last answer, and waits up to [`GRACE`]. A further answer (for which
    /// `is_answer` is true) is a fault: it may be the answer to the last frame, with all earlier ones
    /// shifted. An exit status other than 0 is a fault, too.
    pub fn finish(&mut self, is_answer: fn(&T) -> bool) -> Result<(), String> {
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

    /// Sends the `quit` line, and closes the stdin of the process.
    fn ask_to_end(&mut self) {
        let _ = self.lines.take().zip(self.quit).map(|(lines, quit)| lines.try_send(quit.to_string()));
    }

    /// The exit status, or `None` if the process still runs after [`GRACE`]. A further answer (for which
    /// `is_answer` is true) is a fault.
    fn ended(&mut self, is_answer: fn(&T) -> bool) -> Result<Option<ExitStatus>, String> {
        let mut end = Instant::now() + GRACE;
        let mut ended = None;
        while Instant::now() < end {
            match self.answers.recv_timeout(TICK) {
                Ok(Ok(last)) if is_answer(&last) => return Err(self.fault(UNASKED.into())),
                Ok(Err(fault)) => return Err(self.fault(fault)),
                Ok(Ok(_)) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) if ended.is_some() => break,
                Err(RecvTimeoutError::Disconnected) => std::thread::sleep(TICK),
            }
            if ended.is_none() {
                let status = self.process.try_wait();
                ended = status.map_err(|e| format!("cannot start `{}`: {e}", self.name))?;
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
    /// Sends a line and reads the answer. `expected` describes the answer for messages; `read` returns a
    /// reason if the text is not an answer.
    pub fn ask<A>(
        &mut self,
        line: String,
        expected: &str,
        read: impl FnOnce(&str) -> Result<A, String>,
    ) -> Result<A, String> {
        self.send(line, |_| None)?;
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
