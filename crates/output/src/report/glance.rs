//! Head of a page: the figure and the table that support the verdict.

use super::page::{FigureView, Page};
use crate::table::layout::{TableLayout, is_anchor};
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::figure::Figure;
use trackfail_engine::spec::table::{Side, Table};
use trackfail_methods::score::Metric;

/// Name of the figure that shows all methods with their intervals.
pub const HEADLINE: &str = "headline";

/// True if a figure shows a metric: along its curves or, for F, by lines of equal F.
fn shows(figure: &Figure, metric: Metric) -> bool {
    let [y, x] = [figure.params.metric, figure.params.x_metric];
    let is_curve = ["sweep", "curve"].contains(&figure.kind.word);
    let has_iso_f = [x, y] == [Some(Metric::RECALL), Some(Metric::PRECISION)] && metric == Metric::F_SCORE;
    is_curve && (y == Some(metric) || has_iso_f)
}

/// True if `methods` contains at least half of the best methods, of which each tracker has one.
fn has_most(methods: &[String], best: &[String]) -> bool {
    2 * best.iter().filter(|method| methods.contains(method)).count() >= best.len()
}

/// Moves the figure that answers the page's question to the head. For methods, that is the curve of the
/// verdict's metric with the best methods, or else the figure of all methods with intervals. For readings, it
/// is the first of their figures. Otherwise the first figure stays.
pub fn figure_first(
    figures: &mut [FigureView],
    experiment: &Experiment,
    (metric, best): (Option<Metric>, &[String]),
    is_about_readings: bool,
) {
    let own = |view: &FigureView| experiment.figures.iter().find(|own| own.name == view.name);
    let place = if is_about_readings {
        Some(figures.iter().filter(|view| own(view).is_some()).count())
    } else if experiment.methods.is_empty() {
        None
    } else {
        let answers = |view: &FigureView| {
            let asked_for = metric.zip(own(view));
            asked_for.is_some_and(|(metric, own)| shows(own, metric) && has_most(&own.params.methods, best))
        };
        let of_all = |view: &FigureView| view.name.starts_with(HEADLINE);
        figures.iter().position(answers).or_else(|| figures.iter().position(of_all))
    };
    if let Some(place) = place.filter(|place| *place < figures.len()) {
        figures[..=place].rotate_right(1);
    }
}

/// Index and table that shows the metric for most of the experiment's methods (without anchors); the first of
/// equal ones.
fn main_table(experiment: &Experiment, metric: Metric) -> Option<(usize, &Table)> {
    let has = |table: &Table| {
        let of_rows = matches!(&table.rows, Side::Metrics(metrics) if metrics.contains(&metric));
        table.shows.is_none() && (of_rows || [table.metric, table.ranked].contains(&Some(metric)))
    };
    let competing = |t: &Table| t.methods.iter().filter(|method| !is_anchor(experiment, method)).count();
    let with = experiment.tables.iter().enumerate().filter(|(_, t)| has(t));
    with.rev().max_by_key(|(_, t)| competing(t))
}

/// Moves the table with the verdict's metric to the head: the experiment's own one, or that of the ranked
/// methods with intervals if the own one lacks most methods of `best` (one per tracker). The experiment's own
/// tables come first on the page.
pub fn table_first(
    page: &mut Page,
    experiment: &Experiment,
    metric: Metric,
    (ranked, best): (Option<TableLayout>, &[String]),
) {
    // Trackers are compared by the tables that the experiment has of them, and one that begins with the table of an analysis
    // is about that.
    let begins_with_analysis = experiment.tables.first().is_some_and(|t| t.shows.is_some());
    if experiment.methods.is_empty() || begins_with_analysis {
        return;
    }
    match (main_table(experiment, metric), ranked) {
        (Some((k, table)), _) if k < page.tables.len() && has_most(&table.methods, best) => {
            page.tables[..=k].rotate_right(1);
        }
        (_, Some(ranked)) if !best.is_empty() => page.tables.insert(0, ranked),
        _ => {}
    }
}

#[cfg(test)]
mod tests;
