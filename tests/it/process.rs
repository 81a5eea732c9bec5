//! Foreign programs as trackers, and our trackers for foreign programs.

use crate::outside::{is_running, pid};
use crate::tools::{needs, rows, trackfail};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};
use trackfail::dataset::user_frames::without_frames;
use trackfail::dataset::{Frames, Sequence};
use trackfail::image::{Frame, encode_png};
use trackfail::plugin::{self, Configured};
use trackfail::region::{Rect, Region};
use trackfail::spec::programs;
use trackfail::tracker::process::Bind;
use trackfail::tracker::{RunContext, TRACKERS, TrackerConfig, TrackerState};
use trackfail_testing::put;

const FRAMES: u32 = 140;

/// Answers the first region for ever.
const STILL: &str = "while read -r line; do case $line in quit) exit;; init*) region=$(printf '%s' \"$line\" | \
                     cut -f 3);; esac; echo \"$region\"; done\n";

const PLUGINS: &str = r#"[tracker.still-in-sh]
command = ["sh", "tracker.sh"]
protocol = "lines"
version = "1"
deterministic = true
digest = ["tracker.sh"]

[tracker.served]
command = ["PROGRAM", "serve-trax", "ncc"]
version = "1"
confidence = "confidence"

[tracker.broken]
command = ["sh", "-c", "read -r line; echo 1,2,3,4; read -r line; echo 'no memory' >&2; exit 7"]
protocol = "lines"
version = "1"

[tracker.hanging]
command = ["sh", "-c", "echo $$ > hanging.pid; (setsid sh -c 'echo $$ > away.pid; exec sleep 1000' &); sleep 1000 & echo $! > sleeping.pid; wait"]
protocol = "lines"
version = "1"

[tracker.leaving]
command = ["sh", "-c", "(setsid sh -c 'echo $$ > left.pid; exec sleep 1000' &); exec sh tracker.sh"]
protocol = "lines"
version = "1"

[tracker.absent]
command = ["./no-such-program"]
protocol = "lines"
version = "1"

[tracker.killed]
command = ["sh", "-c", "read -r line; echo gone >&2; kill -s SEGV $$"]
protocol = "lines"
version = "1"
"#;

/// The left top corner of the target.
fn place(t: u32) -> (u32, u32) {
    (8 + t / 5, 10 + t % 7)
}

fn frame(t: u32) -> Frame {
    let (x, y) = place(t);
    Frame::from_fn(64, 48, |column, row| {
        let inside = (x..x + 16).contains(&(column as u32)) && (y..y + 12).contains(&(row as u32));
        let (u, v) = (column as u32 - x.min(column as u32), row as u32 - y.min(row as u32));
        let texture = ((u * 31 + v * 17) % 64) as u8;
        if inside { [200, 3 * texture, 60] } else { [((column * 13 + row * 7) % 64) as u8, 90, 120] }
    })
}

/// A data root with one sequence in OTB layout, and a folder with `plugins.toml`.
struct Place {
    dir: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let place = Self { dir: tempfile::tempdir().unwrap() };
        let mut truth = String::new();
        for t in 0..FRAMES {
            place.put(place.image(t), encode_png(&frame(t)).unwrap());
            let (x, y) = self::place(t);
            truth += &format!("{},{},16,12\n", x + 1, y + 1);
        }
        place.put("data/otb/Couple/groundtruth_rect.txt", truth);
        place.put("programs/tracker.sh", STILL);
        place.plugins(PLUGINS);
        place
    }

    fn put(&self, name: impl AsRef<Path>, bytes: impl AsRef<[u8]>) {
        put(self.dir.path(), name, bytes);
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn image(&self, t: u32) -> PathBuf {
        self.path(&format!("data/otb/Couple/img/{:04}.png", t + 1))
    }

    fn plugins(&self, text: &str) {
        self.put("programs/plugins.toml", text.replace("PROGRAM", env!("CARGO_BIN_EXE_trackfail")));
    }

    /// A run of a built-in tracker beside a program.
    fn command(&self, built_in: &str, program: &str) -> assert_cmd::Command {
        let text = format!(
            "schema = 1\nname = \"mine/try\"\ntitle = \"A try\"\nprotocol = \"khalid2016/1\"\n\
             [suites]\ntest = \"otb-dtef20\"\n[[tracker]]\nname = \"{built_in}\"\n\
             [[tracker]]\nname = \"process\"\nprogram = \"{program}\"\nlabel = \"mine\"\n\
             [[method]]\nname = \"Hist\"\nsignal = {{ kind = \"rgb-histogram\" }}\n\
             detector = {{ kind = \"level\", below = 0.97 }}\n\
             [[table]]\nname = \"t\"\nrows = [\"recall\"]\ncolumns = \"tracker\"\nmethods = [\"Hist\"]\n"
        );
        self.put("try.toml", text);
        let mut command = trackfail();
        command.arg("run").arg(self.path("try.toml")).arg("--allow-missing");
        for (flag, folder) in [("--data-root", "data"), ("--results", "results"), ("--reports", "reports")] {
            command.arg(flag).arg(self.path(folder));
        }
        command
    }

    fn run(&self, built_in: &str, program: &str) -> Output {
        let plugins = self.path("programs/plugins.toml");
        self.command(built_in, program).arg("--plugins").arg(plugins).output().unwrap()
    }

    /// The rows of the scores without the tracker's name, by tracker.
    fn scores(&self, tracker: &str) -> Vec<Vec<String>> {
        let text = std::fs::read_to_string(self.path("results/mine/try/scores.csv")).unwrap();
        let mine = rows(&text).into_iter().filter(|row| row["tracker"] == tracker);
        mine.map(|row| row.into_iter().filter(|(k, _)| k != "tracker").map(|(_, v)| v).collect()).collect()
    }

    /// The sequence in memory.
    fn sequence(&self) -> Sequence {
        let (x, y) = self::place(0);
        let first = Region::Rect(Rect::new(f64::from(x), f64::from(y), 16.0, 12.0));
        let files: Vec<PathBuf> = (0..FRAMES).map(|t| self.image(t)).collect();
        let mut sequence = without_frames("Couple", files.len());
        (sequence.truth[0], sequence.frames) = (Some(first), Frames::Files(files.into()));
        sequence
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Tracks that were computed, not found.
fn computed(output: &Output) -> usize {
    let text = stderr(output);
    assert_eq!(output.status.code(), Some(3), "the sequence is not the pinned one: {text}");
    let tally = text.lines().find(|l| l.contains("tracks") && l.contains("cached")).expect("a tally");
    tally.split_once("tracks ").unwrap().1.split(' ').next().unwrap().parse().unwrap()
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
    let place = Place::new();
    assert_eq!(computed(&place.run("still", "still-in-sh")), 2);
    let scores = place.scores("mine");
    assert!(!scores.is_empty() && scores == place.scores("still"));
    assert_eq!(computed(&place.run("still", "still-in-sh")), 0);
    // Where it is kept is of no importance, nor how long it is waited for.
    std::fs::rename(place.path("programs"), place.path("elsewhere")).unwrap();
    std::fs::create_dir(place.path("programs")).unwrap();
    std::fs::rename(place.path("elsewhere/tracker.sh"), place.path("programs/tracker.sh")).unwrap();
    place.plugins(&PLUGINS.replace("deterministic", "answer_timeout = 9\ndeterministic"));
    assert_eq!(computed(&place.run("still", "still-in-sh")), 0);
    place.plugins(&PLUGINS.replacen("version = \"1\"", "version = \"2\"", 1));
    assert_eq!(computed(&place.run("still", "still-in-sh")), 1);
    place.put("programs/tracker.sh", format!("# changed\n{STILL}"));
    assert_eq!(computed(&place.run("still", "still-in-sh")), 1);
    // A report is made of results alone.
    std::fs::remove_dir_all(place.path("programs")).unwrap();
    let mut report = trackfail();
    report.arg("report").arg("--results").arg(place.path("results"));
    let output = report.arg("--reports").arg(place.path("again")).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
}

#[test]
fn programs_are_named_by_flag_variable_or_the_folder_and_nowhere_else() {
    let place = Place::new();
    let dry = |place: &Place, program: &str| {
        let mut command = place.command("still", program);
        command.arg("--dry-run").current_dir(place.dir.path());
        command
    };
    let message = |mut command: assert_cmd::Command| {
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        stderr(&output)
    };
    let text = message(dry(&place, "still-in-sh"));
    let words = "try.toml:11: unknown program `still-in-sh`: there is no plugins.toml here";
    assert!(text.contains(words), "{text}");
    let file = place.path("programs/plugins.toml");
    let mut named = dry(&place, "still-in-hs");
    named.arg("--plugins").arg(&file);
    let text = message(named);
    let words = "plugins.toml: unknown program `still-in-hs`; did you mean `still-in-sh`?";
    assert!(text.contains(words), "{text}");
    let good = |command: &mut assert_cmd::Command| {
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    good(dry(&place, "still-in-sh").arg("--plugins").arg(&file));
    good(dry(&place, "still-in-sh").env("TRACKFAIL_PLUGINS", &file));
    std::fs::copy(&file, place.path("plugins.toml")).unwrap();
    good(&mut dry(&place, "still-in-sh"));
    let listed = good(trackfail().args(["list", "trackers"]).current_dir(place.dir.path()));
    let line = listed.lines().find(|l| l.contains("still-in-sh")).unwrap();
    assert!(line.contains("process") && line.contains("speaks lines, from plugins.toml"), "{line}");
    place.put("plugins.toml", "[tracker.a]\ncommand = [\"a\"]\nverson = \"1\"\n");
    let text = message(dry(&place, "still-in-sh"));
    assert!(text.contains("plugins.toml:3: unknown key `verson`") && text.contains("`version`?"), "{text}");
    // An experiment cannot say what is run.
    let spec = std::fs::read_to_string(place.path("try.toml")).unwrap();
    place.put("bad.toml", spec.replace("label = ", "command = [\"true\"]\nlabel = "));
    let mut bad = trackfail();
    bad.arg("run").arg(place.path("bad.toml")).arg("--plugins").arg(&file);
    trackfail_testing::assert_says(message(bad), "unknown key `command`");
    let mut absent = dry(&place, "still-in-sh");
    absent.args(["--plugins", "absent.toml"]);
    assert!(message(absent).contains("absent.toml:1: "));
}

#[test]
fn a_program_that_ends_fails_its_cells_alone_and_it_is_told_how() {
    let place = Place::new();
    for (program, words) in [
        ("absent", ["cannot start `", "No such file or directory (os error 2)"]),
        ("killed", ["it ended (signal: 11", "its stderr ends with: gone"]),
    ] {
        let text = stderr(&place.run("still", program));
        assert!(words.iter().all(|words| text.contains(words)), "{program}: {text}");
    }
    let output = place.run("still", "broken");
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stderr(&output).contains("it ended (exit status: 7)"), "{}", stderr(&output));
    let scores = std::fs::read_to_string(place.path("results/mine/try/scores.csv")).unwrap();
    let line = scores.lines().find(|l| l.contains(",mine,") && l.contains("Couple")).unwrap();
    assert!(line.contains("failed: broken: frame 2 of Couple: it ended (exit status: 7)"), "{line}");
    assert!(line.contains("its stderr ends with: no memory"), "{line}");
    assert!(scores.lines().any(|l| l.contains(",still,") && l.ends_with(",ok")), "{scores}");
}

#[test]
fn programs_do_not_outlive_us() {
    let place = Place::new();
    let temporary = place.path("tmp");
    std::fs::create_dir(&temporary).unwrap();
    for signal in ["-KILL", "-INT"] {
        let files = ["hanging.pid", "sleeping.pid", "away.pid"].map(|name| place.path("programs").join(name));
        files.iter().for_each(|f| std::fs::remove_file(f).unwrap_or_default());
        let command = place.command("still", "hanging");
        let mut run = Command::new(command.get_program());
        run.args(command.get_args()).arg("--plugins").arg(place.path("programs/plugins.toml"));
        let mut run = run.env("TMPDIR", &temporary).stderr(std::process::Stdio::null()).spawn().unwrap();
        let processes = files.map(|f| pid(&f));
        assert!(processes.iter().all(|p| is_running(p)));
        assert!(Command::new("kill").arg(signal).arg(run.id().to_string()).status().unwrap().success());
        run.wait().unwrap();
        let end = Instant::now() + Duration::from_secs(30);
        let left = || std::fs::read_dir(&temporary).unwrap().count();
        while processes.iter().any(|p| is_running(p)) || left() > 0 {
            assert!(Instant::now() < end, "{signal}: {processes:?} or {} folders are left", left());
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// Processes that a program leaves in a session of their own end with the program.
#[cfg(target_os = "linux")]
#[test]
fn no_process_is_left_after_a_run() {
    let place = Place::new();
    assert_eq!(computed(&place.run("still", "leaving")), 2);
    let left = pid(&place.path("programs/left.pid"));
    assert!(!is_running(&left), "{left} is left");
}

#[test]
fn a_served_tracker_is_the_tracker() {
    let place = Place::new();
    let sequence = place.sequence();
    let served = program(&place.path("programs/plugins.toml"), "served");
    assert_eq!(track(&*served, &sequence, 40), track(&*built_in("ncc"), &sequence, 40));
    assert_eq!(computed(&place.run("ncc", "served")), 2);
    assert_eq!(place.scores("mine"), place.scores("ncc"));
}

/// Answer of `serve-trax` to some lines: exit code, stdout and stderr.
fn serve(arguments: &[&str], lines: &str) -> (i32, String, String) {
    let output = trackfail().arg("serve-trax").args(arguments).write_stdin(lines).output().unwrap();
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code().unwrap_or(-1), stdout, stderr(&output))
}

#[test]
fn a_session_ends_well_or_with_a_reason() {
    let place = Place::new();
    let image = |t| place.image(t).display().to_string();
    let (a, b) = (image(0), image(1));
    let other = place.path("other.png");
    image::RgbImage::new(9, 9).save(&other).unwrap();
    let start = format!("@@TRAX:initialize \"file://{a}\" \"8,10,16,12\"\n");
    let (code, said, _) =
        serve(&["still"], &format!("{start}@@TRAX:frame \"{b}\"\nnoise\n{start}@@TRAX:quit\n"));
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(code, 0, "{said}");
    assert!(lines[0].starts_with(
        "@@TRAX:hello \"trax.version=3\" \"trax.image=path\" \"trax.region=rectangle;polygon\""
    ));
    assert!(lines[0].contains("\"trax.name=still\""), "{said}");
    assert_eq!(lines[1..], ["@@TRAX:state \"8,10,16,12\""; 3]);
    // A client that hangs up has nothing more to ask.
    assert_eq!(serve(&["still"], &start).0, 0);
    // A posterior has a likelihood, and the seed counts.
    let sampled = |seed: &str| {
        let polygon = start.replace("8,10,16,12", "8,10,24,10,24,22,8,22");
        let arguments = ["color-particle-filter", "--seed", seed, "--params", "{ particles = 50 }"];
        serve(&arguments, &format!("{polygon}@@TRAX:frame {b}\n"))
    };
    let (code, said, told) = sampled("1");
    assert!(code == 0 && said.lines().nth(2).unwrap().contains("\" \"confidence=0."), "{said}{told}");
    assert!(said == sampled("1").1 && said != sampled("2").1);
    for (lines, code, reason) in [
        (format!("@@TRAX:frame \"{b}\"\n"), 1, "expected `initialize` first"),
        ("@@TRAX:initialize 1,2,3,4\n".to_string(), 1, "an image and a region, as in version 3"),
        (format!("{start}@@TRAX:state 1,2,3,4\n"), 1, "a client's message"),
        (format!("{start}@@TRAX:frame\n"), 1, "`frame` with one image"),
        (format!("{start}@@TRAX:frame /no/such/image.png\n"), 3, "/no/such/image.png: "),
        (start.replace("8,10", "nan,10"), 1, "not a finite number"),
        (start.replace("8,10", "5000,5000"), 1, "the region 5000,5000,16,12 lies outside of the image of "),
        (
            format!("{start}@@TRAX:frame \"{}\"\n", other.display()),
            3,
            "all frames of a sequence must have one size",
        ),
    ] {
        let (got, said, told) = serve(&["still"], &lines);
        let last = said.lines().last().unwrap();
        assert_eq!(got, code, "{said}{told}");
        assert!(last.starts_with("@@TRAX:quit \"trax.reason=") && last.contains(reason), "{last}");
        assert!(told.starts_with("error: ") && told.contains(reason), "{told}");
    }
    for (arguments, reason) in [
        (&["stil"][..], "unknown tracker `stil`; did you mean `still`?"),
        (&["replay"], "`replay` answers from ground truth or result files"),
        (&["scripted"], "`scripted` answers from ground truth or result files"),
        (&["process"], "let the client start a TraX server"),
        (&["ncc", "--params", "{ searsh = 2 }"], "--params:1: unknown field `searsh`"),
        (&["ncc", "--params", "{"], "--params:1: "),
    ] {
        let (code, said, told) = serve(arguments, "");
        assert!(code == 2 && said.is_empty() && told.contains(reason), "{said}{told}");
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
    let place = Place::new();
    place.put("programs/peer.py", PEER_SERVER);
    let block = |name: &str, more: &str| {
        format!("[tracker.{name}]\ncommand = [\"python3\", \"peer.py\"{more}]\nversion = \"1\"\n")
    };
    place.plugins(&(block("rectangle", "") + &block("polygon", ", \"polygon\"")));
    let sequence = place.sequence();
    for name in ["rectangle", "polygon"] {
        let states = track(&*program(&place.path("programs/plugins.toml"), name), &sequence, 6);
        for (t, state) in states.iter().enumerate() {
            let expected = Rect::new(8.0 + t as f64, 10.0, 16.0, 12.0);
            assert_eq!(state.region.rect(), expected, "{name}");
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
    let place = Place::new();
    place.put("client.py", PEER_CLIENT);
    let mut client = Command::new("python3");
    client.arg(place.path("client.py")).arg(env!("CARGO_BIN_EXE_trackfail"));
    let output = client.args((0..20).map(|t| place.image(t))).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("ncc rectangle polygon path"));
    let expected = track(&*built_in("ncc"), &place.sequence(), 20);
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
    let place = Place::new();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/plugins.toml");
    let states = track(&*program(&file, "least-squares"), &place.sequence(), 60);
    for (t, state) in states.iter().enumerate() {
        let (x, y) = self::place(t as u32);
        assert_eq!(state.region.rect(), Rect::new(f64::from(x), f64::from(y), 16.0, 12.0), "frame {t}");
    }
}
