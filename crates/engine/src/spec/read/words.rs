//! The names that parts of an experiment can refer to.

use crate::spec::analysis::Analysis;
use crate::spec::method::Method;
use crate::spec::table::{GridAxis, Words};
use crate::spec::{TEST, wire};
use std::collections::{BTreeMap, BTreeSet};
use trackfail_dataset::suite::Catalog;

/// The names that tables, figures and claims may refer to. A method that is wrong has its name and its axes.
pub fn words(
    catalog: &Catalog,
    wire: &wire::Experiment,
    suites: &BTreeMap<String, String>,
    labels: &[String],
    methods: &[Method],
    analyses: &[Analysis],
) -> Words {
    let is_wrong = |m: &&wire::Method| methods.iter().all(|right| right.name != *m.name.get_ref());
    let wrong: Vec<&wire::Method> = wire.method.get_ref().iter().filter(is_wrong).collect();
    let points = methods.iter().flat_map(|m| &m.variants).flat_map(|v| v.point.iter().map(|(axis, _)| axis));
    let axes: BTreeSet<&String> =
        points.chain(wrong.iter().flat_map(|m| &m.grid).flat_map(|g| g.keys())).collect();
    let names = |keep: fn(&Method) -> bool| -> Vec<String> {
        let right = |m: &&wire::Method| methods.iter().find(|r| r.name == *m.name.get_ref()).is_none_or(keep);
        wire.method.get_ref().iter().filter(right).map(|m| m.name.get_ref().clone()).collect()
    };
    let sequences = suites.get(TEST).and_then(|name| catalog.suite(name).ok());
    Words {
        methods: names(|_| true),
        trackers: labels.to_vec(),
        axes: axes.into_iter().cloned().collect(),
        grids: methods
            .iter()
            .flat_map(grid_axes)
            .chain(wrong.iter().copied().flat_map(written_axes))
            .collect(),
        sequences: sequences.map_or_else(Vec::new, |suite| suite.sequence_names()),
        drawn: names(|m| !m.has_grid()),
        with_signal: names(|m| m.variants.iter().any(|v| v.signal.is_some())),
        analyses: analyses.iter().map(|a| (a.name.clone(), a.names())).collect(),
    }
}

/// The axes of a method's grid.
fn grid_axes(method: &Method) -> Vec<GridAxis> {
    let mut axes: Vec<GridAxis> = Vec::new();
    for (axis, value) in method.variants.iter().flat_map(|v| &v.point) {
        match axes.iter_mut().find(|known| known.axis == *axis) {
            Some(known) if known.values.contains(value) => {}
            Some(known) => known.values.push(*value),
            None => {
                axes.push(GridAxis { method: method.name.clone(), axis: axis.clone(), values: vec![*value] })
            }
        }
    }
    axes
}

/// The axes that the grid of a wrong method has by its text, so that what speaks of them is not called wrong too.
fn written_axes(method: &wire::Method) -> Vec<GridAxis> {
    let axis = |(axis, values): (&String, &toml::Value)| {
        let number = |value: &toml::Value| value.as_float().or(value.as_integer().map(|v| v as f64));
        let values = values.as_array().into_iter().flatten().filter_map(number).collect();
        GridAxis { method: method.name.get_ref().clone(), axis: axis.clone(), values }
    };
    method.grid.iter().flatten().map(axis).collect()
}
