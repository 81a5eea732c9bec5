//! From a number of a table down to the frames, by the results alone.

use crate::tools::trackfail;
use serde_json::Value;
use std::path::Path;

const SPEC: &str = r#"schema = 1
name = "mine/small"
title = "t"
protocol = "khalid2016/1"
[suites]
test = "synthetic-vot"
[[tracker]]
name = "still"
[[method]]
name = "level"
signal.kind = "rgb-histogram"
detector = { kind = "level", below = 0.9 }
[[method]]
name = "signed"
signal.kind = "rgb-histogram"
detector = { kind = "level", below = 0.9 }
protocol = "sanmiguel2015/1"
[[method]]
name = "frames"
signal.kind = "rgb-histogram"
detector = { kind = "level", below = 0.9 }
protocol = "sanmiguel2015-segmentation/1"
[[table]]
name = "t"
rows = ["tp", "recall", "score_mean"]
columns = "method"
"#;

/// Exit code, stdout and stderr of `explain`.
fn explain(root: &Path, words: &[&str]) -> (i32, String, String) {
    let output = trackfail().current_dir(root).arg("explain").args(words).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

fn rows(root: &Path, words: &[&str]) -> Vec<Value> {
    let (code, stdout, stderr) = explain(root, &[words, &["--format", "json"]].concat());
    assert_eq!(code, 0, "{stderr}");
    serde_json::from_str(&stdout).unwrap()
}

#[test]
fn a_number_is_taken_apart_down_to_its_frames() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    std::fs::write(root.join("a.toml"), SPEC).unwrap();
    trackfail().current_dir(root).args(["run", "a.toml", "-q"]).assert().success();

    let pooled = std::fs::read_to_string(root.join("results/mine/small/measures.csv")).unwrap();
    for method in ["level", "signed", "frames"] {
        let line = pooled.lines().find(|l| l.split(',').nth(2) == Some(method)).unwrap();
        let counts: Vec<u64> = line.split(',').skip(6).take(4).map(|n| n.parse().unwrap()).collect();
        let parts = rows(root, &["t", "tp", method]);
        // As tables show the metric.
        assert_eq!(rows(root, &["t", "True positives", method]), parts);
        let of = |part: &Value, name: &str| part[name].as_u64().unwrap();
        for (name, total) in ["tp", "fp", "fn", "tn"].iter().zip(&counts) {
            assert_eq!(parts.iter().map(|p| of(p, name)).sum::<u64>(), *total, "{method} {name}");
        }
        // A sequence moves a count by its own count.
        assert!(parts.iter().all(|p| p["moves"].as_f64() == p["tp"].as_f64()));
        assert!(parts.is_sorted_by_key(|p| std::cmp::Reverse(of(p, "tp"))));

        // The events listed for each sequence add up to its counts.
        for part in &parts {
            let name = part["sequence"].as_str().unwrap();
            let listed = rows(root, &["mine/small/t", "tp", method, "--sequence", name]);
            if method == "frames" {
                for counted in ["tp", "fp", "fn", "tn"] {
                    let mine = listed.iter().filter(|r| r["counts as"] == counted);
                    assert_eq!(mine.map(|r| of(r, "frames")).sum::<u64>(), of(part, counted));
                }
                continue;
            }
            let count = |outcome: &str| listed.iter().filter(|r| r["outcome"] == outcome).count() as u64;
            let outcomes = ["hit", "false alarm", "missed"].map(count);
            assert_eq!(outcomes, ["tp", "fp", "fn"].map(|n| of(part, n)), "{method} {name}");
            let far = |r: &&Value| r["distance"].as_i64().is_some_and(|d| d.abs() > 5);
            assert!(!listed.iter().any(|r| far(&r)));
            // Every detection is marked in its frame.
            for detection in listed.iter().filter_map(|r| r["detection"].as_u64()).take(3) {
                let frame = detection.to_string();
                let words = ["t", "tp", method, "--sequence", name, "--frames", &frame];
                let frames = rows(root, &words);
                assert_eq!(frames.len(), 1);
                assert_eq!(frames[0]["frame"].as_u64(), Some(detection));
                assert!(frames[0]["mark"].as_str().unwrap().contains("detection: "), "{frames:?}");
            }
        }
    }
    // The mean of all scores does not come from counts; it is computed again from the frames.
    let parts = rows(root, &["t", "score_mean", "level"]);
    assert!(parts.iter().any(|p| p["moves"].as_f64().is_some_and(|m| m != 0.0)));
}

#[test]
fn unknown_names_are_refused_with_the_nearest_known_one() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    let refused = |words: &[&str], what: &str| {
        let (code, stdout, stderr) = explain(root, words);
        assert!(code == 2 && stdout.is_empty() && stderr.contains(what), "{words:?}: {code} {stderr}");
    };
    refused(&["t", "tp", "level"], "no finished experiment in results: nothing has been run there yet");
    std::fs::write(root.join("a.toml"), SPEC).unwrap();
    trackfail().current_dir(root).args(["run", "a.toml", "-q"]).assert().success();
    refused(&["x", "tp", "level"], "unknown table `x`");
    refused(&["mine/smal/t", "tp", "level"], "did you mean `mine/small`?");
    refused(&["mine/small/u", "tp", "level"], "did you mean `t`?");
    refused(&["t", "recal", "level"], "did you mean `recall`?");
    refused(&["t", "f1", "level"], "unknown row `f1`; there is: tp, recall, score_mean");
    refused(&["t", "score", "level"], "did you mean `score_mean`?");
    refused(&["small/t", "tp", "level"], "unknown finished experiment `small`; did you mean `mine/small`?");
    refused(&["t", "tp", "levl"], "did you mean `level`?");
    refused(&["t", "tp", "level", "--tracker", "stil"], "did you mean `still`?");
    refused(&["t", "tp", "level", "--sequence", "\u{1b}[2J"], "unknown sequence");
    refused(&["t", "tp", "level", "--sequence", "a", "--frames", "9-3"], "names no frames");
    let beyond = ["t", "tp", "level", "--sequence", "ball", "--frames", "5000-5001"];
    refused(&beyond, "--frames 5000-5001: ball has the frames 1 to ");
    refused(&["../t", "tp", "level"], "unknown finished experiment");
}
