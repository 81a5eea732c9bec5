//! Tables and published numbers as an experiment asks for them.

mod published;

use super::error::{Errors, Source, SpecError};
use super::name::check_file_name;
use super::width::Width;
use super::wire;
pub use published::{inherit_published, read_published};
use serde::Serialize;
use std::ops::Range;
use toml::Spanned;
use trackfail_core::direction::Direction;
use trackfail_methods::analysis::Names;
use trackfail_methods::score::Metric;

/// The quantity that varies along one side of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Side {
    /// Metrics, in this order.
    Metrics(Vec<Metric>),
    /// Methods, in the experiment's order.
    Method,
    /// Trackers, in the experiment's order.
    Tracker,
    /// The values of a grid axis.
    Axis(String),
    /// All sequences, then those with each attribute.
    Attribute,
}

/// A table; whatever varies and is on neither side makes groups.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// File name.
    pub name: String,
    /// Text above the table.
    pub caption: Option<String>,
    /// Rows.
    pub rows: Side,
    /// Columns.
    pub columns: Side,
    /// The metric of all cells when neither side holds metrics.
    pub metric: Option<Metric>,
    /// The methods shown, in the experiment's order.
    pub methods: Vec<String>,
    /// The metric by which the methods are ranked; it has no rows and columns of its own then.
    pub ranked: Option<Metric>,
    /// The analysis whose table it is, instead of all that.
    pub shows: Option<FindingName>,
    /// The column of that table to which the trackers are the columns; all columns when `None`.
    pub column: Option<String>,
    /// The table whose published numbers stand beside ours too.
    pub published: Option<String>,
    /// The parts of it that LaTeX shows.
    pub latex: Latex,
}

/// The parts of a table that LaTeX shows, and how wide they may be.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Latex {
    /// The columns, in this order; all but anchors when empty.
    pub columns: Vec<String>,
    /// The width; as the table needs it when `None`.
    pub width: Option<Width>,
}

/// A row of numbers as a paper prints it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Published {
    /// Name of the table.
    pub table: String,
    /// The tracker the paper used.
    pub tracker: String,
    /// Row, as in the table.
    pub row: String,
    /// Column and text, at the precision printed.
    pub values: Vec<(String, String)>,
}

/// Words an experiment defines, for checking references.
pub struct Words {
    /// Method names.
    pub methods: Vec<String>,
    /// Tracker labels.
    pub trackers: Vec<String>,
    /// Grid axes of all methods.
    pub axes: Vec<String>,
    /// The values of each axis in the grid of each method.
    pub grids: Vec<GridAxis>,
    /// Sequences of the test suite.
    pub sequences: Vec<String>,
    /// Methods without a grid: those whose series are kept for figures.
    pub drawn: Vec<String>,
    /// Methods that read a signal.
    pub with_signal: Vec<String>,
    /// Analyses with what they find out.
    pub analyses: Vec<(String, Names)>,
}

/// The values that an axis has in the grid of a method.
#[derive(Debug, Clone, PartialEq)]
pub struct GridAxis {
    /// The method.
    pub method: String,
    /// The axis.
    pub axis: String,
    /// Its values, each once, in any order.
    pub values: Vec<f64>,
}

/// A product of an analysis: the analysis's name in the experiment, and the name of the table, chart or number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FindingName {
    /// The analysis.
    pub analysis: String,
    /// Name of the table, chart or number.
    pub part: String,
}

impl std::fmt::Display for FindingName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.analysis, self.part)
    }
}

/// A name that no analysis of the experiment gives to a finding; the message lists those that are.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct UnknownFinding(String);

impl Words {
    /// Reads `ANALYSIS.PART`, where `parts` picks out which parts are meant.
    ///
    /// # Errors
    /// A name that no analysis makes.
    pub fn finding(&self, text: &str, parts: fn(&Names) -> &[String]) -> Result<FindingName, UnknownFinding> {
        let known = || {
            let all = self.analyses.iter();
            all.flat_map(|(name, names)| parts(names).iter().map(move |part| format!("{name}.{part}")))
        };
        if !known().any(|k| k == text) {
            let known: Vec<String> = known().collect();
            let message = trackfail_core::plugin::unknown("finding", text, known.iter().map(String::as_str));
            return Err(UnknownFinding(message));
        }
        let (analysis, part) = text.split_once('.').unwrap_or((text, ""));
        Ok(FindingName { analysis: analysis.to_string(), part: part.to_string() })
    }
}

/// The side of a table that is the attributes of sequences.
const ATTRIBUTE: &str = "attribute";

/// The metric that a word of the file names.
pub(super) fn metric(source: Source<'_>, word: &Spanned<String>) -> Result<Metric, SpecError> {
    Metric::from_name(word.get_ref())
        .ok_or_else(|| source.error(word.span(), Metric::unknown(word.get_ref())))
}

/// The grid axis that a word of the file names.
pub(super) fn grid_axis(
    source: Source<'_>,
    word: &Spanned<String>,
    words: &Words,
) -> Result<String, SpecError> {
    if words.axes.contains(word.get_ref()) {
        return Ok(word.get_ref().clone());
    }
    Err(source.unknown(word.span(), "grid axis", word.get_ref(), words.axes.iter().map(String::as_str)))
}

/// Refuses each word of a list that is not among the known ones.
pub(super) fn all_known<'l>(
    source: Source<'_>,
    what: &str,
    list: impl IntoIterator<Item = &'l Spanned<String>>,
    known: &[String],
) -> Result<(), SpecError> {
    let wrong = list.into_iter().filter(|word| !known.contains(word.get_ref()));
    let error = |word: &Spanned<String>| {
        source.unknown(word.span(), what, word.get_ref(), known.iter().map(String::as_str))
    };
    Errors::collect(wrong.map(|word| Err::<(), _>(error(word)))).map(drop)
}

/// The methods of the experiment that are in `list`, or all without a list.
pub(super) fn read_methods(
    source: Source<'_>,
    list: Option<&[Spanned<String>]>,
    words: &Words,
) -> Result<Vec<String>, SpecError> {
    let Some(list) = list else { return Ok(words.methods.clone()) };
    all_known(source, "method", list, &words.methods)?;
    let shown = |name: &&String| list.iter().any(|m| m.get_ref() == *name);
    Ok(words.methods.iter().filter(shown).cloned().collect())
}

/// What the table of an experiment without tables and figures shows.
const DEFAULT_METRICS: [&str; 6] =
    ["events", "precision", "recall", "f_score", "f_over_chance", "false_alarms_per_1000"];

impl Table {
    /// The table that an experiment without tables and figures has.
    pub fn of_methods(words: &Words) -> Self {
        Self {
            name: "methods".to_string(),
            caption: None,
            rows: Side::Metrics(DEFAULT_METRICS.into_iter().filter_map(Metric::from_name).collect()),
            columns: Side::Method,
            metric: None,
            methods: words.methods.clone(),
            ranked: None,
            shows: None,
            column: None,
            published: None,
            latex: Latex::default(),
        }
    }
}

/// Checks a `[[table]]`.
///
/// # Errors
/// All that is wrong with it.
pub fn read_table(source: Source<'_>, wire: &wire::Table, words: &Words) -> Result<Table, SpecError> {
    let mut errors = Errors::default();
    errors.keep(check_file_name(source, &wire.name));
    if wire.name.get_ref() == "macros" {
        errors.push(source.error(wire.name.span(), "`macros` is the file with the numbers of all tables"));
    }
    if let Some(column) = wire.column.as_ref().filter(|_| wire.shows.is_none()) {
        errors.push(source.error(column.span(), "`column` is for tables that `show` one of an analysis"));
    }
    let read = match (wire, &wire.rows, &wire.columns) {
        (wire::Table { shows: Some(shows), .. }, ..) => read_shown(source, wire, shows, words),
        (wire::Table { rank: Some(rank), .. }, ..) => read_leaderboard(source, wire, rank, words),
        (_, Some(rows), Some(columns)) => read_crossed(source, wire, (rows, columns), words),
        _ => Err(source.error(wire.name.span(), "a table needs `rows` and `columns`, `rank` or `shows`")),
    };
    match errors.keep(read) {
        Some(table) => errors.check().map(|()| table),
        None => Err(errors.first()),
    }
}

/// A table with rows and columns of its own.
fn read_crossed(
    source: Source<'_>,
    wire: &wire::Table,
    (wire_rows, wire_columns): (&Spanned<Vec<Spanned<String>>>, &Spanned<String>),
    words: &Words,
) -> Result<Table, SpecError> {
    let mut errors = Errors::default();
    let rows = errors.keep(read_rows(source, wire_rows, words));
    let columns = errors.keep(read_columns(source, wire_columns, words));
    let shown = errors.keep(wire.metric.as_ref().map(|m| metric(source, m)).transpose());
    let methods = errors.keep(read_methods(source, wire.methods.as_deref(), words));
    let known = match columns {
        Some(Side::Method) => methods.as_ref(),
        Some(Side::Tracker) => Some(&words.trackers),
        _ => None,
    };
    let latex = errors.keep(read_latex(source, wire, known.map(Vec::as_slice)));
    let shown = match (&rows, &columns, shown) {
        (Some(rows), Some(columns), Some(shown)) => errors.keep(metric_of_cells(
            source,
            wire,
            [(rows, wire_rows.span()), (columns, wire_columns.span())],
            shown,
        )),
        _ => None,
    };
    let (Some(rows), Some(columns), Some(metric), Some(methods), Some(latex)) =
        (rows, columns, shown, methods, latex)
    else {
        return Err(errors.first());
    };
    Ok(Table {
        name: wire.name.get_ref().clone(),
        caption: wire.caption.clone(),
        rows,
        columns,
        metric,
        methods,
        ranked: None,
        shows: None,
        column: None,
        published: wire.published.as_ref().map(|t| t.get_ref().clone()),
        latex,
    })
}

/// The metric of all cells, where the rows, of which each side comes with its place, are no metrics; `shown` is the one
/// that the file gives.
fn metric_of_cells(
    source: Source<'_>,
    wire: &wire::Table,
    [(rows, rows_place), (columns, columns_place)]: [(&Side, Range<usize>); 2],
    shown: Option<Metric>,
) -> Result<Option<Metric>, SpecError> {
    let place = || wire.metric.as_ref().map_or(rows_place.clone(), Spanned::span);
    let shown = match (rows, shown) {
        (Side::Metrics(_), None) => None,
        (Side::Metrics(_), Some(_)) => {
            return Err(source.error(place(), "`metric` is for tables whose rows are a grid axis"));
        }
        (_, shown) => Some(shown.unwrap_or(Metric::F_SCORE)),
    };
    let attribute = [rows, columns].contains(&&Side::Attribute);
    let metrics = if let Side::Metrics(list) = rows { list.as_slice() } else { shown.as_slice() };
    if let Some(m) = metrics.iter().find(|m| attribute && !m.is_of_counts()) {
        let message =
            format!("`{}` is not known attribute by attribute, only what is made of counts is", m.name());
        return Err(source.error(place(), message));
    }
    if rows == columns {
        return Err(source.error(columns_place, "rows and columns are the same"));
    }
    Ok(shown)
}

/// Checks `latex = { columns, width }`.
fn read_latex(source: Source<'_>, wire: &wire::Table, known: Option<&[String]>) -> Result<Latex, SpecError> {
    let Some(latex) = &wire.latex else { return Ok(Latex::default()) };
    let columns = latex.columns.iter().flatten();
    let mut errors = Errors::default();
    if let Some(known) = known {
        errors.keep(all_known(source, "column", columns.clone(), known));
    }
    match errors.keep(Width::read(source, latex.width.as_ref())) {
        Some(width) => errors.check().map(|()| {
            let columns = columns.map(|c| c.get_ref().clone()).collect();
            Latex { columns, width }
        }),
        None => Err(errors.first()),
    }
}

/// A table that an analysis makes.
fn read_shown(
    source: Source<'_>,
    wire: &wire::Table,
    shows: &Spanned<String>,
    words: &Words,
) -> Result<Table, SpecError> {
    let span = wire.rows.as_ref().map(Spanned::span).or(wire.columns.as_ref().map(Spanned::span));
    let span = span.or(wire.rank.as_ref().map(Spanned::span));
    let mut errors = Errors::default();
    if let Some(span) = span.or(wire.metric.as_ref().map(Spanned::span)) {
        let message = "a table that `shows` one of an analysis has no rows, columns or metric of its own";
        errors.push(source.error(span, message));
    }
    let finding = words.finding(shows.get_ref(), |n| &n.tables);
    let finding = errors.keep(finding.map_err(|e| source.error(shows.span(), e.to_string())));
    let latex = errors.keep(read_latex(source, wire, None));
    let (Some(finding), Some(latex), true) = (finding, latex, errors.is_empty()) else {
        return Err(errors.first());
    };
    Ok(Table {
        name: wire.name.get_ref().clone(),
        caption: wire.caption.clone(),
        rows: Side::Metrics(Vec::new()),
        columns: Side::Tracker,
        metric: None,
        methods: Vec::new(),
        ranked: None,
        shows: Some(finding),
        column: wire.column.as_ref().map(|c| c.get_ref().clone()),
        published: None,
        latex,
    })
}

/// The rows of a table: metrics, attributes, or the values of a grid axis.
fn read_rows(
    source: Source<'_>,
    wire_rows: &Spanned<Vec<Spanned<String>>>,
    words: &Words,
) -> Result<Side, SpecError> {
    Ok(match wire_rows.get_ref().as_slice() {
        [] => return Err(source.error(wire_rows.span(), "`rows` is empty")),
        [one] if words.axes.contains(one.get_ref()) => Side::Axis(one.get_ref().clone()),
        [one] if one.get_ref() == ATTRIBUTE => Side::Attribute,
        list => {
            let axes = words.axes.iter().map(String::as_str);
            let known = Metric::names().map(|n| -> &str { n }).chain([ATTRIBUTE]).chain(axes);
            let known: Vec<&str> = known.collect();
            let read = |word: &Spanned<String>| {
                Metric::from_name(word.get_ref()).ok_or_else(|| {
                    let known = known.iter().copied();
                    source.unknown(word.span(), "metric, attribute or grid axis", word.get_ref(), known)
                })
            };
            Side::Metrics(Errors::collect(list.iter().map(read))?)
        }
    })
}

/// The columns of a table: methods, trackers, attributes, or the values of a grid axis.
fn read_columns(
    source: Source<'_>,
    wire_columns: &Spanned<String>,
    words: &Words,
) -> Result<Side, SpecError> {
    Ok(match wire_columns.get_ref().as_str() {
        "method" => Side::Method,
        "tracker" => Side::Tracker,
        word if words.axes.iter().any(|a| a == word) => Side::Axis(word.to_string()),
        ATTRIBUTE => Side::Attribute,
        word => {
            let known =
                ["method", "tracker", ATTRIBUTE].into_iter().chain(words.axes.iter().map(String::as_str));
            return Err(source.unknown(wire_columns.span(), "column", word, known));
        }
    })
}

/// A table of methods in order of a metric.
fn read_leaderboard(
    source: Source<'_>,
    wire: &wire::Table,
    rank: &Spanned<String>,
    words: &Words,
) -> Result<Table, SpecError> {
    let span = wire.rows.as_ref().map(Spanned::span).or(wire.columns.as_ref().map(Spanned::span));
    let mut errors = Errors::default();
    if let Some(span) = span.or(wire.metric.as_ref().map(Spanned::span)) {
        let message = "a table with a `rank` has no rows, columns or metric of its own";
        errors.push(source.error(span, message));
    }
    let metric = errors.keep(metric(source, rank));
    let ranks = |m: &Metric| m.direction() != Direction::Neither && (m.is_of_counts() || m.is_of_frames());
    if let Some(metric) = metric.filter(|metric| !ranks(metric)) {
        let message = format!(
            "`{}` ranks nothing: it is no measure of counts or frames with a better end",
            metric.name()
        );
        errors.push(source.error(rank.span(), message));
    }
    let methods = errors.keep(read_methods(source, wire.methods.as_deref(), words));
    let latex = errors.keep(read_latex(source, wire, None));
    let (Some(metric), Some(methods), Some(latex), true) = (metric, methods, latex, errors.is_empty()) else {
        return Err(errors.first());
    };
    Ok(Table {
        name: wire.name.get_ref().clone(),
        caption: wire.caption.clone(),
        rows: Side::Metrics(Vec::new()),
        columns: Side::Tracker,
        metric: None,
        methods,
        ranked: Some(metric),
        shows: None,
        column: None,
        published: None,
        latex,
    })
}
