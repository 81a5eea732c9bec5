//! Names that parts of an experiment can refer to.

use super::analysis::Analysis;
use super::method::Method;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};
use trackfail_core::plugin::unknown;
use trackfail_methods::analysis::Names;
use trackfail_methods::score::Protocol;
use trackfail_methods::tracker::process::Programs;

/// Names defined by an experiment, for checking references. Names of wrong parts are included, so that
/// references to them are not reported as well.
#[derive(Default)]
pub struct Words {
    /// Names of the methods.
    pub methods: Vec<String>,
    /// Tracker labels.
    pub trackers: Vec<String>,
    /// Grid axes of all methods.
    pub axes: Vec<String>,
    /// Values of each axis, by method.
    pub grids: Vec<GridAxis>,
    /// Names of the sequences of the test suite; empty if unknown.
    pub sequences: Vec<String>,
    /// Methods without a grid, whose values per frame are kept for figures.
    pub drawn: Vec<String>,
    /// Methods that read a signal.
    pub with_signal: Vec<String>,
    /// Analyses with the names that they compute; `None` for analyses with errors.
    pub analyses: Vec<(String, Option<Names>)>,
    /// Names of the tables.
    pub tables: Vec<String>,
    /// True if the file names a protocol, be it known or not.
    pub has_protocol: bool,
}

/// Programs, suites, names and the protocol that trackers, methods and analyses of an experiment may refer to.
pub(super) struct Known<'a> {
    pub programs: Option<&'a Programs>,
    /// Suite names by role; empty if `[suites]` has errors.
    pub suites: &'a BTreeMap<String, String>,
    pub words: &'a Words,
    /// Protocol of methods that name none.
    pub protocol: Option<&'static Protocol>,
}

/// Values of an axis in the grid of a method.
#[derive(Debug, Clone, PartialEq)]
pub struct GridAxis {
    /// Name of the method with the grid.
    pub method: String,
    /// Name of the axis, a parameter of the method.
    pub axis: String,
    /// Values without repetitions, in any order.
    pub values: Vec<f64>,
}

/// A product of an analysis: a table, chart or number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FindingName {
    /// Name of the analysis in the experiment.
    pub analysis: String,
    /// Name of the table, chart or number.
    pub part: String,
}

impl std::fmt::Display for FindingName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.analysis, self.part)
    }
}

impl Words {
    /// Collects the names in a file, before their items are checked.
    pub(super) fn of(document: &DeTable<'_>) -> Self {
        let names = |kind: &str| -> Vec<String> {
            items(document, kind).filter_map(|item| text(item, "name")).collect()
        };
        let label = |item: &DeTable<'_>| text(item, "label").or_else(|| text(item, "name"));
        let methods = names("method");
        let grids: Vec<GridAxis> = items(document, "method").flat_map(grid_axes).collect();
        let axes: BTreeSet<&String> = grids.iter().map(|grid| &grid.axis).collect();
        Self {
            trackers: items(document, "tracker").filter_map(label).collect(),
            axes: axes.into_iter().cloned().collect(),
            grids,
            drawn: methods.clone(),
            with_signal: methods.clone(),
            methods,
            analyses: names("analysis").into_iter().map(|name| (name, None)).collect(),
            tables: names("table"),
            has_protocol: document.contains_key("protocol"),
            sequences: Vec::new(),
        }
    }

    /// Adds facts about the methods and analyses that are valid.
    pub(super) fn learn(&mut self, methods: &[Method], analyses: &[Analysis]) {
        let is_or_wrong = |name: &String, of: fn(&Method) -> bool| {
            methods.iter().find(|method| method.name == *name).is_none_or(of)
        };
        self.drawn.retain(|name| is_or_wrong(name, |method| !method.has_grid()));
        self.with_signal
            .retain(|name| is_or_wrong(name, |method| method.variants.iter().any(|v| !v.signals.is_empty())));
        for (name, names) in &mut self.analyses {
            *names = analyses.iter().find(|analysis| analysis.name == *name).map(Analysis::names);
        }
    }

    /// Parses `ANALYSIS.PART`; `parts` selects tables, charts or numbers.
    ///
    /// # Errors
    /// A message about an unknown name, with the known ones.
    pub fn finding(&self, text: &str, parts: fn(&Names) -> &[String]) -> Result<FindingName, String> {
        let (analysis, part) = text.split_once('.').unwrap_or((text, ""));
        let known = || {
            let right = self.analyses.iter().filter_map(|(name, names)| Some((name, names.as_ref()?)));
            right.flat_map(|(name, names)| parts(names).iter().map(move |part| format!("{name}.{part}")))
        };
        let is_wrong = self.analyses.iter().any(|(name, names)| name == analysis && names.is_none());
        if !is_wrong && !known().any(|known| known == text) {
            let known: Vec<String> = known().collect();
            return Err(unknown("finding", text, known.iter().map(String::as_str)));
        }
        Ok(FindingName { analysis: analysis.to_string(), part: part.to_string() })
    }
}

/// Tables in a list of tables.
fn items<'t, 'i>(document: &'t DeTable<'i>, kind: &str) -> impl Iterator<Item = &'t DeTable<'i>> {
    let list = document.get(kind).and_then(|list| list.get_ref().as_array());
    list.into_iter().flat_map(|list| list.iter()).filter_map(|item| item.get_ref().as_table())
}

fn text(item: &DeTable<'_>, key: &str) -> Option<String> {
    item.get(key)?.get_ref().as_str().map(str::to_string)
}

/// Axes in the grid of a method.
fn grid_axes(method: &DeTable<'_>) -> Vec<GridAxis> {
    let name = text(method, "name").unwrap_or_default();
    let grid = method.get("grid").and_then(|grid| grid.get_ref().as_table());
    let number = |value: &Spanned<DeValue<'_>>| f64::deserialize(ValueDeserializer::from(value.clone())).ok();
    let mut axes = Vec::new();
    for (axis, values) in grid.into_iter().flatten() {
        let values = values.get_ref().as_array().into_iter().flat_map(|list| list.iter());
        let values = values.filter_map(number).collect();
        axes.push(GridAxis { method: name.clone(), axis: axis.get_ref().to_string(), values });
    }
    axes
}
