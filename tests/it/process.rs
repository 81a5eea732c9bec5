//! Foreign programs as trackers, signals and detectors in whole runs, and our trackers for foreign programs.

use crate::engine::tally;
use crate::outside::{end, pid};
use crate::tools::{Place, Ran, corner, experiment, needs, trackfail, words};
use std::path::{Path, PathBuf};
use std::process::Command;
use trackfail::dataset::user_frames::without_frames;
use trackfail::dataset::{Frames, Sequence};
use trackfail::plugin::{self, Configured};
use trackfail::region::{Rect, Region};
use trackfail::spec::programs;
use trackfail::tracker::process::Bind;
use trackfail::tracker::{RunContext, TRACKERS, TrackerConfig, TrackerState};

const FRAMES: u32 = 140;
const SCORES: &str = "results/mine/try/scores.csv";

/// Answers the first region for ever.
const STILL: &str = "while read -r line; do case $line in quit) exit;; init*) region=$(printf '%s' \"$line\" | \
                     cut -f 3);; esac; echo \"$region\"; done\n";

const PLUGINS: &str = r#"[tracker]
still-in-sh = { command = ["sh", "tracker.sh"], protocol = "lines", version = "1", deterministic = true, digest = ["tracker.sh"] }
served = { command = ["PROGRAM", "serve-trax", "ncc"], version = "1", confidence = "confidence" }
hanging = { command = ["sh", "-c", "echo $$ > hanging.pid; (setsid sh -c 'echo $$ > away.pid; exec sleep 1000' &); sleep 1000 & echo $! > sleeping.pid; wait"], protocol = "lines", version = "1" }
leaving = { command = ["sh", "-c", "(setsid sh -c 'echo $$ > left.pid; exec sleep 1000' &); while [ ! -s left.pid ]; do sleep 0.01; done; exec sh tracker.sh"], protocol = "lines", version = "1" }
"#;

/// The target.
fn target(t: u32) -> Rect {
    let (x, y) = corner(t);
    Rect::new(f64::from(x), f64::from(y), 16.0, 12.0)
}

/// The image of a frame.
fn image(t: u32) -> String {
    format!("data/otb/Couple/img/{:04}.png", t + 1)
}

/// A data root `data` with one sequence in OTB layout, and a folder `programs` with `plugins.toml`.
fn place() -> Place {
    let place = Place::new();
    crate::tools::sequence(&place, "Couple", FRAMES);
    place.write("programs/tracker.sh", STILL);
    place.write("programs/plugins.toml", PLUGINS.replace("PROGRAM", env!("CARGO_BIN_EXE_trackfail")));
    place
}

/// The sequence in memory.
fn sequence(place: &Place) -> Sequence {
    let files: Vec<PathBuf> = (0..FRAMES).map(|t| place.path(&image(t))).collect();
    let mut sequence = without_frames("Couple", files.len());
    (sequence.truth[0], sequence.frames) = (Some(Region::Rect(target(0))), Frames::Files(files));
    sequence
}

/// An experiment with one method.
fn spec(suite: &str, trackers: &str, signal: &str, detector: &str) -> String {
    let method = format!("method = [{{ name = \"Mine\", signal = {signal}, detector = {detector} }}]");
    let table = "table = [{ name = \"t\", rows = [\"recall\"], columns = \"tracker\" }]";
    experiment("mine/try", suite, &format!("tracker = [{trackers}]\n{method}\n{table}\n"))
}

/// A built-in tracker and a program.
fn trackers(built_in: &str, program: &str) -> String {
    format!(
        "{{ name = \"{built_in}\" }}, {{ name = \"process\", program = \"{program}\", label = \"mine\" }}"
    )
}

const SCRIPTED: &str = "{ name = \"scripted\" }";
const LEVEL: &str = "{ kind = \"level\", below = 0.97 }";

/// The line that runs the experiment of a built-in tracker and a program on the sequence.
fn line(place: &Place, built_in: &str, program: &str) -> String {
    let trackers = trackers(built_in, program);
    place.write("try.toml", spec("otb-dtef20", &trackers, "{ kind = \"rgb-histogram\" }", LEVEL));
    "run try.toml --allow-missing --data-root data".into()
}

/// Number of tracks that are computed, not found, with the programs of a folder.
fn computed(place: &Place, built_in: &str, program: &str, folder: &str) -> usize {
    let line = line(place, built_in, program);
    // The sequence is not the pinned one.
    tally(&place.run(&format!("{line} --plugins {folder}/plugins.toml")).ends(3))["tracks"].0
}

/// The scores without the tracker's name, by tracker.
fn scores(place: &Place, tracker: &str) -> Vec<Vec<String>> {
    let mine = place.rows(SCORES).into_iter().filter(|row| row["tracker"] == tracker);
    mine.map(|row| row.into_iter().filter(|(k, _)| k != "tracker").map(|(_, v)| v).collect()).collect()
}

/// The first `n` frames.
fn track(setup: &dyn TrackerConfig, sequence: &Sequence, n: usize) -> Vec<TrackerState> {
    let context = RunContext { sequence, start_frame: 0, run: 0, seed: 5, data_roots: &[] };
    let region = sequence.truth[0].clone().unwrap();
    let frame = |t| sequence.frame(t).unwrap();
    let (mut tracker, first) = setup.start(&context, &frame(0), &region).unwrap_or_else(|e| panic!("{e}"));
    let rest = (1..n).map(|t| tracker.update(&frame(t)).unwrap_or_else(|e| panic!("{e}")));
    std::iter::once(first).chain(rest).collect()
}

fn built_in(kind: &str) -> Configured<dyn TrackerConfig> {
    plugin::find(TRACKERS, kind).unwrap().build_from_text("{}").unwrap()
}

/// A program of a file of programs, bound.
fn program(file: &Path, name: &str) -> Configured<dyn TrackerConfig> {
    let text = format!("{{ program = \"{name}\" }}");
    let mut setup = plugin::find(TRACKERS, "process").unwrap().build_from_text(&text).unwrap();
    Bind::bind(&mut setup, &programs::read(file).unwrap()).unwrap();
    setup
}

#[test]
fn a_program_is_run_once_until_it_or_its_version_changes() {
    let place = place();
    let computed = |folder: &str| computed(&place, "still", "still-in-sh", folder);
    assert_eq!(computed("programs"), 2);
    let mine = scores(&place, "mine");
    assert!(!mine.is_empty() && mine == scores(&place, "still"));
    assert_eq!(computed("programs"), 0);
    // Where it is kept is of no importance, nor how long it is waited for.
    std::fs::rename(place.path("programs"), place.path("elsewhere")).unwrap();
    let plugins = |from: &str, to: &str| place.write("elsewhere/plugins.toml", PLUGINS.replacen(from, to, 1));
    plugins("deterministic", "answer_timeout = 9, deterministic");
    assert_eq!(computed("elsewhere"), 0);
    plugins("version = \"1\"", "version = \"2\"");
    assert_eq!(computed("elsewhere"), 1);
    place.write("elsewhere/tracker.sh", format!("# changed\n{STILL}"));
    assert_eq!(computed("elsewhere"), 1);
    // A report is made of results alone.
    std::fs::remove_dir_all(place.path("elsewhere")).unwrap();
    place.run("report --reports again").ends(0);
}

#[test]
fn programs_are_named_by_flag_variable_or_the_folder_and_nowhere_else() {
    let place = place();
    let line = line(&place, "still", "still-in-sh");
    let dry = |more: &str| place.command(&format!("{line} --dry-run {more}"));
    let refused = |mut command: assert_cmd::Command, words: &str| Ran::of(&mut command).ends(2).tells(words);
    refused(dry(""), "try.toml:6: unknown program `still-in-sh`: there is no plugins.toml here");
    refused(dry("--plugins absent.toml"), "absent.toml:1: ");
    Ran::of(&mut dry("--plugins programs/plugins.toml")).ends(0);
    Ran::of(dry("").env("TRACKFAIL_PLUGINS", "programs/plugins.toml")).ends(0);
    std::fs::copy(place.path("programs/plugins.toml"), place.path("plugins.toml")).unwrap();
    Ran::of(&mut dry("")).ends(0);
    let listed = place.run("list trackers").ends(0).out;
    let line = listed.lines().find(|l| l.contains("still-in-sh")).unwrap();
    assert!(line.contains("process") && line.contains("speaks lines, from plugins.toml"), "{line}");
    // An experiment cannot say what is run.
    place.write("bad.toml", place.read("try.toml").replace("label = ", "command = [\"true\"], label = "));
    refused(place.command("run bad.toml"), "unknown key `command`");
}

#[test]
fn a_program_that_fails_fails_its_cells_alone_with_the_reason() {
    let mine = "{ kind = \"process\", program = \"mine\" }";
    let ends = ["sh", "-c", "read -r meta; read -r line; echo 'no memory' >&2; exit 7"];
    let later = ["sh", "-c", "read -r line; echo 1,2,3,4; read -r line; echo 'no memory' >&2; exit 7"];
    let killed = ["sh", "-c", "read -r line; echo no memory >&2; kill -s SEGV $$"];
    let absent = ["./no-such-program", "", ""];
    let memory = "no memory";
    for (role, command, told) in [
        ("tracker", later, memory),
        ("tracker", killed, memory),
        ("tracker", absent, "cannot start `"),
        ("signal", ends, memory),
        ("signal", absent, "cannot start `"),
        ("detector", ends, memory),
    ] {
        let signal = if role == "signal" { mine } else { "{ kind = \"box-motion\" }" };
        let detector = if role == "detector" { mine } else { LEVEL };
        let is_tracker = role == "tracker";
        let (all, protocol) = match is_tracker {
            true => (trackers("scripted", "mine"), "protocol = \"lines\"\n"),
            false => (SCRIPTED.to_string(), ""),
        };
        let place = Place::with(&[("try.toml", &spec("synthetic-otb", &all, signal, detector))]);
        let text = format!("[{role}.mine]\ncommand = {command:?}\nversion = \"1\"\n{protocol}");
        place.write("plugins.toml", text);
        // What has failed is not missing.
        place.run("run try.toml --allow-missing").ends(4).tells(told);
        let scores = place.read(SCORES);
        let cells = scores.lines().skip(1).filter(|line| !line.contains(",*,"));
        let (failed, good): (Vec<&str>, Vec<&str>) =
            cells.partition(|line| !is_tracker || line.contains(",mine,"));
        assert!(!failed.is_empty() && good.is_empty() != is_tracker, "{scores}");
        assert!(good.iter().all(|line| line.ends_with(",ok")), "{scores}");
        for cell in failed {
            // No count in its place.
            let (before, reason) = cell.split_once("failed: ").unwrap_or_else(|| panic!("{cell}"));
            assert!(before.trim_end_matches('"').ends_with(",Mine,,,,,,,,,,,,"), "{cell}");
            assert!(reason.contains(told), "{cell}");
        }
        // Programs are named in a file of one's own.
        place.write("plugins.toml", "");
        place.run("run try.toml").ends(2).tells(&format!("names no {role}"));
    }
}

// The built-in detector `level` labels what the example does with one frame in a row.
#[needs(python)]
#[test]
fn the_examples_of_the_documentation_judge_tracks() {
    let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/examples/plugins.toml");
    let python = "{ kind = \"process\", program = \"patient\", params = { above = 0.05, frames = 1 } }";
    let [ours, level] = [python, "{ kind = \"level\", above = 0.05 }"].map(|detector| {
        let signal = "{ kind = \"process\", program = \"size\", good = \"low\", params = { rate = 0.2 } }";
        let place = Place::with(&[("try.toml", &spec("synthetic-otb", SCRIPTED, signal, detector))]);
        place.run(&format!("run try.toml --plugins '{examples}'")).ends(0);
        let mut cells = place.rows(SCORES);
        cells.retain(|row| row["sequence"] != "*");
        ["tp", "fp", "fn"].map(|column| cells.iter().map(|row| row[column].clone()).collect::<Vec<_>>())
    });
    assert_eq!(ours, level);
    assert!(ours[0].iter().chain(&ours[1]).any(|count| count != "0"), "no detection at all");
}

#[test]
fn programs_do_not_outlive_us() {
    let place = place();
    let line = format!("{} --plugins programs/plugins.toml", line(&place, "still", "hanging"));
    let files = ["hanging.pid", "sleeping.pid", "away.pid"].map(|name| place.path("programs").join(name));
    for signal in ["-KILL", "-INT"] {
        let mut run = Command::new(env!("CARGO_BIN_EXE_trackfail"));
        end(&place, run.args(words(&line)), &files, signal);
    }
}

/// Processes that a program leaves in a session of their own end with the program.
#[cfg(target_os = "linux")]
#[test]
fn no_process_is_left_after_a_run() {
    let place = place();
    assert_eq!(computed(&place, "still", "leaving", "programs"), 2);
    let left = pid(&place.path("programs/left.pid"));
    assert!(!trackfail_testing::is_running(&left), "{left} is left");
}

#[test]
fn a_served_tracker_is_the_tracker() {
    let place = place();
    let sequence = sequence(&place);
    let served = program(&place.path("programs/plugins.toml"), "served");
    assert_eq!(track(&*served, &sequence, 40), track(&*built_in("ncc"), &sequence, 40));
    assert_eq!(computed(&place, "ncc", "served", "programs"), 2);
    assert_eq!(scores(&place, "mine"), scores(&place, "ncc"));
}

/// Run of `serve-trax` on some lines of input.
fn serve(arguments: &[&str], lines: &str) -> Ran {
    Ran::of(trackfail().arg("serve-trax").args(arguments).write_stdin(lines))
}

#[test]
fn a_session_ends_well_or_with_a_reason() {
    let place = place();
    let [a, b] = [0, 1].map(|t| place.path(&image(t)).display().to_string());
    let other = place.path("other.png");
    image::RgbImage::new(9, 9).save(&other).unwrap();
    let start = format!("@@TRAX:initialize \"file://{a}\" \"8,10,16,12\"\n");
    let lines = format!("{start}@@TRAX:frame \"{b}\"\nnoise\n{start}@@TRAX:quit\n");
    let said = serve(&["still"], &lines).ends(0).out;
    let (hello, states) = said.split_once('\n').unwrap();
    let words = "@@TRAX:hello \"trax.version=3\" \"trax.image=path\" \"trax.region=rectangle;polygon\"";
    assert!(hello.starts_with(words) && hello.contains("\"trax.name=still\""), "{hello}");
    assert_eq!(states, "@@TRAX:state \"8,10,16,12\"\n".repeat(3));
    // A client that hangs up has nothing more to ask.
    serve(&["still"], &start).ends(0);
    // A posterior has a likelihood, and the seed counts.
    let sampled = |seed: &str| {
        let polygon = start.replace("8,10,16,12", "8,10,24,10,24,22,8,22");
        let arguments = ["color-particle-filter", "--seed", seed, "--params", "{ particles = 50 }"];
        serve(&arguments, &format!("{polygon}@@TRAX:frame {b}\n")).ends(0).out
    };
    let said = sampled("1");
    assert!(said.lines().nth(2).unwrap().contains("\" \"confidence=0."), "{said}");
    assert!(said == sampled("1") && said != sampled("2"));
    for (lines, code, reason) in [
        (format!("@@TRAX:frame \"{b}\"\n"), 1, "expected `initialize` first"),
        ("@@TRAX:initialize 1,2,3,4\n".to_string(), 1, "an image and a region, as in version 3"),
        (format!("{start}@@TRAX:state 1,2,3,4\n"), 1, "a client's message"),
        (format!("{start}@@TRAX:frame\n"), 1, "`frame` with one image"),
        (format!("{start}@@TRAX:frame /no/such/image.png\n"), 3, "/no/such/image.png: "),
        (start.replace("8,10", "nan,10"), 1, "not a finite number"),
        (start.replace("8,10", "5000,5000"), 1, "the region 5000,5000,16,12 lies outside of the image of "),
        (format!("{start}@@TRAX:frame \"{}\"\n", other.display()), 3, "sequence must have one size"),
    ] {
        let Ran { out, err, .. } = serve(&["still"], &lines).ends(code).tells(reason);
        let last = out.lines().last().unwrap();
        assert!(last.starts_with("@@TRAX:quit \"trax.reason=") && last.contains(reason), "{last}");
        assert!(err.starts_with("error: "), "{err}");
    }
    for (arguments, reason) in [
        (&["stil"][..], "unknown tracker `stil`; did you mean `still`?"),
        (&["replay"], "`replay` answers from ground truth or result files"),
        (&["scripted"], "`scripted` answers from ground truth or result files"),
        (&["process"], "let the client start a TraX server"),
        (&["ncc", "--params", "{ searsh = 2 }"], "--params:1: unknown field `searsh`"),
        (&["ncc", "--params", "{"], "--params:1: "),
    ] {
        serve(arguments, "").refuses(2, reason);
    }
}

const PEER_SERVER: &str = r#"
import sys, trax
polygon = "polygon" in sys.argv
formats = [trax.Region.POLYGON] if polygon else [trax.Region.RECTANGLE]
with trax.Server(formats, [trax.Image.PATH], tracker_name="peer") as server:
    while True:
        request = server.wait()
        if request.type == trax.TraxStatus.QUIT:
            break
        if request.type == trax.TraxStatus.INITIALIZE:
            region, n = request.objects[0][0], 0
        image = request.image["color"] if request.image else None
        if image is None:
            continue
        if polygon:
            answer = trax.Polygon.create([(x + n, y) for x, y in region])
        else:
            x, y, w, h = region.bounds()
            answer = trax.Rectangle.create(x + n, y, w, h)
        n += 1
        print("looking at", image.path(), file=sys.stderr)
        server.status([(answer, {"confidence": 0.5})])
"#;

#[needs(vot_trax)]
#[test]
fn a_tracker_written_with_vot_trax_is_followed() {
    let place = place();
    place.write("programs/peer.py", PEER_SERVER);
    let block = |name: &str, more: &str| {
        format!("[tracker.{name}]\ncommand = [\"python3\", \"peer.py\"{more}]\nversion = \"1\"\n")
    };
    place.write("programs/plugins.toml", block("rectangle", "") + &block("polygon", ", \"polygon\""));
    let sequence = sequence(&place);
    for name in ["rectangle", "polygon"] {
        let states = track(&*program(&place.path("programs/plugins.toml"), name), &sequence, 6);
        for (t, state) in states.iter().enumerate() {
            assert_eq!(state.region.rect(), Rect::new(8.0 + t as f64, 10.0, 16.0, 12.0), "{name}");
            assert_eq!(matches!(state.region, Region::Polygon(_)), name == "polygon" && t > 0);
        }
    }
}

const PEER_CLIENT: &str = r#"
import subprocess, sys, trax
from trax.client import Client
program, images = sys.argv[1], sys.argv[2:]
served = subprocess.Popen([program, "serve-trax", "ncc"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
client = Client(stream=(served.stdin.fileno(), served.stdout.fileno()), log=lambda text: None)
print(client.tracker_name, *client.region_formats, *client.image_formats)
first = trax.Rectangle.create(8, 10, 16, 12)
for n, path in enumerate(images):
    image = {"color": trax.FileImage.create(path)}
    if n == 0:
        objects, _ = client.initialize(image, [(first, {})], {})
    else:
        objects, _ = client.frame(image, {}, [])
    print(*objects[0][0].bounds())
client.quit()
sys.exit(served.wait(30))
"#;

#[needs(vot_trax)]
#[test]
fn our_trackers_are_followed_by_the_client_of_vot_trax() {
    let place = place();
    place.write("client.py", PEER_CLIENT);
    let mut client = assert_cmd::Command::new("python3");
    client.arg(place.path("client.py")).arg(env!("CARGO_BIN_EXE_trackfail"));
    let ran = Ran::of(client.args((0..20).map(|t| place.path(&image(t))))).ends(0);
    let mut lines = ran.out.lines();
    assert_eq!(lines.next(), Some("ncc rectangle polygon path"));
    let expected = track(&*built_in("ncc"), &sequence(&place), 20);
    assert_eq!(lines.clone().count(), expected.len());
    for (line, state) in lines.zip(expected) {
        let got: Vec<f64> = line.split(' ').map(|n| n.parse().unwrap()).collect();
        let r = state.region.rect();
        // The library computes in single precision.
        let close = got.iter().zip([r.x, r.y, r.w, r.h]).all(|(a, b)| (a - b).abs() < 1e-3);
        assert!(close, "{line} is not {r:?}");
    }
}

#[needs(pillow)]
#[test]
fn the_example_follows_a_target() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/plugins.toml");
    let place = place();
    for (t, state) in track(&*program(&file, "least-squares"), &sequence(&place), 60).iter().enumerate() {
        assert_eq!(state.region.rect(), target(t as u32), "frame {t}");
    }
}
