//! The papers' experiments on real sequences.

use crate::tools::{assert_same_files, needs, real_data, rows, trackfail};

fn run(name: &str, jobs: &str) -> tempfile::TempDir {
    let root = real_data();
    let dir = tempfile::tempdir().unwrap();
    trackfail()
        .args(["run", name, "--allow-missing", "--jobs", jobs, "--data-root"])
        .arg(root)
        .arg("--results")
        .arg(dir.path().join("results"))
        .arg("--reports")
        .arg(dir.path().join("reports"))
        .assert()
        .success();
    dir
}

#[needs(real_data)]
#[test]
fn table2_counts_the_failures_of_the_result_files() {
    let dir = run("khalid2016/table2", "2");
    let scores = std::fs::read_to_string(dir.path().join("results/khalid2016/table2/scores.csv")).unwrap();
    let all = rows(&scores);
    // Lines `2` in the files of the eight sequences: grep -c '^2$' <tracker>/*/<sequence>/<sequence>_001.txt
    // kalman's files have 64; it was evaluated with upright boxes, and loses the turned ones five times
    // more often (diving 111 and 188, drunk 368, 541 and 562; counted with a polygon clipper in Python).
    for (tracker, failures) in [("GOTURN", "2"), ("PFTracker", "23"), ("CFTTracker", "9"), ("kalman", "69")] {
        let pooled = all
            .iter()
            .find(|r| r["sequence"] == "*" && r["tracker"] == tracker && r["method"] == "DTEF")
            .unwrap();
        assert_eq!(pooled["events"], failures, "{tracker}");
        assert_eq!(pooled["status"], "partial: 8 of 25");
    }
    let missing = all.iter().filter(|r| r["status"].starts_with("missing")).count();
    assert_eq!(missing, 17 * 8 * 22);
    let table =
        std::fs::read_to_string(dir.path().join("results/khalid2016/table2/tables/table2.md")).unwrap();
    assert!(table.contains("8 of 25 targets"));
    assert!(table.contains("DSST (7 events)"));
}

#[needs(real_data)]
#[test]
fn table1_says_how_many_targets_it_rests_on() {
    let dir = run("khalid2016/table1", "2");
    let html = std::fs::read_to_string(dir.path().join("reports/khalid2016/table1/index.html")).unwrap();
    assert!(html.contains("12 of 21 targets") && html.contains("published"));
}

#[needs(real_data)]
#[test]
fn the_papers_figures_are_drawn_and_the_same_with_one_and_two_threads() {
    let (dir, again) = (run("khalid2016/figures", "2"), run("khalid2016/figures", "1"));
    assert_same_files(dir.path(), again.path());
    for figure in ["fig3", "fig4", "fig5"] {
        for ending in ["svg", "png", "pdf"] {
            let path = dir.path().join(format!("reports/khalid2016/figures/figures/{figure}.{ending}"));
            assert!(path.is_file(), "{}", path.display());
        }
    }
}

#[needs(real_data)]
#[test]
fn changes_of_the_particle_filter_on_real_sequences_are_scored() {
    let root = real_data();
    let dir = tempfile::tempdir().unwrap();
    let (results, reports) = (dir.path().join("results"), dir.path().join("reports"));
    let mut command = trackfail();
    command.args(["run", "sanmiguel2015/fig13-real", "--runs", "1", "--data-root"]).arg(root);
    command.arg("--results").arg(&results).arg("--reports").arg(&reports).assert().success();
    let folder = results.join("sanmiguel2015/fig13-real");
    let all = rows(&std::fs::read_to_string(folder.join("scores.csv")).unwrap());
    let of = |method: &str| all.iter().filter(|r| r["sequence"] == "*" && r["method"] == method).count();
    assert_eq!((of("AVU"), of("Two-MChi"), of("M-model"), of("EmpTh")), (8, 8, 1, 1));
    assert!(all.iter().all(|r| r["status"] == "ok"));
    let table = std::fs::read_to_string(folder.join("tables/f-score.md")).unwrap();
    assert!(table.contains("7 targets, 1 run of 10, 1 run of 100 to learn from"), "{table}");
}
