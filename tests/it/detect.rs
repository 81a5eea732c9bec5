//! `trackfail detect` on one's own frames and boxes.

use crate::tools::{rows, trackfail};
use std::path::Path;

/// The first synthetic sequence on disk, with its ground truth as the tracker's boxes.
fn rendered(root: &Path) -> std::path::PathBuf {
    let target = root.join("suite");
    trackfail().args(["render", "synthetic-otb"]).arg(&target).assert().success();
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
    let output = detect(&sequence.join("img"), &boxes, &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().next().unwrap(), "frame,method,score,label,change");
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
    let again = detect(&sequence.join("img"), &with_header, &[]);
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
    trackfail().args(["render", "synthetic-otb", "--sequence", "Girl"]).arg(&target).assert().success();
    let sequence = target.join("Girl");
    let boxes = root.path().join("boxes.txt");
    std::fs::rename(sequence.join("groundtruth_rect.txt"), &boxes).unwrap();
    let clean = detect(&sequence, &boxes, &["--method", "RAW"]);
    assert_eq!(clean.status.code(), Some(0));
    std::fs::write(sequence.join("groundtruth_rect.txt"), "1,2\n").unwrap();
    let again = detect(&sequence, &boxes, &["--method", "RAW"]);
    assert_eq!(String::from_utf8_lossy(&again.stderr), "");
    assert_eq!(again.stdout, clean.stdout);
}
