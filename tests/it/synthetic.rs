//! The main job without any data: quickstart, its files, its determinism.

use crate::tools::{assert_same_files, output, rows, trackfail};
use std::path::Path;

const COLUMNS: &str = "suite,sequence,tracker,run,method,params,tp,fp,fn,tn,events,detections,precision,\
recall,f_score,fpr,status";

fn quickstart(folder: &Path, jobs: &str) {
    let (results, reports) = (folder.join("results"), folder.join("reports"));
    trackfail()
        .arg("run")
        .args(["--jobs", jobs, "--quiet"])
        .arg("--results")
        .arg(&results)
        .arg("--reports")
        .arg(&reports)
        .assert()
        .success()
        .stdout("");
}

#[test]
fn quickstart_writes_the_same_files_with_one_and_two_threads() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    quickstart(one.path(), "1");
    quickstart(two.path(), "2");
    assert_same_files(one.path(), two.path());

    let folder = one.path().join("results/quickstart");
    for name in ["frames.parquet", "signals.parquet", "truth.parquet", "measures.csv", "manifest.json"] {
        assert!(folder.join(name).is_file(), "{name}");
    }
    for ending in ["csv", "md", "tex"] {
        assert!(folder.join("tables").join(format!("table1.{ending}")).is_file());
    }
    let reports = one.path().join("reports/quickstart");
    for name in
        ["index.html", "report.md", "figures/example.svg", "figures/example.png", "figures/example.pdf"]
    {
        assert!(reports.join(name).is_file(), "{name}");
    }

    let scores = std::fs::read_to_string(folder.join("scores.csv")).unwrap();
    assert_eq!(scores.lines().next().unwrap(), COLUMNS);
    let rows = rows(&scores);
    let number = |r: &std::collections::BTreeMap<String, String>, k: &str| r[k].parse::<u64>().unwrap();
    let cells: Vec<_> = rows.iter().filter(|r| r["sequence"] != "*").collect();
    assert!(cells.iter().all(|r| r["status"] == "ok"));
    for pooled in rows.iter().filter(|r| r["sequence"] == "*") {
        let same = |key: &str, r: &std::collections::BTreeMap<String, String>| r[key] == pooled[key];
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
    let again = tempfile::tempdir().unwrap();
    trackfail()
        .args(["report", "quickstart", "--results"])
        .arg(one.path().join("results"))
        .arg("--reports")
        .arg(again.path())
        .assert()
        .success();
    assert_same_files(&one.path().join("reports"), again.path());
}

#[test]
fn a_rendered_suite_is_read_back_as_it_was() {
    let root = tempfile::tempdir().unwrap();
    for (suite, truth) in [("synthetic-otb", "groundtruth_rect.txt"), ("synthetic-vot", "groundtruth.txt")] {
        let target = root.path().join(suite);
        trackfail().args(["data", "render", suite]).arg(&target).assert().success();
        let first = std::fs::read_dir(&target)
            .unwrap()
            .map(|e| e.unwrap().path())
            .filter(|p| p.is_dir())
            .min()
            .unwrap();
        assert!(first.join(truth).is_file());
        // A second time would mix two renderings.
        trackfail().args(["data", "render", suite]).arg(&target).assert().failure();
    }
}

#[test]
fn help_names_every_verb() {
    let (code, text, _) = output(&["--help"]);
    assert_eq!(code, 0);
    for verb in ["run", "report", "list", "data", "detect", "slurm"] {
        assert!(text.contains(&format!("\n  {verb}")), "{verb}");
    }
}

#[test]
fn lists_name_what_there_is() {
    let contains = |what: &str, words: &[&str]| {
        let (code, text, _) = output(&["list", what, "--format", "csv"]);
        assert_eq!(code, 0, "{what}");
        for word in words {
            assert!(text.contains(word), "{what}: {word}");
        }
    };
    contains(
        "experiments",
        &["quickstart", "khalid2016/table1", "khalid2016/table2", "sanmiguel2015/fig13-d1"],
    );
    contains(
        "suites",
        &["otb-dtef20", "vot2014", "synthetic-otb", "synthetic-vot", "synthetic-d1", "d1-real"],
    );
    fn kinds<T: ?Sized>(list: &[trackfail::plugin::Entry<T>]) -> Vec<&str> {
        list.iter().map(|entry| entry.kind).collect()
    }
    contains("trackers", &kinds(trackfail::tracker::TRACKERS));
    contains("signals", &kinds(trackfail::signal::SIGNALS));
    contains("detectors", &kinds(trackfail::detector::DETECTORS));
    contains("analyses", &kinds(trackfail::analysis::ANALYSES));
    contains("protocols", &["khalid2016/1", "sanmiguel2015/1"]);
    let (_, json, _) = output(&["list", "detectors", "--format", "json"]);
    assert!(serde_json::from_str::<serde_json::Value>(&json).unwrap().is_array());
}
