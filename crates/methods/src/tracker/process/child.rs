//! A child process that is asked and answers, and that may do anything instead.
//!
//! Its three streams have a thread each, so that nothing here waits longer than it wants to; what is held
//! of them is bounded. The process leads a group of its own. A small shell guards the group: it waits for
//! the end of its stdin, a pipe that only we hold, then kills the group and deletes the folder of images. So
//! the end of this process, whatever its cause, is the end of the child, and killing it is closing the pipe.

use crate::dataset::text::{shorten_to, visible};
use std::collections::VecDeque;
use std::io::{BufReader, Read, Write};
use std::path::Path;
use std::process::{ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// So many bytes of stderr are remembered, and so many lines and characters a line are told.
const MAX_STDERR_BYTES: usize = 4 << 10;
const MAX_LINES: usize = 5;
const MAX_LINE_CHARS: usize = 200;
/// Messages on their way to it or from it; there is one at a time, unless it does what it should not.
const MAX_QUEUED: usize = 4;
/// How long a process may take to end after it was asked to, or after its stdout has.
const GRACE: Duration = Duration::from_secs(2);
/// How long the end of stderr is waited for, which a process that has left the group may hold open.
const STDERR_GRACE: Duration = Duration::from_millis(300);
const TICK: Duration = Duration::from_millis(5);

/// A child whose answers are `T`.
pub struct Child<T> {
    process: std::process::Child,
    guard: Option<Guard>,
    ask: Option<SyncSender<String>>,
    answers: Receiver<Result<T, String>>,
    stderr: Arc<Mutex<VecDeque<u8>>>,
    stderr_ended: Receiver<()>,
}

impl<T: Send + 'static> Child<T> {
    /// Starts it. `read` takes one answer from its stdout, `None` at the end; `folder` is deleted if we die.
    pub fn start(
        mut command: Command,
        folder: &Path,
        mut read: impl FnMut(&mut BufReader<ChildStdout>) -> Option<Result<T, String>> + Send + 'static,
    ) -> Result<Self, String> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let name = command.get_program().to_string_lossy().into_owned();
        let mut process = command.spawn().map_err(|e| format!("cannot start `{name}`: {e}"))?;
        let guard = Guard::new(process.id(), folder);
        let (ask, asked) = sync_channel::<String>(MAX_QUEUED);
        let (answer, answers) = sync_channel(MAX_QUEUED);
        let (end, stderr_ended) = sync_channel(1);
        let stderr = Arc::new(Mutex::new(VecDeque::new()));
        if let Some(mut stdin) = process.stdin.take() {
            std::thread::spawn(move || {
                // Writing fails when it reads no more; that it then does not answer is noticed.
                while let Ok(line) = asked.recv() {
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
        Ok(Self { process, guard, ask: Some(ask), answers, stderr, stderr_ended })
    }

    /// Sends a line that is not answered.
    pub fn tell(&mut self, line: String) -> Result<(), String> {
        match self.answers.try_recv() {
            Err(TryRecvError::Empty | TryRecvError::Disconnected) => {}
            Ok(Err(said)) => return Err(self.fault(said)),
            Ok(Ok(_)) => {
                let twice = "it answered without being asked; one answer a frame was expected";
                return Err(self.fault(twice.into()));
            }
        }
        match self.ask.as_ref().map(|ask| ask.try_send(line)) {
            Some(Err(TrySendError::Full(_))) => Err(self.fault("it does not read what it is sent".into())),
            _ => Ok(()),
        }
    }

    /// The next answer, `expected` in words.
    pub fn hear(&mut self, expected: &str, within: Duration) -> Result<T, String> {
        let said = match self.answers.recv_timeout(within) {
            Ok(Ok(answer)) => return Ok(answer),
            Ok(Err(said)) => format!("{said}; expected {expected}"),
            Err(RecvTimeoutError::Timeout) => {
                format!("no answer within {} s; expected {expected}", within.as_secs_f64())
            }
            Err(RecvTimeoutError::Disconnected) => match self.ended(GRACE) {
                Some(status) => format!("it ended ({status}); expected {expected}"),
                None => format!("it closed its stdout; expected {expected}"),
            },
        };
        Err(self.fault(said))
    }

    /// Kills it and adds its last words to what is said of it.
    pub fn fault(&mut self, said: String) -> String {
        self.kill();
        let _ = self.stderr_ended.recv_timeout(STDERR_GRACE);
        let bytes: Vec<u8> =
            self.stderr.lock().unwrap_or_else(PoisonError::into_inner).iter().copied().collect();
        let text = String::from_utf8_lossy(&bytes);
        let lines: Vec<&str> = text.lines().filter(|l| !l.trim().is_empty()).collect();
        let last = &lines[lines.len().saturating_sub(MAX_LINES)..];
        if last.is_empty() {
            return said;
        }
        let last: Vec<_> = last.iter().map(|l| shorten_to(&visible(l.trim_end()), MAX_LINE_CHARS)).collect();
        format!("{said}; its stderr ends with: {}", last.join(" | "))
    }

    /// Asks it to end, and waits a moment for that.
    pub fn quit(&mut self, line: String) {
        let Some(ask) = self.ask.take() else { return };
        // Its stdin is closed behind the line.
        if ask.try_send(line).is_ok() {
            drop(ask);
            self.ended(GRACE);
        }
        self.kill();
    }

    /// How it ended, if it does within a time.
    fn ended(&mut self, within: Duration) -> Option<ExitStatus> {
        let end = Instant::now() + within;
        loop {
            // It may be waiting for room to say something more.
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
        self.ask = None;
        drop(self.guard.take());
        // Where there is no guard; a process that has ended already is not harmed.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl<T> Drop for Child<T> {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Keeps the end of a stream.
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

/// Kills a process group when it is dropped, or when we are gone.
struct Guard {
    shell: std::process::Child,
}

impl Guard {
    /// `None` where there is no such shell.
    #[cfg(unix)]
    fn new(group: u32, folder: &Path) -> Option<Self> {
        use std::os::unix::process::CommandExt as _;
        const SCRIPT: &str = r#"while read -r _; do :; done; kill -s KILL -- "-$1"; rm -rf -- "$2""#;
        let mut shell = Command::new("/bin/sh");
        shell.args(["-c", SCRIPT, "sh", &group.to_string()]).arg(folder).current_dir("/");
        // A group of its own, too: Ctrl-C on the terminal is not meant for it.
        shell.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null()).process_group(0);
        Some(Self { shell: shell.spawn().ok()? })
    }

    #[cfg(not(unix))]
    fn new(_: u32, _: &Path) -> Option<Self> {
        None
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        drop(self.shell.stdin.take());
        let _ = self.shell.wait();
    }
}
