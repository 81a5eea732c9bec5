use super::*;
use crate::table::build::{group, table};
use crate::testing::{self, items};

/// Experiment with precision and F over thresholds, in tables and figures. The table of F lacks the method
/// CovF.
fn experiment() -> Experiment {
    let tables = [
        "name = 'precision'; metric = 'precision'",
        "name = 'one'; metric = 'f_score'; methods = ['DTEF']",
        "name = 'two'; metric = 'f_score'; methods = ['DTEF', 'NAIVE']",
    ]
    .map(|keys| format!("{keys}; rows = ['threshold']; columns = 'method'"));
    let figures = [
        "name = 'precision'; kind = 'sweep'; metric = 'precision'; x = 'threshold'",
        "name = 'f'; kind = 'sweep'; metric = 'f_score'; x = 'threshold'; methods = ['DTEF', 'NAIVE']",
        "name = 'roc'; kind = 'curve'; metric = 'recall'; x = 'fpr'",
    ];
    let below = items("table", &tables.each_ref().map(String::as_str)) + &items("figure", &figures);
    let grid = "grid = { threshold = [0.002, 0.004] }";
    testing::experiment("", &[("DTEF", grid), ("NAIVE", grid), ("CovF", "")], &below)
}

fn first_figure(metric: Metric, best: &str) -> String {
    let figure = |name: &str| FigureView { name: name.into(), ..FigureView::default() };
    let mut figures = ["precision", "f", "roc", "headline"].map(figure);
    figure_first(&mut figures, &experiment(), (Some(metric), &[best.to_string()]), false);
    figures[0].name.clone()
}

#[test]
fn the_figure_at_the_head_is_of_the_metric_of_the_verdict() {
    assert_eq!(first_figure(Metric::F_SCORE, "DTEF"), "f");
    assert_eq!(first_figure(Metric::RECALL, "CovF"), "roc");
    assert_eq!(first_figure(Metric::F_SCORE, "CovF"), "headline", "the sweep lacks CovF");
    assert_eq!(first_figure(Metric::INFORMEDNESS, "DTEF"), "headline");
}

fn first_tables(best: &[&str]) -> Vec<String> {
    let named = |name: &str| {
        let rows = [("a".to_string(), Vec::new())];
        table(name, String::new(), "method", [""; 0], vec![group("", String::new(), rows)])
    };
    let tables = ["precision", "one", "two"].map(named).into();
    let mut page = Page { tables, ..Page::default() };
    let best: Vec<String> = best.iter().map(|b| (*b).to_string()).collect();
    table_first(&mut page, &experiment(), Metric::F_SCORE, (Some(named("ranked")), &best));
    page.tables.into_iter().map(|t| t.name).collect()
}

#[test]
fn the_table_at_the_head_has_the_metric_and_the_best_method() {
    assert_eq!(first_tables(&["DTEF"]), ["two", "precision", "one"]);
    assert_eq!(first_tables(&["DTEF", "CovF"]), ["two", "precision", "one"]);
    assert_eq!(first_tables(&["CovF"]), ["ranked", "precision", "one", "two"]);
}
