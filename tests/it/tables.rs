//! Tables by attribute and tables of ranks, against the scores beside them.

use crate::tools::{Place, Ran, Row, assert_same_files, number};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

const SPEC: &str = r#"schema = 1
name = "small"
title = "t"
protocol = "khalid2016/1"
suites.test = "synthetic-otb"
tracker = [{ name = "still" }]
method = [
    { name = "often", detector = { kind = "periodic", period = 10 } },
    { name = "level", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 } },
    { name = "strict", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.3 } },
]
table = [
    { name = "parts", rows = ["attribute"], columns = "method", metric = "recall" },
    { name = "turned", rows = ["tp", "events"], columns = "attribute", methods = ["level"] },
    { name = "board", rank = "recall" },
]
"#;

/// Row and column of a table in CSV -> our number.
fn table(place: &Place, name: &str) -> BTreeMap<(String, String), f64> {
    let rows = place.rows(&format!("results/small/tables/{name}.csv"));
    let cell = |row: &Row| Some(((row["row"].clone(), row["column"].clone()), row["ours"].parse().ok()?));
    rows.iter().filter_map(cell).collect()
}

#[test]
fn parts_are_pooled_and_ranks_follow_the_measure() {
    let place = Place::with(&[("a.toml", SPEC)]);
    assert_eq!(place.run("run a.toml -q").ends(0).err, "");
    let manifest = place.json("results/small/manifest.json");
    let attributes = manifest["suite"]["attributes"].as_object().unwrap();
    let scores = place.rows("results/small/scores.csv");
    // TP and FN of a method on the sequences with an attribute, or on all.
    let counted = |method: &str, attribute: &str| {
        let has = |sequence: &str| {
            attribute == "all" || attributes[sequence].as_array().unwrap().iter().any(|a| a == attribute)
        };
        let mine = |row: &&Row| row["sequence"] != "*" && row["method"] == method && has(&row["sequence"]);
        let sum = |name: &str| scores.iter().filter(mine).map(|row| number(row, name)).sum::<f64>();
        (sum("tp"), sum("fn"))
    };
    let [parts, turned, board] = ["parts", "turned", "board"].map(|name| table(&place, name));
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

    // Chosen tables and figures, and all, are put into one folder for a paper.
    for arguments in ["--paper all", "--paper some --only parts --only headline"] {
        assert_eq!(place.run(&format!("report small {arguments}")).ends(0).err, "");
    }
    let names = |folder: &str| -> BTreeSet<String> {
        place.list(folder).iter().map(|path| path.file_name().unwrap().display().to_string()).collect()
    };
    let expected = ["paper.tex", "small-headline.pdf", "small-macros.tex", "small-parts.tex"];
    assert_eq!(names("some"), expected.map(String::from).into());
    assert!(names("all").is_superset(&names("some")) && names("all").contains("small-board.tex"));
    let paper = place.read("some/paper.tex");
    assert!(paper.contains("\\input{small-parts}") && paper.contains("{small-headline}"), "{paper}");
    place.run("report small --paper none --only partz").ends(2).tells("parts");
    assert!(!place.has("none"));
}

#[test]
fn wrong_tables_are_refused() {
    for (from, to, words) in [
        ("metric = \"recall\"", "metric = \"score_mean\"", "not known attribute by attribute"),
        ("metric = \"recall\"", "metric = \"delay_median\"", "not known attribute by attribute"),
        ("rank = \"recall\"", "rank = \"events\"", "`events` ranks nothing"),
        ("rank = \"recall\"", "rank = \"recall\", rows = [\"tp\"]", "with a `rank` has no `rows` of its own"),
        ("name = \"board\"", "name = \"macros\"", "the file with the numbers of all tables"),
    ] {
        Place::with(&[("a.toml", &SPEC.replace(from, to))]).run("run a.toml -q").ends(2).tells(words);
    }
}

// Presentation is not the result: a report of old results by a new file is that of a run of the new file.
#[test]
fn captions_order_and_selection_change_without_another_run() {
    let level = SPEC.lines().find(|line| line.contains("name = \"level\"")).unwrap();
    let shown = "metric = \"precision\", caption = \"By attribute\", methods = [\"strict\", \"level\"]";
    let later = SPEC
        .replace("title = \"t\"", "title = \"another\"\nnote = \"new\"")
        .replace(level, "")
        .replace("method = [\n", &format!("method = [\n{level}\n"))
        .replace("metric = \"recall\"", shown);
    let later = later + "figure = [{ name = \"soon\", kind = \"delay\" }]\n";
    let place = Place::with(&[("before/a.toml", SPEC), ("after/a.toml", &later), ("before/b.toml", &later)]);
    let (before, after) = (place.path("before"), place.path("after"));
    // Runs the program in the folder of the old results.
    let old = |line: &str| Ran::of(place.command(line).current_dir(&before));
    assert_eq!(old("run a.toml -q").ends(0).err, "");
    assert_eq!(Ran::of(place.command("run a.toml -q").current_dir(&after)).ends(0).err, "");
    std::fs::remove_dir_all(before.join("results/.store")).unwrap();
    old("report b.toml").ends(0);
    let same = || {
        for folder in ["figures", "tables"] {
            let folder = Path::new("reports/small").join(folder);
            assert_same_files(&before.join(&folder), &after.join(&folder));
        }
    };
    same();
    for name in ["experiment.toml", "tables/parts.md", "tables/board.csv"] {
        let [one, other] = ["before", "after"].map(|at| place.read(&format!("{at}/results/small/{name}")));
        assert_eq!(one, other, "{name}");
    }
    // It is kept, and what numbers rest on is no presentation.
    old("report small").ends(0);
    same();
    place.write("before/b.toml", later.replace("0.9", "0.8"));
    old("report b.toml").ends(2).tells("b.toml").tells("other: method");
    old("report c.toml").ends(2).tells("c.toml").tells("No such file");
}
