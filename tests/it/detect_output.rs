//! Outputs of `trackfail detect`: a verdict for people, formats for programs, exit codes, files.

use crate::tools::{needs, rows, trackfail};
use std::path::{Path, PathBuf};
use std::process::Output;

/// Boxes that stand still, jump to a far place in frame 41, and stand there.
fn boxes(root: &Path) -> PathBuf {
    let path = root.join("boxes.txt");
    let text: String = (1..=60).map(|t| if t < 41 { "10,10,20,20\n" } else { "200,10,20,20\n" }).collect();
    std::fs::write(&path, text).unwrap();
    path
}

fn detect(boxes: &Path, more: &[&str]) -> Output {
    trackfail()
        .args(["detect", "--method", "Displacement", "--boxes"])
        .arg(boxes)
        .args(more)
        .output()
        .unwrap()
}

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap()
}

#[test]
fn a_line_of_confidence_that_is_missing_is_told() {
    let root = tempfile::tempdir().unwrap();
    let boxes = boxes(root.path());
    let confidence = root.path().join("confidence.txt");
    std::fs::write(&confidence, "0.5\n".repeat(59)).unwrap();
    let output = detect(&boxes, &["--confidence", confidence.to_str().unwrap()]);
    let told = text(output.stderr);
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert!(told.contains("confidence.txt: 59 values for 60 boxes"), "{told}");
}

#[test]
fn tiny_sides_are_told_with_an_exponent() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("boxes.txt");
    image::RgbImage::new(40, 30).save(root.path().join("1.png")).unwrap();
    std::fs::write(&path, "205,151,1e-300,50\n").unwrap();
    let output = detect(&path, &["--frames", root.path().join("1.png").to_str().unwrap()]);
    let told = text(output.stderr);
    assert!(told.contains("the box 205,151,1e-300,50 (x,y,w,h) lies outside"), "{told}");
}

const VERDICT: &str = "Lost since frame 41; not surely found again. Start the tracker again at frame 41, or do not use its \
                       boxes from there on.";

#[test]
fn a_verdict_a_table_and_json() {
    let root = tempfile::tempdir().unwrap();
    let boxes = boxes(root.path());
    let one = text(detect(&boxes, &["--format", "table"]).stdout);
    let (sentences, table) = one.split_once("\n\n").unwrap();
    assert_eq!(sentences, VERDICT);
    let table: Vec<Vec<&str>> = table.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(table[0], ["from", "to", "state", "probability", "why"]);
    assert_eq!(table[1].join(" "), "41 50 lost alarm: 9.50 > 1.00; then not surely found again");
    assert_eq!(table.len(), 2);
    let two = text(detect(&boxes, &["--method", "Scale", "--format", "table"]).stdout);
    let lines: Vec<&str> = two.lines().collect();
    assert_eq!((lines[0], lines[1], lines[4]), (VERDICT, "", ""));
    let words = |line: &str| line.split_whitespace().map(String::from).collect::<Vec<_>>();
    assert_eq!(words(lines[6]), ["Displacement", "1", "10", "of", "60", "41", "tracking"]);
    assert_eq!(words(lines[7]), ["Scale", "0", "0", "of", "60", "tracking"]);

    // Output into a pipe is CSV unless the user wants something else.
    let csv = text(detect(&boxes, &[]).stdout);
    assert_eq!(csv, text(detect(&boxes, &["--format", "csv"]).stdout));
    let all = rows(&csv);
    let lost: Vec<&str> = all.iter().filter(|row| row["state"] == "lost").map(|row| &*row["frame"]).collect();
    assert_eq!(lost, (41..=50).map(|t| t.to_string()).collect::<Vec<_>>());

    let json: serde_json::Value =
        serde_json::from_slice(&detect(&boxes, &["--format", "json"]).stdout).unwrap();
    let method = &json["tracks"][0]["methods"][0];
    assert!(json["tracks"][0]["target"].is_null());
    assert_eq!(method["verdict"], VERDICT);
    assert_eq!(method["lost"], serde_json::json!([[41, 50]]));
    assert_eq!((&method["threshold"], method["frames"].as_array().unwrap().len()), (&1.0.into(), 60));
    for (row, frame) in all.iter().zip(method["frames"].as_array().unwrap()) {
        assert_eq!(row["state"], frame["state"].as_str().unwrap());
        assert_eq!(row["score"].parse::<f64>().unwrap(), frame["score"].as_f64().unwrap());
    }
}

#[test]
fn a_loss_may_be_an_exit_code() {
    let root = tempfile::tempdir().unwrap();
    let boxes = boxes(root.path());
    let lost = detect(&boxes, &["--fail-on-loss", "--format", "table"]);
    assert_eq!(lost.status.code(), Some(6));
    let table = " from  to  state  probability  why\n 41    50  lost                alarm: 9.50 > 1.00; then not surely found again\n";
    assert_eq!(text(lost.stdout), format!("{VERDICT}\n\n{table}"));
    let told = text(lost.stderr);
    assert!(told.ends_with(&format!("\nerror: {VERDICT}\n")), "{told}");
    let still = root.path().join("still.txt");
    std::fs::write(&still, "10,10,20,20\n".repeat(9)).unwrap();
    assert_eq!(detect(&still, &["--fail-on-loss"]).status.code(), Some(0));
    let help = text(trackfail().arg("--help").output().unwrap().stdout);
    let help: Vec<&str> = help.split_whitespace().collect();
    assert!(help.join(" ").contains("6 the target is lost (`detect --fail-on-loss`)"));
}

#[test]
fn a_budget_is_for_methods_that_take_one() {
    let root = tempfile::tempdir().unwrap();
    let boxes = boxes(root.path());
    let output = detect(&boxes, &["--budget", "5"]);
    let message = text(output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(
        message.contains("method `Displacement` takes no budget of false alarms; methods that take one: "),
        "{message}"
    );
    // Without a method it is the recommended one of those that take one, also where confidence alone would choose another.
    let confidence = root.path().join("confidence.txt");
    std::fs::write(&confidence, "0.5\n".repeat(60)).unwrap();
    let mut command = trackfail();
    command.args(["detect", "--budget", "5", "--boxes"]).arg(&boxes).arg("--confidence").arg(&confidence);
    let output = command.output().unwrap();
    assert!(rows(&text(output.stdout)).iter().all(|row| row["method"] == "Fused boxes"));
    assert_eq!(output.status.code(), Some(0));
    for budget in ["0", "-1", "nan", "inf"] {
        for verb in [&["detect", "--boxes", "-"][..], &["monitor"]] {
            let output = trackfail().args(verb).arg(format!("--budget={budget}")).write_stdin("").output();
            let output = output.unwrap();
            let told = text(output.stderr);
            assert_eq!(output.status.code(), Some(2), "{told}");
            assert!(told.contains("it is a number above 0"), "{told}");
        }
    }
}

#[test]
fn a_larger_budget_lowers_the_threshold() {
    let root = tempfile::tempdir().unwrap();
    let boxes = boxes(root.path());
    let threshold = |budget: &str| {
        let mut command = trackfail();
        command.args(["detect", "--method", "Fused boxes", "--format", "json", "--boxes"]).arg(&boxes);
        let output = command.args(["--budget", budget]).output().unwrap();
        assert!(output.status.success(), "{}", text(output.stderr));
        let verdict: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        verdict["tracks"][0]["methods"][0]["threshold"].as_f64().unwrap()
    };
    let (small, large) = (threshold("1"), threshold("50"));
    assert!(0.0 < large && large < small && small < 1.0, "{large} {small}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_a_closed_pipe_is_none() {
    let root = tempfile::tempdir().unwrap();
    let boxes = boxes(root.path());
    let run = |script: &str| {
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", script]).env("PROGRAM", env!("CARGO_BIN_EXE_trackfail")).env("BOXES", &boxes);
        shell.output().unwrap()
    };
    for format in ["csv", "json", "table"] {
        let detect =
            format!("\"$PROGRAM\" detect --boxes \"$BOXES\" --boxes-format xywh --base 1 --format {format}");
        let output = run(&format!("{detect} > /dev/full"));
        assert_eq!(output.status.code(), Some(1), "{format}");
        assert!(text(output.stderr).starts_with("error: stdout: "));
        // The reader is gone before the program writes.
        let closed = format!("{{ sleep 1; {detect}; echo $? >&2; }} | true");
        assert_eq!(text(run(&closed).stderr), "0\n", "{format}");
    }
}

/// The frames and boxes, made at the first call, of a rendered sequence of 30 frames, whose box jumps away in the twentieth.
fn clip(root: &Path) -> (PathBuf, PathBuf) {
    let suite = root.join("suite");
    let (img, boxes) = (suite.join("Girl/img"), root.join("clip.txt"));
    if boxes.exists() {
        return (img, boxes);
    }
    trackfail()
        .args(["data", "render", "synthetic-otb", "--sequence", "Girl"])
        .arg(&suite)
        .assert()
        .success();
    let mut files: Vec<PathBuf> = std::fs::read_dir(&img).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    files[30..].iter().for_each(|file| std::fs::remove_file(file).unwrap());
    let truth = std::fs::read_to_string(suite.join("Girl/groundtruth_rect.txt")).unwrap();
    let line = |(t, line): (usize, &str)| if t < 19 { line.to_string() } else { "2,2,9,9".to_string() };
    let lines: Vec<String> = truth.lines().take(30).enumerate().map(line).collect();
    std::fs::write(&boxes, lines.join("\n")).unwrap();
    (img, boxes)
}

fn drawn(root: &Path, more: &[&str]) -> Output {
    let (img, boxes) = clip(root);
    let mut command = trackfail();
    command.current_dir(root).args(["detect", "--method", "Displacement", "--boxes"]).arg(boxes);
    command.arg("--frames").arg(img).args(more).output().unwrap()
}

#[test]
fn a_page_a_figure_and_drawn_frames() {
    let root = tempfile::tempdir().unwrap();
    let here = root.path();
    let more = ["--report", "page.html", "--plot", "plot.svg", "--annotate", "drawn"];
    let output = drawn(here, &more);
    assert!(output.status.success(), "{}", text(output.stderr));
    assert_eq!(rows(&text(output.stdout)).len(), 30);
    let page = std::fs::read_to_string(here.join("page.html")).unwrap();
    assert!(page.contains("Lost since frame 20; ") && page.contains("data:image/jpeg;base64,"));
    let svg = std::fs::read_to_string(here.join("plot.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.contains("Lost since frame 20"));
    let mut names: Vec<String> = std::fs::read_dir(here.join("drawn"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!((names.len(), &*names[0], &*names[29]), (30, "000001.png", "000030.png"));
    let before = image::open(here.join("drawn/000010.png")).unwrap().to_rgb8();
    assert_eq!(before.dimensions(), (160, 120));
    let has = |frame: &image::RgbImage, rgb: [u8; 3]| frame.pixels().any(|pixel| pixel.0 == rgb);
    let after = image::open(here.join("drawn/000025.png")).unwrap().to_rgb8();
    let (green, vermilion) = ([0x00, 0x9E, 0x73], [0xD5, 0x5E, 0x00]);
    assert!(has(&before, green) && !has(&before, vermilion));
    assert!(has(&after, vermilion) && !has(&after, green));

    // The same bytes again, for one thread as for many.
    let (page, svg) = (std::fs::read(here.join("page.html")).unwrap(), svg.into_bytes());
    let again = trackfail()
        .current_dir(here)
        .env("RAYON_NUM_THREADS", "1")
        .args(["detect", "--method", "Displacement", "--boxes", "clip.txt", "--frames", "suite/Girl/img"])
        .args(["--report", "page2.html", "--plot", "plot2.svg"])
        .output()
        .unwrap();
    assert!(again.status.success());
    assert_eq!(std::fs::read(here.join("plot2.svg")).unwrap(), svg);
    let series = |page: &[u8]| {
        let page = String::from_utf8(page.to_vec()).unwrap();
        let at = page.find("id=\"series\"").unwrap();
        page[at..].to_string()
    };
    assert_eq!(series(&std::fs::read(here.join("page2.html")).unwrap()), series(&page));
}

#[test]
fn outputs_that_cannot_be_written_are_told_before_the_work() {
    let root = tempfile::tempdir().unwrap();
    let (img, boxes) = clip(root.path());
    let run = |frames: bool, more: &[&str]| {
        let mut command = trackfail();
        command.current_dir(root.path()).args(["detect", "--boxes"]).arg(&boxes).args(more);
        if frames {
            command.arg("--frames").arg(&img);
        }
        let output = command.output().unwrap();
        assert!(output.stdout.is_empty(), "{more:?}");
        (output.status.code().unwrap(), text(output.stderr))
    };
    for (more, frames, code, words) in [
        (["--plot", "a.gif"], true, 2, "a .svg, a .pdf or a .png file"),
        (["--annotate", "a.gif"], true, 2, ".mp4, .mov, .mkv, .avi"),
        (["--annotate", "a.mp4"], false, 2, "give --frames"),
        (["--report", "none/a.html"], true, 1, "there is no folder none; make it first"),
        (["--plot", "none/a.svg"], true, 1, "there is no folder none"),
        (["--annotate", "none/a.mp4"], true, 1, "there is no folder none"),
        (["--annotate", "none/drawn"], true, 1, "there is no folder none"),
    ] {
        let (got, message) = run(frames, &more);
        assert!(got == code && message.contains(words), "{more:?}: {got} {message}");
    }
    assert!(!root.path().join("none").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn links_and_devices_are_written_to() {
    let root = tempfile::tempdir().unwrap();
    let here = root.path();
    std::fs::write(here.join("page.html"), "old").unwrap();
    std::os::unix::fs::symlink("page.html", here.join("link.html")).unwrap();
    let output = drawn(here, &["--report", "link.html"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(output.stderr));
    assert!(here.join("link.html").is_symlink());
    assert!(std::fs::read_to_string(here.join("page.html")).unwrap().contains("Lost since frame 20"));
    let output = drawn(here, &["--report", "/dev/full"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(output.stderr).contains("/dev/full: "));
    use std::os::unix::fs::FileTypeExt;
    assert!(std::fs::symlink_metadata("/dev/full").unwrap().file_type().is_char_device());
}

#[needs(ffmpeg)]
#[test]
fn a_video_is_drawn_on() {
    let root = tempfile::tempdir().unwrap();
    let here = root.path();
    let output = drawn(here, &["--annotate", "drawn.mp4"]);
    assert!(output.status.success(), "{}", text(output.stderr));
    // The video is one that can be judged again, with as many frames.
    let again = trackfail()
        .current_dir(here)
        .args(["detect", "--frames", "drawn.mp4", "--boxes", "clip.txt", "--annotate", "again.mkv"])
        .output()
        .unwrap();
    assert!(again.status.success(), "{}", text(again.stderr));
    let mut command = trackfail();
    command.current_dir(here).env("PATH", "/nowhere");
    command.args(["detect", "--boxes", "clip.txt", "--frames", "suite/Girl/img", "--annotate", "none.mp4"]);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(3));
    assert!(text(output.stderr).contains("install it"));
    assert!(!here.join("none.mp4").exists());
}
