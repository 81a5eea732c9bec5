//! Outputs of `trackfail detect`: a verdict for people, formats for programs, exit codes, files.

use crate::tools::{rows, trackfail};
use std::path::{Path, PathBuf};
use std::process::Output;

/// Boxes that stand still, jump to a far place in frame 41, and stand there.
fn boxes(root: &Path) -> PathBuf {
    let path = root.join("boxes.txt");
    let text: String = (1..=60).map(|t| if t < 41 { "10,10,20,20\n" } else { "200,10,20,20\n" }).collect();
    std::fs::write(&path, text).unwrap();
    path
}

fn detect(boxes: &Path, more: &[&str]) -> Output {
    trackfail()
        .args(["detect", "--method", "Displacement", "--boxes"])
        .arg(boxes)
        .args(more)
        .output()
        .unwrap()
}

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap()
}

const VERDICT: &str = "lost from frame 41 (Displacement: 9.50 > 1.00); recovered at 51\n";

#[test]
fn a_verdict_a_table_and_json() {
    let root = tempfile::tempdir().unwrap();
    let boxes = boxes(root.path());
    let one = text(detect(&boxes, &["--format", "table"]).stdout);
    assert_eq!(one, VERDICT);
    let two = text(detect(&boxes, &["--method", "Scale", "--format", "table"]).stdout);
    let lines: Vec<&str> = two.lines().collect();
    assert_eq!((lines[0], lines[1]), (VERDICT.trim_end(), ""));
    let words = |line: &str| line.split_whitespace().map(String::from).collect::<Vec<_>>();
    assert_eq!(words(lines[3]), ["Displacement", "1", "10", "of", "60", "41", "tracking"]);
    assert_eq!(words(lines[4]), ["Scale", "0", "0", "of", "60", "tracking"]);

    // What is piped is CSV unless the user wants something else.
    let csv = text(detect(&boxes, &[]).stdout);
    assert_eq!(csv, text(detect(&boxes, &["--format", "csv"]).stdout));
    let all = rows(&csv);
    let lost: Vec<&str> = all.iter().filter(|row| row["state"] == "lost").map(|row| &*row["frame"]).collect();
    assert_eq!(lost, (41..=50).map(|t| t.to_string()).collect::<Vec<_>>());

    let json: serde_json::Value =
        serde_json::from_slice(&detect(&boxes, &["--format", "json"]).stdout).unwrap();
    let method = &json["tracks"][0]["methods"][0];
    assert!(json["tracks"][0]["target"].is_null());
    assert_eq!(method["verdict"], VERDICT.trim_end());
    assert_eq!(method["lost"], serde_json::json!([[41, 50]]));
    assert_eq!((&method["threshold"], method["frames"].as_array().unwrap().len()), (&1.0.into(), 60));
    for (row, frame) in all.iter().zip(method["frames"].as_array().unwrap()) {
        assert_eq!(row["state"], frame["state"].as_str().unwrap());
        assert_eq!(row["score"].parse::<f64>().unwrap(), frame["score"].as_f64().unwrap());
    }
}

#[test]
fn a_loss_may_be_an_exit_code() {
    let root = tempfile::tempdir().unwrap();
    let boxes = boxes(root.path());
    let lost = detect(&boxes, &["--fail-on-loss", "--format", "table"]);
    assert_eq!(lost.status.code(), Some(6));
    assert_eq!(text(lost.stdout), VERDICT);
    assert_eq!(text(lost.stderr), format!("error: {VERDICT}"));
    let still = root.path().join("still.txt");
    std::fs::write(&still, "10,10,20,20\n".repeat(9)).unwrap();
    assert_eq!(detect(&still, &["--fail-on-loss"]).status.code(), Some(0));
    let help = text(trackfail().arg("--help").output().unwrap().stdout);
    let help: Vec<&str> = help.split_whitespace().collect();
    assert!(help.join(" ").contains("6 the target is lost (`detect --fail-on-loss`)"));
}

#[test]
fn a_budget_is_for_methods_that_take_one() {
    let root = tempfile::tempdir().unwrap();
    let boxes = boxes(root.path());
    let output = detect(&boxes, &["--budget", "5"]);
    let message = text(output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(
        message.contains("method `Displacement` takes no --budget. Methods that take one: "),
        "{message}"
    );
    for budget in ["0", "-1", "nan", "inf"] {
        let output = detect(&boxes, &[&format!("--budget={budget}")]);
        assert_eq!(output.status.code(), Some(2), "{budget}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_a_closed_pipe_is_none() {
    let root = tempfile::tempdir().unwrap();
    let boxes = boxes(root.path());
    let run = |script: &str| {
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", script]).env("PROGRAM", env!("CARGO_BIN_EXE_trackfail")).env("BOXES", &boxes);
        shell.output().unwrap()
    };
    for format in ["csv", "json", "table"] {
        let output = run(&format!("\"$PROGRAM\" detect --boxes \"$BOXES\" --format {format} > /dev/full"));
        assert_eq!(output.status.code(), Some(1), "{format}");
        assert!(text(output.stderr).starts_with("error: stdout: "));
        // The reader is gone before the program writes.
        let closed = format!(
            "{{ sleep 1; \"$PROGRAM\" detect --boxes \"$BOXES\" --format {format}; echo $? >&2; }} | true"
        );
        assert_eq!(text(run(&closed).stderr), "0\n", "{format}");
    }
}
