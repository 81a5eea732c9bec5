//! Errors name file and line, and set the exit code.

use crate::sent::place_with;
use crate::tools::{Place, Ran, assert_says};

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

/// Wrong changes: a text of the file, its replacement, the line that is blamed, and a part of the message. What is told of
/// words and types is tested where it is checked.
const WRONG: &[(&str, &str, usize, &str)] = &[
    ("\"still\"", "\"stil\"", 10, "did you mean `still`?"),
    ("\"rgb-histogram\"", "\"distribution-field\", layers = 0", 14, "`layers` must be"),
    ("rows = [\"recall\"]\n", "", 18, "a table needs `rows` and `columns`, `rank` or `shows`"),
    ("schema = 1", "schema = 2", 1, "schema 2 is not known"),
    // Trackers.
    ("[[tracker]]", "[[tracker]]\nname = \"still\"\n[[tracker]]", 12, "two trackers are called `still`"),
    ("\"still\"", "\"still\"\ntraining_runs = 0", 11, "`training_runs` must be"),
    // Methods.
    ("[[method]]", "[[method]]\nname = \"RAW\"\n[[method]]", 15, "method `RAW` is listed twice"),
    ("\"RAW\"", "\"RAW\"\ntrackers = [\"stil\"]", 14, "did you mean `still`?"),
    ("\"RAW\"", "\"RAW\"\nprotocol = \"khalid2016/9\"", 14, "did you mean `khalid2016/1`?"),
    ("\"level\", below = 0.9", "\"accumulated-validation\", train = \"t\"", 13, "suite role `t`"),
    ("0.9", r#"{ train = "test", maximise = "tp", grid.quantiles = 1 }"#, 15, "must be 2 to 1000"),
    ("0.9", r#"{ train = "test", maximise = "tp", grid = { quantiles = 9, from = 0.0 } }"#, 15, "alone"),
    // Analyses.
    ("signal = { kind = \"uncertainty-change\" }\n", "", 28, "cut-values needs a `signal`"),
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
    ("error\"]]", "signal:N\"]]\n[[method]]\nname = \"N\"\ndetector.kind = \"never\"", 25, "reads no signal"),
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
    with("still", "still").ends(0);
    with("0.9", r#"{ train = "test", maximise = "recall", grid = { quantiles = 9 } }"#).ends(0);
    WRONG.iter().for_each(|(from, to, line, words)| refused(from, to, *line, words));
    let trained = "{ train = \"test\", maximise = \"tp\", grid.quantiles = 9 } }\ngrid = { below = [1]";
    refused("0.9", trained, 16, "`below` is trained");
    let with_a_grid = "score:G\"]]\n[[method]]\nname = \"G\"\nlike = \"RAW\"\ngrid.below = [1]";
    refused("error\"]]", with_a_grid, 25, "`G` has a grid");
    // Training has no value of these, or would look for the worst one.
    for word in ["score_mean", "fpr", "events"] {
        let train = format!("{{ train = \"test\", maximise = \"{word}\", grid = {{ quantiles = 9 }} }}");
        refused("0.9", &train, 15, "precision, recall, f_score, tp");
    }
    refused("\"still\"", &format!("\"still\"\nlabel = \"{}\"", "x".repeat(65)), 11, "1 to 64 characters");
    let published =
        "[[published]]\ntable = \"t\"\ntracker = \"SP\"\nrow = \"recall\"\nvalues = { RAW = \".1\" }\n";
    let twice = format!("columns = \"method\"\n{published}{published}");
    refused("columns = \"method\"", &twice, 29, "is listed twice");
}

#[test]
fn exit_codes_are_the_documented_ones() {
    let place = Place::new();
    for (line, code) in [
        ("run no-such-experiment", 2),
        ("frobnicate", 2),
        ("data render synthetic-ott /nonexistent", 2),
        ("data list vot2104", 2),
        ("data list --format xml", 2),
        ("data list --format csv --data-root /no/such/folder", 3),
        ("data verify vot2014 --data-root .", 3),
        ("data verify vot2014 --allow-missing --data-root .", 0),
    ] {
        place.run(line).ends(code);
    }
    let words = "25 of 25 sequences of suite vot2014 are missing: no data root is set";
    place.run("run khalid2016/table2").ends(3).tells(words).tells("votchallenge.net");
    place.run("run khalid2016/table2 --data-root /nonexistent").ends(3);
    let claim = "\n[[claim]]\ntext = \"impossible\"\nholds = \"recall[RAW] > 1\"\nrequired = true\n";
    place.write("try.toml", format!("{SPEC}{claim}"));
    place.run("run try.toml").ends(5);
    assert!(place.has("reports/mine/try/index.html"));
    // Every wrong file is told, and a folder is none.
    for name in ["a.toml", "b.toml"] {
        place.write(name, SPEC.replacen("title", "tittle", 1));
    }
    place.run("run a.toml b.toml").ends(2).tells("a.toml:3: ").tells("b.toml:3: ");
    place.run("run .").ends(2).tells(".: a folder; name an experiment file in it");
}

#[test]
fn damaged_results_are_an_error_and_never_a_number() {
    let place = Place::with(&[("try.toml", SPEC)]);
    assert_eq!(place.run("run --quiet try.toml").ends(0).err, "");
    assert_eq!(place.run("report mine/try").ends(0).err, "");
    // Only finished experiments, and what they have, are known.
    let compared =
        ["compare RAW RAW --in mine/try", "compare results/mine/try results/mine/try --results results"];
    for (verb, words) in [
        ("report mine/tri".to_string(), "did you mean `mine/try`?"),
        ("report ../results/mine/try".into(), ""),
        ("report /etc".into(), ""),
        (format!("{} --metric recal", compared[0]), "did you mean `recall`?"),
        (format!("{} --tracker stil", compared[0]), "did you mean `still`?"),
        (format!("{} --tracker stil", compared[1]), "did you mean `still`?"),
        (format!("{} --tracker kangaroo", compared[0]), "there is: still\n"),
        (format!("{} --tracker kangaroo", compared[1]), "there is: still\n"),
    ] {
        place.run(&verb).ends(2).tells(words);
    }

    let name = "results/mine/try/measures.csv";
    let good = place.read(name);
    let done = good.lines().nth(1).unwrap().split(',').nth(4).unwrap().to_string();
    for bad in [good.replace(&format!(",{done},"), ",x,"), good[..good.len() - 9].to_string()] {
        place.write(name, bad);
        // The same code for every verb that reads them.
        for verb in ["report mine/try", "explain t recall RAW", compared[0]] {
            place.run(verb).ends(1).tells("measures.csv");
        }
    }
    place.write(name, good);
    let name = "results/mine/try/scores.csv";
    let scores = place.read(name);
    place.write(name, &scores[..scores.len() / 2]);
    compared.iter().for_each(|compare| drop(place.run(compare).ends(1).tells("scores.csv")));
    place.remove(name);
    compared.iter().for_each(|compare| drop(place.run(compare).ends(1).tells("scores.csv")));
}

// Before: only where methods are compared.
#[test]
fn an_unknown_tracker_is_refused_where_trackers_are_compared() {
    let place = place_with("quickstart");
    let compare = "compare KCF NCC --in quickstart --metric success_auc";
    place.run(compare).ends(0);
    place.run(&format!("{compare} --tracker Nope")).refuses(2, "unknown tracker `Nope`");
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
            place.holds(&format!("results/mine/try/tables/{name}.{end}"), &[], &[long]);
        }
    }
    assert!(place.read("reports/mine/try/index.html").contains("below = 1e-300"));
    assert!(place.read("results/mine/try/tables/u.md").contains("| 1e300 |"));
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
    assert_says(place.read("reports/mine/try/index.html"), "Figure f is not drawn: recall has no value");
}

#[test]
fn the_environment_may_list_several_data_roots_and_none() {
    let place = Place::new();
    for arguments in ["run --dry-run", "data list"] {
        Ran::of(place.command(arguments).env("TRACKFAIL_DATA", "")).ends(0);
    }
    let one = place.folder("one");
    let list = |other: &str| {
        let roots = std::env::join_paths([one.clone(), place.path(other)]).unwrap();
        Ran::of(place.command("data list").env("TRACKFAIL_DATA", roots))
    };
    assert_eq!(list("").ends(0).err, "");
    list("gone").ends(3).tells("gone: the data root is no folder");
}
