//! Data that is not what it should be: a cell fails with a reason, a score never changes silently.

use crate::tools::{Place, experiment, sequence};

const SPEC: &str = r#"tracker = [{ name = "replay", results = "otb/OPE/MINE", label = "mine" }]
method = [{ name = "CovF" }]
table = [{ name = "t", rows = ["recall", "events"], columns = "method" }]
"#;

const TRUTH: &str = "data/otb/Couple/groundtruth_rect.txt";
const BOXES: &str = "data/results/otb/OPE/MINE/Couple.txt";
const FRAME: &str = "data/otb/Couple/img/0100.png";

#[test]
fn a_cell_of_bad_data_fails_with_the_name_of_the_file() {
    // Another sequence in the place of otb/Couple, and a tracker's boxes for it.
    let place = Place::with(&[("couple.toml", &experiment("mine/couple", "otb-dtef20", SPEC))]);
    sequence(&place, "Couple", 140);
    place.write(BOXES, place.bytes(TRUTH));
    let run = || place.run("run couple.toml --allow-missing --data-root data");
    let row = || {
        let rows = place.rows("results/mine/couple/scores.csv");
        rows.into_iter().find(|row| row["sequence"] == "Couple").unwrap()
    };
    run().ends(3).tells("not the data that datasets.lock pins: otb-dtef20/Couple");
    assert_eq!((row()["status"].as_str(), row()["events"].as_str()), ("ok", "0"));
    assert!(place.read("reports/mine/couple/index.html").contains("Not the data that datasets.lock pins"));

    let with = |file: &str, line: usize, text: &str| {
        let good = place.read(file);
        let lines = good.lines().enumerate();
        let lines: Vec<&str> = lines.map(|(k, good)| if k + 1 == line { text } else { good }).collect();
        lines.join("\n").into_bytes()
    };
    let frame = place.bytes(FRAME);
    for (file, bad, code, words, cell) in [
        // Boxes outside the image are no error: the target is simply not there, and only the digest differs.
        (BOXES, with(BOXES, 51, "-500,-500,20,30"), 3, ["", ""], Some(("events", "1"))),
        (BOXES, with(BOXES, 51, "1,2,0,3"), 4, ["Couple.txt", "line 51"], Some(("recall", ""))),
        (FRAME, frame[..frame.len() / 2].to_vec(), 4, ["0100.png", ""], Some(("tp", ""))),
        (TRUTH, with(TRUTH, 12, "1,2,three,4"), 3, ["groundtruth_rect.txt, line 12", ""], None),
        (TRUTH, Vec::new(), 3, ["groundtruth_rect.txt", ""], None),
    ] {
        let good = place.bytes(file);
        place.write(file, bad);
        run().ends(code).tells(words[0]).tells(words[1]);
        if let Some((column, value)) = cell {
            let is_failed = row()["status"].starts_with("failed: ");
            assert_eq!((row()[column].as_str(), is_failed), (value, code == 4), "{:?}", row());
        }
        place.write(file, good);
    }
}
