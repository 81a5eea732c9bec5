//! Programs here are shell scripts, good ones and bad ones.
#![cfg(unix)]

use super::*;
use crate::tracker::testing::{self, Ramp};
use std::path::Path;
use std::time::{Duration, Instant};
use trackfail_core::image::{decode, encode_png};
use trackfail_core::region::Rect;
use trackfail_dataset::{Frames, Numbering, Render, Sequence};

mod ends;

fn sequence(frames: Frames) -> Sequence {
    let numbering = Numbering { first: 11, official: (11, 16) };
    Sequence { numbering, truth: vec![Some(rect()); 6], frames, ..testing::rendered("Ramp", 6) }
}

fn rendered() -> Sequence {
    sequence(testing::rendered("Ramp", 6).frames)
}

fn rect() -> Region {
    Region::Rect(Rect::new(2.0, 3.5, 4.0, 5.0))
}

/// A shell script in a folder of its own, and what it leaves there.
struct Script {
    dir: tempfile::TempDir,
    program: Program,
}

impl Script {
    fn new(protocol: Protocol, text: &str) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let mut program = testing::script(Role::Tracker, dir.path(), text);
        program.protocol = protocol;
        Self { dir, program }
    }

    fn impatient(mut self) -> Self {
        self.program.start_timeout = Duration::from_millis(200);
        self.program.answer_timeout = Duration::from_millis(200);
        self
    }

    fn config(&self) -> Configured<dyn TrackerConfig> {
        let mut config = ENTRY.build_from_text("{ program = \"mine\" }").unwrap();
        Bind::bind(&mut config, &testing::programs(&self.program)).unwrap();
        config
    }

    /// Starts it in a frame of a sequence.
    fn start(&self, sequence: &Sequence, start_frame: usize, region: &Region) -> StartResult {
        let context = RunContext { sequence, start_frame, run: 4, seed: 99, data_roots: &[] };
        self.config().start(&context, &sequence.frame(start_frame).unwrap(), region)
    }

    /// The first `n` frames, as far as they go.
    fn track(&self, n: usize) -> Result<Vec<TrackerState>, String> {
        let sequence = rendered();
        let (mut tracker, first) = self.start(&sequence, 0, &rect()).map_err(|e| e.to_string())?;
        let mut states = vec![first];
        for t in 1..n {
            states.push(tracker.update(&Ramp.render(t)).map_err(|e| e.to_string())?);
        }
        Ok(states)
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.dir.path().join(name)).unwrap_or_default()
    }
}

/// Answers every line but `quit`, after it has written it down.
const GOOD: &str = r#"echo "$TRACKFAIL_SEED $TRACKFAIL_RUN $EXTRA $TRAX" > environment
n=0
while read -r line; do
    printf '%s\n' "$line" >> log
    [ "$line" = quit ] && exit 0
    image=$(printf '%s' "$line" | cut -f 2)
    cp "$image" "seen$n.png"
    n=$((n + 1))
    echo "$n,2.5,3,4 0.25"
done
"#;

fn moved(x: f64) -> TrackerState {
    TrackerState::tracked(Region::Rect(Rect::new(x, 2.5, 3.0, 4.0)))
}

#[test]
fn a_program_gets_frames_and_its_answers_are_the_track() {
    let script = Script::new(Protocol::Lines, GOOD);
    let states = script.track(4).unwrap();
    assert_eq!(states, [TrackerState::initialized(rect()), moved(2.0), moved(3.0), moved(4.0)]);
    assert_eq!(script.read("environment"), "99 4 more \n");
    let log = script.read("log");
    let lines: Vec<Vec<&str>> = log.lines().map(|l| l.split('\t').collect()).collect();
    let words: Vec<_> = lines.iter().map(|l| l[0]).collect();
    assert_eq!(words, ["init", "frame", "frame", "frame", "quit"]);
    assert_eq!(lines[0][2], "2,3.5,4,5");
    for (t, line) in lines.iter().take(4).enumerate() {
        let seen = std::fs::read(script.dir.path().join(format!("seen{t}.png"))).unwrap();
        assert_eq!(decode(&seen).unwrap(), Ramp.render(t));
        assert!(!Path::new(line[1]).parent().unwrap().exists(), "the folder is gone");
    }
}

#[test]
fn two_written_frames_are_kept() {
    let mut images = Images::new().unwrap();
    let paths: Vec<_> = (0..5).map(|t| images.path(None, &Ramp.render(t)).unwrap()).collect();
    assert_eq!(paths.iter().map(|p| p.exists()).collect::<Vec<_>>(), [false, false, false, true, true]);
}

#[test]
fn frames_in_files_are_sent_as_their_paths() {
    let dir = tempfile::tempdir().unwrap();
    let path = |t: usize| dir.path().join(if t == 3 { "a\tb.png".into() } else { format!("{t}.png") });
    (0..6).for_each(|t| std::fs::write(path(t), encode_png(&Ramp.render(t)).unwrap()).unwrap());
    let sequence = sequence(Frames::Files((0..6).map(path).collect::<Vec<_>>().into()));
    let script = Script::new(Protocol::Lines, GOOD);
    let frame = |t: usize| sequence.frame(t).unwrap();
    let (mut tracker, _) = script.start(&sequence, 1, &rect()).unwrap();
    (2..5).for_each(|t| drop(tracker.update(&frame(t)).unwrap()));
    drop(tracker);
    let log = script.read("log");
    let sent: Vec<&str> = log.lines().filter_map(|l| l.split('\t').nth(1)).collect();
    for (k, t) in [(0, 1), (1, 2), (3, 4)] {
        assert_eq!(sent[k], path(t).to_str().unwrap());
    }
    // A path with a tab cannot be sent.
    assert!(sent[2].contains("trackfail-frames-"), "{}", sent[2]);
    let seen = std::fs::read(script.dir.path().join("seen2.png")).unwrap();
    assert_eq!(decode(&seen).unwrap(), frame(3));
}

#[test]
fn polygons_are_sent_to_programs_that_read_them() {
    let corners = vec![(1.0, 1.0), (5.0, 2.0), (4.0, 6.0), (0.0, 5.0)];
    let turned = Region::Polygon(corners.clone());
    let whole = turned.rect();
    for (regions, expected) in [
        (Regions::Polygon, "1,1,5,2,4,6,0,5".to_string()),
        (Regions::Rectangle, format!("{},{},{},{}", whole.x, whole.y, whole.w, whole.h)),
    ] {
        let answer = "echo 0,0,4,0,4,3 >&1";
        let mut script = Script::new(
            Protocol::Lines,
            &format!("read -r l; echo \"$l\" > log; {answer}; read -r l; {answer}; read -r l"),
        );
        script.program.regions = regions;
        let sequence = rendered();
        let (mut tracker, first) = script.start(&sequence, 0, &turned).unwrap();
        assert_eq!(first, TrackerState::initialized(turned.clone()));
        let triangle = Region::Polygon(vec![(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)]);
        assert_eq!(tracker.update(&Ramp.render(1)).unwrap(), TrackerState::tracked(triangle));
        assert_eq!(script.read("log").trim_end().split('\t').nth(2), Some(expected.as_str()));
    }
}

#[test]
fn a_confidence_is_used_if_it_is_named() {
    let confidences = |script: &Script| -> Vec<Option<f64>> {
        script.track(3).unwrap().into_iter().map(|state| state.confidence).collect()
    };
    let property = "\"'$n',2.5,3,4\" confidence=0.'$n' other=7";
    for (mut script, name) in
        [(Script::new(Protocol::Lines, GOOD), "any"), (trax("", property), "confidence")]
    {
        let context = |script: &Script| script.config().gives_confidence(&testing::context(&rendered(), 0));
        assert_eq!((confidences(&script), context(&script)), (vec![None; 3], false));
        script.program.confidence = Some(name.into());
        let expected = match name {
            "any" => vec![Some(0.25); 3],
            _ => vec![Some(0.1), Some(0.2), Some(0.3)],
        };
        assert_eq!((confidences(&script), context(&script)), (expected, true));
        assert_eq!(script.config().params()["confidence"], name);
    }
    // The property of another name, or of none, is no fault; a word is.
    let mut script = trax("", property);
    script.program.confidence = Some("score".into());
    assert_eq!(confidences(&script), [None; 3]);
    let mut script = trax("", "1,2,3,4 confidence=high");
    script.program.confidence = Some("confidence".into());
    let error = script.track(2).unwrap_err();
    assert!(error.contains("its property `confidence`: `high` is no number"), "{error}");
}

#[test]
fn each_start_runs_the_program_anew() {
    let script = Script::new(Protocol::Lines, GOOD);
    for _ in 0..2 {
        assert_eq!(script.track(2).unwrap()[1], moved(2.0));
    }
    assert_eq!(script.read("log").matches("quit").count(), 2);
}

#[test]
fn version_and_protocol_are_parameters_and_the_seed_counts_unless_it_is_deterministic() {
    let mut script = Script::new(Protocol::Lines, "");
    let expected = serde_json::json!(
        { "program": "mine", "version": "7", "protocol": "lines", "regions": "rectangle" }
    );
    assert_eq!(script.config().params(), expected);
    assert!(script.config().facts().uses_seed);
    script.program.deterministic = true;
    script.program.digest = vec!["/a/b".into()];
    assert!(!script.config().facts().uses_seed);
    let sequence = rendered();
    let context = testing::context(&sequence, 0);
    assert_eq!(script.config().inputs(&context).unwrap(), [Path::new("/a/b")]);
    let mut other = ENTRY.build_from_text("{ program = \"mime\" }").unwrap();
    assert!(matches!(other.start(&context, &Ramp.render(0), &rect()), Err(TrackerError::Missing(_))));
    let programs = testing::programs(&script.program);
    let refused = Bind::bind(&mut other, &programs).unwrap_err();
    assert_eq!(refused.message, "plugins.toml: unknown program `mime`; did you mean `mine`?");
    assert_eq!(refused.key, Some("program"));
}

/// Behavior of a script on the first line, and the fault that follows in the first or second frame.
#[test]
fn bad_answers_fail_with_a_reason() {
    for (text, words) in [
        ("echo hello", "frame 11 of Ramp: received `hello` (`hello` is no number); expected `x,y,w,h`"),
        ("echo 1,2,nan,4", "received `1,2,nan,4` (a coordinate is not a finite number)"),
        ("echo 1,2,inf,4", "not a finite number"),
        ("echo 1,2,0,4", "no area"),
        ("echo 1,2,-3,4", "no area"),
        ("echo 1e300,2,3,4", "beyond"),
        ("echo 1,2,3", "not 3 numbers"),
        ("echo 0,0,2,1,0,2,0.5,1", "not convex"),
        ("echo 1,2,3,4 x", "`x` is no number"),
        ("echo 1,2,3,4 nan", "the confidence is not a finite number"),
        ("echo 1,2,3,4 1 1", "more than a region and a confidence"),
        ("echo '1,2,3,4 #1'", "the answer to message 1, but 0 was asked"),
        ("echo '1,2,3,4 1 #x'", "`#x` is no number of a message"),
        ("echo '#0'", "an empty line"),
        // One answer too much, after the next message was sent.
        (
            "echo '1,2,3,4 #0'; read -r line; echo '1,2,3,4 #0'; sleep 100",
            "frame 12 of Ramp: received `1,2,3,4 #0` (the answer to message 0, but 1 was asked)",
        ),
        ("echo", "an empty line"),
        ("printf '\\377\\n'", "received `\u{fffd}`"),
        ("printf '\\033[2J\\n'", "received `\u{fffd}[2J`"),
        ("head -c 1000000000 /dev/zero", "a line of 16384 bytes and more"),
        ("exit 3", "it ended (exit status: 3); expected"),
        ("kill -s KILL $$", "it ended (signal: 9"),
        ("echo one >&2; echo >&2; echo two >&2; exit 1", "its stderr ends with: one | two"),
        ("echo 1,2,3,4; exit 0", "frame 12 of Ramp: it ended (exit status: 0)"),
        ("echo 1,2,3,4; echo 1,2,3,4; sleep 100", "frame 12 of Ramp: it answered without being asked"),
        ("yes 1,2,3,4", "it answered without being asked"),
    ] {
        let script = Script::new(Protocol::Lines, &format!("read -r line; {text}"));
        let sequence = rendered();
        let fault = match script.start(&sequence, 0, &rect()) {
            Err(fault) => fault,
            Ok((mut tracker, _)) => {
                // Time for an answer that was not asked for.
                std::thread::sleep(Duration::from_millis(300));
                let fault = tracker.update(&Ramp.render(1)).unwrap_err();
                assert!(tracker.update(&Ramp.render(2)).is_err(), "it stays dead");
                fault
            }
        };
        let fault = fault.to_string();
        assert!(fault.starts_with("mine: frame 1") && fault.contains(words), "{text}: {fault}");
        assert!(fault.chars().count() < 600 && !fault.contains(char::is_control), "{fault}");
    }
}

/// A program that counts messages and gives each answer its number; `more` is run before the answer to message 3.
fn counting(more: &str) -> Script {
    let text = format!(
        "n=0; while read -r line; do [ \"$line\" = quit ] && exit 0; [ $n = 3 ] && {{ {more}; }}\n\
         echo \"1,2,3,4 0.5 #$n\"; n=$((n + 1)); done"
    );
    Script::new(Protocol::Lines, &text)
}

#[test]
fn answers_may_have_the_number_of_their_message() {
    assert_eq!(counting(":").track(6).unwrap().len(), 6);
    let fault = counting("echo 1,2,3,4 0.5 '#2'").track(6).unwrap_err();
    assert!(
        fault.contains("frame 14 of Ramp") && fault.contains("the answer to message 2, but 3"),
        "{fault}"
    );
}

#[test]
fn a_line_too_much_is_seen_at_the_last_frame_at_the_latest() {
    for stray in ["[ $n = 6 ] && { sleep 0.1; echo 1,2,3,4; }", "[ $n = 3 ] && echo 1,2,3,4"] {
        let text = format!(
            "n=0; while read -r line; do [ \"$line\" = quit ] && exit 0; echo 1,2,3,4; n=$((n + 1)); {stray}; done"
        );
        let fault = Script::new(Protocol::Lines, &text).track(6).unwrap_err();
        assert!(fault.contains("it answered without being asked"), "{fault}");
    }
}

#[test]
fn a_command_that_cannot_be_started_is_an_error() {
    let mut script = Script::new(Protocol::Lines, "");
    for command in ["no-such-program-at-all", "./not/here", "./script.sh"] {
        script.program.command = vec![command.into()];
        let fault = script.track(1).unwrap_err();
        assert!(
            fault.starts_with("mine: frame 11 of Ramp: cannot start `")
                && fault.contains(command.trim_start_matches('.')),
            "{fault}"
        );
    }
}

#[test]
fn hanging_programs_are_killed_with_all_they_started() {
    let answers = |n: usize| "read -r line; echo 1,2,3,4\n".repeat(n);
    for (text, words) in [
        ("sleep 1000".to_string(), "frame 11 of Ramp: no answer within 0.4 s"),
        (answers(2) + "sleep 1000", "frame 13 of Ramp: no answer within 0.2 s; expected `x,y,w,h`"),
        // A grandchild holds the streams while the program itself is gone.
        (answers(1) + "exit 0", "frame 12 of Ramp: "),
        // It closes its streams and stays.
        (answers(1) + "exec >&- 2>&- <&-; sleep 1000", "frame 12 of Ramp: it closed its stdout"),
    ] {
        let apart = if text.contains("exec") { ">/dev/null 2>&1" } else { "" };
        let start = format!("sleep 1000 {apart} & echo $! > grandchild; echo $$ > child\n");
        let script = Script::new(Protocol::Lines, &format!("{start}{text}")).impatient();
        let begin = Instant::now();
        let fault = script.track(6).unwrap_err();
        assert!(fault.contains(words), "{text}: {fault}");
        assert!(begin.elapsed() < Duration::from_secs(60), "{:?}", begin.elapsed());
        for name in ["child", "grandchild"] {
            assert!(testing::is_gone(&script.read(name)), "{text}: {name} is left");
        }
    }
}

/// Whether a process has ended; those that nobody waits for any more have, too.
#[test]
fn a_good_program_is_ended_with_all_it_started_too() {
    let script = Script::new(Protocol::Lines, &format!("sleep 1000 & echo $! > grandchild\n{GOOD}"));
    script.track(3).unwrap();
    assert!(script.read("log").ends_with("quit\n"));
    assert!(testing::is_gone(&script.read("grandchild")));
}

#[test]
fn floods_on_stderr_do_not_block() {
    let script = Script::new(Protocol::Lines, &format!("yes a line of many >&2 &\n{GOOD}"));
    assert_eq!(script.track(4).unwrap().len(), 4);
    let script =
        Script::new(Protocol::Lines, "yes a line of many | head -n 1000000 >&2; printf end >&2; exit 1");
    let fault = script.track(1).unwrap_err();
    assert!(fault.ends_with("a line of many | end") && fault.len() < 400, "{fault}");
}

/// A TraX tracker that writes down the lines that it gets; `answer` may use `$n`, the number of the question.
fn trax(hello: &str, answer: &str) -> Script {
    let state = format!("n=$((n + 1)); printf '@@TRAX:state {answer}\\n'");
    let text = format!(
        "echo \"$TRAX $TRACKFAIL_SEED $TRACKFAIL_RUN\" > environment; echo loading; n=0\n\
         printf '@@TRAX:hello {hello}\\n'\n\
         while read -r line; do\n\
             printf '%s\\n' \"$line\" >> log\n\
             case $line in\n\
                 @@TRAX:quit*) exit 0;;\n\
                 *initialize*png*|@@TRAX:frame*) {state};;\n\
             esac\n\
         done\n"
    );
    Script::new(Protocol::Trax, &text)
}

#[test]
fn trax_trackers_of_versions_1_to_3_are_followed() {
    for version in ["", "trax.version=1", "trax.version=2", "\"trax.version=3\" trax.channels=color;"] {
        let script = trax(&format!("{version} trax.name=x"), "\"'$n',2.5,3,4\" \"confidence=0.5\"");
        let states = script.track(3).unwrap();
        assert_eq!(states, [TrackerState::initialized(rect()), moved(2.0), moved(3.0)], "{version}");
        assert_eq!(script.read("environment"), "1 99 4\n");
        let log = script.read("log");
        let lines: Vec<&str> = log.lines().collect();
        assert!(
            lines[0].starts_with("@@TRAX:initialize \"file:///")
                && lines[0].ends_with(".png\" \"2,3.5,4,5\""),
            "{log}"
        );
        assert!(lines[1].starts_with("@@TRAX:frame \"file:///") && lines[1].ends_with(".png\""), "{log}");
        assert_eq!((lines.len(), lines[3]), (4, "@@TRAX:quit"));
    }
}

#[test]
fn in_version_4_the_image_follows_the_region() {
    let script = trax("trax.version=4", "\"'$n',2.5,3,4\"");
    assert_eq!(script.track(3).unwrap()[1..], [moved(2.0), moved(3.0)]);
    let log = script.read("log");
    let words: Vec<_> = log.lines().map(|l| l.split(' ').next().unwrap()).collect();
    let (i, f) = ("@@TRAX:initialize", "@@TRAX:frame");
    assert_eq!(words, [i, f, f, f, "@@TRAX:quit"]);
    assert_eq!(log.lines().next(), Some("@@TRAX:initialize \"2,3.5,4,5\""));
}

#[test]
fn trax_trackers_get_the_regions_they_read() {
    let turned = Region::Polygon(vec![(1.0, 1.0), (5.0, 2.0), (4.0, 6.0), (0.0, 5.0)]);
    for (regions, region, expected) in [
        ("rectangle;polygon;", &turned, "\"1,1,5,2,4,6,0,5\""),
        ("rectangle;polygon;", &rect(), "\"2,3.5,4,5\""),
        ("polygon;mask;", &rect(), "\"2,3.5,6,3.5,6,8.5,2,8.5\""),
        ("rectangle;", &Region::Polygon(rect().corners()), "\"2,3.5,4,5\""),
    ] {
        let script = trax(&format!("\"trax.region={regions}\""), "1,2,3,4");
        drop(script.start(&rendered(), 0, region).unwrap());
        assert!(script.read("log").lines().next().unwrap().ends_with(expected), "{regions}");
    }
}

#[test]
fn an_answer_without_a_place_repeats_the_last() {
    let states = trax("", "0").track(3).unwrap();
    assert_eq!(
        states,
        [TrackerState::initialized(rect()), TrackerState::tracked(rect()), TrackerState::tracked(rect())]
    );
}

#[test]
fn trax_faults_have_reasons() {
    let plain = |text: &str| Script::new(Protocol::Trax, text);
    for (script, words) in [
        (plain("exit 2"), "it ended (exit status: 2); expected `hello` of a TraX tracker"),
        (plain("sleep 1000").impatient(), "no answer within 0.2 s; expected `hello`"),
        (plain("yes").impatient(), "no answer within 0.2 s; expected `hello`"),
        (plain("echo @@TRAX:state 1,2,3,4; sleep 9"), "received `@@TRAX:state"),
        (trax("trax.version=5", "1,2,3,4"), "a version from 1 to 4"),
        (
            trax("\"trax.image=memory;data;\"", "1,2,3,4"),
            "it reads images as `memory, data`; expected `path`",
        ),
        (trax("\"trax.region=mask;\"", "1,2,3,4"), "it reads regions as `mask`; expected rectangle"),
        (
            trax("\"trax.channels=color;depth;\" trax.version=2", "1,2,3,4"),
            "it needs the image channels `color;depth;`; expected `color` alone",
        ),
        (trax("", "mask:0,0,2,2,1,3"), "masks are not read"),
        (trax("", "1,2,nan,4"), "not a finite number"),
        (trax("", "1,2,3,4 5,6,7,8"), "expected `state` with one region"),
        (plain("echo @@TRAX:hello; read -r l; echo '@@TRAX:quit \"trax.reason=no GPU\"'"), "it quit: no GPU"),
        (plain("echo @@TRAX:hello; read -r l; echo @@TRAX:frame a.png"), "received `@@TRAX:frame"),
        (
            plain("echo @@TRAX:hello; read -r l; head -c 300000000 /dev/zero; exit 5"),
            "it ended (exit status: 5)",
        ),
    ] {
        let fault = script.track(2).unwrap_err();
        assert!(fault.starts_with("mine: frame 11 of Ramp: ") && fault.contains(words), "{words}: {fault}");
    }
}
