//! Inputs of `trackfail detect` as people have them: boxes in several formats, frames in several forms, or none.

use crate::tools::{needs, rows, trackfail};
use std::path::{Path, PathBuf};
use trackfail::method::{Inputs, recommended};

/// A rendered sequence of 60 frames: their folder, and the boxes as numbers.
struct Clip {
    root: tempfile::TempDir,
    img: PathBuf,
    boxes: Vec<[f64; 4]>,
}

const FRAMES: usize = 60;

impl Clip {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("suite");
        trackfail()
            .args(["data", "render", "synthetic-otb", "--sequence", "Girl"])
            .arg(&target)
            .assert()
            .success();
        let img = target.join("Girl/img");
        let mut files: Vec<PathBuf> =
            std::fs::read_dir(&img).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files[FRAMES..].iter().for_each(|file| std::fs::remove_file(file).unwrap());
        let truth = std::fs::read_to_string(target.join("Girl/groundtruth_rect.txt")).unwrap();
        let numbers = |line: &str| -> [f64; 4] {
            let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
            values.try_into().unwrap()
        };
        let boxes = truth.lines().take(FRAMES).map(numbers).collect();
        Self { root, img, boxes }
    }

    /// A file with a line for each box.
    fn file(&self, name: &str, line: impl Fn(usize, [f64; 4]) -> String) -> PathBuf {
        let path = self.root.path().join(name);
        let text: String = self.boxes.iter().enumerate().map(|(t, b)| line(t, *b) + "\n").collect();
        std::fs::write(&path, text).unwrap();
        path
    }

    fn xywh(&self) -> PathBuf {
        self.file("boxes.txt", |_, [x, y, w, h]| format!("{x},{y},{w},{h}"))
    }
}

/// Stdout of a run that ends well.
fn detect(frames: &[PathBuf], boxes: &Path, more: &[&str]) -> String {
    let mut command = trackfail();
    command.arg("detect").arg("--boxes").arg(boxes).args(more);
    if !frames.is_empty() {
        command.arg("--frames").args(frames);
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Exit code and message of a run that fails.
fn refused(frames: &[PathBuf], boxes: &Path, more: &[&str]) -> (Option<i32>, String) {
    let mut command = trackfail();
    command.arg("detect").arg("--boxes").arg(boxes).args(more);
    if !frames.is_empty() {
        command.arg("--frames").args(frames);
    }
    let output = command.output().unwrap();
    assert!(output.stdout.is_empty());
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Scores of a method, by frame.
fn scores(csv: &str) -> Vec<f64> {
    rows(csv).iter().map(|row| row["score"].parse().unwrap_or(f64::NAN)).collect()
}

fn assert_same(csv: &str, want: &[f64], name: &str) {
    let found = scores(csv);
    assert_eq!(found.len(), want.len(), "{name}");
    assert!(found.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-6), "{name}: {found:?} {want:?}");
}

/// The row of frame `t`, after a header in the first one.
fn with_header(t: usize, header: &str, row: String) -> String {
    if t == 0 { format!("{header}\n{row}") } else { row }
}

#[test]
fn one_track_in_every_format_has_one_score() {
    let clip = Clip::new();
    let first = std::fs::read_dir(&clip.img).unwrap().next().unwrap().unwrap().path();
    let (width, height) = image::image_dimensions(first).unwrap();
    let (width, height) = (f64::from(width), f64::from(height));
    let frames = [clip.img.clone()];
    let method = ["--method", "CovF"];
    let want = scores(&detect(&frames, &clip.xywh(), &method));
    assert_eq!(want.len(), FRAMES);
    let xyxy = |_, [x, y, w, h]: [f64; 4]| format!("{x} {y} {} {}", x + w, y + h);
    let vot = |_, [x, y, w, h]: [f64; 4]| {
        let (l, t, r, b) = (x - 1.0, y - 1.0, x + w - 1.0, y + h - 1.0);
        format!("{l},{t},{r},{t},{r},{b},{l},{b}")
    };
    let yolo = move |_, [x, y, w, h]: [f64; 4]| {
        format!(
            "0 {} {} {} {}",
            (x - 1.0 + w / 2.0) / width,
            (y - 1.0 + h / 2.0) / height,
            w / width,
            h / height
        )
    };
    let mot = |t: usize, [x, y, w, h]: [f64; 4]| format!("{},3,{x},{y},{w},{h},1,-1,-1,-1", t + 1);
    let zero = |_, [x, y, w, h]: [f64; 4]| format!("{},{},{w},{h}", x - 1.0, y - 1.0);
    type Line = Box<dyn Fn(usize, [f64; 4]) -> String>;
    let cases: [(&str, Line, &[&str]); 6] = [
        ("xyxy.txt", Box::new(xyxy), &["--boxes-format", "xyxy"]),
        ("vot.txt", Box::new(vot), &["--boxes-format", "vot"]),
        ("yolo.txt", Box::new(yolo), &[]),
        ("mot.txt", Box::new(mot), &[]),
        ("zero.txt", Box::new(zero), &["--base", "0"]),
        ("named.txt", Box::new(zero), &["--base", "0", "--boxes-format", "xywh"]),
    ];
    for (name, line, more) in cases {
        assert_same(&detect(&frames, &clip.file(name, line), &[&method, more].concat()), &want, name);
    }
    // Corners that would reach beyond the frame of 160 x 120 pixels as left, top, width and height.
    let corners = clip.file("corners.txt", |_, _| "100,70,150,110".into());
    let told = |more: &[&str]| {
        let mut command = trackfail();
        command.args(["detect", "--frames"]).arg(&clip.img).arg("--boxes").arg(&corners).args(more);
        String::from_utf8(command.output().unwrap().stderr).unwrap()
    };
    let words = "corners.txt is read as x1,y1,x2,y2, pixels counted from 1 (--boxes-format xyxy --base 1)";
    assert!(told(&method).contains(words), "{}", told(&method));
    assert!(told(&["--boxes-format", "xyxy", "--method", "CovF"]).contains(words));
    assert_eq!(told(&["--boxes-format", "xyxy", "--base", "1", "--method", "CovF"]), "");
    assert_eq!(told(&["--boxes-format", "xywh", "--base", "1", "--method", "CovF"]), "");
    let (code, message) = refused(&[], &clip.root.path().join("yolo.txt"), &[]);
    assert!(code == Some(3) && message.contains("give --frames"), "{message}");
    let eight = clip.file("eight.txt", |t, [x, y, w, h]| format!("{},1,{x},{y},{w},{h},1,1", t + 1));
    assert_same(&detect(&frames, &eight, &method), &want, "eight.txt");
}

// One track as tools write it: with header words in any order (TensorFlow's, pandas'), ultralytics' with a number of the
// target, tables and MOTChallenge with frames from 0.
#[test]
fn headers_and_layouts_are_read_as_what_they_are() {
    let clip = Clip::new();
    let frames = [clip.img.clone()];
    let method = ["--method", "CovF"];
    let want = scores(&detect(&frames, &clip.xywh(), &method));
    type Line = fn(usize, [f64; 4]) -> String;
    let headers: [(&str, &str, Line); 4] = [
        ("center.csv", "x_center,y_center,width,height", |_, [x, y, w, h]| {
            format!("{},{},{w},{h}", x + w / 2.0, y + h / 2.0)
        }),
        ("tf.csv", "ymin;xmin;ymax;xmax", |_, [x, y, w, h]| format!("{y};{x};{};{}", y + h, x + w)),
        ("yxhw.csv", "Y,X,H,W", |_, [x, y, w, h]| format!("{y},{x},{h},{w}")),
        ("named.csv", ",frame,label,bbox_left,bbox_top,bbox_width,bbox_height", |t, [x, y, w, h]| {
            format!("{t},{},traffic light,{x},{y},{w},{h}", t + 1)
        }),
    ];
    for (name, header, line) in headers {
        let file = clip.file(name, |t, b| with_header(t, header, line(t, b)));
        assert_same(&detect(&frames, &file, &method), &want, name);
    }
    let layouts: [(&str, &str, Line); 3] = [
        ("yolo_id.txt", "yolo", |_, [x, y, w, h]| {
            let (x, y) = (x - 1.0 + w / 2.0, y - 1.0 + h / 2.0);
            format!("0 {} {} {} {} 2", x / 160.0, y / 120.0, w / 160.0, h / 120.0)
        }),
        ("fxywh.txt", "frame,x,y,w,h", |t, [x, y, w, h]| format!("{},{x},{y},{w},{h}", t + 1)),
        ("mot10_from0.txt", "mot", |t, [x, y, w, h]| format!("{t},1,{x},{y},{w},{h},1,-1,-1,-1")),
    ];
    for (name, format, line) in layouts {
        let file = clip.file(name, line);
        let output = trackfail()
            .args(["detect", "--frames"])
            .arg(&clip.img)
            .arg("--boxes")
            .arg(&file)
            .args(method)
            .output()
            .unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(
            told.contains(" is read as ") && told.contains(&format!("(--boxes-format {format}")),
            "{told}"
        );
        assert_eq!(told.contains("frames counted from 0"), name == "mot10_from0.txt", "{told}");
        assert_same(&String::from_utf8(output.stdout).unwrap(), &want, name);
    }
}

#[test]
fn what_fits_two_formats_is_asked_with_a_command_for_each() {
    let clip = Clip::new();
    let frames = [clip.img.clone()];
    let method = ["--method", "CovF"];
    let want = scores(&detect(&frames, &clip.xywh(), &method));
    // Both kinds of boxes lie in the frame.
    let detector = clip.file("det6.txt", |_, [x, y, w, h]| format!("{x} {y} {} {} 0.87 0", x + w, y + h));
    let (code, message) = refused(&frames, &detector, &method);
    assert_eq!(code, Some(2), "{message}");
    let commands: Vec<&str> =
        message.lines().filter_map(|line| line.strip_prefix("  trackfail detect ")).collect();
    let ends = ["x,y,w,h,confidence,class", "x1,y1,x2,y2,confidence,class"];
    assert_eq!(commands.len(), ends.len(), "{message}");
    for (command, end) in commands.iter().zip(ends) {
        assert!(command.contains(" --method CovF ") && command.ends_with(&format!(" --boxes-format {end}")));
    }
    let more = [&method[..], &["--boxes-format", ends[1]]].concat();
    assert_same(&detect(&frames, &detector, &more), &want, "det6.txt");
    // The base that is assumed is told, and doubted where a box begins before the first pixel.
    let corner = clip.file("corner.txt", |t, _| format!("{},0,20,20", t % 3));
    let output = trackfail().args(["detect", "--boxes"]).arg(&corner).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("pixels counted from 1") && told.contains("is 0, but the first pixel 1"), "{told}");
    let (code, message) =
        refused(&frames, &clip.file("words.txt", |t, b| with_header(t, "a,b,c,d", format!("{b:?}"))), &[]);
    assert!(
        code == Some(3) && message.contains("words.txt, line 1: `a,b,c,d` names no whole box"),
        "{message}"
    );
}

#[test]
fn every_target_of_motchallenge_has_a_verdict() {
    let clip = Clip::new();
    let line = |t: usize, [x, y, w, h]: [f64; 4]| match t {
        // The second target is there from frame 11 to 50, and not in frame 31.
        10..=29 | 31..=49 => format!("{},3,{x},{y},{w},{h},1\n{},8,{y},{x},{w},{h},1", t + 1, t + 1),
        _ => format!("{},3,{x},{y},{w},{h},1", t + 1),
    };
    let boxes = clip.file("mot.txt", line);
    let text = detect(std::slice::from_ref(&clip.img), &boxes, &["--method", "Displacement"]);
    let all = rows(&text);
    assert_eq!(all.len(), 2 * FRAMES);
    let state = |target: &str| -> Vec<String> {
        all.iter().filter(|r| r["target"] == target).map(|r| r["state"].clone()).collect()
    };
    let absent: Vec<usize> =
        (1..=FRAMES).zip(state("8")).filter(|(_, s)| s == "absent").map(|(t, _)| t).collect();
    assert_eq!(absent, (1..=10).chain([31]).chain(51..=60).collect::<Vec<_>>());
    assert!(state("3").iter().all(|state| state != "absent"));
    let told =
        detect(std::slice::from_ref(&clip.img), &boxes, &["--method", "Displacement", "--format", "table"]);
    let lines: Vec<String> =
        told.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    assert!(lines[0].starts_with("Target 3: ") && lines[1].starts_with("Target 8: "), "{told}");
    assert_eq!(lines[3], "target from to state probability why");
    assert!(
        lines.contains(&"8 1 10 absent no box".into()) && lines.contains(&"8 31 31 absent no box".into()),
        "{told}"
    );
    let confidence = clip.file("confidence.txt", |_, _| "0.5".into());
    let (code, message) = refused(&[], &boxes, &["--confidence", confidence.to_str().unwrap()]);
    assert!(code == Some(2) && message.contains("2 targets"), "{message}");
}

#[test]
fn boxes_without_frames_are_judged_by_what_they_say() {
    let clip = Clip::new();
    let boxes = clip.xywh();
    let text = detect(&[], &boxes, &[]);
    let inputs = Inputs::default();
    assert!(rows(&text).iter().all(|row| row["method"] == recommended(inputs)), "{text}");
    assert_eq!(text.lines().count(), FRAMES + 1);
    let (code, message) = refused(&[], &boxes, &["--method", "DTEF"]);
    assert!(
        code == Some(2) && message.contains("give --frames") && message.contains("Displacement"),
        "{message}"
    );
    // Stdin is a file like others.
    let piped =
        trackfail().args(["detect", "--boxes", "-"]).write_stdin(std::fs::read(&boxes).unwrap()).output();
    assert_eq!(String::from_utf8(piped.unwrap().stdout).unwrap(), text);
    let (code, message) = refused(&[], Path::new("-"), &["--companion", "-"]);
    assert!(code == Some(2) && message.contains("only one"), "{message}");
    // A box that no image has is none without a format of it.
    let far = clip.file("far.txt", |t, _| if t == 4 { "5000,1,9,9".into() } else { "1,1,9,9".into() });
    detect(&[], &far, &[]);
    let (code, message) = refused(std::slice::from_ref(&clip.img), &far, &[]);
    assert!(code == Some(3) && message.contains("far.txt, line 5: the box 5000,1,9,9"), "{message}");
}

#[test]
fn a_tier_is_a_method() {
    let clip = Clip::new();
    let (frames, boxes) = ([clip.img.clone()], clip.xywh());
    for (tier, method) in [
        ("light", "Agreement"),
        ("default", "Fused deep"),
        ("full", "Fused deep full"),
        ("nanotrack", "Fused deep v3"),
    ] {
        let text = detect(&frames, &boxes, &["--tier", tier]);
        assert!(rows(&text).iter().all(|row| row["method"] == method), "{text}");
        assert_eq!(text, detect(&frames, &boxes, &["--method", method]));
    }
    let (code, message) = refused(&frames, &boxes, &["--tier", "light", "--all"]);
    assert!(code == Some(2) && message.contains("--tier"), "{message}");
    let (code, message) = refused(&[], &boxes, &["--tier", "full"]);
    assert!(code == Some(2) && message.contains("give --frames"), "{message}");
}

#[test]
fn the_default_method_is_the_one_recommended_for_the_inputs() {
    let clip = Clip::new();
    let frames = [clip.img.clone()];
    let boxes = clip.xywh();
    let confidence = clip.file("confidence.txt", |t, _| if t < 40 { "0.9".into() } else { "0.1".into() });
    let companion = clip.file("companion.txt", |t, [x, y, w, h]| match t {
        0..30 => format!("{x},{y},{w},{h}"),
        _ => "2,2,6,6".into(),
    });
    let (confidence, companion) = (confidence.to_str().unwrap(), companion.to_str().unwrap());
    let one = Inputs { frames: true, ..Inputs::default() };
    for (inputs, more) in [
        (one, vec![]),
        (Inputs { confidence: true, ..one }, vec!["--confidence", confidence]),
        (Inputs { companions: true, ..one }, vec!["--companion", companion]),
        (
            Inputs { companions: true, confidence: true, ..one },
            vec!["--companion", companion, "--confidence", confidence],
        ),
    ] {
        let text = detect(&frames, &boxes, &more);
        assert!(rows(&text).iter().all(|row| row["method"] == recommended(inputs)), "{more:?}");
        let all = detect(&frames, &boxes, &[vec!["--all"], more.clone()].concat());
        assert_eq!(rows(&all)[0]["method"], recommended(inputs));
        assert!(all.starts_with(&text), "{more:?}");
        let names: std::collections::BTreeSet<String> =
            rows(&all).iter().map(|r| r["method"].clone()).collect();
        assert_eq!(names.contains("Confidence"), inputs.confidence);
        assert_eq!(names.contains("Companions"), inputs.companions);
    }
    let state = |method: &str, file: &str, option: &str| -> Vec<String> {
        let text = detect(&frames, &boxes, &["--method", method, option, file]);
        rows(&text).iter().map(|row| row["state"].clone()).collect()
    };
    for (method, file, option, first) in
        [("Confidence", confidence, "--confidence", 40), ("Companions", companion, "--companion", 30)]
    {
        let states = state(method, file, option);
        assert_eq!(states.iter().position(|s| s == "lost"), Some(first), "{method}");
    }
    let short = clip.root.path().join("short.txt");
    std::fs::write(&short, "1,1,9,9\n").unwrap();
    let (code, message) = refused(&frames, &boxes, &["--companion", short.to_str().unwrap()]);
    assert!(
        code == Some(3) && message.contains("short.txt has 1 boxes") && message.contains("60 frames"),
        "{message}"
    );
}

#[test]
fn an_absent_target_is_neither_lost_nor_tracked() {
    let clip = Clip::new();
    let frames = [clip.img.clone()];
    let boxes = clip.file("boxes.txt", |t, [x, y, w, h]| match t {
        0..5 => String::new(),
        20..23 => "nan,nan,nan,nan".into(),
        58..60 => String::new(),
        _ => format!("{x},{y},{w},{h}"),
    });
    for method in ["CovF", "Watchdog"] {
        let text = detect(&frames, &boxes, &["--absent", "--method", method]);
        let all = rows(&text);
        let absent: Vec<usize> = (0..FRAMES).filter(|t| all[*t]["state"] == "absent").collect();
        assert_eq!(absent, [0, 1, 2, 3, 4, 20, 21, 22, 58, 59], "{method}");
        assert_eq!([&all[4]["score"], &all[59]["score"]], ["", ""]);
        assert!(all[5..58].iter().all(|row| !row["score"].is_empty()));
    }
    // The track begins with its first box, as if there had been no frame before it.
    let late = detect(&frames, &boxes, &["--absent", "--method", "CovF"]);
    let later: Vec<PathBuf> = (6..=58).map(|t| clip.img.join(format!("{t:04}.jpg"))).collect();
    if later[0].exists() {
        let cut = clip.root.path().join("cut.txt");
        let text = std::fs::read_to_string(&boxes).unwrap();
        let lines: Vec<&str> = text.lines().skip(5).take(53).collect();
        std::fs::write(&cut, lines.join("\n")).unwrap();
        let alone = detect(&later, &cut, &["--absent", "--method", "CovF"]);
        assert_eq!(
            late.lines().skip(6).take(53).collect::<Vec<_>>(),
            alone.lines().skip(1).collect::<Vec<_>>()
        );
    }
    let (code, message) = refused(&frames, &boxes, &[]);
    assert!(code == Some(3) && message.contains("boxes.txt, line 1: an empty line"), "{message}");
}

#[test]
fn frames_are_a_folder_a_pattern_or_files() {
    let clip = Clip::new();
    let boxes = clip.xywh();
    let mut files: Vec<PathBuf> = std::fs::read_dir(&clip.img).unwrap().map(|e| e.unwrap().path()).collect();
    let extension = files[0].extension().unwrap().to_string_lossy().into_owned();
    files.sort();
    let want = detect(std::slice::from_ref(&clip.img), &boxes, &["--method", "CovF"]);
    let pattern = clip.img.join(format!("0*.{extension}"));
    assert_eq!(detect(&[pattern], &boxes, &["--method", "CovF"]), want);
    assert_eq!(detect(&files, &boxes, &["--method", "CovF"]), want);
    // An order that no shell gives is meant.
    files.reverse();
    let output =
        trackfail().args(["detect", "--boxes"]).arg(&boxes).arg("--frames").args(&files).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && told.contains("60 frames in the order given: 0060."), "{told}");
    let some = [clip.img.join(format!("*1.{extension}"))];
    let (code, message) = refused(&some, &boxes, &["--method", "CovF"]);
    assert!(code == Some(3) && message.contains("60 boxes") && message.contains("has 6 frames"), "{message}");
    let (code, message) = refused(&[clip.img.join("none.mp4")], &boxes, &[]);
    assert!(code == Some(3) && message.contains("none.mp4"), "{message}");
}

/// Row C of public reports: cvat#6180, roboflow/trackers PR 558, and time stamps. The pictures are the same under each name,
/// so the scores are, too.
#[test]
fn frames_are_in_the_order_of_all_numbers_in_their_names() {
    let clip = Clip::new();
    let boxes = clip.xywh();
    let want = scores(&detect(std::slice::from_ref(&clip.img), &boxes, &["--method", "CovF"]));
    let mut files: Vec<PathBuf> = std::fs::read_dir(&clip.img).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    let extension = files[0].extension().unwrap().to_string_lossy().into_owned();
    let folder = |name: &str, file: &dyn Fn(usize) -> String| {
        let folder = clip.root.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        for (t, path) in files.iter().enumerate() {
            std::fs::copy(path, folder.join(format!("{}.{extension}", file(t)))).unwrap();
        }
        folder
    };
    let date = |t: usize| format!("cam_2024-01-02_{:02}-59-{:02}", 9 + (40 + t) / 60, (40 + t) % 60);
    let all = [
        folder("paren", &|t| format!("DJI_1000({})", t + 1)),
        folder("roboflow", &|t| format!("clip_mp4-{}_jpg.rf.{:x}", t + 1, (t + 7) * 40_503 % 65_536)),
        folder("date", &date),
    ];
    for folder in all {
        for frames in [folder.clone(), folder.join(format!("*.{extension}"))] {
            let found = scores(&detect(std::slice::from_ref(&frames), &boxes, &["--method", "CovF"]));
            assert_eq!(found, want, "{}", frames.display());
        }
    }
    let extra = folder("extra", &|t| (t + 1).to_string());
    std::fs::copy(&files[0], extra.join(format!("background.{extension}"))).unwrap();
    let (code, message) = refused(&[extra], &boxes, &["--method", "CovF"]);
    assert!(code == Some(3) && message.contains("background.") && message.contains("no number"), "{message}");
    let cameras = folder("cameras", &|t| format!("cam{}_{:04}", 1 + t % 2, t + 1));
    let (code, message) = refused(&[cameras], &boxes, &["--method", "CovF"]);
    assert!(code == Some(3) && message.contains("the order of the frames is in doubt"), "{message}");
}

#[needs(ffmpeg)]
#[test]
fn frames_are_a_video() {
    let clip = Clip::new();
    let boxes = clip.xywh();
    let mut files: Vec<PathBuf> = std::fs::read_dir(&clip.img).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    let extension = files[0].extension().unwrap().to_string_lossy().into_owned();
    let video = clip.root.path().join("clip.mp4");
    let made = std::process::Command::new("ffmpeg")
        .args(["-nostdin", "-v", "error", "-i"])
        .arg(clip.img.join(format!("%04d.{extension}")))
        .args(["-c:v", "libx264", "-qp", "0", "-pix_fmt", "yuv444p"])
        .arg(&video)
        .status();
    assert!(made.unwrap().success());
    let temporary = clip.root.path().join("tmp");
    std::fs::create_dir(&temporary).unwrap();
    let run = |path: Option<&str>| {
        let mut command = trackfail();
        command.args(["detect", "--method", "RgbHist", "--boxes"]).arg(&boxes).arg("--frames").arg(&video);
        command.env("TMPDIR", &temporary);
        path.map(|path| command.env("PATH", path));
        command.output().unwrap()
    };
    let output = run(None);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let of_video = scores(&String::from_utf8(output.stdout).unwrap());
    let of_files = scores(&detect(std::slice::from_ref(&clip.img), &boxes, &["--method", "RgbHist"]));
    // The colors of the video are those of the files but for their coding.
    assert!(of_video.iter().zip(&of_files).all(|(a, b)| (a - b).abs() < 0.1), "{of_video:?} {of_files:?}");
    assert_eq!(std::fs::read_dir(&temporary).unwrap().count(), 0, "no frame is a file");
    let output = run(Some("/nowhere"));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(message.contains("no `ffmpeg` on the PATH; install it"), "{message}");
}
