//! Inputs of `trackfail detect` as people have them: boxes in several formats, frames in several forms, or none. The readers of
//! boxes and of the order of frames have their own tests.

use crate::tools::{IMAGES, Place, Ran, Row, clip, rows, words};
use trackfail::method::{Inputs, recommended};

const FRAMES: usize = 60;

/// A rendered sequence of 60 frames of 160 x 120 pixels, the boxes as numbers, and in `boxes.txt`.
struct Clip {
    place: Place,
    boxes: Vec<[f64; 4]>,
}

impl Clip {
    fn new() -> Self {
        let place = Place::new();
        let truth = clip(&place, FRAMES);
        let numbers = |line: &String| -> [f64; 4] {
            let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
            values.try_into().unwrap()
        };
        let clip = Self { place, boxes: truth.iter().map(numbers).collect() };
        clip.file("boxes.txt", |_, [x, y, w, h]| format!("{x},{y},{w},{h}"));
        clip
    }

    /// Writes a file with a line for each box.
    fn file(&self, name: &str, line: impl Fn(usize, [f64; 4]) -> String) {
        let text: String = self.boxes.iter().enumerate().map(|(t, b)| line(t, *b) + "\n").collect();
        self.place.write(name, text);
    }

    /// `detect` on a file of boxes.
    fn boxes(&self, line: &str) -> Ran {
        self.place.run(&format!("detect --boxes {line}"))
    }

    /// `detect` on a file of boxes and the frames.
    fn frames(&self, line: &str) -> Ran {
        self.boxes(&format!("{line} --frames {IMAGES}"))
    }

    /// The scores of CovF.
    fn scores(&self) -> Vec<f64> {
        scores(&self.frames("boxes.txt --method CovF").ends(0))
    }
}

/// Scores of a method, by frame.
fn scores(ran: &Ran) -> Vec<f64> {
    ran.rows().iter().map(|row| row["score"].parse().unwrap_or(f64::NAN)).collect()
}

fn assert_same(ran: &Ran, want: &[f64], name: &str) {
    assert_eq!(ran.code, Some(0), "{name}: {}", ran.err);
    trackfail_testing::assert_near(scores(ran), want, 1e-6, name);
}

#[test]
fn one_track_in_every_format_has_one_score() {
    let clip = Clip::new();
    let want = clip.scores();
    assert_eq!(want.len(), FRAMES);
    type Line = fn(usize, [f64; 4]) -> String;
    // The center as YOLO has it.
    let yolo: Line = |_, [x, y, w, h]| {
        let (x, y) = (x - 1.0 + w / 2.0, y - 1.0 + h / 2.0);
        format!("0 {} {} {} {}", x / 160.0, y / 120.0, w / 160.0, h / 120.0)
    };
    let cases: [(&str, Line, &str, &str); 4] = [
        ("xyxy.txt", |_, [x, y, w, h]| format!("{x} {y} {} {}", x + w, y + h), "--boxes-format xyxy", ""),
        ("zero.txt", |_, [x, y, w, h]| format!("{},{},{w},{h}", x - 1.0, y - 1.0), "--base 0", ""),
        ("yolo.txt", yolo, "", ""),
        ("from0.txt", |t, [x, y, w, h]| format!("{t},1,{x},{y},{w},{h},1,-1,-1,-1"), "", "counted from 0"),
    ];
    for (name, line, more, told) in cases {
        clip.file(name, line);
        let ran = clip.frames(&format!("{name} --method CovF {more}")).tells(told);
        assert_eq!(ran.err.contains("frames counted from 0"), name == "from0.txt", "{}", ran.err);
        assert_same(&ran, &want, name);
    }
    // Corners that would reach beyond the frame of 160 x 120 pixels as left, top, width and height.
    clip.file("corners.txt", |_, _| "100,70,150,110".into());
    let told = |more: &str| clip.frames(&format!("corners.txt --method CovF {more}"));
    let words = "corners.txt is read as x1,y1,x2,y2, pixels counted from 1 (--boxes-format xyxy --base 1)";
    ["", "--boxes-format xyxy"].into_iter().for_each(|more| drop(told(more).tells(words)));
    for format in ["xyxy", "xywh"] {
        assert_eq!(told(&format!("--boxes-format {format} --base 1")).err, "");
    }
    clip.boxes("yolo.txt").refuses(3, "give --frames");
}

#[test]
fn what_fits_two_formats_is_asked_with_a_command_for_each() {
    let clip = Clip::new();
    // Both kinds of boxes lie in the frame.
    clip.file("det6.txt", |_, [x, y, w, h]| format!("{x} {y} {} {} 0.87 0", x + w, y + h));
    let message = clip.frames("det6.txt --method CovF").refuses(2, "").err;
    let commands: Vec<&str> = message.lines().filter_map(|l| l.strip_prefix("  trackfail detect ")).collect();
    let ends = ["x,y,w,h,confidence,class", "x1,y1,x2,y2,confidence,class"];
    assert_eq!(commands.len(), ends.len(), "{message}");
    for (command, end) in commands.iter().zip(ends) {
        assert!(command.contains(" --method CovF ") && command.ends_with(&format!(" --boxes-format {end}")));
    }
    let one = clip.frames(&format!("det6.txt --method CovF --boxes-format {}", ends[1]));
    assert_same(&one, &clip.scores(), "det6.txt");
    // The base that is assumed is told, and doubted where a box begins before the first pixel.
    clip.file("corner.txt", |t, _| format!("{},0,20,20", t % 3));
    clip.boxes("corner.txt").tells("pixels counted from 1").tells("is 0, but the first pixel 1");
}

#[test]
fn every_target_of_motchallenge_has_a_verdict() {
    let clip = Clip::new();
    clip.file("mot.txt", |t, [x, y, w, h]| match t {
        // The second target is there from frame 11 to 50, and not in frame 31.
        10..=29 | 31..=49 => format!("{},3,{x},{y},{w},{h},1\n{},8,{y},{x},{w},{h},1", t + 1, t + 1),
        _ => format!("{},3,{x},{y},{w},{h},1", t + 1),
    });
    let all = clip.frames("mot.txt --method Displacement").ends(0).rows();
    assert_eq!(all.len(), 2 * FRAMES);
    let absent = |target: &str| -> Vec<usize> {
        let states = all.iter().filter(|r| r["target"] == target).map(|r| &r["state"]);
        (1..=FRAMES).zip(states).filter(|(_, state)| *state == "absent").map(|(t, _)| t).collect()
    };
    assert_eq!(absent("8"), (1..=10).chain([31]).chain(51..=60).collect::<Vec<_>>());
    assert!(absent("3").is_empty());
    let told = clip.frames("mot.txt --method Displacement --format table").ends(0).out;
    let lines: Vec<String> = told.lines().map(|line| words(line).join(" ")).collect();
    assert!(lines[0].starts_with("Target 3: ") && lines[1].starts_with("Target 8: "), "{told}");
    for row in ["target from to state probability why", "8 1 10 absent no box", "8 31 31 absent no box"] {
        assert!(lines.contains(&row.into()), "{told}");
    }
    clip.file("confidence.txt", |_, _| "0.5".into());
    clip.boxes("mot.txt --confidence confidence.txt").refuses(2, "2 targets");
}

#[test]
fn boxes_without_frames_are_judged_by_what_they_say() {
    let clip = Clip::new();
    let text = clip.boxes("boxes.txt").ends(0).out;
    assert!(rows(&text).iter().all(|row| row["method"] == recommended(Inputs::default(), None)), "{text}");
    assert_eq!(text.lines().count(), FRAMES + 1);
    clip.boxes("boxes.txt --method DTEF").refuses(2, "give --frames").tells("Displacement");
    // Stdin is a file like others.
    let stdin = clip.place.bytes("boxes.txt");
    assert_eq!(Ran::of(clip.place.command("detect --boxes -").write_stdin(stdin)).out, text);
    clip.boxes("- --companion -").refuses(2, "only one");
    // A box that no image has is none without a format of it.
    clip.file("far.txt", |t, _| if t == 4 { "5000,1,9,9".into() } else { "1,1,9,9".into() });
    clip.boxes("far.txt").ends(0);
    clip.frames("far.txt").refuses(3, "far.txt, line 5: the box 5000,1,9,9");
}

#[test]
fn a_tier_is_a_method() {
    let clip = Clip::new();
    for (tier, method) in [
        ("light", "Agreement"),
        ("default", "Fused deep"),
        ("full", "Fused deep full"),
        ("nanotrack", "Fused deep v3"),
    ] {
        let ran = clip.frames(&format!("boxes.txt --tier {tier}")).ends(0);
        assert!(ran.rows().iter().all(|row| row["method"] == method), "{}", ran.out);
        assert_eq!(ran.out, clip.frames(&format!("boxes.txt --method '{method}'")).ends(0).out);
    }
    clip.frames("boxes.txt --tier light --all").refuses(2, "--tier");
    clip.boxes("boxes.txt --tier full").refuses(2, "give --frames");
}

#[test]
fn the_default_method_is_the_one_recommended_for_the_inputs() {
    let clip = Clip::new();
    clip.file("confidence.txt", |t, _| if t < 40 { "0.9".into() } else { "0.1".into() });
    clip.file("companion.txt", |t, [x, y, w, h]| match t {
        0..30 => format!("{x},{y},{w},{h}"),
        _ => "2,2,6,6".into(),
    });
    let options = ["--companion companion.txt", "--confidence confidence.txt"];
    for (companions, confidence) in [(false, false), (false, true), (true, false), (true, true)] {
        let inputs = Inputs { frames: true, companions, confidence };
        let given = options.into_iter().zip([companions, confidence]).filter(|(_, is_given)| *is_given);
        let more: Vec<&str> = given.map(|(option, _)| option).collect();
        let more = more.join(" ");
        let ran = clip.frames(&format!("boxes.txt {more}")).ends(0);
        assert!(ran.rows().iter().all(|row| row["method"] == recommended(inputs, None)), "{more}");
        let all = clip.frames(&format!("boxes.txt --all {more}")).ends(0);
        assert_eq!(all.rows()[0]["method"], recommended(inputs, None));
        assert!(all.out.starts_with(&ran.out), "{more}");
        let has = |method: &str| all.rows().iter().any(|row| row["method"] == method);
        assert_eq!((has("Confidence"), has("Companions")), (confidence, companions), "{more}");
    }
    for (method, more, first) in
        [("Confidence", "--confidence confidence.txt", 40), ("Companions", "--companion companion.txt", 30)]
    {
        let rows = clip.frames(&format!("boxes.txt --method {method} {more}")).ends(0).rows();
        assert_eq!(rows.iter().position(|row| row["state"] == "lost"), Some(first), "{method}");
    }
    clip.place.write("short.txt", "1,1,9,9\n");
    clip.frames("boxes.txt --companion short.txt").refuses(3, "short.txt has 1 boxes").tells("60 frames");
}

#[test]
fn an_absent_target_is_neither_lost_nor_tracked() {
    let clip = Clip::new();
    clip.file("gaps.txt", |t, [x, y, w, h]| match t {
        0..5 | 58..60 => String::new(),
        20..23 => "nan,nan,nan,nan".into(),
        _ => format!("{x},{y},{w},{h}"),
    });
    for method in ["CovF", "Watchdog"] {
        let all = clip.frames(&format!("gaps.txt --absent --method {method}")).ends(0).rows();
        let absent: Vec<usize> = (0..FRAMES).filter(|t| all[*t]["state"] == "absent").collect();
        assert_eq!(absent, [0, 1, 2, 3, 4, 20, 21, 22, 58, 59], "{method}");
        assert_eq!([&all[4]["score"], &all[59]["score"]], ["", ""]);
        assert!(all[5..58].iter().all(|row| !row["score"].is_empty()));
    }
    // The track begins with its first box, as if there had been no frame before it.
    let late = clip.frames("gaps.txt --absent --method CovF").ends(0);
    let text = clip.place.read("gaps.txt");
    clip.place.write("cut.txt", text.lines().skip(5).take(53).collect::<Vec<_>>().join("\n"));
    let later: Vec<String> = (6..=58).map(|t| format!("{IMAGES}/{t:04}.png")).collect();
    let alone = format!("cut.txt --absent --method CovF --frames {}", later.join(" "));
    let numberless = |mut row: Row| row.remove("frame").map(|_| row);
    let late: Vec<_> = late.rows().drain(5..58).map(numberless).collect();
    assert_eq!(late, clip.boxes(&alone).ends(0).rows().into_iter().map(numberless).collect::<Vec<_>>());
    clip.frames("gaps.txt").refuses(3, "gaps.txt, line 1: an empty line");
}

#[test]
fn frames_are_a_folder_a_pattern_or_files() {
    let clip = Clip::new();
    let of = |frames: &str| clip.boxes(&format!("boxes.txt --method CovF --frames {frames}"));
    assert_eq!(of(&format!("{IMAGES}/0*.png")).ends(0).out, of(IMAGES).ends(0).out);
    // An order that no shell gives is meant.
    let files: Vec<String> = (1..=FRAMES).rev().map(|t| format!("{IMAGES}/{t:04}.png")).collect();
    of(&files.join(" ")).ends(0).tells("60 frames in the order given: 0060.");
    of(&format!("{IMAGES}/*1.png")).refuses(3, "60 boxes").tells("has 6 frames");
    of(&format!("{IMAGES}/none.mp4")).refuses(3, "none.mp4");
    // Names that leave the order in doubt.
    let folder = clip.place.folder("cameras");
    for (t, path) in clip.place.list(IMAGES).iter().enumerate() {
        std::fs::copy(path, folder.join(format!("cam{}_{:04}.png", 1 + t % 2, t + 1))).unwrap();
    }
    of("cameras").refuses(3, "the order of the frames is in doubt");
}
