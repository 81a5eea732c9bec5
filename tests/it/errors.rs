//! Errors name file and line, and set the exit code.

use crate::tools::{Place, Ran, trackfail};

const SPEC: &str = r#"schema = 1
name = "mine/try"
title = "A try"
protocol = "khalid2016/1"

[suites]
test = "synthetic-vot"

[[tracker]]
name = "still"

[[method]]
name = "RAW"
signal = { kind = "rgb-histogram" }
detector = { kind = "level", below = 0.9 }

[[table]]
name = "t"
rows = ["recall"]
columns = "method"
"#;

/// More of an experiment, from line 21 on.
const MORE: &str = r#"
[[figure]]
name = "f"
kind = "strips"
panels = [["error"]]

[[analysis]]
name = "a"
signal = { kind = "uncertainty-change" }
compute = { kind = "cut-values" }
suites = ["test"]

[[table]]
name = "u"
shows = "a.cuts"
"#;

/// Right changes: a text of the file, and its replacement.
const RIGHT: [(&str, &str); 2] =
    [("still", "still"), ("0.9", r#"{ train = "test", maximise = "recall", grid = { quantiles = 9 } }"#)];

/// Wrong changes: a text of the file, its replacement, the line that is blamed, and a part of the message.
const WRONG: &[(&str, &str, usize, &str)] = &[
    ("title", "tittle", 3, "did you mean `title`?"),
    ("khalid2016/1", "khalid2016/7", 4, "did you mean `khalid2016/1`?"),
    ("synthetic-vot", "synthetic-vott", 7, "did you mean `synthetic-vot`?"),
    ("\"still\"", "\"stil\"", 10, "did you mean `still`?"),
    ("\"rgb-histogram\"", "\"rgb-histogramm\"", 14, "did you mean `rgb-histogram`?"),
    ("below", "bellow", 15, "did you mean `below`?"),
    ("0.9", "\"much\"", 15, "`below` must be a number or a table, not \"much\""),
    ("\"rgb-histogram\"", "\"distribution-field\", layers = 0", 14, "`layers` must be"),
    ("[\"recall\"]", "[\"recal\"]", 19, "did you mean `recall`?"),
    ("rows = [\"recall\"]\n", "", 18, "a table needs `rows` and `columns`, `rank` or `shows`"),
    ("columns = \"method\"", "columns = \"methods\"", 20, "did you mean `method`?"),
    ("schema = 1", "schema = 2", 1, "schema 2 is not known"),
    ("schema = 1", "schema = ", 1, ""),
    ("mine/try", "../try", 2, "must be words"),
    // Trackers.
    ("[[tracker]]", "[[tracker]]\nname = \"still\"\n[[tracker]]", 12, "two trackers are called `still`"),
    (
        "\"still\"",
        "\"still\"\nruns = \"ten\"",
        11,
        "`runs` must be a whole number from 1 to 1000, not \"ten\"",
    ),
    ("\"still\"", "\"still\"\nruns = -1", 11, "`runs` must be a whole number from 1 to 1000, not -1"),
    ("\"still\"", "\"still\"\nruns = 2000", 11, "`runs` must be a whole number from 1 to 1000, not 2000"),
    (
        "\"still\"",
        "\"still\"\ntraining_runs = 0",
        11,
        "`training_runs` must be a whole number from 1 to 1000, not 0",
    ),
    // A replay cannot leave the data root.
    ("\"still\"", "\"replay\"\nresults = \"../../etc\"", 11, ""),
    ("\"still\"", "\"replay\"\nresults = \"/etc\"", 11, ""),
    // Methods.
    ("[[method]]", "[[method]]\nname = \"RAW\"\n[[method]]", 15, "method `RAW` is listed twice"),
    ("\"RAW\"", "\"RAW\"\ntrackers = [\"stil\"]", 14, "did you mean `still`?"),
    ("\"RAW\"", "\"RAW\"\nprotocol = \"khalid2016/9\"", 14, "did you mean `khalid2016/1`?"),
    (
        "\"level\", below = 0.9 }",
        "\"accumulated-validation\", train = \"training\" }",
        13,
        "unknown suite role `training`",
    ),
    (
        "0.9",
        r#"{ train = "test", maximise = "recall", grid = { quantiles = 1 } }"#,
        15,
        "`quantiles` must be 2 to 1000",
    ),
    (
        "0.9",
        r#"{ train = "test", maximise = "recall", grid = { quantiles = 9, from = 0.0 } }"#,
        15,
        "or `quantiles` alone",
    ),
    (
        "0.9 }",
        "{ train = \"test\", maximise = \"f_score\", grid = { from = 0.1, to = 0.5, step = 0.1 } } }\n\
         [method.grid]\nbelow = [0.1, 0.2]",
        17,
        "`below` is trained",
    ),
    // Analyses.
    ("\"cut-values\"", "\"cut-value\"", 30, "did you mean `cut-values`?"),
    ("suites = [\"test\"]", "suites = [\"tests\"]", 31, "did you mean `test`?"),
    ("suites = [\"test\"]", "suites = [\"test\", \"test\"]", 31, "takes 1 to 1 suites"),
    ("\"cut-values\"", "\"cut-values\", alphas = [0.1, 0.05]", 30, "`alphas` must be"),
    ("a.cuts", "a.cut", 35, "did you mean `a.cuts`?"),
    // A figure is refused before the run and not after it.
    ("[[\"error\"]]", "[[\"error\"]]\nsequences = [\"bal\"]", 26, "did you mean `ball`?"),
    ("[[\"error\"]]", "[[\"error\"]]\nmetric = \"recall\"", 26, "a `strips` figure has no `metric`"),
    ("[[\"error\"]]", "[[\"error\"]]\nstills = 13", 26, "`stills` must be 0 to 12"),
    ("[[\"error\"]]", "[[\"error\"], []]", 23, "none of its rows is empty"),
    (
        "[[\"error\"]]",
        "[[\"signal:never\"]]\n[[method]]\nname = \"never\"\ndetector = { kind = \"never\" }",
        25,
        "`never` reads no signal",
    ),
    (
        "[[\"error\"]]",
        "[[\"score:G\"]]\n[[method]]\nname = \"G\"\nsignal = { kind = \"rgb-histogram\" }\n\
         detector = { kind = \"level\", below = 0.9 }\ngrid = { below = [0.1, 0.2] }",
        25,
        "`G` has a grid",
    ),
];

/// A dry run with one text of the file replaced by another.
fn with(from: &str, to: &str) -> Ran {
    let text = format!("{SPEC}{MORE}");
    assert!(text.contains(from), "{from}");
    Place::with(&[("try.toml", &text.replacen(from, to, 1))]).run("run try.toml --dry-run")
}

fn refused(from: &str, to: &str, line: usize, words: &str) {
    let ran = with(from, to).ends(2).tells(words);
    assert!(ran.err.starts_with(&format!("error: try.toml:{line}: ")), "{to}: {}", ran.err);
    // The message, the line of the file, and the mark below it.
    assert!([1, 3].contains(&ran.err.lines().count()), "{}", ran.err);
}

#[test]
fn a_wrong_experiment_names_line_and_nearest_word() {
    RIGHT.iter().for_each(|(from, to)| drop(with(from, to).ends(0)));
    WRONG.iter().for_each(|(from, to, line, words)| refused(from, to, *line, words));
    // Training has no value of these, or would look for the worst one.
    for word in ["score_mean", "fpr", "events"] {
        let grid = "{ from = 0.1, to = 0.5, step = 0.1 }";
        let train = format!("{{ train = \"test\", maximise = \"{word}\", grid = {grid} }}");
        refused("0.9", &train, 15, "precision, recall, f_score, tp");
    }
    let label = format!("\"still\"\nlabel = \"{}\"", "x".repeat(65));
    refused("\"still\"", &label, 11, "1 to 64 characters");
}

#[test]
fn published_numbers_belong_to_a_column_once() {
    let row = |values: &str| {
        format!("[[published]]\ntable = \"t\"\ntracker = \"SP\"\nrow = \"recall\"\nvalues = {{ {values} }}\n")
    };
    let refused = |rows: &str, line: usize, words: &str| {
        refused("columns = \"method\"", &format!("columns = \"method\"\n{rows}"), line, words);
    };
    refused(&row("RWA = \".1\""), 25, "did you mean `RAW`?");
    refused(&row("RAW = \"nan\""), 25, "`nan` is not a printed number");
    refused(&(row("RAW = \".1\"") + &row("RAW = \".2\"")), 29, "is listed twice");
}

#[test]
fn exit_codes_are_the_documented_ones() {
    let place = Place::new();
    for wrong in ["run no-such-experiment", "frobnicate", "data render synthetic-ott /nonexistent"] {
        place.run(wrong).ends(2);
    }
    let words = "25 of 25 sequences of suite vot2014 are missing: no data root is set";
    place.run("run khalid2016/table2").ends(3).tells(words).tells("votchallenge.net");
    place.run("run khalid2016/table2 --data-root /nonexistent").ends(3);
    let claim = "\n[[claim]]\ntext = \"impossible\"\nholds = \"recall[RAW] > 1\"\nrequired = true\n";
    place.write("try.toml", format!("{SPEC}{claim}"));
    place.run("run try.toml").ends(5);
    assert!(place.has("reports/mine/try/index.html"));
}

/// A place with the results of the experiment.
fn finished() -> Place {
    let place = Place::with(&[("try.toml", SPEC)]);
    let ran = place.run("run --quiet try.toml").ends(0);
    assert_eq!(ran.err, "");
    place
}

#[test]
fn damaged_results_are_an_error_and_never_a_number() {
    let place = finished();
    assert_eq!(place.run("report mine/try").ends(0).err, "");
    let name = "results/mine/try/measures.csv";
    let good = place.read(name);
    let done = good.lines().nth(1).unwrap().split(',').nth(4).unwrap().to_string();
    for bad in [good.replace(&format!(",{done},"), ",x,"), good[..good.len() - 9].to_string()] {
        place.write(name, bad);
        // The same code for every verb that reads them.
        for verb in ["report mine/try", "explain t recall RAW", "compare RAW RAW --in mine/try"] {
            place.run(verb).ends(1).tells("measures.csv");
        }
    }
}

#[test]
fn compared_results_that_are_damaged_are_no_results() {
    let place = finished();
    let compared =
        ["compare RAW RAW --in mine/try", "compare results/mine/try results/mine/try --results results"];
    let unknown = "unknown measure `recal`; did you mean `recall`?";
    place.run(&format!("{} --metric recal", compared[0])).ends(2).tells(unknown);
    for compare in compared {
        place.run(&format!("{compare} --tracker stil")).ends(2).tells("did you mean `still`?");
        let ran = place.run(&format!("{compare} --tracker kangaroo")).ends(2);
        assert!(ran.err.trim_end().ends_with("there is: still"), "{}", ran.err);
    }
    let name = "results/mine/try/scores.csv";
    let good = place.read(name);
    place.write(name, &good[..good.len() / 2]);
    compared.iter().for_each(|compare| drop(place.run(compare).ends(1).tells("scores.csv")));
    place.remove(name);
    compared.iter().for_each(|compare| drop(place.run(compare).ends(1).tells("scores.csv")));
}

#[test]
fn all_wrong_experiments_are_told_and_folders_are_none() {
    let [a, b] = ["tittle", "titel"].map(|wrong| SPEC.replacen("title", wrong, 1));
    let place = Place::with(&[("a.toml", &a), ("b.toml", &b)]);
    place.run("run a.toml b.toml").ends(2).tells("a.toml:3: ").tells("b.toml:3: ");
    place.run("run .").ends(2).tells(".: a folder; name an experiment file in it");
}

#[test]
fn long_numbers_have_an_exponent() {
    let grid = "below = 0.9 }\ngrid = { below = [1e-300, 0.5, 1e300] }";
    let tables = "columns = \"method\"\n\n[[table]]\nname = \"u\"\nrows = [\"below\"]\ncolumns = \"tracker\"\n\n\
                  [[table]]\nname = \"v\"\nrows = [\"attribute\"]\ncolumns = \"below\"\n";
    let spec = SPEC.replacen("below = 0.9 }", grid, 1).replacen("columns = \"method\"\n", tables, 1);
    let place = Place::with(&[("try.toml", &spec)]);
    let long = "0000000000";
    place.run("run try.toml --dry-run").never_says(long);
    place.run("run try.toml --dry-run --verbose").says("below=1e-300").never_says(long);
    place.run("run try.toml").says("below = 1e-300").never_says(long);
    for name in ["u", "v"] {
        for end in ["csv", "md", "tex"] {
            let text = place.read(&format!("results/mine/try/tables/{name}.{end}"));
            assert!(!text.contains(long), "{name}.{end}: {text}");
        }
    }
    assert!(place.read("reports/mine/try/index.html").contains("below = 1e-300"));
    assert!(place.read("results/mine/try/tables/u.md").contains("| 1e300 |"));
}

#[test]
fn report_knows_only_finished_experiments() {
    let place = finished();
    place.run("report mine/tri").ends(2).tells("did you mean `mine/try`?");
    ["report ../results/mine/try", "report /etc"].into_iter().for_each(|verb| drop(place.run(verb).ends(2)));
}

#[test]
fn a_figure_without_a_value_is_left_out_and_the_report_says_so() {
    // No tracker that never loses its target has a recall.
    let spec = SPEC
        .replace("\"still\"", "\"scripted\"")
        .replace("below = 0.9 }", "below = 0.9 }\ngrid = { below = [0.8, 0.9] }");
    let sweep = "[[figure]]\nname = \"f\"\nkind = \"sweep\"\nmetric = \"recall\"\nx = \"below\"\n";
    let place = Place::with(&[("try.toml", &(spec + sweep))]);
    assert_eq!(place.run("run try.toml --quiet").ends(0).err, "");
    let page = place.read("reports/mine/try/index.html");
    assert!(page.contains("Figure f is not drawn: recall has no value"), "{page}");
}

#[test]
fn the_environment_may_list_several_data_roots_and_none() {
    let place = Place::new();
    for arguments in ["run --dry-run", "data list"] {
        Ran::of(place.command(arguments).env("TRACKFAIL_DATA", "")).ends(0);
    }
    let list = |roots: [std::path::PathBuf; 2]| {
        Ran::of(
            trackfail().args(["data", "list"]).env("TRACKFAIL_DATA", std::env::join_paths(roots).unwrap()),
        )
    };
    let one = place.folder("one");
    assert_eq!(list([one.clone(), place.path("")]).ends(0).err, "");
    list([one, place.path("gone")]).ends(3).tells("gone: the data root is no folder");
}

#[test]
fn a_reader_that_has_gone_is_no_failure() {
    let place = Place::new();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_trackfail"))
        .args(["data", "render", "synthetic-otb", "--sequence", "Girl"])
        .arg(place.path("suite"))
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
