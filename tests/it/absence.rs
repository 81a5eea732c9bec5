//! A tracker that says that its target is absent, and finds it again.

use crate::live::{answers, monitor};
use crate::tools::{Place, Ran, rows};
use serde_json::json;
use std::ops::Range;

/// Number of frames, and those in which the target is hidden and the tracker has no box; both count from 0.
const FRAMES: usize = 40;
const HIDDEN: Range<usize> = 20..25;

/// A method that raises an alarm where the target is hidden.
const COLORS: &str = "--method 'Object colors'";

/// A byte of a place in a texture.
fn noise(x: u32, y: u32, texture: u32) -> u8 {
    let sum = x.wrapping_mul(374_761_393).wrapping_add(y.wrapping_mul(668_265_263));
    let mixed = sum.wrapping_add(texture.wrapping_mul(2_246_822_519));
    ((mixed ^ (mixed >> 13)).wrapping_mul(1_274_126_177) >> 24) as u8
}

/// A red target of 24 x 18 pixels that moves over a smooth ground.
struct Scene(Place);

impl Scene {
    fn new() -> Self {
        let place = Place::new();
        let images = place.folder("img");
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
            picture.save(images.join(format!("{:04}.png", t + 1))).unwrap();
        }
        Self(place)
    }

    /// The tracker's boxes, exact but for the frames of `moved`, where they are on the ground.
    fn boxes(&self, moved: Range<usize>) -> Vec<Option<[usize; 4]>> {
        let right =
            |t: usize| if moved.contains(&t) { [10, 90, 24, 18] } else { [20 + 2 * t, 30 + t, 24, 18] };
        (0..FRAMES).map(|t| (!HIDDEN.contains(&t)).then(|| right(t))).collect()
    }

    /// `detect` on boxes, with `--fail-on-loss`.
    fn detect(&self, boxes: &[Option<[usize; 4]>], more: &str) -> Ran {
        let line = |b: &Option<[usize; 4]>| match b {
            Some([x, y, w, h]) => format!("{x},{y},{w},{h}\n"),
            None => "nan,nan,nan,nan\n".to_string(),
        };
        self.0.write("boxes.txt", boxes.iter().map(line).collect::<String>());
        let detect = "detect --base 0 --absent --fail-on-loss --frames img --boxes boxes.txt";
        self.0.run(&format!("{detect} {more}"))
    }

    /// The lines of the same boxes for `monitor`.
    fn lines(&self, boxes: &[Option<[usize; 4]>]) -> Vec<String> {
        let image = |t: usize| format!("img/{:04}.png", t + 1);
        let line =
            |(t, b): (usize, &Option<[usize; 4]>)| json!({"frame": image(t), "box": b}).to_string() + "\n";
        boxes.iter().enumerate().map(line).collect()
    }

    /// The states that `monitor` gives lines, each as its first letter.
    fn monitored(&self, arguments: &str, lines: &[String]) -> String {
        let told = answers(&monitor(&self.0, arguments, &lines.concat()).ends(0).out);
        told.iter().map(|answer| answer["state"].as_str().unwrap().chars().next().unwrap()).collect()
    }
}

/// The states of a track that is absent in frames 21 to 25, with those after that.
fn states(after: &str) -> String {
    "t".repeat(20) + &"a".repeat(5) + &after.repeat(15)
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
    for method in ["", COLORS] {
        let ran = scene.detect(&boxes, &format!("--format table --report page.html {method}")).ends(0);
        assert_eq!(ran.out, NEVER_LOST);
    }
    let page = scene.0.read("page.html");
    assert!(!page.contains("Lost since") && page.contains(NEVER_LOST.lines().next().unwrap()));

    let all = scene.detect(&boxes, &format!("{COLORS} --format csv")).ends(0).rows();
    let frames = |key: &str, value: &str| -> Vec<usize> {
        (1..=FRAMES).filter(|t| all[t - 1][key] == value).collect()
    };
    assert_eq!((frames("state", "absent"), frames("state", "lost")), (vec![21, 22, 23, 24, 25], vec![]));
    // The alarm of the absence is there, and ends with it.
    assert_eq!(frames("label", "1"), [21, 22, 23, 24, 25]);
    assert_eq!((frames("change", "1"), frames("change", "-1")), (vec![21], vec![26]));

    let lines = scene.lines(&boxes);
    ["", COLORS].into_iter().for_each(|method| assert_eq!(scene.monitored(method, &lines), states("t")));
    // The same in two parts, wherever the first one ends.
    for cut in [20, 22, 25, 26, 30] {
        let state = format!("{COLORS} --state {cut}.state");
        let parts = [&lines[..cut], &lines[cut..]].map(|part| scene.monitored(&state, part));
        assert_eq!(parts.concat(), states("t"), "{cut}");
    }
}

// The boxes are off the target from frame 26 on: the alarm is raised there, by the score of that very frame.
#[test]
fn a_tracker_that_comes_back_beside_its_target_is_lost() {
    let scene = Scene::new();
    let boxes = scene.boxes(25..FRAMES);
    let ran = scene.detect(&boxes, "--format table").ends(6);
    let rows: Vec<String> =
        ran.out.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    let want = [
        "Lost since frame 26. Start the tracker again at frame 26, or do not use its boxes from there on.",
        "",
        "from to state probability why",
        "21 25 absent no box",
        "26 40 lost 1.00 alarm: 1.00 > .91",
    ];
    assert_eq!(rows, want);
    assert_eq!(scene.monitored("", &scene.lines(&boxes)), states("l"));
}

// The boxes are off the target in frames 19 and 20: that loss is not over because the tracker then has no box.
#[test]
fn a_loss_from_before_an_absence_goes_on_after_it() {
    let scene = Scene::new();
    let boxes = scene.boxes(18..20);
    let csv = scene.detect(&boxes, "--format csv").ends(6).out;
    let states: String = rows(&csv).iter().filter_map(|row| row["state"].chars().next()).collect();
    assert_eq!(&states[18..27], "llaaaaall");
    assert!(states.ends_with("tttttt"), "{states}");
    assert_eq!(scene.monitored("", &scene.lines(&boxes)), states);
}

// The confidence is .9, and .05 where there is no box. Method Confidence alarms in single frames and waits for ten without an
// alarm, of which those after the absence need none.
#[test]
fn a_confidence_that_is_low_in_an_absence_is_no_alarm_after_it() {
    let scene = Scene::new();
    let boxes = scene.boxes(0..0);
    let confidence = |t: usize| if HIDDEN.contains(&t) { 0.05 } else { 0.9 };
    let text: String = (0..FRAMES).map(|t| format!("{}\n", confidence(t))).collect();
    scene.0.write("confidence.txt", text);
    let more = "--method Confidence --confidence confidence.txt --format table";
    assert_eq!(scene.detect(&boxes, more).ends(0).out, NEVER_LOST);
    let line = |(t, b): (usize, &Option<[usize; 4]>)| {
        json!({"box": b, "confidence": confidence(t)}).to_string() + "\n"
    };
    let lines: Vec<String> = boxes.iter().enumerate().map(line).collect();
    assert_eq!(scene.monitored("--method Confidence", &lines), states("t"));
}
