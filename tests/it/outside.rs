//! Programs that misbehave: nothing waits for them, and nothing of them is left. `ffmpeg` is a shell script here.

use crate::tools::{Place, Ran};
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

/// A folder with a script `ffmpeg`, a file `clip.mp4` and a temporary folder of its own.
struct Decoder(Place);

impl Decoder {
    fn new() -> Self {
        let place = Place::with(&[("clip.mp4", "a video"), ("boxes.txt", "1,1,9,9\n")]);
        ["programs", "tmp"].into_iter().for_each(|name| drop(place.folder(name)));
        Self(place)
    }

    /// `detect` on the clip with a script in the place of ffmpeg.
    fn detect(&self, script: &str) -> Command {
        trackfail_testing::script(&self.0.path("programs/ffmpeg"), script);
        let path = format!("{}:{}", self.0.path("programs").display(), std::env::var("PATH").unwrap());
        let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
        command.current_dir(self.0.root()).env("PATH", path).env("TMPDIR", self.0.path("tmp"));
        command.args(["detect", "--frames", "clip.mp4", "--boxes", "boxes.txt"]);
        command
    }

    /// Waits until the temporary folder is empty and the process has ended.
    fn is_clean(&self, process: &str) {
        let end = Instant::now() + Duration::from_secs(30);
        let left = || self.0.list("tmp").len();
        while is_running(process) || left() > 0 {
            assert!(Instant::now() < end, "{process} runs, or {} folders are left", left());
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

// Before: after SIGTERM it waited for the child of the script (23.6 s), after SIGKILL the child went on.
#[test]
fn a_decoding_ends_with_us_and_leaves_nothing() {
    let place = Decoder::new();
    let file = place.0.path("child.pid");
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
        let mut child = place.detect(script).stderr(std::process::Stdio::null()).spawn().unwrap();
        let process = pid(&file);
        assert!(is_running(&process));
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), code, "{signal}");
        place.is_clean(&process);
    }
}

// Before: it waited for the end of a stderr that the child held open.
#[test]
fn what_a_decoder_leaves_running_is_not_waited_for() {
    let place = Decoder::new();
    let file = place.0.path("child.pid");
    let script =
        format!("sleep 1000 & echo $! > '{}'; echo 'moov atom not found' >&2; exit 1", file.display());
    let ran = Ran::of(&mut place.detect(&script).into()).ends(3);
    ran.tells("clip.mp4: this is no video that ffmpeg reads").tells("(ffmpeg: moov atom not found)");
    place.is_clean(&pid(&file));
}

// Before: it waited for ever.
#[test]
fn a_pipe_is_no_video() {
    let place = Decoder::new();
    place.0.shell("rm clip.mp4 && mkfifo clip.mp4").ends(0);
    let told = "clip.mp4: not a file; frames are a video file";
    Ran::of(&mut place.detect("exit 1").into()).ends(3).tells(told);
}
