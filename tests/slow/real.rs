//! The papers' experiments on real sequences.

use crate::tools::{Place, Row, assert_same_files, needs, real_data};

/// A place with the results of an experiment of the program.
fn run(words: &str) -> Place {
    let place = Place::new();
    place.run(&format!("run {words} --data-root '{}'", real_data().display())).ends(0);
    place
}

#[needs(real_data)]
#[test]
fn table2_counts_the_failures_of_the_result_files() {
    let place = run("khalid2016/table2 --allow-missing --jobs 2");
    let all = place.rows("results/khalid2016/table2/scores.csv");
    // Lines `2` in the files of the eight sequences: grep -c '^2$' <tracker>/*/<sequence>/<sequence>_001.txt
    // kalman's files have 64; it was evaluated with upright boxes, and loses the turned ones five times
    // more often (diving 111 and 188, drunk 368, 541 and 562; counted with a polygon clipper in Python).
    for (tracker, failures) in [("GOTURN", "2"), ("PFTracker", "23"), ("CFTTracker", "9"), ("kalman", "69")] {
        let is_it = |r: &&Row| r["sequence"] == "*" && r["tracker"] == tracker && r["method"] == "DTEF";
        let pooled = all.iter().find(is_it).unwrap();
        assert_eq!(pooled["events"], failures, "{tracker}");
        assert_eq!(pooled["status"], "partial: 8 of 25");
    }
    assert_eq!(all.iter().filter(|r| r["status"].starts_with("missing")).count(), 17 * 8 * 22);
    place.holds("results/khalid2016/table2/tables/table2.md", &["8 of 25 targets", "DSST (7 events)"], &[]);
}

#[needs(real_data)]
#[test]
fn table1_says_how_many_targets_it_rests_on() {
    let place = run("khalid2016/table1 --allow-missing --jobs 2");
    place.holds("reports/khalid2016/table1/index.html", &["12 of 21 targets", "published"], &[]);
}

#[needs(real_data)]
#[test]
fn the_papers_figures_are_drawn_and_the_same_with_one_and_two_threads() {
    let [place, again] = [2, 1].map(|jobs| run(&format!("khalid2016/figures --allow-missing --jobs {jobs}")));
    assert_same_files(place.root(), again.root());
    for figure in ["fig3", "fig4", "fig5"] {
        for ending in ["svg", "png", "pdf"] {
            let name = format!("reports/khalid2016/figures/figures/{figure}.{ending}");
            assert!(place.path(&name).is_file(), "{name}");
        }
    }
}

#[needs(real_data)]
#[test]
fn changes_of_the_particle_filter_on_real_sequences_are_scored() {
    let place = run("sanmiguel2015/fig13-real --runs 1");
    let all = place.rows("results/sanmiguel2015/fig13-real/scores.csv");
    let of = |method: &str| all.iter().filter(|r| r["sequence"] == "*" && r["method"] == method).count();
    assert_eq!((of("AVU"), of("Two-MChi"), of("M-model"), of("EmpTh")), (8, 8, 1, 1));
    assert!(all.iter().all(|r| r["status"] == "ok"));
    let table = place.read("results/sanmiguel2015/fig13-real/tables/f-score.md");
    assert!(table.contains("7 targets, 1 run of 10, 1 run of 100 to learn from"), "{table}");
}
