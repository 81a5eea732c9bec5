//! Programs that misbehave: nothing waits for them, and nothing of them is left. `ffmpeg` is a shell script here.

use crate::tools::{Place, words};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;
use trackfail_testing::{is_running, kill, within};

/// The process that a file tells of, once it is there.
pub fn pid(path: &Path) -> String {
    let mut text = String::new();
    let is_told = within(Duration::from_secs(60), || {
        text = std::fs::read_to_string(path).unwrap_or_default();
        text.ends_with('\n')
    });
    assert!(is_told, "{} was not written", path.display());
    text.trim().to_string()
}

/// The exit code of a program that gets a signal when the processes are there that files tell of. Neither these nor temporary
/// files are left.
pub fn end(place: &Place, command: &mut Command, files: &[PathBuf], signal: &str) -> Option<i32> {
    files.iter().for_each(|file| std::fs::remove_file(file).unwrap_or_default());
    command.current_dir(place.root()).env("TMPDIR", place.folder("tmp")).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let processes: Vec<String> = files.iter().map(|file| pid(file)).collect();
    assert!(processes.iter().all(|process| is_running(process)));
    kill(child.id(), signal);
    let code = child.wait().unwrap().code();
    let is_left = || processes.iter().any(|p| is_running(p)) || !place.list("tmp").is_empty();
    let is_clean = within(Duration::from_secs(30), || !is_left());
    assert!(is_clean, "{signal}: {processes:?} run, or something is left: {:?}", place.list("tmp"));
    code
}

// Before: after SIGTERM it waited for the child of the script (23.6 s), after SIGKILL the child went on.
#[test]
fn a_decoding_ends_with_us_and_leaves_nothing() {
    let place = Place::with(&[("clip.mp4", "a video"), ("boxes.txt", "1,1,9,9\n")]);
    let programs = place.folder("programs");
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
    let file = place.path("child.pid");
    let hang = format!("sleep 1000 & echo $! > '{}'; wait", file.display());
    // The frames are counted in small, then there are none.
    let later = format!("case \"$*\" in *scale=*) printf 'P6\\n1 1\\n255\\nabc' ;; *) {hang} ;; esac");
    for (script, signal, code) in [
        (&hang, "-TERM", Some(130)),
        (&hang, "-INT", Some(130)),
        (&hang, "-KILL", None),
        (&later, "-TERM", Some(130)),
        (&later, "-KILL", None),
    ] {
        trackfail_testing::script(&programs.join("ffmpeg"), script);
        let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
        command.args(words("detect --frames clip.mp4 --boxes boxes.txt")).env("PATH", &path);
        assert_eq!(end(&place, &mut command, std::slice::from_ref(&file), signal), code, "{signal}");
    }
}
