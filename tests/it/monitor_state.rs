//! `trackfail monitor --state`: whose the state is, and under what it goes on.

use crate::live::{Live, jumping, lines, monitor};
use serde_json::json;
use std::path::PathBuf;

fn place() -> (tempfile::TempDir, PathBuf) {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("track.state");
    (root, path)
}

// Two writers of one state would each undo what the other has written.
#[test]
fn one_monitor_at_a_time_has_a_state() {
    let (root, path) = place();
    let state = path.to_str().unwrap();
    let arguments = ["--method", "Displacement", "--state", state];
    let all = jumping(20, 9);
    let mut live = Live::start(&arguments);
    live.ask(&all[0]);
    let kept = std::fs::read(&path).unwrap();
    let second = |state: &str| {
        let (code, out, err) = monitor(&["--method", "Displacement", "--state", state], &lines(all.clone()));
        assert_eq!((code, out.as_str()), (3, ""), "{err}");
        assert!(err.contains("track.state: another `trackfail monitor` has its state there"), "{err}");
        assert_eq!(std::fs::read(&path).unwrap(), kept);
    };
    second(state);
    #[cfg(unix)]
    {
        // Under another name it is the same state.
        let link = root.path().join("link");
        std::os::unix::fs::symlink(&path, &link).unwrap();
        second(link.to_str().unwrap());
    }
    // The first one goes on as if nothing had been, and another state is free.
    assert_eq!(live.ask(&all[1])["index"], 1);
    let other = root.path().join("other.state");
    assert_eq!(monitor(&["--state", other.to_str().unwrap()], &lines(all.clone())).0, 0);
    assert_eq!(live.end(), 0);
    // A process that is killed leaves the state to the next one.
    let mut live = Live::start(&arguments);
    assert_eq!(live.ask(&all[2])["index"], 2);
    live.kill();
    assert_eq!(monitor(&arguments, &lines(all[2..3].to_vec())).0, 0);
}

#[test]
fn a_state_goes_on_under_its_own_base_and_inputs() {
    let (_root, path) = place();
    let state = path.to_str().unwrap();
    let boxes = |from: usize| lines(jumping(from + 5, 99)[from..].to_vec());
    let begun = ["--base", "1", "--inputs", "confidence", "--budget", "2", "--state", state];
    assert_eq!(monitor(&begun, &boxes(0)).0, 0);
    let kept = std::fs::read(&path).unwrap();
    let other: [(&[&str], &str); 4] = [
        (&["--base", "0"], "boxes that count pixels from 1, not from 0; remove the file to begin anew"),
        (&["--inputs", "frames"], "the state is one for boxes, confidence, not for boxes, frames"),
        (&["--inputs", "frames,confidence"], "not for boxes, frames, confidence"),
        (&["--budget", "3"], "a budget of 2, not with a budget of 3"),
    ];
    for (arguments, words) in other {
        let (code, out, err) = monitor(&[arguments, &["--state", state]].concat(), &boxes(5));
        assert_eq!((code, out.as_str()), (3, ""), "{arguments:?}: {err}");
        assert!(err.contains("track.state: ") && err.contains(words), "{arguments:?}: {err}");
        assert_eq!(std::fs::read(&path).unwrap(), kept, "{arguments:?}");
    }
    // What is not said is that of the state: the answers are those of the stream without an interruption.
    let (code, rest, _) = monitor(&["--state", state], &boxes(5));
    assert_eq!(code, 0);
    let whole = monitor(&begun[..6], &lines(jumping(10, 99))).1;
    assert_eq!(whole.lines().skip(5).collect::<Vec<_>>(), rest.lines().collect::<Vec<_>>());
    assert_eq!(monitor(&begun, &lines([json!({})])).0, 0);
}

#[test]
fn a_state_of_the_first_format_is_refused_in_words() {
    let (_root, path) = place();
    let state = ["--state", path.to_str().unwrap()];
    std::fs::write(&path, b"trackfail-monitor 1\n").unwrap();
    let (code, _, err) = monitor(&state, "{}\n");
    assert_eq!(code, 3, "{err}");
    assert!(
        err.contains("track.state: a state of format 1, which this program does not read; remove"),
        "{err}"
    );
}
