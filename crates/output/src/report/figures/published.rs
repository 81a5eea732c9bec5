//! Published values for the axes of a figure, from the `[[published]]` of its experiment.

use crate::results::Measure;
use crate::table::number::printed_value;
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::table::{Published, Side};
use trackfail_methods::score::Metric;

/// Published value of a method in a row.
fn value(published: &Published, method: &str) -> Option<f64> {
    published.values.iter().find(|(column, _)| column == method).and_then(|(_, text)| printed_value(text))
}

/// Published value of a metric, for a method on a tracker.
pub fn of_metric(experiment: &Experiment, tracker: &str, method: &str, metric: Metric) -> Option<f64> {
    let mine = experiment.published.iter().filter(|p| p.tracker == tracker);
    mine.filter(|p| p.row == metric.name()).find_map(|p| value(p, method))
}

/// Published values of two metrics, for a method on a tracker.
pub fn point(experiment: &Experiment, measure: &Measure, x: Metric, y: Metric) -> Option<(f64, f64)> {
    let of = |metric| of_metric(experiment, &measure.tracker, &measure.method, metric);
    Some((of(x)?, of(y)?))
}

/// Published values of a metric along a grid axis, for a method on a tracker.
pub fn along(experiment: &Experiment, measure: &Measure, metric: Metric, axis: &str) -> Vec<(f64, f64)> {
    let is_along = |p: &&Published| {
        let table = experiment.tables.iter().find(|t| t.name == p.table);
        table.is_some_and(|t| t.metric == Some(metric) && t.rows == Side::Axis(axis.to_string()))
    };
    let mine = experiment.published.iter().filter(|p| p.tracker == measure.tracker).filter(is_along);
    let at = |p: &Published| Some((printed_value(&p.row)?, value(p, &measure.method)?));
    let mut points: Vec<(f64, f64)> = mine.filter_map(at).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{self, items, measure};

    fn experiment() -> Experiment {
        let tables = [
            "name = 'f'; rows = ['horizon']; columns = 'method'; metric = 'f_score'",
            "name = 'both'; rows = ['precision', 'recall']; columns = 'method'",
        ];
        let published = [
            "table = 'f'; tracker = 'PF'; row = '20'; values = { DTEF = '.40' }",
            "table = 'f'; tracker = 'PF'; row = '5'; values = { DTEF = '.38±.02' }",
            "table = 'both'; tracker = 'PF'; row = 'precision'; values = { DTEF = '.3' }",
            "table = 'both'; tracker = 'PF'; row = 'recall'; values = { DTEF = '.6' }",
        ];
        let below = items("table", &tables) + &items("published", &published);
        testing::experiment("", &[("DTEF", "grid = { horizon = [5, 20] }")], &below)
    }

    #[test]
    fn printed_values_are_found_along_an_axis_and_as_points() {
        let experiment = experiment();
        let measure = |tracker| measure(tracker, "DTEF", "horizon=5");
        let along = |metric, axis| along(&experiment, &measure("PF"), metric, axis);
        assert_eq!(along(Metric::F_SCORE, "horizon"), [(5.0, 0.38), (20.0, 0.4)]);
        assert!(along(Metric::PRECISION, "horizon").is_empty() && along(Metric::F_SCORE, "alpha").is_empty());
        let point = |tracker| point(&experiment, &measure(tracker), Metric::RECALL, Metric::PRECISION);
        assert_eq!((point("PF"), point("NCC")), (Some((0.6, 0.3)), None));
    }
}
