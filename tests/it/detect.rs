//! `trackfail detect` on one's own frames and boxes.

use crate::tools::{rows, trackfail};
use std::path::Path;

/// The first synthetic sequence on disk, with its ground truth as the tracker's boxes.
fn rendered(root: &Path) -> std::path::PathBuf {
    let target = root.join("suite");
    trackfail().args(["data", "render", "synthetic-otb"]).arg(&target).assert().success();
    let mut folders: Vec<_> =
        std::fs::read_dir(&target).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_dir()).collect();
    folders.sort();
    folders.remove(0)
}

fn detect(frames: &Path, boxes: &Path, more: &[&str]) -> std::process::Output {
    let mut command = trackfail();
    command.arg("detect").arg("--frames").arg(frames).arg("--boxes").arg(boxes).args(more);
    command.output().unwrap()
}

#[test]
fn prints_a_row_for_each_frame_and_method() {
    let root = tempfile::tempdir().unwrap();
    let sequence = rendered(root.path());
    let boxes = sequence.join("groundtruth_rect.txt");
    let frames = std::fs::read_to_string(&boxes).unwrap().lines().count();
    let output = detect(&sequence.join("img"), &boxes, &["--all"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().next().unwrap(), "frame,method,score,label,change,state");
    let all = rows(&text);
    for method in ["DTEF", "NAIVE", "RAW", "CovF", "RgbHist", "RLHist"] {
        let mine: Vec<_> = all.iter().filter(|r| r["method"] == method).collect();
        assert_eq!(mine.len(), frames, "{method}");
        // Changes are the differences of the labels.
        let mut label = 0;
        for row in mine {
            let now: i32 = row["label"].parse().unwrap();
            assert_eq!(row["change"].parse::<i32>().unwrap(), now - label);
            label = now;
        }
    }

    // A header line and CRLF change nothing; neither does a zero base with shifted boxes.
    let text_boxes = std::fs::read_to_string(&boxes).unwrap();
    let with_header = root.path().join("header.csv");
    std::fs::write(&with_header, format!("x,y,w,h\r\n{}", text_boxes.replace('\n', "\r\n"))).unwrap();
    let again = detect(&sequence.join("img"), &with_header, &["--all"]);
    assert_eq!(String::from_utf8(again.stdout).unwrap(), text);

    let one = detect(&sequence.join("img"), &boxes, &["--method", "CovF"]);
    let one = String::from_utf8(one.stdout).unwrap();
    let expected: Vec<&str> = text.lines().filter(|l| l.contains(",CovF,")).collect();
    assert_eq!(one.lines().skip(1).collect::<Vec<_>>(), expected);

    // Input errors name file and line.
    let short = root.path().join("short.txt");
    std::fs::write(&short, "1,2,3,4\n").unwrap();
    let output = detect(&sequence.join("img"), &short, &[]);
    assert_eq!(output.status.code(), Some(3));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("1 boxes") && message.contains(&format!("has {frames} frames")), "{message}");
    let nan = root.path().join("nan.txt");
    std::fs::write(&nan, "1,2,3,4\nNaN,2,3,4\n").unwrap();
    let output = detect(&sequence.join("img"), &nan, &[]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3));
    assert!(message.contains("nan.txt, line 2"), "{message}");
    let output = detect(&sequence.join("img"), &boxes, &["--method", "DTFE"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("did you mean `DTEF`?"));
}

#[test]
fn nothing_that_lies_beside_the_frames_matters() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("suite");
    trackfail()
        .args(["data", "render", "synthetic-otb", "--sequence", "Girl"])
        .arg(&target)
        .assert()
        .success();
    let sequence = target.join("Girl");
    let boxes = root.path().join("boxes.txt");
    std::fs::rename(sequence.join("groundtruth_rect.txt"), &boxes).unwrap();
    let clean = detect(&sequence, &boxes, &["--method", "RAW"]);
    assert_eq!(clean.status.code(), Some(0));
    std::fs::write(sequence.join("groundtruth_rect.txt"), "1,2\n").unwrap();
    let again = detect(&sequence, &boxes, &["--method", "RAW", "--boxes-format", "xywh", "--base", "1"]);
    assert_eq!(String::from_utf8_lossy(&again.stderr), "");
    assert_eq!(again.stdout, clean.stdout);
}

/// A rendered sequence and the box of its first frame.
fn drawn(root: &Path, name: &str) -> (std::path::PathBuf, String) {
    let target = root.join("suite");
    trackfail().args(["data", "render", "synthetic-d1", "--sequence", name]).arg(&target).assert().success();
    let truth = std::fs::read_to_string(target.join(name).join("groundtruth_rect.txt")).unwrap();
    (target.join(name).join("img"), truth.lines().next().unwrap().to_string())
}

fn follow(frames: &Path, first: &str, more: &[&str]) -> std::process::Output {
    trackfail().arg("detect").arg("--frames").arg(frames).args(["--init", first]).args(more).output().unwrap()
}

#[test]
fn a_target_is_followed_and_doubts_are_told_frame_by_frame() {
    let root = tempfile::tempdir().unwrap();
    let (frames, first) = drawn(root.path(), "car-shade");
    let boxes = root.path().join("boxes.txt");
    let output = follow(&frames, &first, &["--all", "--save-boxes", boxes.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let all = rows(&text);
    let count = std::fs::read_dir(&frames).unwrap().count();
    for method in ["DTEF", "AVU", "Two-MChi", "M-model", "ARTE", "ARTE*"] {
        assert_eq!(all.iter().filter(|r| r["method"] == method).count(), count, "{method}");
    }
    assert!(all.iter().all(|r| r["method"] != "EmpTh"));
    // The target is lost for a while, which ARTE* does not miss.
    assert!(all.iter().any(|r| r["method"] == "ARTE*" && r["label"] == "1"));

    // The boxes that were saved are those that were judged.
    assert_eq!(std::fs::read_to_string(&boxes).unwrap().lines().count(), count);
    let judged = detect(&frames, &boxes, &["--method", "RgbHist"]);
    assert!(judged.status.success(), "{}", String::from_utf8_lossy(&judged.stderr));
    let of = |text: &str| -> Vec<f64> {
        let mine = rows(text).into_iter().filter(|r| r["method"] == "RgbHist");
        mine.map(|r| r["score"].parse().unwrap()).collect()
    };
    for (a, b) in of(&String::from_utf8_lossy(&judged.stdout)).into_iter().zip(of(&text)) {
        // The file counts pixels from 1, which costs the last digit of a coordinate.
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }

    // The judgement of a frame does not change when the video is cut after it.
    let cut = root.path().join("cut");
    std::fs::create_dir(&cut).unwrap();
    let mut files: Vec<_> = std::fs::read_dir(&frames).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    for file in &files[..count * 2 / 3] {
        std::fs::copy(file, cut.join(file.file_name().unwrap())).unwrap();
    }
    let only = ["--method", "ARTE*", "--method", "ARTE"];
    let part = String::from_utf8(follow(&cut, &first, &only).stdout).unwrap();
    let whole = String::from_utf8(follow(&frames, &first, &only).stdout).unwrap();
    for method in [",ARTE*,", ",ARTE,"] {
        let of = |text: &str| -> Vec<String> {
            text.lines().filter(|l| l.contains(method)).map(String::from).collect()
        };
        assert_eq!(of(&part), of(&whole)[..count * 2 / 3], "{method}");
    }
}

#[test]
fn what_cannot_be_judged_is_told() {
    let root = tempfile::tempdir().unwrap();
    let (frames, first) = drawn(root.path(), "car-shade");
    let refused = |more: &[&str], code: i32, words: &str| {
        let output = follow(&frames, &first, more);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{more:?}: {message}");
        assert!(message.contains(words), "{more:?}: {message}");
    };
    refused(&["--method", "ARTE*", "--tracker", "ncc"], 2, "needs a tracker with a posterior");
    refused(&["--method", "EmpTh"], 2, "trained on annotated sequences");
    refused(&["--method", "AVU", "--params", "{ particles = 50 }"], 2, "give --model");
    refused(&["--tracker", "kfc"], 2, "did you mean `kcf`?");
    refused(&["--tracker", "replay"], 2, "ground truth or result files");
    let bad = root.path().join("model.json");
    std::fs::write(&bad, "{ \"model\": { \"consistency\": 3 } }").unwrap();
    refused(&["--method", "AVU", "--model", bad.to_str().unwrap()], 3, "no model of consistency");
    std::fs::write(&bad, "{}").unwrap();
    refused(&["--method", "AVU", "--model", bad.to_str().unwrap()], 3, "holds no learned model");
    let output = follow(&frames, "5000,1,9,9", &[]);
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("--init 5000,1,9,9 lies outside of the frame of 320x240 pixels"), "{message}");
    assert!(
        message.contains("which is number 1 of ") && message.contains(frames.to_str().unwrap()),
        "{message}"
    );
    for wrong in ["1,2,3", "a,b,c,d", "1,2,3,4\n5,6,7,8"] {
        let output = follow(&frames, wrong, &[]);
        assert_eq!(output.status.code(), Some(2), "{wrong}");
    }
    let boxes = root.path().join("boxes.txt");
    std::fs::write(&boxes, "1,2,3,4\n").unwrap();
    let output = detect(&frames, &boxes, &["--method", "ARTE*"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("give --init instead of --boxes"));
}
