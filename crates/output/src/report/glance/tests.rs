use super::*;
use crate::report::layouts::{cell, group, table};
use trackfail_engine::spec::read::parse;

/// Precision and F over thresholds, in tables and figures; the table of F lacks the method CovF.
fn experiment() -> Experiment {
    let text = r#"
        schema = 1
        name = "a"
        title = "a"
        protocol = "khalid2016/1"
        suites = { test = "synthetic-otb" }
        [[tracker]]
        name = "ncc"
        label = "NCC"
        [[method]]
        name = "DTEF"
        grid = { threshold = [0.002, 0.004] }
        [[method]]
        name = "NAIVE"
        grid = { threshold = [0.002, 0.004] }
        [[method]]
        name = "CovF"
        [[table]]
        name = "precision"
        rows = ["threshold"]
        columns = "method"
        metric = "precision"
        [[table]]
        name = "one"
        rows = ["threshold"]
        columns = "method"
        metric = "f_score"
        methods = ["DTEF"]
        [[table]]
        name = "two"
        rows = ["threshold"]
        columns = "method"
        metric = "f_score"
        methods = ["DTEF", "NAIVE"]
        [[figure]]
        name = "precision"
        kind = "sweep"
        metric = "precision"
        x = "threshold"
        [[figure]]
        name = "f"
        kind = "sweep"
        metric = "f_score"
        x = "threshold"
        methods = ["DTEF", "NAIVE"]
        [[figure]]
        name = "roc"
        kind = "curve"
        metric = "recall"
        x = "fpr"
    "#;
    parse("a.toml", text).unwrap()
}

fn figures() -> Vec<FigureView> {
    let figure = |name: &str| FigureView { file: format!("figures/{name}.svg"), ..FigureView::default() };
    ["precision", "f", "roc", "headline"].map(figure).into()
}

fn first_figure(metric: Metric, best: &str) -> String {
    let mut figures = figures();
    figure_first(&mut figures, &experiment(), (Some(metric), &[best.to_string()]), false);
    assert_eq!(figures.len(), 4);
    figures.remove(0).file
}

#[test]
fn the_figure_at_the_head_is_of_the_metric_of_the_verdict() {
    assert_eq!(first_figure(Metric::F_SCORE, "DTEF"), "figures/f.svg");
    assert_eq!(first_figure(Metric::RECALL, "CovF"), "figures/roc.svg");
    assert_eq!(first_figure(Metric::F_SCORE, "CovF"), "figures/headline.svg", "the sweep lacks CovF");
    assert_eq!(first_figure(Metric::INFORMEDNESS, "DTEF"), "figures/headline.svg");
}

fn named(name: &str) -> TableLayout {
    let rows = vec![("a".to_string(), vec![cell(Some(0.5), |v| format!("{v:.3}"))])];
    table(name, String::new(), "method", &["F1 score"], vec![group("", String::new(), rows)])
}

fn first_tables(best: &[&str]) -> Vec<String> {
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
