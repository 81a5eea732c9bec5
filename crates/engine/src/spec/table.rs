//! Tables, figures and published numbers as an experiment asks for them.

mod panel;
mod published;

use super::error::{Source, SpecError};
use super::wire;
use crate::analysis::Names;
use crate::direction::Direction;
use crate::score::measures::Metric;
use panel::read_panel;
pub use published::read_published;
use toml::Spanned;

/// What varies along one side of a table.
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
    /// What the rows are.
    pub rows: Side,
    /// What the columns are.
    pub columns: Side,
    /// The metric of all cells when neither side holds metrics.
    pub metric: Option<Metric>,
    /// The methods shown, in the experiment's order.
    pub methods: Vec<String>,
    /// The metric by which the methods are ranked; it has no rows and columns of its own then.
    pub ranked: Option<Metric>,
    /// The analysis whose table it is, instead of all that.
    pub shows: Option<Made>,
    /// The column of that table to which the trackers are the columns; all columns when `None`.
    pub column: Option<String>,
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

/// What one panel of a strip figure shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Panel {
    /// O_t.
    Error,
    /// A method's signal.
    Signal(String),
    /// A method's signal with its forecast.
    Forecast(String),
    /// One or more methods' scores with their thresholds.
    Score(Vec<String>),
    /// One or more methods' labels, a lane each.
    Labels(Vec<String>),
    /// The tracker's condition as one or more methods follow it.
    Condition(Vec<String>),
}

/// A figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// File name.
    pub name: String,
    /// Text below the figure.
    pub caption: Option<String>,
    /// What it shows.
    pub kind: FigureKind,
}

/// Kinds of figures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FigureKind {
    /// Series over frames, optionally below video frames.
    Strips {
        /// Label of the tracker; the first one when `None`.
        tracker: Option<String>,
        /// Sequences side by side; the one with most events when empty.
        sequences: Vec<String>,
        /// Rows of panels.
        panels: Vec<Vec<Panel>>,
        /// Number of video frames.
        stills: usize,
    },
    /// The states of detectors that follow the condition of a tracker.
    Machine,
    /// Of an analysis.
    Chart(Made),
    /// The share of events found by so many frames after them, a curve for each method without a grid.
    Delay {
        /// The methods shown, in the experiment's order.
        methods: Vec<String>,
    },
    /// One metric over another, a curve for each method with a grid, a point for each without.
    Curve {
        /// What the y axis shows.
        y: Metric,
        /// What the x axis shows.
        x: Metric,
        /// The methods shown, in the experiment's order.
        methods: Vec<String>,
    },
    /// A metric over a grid axis, a line for each combination of the others.
    Sweep {
        /// What the y axis shows.
        metric: Metric,
        /// The axis along x.
        x: String,
        /// The methods shown, in the experiment's order.
        methods: Vec<String>,
    },
}

/// Words an experiment defines, for checking references.
pub struct Words {
    /// Method names.
    pub methods: Vec<String>,
    /// Tracker labels.
    pub trackers: Vec<String>,
    /// Grid axes of all methods.
    pub axes: Vec<String>,
    /// Sequences of the test suite.
    pub sequences: Vec<String>,
    /// Methods without a grid: those whose series are kept for figures.
    pub drawn: Vec<String>,
    /// Methods that read a signal.
    pub with_signal: Vec<String>,
    /// Analyses with what they find out.
    pub analyses: Vec<(String, Names)>,
}

/// What an analysis makes: its name in the experiment, and the name of the table, chart or number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Made {
    /// The analysis.
    pub analysis: String,
    /// What of it.
    pub part: String,
}

impl std::fmt::Display for Made {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.analysis, self.part)
    }
}

impl Words {
    /// Reads `ANALYSIS.PART`, where `parts` picks out which parts are meant.
    ///
    /// # Errors
    /// In words, for one that no analysis makes.
    pub fn made(&self, text: &str, parts: fn(&Names) -> &[String]) -> Result<Made, String> {
        let known = || {
            let all = self.analyses.iter();
            all.flat_map(|(name, names)| parts(names).iter().map(move |part| format!("{name}.{part}")))
        };
        if !known().any(|k| k == text) {
            let known: Vec<String> = known().collect();
            return Err(crate::plugin::unknown("finding", text, known.iter().map(String::as_str)));
        }
        let (analysis, part) = text.split_once('.').unwrap_or((text, ""));
        Ok(Made { analysis: analysis.to_string(), part: part.to_string() })
    }
}

/// The side of a table that is the attributes of sequences.
const ATTRIBUTE: &str = "attribute";

/// Kinds of figures, as experiment files name them.
const FIGURE_KINDS: [&str; 6] = ["strips", "sweep", "curve", "delay", "chart", "machine"];

/// Most video frames above a strip figure.
const MOST_STILLS: usize = 12;

fn metric(source: Source<'_>, word: &Spanned<String>) -> Result<Metric, SpecError> {
    Metric::from_name(word.get_ref())
        .ok_or_else(|| source.unknown(word.span(), "metric", word.get_ref(), Metric::names()))
}

fn axis(source: Source<'_>, word: &Spanned<String>, words: &Words) -> Result<String, SpecError> {
    if words.axes.contains(word.get_ref()) {
        return Ok(word.get_ref().clone());
    }
    Err(source.unknown(word.span(), "grid axis", word.get_ref(), words.axes.iter().map(String::as_str)))
}

/// The methods of the experiment that are in `list`, or all without a list.
fn read_methods(
    source: Source<'_>,
    list: Option<&[Spanned<String>]>,
    words: &Words,
) -> Result<Vec<String>, SpecError> {
    let Some(list) = list else { return Ok(words.methods.clone()) };
    if let Some(wrong) = list.iter().find(|m| !words.methods.contains(m.get_ref())) {
        let known = words.methods.iter().map(String::as_str);
        return Err(source.unknown(wrong.span(), "method", wrong.get_ref(), known));
    }
    let shown = |name: &&String| list.iter().any(|m| m.get_ref() == *name);
    Ok(words.methods.iter().filter(shown).cloned().collect())
}

/// Checks a `[[table]]`.
pub fn read_table(source: Source<'_>, wire: &wire::Table, words: &Words) -> Result<Table, SpecError> {
    check_file_name(source, &wire.name)?;
    let name = wire.name.get_ref().clone();
    if name == "macros" {
        return Err(source.error(wire.name.span(), "`macros` is the file with the numbers of all tables"));
    }
    if let Some(shows) = &wire.shows {
        let span = wire.rows.as_ref().map(Spanned::span).or(wire.columns.as_ref().map(Spanned::span));
        let span = span.or(wire.rank.as_ref().map(Spanned::span));
        if let Some(span) = span.or(wire.metric.as_ref().map(Spanned::span)) {
            let message = "a table that `shows` one of an analysis has no rows, columns or metric of its own";
            return Err(source.error(span, message));
        }
        let made = words.made(shows.get_ref(), |n| &n.tables).map_err(|e| source.error(shows.span(), e))?;
        return Ok(Table {
            name,
            caption: wire.caption.clone(),
            rows: Side::Metrics(Vec::new()),
            columns: Side::Tracker,
            metric: None,
            methods: Vec::new(),
            ranked: None,
            shows: Some(made),
            column: wire.column.as_ref().map(|c| c.get_ref().clone()),
        });
    }
    if let Some(column) = &wire.column {
        return Err(source.error(column.span(), "`column` is for tables that `show` one of an analysis"));
    }
    if let Some(rank) = &wire.rank {
        return read_leaderboard(source, wire, rank, words);
    }
    let (Some(wire_rows), Some(wire_columns)) = (&wire.rows, &wire.columns) else {
        return Err(source.error(wire.name.span(), "a table needs `rows` and `columns`, `rank` or `shows`"));
    };
    let rows = match wire_rows.get_ref().as_slice() {
        [] => return Err(source.error(wire_rows.span(), "`rows` is empty")),
        [one] if words.axes.contains(one) => Side::Axis(one.clone()),
        [one] if one == ATTRIBUTE => Side::Attribute,
        list => {
            let mut metrics = Vec::new();
            for word in list {
                let axes = words.axes.iter().map(String::as_str);
                let known: Vec<&str> =
                    Metric::names().map(|n| -> &str { n }).chain([ATTRIBUTE]).chain(axes).collect();
                let metric = Metric::from_name(word).ok_or_else(|| {
                    source.unknown(wire_rows.span(), "metric, attribute or grid axis", word, known)
                })?;
                metrics.push(metric);
            }
            Side::Metrics(metrics)
        }
    };
    let columns = match wire_columns.get_ref().as_str() {
        "method" => Side::Method,
        "tracker" => Side::Tracker,
        word if words.axes.iter().any(|a| a == word) => Side::Axis(word.to_string()),
        ATTRIBUTE => Side::Attribute,
        word => {
            let known =
                ["method", "tracker", ATTRIBUTE].into_iter().chain(words.axes.iter().map(String::as_str));
            return Err(source.unknown(wire_columns.span(), "column", word, known));
        }
    };
    let shown = wire.metric.as_ref().map(|m| metric(source, m)).transpose()?;
    let shown = match (&rows, shown) {
        (Side::Metrics(_), None) => None,
        (Side::Metrics(_), Some(_)) => {
            let span = wire.metric.as_ref().map_or(wire_rows.span(), Spanned::span);
            return Err(source.error(span, "`metric` is for tables whose rows are a grid axis"));
        }
        (_, shown) => Some(shown.unwrap_or(Metric::FScore)),
    };
    let attribute = [&rows, &columns].contains(&&Side::Attribute);
    let metrics = if let Side::Metrics(list) = &rows { list.as_slice() } else { shown.as_slice() };
    if let Some(m) = metrics.iter().find(|m| attribute && !m.is_of_counts()) {
        let message =
            format!("`{}` is not known attribute by attribute, only what is made of counts is", m.name());
        let span = wire.metric.as_ref().map_or(wire_rows.span(), Spanned::span);
        return Err(source.error(span, message));
    }
    if rows == columns {
        return Err(source.error(wire_columns.span(), "rows and columns are the same"));
    }
    let methods = read_methods(source, wire.methods.as_deref(), words)?;
    Ok(Table {
        name,
        caption: wire.caption.clone(),
        rows,
        columns,
        metric: shown,
        methods,
        ranked: None,
        shows: None,
        column: None,
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
    if let Some(span) = span.or(wire.metric.as_ref().map(Spanned::span)) {
        let message = "a table with a `rank` has no rows, columns or metric of its own";
        return Err(source.error(span, message));
    }
    let metric = metric(source, rank)?;
    if metric.direction() == Direction::Neither || !metric.is_of_counts() {
        let message =
            format!("`{}` ranks nothing: it is no measure of counts with a better end", metric.name());
        return Err(source.error(rank.span(), message));
    }
    Ok(Table {
        name: wire.name.get_ref().clone(),
        caption: wire.caption.clone(),
        rows: Side::Metrics(Vec::new()),
        columns: Side::Tracker,
        metric: None,
        methods: read_methods(source, wire.methods.as_deref(), words)?,
        ranked: Some(metric),
        shows: None,
        column: None,
    })
}

/// Checks a `[[figure]]`.
pub fn read_figure(source: Source<'_>, wire: &wire::Figure, words: &Words) -> Result<Figure, SpecError> {
    check_file_name(source, &wire.name)?;
    let word = wire.kind.get_ref().as_str();
    if !FIGURE_KINDS.contains(&word) {
        return Err(source.unknown(wire.kind.span(), "figure kind", word, FIGURE_KINDS));
    }
    // A key that the kind does not look at would be a wish that nobody hears.
    let first = |list: &[Spanned<String>]| list.first().map(Spanned::span);
    let keys = [
        ("metric", "sweep curve", wire.metric.as_ref().map(Spanned::span)),
        ("x", "sweep curve", wire.x.as_ref().map(Spanned::span)),
        (
            "methods",
            "sweep curve delay",
            wire.methods.as_deref().map(|m| first(m).unwrap_or(wire.kind.span())),
        ),
        ("tracker", "strips", wire.tracker.as_ref().map(Spanned::span)),
        ("sequences", "strips", first(&wire.sequences)),
        ("panels", "strips", wire.panels.first().map(|row| first(row).unwrap_or(wire.kind.span()))),
        ("stills", "strips", wire.stills.as_ref().map(Spanned::span)),
        ("shows", "chart", wire.shows.as_ref().map(Spanned::span)),
    ];
    for (key, of, span) in keys {
        if let Some(span) = span.filter(|_| !of.split(' ').any(|of| of == word)) {
            return Err(source.error(span, format!("a `{word}` figure has no `{key}`")));
        }
    }
    let kind = match word {
        "strips" => {
            if let Some(t) = &wire.tracker
                && !words.trackers.contains(t.get_ref())
            {
                let known = words.trackers.iter().map(String::as_str);
                return Err(source.unknown(t.span(), "tracker", t.get_ref(), known));
            }
            for s in &wire.sequences {
                if !words.sequences.contains(s.get_ref()) {
                    let known = words.sequences.iter().map(String::as_str);
                    return Err(source.unknown(s.span(), "sequence", s.get_ref(), known));
                }
            }
            let stills = wire.stills.as_ref().map_or(0, |s| *s.get_ref());
            if stills > MOST_STILLS {
                let span = wire.stills.as_ref().map_or(wire.name.span(), Spanned::span);
                return Err(source.error(span, format!("`stills` must be 0 to {MOST_STILLS}, not {stills}")));
            }
            if wire.panels.is_empty() || wire.panels.iter().any(Vec::is_empty) {
                return Err(source.error(
                    wire.name.span(),
                    "a `strips` figure needs `panels`, and none of its rows is empty",
                ));
            }
            let mut panels = Vec::new();
            for row in &wire.panels {
                panels.push(row.iter().map(|p| read_panel(source, p, words)).collect::<Result<Vec<_>, _>>()?);
            }
            FigureKind::Strips {
                tracker: wire.tracker.as_ref().map(|t| t.get_ref().clone()),
                sequences: wire.sequences.iter().map(|s| s.get_ref().clone()).collect(),
                panels,
                stills,
            }
        }
        "sweep" | "curve" => {
            let (Some(m), Some(x)) = (&wire.metric, &wire.x) else {
                let message = format!("a `{word}` figure needs `metric` and `x`");
                return Err(source.error(wire.name.span(), message));
            };
            let methods = read_methods(source, wire.methods.as_deref(), words)?;
            let y = metric(source, m)?;
            match word {
                "sweep" => FigureKind::Sweep { metric: y, x: axis(source, x, words)?, methods },
                _ => FigureKind::Curve { y, x: metric(source, x)?, methods },
            }
        }
        "delay" => {
            let methods = read_methods(source, wire.methods.as_deref(), words)?;
            let has_grid = |m: &&Spanned<String>| !words.drawn.contains(m.get_ref());
            if let Some(wrong) = wire.methods.iter().flatten().find(has_grid) {
                let message =
                    format!("`{}` has a grid; delays are drawn of methods without one", wrong.get_ref());
                return Err(source.error(wrong.span(), message));
            }
            FigureKind::Delay { methods: methods.into_iter().filter(|m| words.drawn.contains(m)).collect() }
        }
        "machine" => FigureKind::Machine,
        _ => {
            let Some(shows) = &wire.shows else {
                return Err(source.error(wire.name.span(), "a `chart` figure needs `shows`"));
            };
            let made = words.made(shows.get_ref(), |n| &n.charts);
            FigureKind::Chart(made.map_err(|e| source.error(shows.span(), e))?)
        }
    };
    Ok(Figure { name: wire.name.get_ref().clone(), caption: wire.caption.clone(), kind })
}

/// Refuses a name that is not safe as a file name everywhere.
pub(super) fn check_file_name(source: Source<'_>, name: &Spanned<String>) -> Result<(), SpecError> {
    if is_word(name.get_ref()) {
        return Ok(());
    }
    Err(source.error(name.span(), format!("`{}` must be made of a-z, 0-9, `-` and `_`", name.get_ref())))
}

/// Whether a name is safe as a file name everywhere: `a-z`, `0-9`, `-`, `_`, at most 64 characters.
pub fn is_word(name: &str) -> bool {
    (1..=64).contains(&name.len())
        && name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-' || b == b'_')
}
