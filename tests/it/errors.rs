//! Errors name file and line, and set the exit code.

use crate::tools::{output, trackfail};

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

/// Exit code and message of a run with one text of the file replaced by another.
fn with(from: &str, to: &str) -> (i32, String) {
    assert!(SPEC.contains(from), "{from}");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("try.toml");
    std::fs::write(&path, SPEC.replacen(from, to, 1)).unwrap();
    let output = trackfail().arg("run").arg(&path).arg("--dry-run").output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).replace(&path.display().to_string(), "try.toml");
    (output.status.code().unwrap(), text)
}

#[track_caller]
fn refused(from: &str, to: &str, line: usize, words: &str) {
    let (code, text) = with(from, to);
    assert_eq!(code, 2, "{text}");
    assert!(text.starts_with(&format!("error: try.toml:{line}: ")), "{text}");
    assert!(text.contains(words), "{text}");
    // The message, the line of the file, and the mark below it.
    assert!([1, 3].contains(&text.lines().count()), "{text}");
}

#[test]
fn a_wrong_experiment_names_line_and_nearest_word() {
    assert_eq!(with("still", "still").0, 0);
    refused("title", "tittle", 3, "did you mean `title`?");
    refused("khalid2016/1", "khalid2016/7", 4, "did you mean `khalid2016/1`?");
    refused("synthetic-vot", "synthetic-vott", 7, "did you mean `synthetic-vot`?");
    refused("\"still\"", "\"stil\"", 10, "did you mean `still`?");
    refused("\"rgb-histogram\"", "\"rgb-histogramm\"", 14, "did you mean `rgb-histogram`?");
    refused("below", "bellow", 15, "did you mean `below`?");
    refused("0.9", "\"much\"", 15, "`below` must be a number or a table, not \"much\"");
    refused(
        "\"still\"",
        "\"still\"\nruns = \"ten\"",
        11,
        "`runs` must be a whole number from 1 to 1000, not \"ten\"",
    );
    refused("\"still\"", "\"still\"\nruns = -1", 11, "`runs` must be a whole number from 1 to 1000, not -1");
    refused("\"rgb-histogram\"", "\"distribution-field\", layers = 0", 14, "`layers` must be");
    refused("[\"recall\"]", "[\"recal\"]", 19, "did you mean `recall`?");
    refused("columns = \"method\"", "columns = \"methods\"", 20, "did you mean `method`?");
    refused("schema = 1", "schema = 2", 1, "schema 2 is not known");
    refused("mine/try", "../try", 2, "must be words");
    refused(
        "[[tracker]]",
        "[[tracker]]\nname = \"still\"\n[[tracker]]",
        12,
        "two trackers are called `still`",
    );
    refused("schema = 1", "schema = ", 1, "");
}

#[test]
fn methods_of_some_trackers_and_analyses_are_checked() {
    let method = "name = \"RAW\"\n";
    let of = |more: &str| format!("name = \"RAW\"\n{more}\n");
    refused(method, &of("trackers = [\"stil\"]"), 14, "did you mean `still`?");
    refused(method, &of("protocol = \"khalid2016/9\""), 14, "did you mean `khalid2016/1`?");
    refused(
        "\"still\"",
        "\"still\"\nruns = 2000",
        11,
        "`runs` must be a whole number from 1 to 1000, not 2000",
    );
    refused(
        "\"still\"",
        "\"still\"\ntraining_runs = 0",
        11,
        "`training_runs` must be a whole number from 1 to 1000, not 0",
    );
    let learns = "\"accumulated-validation\", train = \"training\" }";
    refused("\"level\", below = 0.9 }", learns, 13, "unknown suite role `training`");
    let quantiles =
        |grid: &str| format!("below = {{ train = \"test\", maximise = \"recall\", grid = {{ {grid} }} }}");
    assert_eq!(with("below = 0.9", &quantiles("quantiles = 9")).0, 0);
    refused("below = 0.9", &quantiles("quantiles = 1"), 15, "`quantiles` must be 2 to 1000");
    refused("below = 0.9", &quantiles("quantiles = 9, from = 0.0"), 15, "or `quantiles` alone");
    let analysis = |compute: &str, suites: &str| {
        let signal = "signal = { kind = \"uncertainty-change\" }";
        format!(
            "[[analysis]]\nname = \"a\"\n{signal}\ncompute = {{ {compute} }}\nsuites = {suites}\n\n[[table]]"
        )
    };
    let kind = "kind = \"cut-values\"";
    assert_eq!(with("[[table]]", &analysis(kind, "[\"test\"]")).0, 0);
    refused("[[table]]", &analysis("kind = \"cut-value\"", "[\"test\"]"), 20, "did you mean `cut-values`?");
    refused("[[table]]", &analysis(kind, "[\"tests\"]"), 21, "did you mean `test`?");
    refused("[[table]]", &analysis(kind, "[\"test\", \"test\"]"), 21, "takes 1 to 1 suites");
    let bad = "kind = \"cut-values\", alphas = [0.1, 0.05]";
    refused("[[table]]", &analysis(bad, "[\"test\"]"), 20, "`alphas` must be");
    let shows = analysis(kind, "[\"test\"]") + "\nname = \"u\"\nshows = \"a.cut\"\n\n[[table]]";
    refused("[[table]]", &shows, 25, "did you mean `a.cuts`?");
    refused("rows = [\"recall\"]\n", "", 18, "a table needs `rows` and `columns`, `rank` or `shows`");
}

#[test]
fn a_method_twice_is_refused() {
    let twice = "[[method]]\nname = \"RAW\"\n[[method]]";
    refused("[[method]]", twice, 15, "method `RAW` is listed twice");
}

#[test]
fn a_parameter_is_trained_or_in_the_grid_not_both() {
    let train = |maximise: &str| {
        format!(
            "{{ train = \"test\", maximise = \"{maximise}\", grid = {{ from = 0.1, to = 0.5, step = 0.1 }} }}"
        )
    };
    let grid = format!("{} }}\n[method.grid]\nbelow = [0.1, 0.2]", train("f_score"));
    refused("0.9 }", &grid, 17, "`below` is trained");
    // Training has no value of these, or would look for the worst one.
    for word in ["score_mean", "fpr", "events"] {
        refused("0.9", &train(word), 15, "precision, recall, f_score, tp");
    }
}

#[test]
fn a_figure_is_refused_before_the_run_and_not_after_it() {
    let figure =
        |more: &str| format!("columns = \"method\"\n[[figure]]\nname = \"f\"\nkind = \"strips\"\n{more}");
    let refused = |more: &str, line: usize, words: &str| {
        refused("columns = \"method\"", &figure(more), line, words);
    };
    refused("panels = [[\"error\"]]\nsequences = [\"bal\"]", 25, "did you mean `ball`?");
    refused("panels = [[\"error\"]]\nmetric = \"recall\"", 25, "a `strips` figure has no `metric`");
    refused("panels = [[\"error\"]]\nstills = 13", 25, "`stills` must be 0 to 12");
    refused("panels = [[\"error\"], []]", 22, "none of its rows is empty");
    let never =
        "panels = [[\"signal:never\"]]\n[[method]]\nname = \"never\"\ndetector = { kind = \"never\" }";
    refused(never, 24, "`never` reads no signal");
    let grid = "panels = [[\"score:G\"]]\n[[method]]\nname = \"G\"\nsignal = { kind = \"rgb-histogram\" }\n\
                detector = { kind = \"level\", below = 0.9 }\ngrid = { below = [0.1, 0.2] }";
    refused(grid, 24, "`G` has a grid");
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
fn a_wrong_label_is_blamed_on_its_own_line() {
    refused("\"still\"", &format!("\"still\"\nlabel = \"{}\"", "x".repeat(65)), 11, "1 to 64 characters");
}

#[test]
fn a_replay_cannot_leave_the_data_root() {
    for path in ["../../etc", "/etc"] {
        let (code, text) = with("\"still\"", &format!("\"replay\"\nresults = \"{path}\""));
        assert_eq!(code, 2, "{text}");
        assert!(text.contains("try.toml:11: "), "{text}");
    }
}

#[test]
fn exit_codes_are_the_documented_ones() {
    assert_eq!(output(&["run", "no-such-experiment"]).0, 2);
    assert_eq!(output(&["frobnicate"]).0, 2);
    assert_eq!(output(&["data", "render", "synthetic-ott", "/nonexistent"]).0, 2);
    let (code, _, text) = output(&["run", "khalid2016/table2"]);
    assert_eq!(code, 3, "{text}");
    assert!(
        text.contains("25 of 25 sequences of suite vot2014 are missing: no data root is set")
            && text.contains("votchallenge.net"),
        "{text}"
    );
    let (code, _, text) = output(&["run", "khalid2016/table2", "--data-root", "/nonexistent"]);
    assert_eq!(code, 3, "{text}");
}

#[test]
fn a_required_claim_that_does_not_hold_is_exit_code_5() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("try.toml");
    let claim = "\n[[claim]]\ntext = \"impossible\"\nholds = \"recall[RAW] > 1\"\nrequired = true\n";
    std::fs::write(&path, format!("{SPEC}{claim}")).unwrap();
    let output = trackfail()
        .arg("run")
        .arg(&path)
        .arg("--results")
        .arg(dir.path().join("results"))
        .arg("--reports")
        .arg(dir.path().join("reports"))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(5), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(dir.path().join("reports/mine/try/index.html").is_file());
}

/// Runs a spec into `root` and gives the exit code and stderr.
fn run_in(root: &std::path::Path, spec: &str) -> (i32, String) {
    let path = root.join("try.toml");
    std::fs::write(&path, spec).unwrap();
    let mut command = trackfail();
    command.arg("run").arg("--quiet").arg(&path).arg("--results").arg(root.join("results"));
    let output = command.arg("--reports").arg(root.join("reports")).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn report_in(root: &std::path::Path, name: &str) -> (i32, String) {
    let mut command = trackfail();
    command.args(["report", name, "--results"]).arg(root.join("results"));
    let output = command.arg("--reports").arg(root.join("reports")).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn damaged_results_are_an_error_and_never_a_number() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(run_in(dir.path(), SPEC), (0, String::new()));
    assert_eq!(report_in(dir.path(), "mine/try"), (0, String::new()));
    let path = dir.path().join("results/mine/try/measures.csv");
    let good = std::fs::read_to_string(&path).unwrap();
    let done = good.lines().nth(1).unwrap().split(',').nth(4).unwrap().to_string();
    for bad in [good.replace(&format!(",{done},"), ",x,"), good[..good.len() - 9].to_string()] {
        std::fs::write(&path, &bad).unwrap();
        let (code, text) = report_in(dir.path(), "mine/try");
        assert_eq!(code, 1, "{bad}{text}");
        assert!(text.contains("measures.csv"), "{text}");
        // The same code for every verb that reads them.
        let results = dir.path().join("results");
        for verb in [&["explain", "t", "recall", "RAW"][..], &["compare", "RAW", "RAW", "--in", "mine/try"]] {
            let output = trackfail().args(verb).arg("--results").arg(&results).output().unwrap();
            let text = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(1), "{verb:?} {text}");
            assert!(text.contains("measures.csv"), "{verb:?} {text}");
        }
    }
}

#[test]
fn compared_results_that_are_damaged_are_no_results() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(run_in(dir.path(), SPEC), (0, String::new()));
    let results = dir.path().join("results");
    let folder = results.join("mine/try").display().to_string();
    let compare = |words: &[&str]| {
        let output = trackfail().arg("compare").args(words).arg("--results").arg(&results).output().unwrap();
        (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (inside, folders) = (["RAW", "RAW", "--in", "mine/try"], [folder.as_str(), &folder]);
    let (code, text) = compare(&[&inside[..], &["--metric", "recal"]].concat());
    assert!(code == 2 && text.contains("unknown measure `recal`; did you mean `recall`?"), "{text}");
    for words in [&inside[..], &folders[..]] {
        let (code, text) = compare(&[words, &["--tracker", "stil"]].concat());
        assert!(code == 2 && text.contains("did you mean `still`?"), "{text}");
        let (code, text) = compare(&[words, &["--tracker", "kangaroo"]].concat());
        assert!(code == 2 && text.trim_end().ends_with("there is: still"), "{text}");
    }
    let path = results.join("mine/try/scores.csv");
    let good = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, &good[..good.len() / 2]).unwrap();
    for words in [&inside[..], &folders[..]] {
        let (code, text) = compare(words);
        assert!(code == 1 && text.contains("scores.csv"), "{code} {text}");
    }
    std::fs::remove_file(&path).unwrap();
    for words in [&inside[..], &folders[..]] {
        let (code, text) = compare(words);
        assert!(code == 1 && text.contains("scores.csv"), "{code} {text}");
    }
}

#[test]
fn all_wrong_experiments_are_told_and_folders_are_none() {
    let dir = tempfile::tempdir().unwrap();
    for (name, wrong) in [("a.toml", "tittle"), ("b.toml", "titel")] {
        std::fs::write(dir.path().join(name), SPEC.replacen("title", wrong, 1)).unwrap();
    }
    let run = |words: &[&str]| {
        let output = trackfail().current_dir(dir.path()).arg("run").args(words).output().unwrap();
        (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, text) = run(&["a.toml", "b.toml"]);
    assert!(code == 2 && text.contains("a.toml:3: ") && text.contains("b.toml:3: "), "{code} {text}");
    let (code, text) = run(&["."]);
    assert!(code == 2 && text.contains(".: a folder; name an experiment file in it"), "{code} {text}");
}

#[test]
fn tables_have_long_numbers_with_an_exponent() {
    let dir = tempfile::tempdir().unwrap();
    let grid = "below = 0.9 }\ngrid = { below = [1e-300, 0.5, 1e300] }";
    let tables = "columns = \"method\"\n\n[[table]]\nname = \"u\"\nrows = [\"below\"]\ncolumns = \"tracker\"\n\n\
                  [[table]]\nname = \"v\"\nrows = [\"attribute\"]\ncolumns = \"below\"\n";
    let spec = SPEC.replacen("below = 0.9 }", grid, 1).replacen("columns = \"method\"\n", tables, 1);
    let path = dir.path().join("try.toml");
    std::fs::write(&path, spec).unwrap();
    let output = trackfail().current_dir(dir.path()).args(["run", "try.toml"]).output().unwrap();
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(printed.contains("below = 1e-300") && !printed.contains("0000000000"), "{printed}");
    let folder = dir.path().join("results/mine/try/tables");
    for name in ["u", "v"] {
        for end in ["csv", "md", "tex"] {
            let text = std::fs::read_to_string(folder.join(format!("{name}.{end}"))).unwrap();
            assert!(!text.contains("0000000000"), "{name}.{end}: {text}");
        }
    }
    let page = std::fs::read_to_string(dir.path().join("reports/mine/try/index.html")).unwrap();
    assert!(page.contains("below = 1e-300"));
    assert!(std::fs::read_to_string(folder.join("u.md")).unwrap().contains("| 1e300 |"));
}

#[test]
fn small_parameters_are_written_with_an_exponent() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("try.toml");
    let grid = "below = 0.9 }\ngrid = { below = [1e-300, 0.5] }";
    std::fs::write(&path, SPEC.replacen("below = 0.9 }", grid, 1)).unwrap();
    let output = trackfail().arg("run").arg(&path).args(["--dry-run"]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(!text.contains("0000000000"), "{text}");
    let cells = trackfail().arg("run").arg(&path).args(["--dry-run", "--verbose"]).output().unwrap();
    let text = String::from_utf8_lossy(&cells.stdout);
    assert!(text.contains("below=1e-300") && !text.contains("0000000000"), "{text}");
}

#[test]
fn report_knows_only_finished_experiments() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(run_in(dir.path(), SPEC), (0, String::new()));
    let (code, text) = report_in(dir.path(), "mine/tri");
    assert_eq!(code, 2, "{text}");
    assert!(text.contains("did you mean `mine/try`?"), "{text}");
    for outside in ["../results/mine/try", "/etc"] {
        assert_eq!(report_in(dir.path(), outside).0, 2);
    }
}

#[test]
fn a_figure_without_a_value_is_left_out_and_the_report_says_so() {
    let dir = tempfile::tempdir().unwrap();
    // No tracker that never loses its target has a recall.
    let spec = SPEC
        .replace("\"still\"", "\"scripted\"")
        .replace("below = 0.9 }", "below = 0.9 }\ngrid = { below = [0.8, 0.9] }");
    let sweep = "[[figure]]\nname = \"f\"\nkind = \"sweep\"\nmetric = \"recall\"\nx = \"below\"\n";
    assert_eq!(run_in(dir.path(), &(spec + sweep)), (0, String::new()));
    let page = std::fs::read_to_string(dir.path().join("reports/mine/try/index.html")).unwrap();
    assert!(page.contains("Figure f is not drawn: recall has no value"), "{page}");
}

#[test]
fn an_empty_data_root_in_the_environment_is_none() {
    for arguments in [["run", "--dry-run"], ["data", "list"]] {
        let output = trackfail().env("TRACKFAIL_DATA", "").args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn the_environment_may_list_several_data_roots() {
    let dir = tempfile::tempdir().unwrap();
    let (one, gone) = (dir.path().join("one"), dir.path().join("gone"));
    std::fs::create_dir(&one).unwrap();
    let list = |roots: &[&std::path::Path]| {
        let roots = std::env::join_paths(roots).unwrap();
        let output = trackfail().env("TRACKFAIL_DATA", roots).args(["data", "list"]).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    assert_eq!(list(&[&one, dir.path()]), (Some(0), String::new()));
    let (code, message) = list(&[&one, &gone]);
    assert!(code == Some(3) && message.contains("gone: the data root is no folder"), "{code:?} {message}");
}

#[test]
fn a_reader_that_has_gone_is_no_failure() {
    let dir = tempfile::tempdir().unwrap();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_trackfail"))
        .args(["data", "render", "synthetic-otb", "--sequence", "Girl"])
        .arg(dir.path().join("suite"))
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
