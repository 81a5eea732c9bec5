//! Arranges pooled numbers as an experiment's tables require: ours, published, difference.
//!
//! Trackers, methods and grid axes that are on neither side of a table make groups of rows. Each cell stores
//! the [`Origin`] of its pooled number. Published numbers of a tracker that was run stand beside ours for
//! that tracker. If the paper has a single tracker, its numbers stand beside those of all trackers, with its
//! name. Numbers of further trackers make separate groups, without ours.

mod analysed;
mod place;
mod printed;

pub use analysed::analysed;

use super::build;
use super::number::{Style, printed_value};
use crate::results::{Measure, method_label};
use place::{Place, Step, find, groups, steps};
use printed::Printed;
use serde::Serialize;
use trackfail_core::direction::Direction;
use trackfail_core::num::readable;
use trackfail_engine::spec::table::{Latex, Side, Table};
use trackfail_engine::spec::{Experiment, TEST};
use trackfail_methods::score::metric::Kind;
use trackfail_methods::score::{Counts, Metric};

/// A table whose texts are ready for any format.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableLayout {
    /// File name without extension.
    pub name: String,
    /// Text above the table, including the data behind it.
    pub caption: String,
    /// Data behind the table, alone: `12 of 21 targets`.
    pub data: String,
    /// Heading of the first column.
    pub corner: String,
    /// Column headings.
    pub columns: Vec<Label>,
    /// Parts of the table that LaTeX shows.
    pub latex: Latex,
    /// Groups in their order.
    pub groups: Vec<Group>,
}

/// Rows that share a tracker and grid point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Group {
    /// Heading; empty for the only group of a table.
    pub label: String,
    /// Name in the heading, without counts, so that it stays the same when results change.
    pub key: String,
    /// Tracker whose published numbers stand beside ours.
    pub published_tracker: Option<String>,
    /// True if the group has numbers of ours.
    pub has_ours: bool,
    /// Rows in their order.
    pub rows: Vec<Row>,
}

/// One row of a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Heading of the row.
    pub label: Label,
    /// Direction in which values of the row's metric are better.
    pub direction: Direction,
    /// Cells, one for each column.
    pub cells: Vec<Cell>,
}

/// Heading of a row or a column.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Label {
    /// Name in files for programs, macros and commands: `f_score`, `5`.
    pub name: String,
    /// Text for people: `F1 score ↑`, `length = 5`.
    pub shown: String,
    /// Kind of the row or column.
    pub kind: LabelKind,
}

/// Kind of a row or column. Pages and LaTeX tables show results first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LabelKind {
    /// Results.
    Result,
    /// Counts behind the results.
    Count,
    /// Numbers of an anchor.
    Anchor,
}

/// One cell of a table.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Cell {
    /// Pooled number that the cell shows; `None` for analyses, or if nothing was run.
    #[serde(skip)]
    pub of: Option<Origin>,
    /// Explanation of the number on a page.
    pub link: Option<Link>,
    /// Our number, unrounded.
    pub value: Option<f64>,
    /// Our number, as the paper would print it.
    pub ours: Option<String>,
    /// Published text.
    pub published: Option<String>,
    /// Our number minus the published one, both as printed.
    pub difference: Option<String>,
    /// True if our number is the best of the row, as printed, or of the column if rows are trackers. Anchors
    /// do not compete, nor do numbers that lack more cells than others.
    pub best: bool,
    /// True if other cells are equal to this best one.
    pub tied: bool,
    /// True if our number is the second best, and exactly one cell is the best.
    pub second: bool,
    /// Number of cells without a result behind the number.
    pub failed: usize,
}

/// A pooled number, with the names of its row and column in a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Origin {
    /// Name of the row.
    pub row: String,
    /// Name of the column.
    pub column: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Name of the method.
    pub method: String,
    /// Grid point as in `scores.csv`; empty without a grid.
    pub params: String,
    /// Attribute that restricts the sequences; `None` for all sequences.
    pub attribute: Option<String>,
    /// Metric that the cell shows.
    pub metric: Metric,
    /// Counts over the sequences and runs.
    pub counts: Counts,
}

/// Explanation of a number on a page, with links to the page's table of sequences.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Link {
    /// The number in words: `f_score of DTEF on NCC is 0.242`.
    pub number: String,
    /// Formula with the counts filled in.
    pub formula: String,
    /// Command that explains the number.
    pub command: String,
    /// Index of the tracker among those shown by sequence.
    pub tracker: Option<usize>,
    /// Index of the method (with its grid point) among those shown by sequence.
    pub method: Option<usize>,
    /// Index of the attribute that restricts the sequences; `None` for all sequences.
    pub attribute: Option<usize>,
}

impl TableLayout {
    /// Cells in their order, each with its group, row and column.
    pub fn cells(&self) -> impl Iterator<Item = (&Group, &Row, &Label, &Cell)> {
        let rows = self.groups.iter().flat_map(|group| group.rows.iter().map(move |row| (group, row)));
        rows.flat_map(move |(group, row)| {
            row.cells.iter().zip(&self.columns).map(move |(cell, column)| (group, row, column, cell))
        })
    }
}

impl Label {
    /// Heading of a metric, with an arrow for its direction.
    pub fn of_metric(metric: Metric) -> Self {
        let shown = format!("{}{}", metric.title(), arrow(metric.direction()));
        let kind = if metric.is_count() { LabelKind::Count } else { LabelKind::Result };
        Self { name: metric.name().to_string(), shown, kind }
    }
}

impl<T: Into<String>> From<T> for Label {
    fn from(name: T) -> Self {
        let name = name.into();
        Self { shown: name.clone(), name, kind: LabelKind::Result }
    }
}

impl Origin {
    /// Origin of a measure's metric in a cell.
    pub fn new(row: &str, column: &str, measure: &Measure, metric: Metric) -> Self {
        Self {
            row: row.to_string(),
            column: column.to_string(),
            tracker: measure.tracker.clone(),
            method: measure.method.clone(),
            params: measure.params.clone(),
            attribute: measure.attribute.clone(),
            metric,
            counts: measure.pooled.counts,
        }
    }

    /// Origin of the number by which a leaderboard ranks a method.
    pub fn ranked(measure: &Measure, metric: Metric) -> Self {
        Self::new(&method_label(&measure.method, &measure.params), metric.name(), measure, metric)
    }

    /// Name of the method with its grid point.
    pub fn label(&self) -> String {
        method_label(&self.method, &self.params)
    }
}

/// Arrow after the heading of a metric.
fn arrow(direction: Direction) -> &'static str {
    match direction {
        Direction::HigherIsBetter => " ↑",
        Direction::LowerIsBetter => " ↓",
        Direction::Neither => "",
    }
}

/// Pooled numbers that a table shows, by group and row; empty for the table of an analysis.
pub fn origins(experiment: &Experiment, table: &Table, measures: &[Measure]) -> Vec<Origin> {
    match table.ranked {
        Some(metric) => {
            let is_shown = |m: &&Measure| m.attribute.is_none() && table.methods.contains(&m.method);
            measures.iter().filter(is_shown).map(|m| Origin::ranked(m, metric)).collect()
        }
        None => {
            let layout = layout(experiment, table, measures, "");
            layout.cells().filter_map(|(.., cell)| cell.of.clone()).collect()
        }
    }
}

/// Pooled numbers of a tracker and method at a grid point, for claims; `None` if there are none.
pub fn measure_of<'m>(
    measures: &'m [Measure],
    tracker: &str,
    method: &str,
    axes: &[(String, f64)],
) -> Option<&'m Measure> {
    let (tracker, method) = (Some(tracker), Some(method));
    find(measures, &Place { tracker, method, axes: axes.to_vec(), ..Place::default() })
}

/// True if a method is an anchor, that is, its detector reads no signal.
pub fn is_anchor(experiment: &Experiment, method: &str) -> bool {
    let mut variants = experiment.methods.iter().filter(|m| m.name == method).flat_map(|m| &m.variants);
    variants.all(|v| !v.detector.example.detector.facts().needs_signal)
}

/// Makes a table of pooled numbers; `data_note` names the data behind them.
pub fn layout(experiment: &Experiment, table: &Table, measures: &[Measure], data_note: &str) -> TableLayout {
    let rows = steps(&table.rows, experiment, table, measures);
    let columns = steps(&table.columns, experiment, table, measures);
    let printed = Printed::of(experiment, table);
    // Parts of a suite do not compete with each other.
    let compete = columns.iter().all(|(_, at)| at.attribute.is_none());
    let row = |group: &Place<'_>, source: Option<&str>, ours: &[Measure], (name, at_row): &Step<'_>| {
        let metric = at_row.metric.or(table.metric).unwrap_or(Metric::F_SCORE);
        let style = printed.style(name).unwrap_or_else(|| Style::of_metric(metric));
        let cell = |(column, at_column): &Step<'_>| {
            let measure = find(ours, &group.and(at_row).and(at_column));
            let value = measure.and_then(|m| m.value(metric));
            let mut cell = printed.cell(value, Some(style), printed.text(source, name, column));
            if let Some(m) = measure {
                cell.failed = m.failed;
                cell.of = Some(Origin::new(name, column, m, metric));
                if let (Kind::MeanAndDeviation, Some((_, deviation))) = (metric.kind, m.pooled.score) {
                    let deviation = printed.shown(deviation, Some(style));
                    cell.ours = cell.ours.map(|mean| format!("{mean}±{deviation}"));
                }
            }
            cell
        };
        let mut cells: Vec<Cell> = columns.iter().map(cell).collect();
        if compete {
            // Nor does a number with those of more sequences.
            let fewest = cells.iter().filter(|c| c.value.is_some()).map(|c| c.failed).min().unwrap_or(0);
            mark_best(cells.iter_mut(), metric.direction(), |k, cell| {
                let method = columns[k].1.method;
                cell.failed <= fewest && method.is_none_or(|m| !is_anchor(experiment, m))
            });
        }
        Row { label: heading(experiment, name, at_row, false), direction: metric.direction(), cells }
    };
    let group =
        |key: String, label: String, at: &Place<'_>, source: Option<&str>, ours: Option<&[Measure]>| {
            let rows = rows.iter().map(|step| row(at, source, ours.unwrap_or_default(), step));
            let published_tracker = source.map(|label| printed.name(label));
            Group { key, label, published_tracker, has_ours: ours.is_some(), rows: rows.collect() }
        };
    let mut of_table = Vec::new();
    let mut shown: Vec<&str> = Vec::new();
    for (label, at) in groups(experiment, table, measures) {
        let source = printed.beside(at.tracker);
        shown.extend(source);
        let key = if label.is_empty() { at.tracker.unwrap_or_default().to_string() } else { label.clone() };
        let events = at.tracker.and_then(|tracker| events(experiment, table, measures, tracker));
        let heading = events.map_or(label, |events| format!("{key} ({events})"));
        of_table.push(group(key, heading, &at, source, Some(measures)));
    }
    for tracker in printed.trackers() {
        if !shown.contains(&tracker) {
            shown.push(tracker);
            let heading = format!("{tracker} (published; not run here)");
            let at = Place { tracker: Some(tracker), ..Place::default() };
            of_table.push(group(tracker.to_string(), heading, &at, Some(tracker), None));
        }
    }
    let caption = table.caption.as_ref().unwrap_or(&experiment.title).clone();
    let mut caption = format!("{} Suite {}: {data_note}.", sentence(caption), experiment.suites[TEST]);
    if let Some(left_out) = left_out(table, measures) {
        caption.push_str(&format!(" † {left_out}"));
    }
    let rows_are = match &table.rows {
        Side::Axis(axis) => axis.as_str(),
        Side::Attribute => "attribute",
        Side::Method => "method",
        Side::Tracker => "tracker",
        Side::Metrics(_) => "metric",
    };
    let corner = match table.metric.filter(|_| !matches!(table.rows, Side::Metrics(_))) {
        Some(metric) => format!("{} by {rows_are}", Label::of_metric(metric).shown),
        None => rows_are.to_string(),
    };
    let columns = columns.iter().map(|(name, at)| heading(experiment, name, at, true));
    TableLayout {
        data: data_note.to_string(),
        latex: table.latex.clone(),
        ..build::table(&table.name, caption, &corner, columns, of_table)
    }
}

/// Adds a full stop to a text.
pub(super) fn sentence(mut text: String) -> String {
    if !text.ends_with('.') {
        text.push('.');
    }
    text
}

/// Heading of a row or a column. A grid value is shown with its axis, unless the corner of the table names
/// that.
fn heading(experiment: &Experiment, name: &str, at: &Place<'_>, is_column: bool) -> Label {
    if let Some(metric) = at.metric {
        return Label::of_metric(metric);
    }
    let is_anchor = at.method.is_some_and(|m| is_anchor(experiment, m));
    let kind = if is_anchor { LabelKind::Anchor } else { LabelKind::Result };
    let shown = match at.axes.as_slice() {
        [(axis, value)] if is_column => format!("{axis} = {}", readable(value)),
        _ => name.to_string(),
    };
    Label { name: name.to_string(), shown, kind }
}

/// Text like `12 losses`: the events of a tracker for the table's methods. All methods have the same events
/// unless their protocols differ.
fn events(experiment: &Experiment, table: &Table, measures: &[Measure], tracker: &str) -> Option<String> {
    let is_it = |m: &&Measure| m.tracker == tracker && table.methods.contains(&m.method);
    let m = measures.iter().filter(is_it).find(|m| m.attribute.is_none() && m.done > 0)?;
    let n = m.pooled.counts.tp + m.pooled.counts.fn_;
    let protocol = table.methods.first().and_then(|m| experiment.protocol_of(m));
    let things = match (n, protocol.map_or("events", |p| p.positives)) {
        (1, "losses") => "loss",
        (1, things) => things.strip_suffix('s').unwrap_or(things),
        (_, things) => things,
    };
    Some(format!("{n} {things}"))
}

/// Sentence on the number of cells of the table's methods without a result, because of missing data or of failures.
fn left_out(table: &Table, measures: &[Measure]) -> Option<String> {
    let is_shown = |m: &&Measure| m.attribute.is_none() && table.methods.contains(&m.method);
    let count = |of: fn(&Measure) -> usize| measures.iter().filter(is_shown).map(of).sum::<usize>();
    let not_there = count(|m| m.not_there);
    let failed = count(|m| m.failed).saturating_sub(not_there);
    let cells = |n: usize| if n == 1 { "1 cell".to_string() } else { format!("{n} cells") };
    let reasons = [
        (not_there > 0).then(|| format!("The data of {} is not there", cells(not_there))),
        (failed > 0).then(|| format!("{} failed", cells(failed))),
    ];
    let reasons: Vec<String> = reasons.into_iter().flatten().collect();
    let them = if not_there + failed == 1 { "it is" } else { "they are" };
    (!reasons.is_empty()).then(|| format!("{}; {them} left out.", reasons.join(", and ")))
}

/// Marks the best cells and the second best one of those that compete, by their numbers as they are printed.
fn mark_best<'c>(
    cells: impl Iterator<Item = &'c mut Cell>,
    direction: Direction,
    competes: impl Fn(usize, &Cell) -> bool,
) {
    let sign = match direction {
        Direction::HigherIsBetter => 1.0,
        Direction::LowerIsBetter => -1.0,
        Direction::Neither => return,
    };
    let competing = |(k, cell): (usize, &'c mut Cell)| {
        let shown = cell.ours.as_deref().filter(|_| competes(k, cell)).and_then(printed_value)?;
        Some((cell, sign * shown))
    };
    let mut competing: Vec<(&mut Cell, f64)> = cells.enumerate().filter_map(competing).collect();
    competing.sort_by(|a, b| b.1.total_cmp(&a.1));
    let [(_, first), (_, second), ..] = competing[..] else { return };
    let is_tied = first == second;
    for (cell, value) in &mut competing {
        cell.best = *value == first;
        cell.tied = cell.best && is_tied;
        cell.second = !is_tied && *value == second;
    }
}

#[cfg(test)]
mod tests;
