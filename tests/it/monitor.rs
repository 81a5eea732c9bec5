//! `trackfail monitor`: JSON lines in, JSON lines out.

use crate::tools::live::{Live, answers, jumping, lines, monitor};
#[cfg(target_os = "linux")]
use crate::tools::memory;
use crate::tools::{Place, Ran, needs};
use base64::Engine as _;
use serde_json::{Value, json};
#[cfg(target_os = "linux")]
use std::io::Write as _;
use std::path::{Path, PathBuf};
use trackfail::monitor::able;

const STATE: &str = "--method Displacement --state track.state";

/// A place with images of a rendered sequence, and the lines of its first box as that of all frames, with the truth as a
/// companion's.
fn rendered() -> (Place, Vec<PathBuf>, Vec<Value>) {
    let place = Place::new();
    let truth = place.render("synthetic-otb", "Tennis");
    let numbers = |line: &String| -> Value { line.split(',').map(|v| v.parse::<f64>().unwrap()).collect() };
    let boxes: Vec<Value> = truth.iter().map(numbers).collect();
    let images = place.list("suite/Tennis/img");
    let line = |(image, companion): (&PathBuf, &Value)| json!({"frame": image, "box": boxes[0], "companions": [companion], "confidence": 0.5});
    let all = images.iter().zip(&boxes).map(line).collect();
    (place, images, all)
}

#[test]
fn every_line_has_its_answer_at_once() {
    let place = Place::new();
    assert_eq!(monitor(&place, "", "").ends(0).all(), "");
    let mut live = Live::start(&place, "--method Displacement");
    for (t, line) in jumping(30, 20).iter().enumerate() {
        let answer = live.ask(line);
        assert_eq!(answer["index"], t);
        assert_eq!(answer["state"], if t < 20 { "tracking" } else { "lost" }, "{answer}");
        assert_eq!(answer["reasons"].as_array().unwrap().len(), usize::from(t == 20), "{answer}");
    }
    assert_eq!(live.ask(&json!({"box": null}))["state"], "absent");
    assert_eq!(live.end(), 0);
    // A byte order mark before the first line is none of it.
    let line = lines(&jumping(1, 9));
    let plain = monitor(&place, "", &line).ends(0).never_says("error");
    assert_eq!(monitor(&place, "", &format!("\u{feff}{line}")).out, plain.out);
    monitor(&place, "", &format!("{line}\u{feff}{line}")).says("expected value");
}

#[test]
fn broken_lines_are_answered_and_the_stream_goes_on() {
    let (place, _, all) = rendered();
    place.write("text.png", "no image");
    let frame = |frame: Value| json!({"frame": frame, "box": [1, 2, 3, 4]}).to_string();
    let gray = |width: usize| json!({"raw": {"width": width, "height": 1, "format": "gray", "data": "AAAA"}});
    let broken = [
        ("{\"box\": [1, 2".to_string(), "EOF"),
        (String::new(), "empty"),
        ("{\"box\": [1, 2, 0, 4]}".into(), "no area"),
        (frame(json!("text.png")), "text.png"),
        (frame(json!(place.root())), "not a file"),
        (frame(gray(3)), "those before had"),
        ("\u{1b}[2J \u{fffd}".into(), "protocol"),
    ];
    let whole = answers(&monitor(&place, "--method Watchdog", &lines(&all)).out);
    let between: String = broken.iter().map(|(line, _)| format!("{line}\n")).collect();
    let input = lines(&all[..40]) + &between + &lines(&all[40..]);
    let out = answers(&monitor(&place, "--method Watchdog", &input).ends(0).out);
    for (n, (answer, (line, words))) in out[40..].iter().zip(&broken).enumerate() {
        let error = answer["error"].as_str().unwrap_or_else(|| panic!("{line}: {answer}"));
        assert!(error.contains(words), "{line}: {error}");
        assert_eq!(answer["index"], 40 + n);
    }
    let mut others = [&out[..40], &out[40 + broken.len()..]].concat();
    others.iter_mut().enumerate().for_each(|(t, answer)| answer["index"] = t.into());
    assert_eq!(others, whole);
    assert!(whole.iter().any(|answer| answer["state"] == "lost"));
}

#[test]
fn one_frame_may_come_in_many_forms() {
    let (place, images, all) = rendered();
    let mut forms: [String; 4] = Default::default();
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
    let answers = forms.map(|input| monitor(&place, "--method 'First colors'", &input).out);
    assert_eq!(answers[0].lines().count(), 30);
    assert!(answers.iter().all(|other| *other == answers[0]));
}

#[test]
fn boxes_may_count_from_one() {
    let (place, _, all) = rendered();
    let mut shifted = all.clone();
    for line in &mut shifted {
        for at in ["/box/0", "/box/1", "/companions/0/0", "/companions/0/1"] {
            let value = line.pointer_mut(at).unwrap();
            *value = json!(value.as_f64().unwrap() + 1.0);
        }
    }
    for method in ["--method Watchdog", "--method Companions"] {
        let zero = monitor(&place, method, &lines(&all)).ends(0);
        assert_eq!(monitor(&place, &format!("{method} --base 1"), &lines(&shifted)).all(), zero.all());
    }
}

// Two writers of one state would each undo what the other has written.
#[test]
fn one_monitor_at_a_time_has_a_state() {
    let place = Place::new();
    let all = jumping(20, 9);
    let mut live = Live::start(&place, STATE);
    live.ask(&all[0]);
    let kept = place.bytes("track.state");
    let second = |line: &str| {
        let told = "track.state: another `trackfail monitor` has its state there";
        monitor(&place, line, &lines(&all)).refuses(3, told);
        assert_eq!(place.bytes("track.state"), kept);
    };
    second(STATE);
    // Under another name it is the same state.
    std::os::unix::fs::symlink(place.path("track.state"), place.path("link")).unwrap();
    second("--method Displacement --state link");
    // The first one goes on as if nothing had been, and another state is free.
    assert_eq!(live.ask(&all[1])["index"], 1);
    monitor(&place, "--state other.state", &lines(&all)).ends(0);
    assert_eq!(live.end(), 0);
    // A process that is killed leaves the state to the next one.
    let mut live = Live::start(&place, STATE);
    assert_eq!(live.ask(&all[2])["index"], 2);
    live.kill();
    monitor(&place, STATE, &lines(&all[2..3])).ends(0);
}

#[test]
fn a_state_that_cannot_be_used_says_why() {
    let place = Place::new();
    let input = lines(&jumping(5, 9));
    monitor(&place, "--base 1 --inputs confidence --budget 2 --state track.state", &input).ends(0);
    let kept = place.bytes("track.state");
    let from_1 = "boxes that count pixels from 1, not from 0; remove the file to begin anew";
    let inputs = "one for boxes, confidence, not for boxes, frames, confidence";
    for (file, line, code, words) in [
        (&kept[..], "--method Scale --state track.state", 3, "`, not of `Scale`"),
        (&kept[..kept.len() - 3], "--state track.state", 3, "the state is damaged; remove the file"),
        (&kept, "--base 0 --state track.state", 3, from_1),
        (&kept, "--inputs frames,confidence --state track.state", 3, inputs),
        (&kept, "--budget 3 --state track.state", 3, "a budget of 2, not with a budget of 3"),
        (&kept, "--state .", 2, "no regular file"),
        (&kept, "--state no/such/folder", 2, "no such folder"),
        (&kept, "--method Displacment", 2, "did you mean `Displacement`?"),
        (&kept, "--method ARTE", 2, "methods that can monitor: "),
        (&kept, "--state-every 3", 2, "--state <FILE>"),
        (&kept, "--state /dev/null", 2, "no regular file"),
    ] {
        place.write("track.state", file);
        monitor(&place, line, &input).refuses(code, words);
        assert_eq!(place.bytes("track.state"), file, "{line}");
    }
    // A link is written through; what is not said is that of the state.
    std::os::unix::fs::symlink(place.path("track.state"), place.path("link")).unwrap();
    monitor(&place, "--state link", &input).ends(0);
    assert!(place.path("link").is_symlink() && place.bytes("track.state") != kept);
}

#[test]
fn a_stopped_stream_keeps_its_state() {
    let place = Place::new();
    let all = jumping(40, 20);
    let mut told = Vec::new();
    for (part, signal) in all.chunks(10).zip(["-TERM", "-INT", "-HUP", "-TERM"]) {
        let mut live = Live::start(&place, STATE);
        told.extend(part.iter().map(|line| live.ask(line)));
        live.signal(signal);
        assert_eq!(live.child.wait().unwrap().code(), Some(130), "{signal}");
    }
    assert_eq!(told, answers(&monitor(&place, "--method Displacement", &lines(&all)).out));

    // A process that is killed has kept its state up to a multiple of the lines that were asked for.
    place.remove("track.state");
    let mut live = Live::start(&place, &format!("{STATE} --state-every 10"));
    jumping(25, 99).iter().for_each(|line| drop(live.ask(line)));
    live.kill();
    let mut again = Live::start(&place, STATE);
    assert_eq!(again.ask(&jumping(21, 99)[20])["index"], 20);
    assert_eq!(again.end(), 0);
}

#[cfg(target_os = "linux")]
#[test]
fn answers_that_nobody_reads_pile_up_nowhere() {
    let place = Place::new();
    let mut live = Live::start(&place, STATE);
    let line = json!({"box": [1, 1, 20, 20]});
    live.ask(&line);
    let before = memory(live.child.id(), "VmRSS:");
    let mut input = live.input.take().unwrap();
    // Far more than pipes hold; the writer is stuck until the program ends.
    let writer = std::thread::spawn(move || {
        let line = format!("{line}\n");
        (0..400_000).take_while(|_| input.write_all(line.as_bytes()).is_ok()).count()
    });
    std::thread::sleep(std::time::Duration::from_secs(2));
    assert!(!writer.is_finished(), "the program reads on though nobody takes its answers");
    let grown = memory(live.child.id(), "VmRSS:").saturating_sub(before);
    assert!(grown < 2048, "{grown} KiB");
    live.signal("-TERM");
    assert_eq!(live.child.wait().unwrap().code(), Some(130));
    assert!(writer.join().unwrap() < 400_000);
    let answer = answers(&monitor(&place, "--state track.state", "{}\n").out).remove(0);
    assert!(answer["index"].as_u64().unwrap() > 100, "{answer}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_closed_pipe_ends_the_stream_and_a_full_disk_breaks_it() {
    let place = Place::new();
    let state = "monitor --method Displacement --state track.state";
    place.write("lines", lines(&jumping(50, 20)));
    // The reader is gone before the program writes.
    let closed = place.shell(&format!("{{ sleep 1; trackfail {state} < lines; echo $? >&2; }} | true"));
    assert_eq!(closed.err, "0\n");
    place.remove("track.state");
    let full = place.shell(&format!("trackfail {state} < lines > /dev/full"));
    full.ends(1).tells("stdout: No space left on device");
    assert!(place.has("track.state"), "the state is kept");
    // No file may grow beyond nothing: the state cannot be written.
    place.remove("track.state");
    let limited = format!("trap '' XFSZ; ulimit -f 0; trackfail {state} --state-every 10 < lines");
    place.shell(&limited).ends(1).tells("track.state");
    assert!(!place.has("track.state"));
}

/// The example in Python, or a script that uses it.
fn python(place: &Place, script: &str, arguments: &[&str]) -> String {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut command = assert_cmd::Command::new("python3");
    command.env("PYTHONPATH", &examples).env("PYTHONDONTWRITEBYTECODE", "1").current_dir(place.root());
    match script.ends_with(".py") {
        true => command.arg(examples.join(script)),
        false => command.args(["-c", script]),
    };
    Ran::of(command.args(arguments)).ends(0).out
}

#[needs(python)]
#[test]
fn the_python_file_asks_and_is_answered() {
    let (place, images, all) = rendered();
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
    let [first, second] = [0, 1].map(|k: usize| images[k].to_str().unwrap());
    let told = python(&place, script, &[env!("CARGO_BIN_EXE_trackfail"), first, second, &boxes]);
    let told: Vec<&str> = told.lines().collect();
    assert_eq!(told[..2], ["tracking", "absent"]);
    assert!(told[2].starts_with("the frame has 3x2 pixels"), "{told:?}");
    assert_eq!(told[3..], ["3 tracking []", "trackfail monitor has ended with exit code 130"]);
    assert!(std::fs::read_to_string("examples/trackfail_monitor.py").unwrap().lines().count() <= 60);
}

/// Output of the example for trackers of OpenCV on the images that a pattern names.
fn opencv(place: &Place, more: &[&str], pattern: &str) -> String {
    let program = ["--program", env!("CARGO_BIN_EXE_trackfail")];
    python(place, "monitor_opencv.py", &[&program[..], more, &[pattern]].concat())
}

#[needs(opencv)]
#[test]
fn trackers_of_opencv_are_monitored_live() {
    let (place, images, all) = rendered();
    let first: Vec<String> = all[0]["box"].as_array().unwrap().iter().map(Value::to_string).collect();
    for tracker in ["kcf", "csrt"] {
        let more = ["--tracker", tracker, "--box", &first.join(",")];
        let told = opencv(&place, &more, "suite/Tennis/img/%04d.png");
        let mut lines = told.lines();
        assert!(lines.next().unwrap().starts_with("0 tracking"), "{told}");
        assert!(lines.last().unwrap().starts_with(&format!("{} frames, ", images.len())), "{told}");
    }
}

/// Frames of a stand-in for a webcam: a speckled target on a plain wall, which is gone in frames 40 to 69 and comes back
/// elsewhere. Returns where it is in each frame.
fn goes_and_comes_back(scene: &Place) -> Vec<Option<(u32, u32)>> {
    let grain = |x: u32, y: u32| [(x * 97 + y * 61) % 251, (x * 43 + y * 149) % 241, (x * 7 + y * 211) % 239];
    let wall = |x: u32, y: u32| [90 + (x + y) % 5, 100 + x % 7, 110 + y % 3];
    let place = |t: u32| match t {
        0..40 => Some((40 + t / 2, 50)),
        40..70 => None,
        _ => Some((180 - (t - 70) / 2, 90)),
    };
    scene.frames("0000.png", 120, (260, 160), |t, x, y| {
        let inside = place(t).filter(|(u, v)| (*u..u + 32).contains(&x) && (*v..v + 32).contains(&y));
        // Grains of four pixels, so that correlation trackers have something to hold on to.
        let color = inside.map_or_else(|| wall(x, y), |(u, v)| grain((x - u) / 4, (y - v) / 4));
        color.map(|value| value as u8)
    });
    (0..120).map(place).collect()
}

#[needs(opencv)]
#[test]
fn a_target_that_comes_back_is_found_and_judged_anew() {
    let place = Place::new();
    let places = goes_and_comes_back(&place);
    let told = opencv(&place, &["--redetect", "--box", "40,50,32,32"], "%04d.png");
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
    let (place, _, mut all) = rendered();
    let known = able();
    let methods: String = known.iter().map(|method| format!(" --method '{method}'")).collect();
    // Of the frames some lack a confidence, some a box, but not the first.
    for (t, line) in all.iter_mut().enumerate() {
        line["confidence"] = json!(0.3 + 0.6 / (1.0 + (t / 7) as f64) + 0.01 * (t % 5) as f64);
        if t % 13 > 10 {
            line["box"] = Value::Null;
        }
        if [2, 3, 7].contains(&(t % 8)) {
            line["confidence"] = Value::Null;
        }
    }
    for (name, at) in [("boxes", "/box"), ("companions", "/companions/0"), ("confidence", "/confidence")] {
        let row = |line: &Value| match line.pointer(at).unwrap() {
            Value::Array(values) => values.iter().map(Value::to_string).collect::<Vec<_>>().join(",") + "\n",
            Value::Null if name == "boxes" => "NaN,NaN,NaN,NaN\n".into(),
            number => number.to_string().replace("null", "NaN") + "\n",
        };
        place.write(name, all.iter().map(row).collect::<String>());
    }
    let detect = "detect --absent --base 0 --boxes-format xywh --format csv --frames suite/Tennis/img --boxes boxes \
                  --companion companions --confidence confidence";
    let whole = place.run(&format!("{detect}{methods}")).ends(0).rows();
    for method in &known {
        let of_method: Vec<_> = whole.iter().filter(|row| row["method"] == *method).collect();
        let live = answers(&monitor(&place, &format!("--method '{method}'"), &lines(&all)).out);
        assert_eq!(of_method.len(), live.len(), "{method}");
        for (row, answer) in of_method.iter().zip(&live) {
            assert_eq!(answer["state"], row["state"], "{method}: {answer} {row:?}");
        }
    }
}

// A wrong box is that of its target, and a whole float is the id that the integer is.
#[test]
fn an_answer_names_its_target() {
    let boxed = json!({"id": 7.0, "box": [1, 2, 30, 30]});
    let all = [&json!({"id": 7, "box": "none"}), &boxed, &json!({"id": 7, "end": true}), &json!({"id": 1.5})];
    let answers = answers(&monitor(&Place::new(), "--method Displacement", &lines(all)).ends(0).out);
    let [wrong, good, ended, nobody] = &answers[..] else { panic!("{answers:?}") };
    assert!(wrong["id"] == 7 && wrong["error"].as_str().unwrap().starts_with("box: invalid type"), "{wrong}");
    assert!(good["id"] == 7 && good["state"] == "tracking" && ended["ended"] == true, "{answers:?}");
    assert!(nobody["error"].as_str().unwrap().contains("a whole number or a text"), "{nobody}");
}

#[test]
fn an_error_quotes_no_more_than_a_part_of_a_line() {
    let key = "k".repeat(500_000);
    let input = format!("{{\"{key}\": 1}}\n{{\"confidence\": \"{key}\"}}\n{{\"frame\": \"{key}\"}}\n");
    let ran = monitor(&Place::new(), "--method Watchdog", &input).ends(0);
    assert_eq!(ran.out.lines().count(), 3);
    for line in ran.out.lines() {
        assert!(line.contains("\"error\":\"") && line.len() < 1200, "{line:.300}");
    }
}

// Numbers and `null` take eight times the memory of their text, and lists twice that while they grow: a line of 180 MB took
// 2.95 GB. Now it is the line, with room to grow, and perhaps a second one.
#[cfg(target_os = "linux")]
#[test]
fn a_long_line_takes_few_times_its_size() {
    const BYTES: usize = 6 << 20;
    let ones = "1,".repeat(BYTES / 2) + "1";
    let raw = r#"{"raw": {"width": 1, "height": 1, "format": "gray", "data": "AA=="}}"#;
    let long = [
        format!("{{\"box\": [{ones}]}}"),
        format!("{{\"frame\": {raw}, \"companions\": [[{ones}]]}}"),
        format!("{{\"frame\": \"{ones}\"}}"),
    ];
    let place = Place::new();
    let mut live = Live::start(&place, "--method Displacement");
    assert_eq!(live.ask(&json!({"box": [1, 1, 20, 20]}))["state"], "tracking");
    let peak = |live: &Live| memory(live.child.id(), "VmHWM:");
    let before = peak(&live);
    for (n, line) in long.iter().enumerate() {
        let answer = live.ask_text(line);
        assert_eq!(answer["index"], n + 1);
        let error = answer["error"].as_str().unwrap_or_default();
        assert!(error.contains("the line is longer than 1 MiB"), "{answer:.300}");
    }
    let grown = peak(&live) - before;
    assert!(grown < 5 * BYTES as u64 / 1024, "{grown} KiB");
    // The stream goes on.
    assert_eq!(live.ask(&json!({"box": [2, 1, 20, 20]}))["state"], "tracking");
    assert_eq!(live.end(), 0);
}
