//! Programs here are shell scripts, good ones and bad ones.
#![cfg(unix)]

use super::*;
use crate::tracker::testing;
use std::time::Duration;

/// The detector of a script, bound, and the folder of the script.
fn bound(
    params: &str,
    text: &str,
    change: impl Fn(&mut Program),
) -> (Configured<dyn Detector>, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let mut program = testing::script(Role::Detector, folder.path(), text);
    change(&mut program);
    let mut detector = ENTRY.build_from_text(params).unwrap();
    Bind::bind(&mut detector, &testing::programs(&program)).unwrap();
    (detector, folder)
}

fn detect(detector: &dyn Detector, more: &[&[f64]]) -> DetectorOutput {
    let error = [f64::NAN; 3];
    detector.detect(&Input { signal: &[0.5, -1.0, 2.0], error: &error, seed: 99, reverse: None, more })
}

#[test]
fn a_program_gets_the_signal_and_its_answers_are_the_labels() {
    let text = r#"echo "$TRACKFAIL_SEED $EXTRA" > environment
read -r meta; printf '%s\n' "$meta" > log
n=0
while read -r line; do
    printf '%s\n' "$line" >> log
    echo "{\"label\": $((n % 2)), \"score\": $n.25}"
    n=$((n + 1))
done
"#;
    let (detector, folder) = bound("{ program = \"mine\", params = { k = 4 } }", text, |_| ());
    let output = detect(detector.as_ref(), &[]);
    let expected = DetectorOutput {
        score: vec![0.25, 1.25, 2.25],
        alarm: vec![false, true, false],
        ..DetectorOutput::default()
    };
    assert_eq!(output, expected);
    let read = |name| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read("environment"), "99 more\n");
    let expected = r#"{"meta":{"protocol":1,"program":"mine","role":"detector","frames":3,"params":{"k":4}}}
{"index":0,"value":0.5}
{"index":1,"value":-1.0}
{"index":2,"value":2.0}
"#;
    assert_eq!(read("log"), expected);
    let (detector, folder) = bound("{ program = \"mine\", signals = 2 }", text, |_| ());
    assert_eq!(detector.signals(), 2);
    detect(detector.as_ref(), &[&[1.0, 2.0, 3.0]]);
    assert!(
        std::fs::read_to_string(folder.path().join("log")).unwrap().contains(r#""value":-1.0,"more":[2.0]}"#)
    );
}

#[test]
fn version_files_and_seed_are_part_of_the_address() {
    let params = "{ program = \"mine\" }";
    let (detector, _folder) = bound(params, "# a", |p| p.digest = vec![p.folder.join("script.sh")]);
    let shown = detector.params();
    assert_eq!((shown["version"].as_str(), detector.uses_seed()), (Some("7"), true));
    let file = shown["files"][0].as_str().unwrap().to_string();
    // printf '# a' | sha256sum
    assert!(file.starts_with("script.sh ") && file.len() > 40, "{file}");
    let (other, _folder) = bound(params, "# b", |p| p.digest = vec![p.folder.join("script.sh")]);
    assert_ne!(other.params(), shown);
    let (fixed, _folder) = bound(params, "", |p| p.deterministic = true);
    assert!(!fixed.uses_seed());
    let folder = tempfile::tempdir().unwrap();
    let mut program = testing::script(Role::Detector, folder.path(), "");
    program.digest = vec![folder.path().join("absent.py")];
    let mut unbound = ENTRY.build_from_text(params).unwrap();
    let refused = Bind::bind(&mut unbound, &testing::programs(&program)).unwrap_err();
    assert!(refused.message.contains("absent.py"));
    assert!(detect(unbound.as_ref(), &[]).failure.unwrap().contains("mine is not known here"));
    assert!(ENTRY.build_from_text("{ program = \"mine\", signals = 0 }").is_err());
}

#[test]
fn a_failure_gives_no_labels() {
    let answer = "read -r line; echo '{\"score\": 1, \"label\": 1}'\n";
    for (text, words) in [
        ("read -r line; echo '{\"score\": 1, \"label\": 2}'".to_string(), "frame of index 0: received"),
        ("read -r line; echo '{\"score\": 1, \"label\": 2}'".into(), "a label is 0 or 1"),
        ("read -r line; echo '{\"score\": 1}'".into(), "missing field `label`"),
        ("read -r line; echo '{\"score\": null, \"label\": 0}'".into(), "invalid type: null"),
        (
            "read -r line; echo '{\"score\": 1, \"label\": 0, \"index\": 7}'".into(),
            "the answer to index 7, but 0 was asked",
        ),
        ("read -r line; echo '{\"score\": Infinity, \"label\": 0}'".into(), "expected value"),
        (answer.repeat(2) + "echo gone >&2; exit 1", "frame of index 2: it ended (exit status: 1)"),
        (answer.repeat(4), ""),
        (answer.repeat(3) + "echo x", "frame of index 2: it answered without being asked"),
        (answer.repeat(3) + "exit 3", "frame of index 2: it ended after its last answer (exit status: 3)"),
        ("sleep 1000".into(), "no answer within 0.4 s"),
        ("yes x".into(), "frame of index 0: "),
    ] {
        let (detector, _folder) = bound("{ program = \"mine\" }", &format!("read -r meta\n{text}"), |p| {
            if text.contains("sleep") {
                p.start_timeout = Duration::from_millis(200);
                p.answer_timeout = Duration::from_millis(200);
            }
        });
        let output = detect(detector.as_ref(), &[]);
        match (words, output.failure) {
            // The fourth answer is asked for, but the line to read is not there: it is an empty one.
            ("", failure) => assert!(failure.is_some_and(|f| f.contains("without being asked")), "{text}"),
            (words, Some(failure)) => {
                assert!(failure.starts_with("mine: ") && failure.contains(words), "{text}: {failure}");
                assert!(output.alarm.is_empty() && output.score.is_empty(), "{text}");
            }
            (_, None) => panic!("{text}: {:?}", output.alarm),
        }
    }
}
