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

    for name in ["frames.parquet", "signals.parquet", "truth.parquet", "measures.csv", "manifest.json"] {
        assert!(one.has(&format!("results/quickstart/{name}")), "{name}");
    }
    for name in ["results/quickstart/tables/table1", "reports/quickstart/figures/example"] {
        let endings = if name.contains("table") { ["csv", "md", "tex"] } else { ["svg", "png", "pdf"] };
        endings.iter().for_each(|ending| assert!(one.has(&format!("{name}.{ending}")), "{name}.{ending}"));
    }
    assert!(one.has("reports/quickstart/index.html") && one.has("reports/quickstart/report.md"));

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
