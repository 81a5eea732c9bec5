//! A guard: a process between this program and another one. It ends together with all processes that the
//! other one started.
//!
//! On Linux this program starts itself with the first argument `WORD`; that process is the guard and starts
//! the other program. The guard is the subreaper (`PR_SET_CHILD_SUBREAPER`) of all descendants: a process
//! whose parent has ended becomes a child of the guard, even if it left its group and session. So the guard
//! finds all of them in the process tree below itself and kills them when the program has ended, when this
//! program asks, or when this program dies. The guard exits with the status of the program.

use nix::errno::Errno;
use nix::sys::signal::{Signal, kill};
use nix::sys::wait::{WaitStatus, wait};
use nix::unistd::{Pid, dup2_stderr, dup2_stdin, dup2_stdout, getpid, getppid};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::OnceLock;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// First argument of a guard.
const WORD: &str = "guard-of-a-program";
/// Start of the line on stderr of a guard that cannot start its program. The system's error number follows.
pub(super) const CANNOT_START: &str = "guard-of-a-program cannot start it: ";
/// Interval at which a guard checks that this program still runs.
const TICK: Duration = Duration::from_millis(50);
/// Pause between two searches for processes that must end; `PATIENCE` is the longest time for all of them.
const PAUSE: Duration = Duration::from_millis(2);
const PATIENCE: Duration = Duration::from_secs(5);

/// True in an executable that calls [`serve_if_asked`]. Tests of a library do not.
static SERVES: OnceLock<()> = OnceLock::new();

/// Turns this process into a guard, without returning, if it was started as one. Executables that run guarded
/// programs call it first.
pub fn serve_if_asked() {
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().is_some_and(|word| word == WORD) {
        let parent = arguments.next().and_then(|id| id.to_str()?.parse().ok()).map(Pid::from_raw);
        let folder = arguments.next().filter(|folder| !folder.is_empty()).map(PathBuf::from);
        if let (Some(parent), Some(program)) = (parent, arguments.next()) {
            let mut command = Command::new(program);
            command.args(arguments);
            std::process::exit(serve(parent, folder.as_deref(), command));
        }
    }
    SERVES.get_or_init(|| ());
}

/// Command that runs `program` under a guard, in the same folder and environment; `None` if this executable
/// has no guard. `folder` is deleted if this program dies.
pub(super) fn command(program: &Command, folder: Option<&Path>) -> Option<Command> {
    SERVES.get()?;
    let mut guard = Command::new("/proc/self/exe");
    guard.arg0("trackfail").arg(WORD).arg(std::process::id().to_string());
    guard.arg(folder.unwrap_or(Path::new(""))).arg(program.get_program()).args(program.get_args());
    if let Some(folder) = program.get_current_dir() {
        guard.current_dir(folder);
    }
    for (name, value) in program.get_envs() {
        match value {
            Some(value) => guard.env(name, value),
            None => guard.env_remove(name),
        };
    }
    Some(guard)
}

/// Runs the program until it ends or `parent` does. Returns the exit code.
fn serve(parent: Pid, folder: Option<&Path>, mut command: Command) -> i32 {
    // An old kernel has no subreapers; then processes that leave the tree are not found.
    let _ = nix::sys::prctl::set_child_subreaper(true);
    // The program may signal its group, which must not reach the guard.
    command.process_group(0);
    let child = match command.spawn() {
        Ok(child) => child,
        Err(e) => {
            eprintln!("{CANNOT_START}{}", e.raw_os_error().unwrap_or_default());
            return 127;
        }
    };
    // The streams are those of the program alone, so that their ends are seen.
    if let Ok(null) = std::fs::File::options().read(true).write(true).open("/dev/null") {
        let _ = dup2_stdin(&null).and(dup2_stdout(&null)).and(dup2_stderr(&null));
    }
    let (tell, told) = channel();
    std::thread::spawn(move || reap(&child, &tell));
    let ended = loop {
        match told.recv_timeout(TICK) {
            Ok(status) => break Some(status),
            Err(RecvTimeoutError::Timeout) if getppid() == parent => {}
            Err(_) => break None,
        }
    };
    end_descendants(getpid());
    match ended {
        Some(WaitStatus::Exited(_, code)) => code,
        Some(WaitStatus::Signaled(_, signal, _)) => {
            // The first one may only reach the handler that looks for overflows of the stack, and removes itself.
            for _ in 0..2 {
                let _ = kill(getpid(), signal);
                std::thread::sleep(PAUSE);
            }
            128 + signal as i32
        }
        _ => {
            let _ = folder.map(std::fs::remove_dir_all);
            1
        }
    }
}

/// Waits for all children, including orphans that became children later, and sends the status of the first
/// one.
fn reap(first: &Child, tell: &Sender<WaitStatus>) {
    let first = Pid::from_raw(first.id().cast_signed());
    loop {
        match wait() {
            Ok(status) if status.pid() == Some(first) => drop(tell.send(status)),
            Ok(_) | Err(Errno::EINTR) => {}
            Err(_) => return,
        }
    }
}

/// Ends a guarded program and all its descendants; `guard` is the process id of the guard.
pub(super) fn end(guard: u32) {
    end_descendants(Pid::from_raw(guard.cast_signed()));
}

/// Kills all descendants of a process, repeatedly, since new ones may start meanwhile.
fn end_descendants(root: Pid) {
    let end = Instant::now() + PATIENCE;
    loop {
        let living = living_descendants(root.as_raw());
        if living.is_empty() || Instant::now() > end {
            return;
        }
        for process in living {
            // It may have ended by itself.
            let _ = kill(Pid::from_raw(process), Signal::SIGKILL);
        }
        std::thread::sleep(PAUSE);
    }
}

/// Running processes below `root` in the process tree. Those that have ended and await collection are left
/// out.
fn living_descendants(root: i32) -> Vec<i32> {
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let all: Vec<(i32, i32, bool)> = entries
        .filter_map(|entry| {
            let id = entry.file_name().to_str()?.parse().ok()?;
            let (parent, lives) = parent_of(&std::fs::read_to_string(entry.path().join("stat")).ok()?)?;
            Some((id, parent, lives))
        })
        .collect();
    let mut below = vec![root];
    let mut at = 0;
    while let Some(parent) = below.get(at).copied() {
        below.extend(all.iter().filter(|(_, p, _)| *p == parent).map(|(id, _, _)| *id));
        at += 1;
    }
    let lives = |id: &i32| all.iter().any(|(other, _, lives)| other == id && *lives);
    below.into_iter().skip(1).filter(lives).collect()
}

/// Parent process id in a line of `/proc/*/stat`, and true if the process still runs. The process name in the
/// line may have any characters.
fn parent_of(stat: &str) -> Option<(i32, bool)> {
    let mut words = stat.rsplit_once(')')?.1.split_whitespace();
    let state = words.next()?;
    Some((words.next()?.parse().ok()?, !matches!(state, "Z" | "X" | "x")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Stdio;

    #[test]
    fn parents_are_read_whatever_the_name() {
        assert_eq!(parent_of("12 (a) b) S 7 12 12 0"), Some((7, true)));
        assert_eq!(parent_of("12 (sh) Z 1 12"), Some((1, false)));
        assert_eq!(parent_of("12 sh"), None);
    }

    #[test]
    fn descendants_are_found_and_ended() {
        let mut shell = Command::new("sh");
        let shell = shell.args(["-c", "sleep 1000 & setsid sleep 1000 & echo; wait"]);
        let mut child = shell.stdout(Stdio::piped()).spawn().unwrap();
        let mut byte = [0];
        std::io::Read::read_exact(child.stdout.as_mut().unwrap(), &mut byte).unwrap();
        let id = child.id();
        assert!(living_descendants(id.cast_signed()).len() >= 2);
        end(id);
        assert!(living_descendants(id.cast_signed()).is_empty());
        child.kill().unwrap();
        child.wait().unwrap();
    }
}
