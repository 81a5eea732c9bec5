//! Data that is not what it should be: a cell fails with a reason, a score never changes silently.

use crate::tools::{rows, trackfail};
use std::path::{Path, PathBuf};

/// The frames that otb/Couple uses.
const FRAMES: usize = 140;

const SPEC: &str = r#"schema = 1
name = "mine/couple"
title = "One sequence"
protocol = "khalid2016/1"

[suites]
test = "otb-dtef20"

[[tracker]]
name = "replay"
results = "otb/OPE/MINE"
label = "mine"

[[method]]
name = "CovF"

[[table]]
name = "t"
rows = ["recall", "events"]
columns = "method"
"#;

/// A data root with one rendered sequence in the place of otb/Couple, and a tracker's boxes for it.
fn data_root(root: &Path) -> PathBuf {
    let rendered = root.join("rendered");
    trackfail()
        .args(["data", "render", "synthetic-otb", "--sequence", "Girl"])
        .arg(&rendered)
        .assert()
        .success();
    let sequence = root.join("data/otb/Couple");
    std::fs::create_dir_all(root.join("data/otb")).unwrap();
    std::fs::rename(rendered.join("Girl"), &sequence).unwrap();
    let truth = std::fs::read_to_string(sequence.join("groundtruth_rect.txt")).unwrap();
    let boxes: Vec<&str> = truth.lines().take(FRAMES).collect();
    write_boxes(root, &boxes);
    sequence
}

fn write_boxes(root: &Path, boxes: &[&str]) {
    let folder = root.join("data/results/otb/OPE/MINE");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("Couple.txt"), boxes.join("\n")).unwrap();
}

/// Exit code, stderr, and the row of the cell in scores.csv.
fn run(root: &Path) -> (i32, String, std::collections::BTreeMap<String, String>) {
    let spec = root.join("couple.toml");
    std::fs::write(&spec, SPEC).unwrap();
    let output = trackfail()
        .arg("run")
        .arg(&spec)
        .args(["--allow-missing", "--data-root"])
        .arg(root.join("data"))
        .arg("--results")
        .arg(root.join("results"))
        .arg("--reports")
        .arg(root.join("reports"))
        .output()
        .unwrap();
    let scores = root.join("results/mine/couple/scores.csv");
    // Reasons may hold commas; only the numbers before them matter here.
    let text = std::fs::read_to_string(scores).unwrap_or_default();
    let text: Vec<String> =
        text.lines().map(|l| l.split(',').take(17).collect::<Vec<_>>().join(",")).collect();
    let row = rows(&text.join("\n")).into_iter().find(|r| r["sequence"] == "Couple").unwrap_or_default();
    let code = output.status.code().unwrap();
    (code, String::from_utf8_lossy(&output.stderr).into_owned(), row)
}

#[test]
fn other_data_than_pinned_is_exit_code_3_and_the_report_says_so() {
    let root = tempfile::tempdir().unwrap();
    data_root(root.path());
    let (code, text, row) = run(root.path());
    assert_eq!(code, 3, "{text}");
    assert!(text.contains("not the data that datasets.lock pins: otb-dtef20/Couple"), "{text}");
    assert_eq!((row["status"].as_str(), row["events"].as_str()), ("ok", "0"));
    let page = std::fs::read_to_string(root.path().join("reports/mine/couple/index.html")).unwrap();
    assert!(page.contains("Not the data that datasets.lock pins"));
}

#[test]
fn a_truncated_frame_fails_its_cells_with_the_files_name() {
    let root = tempfile::tempdir().unwrap();
    let sequence = data_root(root.path());
    let frame = sequence.join("img/0100.png");
    let bytes = std::fs::read(&frame).unwrap();
    std::fs::write(&frame, &bytes[..bytes.len() / 2]).unwrap();
    let (code, text, row) = run(root.path());
    assert_eq!(code, 4, "{text}");
    assert!(text.contains("0100.png"), "{text}");
    assert_eq!(row["tp"], "");
    assert!(row["status"].starts_with("failed: "), "{row:?}");
}

#[test]
fn short_and_broken_result_files_fail_their_cells() {
    let root = tempfile::tempdir().unwrap();
    let sequence = data_root(root.path());
    let truth = std::fs::read_to_string(sequence.join("groundtruth_rect.txt")).unwrap();
    let good: Vec<&str> = truth.lines().take(FRAMES).collect();

    write_boxes(root.path(), &good[..FRAMES - 1]);
    let (code, text, row) = run(root.path());
    assert_eq!(code, 4, "{text}");
    assert!(text.contains("Couple.txt") && text.contains("139"), "{text}");
    assert_eq!(row["recall"], "");

    for wrong in ["NaN,1,2,3", "1,2,0,3", "1,2,3", "1,2,-3,4"] {
        let mut boxes = good.clone();
        boxes[6] = wrong;
        write_boxes(root.path(), &boxes);
        let (code, text, _) = run(root.path());
        assert_eq!(code, 4, "{wrong}: {text}");
        assert!(text.contains("Couple.txt") && text.contains("line 7"), "{wrong}: {text}");
    }

    // Boxes outside the image are no error: the target is simply not there.
    let mut boxes = good.clone();
    boxes[50] = "-500,-500,20,30";
    write_boxes(root.path(), &boxes);
    let (code, text, row) = run(root.path());
    assert_eq!(code, 3, "only the digest differs: {text}");
    assert_eq!(row["events"], "1");
}

#[test]
fn a_broken_ground_truth_is_exit_code_3_with_file_and_line() {
    let root = tempfile::tempdir().unwrap();
    let sequence = data_root(root.path());
    let path = sequence.join("groundtruth_rect.txt");
    let truth = std::fs::read_to_string(&path).unwrap();
    let mut lines: Vec<&str> = truth.lines().collect();
    lines[11] = "1,2,three,4";
    std::fs::write(&path, lines.join("\n")).unwrap();
    let (code, text, _) = run(root.path());
    assert_eq!(code, 3, "{text}");
    assert!(text.contains("groundtruth_rect.txt, line 12"), "{text}");
    std::fs::write(&path, "").unwrap();
    let (code, text, _) = run(root.path());
    assert_eq!(code, 3, "{text}");
    assert!(text.contains("groundtruth_rect.txt"), "{text}");
}
