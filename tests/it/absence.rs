//! A tracker that says that its target is absent, and finds it again.

use crate::tools::{rows, trackfail};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Number of frames, and those in which the target is hidden and the tracker has no box; both count from 0.
const FRAMES: usize = 40;
const HIDDEN: std::ops::Range<usize> = 20..25;

/// A method that raises an alarm where the target is hidden.
const COLORS: [&str; 2] = ["--method", "Object colors"];

/// A byte of a place in a texture.
fn noise(x: u32, y: u32, texture: u32) -> u8 {
    let sum = x.wrapping_mul(374_761_393).wrapping_add(y.wrapping_mul(668_265_263));
    let mixed = sum.wrapping_add(texture.wrapping_mul(2_246_822_519));
    ((mixed ^ (mixed >> 13)).wrapping_mul(1_274_126_177) >> 24) as u8
}

/// A red target of 24 x 18 pixels that moves over a smooth ground.
struct Scene {
    root: tempfile::TempDir,
}

impl Scene {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir(root.path().join("img")).unwrap();
        for t in 0..FRAMES {
            let (left, top) = (20 + 2 * t as u32, 30 + t as u32);
            let picture = image::RgbImage::from_fn(160, 120, |x, y| {
                let inside = (left..left + 24).contains(&x) && (top..top + 18).contains(&y);
                image::Rgb(if inside && !HIDDEN.contains(&t) {
                    let (u, v) = ((x - left) / 3, (y - top) / 3);
                    [200 + noise(u, v, 1) / 5, 40 + noise(u, v, 2) / 4, 30 + noise(u, v, 3) / 8]
                } else {
                    let [right, down, both] = [x / 4, y / 4, (x + y) / 6].map(|v| v as u8);
                    [70 + right + noise(x / 2, y / 2, 4) / 16, 110 + down, 90 + both]
                })
            });
            picture.save(root.path().join(format!("img/{:04}.png", t + 1))).unwrap();
        }
        Self { root }
    }

    /// The tracker's boxes, exact but for the frames of `moved`, where they are on the ground.
    fn boxes(&self, moved: std::ops::Range<usize>) -> Vec<Option<[usize; 4]>> {
        let right =
            |t: usize| if moved.contains(&t) { [10, 90, 24, 18] } else { [20 + 2 * t, 30 + t, 24, 18] };
        (0..FRAMES).map(|t| (!HIDDEN.contains(&t)).then(|| right(t))).collect()
    }

    /// Exit code and stdout of `detect` on boxes, with `--fail-on-loss`.
    fn detect(&self, boxes: &[Option<[usize; 4]>], more: &[&str]) -> (Option<i32>, String) {
        let path = self.root.path().join("boxes.txt");
        let line = |b: &Option<[usize; 4]>| match b {
            Some([x, y, w, h]) => format!("{x},{y},{w},{h}\n"),
            None => "nan,nan,nan,nan\n".to_string(),
        };
        std::fs::write(&path, boxes.iter().map(line).collect::<String>()).unwrap();
        let mut command = trackfail();
        command.args(["detect", "--base", "0", "--absent", "--fail-on-loss", "--frames"]);
        command.arg(self.root.path().join("img")).arg("--boxes").arg(path).args(more);
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    }

    /// The lines of the same boxes for `monitor`.
    fn lines(&self, boxes: &[Option<[usize; 4]>]) -> Vec<String> {
        let image = |t: usize| -> PathBuf { self.root.path().join(format!("img/{:04}.png", t + 1)) };
        boxes
            .iter()
            .enumerate()
            .map(|(t, b)| json!({"frame": image(t), "box": b}).to_string() + "\n")
            .collect()
    }
}

/// The states that `monitor` gives lines, each as its first letter.
fn monitored(arguments: &[&str], lines: &[String]) -> String {
    let output = trackfail().arg("monitor").args(arguments).write_stdin(lines.concat()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let state = |line: &str| {
        let answer: Value = serde_json::from_str(line).unwrap();
        answer["state"].as_str().and_then(|state| state.chars().next()).unwrap()
    };
    text.lines().map(state).collect()
}

/// The verdict on a track that is absent in frames 21 to 25 and never lost.
const NEVER_LOST: &str = concat!(
    "No loss found in 35 frames; 5 frames have no box.\n\n",
    " from  to  state   probability  why\n",
    " 21    25  absent               no box\n",
);

// The target is hidden in frames 21 to 25, where the tracker has no box, and the boxes of all others are exact: so it is
// absent there and never lost. (Called lost from frame 26 to 34, exit code 6, as long
// as the alarm of frames 22 to 25 was held for ten frames more.)
#[test]
fn a_target_that_is_found_again_after_an_absence_is_not_lost() {
    let scene = Scene::new();
    let boxes = scene.boxes(0..0);
    let page = scene.root.path().join("page.html");
    let more = ["--format", "table", "--report", page.to_str().unwrap()];
    for method in [&[][..], &COLORS] {
        assert_eq!(scene.detect(&boxes, &[&more, method].concat()), (Some(0), NEVER_LOST.to_string()));
    }
    let page = std::fs::read_to_string(page).unwrap();
    assert!(!page.contains("Lost since") && page.contains(NEVER_LOST.lines().next().unwrap()));

    let (code, csv) = scene.detect(&boxes, &[&COLORS[..], &["--format", "csv"]].concat());
    let all = rows(&csv);
    let frames = |key: &str, value: &str| -> Vec<usize> {
        (1..=FRAMES).filter(|t| all[t - 1][key] == value).collect()
    };
    assert_eq!(code, Some(0));
    assert_eq!((frames("state", "absent"), frames("state", "lost")), (vec![21, 22, 23, 24, 25], vec![]));
    // The alarm of the absence is there, and ends with it.
    assert_eq!(frames("label", "1"), [21, 22, 23, 24, 25]);
    assert_eq!((frames("change", "1"), frames("change", "-1")), (vec![21], vec![26]));

    let lines = scene.lines(&boxes);
    let states = "t".repeat(20) + &"a".repeat(5) + &"t".repeat(15);
    assert_eq!((monitored(&[], &lines), monitored(&COLORS, &lines)), (states.clone(), states.clone()));
    // The same in two parts, wherever the first one ends.
    for cut in [20, 22, 25, 26, 30] {
        let state = scene.root.path().join(format!("{cut}.state"));
        let state = [&COLORS[..], &["--state", state.to_str().unwrap()]].concat();
        let parts = [&lines[..cut], &lines[cut..]].map(|part| monitored(&state, part));
        assert_eq!(parts.concat(), states, "{cut}");
    }
}

// The boxes are off the target from frame 26 on: the alarm is raised there, by the score of that very frame.
#[test]
fn a_tracker_that_comes_back_beside_its_target_is_lost() {
    let scene = Scene::new();
    let boxes = scene.boxes(25..FRAMES);
    let (code, verdict) = scene.detect(&boxes, &["--format", "table"]);
    let rows: Vec<String> =
        verdict.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    let want = [
        "Lost since frame 26. Start the tracker again at frame 26, or do not use its boxes from there on.",
        "",
        "from to state probability why",
        "21 25 absent no box",
        "26 40 lost 1.00 alarm: 1.00 > .91",
    ];
    assert_eq!((code, rows.iter().map(String::as_str).collect::<Vec<_>>()), (Some(6), want.to_vec()));
    let states = "t".repeat(20) + &"a".repeat(5) + &"l".repeat(15);
    assert_eq!(monitored(&[], &scene.lines(&boxes)), states);
}

// The boxes are off the target in frames 19 and 20: that loss is not over because the tracker then has no box.
#[test]
fn a_loss_from_before_an_absence_goes_on_after_it() {
    let scene = Scene::new();
    let boxes = scene.boxes(18..20);
    let (code, csv) = scene.detect(&boxes, &["--format", "csv"]);
    assert_eq!(code, Some(6));
    let states: String = rows(&csv).iter().filter_map(|row| row["state"].chars().next()).collect();
    assert_eq!(&states[18..27], "llaaaaall");
    assert!(states.ends_with("tttttt"), "{states}");
    assert_eq!(monitored(&[], &scene.lines(&boxes)), states);
}

// The confidence is .9, and .05 where there is no box. Method Confidence alarms in single frames and waits for ten without an
// alarm, of which those after the absence need none.
#[test]
fn a_confidence_that_is_low_in_an_absence_is_no_alarm_after_it() {
    let scene = Scene::new();
    let boxes = scene.boxes(0..0);
    let path = scene.root.path().join("confidence.txt");
    let confidence = |t: usize| if HIDDEN.contains(&t) { 0.05 } else { 0.9 };
    let text: String = (0..FRAMES).map(|t| format!("{}\n", confidence(t))).collect();
    std::fs::write(&path, text).unwrap();
    let more = ["--method", "Confidence", "--confidence", path.to_str().unwrap(), "--format", "table"];
    let (code, verdict) = scene.detect(&boxes, &more);
    assert_eq!((code, verdict.as_str()), (Some(0), NEVER_LOST));
    let line = |(t, b): (usize, &Option<[usize; 4]>)| {
        json!({"box": b, "confidence": confidence(t)}).to_string() + "\n"
    };
    let lines: Vec<String> = boxes.iter().enumerate().map(line).collect();
    let states = "t".repeat(20) + &"a".repeat(5) + &"t".repeat(15);
    assert_eq!(monitored(&["--method", "Confidence"], &lines), states);
}
