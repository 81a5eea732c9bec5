//! Tables by attribute and tables of ranks, against the scores beside them.

use crate::tools::{assert_same_files, trackfail};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

const SPEC: &str = r#"schema = 1
name = "small"
title = "t"
protocol = "khalid2016/1"
[suites]
test = "synthetic-otb"
[[tracker]]
name = "still"
[[method]]
name = "often"
detector = { kind = "periodic", period = 10 }
[[method]]
name = "level"
signal.kind = "rgb-histogram"
detector = { kind = "level", below = 0.9 }
[[method]]
name = "strict"
signal.kind = "rgb-histogram"
detector = { kind = "level", below = 0.3 }
[[table]]
name = "parts"
rows = ["attribute"]
columns = "method"
metric = "recall"
[[table]]
name = "turned"
rows = ["tp", "events"]
columns = "attribute"
methods = ["level"]
[[table]]
name = "board"
rank = "recall"
"#;

fn run(root: &Path, spec: &str) -> (i32, String) {
    std::fs::write(root.join("a.toml"), spec).unwrap();
    let output = trackfail().current_dir(root).args(["run", "a.toml", "-q"]).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

/// Row and column of a table in CSV -> our number.
fn table(root: &Path, name: &str) -> BTreeMap<(String, String), f64> {
    let text = std::fs::read_to_string(root.join(format!("results/small/tables/{name}.csv"))).unwrap();
    let fields = text.lines().skip(1).map(|l| l.split(',').map(String::from).collect::<Vec<_>>());
    fields.filter_map(|f| Some(((f[2].clone(), f[3].clone()), f[4].parse().ok()?))).collect()
}

#[test]
fn parts_are_pooled_and_ranks_follow_the_measure() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    let (code, stderr) = run(root, SPEC);
    assert_eq!(code, 0, "{stderr}");
    let manifest = std::fs::read_to_string(root.join("results/small/manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    let attributes = manifest["suite"]["attributes"].as_object().unwrap();
    let scores = std::fs::read_to_string(root.join("results/small/scores.csv")).unwrap();
    // TP and FN of a method on the sequences with an attribute, or on all.
    let counted = |method: &str, attribute: &str| {
        let has = |sequence: &str| {
            attribute == "all"
                || attributes[sequence].as_array().unwrap().iter().any(|a| a.as_str() == Some(attribute))
        };
        let rows = scores.lines().skip(1).map(|l| l.split(',').collect::<Vec<_>>());
        let mine = rows.filter(|f| f[1] != "*" && f[4] == method && has(f[1]));
        mine.fold((0.0, 0.0), |(tp, fn_), f| {
            (tp + f[6].parse::<f64>().unwrap(), fn_ + f[8].parse::<f64>().unwrap())
        })
    };
    let (parts, turned, board) = (table(root, "parts"), table(root, "turned"), table(root, "board"));
    assert!(parts.len() > 6 && parts.contains_key(&("occlusion".to_string(), "level".to_string())));
    for ((attribute, method), value) in &parts {
        let (tp, fn_) = counted(method, attribute);
        assert_eq!(*value, tp / (tp + fn_), "{attribute} {method}");
    }
    for ((row, attribute), value) in &turned {
        let (tp, fn_) = counted("level", attribute);
        assert_eq!(*value, if row == "tp" { tp } else { tp + fn_ }, "{attribute} {row}");
    }
    let of = |method: &str, column: &str| board.get(&(method.to_string(), column.to_string())).copied();
    for (method, other) in [("level", "strict"), ("strict", "level")] {
        let (tp, fn_) = counted(method, "all");
        assert_eq!(of(method, "recall"), Some(tp / (tp + fn_)));
        let behind = of(other, "recall") > of(method, "recall");
        assert_eq!(of(method, "rank"), Some(if behind { 2.0 } else { 1.0 }));
        assert!((0.0..=1.0).contains(&of(method, "first").unwrap()));
    }
    // The anchor has a value, and no rank.
    assert!(of("often", "recall").is_some() && of("often", "rank").is_none());
}

#[test]
fn wrong_tables_are_refused() {
    let root = tempfile::tempdir().unwrap();
    for (from, to, what) in [
        ("metric = \"recall\"", "metric = \"score_mean\"", "not known attribute by attribute"),
        ("rank = \"recall\"", "rank = \"events\"", "`events` ranks nothing"),
        ("rank = \"recall\"", "rank = \"recal\"", "did you mean `recall`?"),
        ("rank = \"recall\"", "rank = \"recall\"\nrows = [\"tp\"]", "no rows, columns or metric of its own"),
        ("name = \"board\"", "name = \"macros\"", "the file with the numbers of all tables"),
        ("columns = \"attribute\"", "columns = \"attribut\"", "did you mean `attribute`?"),
    ] {
        let (code, stderr) = run(root.path(), &SPEC.replace(from, to));
        assert!(code == 2 && stderr.contains(what), "{to}: {code} {stderr}");
    }
}

// Presentation is not the result: a report of old results by a new file is that of a run of the new file.
#[test]
fn captions_order_and_selection_change_without_another_run() {
    let root = tempfile::tempdir().unwrap();
    let (before, after) = (root.path().join("before"), root.path().join("after"));
    let level = "[[method]]\nname = \"level\"\nsignal.kind = \"rgb-histogram\"\ndetector = { kind = \"level\", below = 0.9 }\n";
    let changed = SPEC.replace("title = \"t\"", "title = \"another\"\nnote = \"new\"").replace(level, "");
    let changed = changed.replace("[[tracker]]", &format!("{level}[[tracker]]")).replace(
        "metric = \"recall\"",
        "metric = \"precision\"\ncaption = \"By attribute\"\nmethods = [\"strict\", \"level\"]\n[[figure]]\nname = \"soon\"\nkind = \"delay\"",
    );
    for (folder, spec) in [(&before, SPEC), (&after, changed.as_str())] {
        std::fs::create_dir(folder).unwrap();
        assert_eq!(run(folder, spec), (0, String::new()));
    }
    std::fs::write(before.join("b.toml"), &changed).unwrap();
    std::fs::remove_dir_all(before.join("results/.store")).unwrap();
    let report = |file: &str| trackfail().current_dir(&before).args(["report", file]).output().unwrap();
    let output = report("b.toml");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let same = || {
        for folder in ["figures", "tables"] {
            let folder = Path::new("reports/small").join(folder);
            assert_same_files(&before.join(&folder), &after.join(&folder));
        }
    };
    same();
    for name in ["experiment.toml", "tables/parts.md", "tables/board.csv"] {
        let text = |folder: &Path| std::fs::read_to_string(folder.join("results/small").join(name)).unwrap();
        assert_eq!(text(&before), text(&after), "{name}");
    }
    // It is kept, and what numbers rest on is no presentation.
    assert!(report("small").status.success());
    same();
    std::fs::write(before.join("b.toml"), changed.replace("0.9", "0.8")).unwrap();
    let output = report("b.toml");
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("b.toml") && told.contains("other: method"), "{told}");
    let output = report("c.toml");
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("c.toml") && told.contains("No such file"), "{told}");
}

#[test]
fn chosen_tables_and_figures_are_put_into_one_folder_for_a_paper() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    assert_eq!(run(root, SPEC), (0, String::new()));
    let report = |arguments: &[&str]| {
        let output =
            trackfail().current_dir(root).args(["report", "small"]).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    assert_eq!(report(&["--paper", "all"]), (Some(0), String::new()));
    let only = ["--paper", "some", "--only", "parts", "--only", "headline"];
    assert_eq!(report(&only), (Some(0), String::new()));
    let names = |folder: &str| {
        let entries = std::fs::read_dir(root.join(folder)).unwrap();
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect::<BTreeSet<String>>()
    };
    let expected = ["paper.tex", "small-headline.pdf", "small-macros.tex", "small-parts.tex"];
    assert_eq!(names("some"), expected.map(String::from).into());
    assert!(names("all").is_superset(&names("some")) && names("all").contains("small-board.tex"));
    let paper = std::fs::read_to_string(root.join("some/paper.tex")).unwrap();
    assert!(paper.contains("\\input{small-parts}") && paper.contains("{small-headline}"), "{paper}");
    let (code, told) = report(&["--paper", "none", "--only", "partz"]);
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("parts") && !root.join("none").exists(), "{told}");
}
