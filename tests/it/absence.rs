//! A tracker that says that its target is absent, and finds it again: `detect` and `monitor` on the same boxes. The rules of
//! states and alarms are tested where they are.

use crate::live::{answers, monitor};
use crate::tools::{Place, words};
use serde_json::{Value, json};
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

/// A place with the frames of a red target of 24 x 18 pixels that moves over a smooth ground.
fn scene() -> Place {
    let place = Place::new();
    place.frames("img/0000.png", FRAMES, (160, 120), |t, x, y| {
        let (left, top) = (20 + 2 * t, 30 + t);
        let inside = (left..left + 24).contains(&x) && (top..top + 18).contains(&y);
        if inside && !HIDDEN.contains(&(t as usize)) {
            let (u, v) = ((x - left) / 3, (y - top) / 3);
            [200 + noise(u, v, 1) / 5, 40 + noise(u, v, 2) / 4, 30 + noise(u, v, 3) / 8]
        } else {
            let [right, down, both] = [x / 4, y / 4, (x + y) / 6].map(|v| v as u8);
            [70 + right + noise(x / 2, y / 2, 4) / 16, 110 + down, 90 + both]
        }
    });
    place
}

/// Writes the tracker's boxes, exact but for the frames of `moved`, where they are on the ground, and gives the lines of the
/// same boxes for `monitor`.
fn track(place: &Place, moved: Range<usize>) -> Vec<String> {
    let (mut text, mut lines) = (String::new(), Vec::new());
    for t in 0..FRAMES {
        let [x, y] = if moved.contains(&t) { [10, 90] } else { [20 + 2 * t, 30 + t] };
        let region = if HIDDEN.contains(&t) { Value::Null } else { json!([x, y, 24, 18]) };
        text += &if region.is_null() { "nan,nan,nan,nan\n".to_string() } else { format!("{x},{y},24,18\n") };
        lines.push(json!({"frame": format!("img/{:04}.png", t + 1), "box": region}).to_string() + "\n");
    }
    place.write("boxes.txt", text);
    lines
}

const DETECT: &str = "detect --base 0 --absent --fail-on-loss --frames img --boxes boxes.txt";

/// The states that `monitor` gives lines, each as its first letter.
fn monitored(place: &Place, arguments: &str, lines: &[String]) -> String {
    let told = answers(&monitor(place, arguments, &lines.concat()).ends(0).out);
    told.iter().map(|answer| answer["state"].as_str().unwrap().chars().next().unwrap()).collect()
}

/// The states of a track that is absent in frames 21 to 25, with those after that.
fn states(after: &str) -> String {
    "t".repeat(20) + &"a".repeat(5) + &after.repeat(15)
}

// The target is hidden in frames 21 to 25, where the tracker has no box, and the boxes of all others are exact: so it is
// absent there and never lost. (Called lost from frame 26 to 34, exit code 6, as long
// as the alarm of frames 22 to 25 was held for ten frames more.)
#[test]
fn a_target_that_is_found_again_after_an_absence_is_not_lost() {
    let place = scene();
    let lines = track(&place, 0..0);
    let verdict = "No loss found in 35 frames; 5 frames have no box.";
    for method in ["", COLORS] {
        let ran = place.run(&format!("{DETECT} --format table --report page.html {method}")).ends(0);
        let table: Vec<String> = ran.out.lines().map(|line| words(line).join(" ")).collect();
        assert_eq!(table, [verdict, "", "from to state probability why", "21 25 absent no box"]);
        assert_eq!(monitored(&place, method, &lines), states("t"));
    }
    let page = place.read("page.html");
    assert!(!page.contains("Lost since") && page.contains(verdict));

    let all = place.run(&format!("{DETECT} {COLORS} --format csv")).ends(0).rows();
    let frames = |key: &str, value: &str| -> Vec<usize> {
        (1..=FRAMES).filter(|t| all[t - 1][key] == value).collect()
    };
    assert_eq!((frames("state", "absent"), frames("state", "lost")), (vec![21, 22, 23, 24, 25], vec![]));
    // The alarm of the absence is there, and ends with it.
    assert_eq!(frames("label", "1"), [21, 22, 23, 24, 25]);
    assert_eq!((frames("change", "1"), frames("change", "-1")), (vec![21], vec![26]));
}

// Off the target from frame 26 on, the alarm is raised there, by the score of that very frame; a loss in frames 19 and 20 is
// not over because the tracker then has no box.
#[test]
fn a_loss_begins_after_an_absence_or_goes_on_after_it() {
    let place = scene();
    let lines = track(&place, 25..FRAMES);
    let ran = place.run(&format!("{DETECT} --format table")).ends(6);
    let ran = ran.says("Lost since frame 26. Start the tracker again at frame 26");
    assert_eq!(words(ran.out.lines().last().unwrap()).join(" "), "26 40 lost 1.00 alarm: 1.00 > .91");
    assert_eq!(monitored(&place, "", &lines), states("l"));

    let lines = track(&place, 18..20);
    let told = place.run(&format!("{DETECT} --format csv")).ends(6).rows();
    let states: String = told.iter().filter_map(|row| row["state"].chars().next()).collect();
    assert_eq!(&states[18..27], "llaaaaall");
    assert!(states.ends_with("tttttt"), "{states}");
    assert_eq!(monitored(&place, "", &lines), states);
}
