//! How programs end after their last answer.

use super::*;

// What a program says at its end is the only word on whether its answers were right; one that is killed after it did not end
// in time has said nothing.
#[test]
fn the_exit_status_after_the_last_answer_counts() {
    let answers = "for i in 1 2 3 4 5 6; do read -r line; echo 1,2,3,4; done\n";
    let lines = |end: &str| Script::new(Protocol::Lines, &format!("{answers}{end}"));
    let ended = "mine: frame 16 of Ramp: it ended after its last answer ";
    for (end, words) in [
        ("exit 3", "(exit status: 3); expected exit status: 0"),
        (
            "read -r line; echo no memory >&2; exit 1",
            "(exit status: 1); expected exit status: 0; its stderr ends with: no memory",
        ),
        ("read -r line; kill -s SEGV $$", "(signal: 11"),
    ] {
        let fault = lines(end).track(6).unwrap_err();
        assert!(fault.starts_with(ended) && fault[ended.len()..].starts_with(words), "{end}: {fault}");
        // Before the last frame there is no last answer.
        assert_eq!(lines(end).track(5).unwrap().len(), 5, "{end}");
    }
    for end in ["exit 0", "read -r line", "sleep 1000"] {
        assert_eq!(lines(end).track(6).unwrap().len(), 6, "{end}");
    }
    let script = trax("", "1,2,3,4");
    let text = script.read("script.sh").replace("exit 0", "exit 3");
    std::fs::write(script.dir.path().join("script.sh"), text).unwrap();
    assert!(script.track(6).unwrap_err().contains("it ended after its last answer (exit status: 3)"));
    assert_eq!(script.track(5).unwrap().len(), 5);
}
