//! Tracks that are missing, cut, empty or crashed: failure as data, with methods and without.

use crate::tools::{Place, Ran, assert_says, experiment, suite};

/// Frames of every sequence.
const FRAMES: usize = 10;
/// The target, which does not move, and a box beside it.
const TARGET: &str = "11,11,9,9\n";
const AWAY: &str = "81,11,9,9\n";

const SEQUENCES: [(&str, &str); 3] = [("a", "truth/a.txt"), ("b", "truth/b.txt"), ("c", "truth/c.txt")];

const HEAD: &str = "schema = 1\nname = \"mine/three\"\ntitle = \"Three\"\nsuites.test = \"my-three\"\n";

const ANALYSIS: &str = r#"
analysis = [{ name = "ope", compute = { kind = "success", rules = "otb-matlab/1" }, suites = ["test"] }]
table = [
    { name = "overall", shows = "ope.overall" },
    { name = "sequences", shows = "ope.sequences", column = "success AUC" },
]
figure = [{ name = "success", kind = "chart", shows = "ope.success" }]
"#;

const METHOD: &str = r#"
method = [{ name = "every second", protocol = "khalid2016/1", detector = { kind = "periodic", period = 2 } }]
table = [{ name = "alarms", rows = ["detections"], columns = "method" }]
"#;

const PAGE: &str = "reports/mine/three/index.html";

/// A data root with three sequences.
fn place() -> Place {
    let place = Place::with(&[("datasets.lock", &suite("my-three", "otb-boxes", &SEQUENCES))]);
    SEQUENCES.iter().for_each(|(_, file)| place.write(file, TARGET.repeat(FRAMES)));
    place
}

fn result(place: &Place, tracker: &str, sequence: &str, text: &str) {
    place.write(&format!("results/{tracker}/{sequence}.txt"), text);
}

/// Exact results of a tracker on all three sequences.
fn exact(place: &Place, tracker: &str) {
    ["a", "b", "c"].into_iter().for_each(|sequence| result(place, tracker, sequence, &TARGET.repeat(FRAMES)));
}

/// `full` has lost the target of c, `part` has no file of it, and that of `cut` has three of ten lines.
fn with_three_trackers() -> Place {
    let place = place();
    ["full", "part", "cut"].into_iter().for_each(|tracker| exact(&place, tracker));
    result(&place, "full", "c", &AWAY.repeat(FRAMES));
    place.remove("results/part/c.txt");
    result(&place, "cut", "c", &TARGET.repeat(3));
    place
}

fn run(place: &Place, spec: &str, more: &str) -> Ran {
    place.write("spec.toml", spec);
    place.run(&format!("run spec.toml --data-root . --results r {more}"))
}

/// A file of the results.
fn kept(place: &Place, name: &str) -> String {
    place.read(&format!("r/mine/three/{name}"))
}

/// An experiment with these trackers.
fn spec(trackers: &[&str], rest: &str) -> String {
    let tracker = |t: &&str| format!("[[tracker]]\nname = \"replay\"\nresults = \"{t}\"\nlabel = \"{t}\"\n");
    format!("{HEAD}{rest}{}", trackers.iter().map(tracker).collect::<String>())
}

/// The experiment with a track of a tracker that is declared absent.
fn with_absent(spec: &str, tracker: &str, text: &str) -> String {
    let label = format!("label = \"{tracker}\"\n");
    spec.replace(&label, &format!("{label}absent = [{{ {text} }}]\n"))
}

// Before: exit code 0 and no word, because no method has a cell that could fail.
#[test]
fn tracks_fail_without_methods_as_with_them() {
    let place = with_three_trackers();
    for (rest, first) in [
        (ANALYSIS, "1 track is not there, the first: c, part"),
        (METHOD, "1 of 6 cells are not there, the first: c, part, every second"),
    ] {
        let reason = "no result of `part` for c, run 0: none of c.json, c.txt";
        let part = spec(&["full", "part"], rest);
        run(&place, &part, "").ends(3).shows(&format!("{first}: {reason}"));
        assert!(kept(&place, "manifest.json").contains(reason));
        run(&place, &part, "--allow-missing").ends(0).shows("not there: part, c");

        // What is cut, empty or no boxes has failed, whether or not others may be missing.
        let file = std::path::Path::new("results").join("cut").join("c.txt").display().to_string();
        for (text, more, words) in [
            (TARGET.repeat(3), "", "3 boxes; c has 10 frames"),
            (String::new(), "--shard 1/1", "the file is empty"),
            (TARGET.repeat(9) + "11,11,x,9\n", "--allow-missing", "c.txt, line 10"),
        ] {
            result(&place, "cut", "c", &text);
            run(&place, &spec(&["full", "cut"], rest), more).ends(4).shows(words).shows(&file);
        }
    }
    assert!(place.read(PAGE).contains("line 10"));
    // What is missing has not failed.
    let part = spec(&["full", "part"], METHOD);
    let ran = run(&place, &part, "--allow-missing").ends(0);
    let ran = ran.says("The data of 1 cell is not there; it is left out.");
    let (page, index) = (place.read(PAGE), place.read("reports/index.html"));
    for text in [&ran.all(), &kept(&place, "tables/alarms.md"), &page, &index] {
        assert!(!text.to_lowercase().contains("failed:") && !text.contains("<dt>Failed"), "{text}");
    }
    assert!(page.contains("not there: no result of"), "{page}");
    place.holds("r/mine/three/scores.csv", &["\"missing: no result of `part`"], &["failed"]);
    let share = run(&place, &part, "--allow-missing --shard 1/1").ends(0).tells("not there: part, c");
    assert!(!share.err.contains("failed"), "{}", share.err);
}

#[test]
fn a_share_names_tracks_whatever_their_trackers_are_called() {
    let place = with_three_trackers();
    let spec = spec(&["full", "part"], METHOD).replace("label = \"part\"", "label = \"lab/part/2\"");
    let spec = spec.replace("name = \"every second\"", "name = \"every/second\"");
    let told = "not there: lab/part/2, c, every/second: no result of `part`";
    let first = "the first: c, lab/part/2, every/second: no result of `part`";
    run(&place, &spec, "--shard 1/1").ends(3).shows(told).shows(first);
    let without = spec.replace(&METHOD.replace("every second", "every/second"), ANALYSIS);
    let told = "1 track is not there, the first: c, lab/part/2: no result";
    run(&place, &without, "--shard 1/1").ends(3).shows(told);
}

// Before: "no track in role `test` to analyse".
#[test]
fn the_file_is_named_where_a_tracker_has_none() {
    let ran = run(&place(), &spec(&["gone"], ANALYSIS), "").ends(3).never_says("no track in role");
    let ran = ran.shows("not there: 3 tracks: no result of `gone` for a, run 0: none of a.json");
    ran.shows("*, analysis ope of gone: no result of `gone` for a, run 0");
}

// By hand: the success AUC of a target in all ten frames is 20/21, of one in the first frame 2/21, in five frames 10/21.
// `full` has 20/21, 20/21 and 2/21, `part` 10/21 and 20/21: the means of what each has are .667 and .714, but on a and b
// `full` is better, .952 and .714. Before: a star for .714.
#[test]
fn trackers_are_compared_on_the_sequences_that_all_have() {
    let place = with_three_trackers();
    result(&place, "part", "a", &(TARGET.repeat(5) + &AWAY.repeat(5)));
    let claim = "[[claim]]\ntext = \"full is better\"\nrequired = true\n\
                 holds = \"finding[ope.success_auc, full] > finding[ope.success_auc, part]\"\n";
    run(&place, &spec(&["full", "part", "gone"], &format!("{ANALYSIS}\n{claim}")), "--allow-missing").ends(0);
    let table = kept(&place, "tables/overall.md");
    for line in [
        "| full (3 of 3 targets) | **0.952** | **1.000** |",
        "| part (2 of 3 targets) | 0.714 | 0.750 |",
        "my-three (the 2 of 3 targets that all trackers here have)",
    ] {
        assert!(table.contains(line), "{line}\n{table}");
    }
    place.holds("r/mine/three/tables/sequences.md", &["part (2 of 3 targets)"], &["| c |"]);

    // A tracker alone has what it has, and says so.
    run(&place, &spec(&["cut"], ANALYSIS), "--allow-missing").ends(4);
    assert_says(kept(&place, "tables/overall.md"), "| cut (2 of 3 targets) | 0.952 | 1 |");

    // Where nothing is missing, there is nothing to tell.
    exact(&place, "part");
    run(&place, &spec(&["full", "part"], ANALYSIS), "").ends(0);
    let table = kept(&place, "tables/overall.md");
    assert!(table.contains("| full | 0.667 | 0.700 |"), "{table}");
    assert!(table.contains("Suites: my-three (3 targets); 3 targets."), "{table}");
}

#[test]
fn a_sequence_counts_if_all_runs_of_it_are_there() {
    let place = place();
    for file in ["a_001", "a_002", "b_001", "b_002", "c_001"] {
        result(&place, "twice", file, &TARGET.repeat(FRAMES));
    }
    let twice = spec(&["twice"], ANALYSIS).replace("label = \"twice\"", "label = \"twice\"\nruns = 2");
    run(&place, &twice, "").ends(3).shows("1 track is not there, the first: c, twice: no result");
    assert!(kept(&place, "tables/overall.md").contains("| twice (2 of 3 targets) |"));

    // Two trackers that have no sequence in common.
    result(&place, "x", "a", &TARGET.repeat(FRAMES));
    result(&place, "y", "b", &TARGET.repeat(FRAMES));
    let reason = "there is no sequence of my-three that every tracker has a track of";
    run(&place, &spec(&["x", "y"], ANALYSIS), "--allow-missing").ends(0).shows(reason);
}

// Two methods on two trackers, one of which lacks a sequence: its numbers do not compete.
#[test]
fn numbers_of_fewer_sequences_have_no_star() {
    let place = with_three_trackers();
    let shown = "rows = [\"detections\"], columns = \"method\"";
    let by_tracker = METHOD.replace(shown, "rows = [\"fpr\", \"recall\"], columns = \"tracker\"");
    let spec = spec(&["full", "part"], &by_tracker);
    run(&place, &spec, "--allow-missing").ends(0);
    place.holds("r/mine/three/tables/alarms.md", &[], &["**1.000"]);
    exact(&place, "part");
    run(&place, &spec, "");
    assert_says(kept(&place, "tables/alarms.md"), "**1.000** =");
}

const CONFIDENCE: &str = r#"
protocol = "khalid2016/1"
method = [{ name = "sure", signal.kind = "confidence", detector = { kind = "level", below = 0.5 } }]
table = [{ name = "alarms", rows = ["detections"], columns = "method" }]
"#;

const ORDER: &str = r#"
protocol = "khalid2016/1"
method = [
    { name = "sure", signal.kind = "confidence", detector = { kind = "level", below = 0.5 } },
    { name = "still", signal = { kind = "box-motion", measure = "displacement" }, detector = { kind = "level", below = 0.5 } },
]
table = [{ name = "order", methods = ["sure", "still"], rank = "fpr" }]
"#;

// By hand: both methods alarm in every frame, so that both have the first rank where both have all sequences.
#[test]
fn a_method_without_a_result_for_a_sequence_has_no_rank() {
    let place = place();
    exact(&place, "T");
    let spec = spec(&["T"], ORDER);
    let confidence = |sequence| {
        place.write(&format!("results/T/{sequence}_confidence.value"), "0.1\n".repeat(FRAMES));
    };
    ["a", "b"].into_iter().for_each(confidence);
    run(&place, &spec, "--allow-missing").ends(0);
    let table = kept(&place, "tables/order.md");
    let row = |table: &str, method: &str| {
        let line = table.lines().find(|line| line.starts_with(&format!("| {method} |"))).unwrap();
        line.split('|').map(|cell| cell.trim().to_string()).skip(2).take(2).collect::<Vec<_>>()
    };
    let is_unranked = |cell: &str| cell.parse::<u32>().is_err();
    assert!(row(&table, "still")[0] == "1" && is_unranked(&row(&table, "sure")[0]), "{table}");
    assert!(row(&table, "sure")[1].ends_with('†') && !row(&table, "still")[1].contains('†'), "{table}");
    assert!(table.contains("† No result where other methods have one, so no rank."), "{table}");
    confidence("c");
    run(&place, &spec, "");
    let table = kept(&place, "tables/order.md");
    assert!(row(&table, "still")[0] == "1" && row(&table, "sure")[0] == "1", "{table}");
    assert!(!table.contains('†'), "{table}");
}

const LONG_TERM: &str = r#"
analysis = [{ name = "lt", compute = { kind = "longterm", rules = "longterm/pysot/1" }, signal.kind = "confidence", suites = ["test"] }]
table = [{ name = "overall", shows = "lt.overall" }]
"#;

// Before: exit code 0, "sure was not run on T (1 cell): it needs a tracker that gives its confidence", and numbers of two
// sequences under "3 targets".
#[test]
fn a_confidence_with_faults_is_a_failure_and_an_absent_one_is_missing() {
    for (rest, table) in [(CONFIDENCE, "alarms"), (LONG_TERM, "overall")] {
        let place = place();
        exact(&place, "T");
        let spec = spec(&["T"], rest);
        let needs = "it needs a tracker that gives its confidence";
        run(&place, &spec, "").ends(0).shows("was not run on T").shows(needs);
        for sequence in ["a", "b"] {
            place.write(&format!("results/T/{sequence}_confidence.value"), "0.9\n".repeat(FRAMES));
        }

        let reason = "there is no confidence in or beside results/T/c.txt, and other tracks of T have one";
        run(&place, &spec, "").ends(3).shows(reason).never_says("was not run on");
        run(&place, &spec, "--allow-missing").ends(0).shows(reason);
        let shown = kept(&place, &format!("tables/{table}.md"));
        let says = ["The data of 1 cell is not there", "T (2 of 3 targets)"];
        assert!(says.iter().any(|words| shown.contains(words)), "{shown}");

        let file = "results/T/c_confidence.value";
        for (text, words) in [
            ("0.9\n".repeat(FRAMES - 1), "9 values for 10 boxes"),
            ("0.9\n".repeat(9) + "much\n", "c_confidence.value, line 10"),
        ] {
            place.write(file, text);
            run(&place, &spec, "--allow-missing").ends(4).shows(words).shows("c_confidence.value");
        }
        place.write(file, "0.9\n".repeat(FRAMES));
        run(&place, &spec, "").ends(0).never_says("was not run on");
    }
}

#[test]
fn a_declared_absence_is_no_failure_and_a_wrong_declaration_is_one() {
    let place = with_three_trackers();
    let cut = |spec: String| with_absent(&spec, "cut", "sequence = \"c\", reason = \"its file was cut\"");
    for (rest, of_cells) in [(ANALYSIS, ""), (METHOD, " (1 cell)")] {
        let declared = cut(spec(&["full", "cut"], rest));
        let line = "cut has no track on c, as declared: its file was cut";
        run(&place, &declared, "").ends(0).shows(&format!("{line}{of_cells}\n"));
        place.holds(PAGE, &[line, "3 targets (2 of them with a track of cut)"], &[]);
        run(&place, &declared, "--shard 1/1").ends(0);
        // Nothing else is excused.
        let more = cut(spec(&["full", "cut", "part"], rest));
        run(&place, &more, "").ends(3).shows("no result of `part` for c");
    }
    assert_says(kept(&place, "scores.csv"), "not run: has no track on c, as declared: its file was cut");
    run(&place, &cut(spec(&["full", "cut"], ANALYSIS)), "");
    assert!(kept(&place, "tables/overall.md").contains("| cut (2 of 3 targets) |"));

    exact(&place, "cut");
    for (more, rest) in [("--allow-missing", METHOD), ("--shard 1/1", ANALYSIS)] {
        let words = "c: a track of cut is declared `absent`, but can be read";
        run(&place, &cut(spec(&["full", "cut"], rest)), more).ends(4).shows(words);
    }

    for (text, words) in [
        ("sequence = \"cc\", reason = \"x\"", "unknown sequence `cc`"),
        ("sequence = \"c\", reason = \" \"", "`reason` must say why"),
        ("sequence = \"c\"", "`reason`"),
        ("sequence = \"c\", reason = \"x\", run = 1", "`run`"),
    ] {
        let wrong = with_absent(&spec(&["full", "cut"], ANALYSIS), "cut", text);
        run(&place, &wrong, "").ends(2).shows(words).shows("spec.toml:");
    }
    let replayed = "name = \"replay\"\nresults = \"cut\"";
    let still = cut(spec(&["cut"], ANALYSIS)).replace(replayed, "name = \"still\"");
    run(&place, &still, "").ends(2).shows("only results that are replayed");
}

// Before: all cells of its tracker had failed, and those of the trackers that have this one as a companion.
#[test]
fn a_signal_that_crashes_has_failed_for_its_own_methods_alone() {
    let plugins = "[signal.bad]\ncommand = [\"false\"]\nversion = \"1\"\n";
    let place = Place::with(&[("plugins.toml", plugins)]);
    let rest = r#"suites.train = "synthetic-otb"
tracker = [{ name = "ncc" }, { name = "still" }]
method = [
    { name = "companions", signal.kind = "companion-overlap", detector = { kind = "level", below = 0.1 } },
    { name = "trained", signal.kind = "box-motion", detector = { kind = "level", above = { train = "train", maximise = "f_score", grid = { quantiles = 5 } } } },
    { name = "broken", trackers = ["still"], signal = { kind = "process", program = "bad" }, detector = { kind = "level", below = { train = "train", maximise = "f_score", grid = { quantiles = 5 } } } },
]
"#;
    let spec = experiment("mine/three", "synthetic-vot", rest);
    for _ in ["computed", "from the store"] {
        let ran = run(&place, &spec, "").ends(4).shows("9 of 45 cells failed");
        ran.shows("broken").never_says("companion still");
    }
}

// `part` has no file of c, which is of another source than the videos that it was run on.
#[test]
fn a_tracker_has_no_cells_on_sources_that_are_not_its_own() {
    let place = with_three_trackers();
    place.write("datasets.lock", place.read("datasets.lock").replace("truth/c.txt", "clips/c.txt"));
    place.write("clips/c.txt", TARGET.repeat(FRAMES));
    let label = "label = \"part\"\n";
    let on = |source: &str| {
        spec(&["full", "part"], METHOD).replace(label, &format!("{label}sources = [\"{source}\"]\n"))
    };
    run(&place, &on("truth"), "").ends(0).never_says("not there");
    let scores = kept(&place, "scores.csv");
    let rows = |start: &str| scores.lines().filter(|line| line.starts_with(start)).count();
    assert_eq!([rows("my-three,c,full"), rows("my-three,c,part"), rows("my-three,a,part")], [1, 0, 1]);
    let cells = run(&place, &on("truth"), "--dry-run --format csv").out;
    let of = |start: &str| cells.lines().find(|line| line.starts_with(start));
    assert_eq!((of("c,part"), cells.lines().filter(|line| line.contains("every second")).count()), (None, 5));
    let is_cached = |line: Option<&str>| line.is_some_and(|line| line.ends_with(",cached"));
    assert!(is_cached(of("b,part")) && is_cached(of("c,full")), "{cells}");
    run(&place, &on("trut"), "").ends(2).shows("unknown source of videos `trut`; did you mean `truth`?");
}
