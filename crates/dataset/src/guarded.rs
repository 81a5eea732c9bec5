//! Programs outside of this one, such as ffmpeg and trackers, which may misbehave in any way.
//!
//! A [`Guarded`] program and all its child processes end when the program ends or when this process ends,
//! whatever the cause. On Linux a guard process between the two ensures it. Elsewhere the program leads a
//! process group, and a small shell waits for the end of its stdin, a pipe that only this process holds, and
//! then kills the group.
//!
//! A process that has escaped may still hold the streams of the program open. The end of a stream is
//! therefore awaited for at most [`STREAM_GRACE`].

#[cfg(target_os = "linux")]
mod guard;

/// Stand-in for the guard on systems other than Linux.
#[cfg(not(target_os = "linux"))]
mod guard {
    use std::{path::Path, process::Command};

    pub(super) const CANNOT_START: &str = "";

    /// Does nothing on this system.
    pub fn serve_if_asked() {}

    pub(super) fn command(_: &Command, _: Option<&Path>) -> Option<Command> {
        None
    }

    pub(super) fn end(_: u32) {}
}

pub use guard::serve_if_asked;

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Number of bytes at the end of a stream that are kept.
const MAX_TAIL_BYTES: usize = 4 << 10;
/// Longest wait for the end of a stream after the program has ended.
pub const STREAM_GRACE: Duration = Duration::from_millis(300);
/// Longest pause between two checks that a program has ended.
const LONGEST_PAUSE: Duration = Duration::from_millis(100);

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Records that the user interrupted the program, for waits without a flag of their own. A signal handler may
/// call it.
pub fn interrupt() {
    INTERRUPTED.store(true, Ordering::Relaxed);
}

/// True once [`interrupt`] was called.
pub fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// A running program. Dropping the value ends the program and all that it started.
pub struct Guarded {
    process: Child,
    /// True if the process is a guard, which in turn started the program.
    is_guard: bool,
    /// Shell that kills the group of the program once its stdin ends. Only where there is no guard.
    shell: Option<Child>,
    stderr: Option<Tail>,
}

impl Guarded {
    /// Starts a program with the given stdin and stdout; its stderr is read. `folder` is deleted if this
    /// process dies first.
    ///
    /// # Errors
    /// When the program cannot be started. Some systems report that only in [`Self::try_wait`].
    pub fn start(command: Command, [stdin, stdout]: [Stdio; 2], folder: Option<&Path>) -> io::Result<Self> {
        // It is deleted by a process that works in another folder.
        let folder = folder.map(std::path::absolute).transpose()?;
        let folder = folder.as_deref();
        let guarded = guard::command(&command, folder);
        let is_guard = guarded.is_some();
        let mut command = guarded.unwrap_or(command);
        command.stdin(stdin).stdout(stdout).stderr(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut process = command.spawn()?;
        let shell = if is_guard { None } else { start_shell(process.id(), folder) };
        let stderr = process.stderr.take().map(Tail::new);
        Ok(Self { process, is_guard, shell, stderr })
    }

    /// Takes the stdin of the program, if it is a pipe. `None` at the second call.
    pub fn stdin(&mut self) -> Option<ChildStdin> {
        self.process.stdin.take()
    }

    /// Takes the stdout of the program, if it is a pipe. `None` at the second call.
    pub fn stdout(&mut self) -> Option<ChildStdout> {
        self.process.stdout.take()
    }

    /// Last bytes of the program's stderr. Its end is awaited for at most [`STREAM_GRACE`].
    pub fn stderr(&self) -> String {
        self.stderr.as_ref().map(Tail::text).unwrap_or_default()
    }

    /// Exit status of the program; `None` while it runs.
    ///
    /// # Errors
    /// When the program could not be started.
    pub fn try_wait(&mut self) -> io::Result<Option<ExitStatus>> {
        let status = self.process.try_wait()?;
        let error = status.and_then(|_| self.start_error());
        error.map_or(Ok(status), Err)
    }

    /// Error of the system, if the guard could not start the program.
    fn start_error(&self) -> Option<io::Error> {
        let text = self.is_guard.then(|| self.stderr())?;
        let number = text.strip_prefix(guard::CANNOT_START)?.trim_end().parse().ok()?;
        Some(io::Error::from_raw_os_error(number))
    }

    /// Waits until the program ends or `check` fails, then ends everything that the program started. Returns
    /// the exit status or the error of `check`.
    ///
    /// # Errors
    /// When the program could not be started.
    pub fn wait<E>(&mut self, check: impl Fn() -> Result<(), E>) -> io::Result<Result<ExitStatus, E>> {
        let mut pause = Duration::from_millis(1);
        let outcome = loop {
            if let Some(status) = self.try_wait()? {
                break Ok(status);
            }
            if let Err(reason) = check() {
                break Err(reason);
            }
            std::thread::sleep(pause);
            pause = (2 * pause).min(LONGEST_PAUSE);
        };
        self.end();
        Ok(outcome)
    }

    /// Ends the program with all that it has started.
    pub fn end(&mut self) {
        // When a guard has ended, so have the others, and its number may be another process's.
        if self.is_guard && matches!(self.process.try_wait(), Ok(None)) {
            guard::end(self.process.id());
        }
        if let Some(mut shell) = self.shell.take() {
            // A line says that this program lives.
            let _ = shell.stdin.take().map(|mut stdin| stdin.write_all(b"\n"));
            let _ = shell.wait();
        }
        // Needed if there is no shell; harmless if the process has already ended.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Drop for Guarded {
    fn drop(&mut self) {
        self.end();
    }
}

/// Keeps the last bytes of a stream. A thread reads on, so that a full pipe never blocks the writer.
pub struct Tail {
    kept: Arc<Mutex<VecDeque<u8>>>,
    ended: Receiver<()>,
}

impl Tail {
    /// Starts the reading thread.
    pub fn new(stream: impl Read + Send + 'static) -> Self {
        let (end, ended) = sync_channel(1);
        let kept = Arc::new(Mutex::new(VecDeque::new()));
        let tail = Self { kept: kept.clone(), ended };
        std::thread::spawn(move || {
            remember(stream, &kept);
            let _ = end.send(());
        });
        tail
    }

    /// Last bytes of the stream as text. Its end is awaited for at most [`STREAM_GRACE`].
    pub fn text(&self) -> String {
        let _ = self.ended.recv_timeout(STREAM_GRACE);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        String::from_utf8_lossy(kept.make_contiguous()).into_owned()
    }
}

/// Reads a stream to its end and keeps its last bytes.
fn remember(mut stream: impl Read, kept: &Mutex<VecDeque<u8>>) {
    let mut buffer = [0; 8 << 10];
    loop {
        match stream.read(&mut buffer) {
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Ok(0) | Err(_) => return,
            Ok(n) => {
                let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                kept.extend(&buffer[..n]);
                let surplus = kept.len().saturating_sub(MAX_TAIL_BYTES);
                kept.drain(..surplus);
            }
        }
    }
}

/// Starts a shell that kills a process group when its stdin ends, and deletes `folder` if no line came
/// before. `None` if the shell cannot be started.
fn start_shell(group: u32, folder: Option<&Path>) -> Option<Child> {
    const SCRIPT: &str = r#"lives=; while read -r _; do lives=1; done; kill -s KILL -- "-$1"; shift
        [ "$lives" ] || rm -rf -- "$@""#;
    let mut shell = Command::new("/bin/sh");
    shell.args(["-c", SCRIPT, "sh", &group.to_string()]).args(folder).current_dir("/");
    shell.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
    // In a group of its own as well, since Ctrl-C on the terminal must not end it.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut shell, 0);
    shell.spawn().ok()
}

#[cfg(test)]
mod tests;
