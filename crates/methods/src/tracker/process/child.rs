//! A child process that gets lines and answers them, and that may misbehave in any way.
//!
//! Each of its three streams has a thread, so that no call here waits longer than its time limit; buffers are
//! bounded. The process leads a group of its own. A small shell guards the group: it waits for
//! the end of its stdin, a pipe that only this program holds, then kills the group and deletes the folder of images. So
//! the end of this program, whatever its cause, ends the child, and closing the pipe kills it.

use super::fault::ProgramFault;
use crate::dataset::text::{shorten_to, visible};
use std::collections::VecDeque;
use std::io::{BufReader, Read, Write};
use std::path::Path;
use std::process::{ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Bytes of stderr that are kept, and lines and characters per line that messages quote.
const MAX_STDERR_BYTES: usize = 4 << 10;
const MAX_LINES: usize = 5;
const MAX_LINE_CHARS: usize = 200;
/// Messages under way to it or from it; there is one at a time, unless it misbehaves.
const MAX_QUEUED: usize = 4;
/// Time that a process has to end after it was asked to, or after its stdout has ended.
const GRACE: Duration = Duration::from_secs(2);
/// Time limit of waiting for the end of stderr, which a process that has left the group may hold open.
const STDERR_GRACE: Duration = Duration::from_millis(300);
const TICK: Duration = Duration::from_millis(5);
const UNASKED: &str = "it answered without being asked; one answer a frame was expected";

/// A child process whose answers are of type `T`.
pub struct Child<T> {
    process: std::process::Child,
    guard: Option<Guard>,
    lines: Option<SyncSender<String>>,
    answers: Receiver<Result<T, ProgramFault>>,
    stderr: Arc<Mutex<VecDeque<u8>>>,
    stderr_ended: Receiver<()>,
}

impl<T: Send + 'static> Child<T> {
    /// Starts the process. `read` takes one answer from its stdout, `None` at the end; `folder`, if there is one, is
    /// deleted if this program dies.
    pub fn start(
        mut command: Command,
        folder: Option<&Path>,
        mut read: impl FnMut(&mut BufReader<ChildStdout>) -> Option<Result<T, ProgramFault>> + Send + 'static,
    ) -> Result<Self, ProgramFault> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let name = command.get_program().to_string_lossy().into_owned();
        let mut process = command.spawn().map_err(|source| ProgramFault::Start { program: name, source })?;
        let guard = Guard::new(process.id(), folder);
        let (lines, queue) = sync_channel::<String>(MAX_QUEUED);
        let (answer, answers) = sync_channel(MAX_QUEUED);
        let (end, stderr_ended) = sync_channel(1);
        let stderr = Arc::new(Mutex::new(VecDeque::new()));
        if let Some(mut stdin) = process.stdin.take() {
            std::thread::spawn(move || {
                // Writing fails when the process reads no more; the missing answer is noticed elsewhere.
                while let Ok(line) = queue.recv() {
                    if stdin.write_all(line.as_bytes()).and_then(|()| stdin.flush()).is_err() {
                        break;
                    }
                }
            });
        }
        if let Some(stdout) = process.stdout.take() {
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
        if let Some(stream) = process.stderr.take() {
            let kept = stderr.clone();
            std::thread::spawn(move || {
                remember(stream, &kept);
                let _ = end.send(());
            });
        }
        Ok(Self { process, guard, lines: Some(lines), answers, stderr, stderr_ended })
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

    /// Waits for the next answer; `expected` describes it in messages.
    pub fn receive(&mut self, expected: &str, within: Duration) -> Result<T, ProgramFault> {
        let message = match self.answers.recv_timeout(within) {
            Ok(Ok(answer)) => return Ok(answer),
            Ok(Err(e)) => format!("{e}; expected {expected}"),
            Err(RecvTimeoutError::Timeout) => {
                format!("no answer within {} s; expected {expected}", within.as_secs_f64())
            }
            Err(RecvTimeoutError::Disconnected) => match self.ended(GRACE) {
                Some(status) => format!("it ended ({status}); expected {expected}"),
                None => format!("it closed its stdout; expected {expected}"),
            },
        };
        Err(self.fault(message))
    }

    /// Kills the process; the error is `message` with the last lines of its stderr.
    pub fn fault(&mut self, message: String) -> ProgramFault {
        self.kill();
        let _ = self.stderr_ended.recv_timeout(STDERR_GRACE);
        let bytes: Vec<u8> =
            self.stderr.lock().unwrap_or_else(PoisonError::into_inner).iter().copied().collect();
        let text = String::from_utf8_lossy(&bytes);
        let lines: Vec<&str> = text.lines().filter(|l| !l.trim().is_empty()).collect();
        let last = &lines[lines.len().saturating_sub(MAX_LINES)..];
        if last.is_empty() {
            return ProgramFault::Conduct(message);
        }
        let last: Vec<_> = last.iter().map(|l| shorten_to(&visible(l.trim_end()), MAX_LINE_CHARS)).collect();
        ProgramFault::Conduct(format!("{message}; its stderr ends with: {}", last.join(" | ")))
    }

    /// Sends `line`, which asks the process to end, and gives it [`GRACE`].
    pub fn quit(&mut self, line: String) {
        let Some(lines) = self.lines.take() else { return };
        // Its stdin is closed after the line.
        if lines.try_send(line).is_ok() {
            drop(lines);
            self.ended(GRACE);
        }
        self.kill();
    }

    /// Ends it after its last answer: closes its stdin and gives it [`GRACE`]. A further answer is a fault.
    pub fn finish(&mut self) -> Result<(), ProgramFault> {
        self.lines = None;
        match self.answers.recv_timeout(GRACE) {
            Ok(Ok(_)) => Err(self.fault(UNASKED.into())),
            Ok(Err(e)) => Err(self.fault(e.to_string())),
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
                self.kill();
                Ok(())
            }
        }
    }

    /// The exit status, if it ends within a time.
    fn ended(&mut self, within: Duration) -> Option<ExitStatus> {
        let end = Instant::now() + within;
        loop {
            // It may be blocked on a full pipe.
            while self.answers.try_recv().is_ok() {}
            match self.process.try_wait() {
                Ok(Some(status)) => return Some(status),
                Ok(None) if Instant::now() < end => std::thread::sleep(TICK),
                _ => return None,
            }
        }
    }
}

impl<T> Child<T> {
    fn kill(&mut self) {
        self.lines = None;
        drop(self.guard.take());
        // Needed if there is no guard; harmless if the process has already ended.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl<T> Drop for Child<T> {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Reads a stream to its end and keeps its last bytes.
fn remember(mut stream: impl Read, kept: &Mutex<VecDeque<u8>>) {
    let mut buffer = [0; 8 << 10];
    loop {
        match stream.read(&mut buffer) {
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Ok(0) | Err(_) => return,
            Ok(n) => {
                let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                kept.extend(&buffer[..n]);
                let surplus = kept.len().saturating_sub(MAX_STDERR_BYTES);
                kept.drain(..surplus);
            }
        }
    }
}

/// Kills a process group when it is dropped, or when this program dies.
struct Guard {
    shell: std::process::Child,
}

impl Guard {
    /// `None` if the shell cannot be started.
    #[cfg(unix)]
    fn new(group: u32, folder: Option<&Path>) -> Option<Self> {
        use std::os::unix::process::CommandExt as _;
        const SCRIPT: &str = r#"while read -r _; do :; done; kill -s KILL -- "-$1"; shift; rm -rf -- "$@""#;
        let mut shell = Command::new("/bin/sh");
        shell.args(["-c", SCRIPT, "sh", &group.to_string()]).args(folder).current_dir("/");
        // In a group of its own as well, since Ctrl-C on the terminal must not end it.
        shell.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null()).process_group(0);
        Some(Self { shell: shell.spawn().ok()? })
    }

    #[cfg(not(unix))]
    fn new(_: u32, _: Option<&Path>) -> Option<Self> {
        None
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        drop(self.shell.stdin.take());
        let _ = self.shell.wait();
    }
}
