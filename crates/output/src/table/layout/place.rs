//! Where the numbers of a table come from: tracker, method, grid point and metric of every cell.

use crate::results::Measure;
use crate::results::method_label;
use trackfail_core::num::readable;
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::table::{Side, Table};
use trackfail_methods::score::Metric;

/// Names a cell of a table and the number that it shows.
#[derive(Debug, Clone, PartialEq)]
pub struct CellRef {
    /// Label of its row.
    pub row: String,
    /// Label of its column.
    pub column: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Method.
    pub method: String,
    /// Grid point as in `scores.csv`, empty without a grid.
    pub params: String,
    /// The attribute of the sequences that it is about; all sequences when `None`.
    pub attribute: Option<String>,
    /// The metric that it shows.
    pub metric: Metric,
}

/// Lists the cells of a table that show a pooled number, group by group and row by row; none for the table of an
/// analysis.
pub fn cell_refs(experiment: &Experiment, table: &Table, measures: &[Measure]) -> Vec<CellRef> {
    if let Some(metric) = table.ranked {
        let shown = measures.iter().filter(|m| m.attribute.is_none() && table.methods.contains(&m.method));
        return shown.map(|m| ranked(m, metric)).collect();
    }
    let (rows, columns) =
        (steps(&table.rows, table, experiment, measures), steps(&table.columns, table, experiment, measures));
    let mut refs = Vec::new();
    for (_, group) in group_places(experiment, table, measures) {
        for (row, of_row) in &rows {
            for (column, of_column) in &columns {
                let at = merge(&[&group, of_row, of_column]);
                let (Some(tracker), Some(method)) = (&at.tracker, &at.method) else { continue };
                let attribute = at.attribute.as_deref();
                let Some(measure) = find(measures, tracker, method, &at.axes, attribute) else { continue };
                refs.push(CellRef {
                    row: row.clone(),
                    column: column.clone(),
                    tracker: tracker.clone(),
                    method: method.clone(),
                    params: measure.params.clone(),
                    attribute: at.attribute.clone(),
                    metric: at.metric.or(table.metric).unwrap_or(Metric::F_SCORE),
                });
            }
        }
    }
    refs
}

/// The cell of a method's row in a leaderboard that shows a pooled number.
fn ranked(measure: &Measure, metric: Metric) -> CellRef {
    CellRef {
        row: method_label(&measure.method, &measure.params),
        column: metric.name().to_string(),
        tracker: measure.tracker.clone(),
        method: measure.method.clone(),
        params: measure.params.clone(),
        attribute: None,
        metric,
    }
}

/// Label of the step along the attributes that takes all sequences.
const ALL: &str = "all";

/// Selection that a step, row, column or group fixes; everything else varies.
#[derive(Clone, Default)]
pub(super) struct Place {
    pub(super) tracker: Option<String>,
    pub(super) method: Option<String>,
    pub(super) metric: Option<Metric>,
    pub(super) attribute: Option<String>,
    pub(super) axes: Vec<(String, f64)>,
}

/// The steps along one side of a table: their labels, and what each fixes.
pub(super) fn steps(
    side: &Side,
    table: &Table,
    experiment: &Experiment,
    measures: &[Measure],
) -> Vec<(String, Place)> {
    match side {
        Side::Metrics(metrics) => metrics
            .iter()
            .map(|m| (m.name().to_string(), Place { metric: Some(*m), ..Place::default() }))
            .collect(),
        Side::Method => table
            .methods
            .iter()
            .map(|m| (m.clone(), Place { method: Some(m.clone()), ..Place::default() }))
            .collect(),
        Side::Tracker => experiment
            .trackers
            .iter()
            .filter(|t| {
                experiment.methods.iter().any(|m| table.methods.contains(&m.name) && m.runs_on(&t.label))
            })
            .map(|t| (t.label.clone(), Place { tracker: Some(t.label.clone()), ..Place::default() }))
            .collect(),
        Side::Attribute => {
            let mut known: Vec<&str> = measures.iter().filter_map(|m| m.attribute.as_deref()).collect();
            known.sort_unstable();
            known.dedup();
            let of = |a: &str| (a.to_string(), Place { attribute: Some(a.to_string()), ..Place::default() });
            std::iter::once((ALL.to_string(), Place::default())).chain(known.into_iter().map(of)).collect()
        }
        Side::Axis(axis) => axis_values(axis, measures)
            .into_iter()
            .map(|v| (readable(v), Place { axes: vec![(axis.clone(), v)], ..Place::default() }))
            .collect(),
    }
}

fn axis_values(axis: &str, measures: &[Measure]) -> Vec<f64> {
    let mut values: Vec<f64> =
        measures.iter().flat_map(Measure::point).filter(|(a, _)| a == axis).map(|(_, v)| v).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

pub(super) fn merge(places: &[&Place]) -> Place {
    places.iter().fold(Place::default(), |mut all, p| {
        all.tracker = p.tracker.clone().or(all.tracker);
        all.method = p.method.clone().or(all.method);
        all.metric = p.metric.or(all.metric);
        all.attribute = p.attribute.clone().or(all.attribute);
        all.axes.extend(p.axes.iter().cloned());
        all
    })
}

/// Finds pooled numbers; axes that the method's grid does not have are ignored.
pub(super) fn find<'a>(
    measures: &'a [Measure],
    tracker: &str,
    method: &str,
    axes: &[(String, f64)],
    attribute: Option<&str>,
) -> Option<&'a Measure> {
    measures.iter().find(|m| {
        m.tracker == tracker
            && m.attribute.as_deref() == attribute
            && m.method == method
            && m.point().iter().all(|(axis, v)| axes.iter().any(|(a, w)| a == axis && w == v))
    })
}

/// The groups of a table: every combination of what varies and is on neither side, with a label.
pub(super) fn group_places(
    experiment: &Experiment,
    table: &Table,
    measures: &[Measure],
) -> Vec<(String, Place)> {
    let on_side = |side: &Side| table.rows == *side || table.columns == *side;
    let mut sides: Vec<Vec<(String, Place)>> = Vec::new();
    if !on_side(&Side::Tracker) {
        sides.push(steps(&Side::Tracker, table, experiment, measures));
    }
    if !on_side(&Side::Method) {
        sides.push(steps(&Side::Method, table, experiment, measures));
    }
    let shown = measures.iter().filter(|m| table.methods.contains(&m.method));
    let mut axes: Vec<String> = shown.flat_map(Measure::point).map(|(a, _)| a).collect();
    axes.sort();
    axes.dedup();
    for axis in axes {
        let side = Side::Axis(axis.clone());
        if !on_side(&side) {
            let mut list = steps(&side, table, experiment, measures);
            for step in &mut list {
                step.0 = format!("{axis} = {}", step.0);
            }
            sides.push(list);
        }
    }
    let mut places = vec![(String::new(), Place::default())];
    for side in sides {
        let single = side.len() == 1;
        places = places
            .iter()
            .flat_map(|(label, place)| {
                side.iter().map(move |(step, fixed)| {
                    let label = match (single, label.is_empty()) {
                        (true, _) => label.clone(),
                        (false, true) => step.clone(),
                        (false, false) => format!("{label}, {step}"),
                    };
                    (label, merge(&[place, fixed]))
                })
            })
            .collect();
    }
    places
}
