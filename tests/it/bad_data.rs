//! Data that is not what it should be: a cell fails with a reason, a score never changes silently.

use crate::tools::{Place, Ran, Row, rows, sequence};

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

/// A data root with another sequence in the place of otb/Couple, and a tracker's boxes for it, which are returned.
fn data_root() -> (Place, Vec<String>) {
    let place = Place::with(&[("couple.toml", SPEC)]);
    sequence(&place, "Couple", 140);
    let boxes: Vec<String> = place.read(TRUTH).lines().map(String::from).collect();
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
fn a_cell_of_bad_data_fails_with_the_name_of_the_file() {
    let (place, good) = data_root();
    let (ran, row) = run(&place);
    ran.ends(3).tells("not the data that datasets.lock pins: otb-dtef20/Couple");
    assert_eq!((row["status"].as_str(), row["events"].as_str()), ("ok", "0"));
    assert!(place.read("reports/mine/couple/index.html").contains("Not the data that datasets.lock pins"));

    // Boxes outside the image are no error: the target is simply not there, and only the digest differs.
    let with = |line: &str| {
        let mut boxes = good.clone();
        boxes[50] = line.into();
        write_boxes(&place, &boxes);
        run(&place)
    };
    let (ran, row) = with("-500,-500,20,30");
    ran.ends(3);
    assert_eq!(row["events"], "1");
    let (ran, row) = with("1,2,0,3");
    ran.ends(4).tells("Couple.txt").tells("line 51");
    assert_eq!(row["recall"], "");

    write_boxes(&place, &good);
    let frame = "data/otb/Couple/img/0100.png";
    let bytes = place.bytes(frame);
    place.write(frame, &bytes[..bytes.len() / 2]);
    let (ran, row) = run(&place);
    ran.ends(4).tells("0100.png");
    assert!(row["tp"].is_empty() && row["status"].starts_with("failed: "), "{row:?}");
    place.write(frame, bytes);

    let truth = place.read(TRUTH);
    let mut lines: Vec<&str> = truth.lines().collect();
    lines[11] = "1,2,three,4";
    place.write(TRUTH, lines.join("\n"));
    run(&place).0.ends(3).tells("groundtruth_rect.txt, line 12");
    place.write(TRUTH, "");
    run(&place).0.ends(3).tells("groundtruth_rect.txt");
}
