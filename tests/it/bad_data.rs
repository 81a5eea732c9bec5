//! Data that is not what it should be: a cell fails with a reason, a score never changes silently.

use crate::tools::{Place, Ran, Row, rows};

/// The frames that otb/Couple uses.
const FRAMES: usize = 140;

const SPEC: &str = r#"schema = 1
name = "mine/couple"
title = "One sequence"
protocol = "khalid2016/1"
suites.test = "otb-dtef20"
tracker = [{ name = "replay", results = "otb/OPE/MINE", label = "mine" }]
method = [{ name = "CovF" }]
table = [{ name = "t", rows = ["recall", "events"], columns = "method" }]
"#;

const TRUTH: &str = "data/otb/Couple/groundtruth_rect.txt";

/// A data root with one rendered sequence in the place of otb/Couple, and a tracker's boxes for it, which are returned.
fn data_root() -> (Place, Vec<String>) {
    let place = Place::with(&[("couple.toml", SPEC)]);
    let mut boxes = place.render("synthetic-otb", "Girl");
    place.folder("data/otb");
    std::fs::rename(place.path("suite/Girl"), place.path("data/otb/Couple")).unwrap();
    boxes.truncate(FRAMES);
    write_boxes(&place, &boxes);
    (place, boxes)
}

fn write_boxes(place: &Place, boxes: &[String]) {
    place.write("data/results/otb/OPE/MINE/Couple.txt", boxes.join("\n"));
}

/// The end of a run, and the row of the cell in scores.csv.
fn run(place: &Place) -> (Ran, Row) {
    let ran = place.run("run couple.toml --allow-missing --data-root data");
    let text = std::fs::read_to_string(place.path("results/mine/couple/scores.csv")).unwrap_or_default();
    let row = rows(&text).into_iter().find(|r| r["sequence"] == "Couple").unwrap_or_default();
    (ran, row)
}

#[test]
fn other_data_than_pinned_is_exit_code_3_and_the_report_says_so() {
    let (place, _) = data_root();
    let (ran, row) = run(&place);
    ran.ends(3).tells("not the data that datasets.lock pins: otb-dtef20/Couple");
    assert_eq!((row["status"].as_str(), row["events"].as_str()), ("ok", "0"));
    assert!(place.read("reports/mine/couple/index.html").contains("Not the data that datasets.lock pins"));
}

#[test]
fn a_truncated_frame_fails_its_cells_with_the_files_name() {
    let (place, _) = data_root();
    let bytes = place.bytes("data/otb/Couple/img/0100.png");
    place.write("data/otb/Couple/img/0100.png", &bytes[..bytes.len() / 2]);
    let (ran, row) = run(&place);
    ran.ends(4).tells("0100.png");
    assert!(row["tp"].is_empty() && row["status"].starts_with("failed: "), "{row:?}");
}

#[test]
fn short_and_broken_result_files_fail_their_cells() {
    let (place, good) = data_root();
    write_boxes(&place, &good[..FRAMES - 1]);
    let (ran, row) = run(&place);
    ran.ends(4).tells("Couple.txt").tells("139");
    assert_eq!(row["recall"], "");
    let with = |t: usize, line: &str| {
        let mut boxes = good.clone();
        boxes[t] = line.into();
        write_boxes(&place, &boxes);
        run(&place)
    };
    for wrong in ["NaN,1,2,3", "1,2,0,3", "1,2,3", "1,2,-3,4"] {
        with(6, wrong).0.ends(4).tells("Couple.txt").tells("line 7");
    }
    // Boxes outside the image are no error: the target is simply not there, and only the digest differs.
    let (ran, row) = with(50, "-500,-500,20,30");
    ran.ends(3);
    assert_eq!(row["events"], "1");
}

#[test]
fn a_broken_ground_truth_is_exit_code_3_with_file_and_line() {
    let (place, _) = data_root();
    let truth = place.read(TRUTH);
    let mut lines: Vec<&str> = truth.lines().collect();
    lines[11] = "1,2,three,4";
    place.write(TRUTH, lines.join("\n"));
    run(&place).0.ends(3).tells("groundtruth_rect.txt, line 12");
    place.write(TRUTH, "");
    run(&place).0.ends(3).tells("groundtruth_rect.txt");
}
