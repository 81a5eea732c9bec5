//! Values that the rows, columns and groups of a table fix: tracker, method, grid point, metric, attribute.

use crate::results::Measure;
use std::collections::BTreeSet;
use trackfail_core::num::readable;
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::table::{Side, Table};
use trackfail_methods::score::Metric;

/// Row label for all sequences, whatever their attributes.
const ALL: &str = "all";

/// Values that a row, column or group fixes. Fields that are `None` vary.
#[derive(Clone, Default)]
pub(super) struct Place<'a> {
    pub(super) tracker: Option<&'a str>,
    pub(super) method: Option<&'a str>,
    pub(super) metric: Option<Metric>,
    pub(super) attribute: Option<&'a str>,
    pub(super) axes: Vec<(String, f64)>,
}

/// A row, column or group: its label, and the values that it fixes.
pub(super) type Step<'a> = (String, Place<'a>);

impl Place<'_> {
    /// Values that this place and the other one fix together.
    pub(super) fn and(&self, other: &Self) -> Self {
        Self {
            tracker: other.tracker.or(self.tracker),
            method: other.method.or(self.method),
            metric: other.metric.or(self.metric),
            attribute: other.attribute.or(self.attribute),
            axes: [self.axes.as_slice(), &other.axes].concat(),
        }
    }
}

/// Steps along one side of a table.
pub(super) fn steps<'a>(
    side: &Side,
    experiment: &'a Experiment,
    table: &'a Table,
    measures: &'a [Measure],
) -> Vec<Step<'a>> {
    let all = Place::default;
    match side {
        Side::Metrics(metrics) => {
            metrics.iter().map(|m| (m.name().to_string(), Place { metric: Some(*m), ..all() })).collect()
        }
        Side::Method => {
            table.methods.iter().map(|m| (m.clone(), Place { method: Some(m), ..all() })).collect()
        }
        Side::Tracker => {
            let shown = || experiment.methods.iter().filter(|m| table.methods.contains(&m.name));
            let trackers = experiment.trackers.iter().filter(|t| shown().any(|m| m.runs_on(&t.label)));
            trackers.map(|t| (t.label.clone(), Place { tracker: Some(&t.label), ..all() })).collect()
        }
        Side::Attribute => {
            let known: BTreeSet<&str> = measures.iter().filter_map(|m| m.attribute.as_deref()).collect();
            let of = |a: &'a str| (a.to_string(), Place { attribute: Some(a), ..all() });
            std::iter::once((ALL.to_string(), all())).chain(known.into_iter().map(of)).collect()
        }
        Side::Axis(axis) => {
            let points = measures.iter().flat_map(Measure::point).filter(|(known, _)| known == axis);
            let mut values: Vec<f64> = points.map(|(_, value)| value).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            let of = |v: f64| (readable(v), Place { axes: vec![(axis.clone(), v)], ..all() });
            values.into_iter().map(of).collect()
        }
    }
}

/// Pooled numbers of a place. Axes that the method's grid lacks are ignored.
pub(super) fn find<'m>(measures: &'m [Measure], at: &Place<'_>) -> Option<&'m Measure> {
    measures.iter().find(|m| {
        at.tracker == Some(m.tracker.as_str())
            && at.attribute == m.attribute.as_deref()
            && at.method == Some(m.method.as_str())
            && m.point().iter().all(|point| at.axes.contains(point))
    })
}

/// Groups of a table: all combinations of the values that vary and are on neither side.
pub(super) fn groups<'a>(
    experiment: &'a Experiment,
    table: &'a Table,
    measures: &'a [Measure],
) -> Vec<Step<'a>> {
    let shown = measures.iter().filter(|m| table.methods.contains(&m.method));
    let axes: BTreeSet<String> = shown.flat_map(Measure::point).map(|(axis, _)| axis).collect();
    let sides = [Side::Tracker, Side::Method].into_iter().chain(axes.into_iter().map(Side::Axis));
    let mut groups: Vec<Step<'a>> = vec![(String::new(), Place::default())];
    for side in sides.filter(|side| table.rows != *side && table.columns != *side) {
        let mut steps = steps(&side, experiment, table, measures);
        if let Side::Axis(axis) = &side {
            steps.iter_mut().for_each(|(label, _)| *label = format!("{axis} = {label}"));
        }
        let single = steps.len() == 1;
        let with = |(label, place): &Step<'a>| -> Vec<Step<'a>> {
            let joined = |step: &str| match (single, label.is_empty()) {
                (true, _) => label.clone(),
                (false, true) => step.to_string(),
                (false, false) => format!("{label}, {step}"),
            };
            steps.iter().map(|(step, fixed)| (joined(step), place.and(fixed))).collect()
        };
        groups = groups.iter().flat_map(with).collect();
    }
    groups
}
