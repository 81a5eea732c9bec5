//! Arranges pooled numbers as an experiment's tables ask: ours, published, difference.
//!
//! Trackers, methods and grid axes that are on neither side of a table make groups of rows.
//! Published numbers of a tracker that was run stand beside that tracker's; those of a paper's only
//! tracker stand beside every tracker, and say whose they are; those of further trackers make groups
//! of their own without numbers of ours.

mod analysed;
mod place;

pub use analysed::analysed;
pub use place::{CellRef, cell_refs};

use super::number::{Style, printed_value};
use crate::results::Measure;
use place::{Place, find, group_places, merge, steps};
use serde::Serialize;
use trackfail_core::direction::Direction;
use trackfail_core::num::readable;
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::table::{Latex, Published, Side, Table};
use trackfail_methods::score::Metric;
use trackfail_methods::score::metric::Kind;

/// A table whose texts are ready for any format.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableLayout {
    /// File name.
    pub name: String,
    /// Text above the table, with the data it rests on.
    pub caption: String,
    /// The data the table rests on, alone: `12 of 21 targets`.
    pub data: String,
    /// Heading of the first column.
    pub corner: String,
    /// Column headings.
    pub columns: Vec<Label>,
    /// The parts of it that LaTeX shows.
    pub latex: Latex,
    /// Groups in order.
    pub groups: Vec<Group>,
}

/// Rows that share a tracker and grid point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Group {
    /// Heading; empty for a table's only group.
    pub label: String,
    /// Name in the heading, without counts: it stays the same when results change.
    pub key: String,
    /// The tracker whose published numbers stand beside ours.
    pub published_tracker: Option<String>,
    /// Whether there are numbers of ours at all.
    pub has_ours: bool,
    /// Rows in order.
    pub rows: Vec<Row>,
}

/// One row.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Metric or grid value.
    pub label: Label,
    /// Whether higher or lower values of the row's metric are better.
    pub direction: Direction,
    /// Cells, one for each column.
    pub cells: Vec<Cell>,
}

/// Heading of a row or a column.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Label {
    /// Its name in files for programs, macros and commands: `f_score`, `5`.
    pub name: String,
    /// How people read it: `F1 score ↑`, `length = 5`.
    pub shown: String,
    /// Kind of the column.
    pub kind: LabelKind,
}

/// Kind of a column: pages and LaTeX tables show results first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LabelKind {
    /// Results.
    Result,
    /// Counts that results are made from.
    Count,
    /// Numbers of an anchor.
    Anchor,
}

impl Label {
    /// A column of results that people read by another name.
    pub fn shown_as(name: String, shown: String) -> Self {
        Self { name, shown, kind: LabelKind::Result }
    }
}

impl<T: Into<String>> From<T> for Label {
    fn from(name: T) -> Self {
        let name = name.into();
        Self { shown: name.clone(), name, kind: LabelKind::Result }
    }
}

impl Label {
    /// The heading of a metric, with an arrow for its direction.
    pub fn of_metric(metric: Metric) -> Self {
        let arrow = match metric.direction() {
            Direction::HigherIsBetter => " ↑",
            Direction::LowerIsBetter => " ↓",
            Direction::Neither => "",
        };
        let (name, shown) = (metric.name().to_string(), format!("{}{arrow}", metric.title()));
        Self { name, shown, kind: if metric.is_count() { LabelKind::Count } else { LabelKind::Result } }
    }
}

/// One cell.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Cell {
    /// Our number as it is.
    pub value: Option<f64>,
    /// Our number as the paper would print it.
    pub ours: Option<String>,
    /// The published text.
    pub published: Option<String>,
    /// Ours minus published, both as printed.
    pub difference: Option<String>,
    /// Whether it is the best of ours in its row, as printed, or in its column where rows are trackers; anchors do not
    /// compete, nor do numbers with more cells without a result than others.
    pub best: bool,
    /// Whether others are as good as this best one.
    pub tied: bool,
    /// Whether it is the second best of ours there, if exactly one cell is the best.
    pub second: bool,
    /// Cells without a result behind this number.
    pub failed: usize,
}

/// Says how many cells have no result because their data is not there, or because they failed.
fn left_out(measures: &[Measure]) -> Option<String> {
    let count =
        |of: fn(&Measure) -> usize| measures.iter().filter(|m| m.attribute.is_none()).map(of).sum::<usize>();
    let not_there = count(|m| m.not_there);
    let failed = count(|m| m.failed).saturating_sub(not_there);
    let cells = |n: usize| if n == 1 { "1 cell".to_string() } else { format!("{n} cells") };
    let them = if not_there + failed == 1 { "it is" } else { "they are" };
    match (not_there, failed) {
        (0, 0) => None,
        (n, 0) => Some(format!("The data of {} is not there; {them} left out.", cells(n))),
        (0, n) => Some(format!("{} failed; {them} left out.", cells(n))),
        (n, m) => Some(format!(
            "The data of {} is not there, and {} failed; they are left out.",
            cells(n),
            cells(m)
        )),
    }
}

/// The pooled numbers of a tracker and method at a grid point, where there are any; for claims.
pub fn measure_of<'a>(
    measures: &'a [Measure],
    tracker: &str,
    method: &str,
    axes: &[(String, f64)],
) -> Option<&'a Measure> {
    find(measures, tracker, method, axes, None)
}

/// Whether a method is an anchor: a detector that looks at no signal.
pub fn is_anchor(experiment: &Experiment, method: &str) -> bool {
    experiment
        .methods
        .iter()
        .filter(|m| m.name == method)
        .flat_map(|m| &m.variants)
        .all(|v| !v.detector.example().detector.needs_signal())
}

/// Makes a table of pooled numbers; `data_note` says what they rest on.
pub fn layout(experiment: &Experiment, table: &Table, measures: &[Measure], data_note: &str) -> TableLayout {
    let published: Vec<&Published> = experiment.published.iter().filter(|p| p.table == table.name).collect();
    let rows = steps(&table.rows, table, experiment, measures);
    let columns = steps(&table.columns, table, experiment, measures);
    let context = TableContext {
        experiment,
        metric: table.metric,
        published: &published,
        rows: &rows,
        columns: &columns,
    };
    let protocol = table.methods.first().and_then(|m| experiment.protocol_of(m));
    let positives = protocol.map_or("events", |p| p.positives);
    let counted = |n: u64| format!("{n} {}", if n == 1 { singular(positives) } else { positives });
    let mut groups = Vec::new();
    let mut shown_trackers: Vec<&str> = Vec::new();
    for (label, place) in group_places(experiment, table, measures) {
        let tracker = place.tracker.clone();
        let source = published_for(&published, tracker.as_deref(), experiment);
        if let Some(source) = source {
            shown_trackers.push(source);
        }
        let key = if label.is_empty() { tracker.clone().unwrap_or_default() } else { label.clone() };
        let heading = match (&tracker, events(table, measures, tracker.as_deref())) {
            (Some(t), Some(events)) if label.is_empty() => format!("{t} ({})", counted(events)),
            (Some(_), Some(events)) => format!("{label} ({})", counted(events)),
            _ => label,
        };
        groups.push(Group { key, ..make_group(&context, measures, heading, source, &place) });
    }
    let mut others: Vec<&str> = Vec::new();
    for p in &published {
        if !shown_trackers.contains(&p.tracker.as_str()) && !others.contains(&p.tracker.as_str()) {
            others.push(&p.tracker);
        }
    }
    for tracker in others {
        let label = format!("{tracker} (published; not run here)");
        let place = Place { tracker: Some(tracker.to_string()), ..Place::default() };
        let group = make_group(&context, &[], label, Some(tracker), &place);
        groups.push(Group { key: tracker.to_string(), has_ours: false, ..group });
    }
    let mut caption = table.caption.clone().unwrap_or_else(|| experiment.title.clone());
    if !caption.ends_with('.') {
        caption.push('.');
    }
    caption.push_str(&format!(" Suite {}: {data_note}", experiment.suites[trackfail_engine::spec::TEST]));
    caption.push('.');
    if let Some(left_out) = left_out(measures) {
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
    TableLayout {
        name: table.name.clone(),
        caption,
        data: data_note.to_string(),
        corner,
        columns: columns.iter().map(|(name, place)| heading(experiment, name, place, true)).collect(),
        latex: table.latex.clone(),
        groups,
    }
}

/// The heading of a row or a column. A grid value has the name of its axis beside it where no corner names that.
fn heading(experiment: &Experiment, name: &str, place: &Place, is_column: bool) -> Label {
    if let Some(metric) = place.metric {
        return Label::of_metric(metric);
    }
    let is_anchor = place.method.as_deref().is_some_and(|m| is_anchor(experiment, m));
    let kind = if is_anchor { LabelKind::Anchor } else { LabelKind::Result };
    let shown = match place.axes.as_slice() {
        [(axis, value)] if is_column => format!("{axis} = {}", readable(value)),
        _ => name.to_string(),
    };
    Label { name: name.to_string(), shown, kind }
}

/// One of the things that protocols count, such as `events` or `losses`.
fn singular(positives: &str) -> &str {
    match positives {
        "losses" => "loss",
        plural => plural.strip_suffix('s').unwrap_or(plural),
    }
}

/// Number of events of a tracker (of the only one when `None`) for the table's methods. All methods have the same
/// events unless their protocols differ.
fn events(table: &Table, measures: &[Measure], tracker: Option<&str>) -> Option<u64> {
    let mine = |m: &&Measure| {
        m.attribute.is_none() && tracker.is_none_or(|t| m.tracker == t) && table.methods.contains(&m.method)
    };
    let m = measures.iter().find(|m| mine(m) && m.done > 0)?;
    Some(m.pooled.counts.tp + m.pooled.counts.fn_)
}

fn published_for<'a>(
    published: &[&'a Published],
    tracker: Option<&str>,
    experiment: &Experiment,
) -> Option<&'a str> {
    let own = published.iter().find(|p| Some(p.tracker.as_str()) == tracker);
    if let Some(own) = own {
        return Some(&own.tracker);
    }
    let first = published.first()?;
    let only = published.iter().all(|p| p.tracker == first.tracker);
    let is_run = experiment.trackers.iter().any(|t| t.label == first.tracker);
    (only && !is_run).then_some(first.tracker.as_str())
}

/// The tracker that a paper prints numbers of: for a reading the one that it is like.
fn printed_for(experiment: &Experiment, label: &str) -> String {
    let tracker = experiment.trackers.iter().find(|t| t.label == label);
    tracker.and_then(|t| t.like.as_deref()).unwrap_or(label).to_string()
}

/// Properties that all groups of a table share.
struct TableContext<'a> {
    experiment: &'a Experiment,
    metric: Option<Metric>,
    published: &'a [&'a Published],
    rows: &'a [(String, Place)],
    columns: &'a [(String, Place)],
}

fn make_group(
    context: &TableContext<'_>,
    measures: &[Measure],
    label: String,
    source: Option<&str>,
    place: &Place,
) -> Group {
    let TableContext { experiment, metric: of_table, published, rows, columns } = *context;
    let rows = rows.iter().map(|(row_label, row)| {
        let printed = |column: &str| {
            published
                .iter()
                .filter(|p| Some(p.tracker.as_str()) == source && p.row == *row_label)
                .flat_map(|p| &p.values)
                .find(|(c, _)| c == column)
                .map(|(_, text)| text.clone())
        };
        let metric = row.metric.or(of_table).unwrap_or(Metric::F_SCORE);
        // As the paper prints the metric, for whichever tracker it does: a column has one rounding.
        let first = || {
            let of_row = published.iter().filter(|p| p.row == *row_label);
            of_row.flat_map(|p| &p.values).map(|(_, text)| text.as_str()).next()
        };
        let style = first().map_or_else(|| Style::of_metric(metric), Style::of);
        let mut cells: Vec<Cell> = columns
            .iter()
            .map(|(column_label, column)| {
                let at = merge(&[place, row, column]);
                let tracker = at.tracker.as_deref().or(experiment.trackers.first().map(|t| t.label.as_str()));
                let method = at.method.as_deref().or(experiment.methods.first().map(|m| m.name.as_str()));
                let attribute = at.attribute.as_deref();
                let of = |(t, m): (&str, &str)| find(measures, t, m, &at.axes, attribute);
                let measure = tracker.zip(method).and_then(of);
                make_cell(measure, metric, style, printed(column_label))
            })
            .collect();
        // Parts of a suite do not compete with each other.
        if columns.iter().all(|c| c.1.attribute.is_none()) {
            // Nor does a number with those of more sequences.
            let fewest = cells.iter().filter(|c| c.value.is_some()).map(|c| c.failed).min().unwrap_or(0);
            let is_partial: Vec<bool> = cells.iter().map(|c| c.failed > fewest).collect();
            mark_best(&mut cells, metric.direction(), style, |k| {
                let name = columns[k].1.method.as_deref();
                is_partial[k] || name.is_some_and(|m| is_anchor(experiment, m))
            });
        }
        let label = heading(experiment, row_label, row, false);
        Row { label, direction: metric.direction(), cells }
    });
    Group {
        key: label.clone(),
        label,
        published_tracker: source.map(|label| printed_for(experiment, label)),
        has_ours: true,
        rows: rows.collect(),
    }
}

fn make_cell(measure: Option<&Measure>, metric: Metric, style: Style, published: Option<String>) -> Cell {
    let value = measure.and_then(|m| m.value(metric));
    let ours = value.map(|v| match (metric.kind(), measure.and_then(|m| m.pooled.score)) {
        (Kind::MeanAndDeviation, Some((_, std))) => format!("{}±{}", style.format(v), style.format(std)),
        _ => style.format(v),
    });
    let printed = published.as_deref().and_then(printed_value);
    let difference = value.zip(printed).map(|(v, p)| style.format_signed(style.round(v) - p));
    Cell { value, ours, published, difference, failed: measure.map_or(0, |m| m.failed), ..Cell::default() }
}

/// Marks the best cells and the second best one, by their numbers as they are printed.
fn mark_best(cells: &mut [Cell], direction: Direction, style: Style, is_anchor: impl Fn(usize) -> bool) {
    let sign = match direction {
        Direction::HigherIsBetter => 1.0,
        Direction::LowerIsBetter => -1.0,
        Direction::Neither => return,
    };
    let competing = |k: usize, c: &Cell| c.value.filter(|_| !is_anchor(k)).map(|v| sign * style.round(v));
    let best = cells.iter().enumerate().filter_map(|(k, c)| competing(k, c)).max_by(f64::total_cmp);
    let count = cells.iter().enumerate().filter(|(k, c)| competing(*k, c).is_some()).count();
    if count < 2 {
        return;
    }
    for (k, cell) in cells.iter_mut().enumerate() {
        let value = competing(k, cell);
        cell.best = value.is_some() && value == best;
    }
    if cells.iter().filter(|c| c.best).count() > 1 {
        cells.iter_mut().for_each(|cell| cell.tied = cell.best);
        return;
    }
    let rest = cells.iter().enumerate().filter(|(_, c)| !c.best);
    let second = rest.filter_map(|(k, c)| competing(k, c)).max_by(f64::total_cmp);
    for (k, cell) in cells.iter_mut().enumerate().filter(|(_, c)| !c.best) {
        let value = competing(k, cell);
        cell.second = value.is_some() && value == second;
    }
}

#[cfg(test)]
mod tests;
