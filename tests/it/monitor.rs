//! `trackfail monitor`: JSON lines in, JSON lines out.

use crate::live::{Live, jumping, lines, monitor};
#[cfg(target_os = "linux")]
use crate::tools::resident;
use crate::tools::{needs, rows, trackfail};
use base64::Engine as _;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;
#[cfg(target_os = "linux")]
use std::{io::Write, process::Stdio};
use trackfail::monitor::{Monitor, MonitorError, Options};

/// Images of a rendered sequence, and the lines of its first box as that of all frames, with the truth as a companion's.
fn rendered(root: &Path) -> (Vec<PathBuf>, Vec<Value>) {
    let target = root.join("suite");
    trackfail()
        .args(["data", "render", "synthetic-otb", "--sequence", "Tennis"])
        .arg(&target)
        .assert()
        .success();
    let mut images: Vec<PathBuf> = walkdir::WalkDir::new(&target)
        .into_iter()
        .map(|e| e.unwrap().into_path())
        .filter(|p| p.extension().is_some_and(|e| e == "png" || e == "jpg"))
        .collect();
    images.sort();
    let truth = walkdir::WalkDir::new(&target).into_iter().map(|e| e.unwrap().into_path());
    let truth = truth.filter(|p| p.ends_with("groundtruth_rect.txt")).last().unwrap();
    let boxes: Vec<Value> = std::fs::read_to_string(truth)
        .unwrap()
        .lines()
        .map(|line| line.split([',', '\t']).map(|v| v.parse::<f64>().unwrap()).collect())
        .collect();
    let line = |(image, companion): (&PathBuf, &Value)| json!({"frame": image, "box": boxes[0], "companions": [companion], "confidence": 0.5});
    let all = images.iter().zip(&boxes).map(line).collect();
    (images, all)
}

#[test]
fn every_line_has_its_answer_at_once() {
    let mut live = Live::start(&["--method", "Displacement"]);
    for (t, line) in jumping(30, 20).iter().enumerate() {
        let answer = live.ask(line);
        let state = if t < 20 { "tracking" } else { "lost" };
        assert_eq!(
            (answer["index"].as_u64(), answer["state"].as_str()),
            (Some(t as u64), Some(state)),
            "{answer}"
        );
        let reasons = answer["reasons"].as_array().unwrap();
        assert_eq!(reasons.len(), usize::from(t == 20), "{answer}");
    }
    assert_eq!(live.ask(&json!({"box": null}))["state"], "absent");
    assert_eq!(live.end(), 0);
}

#[test]
fn before_the_first_box_the_target_is_absent() {
    let input = lines([json!({}), json!({"box": null}), json!({"box": [1, 2, 30, 30]})]);
    let (code, out, err) = monitor(&[], &input);
    let states: Vec<Value> =
        out.lines().map(|l| serde_json::from_str::<Value>(l).unwrap()["state"].clone()).collect();
    assert_eq!((code, states), (0, vec![json!("absent"), json!("absent"), json!("tracking")]));
    assert!(err.starts_with("method: "), "{err}");
    assert_eq!(monitor(&[], ""), (0, String::new(), String::new()));
}

#[test]
fn a_budget_alone_is_enough() {
    let boxes = lines(jumping(30, 20));
    let confident = lines(jumping(30, 20).into_iter().map(|mut line| {
        line["confidence"] = json!(0.5);
        line
    }));
    for (input, method) in [(boxes, "Fused boxes"), (confident, "Fused boxes")] {
        let (code, out, err) = monitor(&["--budget", "2"], &input);
        assert_eq!((code, err), (0, format!("method: {method}\n")));
        // Of a method that is named, no note says that there are no frames.
        let note = format!(",\"note\":\"without frames: {method}, until frames come\"");
        assert_eq!(monitor(&["--budget", "2", "--method", method], &input).1, out.replacen(&note, "", 1));
        assert!(!out.contains("\"error\""), "{out}");
    }
    let (code, out, err) = monitor(&["--budget", "0"], &lines(jumping(3, 9)));
    assert!(
        code == 2 && out.is_empty() && err.contains("it is a number above 0: false alarms per 1000 frames"),
        "{err}"
    );
}

#[test]
fn broken_lines_are_answered_and_the_stream_goes_on() {
    let root = tempfile::tempdir().unwrap();
    let (images, all) = rendered(root.path());
    let text = root.path().join("text.png");
    std::fs::write(&text, "no image").unwrap();
    let gray = |width: usize| json!({"raw": {"width": width, "height": 1, "format": "gray", "data": "AAAA"}});
    let broken = [
        ("{\"box\": [1, 2".to_string(), "EOF"),
        (String::new(), "empty"),
        ("[1, 2, 3, 4]".to_string(), "invalid"),
        (json!({"boxes": [[1, 2, 3, 4]]}).to_string(), "unknown field `boxes`"),
        (json!({"box": [1, 2, 3]}).to_string(), "box: "),
        (json!({"box": [1, 2, 0, 4]}).to_string(), "no area"),
        (json!({"frame": "missing.png", "box": [1, 2, 3, 4]}).to_string(), "missing.png"),
        (json!({"frame": text, "box": [1, 2, 3, 4]}).to_string(), "text.png"),
        (json!({"frame": root.path(), "box": [1, 2, 3, 4]}).to_string(), "not a file"),
        (json!({"frame": gray(4), "box": [1, 2, 3, 4]}).to_string(), "4 bytes, not 3"),
        (json!({"frame": gray(3), "box": [1, 2, 3, 4]}).to_string(), "those before had"),
        ("\u{1b}[2J \u{fffd}".to_string(), "protocol"),
    ];
    let whole = monitor(&["--method", "Watchdog"], &lines(all.clone())).1;
    let mut input = lines(all[..40].to_vec());
    input.extend(broken.iter().map(|(line, _)| format!("{line}\n")));
    input += &lines(all[40..].to_vec());
    let (code, out, _) = monitor(&["--method", "Watchdog"], &input);
    assert_eq!((code, out.lines().count()), (0, images.len() + broken.len()));
    let read = |text: &str| text.lines().map(|l| serde_json::from_str(l).unwrap()).collect::<Vec<Value>>();
    let (out, whole) = (read(&out), read(&whole));
    for (n, (answer, (line, words))) in out[40..].iter().zip(&broken).enumerate() {
        let error = answer["error"].as_str().unwrap_or_else(|| panic!("{line}: {answer}"));
        assert!(error.contains(words), "{line}: {error}");
        assert_eq!(answer["index"], 40 + n);
    }
    for (t, want) in whole.iter().enumerate() {
        let n = if t < 40 { t } else { t + broken.len() };
        let mut want = want.clone();
        want["index"] = n.into();
        assert_eq!(out[n], want);
    }
    assert!(whole.iter().any(|answer| answer["state"] == "lost"));
}

#[test]
fn one_frame_may_come_in_many_forms() {
    let root = tempfile::tempdir().unwrap();
    let (images, all) = rendered(root.path());
    let mut forms = vec![String::new(); 4];
    for (image, line) in images.iter().zip(&all).take(30) {
        let picture = image::open(image).unwrap().into_rgb8();
        let mut bgr = picture.clone().into_raw();
        bgr.as_chunks_mut::<3>().0.iter_mut().for_each(|pixel| pixel.swap(0, 2));
        let data = |bytes: &[u8]| base64::engine::general_purpose::STANDARD.encode(bytes);
        let (width, height) = picture.dimensions();
        let raw = |format: &str, bytes: &[u8]| json!({"raw": {"width": width, "height": height, "format": format, "data": data(bytes)}});
        let kept = image.with_extension("bgr");
        std::fs::write(&kept, &bgr).unwrap();
        let file = json!({"raw": {"width": width, "height": height, "format": "bgr", "path": kept}});
        let frames = [json!(image), raw("rgb", picture.as_raw()), raw("bgr", &bgr), file];
        for (form, frame) in forms.iter_mut().zip(frames) {
            let mut line = line.clone();
            line["frame"] = frame;
            *form += &format!("{line}\n");
        }
    }
    let answers = forms.iter().map(|input| monitor(&["--method", "First colors"], input).1);
    let answers: Vec<String> = answers.collect();
    assert_eq!(answers[0].lines().count(), 30);
    assert!(answers.iter().all(|other| *other == answers[0]));
}

#[test]
fn boxes_may_count_from_one() {
    let root = tempfile::tempdir().unwrap();
    let (_, all) = rendered(root.path());
    let shifted = all.iter().map(|line| {
        let mut line = line.clone();
        for place in ["/box/0", "/box/1", "/companions/0/0", "/companions/0/1"] {
            let value = line.pointer_mut(place).unwrap();
            *value = json!(value.as_f64().unwrap() + 1.0);
        }
        line
    });
    for method in ["Watchdog", "Companions"] {
        let zero = monitor(&["--method", method], &lines(all.clone()));
        assert_eq!(monitor(&["--method", method, "--base", "1"], &lines(shifted.clone())), zero);
    }
}

#[test]
fn a_kept_state_goes_on_as_if_nothing_had_happened() {
    let root = tempfile::tempdir().unwrap();
    let (_, all) = rendered(root.path());
    let state = root.path().join("track.state");
    let state = state.to_str().unwrap();
    for method in ["Watchdog", "Companions", "Displacement"] {
        let whole = monitor(&["--method", method], &lines(all.clone())).1;
        let mut parts = String::new();
        for part in all.chunks(all.len() / 4) {
            let (code, out, _) = monitor(&["--method", method, "--state", state], &lines(part.to_vec()));
            assert_eq!(code, 0);
            parts += &out;
        }
        assert_eq!(parts, whole, "{method}");
        std::fs::remove_file(state).unwrap();
    }
}

#[test]
fn a_state_that_cannot_be_used_says_why() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("track.state");
    let state = path.to_str().unwrap();
    let input = lines(jumping(5, 9));
    let (code, _, _) = monitor(&["--method", "Displacement", "--state", state], &input);
    assert_eq!(code, 0);
    let kept = std::fs::read(&path).unwrap();
    let refused = |arguments: &[&str], code: i32, words: &str| {
        let (got, out, err) = monitor(arguments, &input);
        assert_eq!((got, out.as_str()), (code, ""), "{arguments:?}: {err}");
        assert!(err.contains(words), "{arguments:?}: {err}");
    };
    refused(&["--method", "Scale", "--state", state], 3, "method `Displacement`, not of `Scale`");
    std::fs::write(&path, &kept[..kept.len() - 3]).unwrap();
    refused(&["--state", state], 3, "track.state: the state is damaged; remove the file");
    std::fs::write(&path, "").unwrap();
    refused(&["--state", state], 3, "not a state");
    refused(&["--state", root.path().to_str().unwrap()], 2, "no regular file");
    refused(&["--state", root.path().join("no/such/folder").to_str().unwrap()], 2, "no such folder");
    refused(&["--method", "Displacment"], 2, "did you mean `Displacement`?");
    refused(&["--method", "ARTE"], 2, "methods that can monitor: ");
    refused(&["--state-every", "3"], 2, "--state <FILE>");
    #[cfg(unix)]
    {
        refused(&["--state", "/dev/null"], 2, "no regular file");
        // A link is written through.
        std::fs::remove_file(&path).unwrap();
        let link = root.path().join("link");
        std::fs::write(&path, &kept).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        assert_eq!(monitor(&["--state", link.to_str().unwrap()], &input).0, 0);
        assert!(link.is_symlink() && std::fs::read(&path).unwrap() != kept);
    }
}

#[cfg(unix)]
#[test]
fn a_stopped_stream_keeps_its_state() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("track.state");
    let arguments = ["--method", "Displacement", "--state", path.to_str().unwrap()];
    let all = jumping(40, 20);
    let mut answers = Vec::new();
    for (part, signal) in all.chunks(10).zip(["-TERM", "-INT", "-HUP", "-TERM"]) {
        let mut live = Live::start(&arguments);
        answers.extend(part.iter().map(|line| live.ask(line)));
        live.signal(signal);
        assert_eq!(live.child.wait().unwrap().code(), Some(130), "{signal}");
    }
    let whole = monitor(&arguments[..2], &lines(all)).1;
    let whole: Vec<Value> = whole.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(answers, whole);

    // A process that is killed has kept its state up to a multiple of the lines that were asked for.
    std::fs::remove_file(&path).unwrap();
    let mut live = Live::start(&[&arguments[..], &["--state-every", "10"]].concat());
    jumping(25, 99).iter().for_each(|line| drop(live.ask(line)));
    live.kill();
    let mut again = Live::start(&arguments);
    assert_eq!(again.ask(&jumping(21, 99)[20])["index"], 20);
    assert_eq!(again.end(), 0);
}

#[cfg(target_os = "linux")]
#[test]
fn answers_that_nobody_reads_pile_up_nowhere() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("track.state");
    let mut live = Live::start(&["--method", "Displacement", "--state", path.to_str().unwrap()]);
    live.ask(&json!({"box": [1, 1, 20, 20]}));
    let before = resident(live.child.id());
    let mut input = live.input.take().unwrap();
    // Far more than pipes hold; the writer is stuck until the program ends.
    let writer = std::thread::spawn(move || {
        let line = format!("{}\n", json!({"box": [1, 1, 20, 20]}));
        (0..400_000).take_while(|_| input.write_all(line.as_bytes()).is_ok()).count()
    });
    std::thread::sleep(std::time::Duration::from_secs(2));
    assert!(!writer.is_finished(), "the program reads on though nobody takes its answers");
    let grown = resident(live.child.id()).saturating_sub(before);
    assert!(grown < 2048, "{grown} KiB");
    live.signal("-TERM");
    assert_eq!(live.child.wait().unwrap().code(), Some(130));
    assert!(writer.join().unwrap() < 400_000);
    let (_, out, _) = monitor(&["--state", path.to_str().unwrap()], "{}\n");
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert!(answer["index"].as_u64().unwrap() > 100, "{answer}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_closed_pipe_ends_the_stream_and_a_full_disk_breaks_it() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("track.state");
    let arguments = ["--method", "Displacement", "--state", path.to_str().unwrap()];
    let input = lines(jumping(50, 20));
    let start = |stdout: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
        command.arg("monitor").args(arguments).stdin(Stdio::piped()).stdout(stdout).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        drop(child.stdout.take());
        let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
        let output = child.wait_with_output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    assert_eq!(start(Stdio::piped()), (Some(0), String::new()));
    std::fs::remove_file(&path).unwrap();
    let full = std::fs::File::create("/dev/full").unwrap();
    let (code, message) = start(full.into());
    assert_eq!(code, Some(1));
    assert!(message.contains("stdout: No space left on device"), "{message}");
    assert!(path.is_file(), "the state is kept");

    // No file may grow beyond nothing: the state cannot be written.
    std::fs::remove_file(&path).unwrap();
    let script = "trap '' XFSZ; ulimit -f 0; exec \"$0\" monitor --method Displacement --state \"$1\" --state-every 10";
    let mut limited = assert_cmd::Command::new("sh");
    limited.args(["-c", script, env!("CARGO_BIN_EXE_trackfail"), path.to_str().unwrap()]);
    let output = limited.write_stdin(input).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("track.state") && !path.exists(), "{message}");
}

/// The example in Python, started in a folder.
fn python(folder: &Path, script: &str, arguments: &[&str]) -> String {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut command = Command::new("python3");
    command.env("PYTHONPATH", &examples).env("PYTHONDONTWRITEBYTECODE", "1").current_dir(folder);
    let output = command.arg(if script.ends_with(".py") {
        examples.join(script).into_os_string()
    } else {
        "-c".into()
    });
    let output = if script.ends_with(".py") { output } else { output.arg(script) };
    let output = output.args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[needs(python)]
#[test]
fn the_python_file_asks_and_is_answered() {
    let root = tempfile::tempdir().unwrap();
    let (images, all) = rendered(root.path());
    let boxes = all[0]["box"].to_string();
    let script = r#"
import pathlib, sys
from trackfail_monitor import Monitor
program, first, second, box = sys.argv[1:]
class Picture:
    shape = (2, 3)
    def tobytes(self): return bytes(6)
with Monitor("--method", "Watchdog", program=program) as monitor:
    box = eval(box)
    print(monitor.update(first, box)["state"])
    print(monitor.update(pathlib.Path(second), None)["state"])
    try:
        monitor.update(Picture(), [float("nan")] * 4)
    except ValueError as error:
        print(error)
    answer = monitor.update(first, box, 0.5, [box, None])
    print(answer["index"], answer["state"], answer["reasons"])
    monitor.process.terminate()
    monitor.process.wait()
    try:
        monitor.update(None, box)
    except RuntimeError as error:
        print(error)
"#;
    let name = |image: &Path| image.to_str().unwrap().to_string();
    let arguments = [env!("CARGO_BIN_EXE_trackfail"), &name(&images[0]), &name(&images[1]), &boxes];
    let told = python(root.path(), script, &arguments);
    let told: Vec<&str> = told.lines().collect();
    assert_eq!(told[..2], ["tracking", "absent"]);
    assert!(told[2].starts_with("the frame has 3x2 pixels"), "{told:?}");
    assert_eq!(told[3..], ["3 tracking []", "trackfail monitor has ended with exit code 130"]);
    let text = std::fs::read_to_string("examples/trackfail_monitor.py").unwrap();
    assert!(text.lines().count() <= 60);
}

#[needs(opencv)]
#[test]
fn trackers_of_opencv_are_monitored_live() {
    let root = tempfile::tempdir().unwrap();
    let (images, all) = rendered(root.path());
    let pattern =
        images[0].with_file_name(format!("%04d.{}", images[0].extension().unwrap().to_str().unwrap()));
    let first: Vec<String> = all[0]["box"].as_array().unwrap().iter().map(Value::to_string).collect();
    for tracker in ["kcf", "csrt"] {
        let arguments =
            ["--program", env!("CARGO_BIN_EXE_trackfail"), "--tracker", tracker, "--box", &first.join(",")];
        let told = python(
            root.path(),
            "monitor_opencv.py",
            &[&arguments[..], &[pattern.to_str().unwrap()]].concat(),
        );
        let mut lines = told.lines();
        assert!(lines.next().unwrap().starts_with("0 tracking"), "{told}");
        assert!(lines.last().unwrap().starts_with(&format!("{} frames, ", images.len())), "{told}");
    }
}

/// Frames of a stand-in for a webcam: a speckled target on a plain wall, which is gone in frames 40 to 69 and comes back
/// elsewhere. Returns where it is in each frame.
fn goes_and_comes_back(folder: &Path) -> Vec<Option<(u32, u32)>> {
    let speckle =
        |x: u32, y: u32| [(x * 97 + y * 61) % 251, (x * 43 + y * 149) % 241, (x * 7 + y * 211) % 239];
    let wall = |x: u32, y: u32| [90 + (x + y) % 5, 100 + x % 7, 110 + y % 3];
    let place = |t: u32| match t {
        0..40 => Some((40 + t / 2, 50)),
        40..70 => None,
        _ => Some((180 - (t - 70) / 2, 90)),
    };
    for t in 0..120 {
        let picture = image::RgbImage::from_fn(260, 160, |x, y| {
            let inside = place(t).filter(|(u, v)| (*u..u + 32).contains(&x) && (*v..v + 32).contains(&y));
            // Grains of four pixels, so that correlation trackers have something to hold on to.
            let color = inside.map_or_else(|| wall(x, y), |(u, v)| speckle((x - u) / 4, (y - v) / 4));
            image::Rgb(color.map(|value| value as u8))
        });
        picture.save(folder.join(format!("{:04}.png", t + 1))).unwrap();
    }
    (0..120).map(place).collect()
}

#[needs(opencv)]
#[test]
fn a_target_that_comes_back_is_found_and_judged_anew() {
    let root = tempfile::tempdir().unwrap();
    let places = goes_and_comes_back(root.path());
    let pattern = root.path().join("%04d.png");
    let arguments = ["--program", env!("CARGO_BIN_EXE_trackfail"), "--redetect", "--box", "40,50,32,32"];
    let told =
        python(root.path(), "monitor_opencv.py", &[&arguments[..], &[pattern.to_str().unwrap()]].concat());
    let lines: Vec<Vec<&str>> = told.lines().map(|line| line.split_whitespace().collect()).collect();
    let at = |words: &[&str]| lines.iter().position(|line| words.iter().all(|word| line.contains(word)));
    let gone = lines.iter().position(|line| ["lost", "absent"].contains(&line[1])).unwrap();
    let frame: usize = lines[gone][0].parse().unwrap();
    assert!((40..70).contains(&frame), "{told}");
    let found = at(&["found", "again"]).unwrap_or_else(|| panic!("{told}"));
    let number: Vec<u32> = lines[found][3..5].iter().map(|word| word.parse().unwrap()).collect();
    assert!(places[70..75].contains(&Some((number[0], number[1]))), "{told}");
    assert_eq!(lines[found + 1][1], "tracking", "{told}");
    assert!(lines[found + 2][1] == "frames,", "no loss after that: {told}");
}

// Before: where the tracker gave no confidence, methods had other states live than of the whole track.
#[test]
fn what_it_says_live_is_what_detect_says_of_the_whole() {
    let root = tempfile::tempdir().unwrap();
    let (images, all) = rendered(root.path());
    let Err(MonitorError::Unfit { known, .. }) =
        Monitor::new(&Options { method: Some("AVU".into()), ..Options::default() })
    else {
        panic!("AVU cannot monitor")
    };
    let [boxes, companions, confidence] =
        ["boxes", "companions", "confidence"].map(|name| root.path().join(name));
    // Shares of frames without a confidence and without a box, in eighths. The first frame has both.
    for (k, (silent, absent)) in [(0, 0), (3, 0), (5, 2), (1, 4)].into_iter().enumerate() {
        let lacks = |t: usize, salt: u64, share: u64| {
            t > 0 && (t as u64 + salt + 99 * k as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 61 < share
        };
        let mut input = all.clone();
        let (mut box_lines, mut companion_lines, mut confidence_lines) =
            (String::new(), String::new(), String::new());
        for (t, line) in input.iter_mut().enumerate() {
            let sure = 0.3 + 0.6 / (1.0 + (t / 7) as f64) + 0.01 * (t % 5) as f64;
            let numbers = |value: &Value| {
                value.as_array().unwrap().iter().map(Value::to_string).collect::<Vec<_>>().join(",") + "\n"
            };
            companion_lines += &numbers(&line["companions"][0]);
            if lacks(t, 1, absent) {
                line["box"] = Value::Null;
                box_lines += "NaN,NaN,NaN,NaN\n";
            } else {
                box_lines += &numbers(&line["box"]);
            }
            if lacks(t, 2, silent) {
                line["confidence"] = Value::Null;
                confidence_lines += "NaN\n";
            } else {
                line["confidence"] = json!(sure);
                confidence_lines += &format!("{sure}\n");
            }
        }
        for (path, text) in
            [(&boxes, box_lines), (&companions, companion_lines), (&confidence, confidence_lines)]
        {
            std::fs::write(path, text).unwrap();
        }
        let mut command = trackfail();
        command.args(["detect", "--absent", "--base", "0", "--boxes-format", "xywh", "--format", "csv"]);
        command.arg("--frames").arg(images[0].parent().unwrap()).arg("--boxes").arg(&boxes);
        command.arg("--companion").arg(&companions).arg("--confidence").arg(&confidence);
        known.iter().for_each(|method| {
            command.args(["--method", method]);
        });
        let whole = command.output().unwrap();
        assert!(whole.status.success(), "{}", String::from_utf8_lossy(&whole.stderr));
        let whole = rows(&String::from_utf8(whole.stdout).unwrap());
        let input = lines(input);
        for method in &known {
            let of_method: Vec<_> = whole.iter().filter(|row| row["method"] == *method).collect();
            let (_, live, _) = monitor(&["--method", method], &input);
            assert_eq!(of_method.len(), live.lines().count(), "{method}");
            for (row, line) in of_method.iter().zip(live.lines()) {
                let answer: Value = serde_json::from_str(line).unwrap();
                assert_eq!(answer["state"], row["state"], "{method}, {k}: {line} {row:?}");
            }
        }
    }
}

#[test]
fn a_byte_order_mark_before_the_first_line_is_none_of_it() {
    let line = json!({ "box": [10, 10, 20, 20] }).to_string() + "\n";
    let method = ["--method", "Displacement"];
    let (code, plain, _) = monitor(&method, &line);
    assert!(code == 0 && !plain.contains("error"), "{plain}");
    assert_eq!(monitor(&method, &format!("\u{feff}{line}")).1, plain);
    assert!(monitor(&method, &format!("{line}\u{feff}{line}")).1.contains("expected value"));
}
