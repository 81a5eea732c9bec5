//! Outputs of `trackfail detect`: a verdict for people, formats for programs, exit codes, files.

use crate::tools::{Place, Ran, needs, rows, words};
use serde_json::Value;

/// Boxes that stand still, jump to a far place in frame 41, and stand there.
fn place() -> Place {
    let line = |t: usize| if t < 41 { "10,10,20,20\n" } else { "200,10,20,20\n" };
    let text: String = (1..=60).map(line).collect();
    Place::with(&[("boxes.txt", &text)])
}

fn detect(place: &Place, more: &str) -> Ran {
    place.run(&format!("detect --method Displacement --boxes boxes.txt {more}"))
}

const VERDICT: &str = "Lost since frame 41; not surely found again. Start the tracker again at frame 41, or do not use \
                       its boxes from there on.";

#[test]
fn a_verdict_a_table_and_json() {
    let place = place();
    let detect = |more: &str| detect(&place, more).out;
    let one = detect("--format table");
    let (sentences, table) = one.split_once("\n\n").unwrap();
    assert_eq!(sentences, VERDICT);
    let words = |line: &str| words(line).join(" ");
    let row = "41 50 lost alarm: 9.50 > 1.00; then not surely found again";
    assert_eq!(table.lines().map(words).collect::<Vec<_>>(), ["from to state probability why", row]);
    let two = detect("--method Scale --format table");
    let lines: Vec<&str> = two.lines().collect();
    assert_eq!((lines[0], lines[1], lines[4]), (VERDICT, "", ""));
    assert_eq!(words(lines[6]), "Displacement 1 10 of 60 41 tracking");
    assert_eq!(words(lines[7]), "Scale 0 0 of 60 tracking");

    // Output into a pipe is CSV unless the user wants something else.
    let csv = detect("");
    assert_eq!(csv, detect("--format csv"));
    let all = rows(&csv);
    let json: Value = serde_json::from_str(&detect("--format json")).unwrap();
    let method = &json["tracks"][0]["methods"][0];
    assert!(json["tracks"][0]["target"].is_null());
    assert_eq!(method["verdict"], VERDICT);
    assert_eq!(method["lost"], serde_json::json!([[41, 50]]));
    assert_eq!((&method["threshold"], method["frames"].as_array().unwrap().len()), (&1.0.into(), all.len()));
    assert!(all.iter().enumerate().all(|(t, row)| (row["state"] == "lost") == (40..50).contains(&t)));
    for (row, frame) in all.iter().zip(method["frames"].as_array().unwrap()) {
        assert_eq!(row["state"], frame["state"].as_str().unwrap());
        assert_eq!(row["score"].parse::<f64>().unwrap(), frame["score"].as_f64().unwrap());
    }
}

#[test]
fn a_loss_may_be_an_exit_code() {
    let place = place();
    let lost = detect(&place, "--fail-on-loss --format table").ends(6);
    assert!(lost.out.starts_with(&format!("{VERDICT}\n\n from ")), "{}", lost.out);
    assert!(lost.err.ends_with(&format!("\nerror: {VERDICT}\n")), "{}", lost.err);
    place.write("confidence.txt", "0.5\n".repeat(59));
    detect(&place, "--confidence confidence.txt").ends(3).tells("confidence.txt: 59 values for 60 boxes");
    place.write("boxes.txt", "10,10,20,20\n".repeat(9));
    detect(&place, "--fail-on-loss").ends(0);
    // Tiny sides have an exponent.
    image::RgbImage::new(40, 30).save(place.path("1.png")).unwrap();
    place.write("boxes.txt", "205,151,1e-300,50\n");
    detect(&place, "--frames 1.png").tells("the box 205,151,1e-300,50 (x,y,w,h) lies outside");
    let help = place.run("--help").out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("6 the target is lost (`detect --fail-on-loss`)"), "{help}");
}

#[test]
fn a_budget_is_for_methods_that_take_one() {
    let place = place();
    let words = "method `Displacement` takes no budget of false alarms; methods that take one: ";
    detect(&place, "--budget 5").ends(2).tells(words);
    // Without a method it is the recommended one of those that take one, also where confidence alone would choose another.
    place.write("confidence.txt", "0.5\n".repeat(60));
    let chosen = place.run("detect --budget 5 --boxes boxes.txt --confidence confidence.txt").ends(0);
    assert!(chosen.rows().iter().all(|row| row["method"] == "Fused boxes"));
    for line in ["detect --boxes - --budget=0", "detect --boxes - --budget=nan", "monitor --budget=-1"] {
        Ran::of(place.command(line).write_stdin("")).ends(2).tells("it is a number above 0");
    }
    // A larger one lowers the threshold.
    let [small, large] = ["1", "50"].map(|budget| {
        let line = "detect --method 'Fused boxes' --format json --boxes boxes.txt --budget";
        let ran = place.run(&format!("{line} {budget}")).ends(0);
        let verdict: Value = serde_json::from_str(&ran.out).unwrap();
        verdict["tracks"][0]["methods"][0]["threshold"].as_f64().unwrap()
    });
    assert!(0.0 < large && large < small && small < 1.0, "{large} {small}");
}

/// The frames and boxes of a rendered sequence of 30 frames, whose box jumps away in the twentieth.
fn clip() -> Place {
    let place = Place::new();
    let mut lines = crate::tools::clip(&place, 30);
    lines[19..].fill("2,2,9,9".into());
    place.write("clip.txt", lines.join("\n"));
    place
}

/// The words that draw it.
const DRAW: &str = "detect --method Displacement --boxes clip.txt --frames suite/Girl/img";

#[test]
fn a_page_a_figure_and_drawn_frames() {
    let place = clip();
    let ran = place.run(&format!("{DRAW} --report page.html --plot plot.svg --annotate drawn")).ends(0);
    assert_eq!(ran.rows().len(), 30);
    let page = place.read("page.html");
    assert!(page.contains("Lost since frame 20; ") && page.contains("data:image/jpeg;base64,"));
    let svg = place.read("plot.svg");
    assert!(svg.starts_with("<svg ") && svg.contains("Lost since frame 20"));
    let names = place.list("drawn");
    assert!(names.len() == 30 && names[0].ends_with("000001.png") && names[29].ends_with("000030.png"));
    let [before, after] = [9, 24].map(|k: usize| image::open(&names[k]).unwrap().to_rgb8());
    assert_eq!(before.dimensions(), (160, 120));
    let has = |frame: &image::RgbImage, rgb: [u8; 3]| frame.pixels().any(|pixel| pixel.0 == rgb);
    let (green, vermilion) = ([0x00, 0x9E, 0x73], [0xD5, 0x5E, 0x00]);
    assert!(has(&before, green) && !has(&before, vermilion));
    assert!(has(&after, vermilion) && !has(&after, green));

    // The same bytes again, for one thread as for many.
    let again = format!("{DRAW} --report page2.html --plot plot2.svg");
    Ran::of(place.command(&again).env("RAYON_NUM_THREADS", "1")).ends(0);
    assert_eq!(place.read("plot2.svg"), svg);
    let series = |page: String| page[page.find("id=\"series\"").unwrap()..].to_string();
    assert_eq!(series(place.read("page2.html")), series(page));
}

#[test]
fn outputs_that_cannot_be_written_are_told_before_the_work() {
    let place = clip();
    let frames = "--frames suite/Girl/img";
    for (more, code, words) in [
        (format!("{frames} --plot a.gif"), 2, "a .svg, a .pdf or a .png file"),
        (format!("{frames} --annotate a.gif"), 2, ".mp4, .mov, .mkv, .avi"),
        ("--annotate a.mp4".into(), 2, "give --frames"),
        (format!("{frames} --report none/a.html"), 1, "there is no folder none; make it first"),
        (format!("{frames} --plot none/a.svg"), 1, "there is no folder none"),
        (format!("{frames} --annotate none/a.mp4"), 1, "there is no folder none"),
        (format!("{frames} --annotate none/drawn"), 1, "there is no folder none"),
    ] {
        place.run(&format!("detect --boxes clip.txt {more}")).refuses(code, words);
    }
    assert!(!place.has("none"));
}

#[needs(ffmpeg)]
#[test]
fn a_video_is_drawn_on() {
    let place = clip();
    place.run(&format!("{DRAW} --annotate drawn.mp4")).ends(0);
    // The video is one that can be judged again, with as many frames.
    let again = "detect --frames drawn.mp4 --boxes clip.txt --annotate again.mkv";
    Ran::of(place.command(again).env("TMPDIR", place.folder("tmp"))).ends(0);
    assert!(place.list("tmp").is_empty(), "no frame is a file");
    let none = format!("{DRAW} --annotate none.mp4");
    Ran::of(place.command(&none).env("PATH", "/nowhere")).ends(3).tells("install it");
    assert!(!place.has("none.mp4"));
}
