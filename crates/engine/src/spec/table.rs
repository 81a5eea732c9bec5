//! Tables and published numbers of an experiment.

use super::error::At;
use super::method::Method;
use super::name::{check_file_name, check_label};
use super::width::Width;
pub use super::words::{FindingName, GridAxis, Words};
use super::{Tracker, wire};
use serde::Serialize;
use trackfail_core::direction::Direction;
use trackfail_methods::analysis::Names;
use trackfail_methods::score::Metric;
use trackfail_methods::score::metric::Source;

/// Quantity that varies along one side of a table.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Side {
    /// Metrics, in this order.
    Metrics(Vec<Metric>),
    /// Methods, in the experiment's order.
    Method,
    /// Trackers, in the experiment's order.
    #[default]
    Tracker,
    /// The values of a grid axis.
    Axis(String),
    /// All sequences, then those with each attribute.
    Attribute,
}

/// A table. Quantities that vary but are on neither side make groups of rows.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Table {
    /// File name without extension.
    pub name: String,
    /// Text above the table.
    pub caption: Option<String>,
    /// Content of the rows.
    pub rows: Side,
    /// Content of the columns.
    pub columns: Side,
    /// Metric of all cells; `None` if a side holds metrics.
    pub metric: Option<Metric>,
    /// The methods shown, in the experiment's order.
    pub methods: Vec<String>,
    /// Metric by which the methods are ranked. Such a table has no rows and columns of its own.
    pub ranked: Option<Metric>,
    /// Table of an analysis that is shown instead.
    pub shows: Option<FindingName>,
    /// Column of that table that is shown, with one column for each tracker; `None` to show all columns.
    pub column: Option<String>,
    /// Name of another table whose published numbers stand beside ours, too.
    pub published: Option<String>,
    /// Parts of the table that LaTeX shows.
    pub latex: Latex,
}

/// Parts of a table that LaTeX shows, and their width.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Latex {
    /// Columns in this order; empty for all but anchors.
    pub columns: Vec<String>,
    /// Width in print; `None` for the natural width of the table.
    pub width: Option<Width>,
}

/// One row of numbers, as a paper prints it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Published {
    /// Name of the table.
    pub table: String,
    /// The tracker the paper used.
    pub tracker: String,
    /// Row, as in the table.
    pub row: String,
    /// Column names and printed texts, at the printed precision.
    pub values: Vec<(String, String)>,
}

/// Name of the side that lists attributes of sequences.
const ATTRIBUTE: &str = "attribute";

/// Grid axis that a word of the file names.
pub(super) fn grid_axis(at: At<'_>, word: &str, words: &Words) -> Option<String> {
    at.knows("grid axis", word, words.axes.iter().map(String::as_str)).then(|| word.to_string())
}

/// Reports each word of a list that is not among the known ones.
pub(super) fn all_known(at: At<'_>, what: &str, list: &[String], known: &[String]) {
    for (index, word) in list.iter().enumerate().filter(|(_, word)| !known.contains(word)) {
        at.item(index).tell_unknown(what, word, known.iter().map(String::as_str));
    }
}

/// Methods listed in a table or figure; all methods without a list.
pub(super) fn read_methods(at: At<'_>, list: Option<&[String]>, words: &Words) -> Vec<String> {
    let Some(list) = list else { return words.methods.clone() };
    all_known(at.key("methods"), "method", list, &words.methods);
    words.methods.iter().filter(|name| list.contains(name)).cloned().collect()
}

/// Table or chart named by the key `shows`. An unknown one is reported.
pub(super) fn read_shows(
    at: At<'_>,
    shows: Option<&String>,
    words: &Words,
    parts: fn(&Names) -> &[String],
) -> Option<FindingName> {
    words.finding(shows?, parts).map_err(|message| at.key("shows").tell(message)).ok()
}

/// Metrics in the table of an experiment that defines no tables and figures.
const DEFAULT_METRICS: [&str; 6] =
    ["events", "precision", "recall", "f_score", "f_over_chance", "false_alarms_per_1000"];

impl Table {
    /// Table of an experiment that defines no tables and figures.
    pub(super) fn of_methods(words: &Words) -> Self {
        let rows = Side::Metrics(DEFAULT_METRICS.into_iter().filter_map(Metric::from_name).collect());
        let (name, methods) = ("methods".to_string(), words.methods.clone());
        Self { name, rows, columns: Side::Method, methods, ..Self::default() }
    }

    /// Checks a `[[table]]`.
    pub(super) fn read(at: At<'_>, wire: &wire::Table, words: &Words) -> Option<Self> {
        check_file_name(at.key("name"), &wire.name);
        if wire.name == "macros" {
            at.key("name").tell("`macros` is the file with the numbers of all tables");
        }
        if wire.column.is_some() && wire.shows.is_none() {
            at.key("column").tell("`column` is for tables that `show` one of an analysis");
        }
        let has_none = |keys: &[&str], what: &str| {
            if let Some(key) = keys.iter().find(|key| at.has(key)) {
                at.key(key).tell(format!("a table {what} has no `{key}` of its own"));
            }
        };
        let (name, caption, rows) = (wire.name.clone(), wire.caption.clone(), Side::Metrics(Vec::new()));
        let mut table = Self { name, caption, rows, ..Self::default() };
        if wire.shows.is_some() {
            has_none(&["rows", "columns", "metric", "rank", "methods"], "that `shows` one of an analysis");
            table.shows = Some(read_shows(at, wire.shows.as_ref(), words, |names| &names.tables)?);
            table.column = wire.column.clone();
        } else if let Some(rank) = &wire.rank {
            has_none(&["rows", "columns", "metric"], "with a `rank`");
            table.methods = read_methods(at, wire.methods.as_deref(), words);
            let metric = Metric::from_name(rank)?;
            let is_measure = metric.is_of_counts() || metric.is_of_frames();
            if metric.direction() == Direction::Neither || !is_measure {
                let message = "ranks nothing: it is no measure of counts or frames with a better end";
                at.key("rank").tell(format!("`{rank}` {message}"));
            }
            table.ranked = Some(metric);
        } else {
            table.read_sides(at, wire, words)?;
        }
        if let Some(latex) = &wire.latex {
            let (at, columns) = (at.key("latex"), latex.columns.clone().unwrap_or_default());
            let has_sides = table.shows.is_none() && table.ranked.is_none();
            let known = match table.columns {
                Side::Method if has_sides => &table.methods,
                Side::Tracker if has_sides => &words.trackers,
                _ => &columns,
            };
            all_known(at.key("columns"), "column", &columns, known);
            table.latex = Latex { width: latex.width.as_deref().and_then(Width::from_word), columns };
        }
        Some(table)
    }

    /// Checks rows, columns and the metric of the cells.
    fn read_sides(&mut self, at: At<'_>, wire: &wire::Table, words: &Words) -> Option<()> {
        let (Some(rows), Some(columns)) = (&wire.rows, &wire.columns) else {
            return at.key("name").refuse("a table needs `rows` and `columns`, `rank` or `shows`");
        };
        self.methods = read_methods(at, wire.methods.as_deref(), words);
        self.published = wire.published.clone();
        self.metric = wire.metric.as_deref().and_then(Metric::from_name);
        let (rows, columns) = (read_rows(at, rows, words), read_columns(at, columns, words));
        let (rows, columns) = (rows?, columns?);
        let in_metric = at.key(if self.metric.is_some() { "metric" } else { "rows" });
        match (&rows, self.metric) {
            (Side::Metrics(_), Some(_)) => {
                in_metric.tell("`metric` is for tables whose rows are a grid axis")
            }
            (Side::Metrics(_), None) => {}
            (_, metric) => self.metric = Some(metric.unwrap_or(Metric::F_SCORE)),
        }
        let metrics = if let Side::Metrics(list) = &rows { list.as_slice() } else { self.metric.as_slice() };
        let of_attributes = [&rows, &columns].contains(&&Side::Attribute);
        if let Some(m) = metrics.iter().find(|m| of_attributes && m.source != Source::Counts) {
            let name = m.name();
            in_metric.tell(format!(
                "`{name}` is not known attribute by attribute, only what is made of counts is"
            ));
        }
        if rows == columns {
            at.key("columns").tell("rows and columns are the same");
        }
        (self.rows, self.columns) = (rows, columns);
        Some(())
    }
}

/// The rows of a table: metrics, attributes, or the values of a grid axis.
fn read_rows(at: At<'_>, rows: &[String], words: &Words) -> Option<Side> {
    let at = at.key("rows");
    match rows {
        [] => at.tell("`rows` is empty"),
        [one] if words.axes.contains(one) => return Some(Side::Axis(one.clone())),
        [one] if one == ATTRIBUTE => return Some(Side::Attribute),
        _ => {}
    }
    let axes = words.axes.iter().map(String::as_str);
    let known = Metric::names().map(|name| -> &str { name }).chain([ATTRIBUTE]).chain(axes);
    let metric = |(index, word): (usize, &String)| {
        let metric = Metric::from_name(word);
        if metric.is_none() {
            at.item(index).tell_unknown("metric, attribute or grid axis", word, known.clone());
        }
        metric
    };
    // All are read before one that is unknown ends it.
    let metrics: Vec<Option<Metric>> = rows.iter().enumerate().map(metric).collect();
    metrics.into_iter().collect::<Option<Vec<_>>>().filter(|all| !all.is_empty()).map(Side::Metrics)
}

/// The columns of a table: methods, trackers, attributes, or the values of a grid axis.
fn read_columns(at: At<'_>, columns: &str, words: &Words) -> Option<Side> {
    let side = match columns {
        "method" => Side::Method,
        "tracker" => Side::Tracker,
        ATTRIBUTE => Side::Attribute,
        word => Side::Axis(word.to_string()),
    };
    let axes = words.axes.iter().map(String::as_str);
    let known = ["method", "tracker", ATTRIBUTE].into_iter().chain(axes);
    at.key("columns").knows("column", columns, known).then_some(side)
}

/// All published numbers, including inherited ones. A method or tracker that is
/// [like](Method::like) another inherits that one's numbers, unless it has its own; so
/// does a table that names another one.
pub(super) fn inherit_published(
    published: Vec<Published>,
    tables: &[Table],
    methods: &[Method],
    trackers: &[Tracker],
) -> Vec<Published> {
    let mut all = published;
    for (table, like) in tables.iter().filter_map(|t| Some((&t.name, t.published.as_ref()?))) {
        let taken: Vec<Published> = all.iter().filter(|p| p.table == *like).cloned().collect();
        all.extend(taken.into_iter().map(|p| Published { table: table.clone(), ..p }));
    }
    for (label, like) in trackers.iter().filter_map(|t| Some((&t.label, t.like.as_ref()?))) {
        let taken: Vec<Published> = all.iter().filter(|p| p.tracker == *like).cloned().collect();
        all.extend(taken.into_iter().map(|p| Published { tracker: label.clone(), ..p }));
    }
    for Published { values, .. } in &mut all {
        for method in methods {
            let text = |name: &str| values.iter().find(|(m, _)| m == name).map(|(_, text)| text.clone());
            let taken = method.like.as_deref().and_then(text);
            if let (Some(taken), None) = (taken, text(&method.name)) {
                values.push((method.name.clone(), taken));
            }
        }
    }
    all
}

/// Checks a `[[published]]` against its table; `None` if that table is wrong.
pub(super) fn read_published(
    at: At<'_>,
    wire: &wire::Published,
    tables: &[Table],
    words: &Words,
) -> Option<Published> {
    check_label(at.key("tracker"), &wire.tracker, false);
    let Some(table) = tables.iter().find(|t| t.name == wire.table) else {
        at.key("table").knows("table", &wire.table, words.tables.iter().map(String::as_str));
        return None;
    };
    if table.ranked.is_some() {
        at.key("table").tell("a table with a `rank` has no published numbers beside it");
    } else if let (Side::Metrics(metrics), None) = (&table.rows, &table.shows) {
        at.key("row").knows("row", &wire.row, metrics.iter().map(|m| m.name()));
    }
    for (column, text) in &wire.values {
        let at = at.key("values").key(column);
        if table.columns == Side::Method {
            at.knows("column", column, table.methods.iter().map(String::as_str));
        }
        let numbers: Vec<&str> = text.split('±').collect();
        let is_number = |n: &&str| n.trim().parse::<f64>().is_ok_and(f64::is_finite);
        if numbers.len() > 2 || !numbers.iter().all(is_number) {
            at.tell(format!("`{text}` is not a printed number"));
        }
    }
    let (table, tracker, row) = (wire.table.clone(), wire.tracker.clone(), wire.row.clone());
    Some(Published { table, tracker, row, values: wire.values.clone().into_iter().collect() })
}
