//! The main job without any data: quickstart, its files, its determinism.

use crate::tools::{Place, Row, assert_same_files};

const COLUMNS: &str = "suite,sequence,tracker,run,method,params,tp,fp,fn,tn,events,detections,precision,\
recall,f_score,fpr,status";

#[test]
fn quickstart_writes_the_same_files_with_one_and_two_threads() {
    let (one, two) = (Place::new(), Place::new());
    for (place, jobs) in [(&one, 1), (&two, 2)] {
        assert_eq!(place.run(&format!("run --jobs {jobs} --quiet")).ends(0).out, "");
    }
    assert_same_files(one.root(), two.root());

    let results = ["frames.parquet", "signals.parquet", "truth.parquet", "measures.csv", "manifest.json"];
    let tables = ["tables/table1.csv", "tables/table1.md", "tables/table1.tex"];
    for name in results.into_iter().chain(tables) {
        assert!(one.path(&format!("results/quickstart/{name}")).is_file(), "{name}");
    }
    for name in
        ["index.html", "report.md", "figures/example.svg", "figures/example.png", "figures/example.pdf"]
    {
        assert!(one.path(&format!("reports/quickstart/{name}")).is_file(), "{name}");
    }

    let scores = one.read("results/quickstart/scores.csv");
    assert_eq!(scores.lines().next().unwrap(), COLUMNS);
    let rows = one.rows("results/quickstart/scores.csv");
    let number = |r: &Row, k: &str| r[k].parse::<u64>().unwrap();
    let cells: Vec<_> = rows.iter().filter(|r| r["sequence"] != "*").collect();
    assert!(cells.iter().all(|r| r["status"] == "ok"));
    for pooled in rows.iter().filter(|r| r["sequence"] == "*") {
        let same = |key: &str, r: &Row| r[key] == pooled[key];
        let mine = cells.iter().filter(|r| same("method", r) && same("tracker", r));
        for key in ["tp", "fp", "fn", "tn", "events", "detections"] {
            let sum: u64 = mine.clone().map(|r| number(r, key)).sum();
            assert_eq!(sum, number(pooled, key), "{key} of {}", pooled["method"]);
        }
        assert_eq!(number(pooled, "tp") + number(pooled, "fn"), number(pooled, "events"));
        assert_eq!(number(pooled, "tp") + number(pooled, "fp"), number(pooled, "detections"));
    }
    // Closed forms of the anchors; a value that does not exist is empty, never 0.
    let pooled = |m: &str| rows.iter().find(|r| r["sequence"] == "*" && r["method"] == m).unwrap();
    assert_eq!(pooled("oracle")["f_score"], "1.0");
    assert_eq!(pooled("never")["precision"], "");
    assert_eq!(pooled("never")["recall"], "0.0");
    assert!(number(pooled("oracle"), "events") >= 10, "the suite must have failures to detect");

    // The report comes from results alone, and again with the same bytes.
    one.run("report quickstart --reports again").ends(0);
    assert_same_files(&one.path("reports"), &one.path("again"));
}

#[test]
fn a_rendered_suite_is_read_back_as_it_was() {
    let place = Place::new();
    for (suite, truth) in [("synthetic-otb", "groundtruth_rect.txt"), ("synthetic-vot", "groundtruth.txt")] {
        let render = format!("data render {suite} {suite}");
        place.run(&render).ends(0);
        let first = place.list(suite).into_iter().find(|path| path.is_dir()).unwrap();
        assert!(first.join(truth).is_file());
        // A second time would mix two renderings.
        assert_ne!(place.run(&render).code, Some(0));
    }
}

#[test]
fn help_names_every_verb() {
    let text = Place::new().run("--help").ends(0).out;
    for verb in ["run", "report", "list", "data", "detect", "slurm"] {
        assert!(text.contains(&format!("\n  {verb}")), "{verb}");
    }
}

#[test]
fn lists_name_what_there_is() {
    let place = Place::new();
    let contains = |what: &str, words: &[&str]| {
        let ran = place.run(&format!("list {what} --format csv")).ends(0);
        words.iter().fold(ran, |ran, word| ran.says(word));
    };
    let experiments = ["quickstart", "khalid2016/table1", "khalid2016/table2", "sanmiguel2015/fig13-d1"];
    contains("experiments", &experiments);
    let suites = ["otb-dtef20", "vot2014", "synthetic-otb", "synthetic-vot", "synthetic-d1", "d1-real"];
    contains("suites", &suites);
    fn kinds<T: ?Sized>(list: &[trackfail::plugin::Entry<T>]) -> Vec<&str> {
        list.iter().map(|entry| entry.kind).collect()
    }
    contains("trackers", &kinds(trackfail::tracker::TRACKERS));
    contains("signals", &kinds(trackfail::signal::SIGNALS));
    contains("detectors", &kinds(trackfail::detector::DETECTORS));
    contains("analyses", &kinds(trackfail::analysis::ANALYSES));
    contains("protocols", &["khalid2016/1", "sanmiguel2015/1"]);
    let json = place.run("list detectors --format json").out;
    assert!(serde_json::from_str::<serde_json::Value>(&json).unwrap().is_array());
}
