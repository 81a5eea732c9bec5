//! Programs here are shell scripts, good ones and bad ones.
#![cfg(unix)]

use super::*;
use crate::tracker::process::Program;
use crate::tracker::testing;
use std::time::Duration;
use trackfail_core::image::decode;
use trackfail_core::region::Rect;
use trackfail_dataset::Sequence;

fn sequence() -> Sequence {
    testing::rendered("Ramp", 4)
}

/// The signal of a script, bound, and the folder of the script.
fn bound(
    params: &str,
    text: &str,
    change: impl Fn(&mut Program),
) -> (Configured<dyn Signal>, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let mut program = testing::script(Role::Signal, folder.path(), text);
    change(&mut program);
    let mut signal = ENTRY.build_from_text(params).unwrap();
    Bind::bind(&mut signal, &testing::programs(&program)).unwrap();
    (signal, folder)
}

fn state(t: usize) -> TrackerState {
    let region = match t {
        2 => Region::Polygon(vec![(1.0, 1.0), (5.0, 2.0), (4.0, 6.0), (0.0, 5.0)]),
        _ => Region::Rect(Rect::new(t as f64, 2.5, 3.0, 4.0)),
    };
    let mut state = TrackerState::new(region, if t == 3 { Status::Absent } else { Status::Failed });
    state.confidence = (t > 0).then_some(0.125 * t as f64);
    state.response = Some(Response { peak: 0.5, ..Response::default() });
    state
}

/// The values of all frames, as far as they go, and the first fault.
fn values(signal: &dyn Signal) -> (Vec<f64>, Option<String>) {
    let sequence = sequence();
    let mut session = match signal.start(&testing::context(&sequence, 0)) {
        Ok(session) => session,
        Err(e) => return (vec![], Some(e.to_string())),
    };
    let mut values = Vec::new();
    for t in 0..sequence.len() {
        let value = session.push(&Observation::new(&sequence.frame(t).unwrap(), &state(t)));
        if let Some(fault) = session.fault() {
            assert!(!value.is_finite(), "a value beside a fault");
            assert!(
                session.push(&Observation::new(&sequence.frame(t).unwrap(), &state(t))).is_nan(),
                "it stays dead"
            );
            return (values, Some(fault.to_string()));
        }
        values.push(value);
    }
    (values, None)
}

/// Answers every line but the first, after it has written it down, and keeps the image.
const GOOD: &str = r#"echo "$TRACKFAIL_SEED$EXTRA" > environment
read -r meta; printf '%s\n' "$meta" > log
n=0
while read -r line; do
    printf '%s\n' "$line" >> log
    image=$(printf '%s' "$line" | sed -n 's/.*"frame":"\([^"]*\)".*/\1/p')
    [ -n "$image" ] && cp "$image" "seen$n.png"
    n=$((n + 1))
    echo "{\"score\": $n.5}"
done
echo end >> log
"#;

#[test]
fn a_program_gets_what_it_reads_and_its_answers_are_the_signal() {
    let params = "{ program = \"mine\", params = { rate = 0.5, words = [\"a\"] } }";
    let (signal, folder) = bound(params, GOOD, |_| ());
    assert_eq!(values(signal.as_ref()), (vec![1.5, 2.5, 3.5, 4.5], None));
    let read = |name| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read("environment"), "more\n");
    let expected = r#"{"meta":{"protocol":1,"program":"mine","role":"signal","frames":4,"params":{"rate":0.5,"words":["a"]}}}
{"index":0,"frame":null,"box":[0.0,2.5,3.0,4.0],"absent":false,"confidence":null}
{"index":1,"frame":null,"box":[1.0,2.5,3.0,4.0],"absent":false,"confidence":0.125}
{"index":2,"frame":null,"box":[0.4384471871911697,1.4384471871911697,4.123105625617661,4.123105625617661],"polygon":[1.0,1.0,5.0,2.0,4.0,6.0,0.0,5.0],"absent":false,"confidence":0.25}
{"index":3,"frame":null,"box":[3.0,2.5,3.0,4.0],"absent":true,"confidence":0.375}
end
"#;
    assert_eq!(read("log"), expected);
    // Nothing of the ground truth, nor of what is made of it.
    for word in ["truth", "Failed", "status", &sequence().name] {
        assert!(!read("log").contains(word), "{word}");
    }
}

#[test]
fn frames_without_a_file_are_sent_as_images() {
    let (signal, folder) = bound("{ program = \"mine\", reads = \"pixels\" }", GOOD, |_| ());
    assert_eq!(values(signal.as_ref()).0, [1.5, 2.5, 3.5, 4.5]);
    let log = std::fs::read_to_string(folder.path().join("log")).unwrap();
    assert!(log.contains("\"frames\":4,\"size\":[320,240]"), "{log}");
    for t in 0..4 {
        let seen = std::fs::read(folder.path().join(format!("seen{t}.png"))).unwrap();
        assert_eq!(decode(&seen).unwrap(), sequence().frame(t).unwrap());
    }
    let (signal, folder) = bound("{ program = \"mine\", reads = \"response\" }", GOOD, |_| ());
    assert_eq!(values(signal.as_ref()).0.len(), 4);
    assert!(
        std::fs::read_to_string(folder.path().join("log")).unwrap().contains("\"response\":{\"peak\":0.5")
    );
}

#[test]
fn parameters_say_what_it_needs_and_what_is_good() {
    let (signal, _folder) = bound("{ program = \"mine\", good = \"low\", reads = \"pixels\" }", "", |p| {
        p.digest = vec!["/a/b".into()];
    });
    assert_eq!((signal.facts().direction, signal.reads()), (Direction::LowerIsBetter, Reads::Pixels));
    let expected = serde_json::json!(
        { "program": "mine", "good": "low", "reads": "pixels", "params": {}, "version": "7" }
    );
    assert_eq!(signal.params(), expected);
    let sequence = sequence();
    let context = testing::context(&sequence, 0);
    assert_eq!(signal.inputs(&context).unwrap(), [PathBuf::from("/a/b")]);
    let mut other = ENTRY.build_from_text("{ program = \"mime\" }").unwrap();
    assert!(matches!(other.start(&context), Err(TrackerError::Missing(_))));
    let folder = tempfile::tempdir().unwrap();
    // A tracker of that name is no signal.
    let tracker = testing::script(Role::Tracker, folder.path(), "");
    let refused = Bind::bind(&mut other, &testing::programs(&tracker)).unwrap_err();
    assert!(
        refused.message.contains("names no signal") && refused.key == Some("program"),
        "{}",
        refused.message
    );
}

#[test]
fn what_a_program_does_wrong_is_told() {
    let answer = "read -r line; echo '{\"score\": 1}'\n";
    for (text, words) in [
        ("read -r line; echo 0.5".to_string(), "received `0.5` (invalid type"),
        ("read -r line; echo '{\"score\": NaN}'".into(), "expected `{\"score\": 0.5}`"),
        ("read -r line; echo '{\"score\": 1e999}'".into(), "number out of range"),
        ("read -r line; echo '{\"scor\": 1}'".into(), "unknown field `scor`"),
        ("read -r line; echo '{\"score\": 1, \"label\": 0}'".into(), "unknown field `label`"),
        (
            "read -r line; echo '{\"score\": 1, \"index\": 1}'".into(),
            "the answer to index 1, but 0 was asked",
        ),
        ("read -r line; printf '\\377\\n'".into(), "received `\u{fffd}`"),
        ("read -r line; head -c 1000000000 /dev/zero".into(), "a line of 16384 bytes and more"),
        (
            "echo no memory >&2; exit 7".into(),
            "it ended (exit status: 7); expected `{\"score\": 0.5}` with a finite number; its stderr ends with: no memory",
        ),
        (answer.repeat(2) + "exit 0", "frame 3 of"),
        (answer.repeat(2) + "exit 0", "it ended (exit status: 0)"),
        (answer.repeat(4) + "echo '{\"score\": 1}'", "it answered without being asked"),
        (answer.repeat(4) + "echo x", "it answered without being asked"),
        (
            answer.repeat(4) + "exit 3",
            "it ended after its last answer (exit status: 3); expected exit status: 0",
        ),
        (answer.repeat(4) + "kill -s KILL $$", "it ended after its last answer (signal: 9"),
        (answer.repeat(2) + "echo '{\"score\": 1}'\n" + &answer.repeat(2), "it answered without being asked"),
        (answer.repeat(3) + "exec >&-; sleep 1000", "it closed its stdout"),
    ] {
        let (signal, _folder) = bound("{ program = \"mine\" }", &format!("read -r meta\n{text}"), |_| ());
        let (values, fault) = values(signal.as_ref());
        let fault = fault.unwrap_or_else(|| panic!("{text}: {values:?}"));
        assert!(fault.starts_with("mine: frame ") && fault.contains(words), "{text}: {fault}");
        assert!(fault.chars().count() < 600 && !fault.contains(char::is_control), "{fault}");
    }
    let (signal, _folder) =
        bound("{ program = \"mine\" }", "", |p| p.command = vec!["no-such-program-at-all".into()]);
    assert!(values(signal.as_ref()).1.unwrap().contains("cannot start `no-such-program-at-all`"));
}

#[test]
fn hanging_programs_are_killed_and_slow_ends_are_no_fault() {
    let impatient = |program: &mut Program| {
        program.start_timeout = Duration::from_millis(200);
        program.answer_timeout = Duration::from_millis(200);
    };
    let (signal, folder) = bound("{ program = \"mine\" }", "sleep 1000 & echo $! > child; wait", impatient);
    let (_, fault) = values(signal.as_ref());
    assert!(fault.unwrap().contains("no answer within 0.4 s; expected `{\"score\": 0.5}`"));
    let child = std::fs::read_to_string(folder.path().join("child")).unwrap();
    assert!(testing::is_gone(&child), "{child} is left");
    let slow = "read -r meta; for i in 1 2 3 4; do read -r line; echo '{\"score\": 1}'; done; sleep 1000";
    let (signal, _folder) = bound("{ program = \"mine\" }", slow, |_| ());
    assert_eq!(values(signal.as_ref()), (vec![1.0; 4], None));
}
