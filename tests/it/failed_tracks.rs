//! Tracks that are missing, cut, empty or crashed: failure as data, with methods and without.

use crate::tools::output;
use std::path::{Path, PathBuf};

/// Frames of every sequence.
const FRAMES: usize = 10;
/// The target, which does not move, and a box beside it.
const TARGET: &str = "11,11,9,9\n";
const AWAY: &str = "81,11,9,9\n";

const LOCK: &str = r#"schema = 2

[[suite]]
name = "my-three"
title = "Three targets"
format = "otb-boxes"
source = "mine"
licence = "mine"
how_to_get = "ask me"
sequence = [
    { name = "a", folder = "truth/a.txt" },
    { name = "b", folder = "truth/b.txt" },
    { name = "c", folder = "truth/c.txt" },
]
"#;

const HEAD: &str = "schema = 1\nname = \"mine/three\"\ntitle = \"Three\"\n[suites]\ntest = \"my-three\"\n";

const ANALYSIS: &str = r#"
[[analysis]]
name = "ope"
compute = { kind = "success", rules = "otb-matlab/1" }
suites = ["test"]

[[table]]
name = "overall"
shows = "ope.overall"

[[table]]
name = "sequences"
shows = "ope.sequences"
column = "success AUC"

[[figure]]
name = "success"
kind = "chart"
shows = "ope.success"
"#;

const METHOD: &str = r#"
[[method]]
name = "every second"
protocol = "khalid2016/1"
detector = { kind = "periodic", period = 2 }

[[table]]
name = "alarms"
rows = ["detections"]
columns = "method"
"#;

/// A data root with three sequences, and with the results of trackers on them.
struct Place {
    dir: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let place = Self { dir: tempfile::tempdir().unwrap() };
        place.write("datasets.lock", LOCK);
        for sequence in ["a", "b", "c"] {
            place.write(&format!("truth/{sequence}.txt"), &TARGET.repeat(FRAMES));
        }
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    fn result(&self, tracker: &str, sequence: &str, text: &str) {
        self.write(&format!("results/{tracker}/{sequence}.txt"), text);
    }

    /// Exact results of a tracker on all three sequences.
    fn exact(&self, tracker: &str) {
        for sequence in ["a", "b", "c"] {
            self.result(tracker, sequence, &TARGET.repeat(FRAMES));
        }
    }

    /// `full` has lost the target of c, `part` has no file of it, and that of `cut` has three of ten lines.
    fn with_three_trackers() -> Self {
        let place = Self::new();
        for tracker in ["full", "part", "cut"] {
            place.exact(tracker);
        }
        place.result("full", "c", &AWAY.repeat(FRAMES));
        std::fs::remove_file(place.path("results/part/c.txt")).unwrap();
        place.result("cut", "c", &TARGET.repeat(3));
        place
    }

    /// Runs an experiment; exit code and what was printed to stdout and stderr.
    fn run(&self, spec: &str, more: &[&str]) -> (i32, String) {
        self.write("spec.toml", spec);
        let at = |name: &str| self.path(name).to_str().unwrap().to_owned();
        let (spec, data, results, reports) = (at("spec.toml"), at(""), at("r"), at("p"));
        let arguments = ["run", &spec, "--data-root", &data, "--results", &results, "--reports", &reports];
        let (code, said, told) = output(&[&arguments[..], more].concat());
        (code, said + &told)
    }

    /// A file of the results.
    fn kept(&self, name: &str) -> String {
        std::fs::read_to_string(self.path("r/mine/three").join(name)).unwrap()
    }
}

/// An experiment with these trackers.
fn spec(trackers: &[&str], rest: &str) -> String {
    let tracker = |t: &&str| format!("[[tracker]]\nname = \"replay\"\nresults = \"{t}\"\nlabel = \"{t}\"\n");
    format!("{HEAD}{}{rest}", trackers.iter().map(tracker).collect::<String>())
}

/// The experiment with a track of a tracker that is declared absent.
fn with_absent(spec: &str, tracker: &str, text: &str) -> String {
    let label = format!("label = \"{tracker}\"\n");
    spec.replace(&label, &format!("{label}absent = [{{ {text} }}]\n"))
}

/// The file of a result as messages have it.
fn file(tracker: &str, sequence: &str) -> String {
    Path::new("results").join(tracker).join(format!("{sequence}.txt")).display().to_string()
}

// Before: exit code 0 and no word, because no method has a cell that could fail.
#[test]
fn tracks_fail_without_methods_as_with_them() {
    let place = Place::with_three_trackers();
    for (rest, first) in [
        (ANALYSIS, "1 track is not there, the first: c, part"),
        (METHOD, "1 of 6 cells are not there, the first: c, part, every second"),
    ] {
        let reason = "no result of `part` for c, run 0: none of c.json, c.txt";
        let (code, told) = place.run(&spec(&["full", "part"], rest), &[]);
        assert_eq!(code, 3, "{told}");
        assert!(told.contains(&format!("{first}: {reason}")), "{told}");
        assert!(place.kept("manifest.json").contains(reason));
        let (code, told) = place.run(&spec(&["full", "part"], rest), &["--allow-missing"]);
        assert!(code == 0 && told.contains("not there: part, c"), "{code} {told}");

        // What is cut, empty or no boxes has failed, whether or not others may be missing.
        for (text, words) in [
            (TARGET.repeat(3), "3 boxes; c has 10 frames"),
            (String::new(), "the file is empty"),
            (TARGET.repeat(9) + "11,11,x,9\n", "c.txt, line 10"),
        ] {
            place.result("cut", "c", &text);
            let calls: [&[&str]; 3] = [&[], &["--allow-missing"], &["--shard", "1/1"]];
            for more in calls {
                let (code, told) = place.run(&spec(&["full", "cut"], rest), more);
                assert!(
                    code == 4 && told.contains(words) && told.contains(&file("cut", "c")),
                    "{code} {told}"
                );
            }
        }
    }
    let page = std::fs::read_to_string(place.path("p/mine/three/index.html")).unwrap();
    assert!(page.contains("line 10"), "{page}");
}

#[test]
fn a_share_names_tracks_whatever_their_trackers_are_called() {
    let place = Place::with_three_trackers();
    let spec = spec(&["full", "part"], METHOD).replace("label = \"part\"", "label = \"lab/part/2\"");
    let spec = spec.replace("name = \"every second\"", "name = \"every/second\"");
    let (code, told) = place.run(&spec, &["--shard", "1/1"]);
    assert!(
        code == 3 && told.contains("not there: lab/part/2, c, every/second: no result of `part`"),
        "{told}"
    );
    assert!(told.contains("the first: c, lab/part/2, every/second: no result of `part`"), "{told}");
    let without = spec.replace(METHOD.replace("every second", "every/second").as_str(), ANALYSIS);
    let (code, told) = place.run(&without, &["--shard", "1/1"]);
    assert!(
        code == 3 && told.contains("1 track is not there, the first: c, lab/part/2: no result"),
        "{told}"
    );
}

// Before: "no track in role `test` to analyse".
#[test]
fn the_file_is_named_where_a_tracker_has_none() {
    let place = Place::new();
    let (code, told) = place.run(&spec(&["gone"], ANALYSIS), &[]);
    assert_eq!(code, 3, "{told}");
    assert!(told.contains("not there: 3 tracks: no result of `gone` for a, run 0: none of a.json"), "{told}");
    assert!(told.contains("*, analysis ope of gone: no result of `gone` for a, run 0"), "{told}");
    assert!(!told.contains("no track in role"), "{told}");
}

// By hand: the success AUC of a target in all ten frames is 20/21, of one in the first frame 2/21, in five frames 10/21.
// `full` has 20/21, 20/21 and 2/21, `part` 10/21 and 20/21: the means of what each has are .667 and .714, but on a and b
// `full` is better, .952 and .714. Before: a star for .714.
#[test]
fn trackers_are_compared_on_the_sequences_that_all_have() {
    let place = Place::with_three_trackers();
    place.result("part", "a", &(TARGET.repeat(5) + &AWAY.repeat(5)));
    let claim = "[[claim]]\ntext = \"full is better\"\nrequired = true\n\
                 holds = \"finding[ope.success_auc, full] > finding[ope.success_auc, part]\"\n";
    let two = spec(&["full", "part", "gone"], &format!("{ANALYSIS}\n{claim}"));
    let (code, told) = place.run(&two, &["--allow-missing"]);
    assert_eq!(code, 0, "{told}");
    let table = place.kept("tables/overall.md");
    for line in [
        "| full (3 of 3 targets) | **0.952** | **1.000** |",
        "| part (2 of 3 targets) | 0.714 | 0.750 |",
        "my-three (the 2 of 3 targets that all trackers here have)",
    ] {
        assert!(table.contains(line), "{line}\n{table}");
    }
    let sequences = place.kept("tables/sequences.md");
    assert!(sequences.contains("part (2 of 3 targets)") && !sequences.contains("| c |"), "{sequences}");

    // A tracker alone has what it has, and says so.
    let (code, told) = place.run(&spec(&["cut"], ANALYSIS), &["--allow-missing"]);
    let table = place.kept("tables/overall.md");
    assert!(code == 4 && table.contains("| cut (2 of 3 targets) | 0.952 | 1 |"), "{told}\n{table}");

    // Where nothing is missing, there is nothing to tell.
    place.exact("part");
    let (code, told) = place.run(&spec(&["full", "part"], ANALYSIS), &[]);
    let table = place.kept("tables/overall.md");
    assert!(code == 0 && table.contains("| full | 0.667 | 0.700 |"), "{told}\n{table}");
    assert!(table.contains("Suites: my-three (3 targets); 3 targets."), "{table}");
}

#[test]
fn a_sequence_counts_if_all_runs_of_it_are_there() {
    let place = Place::new();
    for file in ["a_001", "a_002", "b_001", "b_002", "c_001"] {
        place.result("twice", file, &TARGET.repeat(FRAMES));
    }
    let twice = spec(&["twice"], ANALYSIS).replace("label = \"twice\"", "label = \"twice\"\nruns = 2");
    let (code, told) = place.run(&twice, &[]);
    assert!(code == 3 && told.contains("1 track is not there, the first: c, twice: no result"), "{told}");
    assert!(place.kept("tables/overall.md").contains("| twice (2 of 3 targets) |"), "{told}");

    // Two trackers that have no sequence in common.
    place.result("x", "a", &TARGET.repeat(FRAMES));
    place.result("y", "b", &TARGET.repeat(FRAMES));
    let (code, told) = place.run(&spec(&["x", "y"], ANALYSIS), &["--allow-missing"]);
    let reason = "there is no sequence of my-three that every tracker has a track of";
    assert!(code == 0 && told.contains(reason), "{code} {told}");
}

// Two methods on two trackers, one of which lacks a sequence: its numbers do not compete.
#[test]
fn numbers_of_fewer_sequences_have_no_star() {
    let place = Place::with_three_trackers();
    let by_tracker = METHOD
        .replace("columns = \"method\"", "columns = \"tracker\"")
        .replace("[\"detections\"]", "[\"fpr\", \"recall\"]");
    let (code, told) = place.run(&spec(&["full", "part"], &by_tracker), &["--allow-missing"]);
    let table = place.kept("tables/alarms.md");
    assert!(code == 0 && !table.contains("**1.000"), "{told}\n{table}");
    place.exact("part");
    let (_, told) = place.run(&spec(&["full", "part"], &by_tracker), &[]);
    let table = place.kept("tables/alarms.md");
    assert!(table.contains("**1.000** ="), "{told}\n{table}");
}

const CONFIDENCE: &str = r#"
[[method]]
name = "sure"
protocol = "khalid2016/1"
signal = { kind = "confidence" }
detector = { kind = "level", below = 0.5 }

[[table]]
name = "alarms"
rows = ["detections"]
columns = "method"
"#;

const ORDER: &str = r#"
[[method]]
name = "still"
protocol = "khalid2016/1"
signal = { kind = "box-motion", measure = "displacement" }
detector = { kind = "level", below = 0.5 }

[[table]]
name = "order"
methods = ["sure", "still"]
rank = "fpr"
"#;

// By hand: both methods alarm in every frame, so that both have the first rank where both have all sequences.
#[test]
fn a_method_without_a_result_for_a_sequence_has_no_rank() {
    let place = Place::new();
    place.exact("T");
    let spec = spec(&["T"], &format!("{CONFIDENCE}{ORDER}"));
    let confidence = |sequence| {
        place.write(&format!("results/T/{sequence}_confidence.value"), &"0.1\n".repeat(FRAMES));
    };
    ["a", "b"].into_iter().for_each(confidence);
    let (code, told) = place.run(&spec, &["--allow-missing"]);
    let table = place.kept("tables/order.md");
    assert_eq!(code, 0, "{told}");
    let row = |table: &str, method: &str| {
        let line = table.lines().find(|line| line.starts_with(&format!("| {method} |"))).unwrap();
        line.split('|').map(|cell| cell.trim().to_string()).skip(2).take(2).collect::<Vec<_>>()
    };
    let is_unranked = |cell: &str| cell.parse::<u32>().is_err();
    assert!(row(&table, "still")[0] == "1" && is_unranked(&row(&table, "sure")[0]), "{table}");
    assert!(row(&table, "sure")[1].ends_with('†') && !row(&table, "still")[1].contains('†'), "{table}");
    assert!(table.contains("† No result where other methods have one, so no rank."), "{table}");
    confidence("c");
    let (_, told) = place.run(&spec, &[]);
    let table = place.kept("tables/order.md");
    assert!(row(&table, "still")[0] == "1" && row(&table, "sure")[0] == "1", "{told}\n{table}");
    assert!(!table.contains('†'), "{table}");
}

const LONG_TERM: &str = r#"
[[analysis]]
name = "lt"
compute = { kind = "longterm", rules = "longterm/pysot/1" }
signal = { kind = "confidence" }
suites = ["test"]

[[table]]
name = "overall"
shows = "lt.overall"
"#;

// Before: exit code 0, "sure was not run on T (1 cell): it needs a tracker that gives its confidence", and numbers of two
// sequences under "3 targets".
#[test]
fn a_confidence_with_faults_is_a_failure_and_an_absent_one_is_missing() {
    for (rest, table) in [(CONFIDENCE, "alarms"), (LONG_TERM, "overall")] {
        let place = Place::new();
        place.exact("T");
        let spec = spec(&["T"], rest);
        let (code, told) = place.run(&spec, &[]);
        assert_eq!(code, 0, "{told}");
        assert!(
            told.contains("was not run on T")
                && told.contains("it needs a tracker that gives its confidence")
        );
        for sequence in ["a", "b"] {
            place.write(&format!("results/T/{sequence}_confidence.value"), &"0.9\n".repeat(FRAMES));
        }

        let reason = "there is no confidence in or beside results/T/c.txt, and other tracks of T have one";
        let (code, told) = place.run(&spec, &[]);
        assert!(code == 3 && told.contains(reason), "{code} {told}");
        assert!(!told.contains("was not run on"), "{told}");
        let (code, told) = place.run(&spec, &["--allow-missing"]);
        let shown = place.kept(&format!("tables/{table}.md"));
        assert!(code == 0 && told.contains(reason), "{code} {told}");
        let says = ["The data of 1 cell is not there", "T (2 of 3 targets)"];
        assert!(says.iter().any(|words| shown.contains(words)), "{shown}");

        let (file, other) = ("results/T/c_confidence.value", "results/T/c_scores.txt");
        let value = |n: usize| "0.9\n".repeat(n);
        for (files, words) in [
            (&[(file, value(FRAMES - 1))][..], "9 values for 10 boxes"),
            (&[(file, value(FRAMES + 1))], "11 values for 10 boxes"),
            (&[(file, value(9) + "much\n")], "c_confidence.value, line 10"),
            (&[(file, String::new())], "c_confidence.value: the file is empty"),
            (
                &[(file, value(FRAMES)), (other, value(FRAMES))],
                "c_scores.txt exist; name the one that is meant",
            ),
        ] {
            for (name, text) in files {
                place.write(name, text);
            }
            let (code, told) = place.run(&spec, &["--allow-missing"]);
            assert!(
                code == 4 && told.contains(words) && told.contains("c_confidence.value"),
                "{code} {told}"
            );
            for (name, _) in files {
                std::fs::remove_file(place.path(name)).unwrap();
            }
        }
        #[cfg(unix)]
        {
            // Reading a pipe without a writer would block.
            let pipe = place.path(file);
            assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
            let (code, told) = place.run(&spec, &["--allow-missing"]);
            assert!(code == 4 && told.contains("c_confidence.value: not a file"), "{code} {told}");
            std::fs::remove_file(&pipe).unwrap();
        }

        place.write(file, &value(FRAMES));
        let (code, told) = place.run(&spec, &[]);
        assert!(code == 0 && !told.contains("was not run on"), "{code} {told}");
    }
}

#[test]
fn a_declared_absence_is_no_failure_and_a_wrong_declaration_is_one() {
    let place = Place::with_three_trackers();
    let cut = |spec: String| with_absent(&spec, "cut", "sequence = \"c\", reason = \"its file was cut\"");
    for (rest, of_cells) in [(ANALYSIS, ""), (METHOD, " (1 cell)")] {
        let (code, told) = place.run(&cut(spec(&["full", "cut"], rest)), &[]);
        assert_eq!(code, 0, "{told}");
        let line = format!("cut has no track on c, as declared: its file was cut{of_cells}\n");
        assert!(told.contains(&line), "{line}\n{told}");
        let page = std::fs::read_to_string(place.path("p/mine/three/index.html")).unwrap();
        assert!(page.contains("cut has no track on c, as declared: its file was cut"), "{page}");
        assert!(page.contains("3 targets (2 of them with a track of cut)"), "{page}");
        assert_eq!(place.run(&cut(spec(&["full", "cut"], rest)), &["--shard", "1/1"]).0, 0);
        // Nothing else is excused.
        let (code, told) = place.run(&cut(spec(&["full", "cut", "part"], rest)), &[]);
        assert!(code == 3 && told.contains("no result of `part` for c"), "{code} {told}");
    }
    assert!(place.kept("scores.csv").contains("not run: has no track on c, as declared: its file was cut"));
    let (_, told) = place.run(&cut(spec(&["full", "cut"], ANALYSIS)), &[]);
    assert!(place.kept("tables/overall.md").contains("| cut (2 of 3 targets) |"), "{told}");

    place.exact("cut");
    for (more, rest) in [(&["--allow-missing"][..], METHOD), (&["--shard", "1/1"], ANALYSIS)] {
        let (code, told) = place.run(&cut(spec(&["full", "cut"], rest)), more);
        assert!(
            code == 4 && told.contains("c: a track of cut is declared `absent`, but can be read"),
            "{told}"
        );
    }

    for (text, words) in [
        ("sequence = \"cc\", reason = \"x\"", "unknown sequence `cc`"),
        ("sequence = \"c\", reason = \" \"", "`reason` must say why"),
        ("sequence = \"c\"", "`reason`"),
        ("sequence = \"c\", reason = \"x\", run = 1", "`run`"),
    ] {
        let (code, told) = place.run(&with_absent(&spec(&["full", "cut"], ANALYSIS), "cut", text), &[]);
        assert!(code == 2 && told.contains(words) && told.contains("spec.toml:"), "{code} {told}");
    }
    let ran =
        cut(spec(&["cut"], ANALYSIS)).replace("name = \"replay\"\nresults = \"cut\"", "name = \"still\"");
    let (code, told) = place.run(&ran, &[]);
    assert!(code == 2 && told.contains("only results that are replayed"), "{code} {told}");
}

/// A data root with the frames of two sequences, and a program that ends in the second frame of one of them.
#[cfg(unix)]
#[test]
fn a_tracker_that_crashes_on_a_sequence_has_failed_there() {
    let place = Place::new();
    for sequence in ["a", "b"] {
        let folder = place.path(&format!("mine/{sequence}/img"));
        std::fs::create_dir_all(&folder).unwrap();
        for t in 1..=FRAMES {
            image::RgbImage::new(64, 48).save(folder.join(format!("{t:04}.png"))).unwrap();
        }
        place.write(&format!("mine/{sequence}/groundtruth_rect.txt"), &TARGET.repeat(FRAMES));
    }
    std::fs::remove_file(place.path("datasets.lock")).unwrap();
    let root = place.path("").to_str().unwrap().to_owned();
    let (code, _, told) =
        output(&["data", "add", "my-three", "mine", "--format", "otb", "--data-root", &root]);
    assert_eq!(code, 0, "{told}");
    place.write(
        "tracker.sh",
        "while read -r line; do case $line in quit) exit;; \
         init*) region=$(printf '%s' \"$line\" | cut -f 3);; \
         */b/*) echo 'no memory' >&2; exit 7;; esac; echo \"$region\"; done\n",
    );
    let program =
        "[tracker.mine]\ncommand = [\"sh\", \"tracker.sh\"]\nprotocol = \"lines\"\nversion = \"1\"\n";
    place.write("plugins.toml", program);
    let plugins = place.path("plugins.toml").to_str().unwrap().to_owned();
    let spec = format!(
        "{HEAD}[[tracker]]\nname = \"still\"\n[[tracker]]\nname = \"process\"\nprogram = \"mine\"\nlabel = \"mine\"\n"
    );
    for rest in [ANALYSIS, METHOD] {
        let (code, told) = place.run(&(spec.clone() + rest), &["--plugins", &plugins, "--allow-missing"]);
        assert!(code == 4 && told.contains("failed: mine, b") && told.contains("no memory"), "{code} {told}");
    }
}

// `part` has no file of c, which is of another source than the videos that it was run on.
#[test]
fn a_tracker_has_no_cells_on_sources_that_are_not_its_own() {
    let place = Place::with_three_trackers();
    place.write("datasets.lock", &LOCK.replace("truth/c.txt", "clips/c.txt"));
    place.write("clips/c.txt", &TARGET.repeat(FRAMES));
    let label = "label = \"part\"\n";
    let on = |source: &str| {
        let spec = spec(&["full", "part"], METHOD);
        spec.replace(label, &format!("{label}sources = [\"{source}\"]\n"))
    };
    let (code, told) = place.run(&on("truth"), &[]);
    assert!(code == 0 && !told.contains("not there"), "{code} {told}");
    let scores = place.kept("scores.csv");
    let rows = |start: &str| scores.lines().filter(|line| line.starts_with(start)).count();
    assert_eq!([rows("my-three,c,full"), rows("my-three,c,part"), rows("my-three,a,part")], [1, 0, 1]);
    let (_, cells) = place.run(&on("truth"), &["--dry-run", "--format", "csv"]);
    let states = |start: &str| cells.lines().filter(|line| line.starts_with(start)).collect::<Vec<_>>();
    assert_eq!(
        (states("c,part").len(), cells.lines().filter(|line| line.contains("every second")).count()),
        (0, 5)
    );
    assert!(states("b,part")[0].ends_with(",cached") && states("c,full")[0].ends_with(",cached"), "{cells}");
    let (code, told) = place.run(&on("trut"), &[]);
    assert!(code == 2 && told.contains("unknown source of videos `trut`; did you mean `truth`?"), "{told}");
}
