//! A child process that gets lines and answers them, and that may misbehave in any way.
//!
//! Each of its three streams has a thread, so that no call here waits longer than its time limit; buffers are
//! bounded.
//!
//! The end of this program, whatever its cause, ends the child and what it has started. On Linux a [guard](super::guard)
//! sees to that. Elsewhere the process leads a group of its own, which a small shell guards: it waits for the end of its
//! stdin, a pipe that only this program holds, then kills the group and deletes the folder of images.

use super::fault::ProgramFault;
use super::guard;
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
    /// The first word of its command.
    name: String,
    /// Whether the process is a guard, which has started the program.
    is_guard: bool,
    shell: Option<GuardShell>,
    lines: Option<SyncSender<String>>,
    answers: Receiver<Result<T, ProgramFault>>,
    stderr: Arc<Mutex<VecDeque<u8>>>,
    stderr_ended: Receiver<()>,
}

impl<T: Send + 'static> Child<T> {
    /// Starts the process. `read` takes one answer from its stdout, `None` at the end; `folder`, if there is one, is
    /// deleted if this program dies.
    pub fn start(
        command: Command,
        folder: Option<&Path>,
        mut read: impl FnMut(&mut BufReader<ChildStdout>) -> Option<Result<T, ProgramFault>> + Send + 'static,
    ) -> Result<Self, ProgramFault> {
        let name = command.get_program().to_string_lossy().into_owned();
        let guarded = guard::command(&command, folder);
        let is_guard = guarded.is_some();
        let mut command = guarded.unwrap_or(command);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut process =
            command.spawn().map_err(|source| ProgramFault::Start { program: name.clone(), source })?;
        let shell = if is_guard { None } else { GuardShell::new(process.id(), folder) };
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
        Ok(Self { process, name, is_guard, shell, lines: Some(lines), answers, stderr, stderr_ended })
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
                Some(_) if self.start_error().is_some() => {
                    let source = self.start_error().unwrap_or_else(|| std::io::ErrorKind::Other.into());
                    return Err(ProgramFault::Start { program: self.name.clone(), source });
                }
                Some(status) => format!("it ended ({status}); expected {expected}"),
                None => format!("it closed its stdout; expected {expected}"),
            },
        };
        Err(self.fault(message))
    }

    /// The last bytes of its stderr, when it has ended.
    fn stderr(&self) -> String {
        let _ = self.stderr_ended.recv_timeout(STDERR_GRACE);
        let bytes: Vec<u8> =
            self.stderr.lock().unwrap_or_else(PoisonError::into_inner).iter().copied().collect();
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// The system's error, if the guard could not start the program.
    fn start_error(&self) -> Option<std::io::Error> {
        let text = self.is_guard.then(|| self.stderr())?;
        let number = text.strip_prefix(guard::CANNOT_START)?.trim_end().parse().ok()?;
        Some(std::io::Error::from_raw_os_error(number))
    }

    /// Kills the process; the error is `message` with the last lines of its stderr.
    pub fn fault(&mut self, message: String) -> ProgramFault {
        self.kill();
        let text = self.stderr();
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

    /// Ends it after its last answer: sends `line`, if there is one, closes its stdin, and gives it [`GRACE`]. A further
    /// answer, as `is_answer` has it, is a fault: it may be the answer to the last frame, with all before it shifted. So is
    /// an end of its own with another status than 0: it says that something went wrong.
    pub fn finish(&mut self, line: Option<String>, is_answer: fn(&T) -> bool) -> Result<(), ProgramFault> {
        let lines = self.lines.take();
        let _ = lines.zip(line).map(|(lines, line)| lines.try_send(line));
        let end = Instant::now() + GRACE;
        let mut ended: Option<(Instant, ExitStatus)> = None;
        while Instant::now() < end {
            match self.answers.recv_timeout(TICK) {
                Ok(Ok(last)) if is_answer(&last) => return Err(self.fault(UNASKED.into())),
                Ok(Err(e)) => return Err(self.fault(e.to_string())),
                Ok(Ok(_)) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) if ended.is_some() => break,
                Err(RecvTimeoutError::Disconnected) => std::thread::sleep(TICK),
            }
            if ended.is_none()
                && let Ok(Some(status)) = self.process.try_wait()
            {
                ended = Some((Instant::now(), status));
            }
            // Something that it has started may hold its stdout open.
            if ended.is_some_and(|(at, _)| at.elapsed() > STDERR_GRACE) {
                break;
            }
        }
        if let Some((_, status)) = ended.filter(|(_, status)| !status.success()) {
            return Err(
                self.fault(format!("it ended after its last answer ({status}); expected exit status: 0"))
            );
        }
        self.kill();
        Ok(())
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
        if self.is_guard {
            guard::end(self.process.id());
        }
        drop(self.shell.take());
        // Needed if there is no shell; harmless if the process has already ended.
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
struct GuardShell {
    shell: std::process::Child,
}

impl GuardShell {
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

impl Drop for GuardShell {
    fn drop(&mut self) {
        drop(self.shell.stdin.take());
        let _ = self.shell.wait();
    }
}
