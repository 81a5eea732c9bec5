//! Killed, interrupted, out of space, not allowed: a run goes on from what is whole, or says why not.

use crate::tools::{Place, assert_same_files, needs};
use sha2::{Digest, Sha256};
use std::ffi::OsStr;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

fn start(folder: &Path) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
    command.env_remove("HOME").env_remove("TRACKFAIL_DATA").current_dir(folder).args(["run", "--quiet"]);
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// A results folder that says it is whole has the files that it says it has.
fn assert_whole_or_unfinished(folder: &Path) {
    let Ok(manifest) = std::fs::read(folder.join("manifest.json")) else { return };
    let manifest: serde_json::Value = serde_json::from_slice(&manifest).unwrap();
    for (name, digest) in manifest["files"].as_object().unwrap() {
        let bytes = std::fs::read(folder.join(name)).unwrap();
        let found: String = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
        assert_eq!(Some(found.as_str()), digest.as_str(), "{name}");
    }
}

#[test]
fn killed_at_fifty_moments_and_resumed_is_an_uninterrupted_run() {
    let (whole, killed) = (Place::new(), Place::new());
    assert!(start(whole.root()).wait().unwrap().success());
    let (mut kills, mut finished) = (0, 0);
    // Numbers from 0 to below 1 that look random, the same ones in every run of the tests.
    for moment in (1..=400_u32).map(|k| (f64::from(k) * 0.618_033_988_749_895).fract()) {
        let mut run = start(killed.root());
        std::thread::sleep(Duration::from_secs_f64(moment));
        if run.try_wait().unwrap().is_some() {
            finished += 1;
        } else {
            run.kill().unwrap();
            run.wait().unwrap();
            kills += 1;
        }
        assert_whole_or_unfinished(&killed.path("results/quickstart"));
        if kills == 50 {
            break;
        }
    }
    assert_eq!(kills, 50, "{finished} runs were over before they could be killed");
    assert!(start(killed.root()).wait().unwrap().success());
    assert_same_files(whole.root(), killed.root());
    let is_temporary = |name: &OsStr| name.as_encoded_bytes().starts_with(b".trackfail-tmp-");
    let entries = walkdir::WalkDir::new(killed.root()).into_iter().flatten();
    let left: Vec<_> = entries.filter(|entry| is_temporary(entry.file_name())).collect();
    assert!(left.is_empty(), "temporary files are left: {left:?}");
}

#[test]
fn ctrl_c_keeps_what_is_done_and_exits_130() {
    let place = Place::new();
    let packs = place.path("results/.store/packs");
    for signal in ["-INT", "-TERM"] {
        let before = std::fs::read_dir(&packs).map_or(0, Iterator::count);
        let mut run = start(place.root());
        // As soon as something is kept.
        while std::fs::read_dir(&packs).map_or(0, Iterator::count) <= before {
            assert!(run.try_wait().unwrap().is_none(), "it was over before it could be interrupted");
            std::thread::sleep(Duration::from_millis(5));
        }
        trackfail_testing::kill(run.id(), signal);
        assert_eq!(run.wait().unwrap().code(), Some(130), "{signal}");
        assert!(!place.has("results/quickstart/manifest.json"));
    }
    let whole = Place::new();
    for place in [&place, &whole] {
        assert!(start(place.root()).wait().unwrap().success());
    }
    assert_same_files(whole.root(), place.root());
}

/// A small file system in memory, mounted; its test is marked `#[needs(mount)]`.
#[cfg(target_os = "linux")]
struct Tmpfs(Place);

#[cfg(target_os = "linux")]
impl Tmpfs {
    fn mount(&self, how: &str) {
        self.0.shell(&format!("mount {how} '{}'", self.0.root().display())).ends(0);
    }
}

#[cfg(target_os = "linux")]
impl Drop for Tmpfs {
    fn drop(&mut self) {
        self.0.shell(&format!("umount -l '{}'", self.0.root().display()));
    }
}

#[cfg(target_os = "linux")]
#[needs(mount)]
#[test]
fn a_full_disk_and_a_read_only_one_leave_earlier_results_as_they_were() {
    let small = Tmpfs(Place::new());
    small.mount("-t tmpfs -o size=65536k none");
    let (disk, beside) = (&small.0, Place::new());
    let again = || disk.run("run --quiet --force");
    disk.run("run --quiet").ends(0);
    let copy = beside.path("copy");
    disk.shell(&format!("cp -a . '{}'", copy.display())).ends(0);

    assert_ne!(disk.shell("cat /dev/zero > filler").code, Some(0));
    let full = again().ends(1).tells("No space left");
    assert!(full.err.starts_with("error: quickstart: "), "{}", full.err);
    disk.remove("filler");
    assert_same_files(&copy, disk.root());
    assert_whole_or_unfinished(&disk.path("results/quickstart"));
    assert!(disk.has("results/quickstart/manifest.json"));

    small.mount("-o remount,ro");
    again().ends(1).tells("Read-only file system");
    // Tables are written beside the results.
    disk.run(&format!("report --reports {}", beside.path("reports").display())).ends(1);
    small.mount("-o remount,rw");
    assert_same_files(&copy, disk.root());
    again().ends(0);
    assert_same_files(&copy, disk.root());
}
