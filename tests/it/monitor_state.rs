//! `trackfail monitor --state`: whose the state is, and under what it goes on.

use crate::live::{Live, jumping, lines, monitor};
use crate::tools::Place;

const STATE: &str = "--method Displacement --state track.state";

// Two writers of one state would each undo what the other has written.
#[test]
fn one_monitor_at_a_time_has_a_state() {
    let place = Place::new();
    let all = jumping(20, 9);
    let mut live = Live::start(&place, STATE);
    live.ask(&all[0]);
    let kept = place.bytes("track.state");
    let second = |line: &str| {
        let told = "track.state: another `trackfail monitor` has its state there";
        monitor(&place, line, &lines(&all)).refuses(3, told);
        assert_eq!(place.bytes("track.state"), kept);
    };
    second(STATE);
    #[cfg(unix)]
    {
        // Under another name it is the same state.
        std::os::unix::fs::symlink(place.path("track.state"), place.path("link")).unwrap();
        second("--method Displacement --state link");
    }
    // The first one goes on as if nothing had been, and another state is free.
    assert_eq!(live.ask(&all[1])["index"], 1);
    monitor(&place, "--state other.state", &lines(&all)).ends(0);
    assert_eq!(live.end(), 0);
    // A process that is killed leaves the state to the next one.
    let mut live = Live::start(&place, STATE);
    assert_eq!(live.ask(&all[2])["index"], 2);
    live.kill();
    monitor(&place, STATE, &lines(&all[2..3])).ends(0);
}

// The rules are tested where they are; here are the words of the command line and the file.
#[test]
fn a_state_goes_on_under_its_own_base_and_inputs() {
    let place = Place::new();
    let boxes = |from: usize| lines(&jumping(from + 5, 99)[from..]);
    let begun = "--base 1 --inputs confidence --budget 2";
    let kept = "--state track.state";
    monitor(&place, &format!("{begun} {kept}"), &boxes(0)).ends(0);
    let state = place.bytes("track.state");
    for (arguments, words) in [
        ("--base 0", "boxes that count pixels from 1, not from 0; remove the file to begin anew"),
        ("--inputs frames,confidence", "one for boxes, confidence, not for boxes, frames, confidence"),
        ("--budget 3", "a budget of 2, not with a budget of 3"),
    ] {
        let ran = monitor(&place, &format!("{arguments} {kept}"), &boxes(5));
        ran.refuses(3, words).tells("track.state: ");
        assert_eq!(place.bytes("track.state"), state, "{arguments}");
    }
    // What is not said is that of the state: the answers are those of the stream without an interruption.
    let rest = monitor(&place, kept, &boxes(5)).ends(0).out;
    let whole = monitor(&place, begun, &lines(&jumping(10, 99))).out;
    assert_eq!(whole.lines().skip(5).collect::<Vec<_>>(), rest.lines().collect::<Vec<_>>());
}
