//! Programs that misbehave: nothing waits for them, and nothing of them is left. `ffmpeg` is a shell script here.

use crate::tools::Place;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// The process that a file tells of, once it is there.
pub fn pid(path: &Path) -> String {
    let end = Instant::now() + Duration::from_secs(60);
    loop {
        match std::fs::read_to_string(path) {
            Ok(text) if text.ends_with('\n') => return text.trim().to_string(),
            _ => assert!(Instant::now() < end, "{} was not written", path.display()),
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Whether a process is there and has not ended.
pub fn is_running(pid: &str) -> bool {
    let shown = Command::new("ps").args(["-o", "stat=", "-p", pid]).output().unwrap();
    let state = String::from_utf8_lossy(&shown.stdout).trim().to_string();
    !state.is_empty() && !state.starts_with('Z')
}

// Before: after SIGTERM it waited for the child of the script (23.6 s), after SIGKILL the child went on.
#[test]
fn a_decoding_ends_with_us_and_leaves_nothing() {
    let place = Place::with(&[("clip.mp4", "a video"), ("boxes.txt", "1,1,9,9\n")]);
    let [programs, temporary] = ["programs", "tmp"].map(|name| place.folder(name));
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
        std::fs::remove_file(&file).unwrap_or_default();
        trackfail_testing::script(&programs.join("ffmpeg"), script);
        let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
        command.current_dir(place.root()).env("PATH", &path).env("TMPDIR", &temporary);
        command.args(["detect", "--frames", "clip.mp4", "--boxes", "boxes.txt"]);
        let mut child = command.stderr(std::process::Stdio::null()).spawn().unwrap();
        let process = pid(&file);
        assert!(is_running(&process));
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), code, "{signal}");
        // The temporary folder becomes empty, and the process ends.
        let end = Instant::now() + Duration::from_secs(30);
        while is_running(&process) || !place.list("tmp").is_empty() {
            assert!(Instant::now() < end, "{process} runs, or something is left: {:?}", place.list("tmp"));
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}
