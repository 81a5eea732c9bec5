//! What papers print of a figure's axes, from the `[[published]]` of its experiment.

use crate::results::Measure;
use crate::score::Metric;
use crate::spec::Experiment;
use crate::spec::table::{Published, Side};

fn number(text: &str) -> Option<f64> {
    text.split('±').next()?.trim().parse().ok()
}

/// The printed value of a method in a row.
fn value(published: &Published, method: &str) -> Option<f64> {
    published.values.iter().find(|(column, _)| column == method).and_then(|(_, text)| number(text))
}

/// The value of a metric that is printed for a method on a tracker.
fn of_metric(experiment: &Experiment, measure: &Measure, metric: Metric) -> Option<f64> {
    let mine = experiment.published.iter().filter(|p| p.tracker == measure.tracker);
    mine.filter(|p| p.row == metric.name()).find_map(|p| value(p, &measure.method))
}

/// The point of two metrics that is printed for a method on a tracker.
pub fn point(experiment: &Experiment, measure: &Measure, x: Metric, y: Metric) -> Option<(f64, f64)> {
    Some((of_metric(experiment, measure, x)?, of_metric(experiment, measure, y)?))
}

/// The values of a metric that are printed for a method on a tracker along an axis of its grid.
pub fn along(experiment: &Experiment, measure: &Measure, metric: Metric, axis: &str) -> Vec<(f64, f64)> {
    let is_along = |p: &&Published| {
        let table = experiment.tables.iter().find(|t| t.name == p.table);
        table.is_some_and(|t| t.metric == Some(metric) && t.rows == Side::Axis(axis.to_string()))
    };
    let mine = experiment.published.iter().filter(|p| p.tracker == measure.tracker).filter(is_along);
    let at = |p: &Published| Some((number(&p.row)?, value(p, &measure.method)?));
    let mut points: Vec<(f64, f64)> = mine.filter_map(at).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}
