//! Figures as an experiment asks for them: the list of kinds, and the keys that each kind reads.
//!
//! A kind is one line in [`FIGURE_KINDS`], which declares its word and its keys, and one file with one line in the
//! list of drawers of the report, which draws it; a test there ties both lists together. Every key has one reader
//! here, whichever kinds take it, so a kind needs code here only when it brings a key of its own.

mod panel;

pub use panel::Panel;

use super::error::{Source, SpecError};
use super::name::check_file_name;
use super::table::{FindingName, Words, grid_axis, metric, read_methods};
use super::wire;
use crate::score::Metric;
use panel::read_panel;
use std::ops::Range;
use toml::Spanned;

/// A kind of figure: its word in experiment files and the keys it reads.
#[derive(Debug, PartialEq, Eq)]
pub struct FigureKind {
    /// The word an experiment file uses.
    pub word: &'static str,
    /// Content of the figure, in one line.
    pub summary: &'static str,
    /// Keys that must be given.
    pub required: &'static [FigureKey],
    /// Keys that may be left out. A key in neither list is refused.
    pub optional: &'static [FigureKey],
}

/// Every kind of figure.
pub const FIGURE_KINDS: &[FigureKind] = &[
    FigureKind {
        word: "strips",
        summary: "series over the frames of sequences, optionally below video frames",
        required: &[FigureKey::Panels],
        optional: &[FigureKey::Tracker, FigureKey::Sequences, FigureKey::Stills],
    },
    FigureKind {
        word: "sweep",
        summary: "a metric over a grid axis, a curve for each combination of the other axes",
        required: &[FigureKey::Metric, FigureKey::XAxis],
        optional: &[FigureKey::Methods],
    },
    FigureKind {
        word: "curve",
        summary: "one metric over another, a curve for each method with a grid, a point for each without",
        required: &[FigureKey::Metric, FigureKey::XMetric],
        optional: &[FigureKey::Methods],
    },
    FigureKind {
        word: "delay",
        summary: "the share of events found by a number of frames after them, a curve for each method without a grid",
        required: &[],
        optional: &[FigureKey::MethodsWithoutGrid],
    },
    FigureKind {
        word: "chart",
        summary: "a chart that an analysis makes",
        required: &[FigureKey::Shows],
        optional: &[],
    },
    FigureKind {
        word: "machine",
        summary: "the conditions of a tracker that ARTE follows, with the events that change them",
        required: &[],
        optional: &[],
    },
];

/// A key of a `[[figure]]`, with the meaning it has for a kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FigureKey {
    /// `metric`: the metric along y.
    Metric,
    /// `x`: a grid axis.
    XAxis,
    /// `x`: a metric.
    XMetric,
    /// `methods`: methods, with or without a grid; all when left out.
    Methods,
    /// `methods`: methods without a grid, whose series are kept frame by frame; all of these when left out.
    MethodsWithoutGrid,
    /// `tracker`: the label of a tracker.
    Tracker,
    /// `sequences`: sequences of the test suite.
    Sequences,
    /// `panels`: rows of panels.
    Panels,
    /// `stills`: a number of video frames.
    Stills,
    /// `shows`: a chart of an analysis.
    Shows,
}

/// A figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// File name.
    pub name: String,
    /// Text below the figure.
    pub caption: Option<String>,
    /// How wide it is in print.
    pub width: Width,
    /// Content of the figure.
    pub kind: &'static FigureKind,
    /// The checked keys.
    pub params: FigureParams,
}

/// How wide a figure is in print.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Width {
    /// One of the two columns of a page: 3.3 inches.
    Column,
    /// All the text of a page: 7 inches.
    #[default]
    Text,
}

impl Width {
    const ALL: [Self; 2] = [Self::Column, Self::Text];

    /// The word in experiment files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Column => "column",
            Self::Text => "text",
        }
    }

    /// Width in inches.
    pub fn inches(self) -> f64 {
        match self {
            Self::Column => 3.3,
            Self::Text => 7.0,
        }
    }

    /// Checks `width`, which every kind of figure reads.
    fn read(source: Source<'_>, wire: &wire::Figure) -> Result<Self, SpecError> {
        let Some(word) = &wire.width else { return Ok(Self::default()) };
        Self::ALL
            .into_iter()
            .find(|width| width.word() == word.get_ref())
            .ok_or_else(|| source.unknown(word.span(), "width", word.get_ref(), Self::ALL.map(Self::word)))
    }
}

/// The checked keys of a figure; those that its kind does not read are empty.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FigureParams {
    /// The metric along y.
    pub metric: Option<Metric>,
    /// The grid axis along x.
    pub x_axis: Option<String>,
    /// The metric along x.
    pub x_metric: Option<Metric>,
    /// The methods shown, in the experiment's order.
    pub methods: Vec<String>,
    /// Label of the tracker; the experiment's first one when `None`.
    pub tracker: Option<String>,
    /// Sequences side by side; the one with most events when empty.
    pub sequences: Vec<String>,
    /// Rows of panels.
    pub panels: Vec<Vec<Panel>>,
    /// Number of video frames.
    pub stills: usize,
    /// The chart of an analysis.
    pub shows: Option<FindingName>,
}

/// Maximum number of video frames above a strip figure.
const MAX_STILLS: usize = 12;

impl FigureKind {
    /// The kind with this word.
    pub fn from_word(word: &str) -> Option<&'static Self> {
        FIGURE_KINDS.iter().find(|kind| kind.word == word)
    }

    fn reads(&self, key: FigureKey) -> bool {
        self.required.contains(&key) || self.optional.contains(&key)
    }
}

impl FigureKey {
    const ALL: [Self; 10] = [
        Self::Metric,
        Self::XAxis,
        Self::XMetric,
        Self::Methods,
        Self::MethodsWithoutGrid,
        Self::Tracker,
        Self::Sequences,
        Self::Panels,
        Self::Stills,
        Self::Shows,
    ];

    /// The key in the experiment file.
    pub fn word(self) -> &'static str {
        match self {
            Self::Metric => "metric",
            Self::XAxis | Self::XMetric => "x",
            Self::Methods | Self::MethodsWithoutGrid => "methods",
            Self::Tracker => "tracker",
            Self::Sequences => "sequences",
            Self::Panels => "panels",
            Self::Stills => "stills",
            Self::Shows => "shows",
        }
    }

    /// Where the key's value is in the file; none where it is left out.
    fn place(self, wire: &wire::Figure) -> Option<Range<usize>> {
        let first = |list: &[Spanned<String>]| list.first().map(Spanned::span);
        match self {
            Self::Metric => wire.metric.as_ref().map(Spanned::span),
            Self::XAxis | Self::XMetric => wire.x.as_ref().map(Spanned::span),
            Self::Methods | Self::MethodsWithoutGrid => {
                wire.methods.as_deref().map(|m| first(m).unwrap_or(wire.kind.span()))
            }
            Self::Tracker => wire.tracker.as_ref().map(Spanned::span),
            Self::Sequences => first(&wire.sequences),
            Self::Panels => wire.panels.first().map(|row| first(row).unwrap_or(wire.kind.span())),
            Self::Stills => wire.stills.as_ref().map(Spanned::span),
            Self::Shows => wire.shows.as_ref().map(Spanned::span),
        }
    }

    /// Checks the key's value into `params`.
    fn read(
        self,
        source: Source<'_>,
        wire: &wire::Figure,
        words: &Words,
        params: &mut FigureParams,
    ) -> Result<(), SpecError> {
        match self {
            Self::Metric => params.metric = wire.metric.as_ref().map(|m| metric(source, m)).transpose()?,
            Self::XAxis => {
                params.x_axis = wire.x.as_ref().map(|x| grid_axis(source, x, words)).transpose()?;
            }
            Self::XMetric => params.x_metric = wire.x.as_ref().map(|x| metric(source, x)).transpose()?,
            Self::Methods => params.methods = read_methods(source, wire.methods.as_deref(), words)?,
            Self::MethodsWithoutGrid => params.methods = methods_without_grid(source, wire, words)?,
            Self::Tracker => {
                if let Some(wrong) = wire.tracker.as_ref().filter(|t| !words.trackers.contains(t.get_ref())) {
                    let known = words.trackers.iter().map(String::as_str);
                    return Err(source.unknown(wrong.span(), "tracker", wrong.get_ref(), known));
                }
                params.tracker = wire.tracker.as_ref().map(|t| t.get_ref().clone());
            }
            Self::Sequences => {
                if let Some(wrong) = wire.sequences.iter().find(|s| !words.sequences.contains(s.get_ref())) {
                    let known = words.sequences.iter().map(String::as_str);
                    return Err(source.unknown(wrong.span(), "sequence", wrong.get_ref(), known));
                }
                params.sequences = wire.sequences.iter().map(|s| s.get_ref().clone()).collect();
            }
            Self::Panels => {
                if wire.panels.iter().any(Vec::is_empty) {
                    let message = "a `strips` figure needs `panels`, and none of its rows is empty";
                    return Err(source.error(wire.name.span(), message));
                }
                let row = |row: &Vec<_>| row.iter().map(|p| read_panel(source, p, words)).collect();
                params.panels = wire.panels.iter().map(row).collect::<Result<_, _>>()?;
            }
            Self::Stills => {
                if let Some(wrong) = wire.stills.as_ref().filter(|s| *s.get_ref() > MAX_STILLS) {
                    let message = format!("`stills` must be 0 to {MAX_STILLS}, not {}", wrong.get_ref());
                    return Err(source.error(wrong.span(), message));
                }
                params.stills = wire.stills.as_ref().map_or(0, |s| *s.get_ref());
            }
            Self::Shows => {
                let finding = |s: &Spanned<String>| {
                    let name = words.finding(s.get_ref(), |n| &n.charts);
                    name.map_err(|e| source.error(s.span(), e.to_string()))
                };
                params.shows = wire.shows.as_ref().map(finding).transpose()?;
            }
        }
        Ok(())
    }
}

/// The methods without a grid that are listed, or all of these without a list.
fn methods_without_grid(
    source: Source<'_>,
    wire: &wire::Figure,
    words: &Words,
) -> Result<Vec<String>, SpecError> {
    let mut methods = read_methods(source, wire.methods.as_deref(), words)?;
    let has_grid = |m: &&Spanned<String>| !words.drawn.contains(m.get_ref());
    if let Some(wrong) = wire.methods.iter().flatten().find(has_grid) {
        let message = format!("`{}` has a grid; delays are drawn of methods without one", wrong.get_ref());
        return Err(source.error(wrong.span(), message));
    }
    methods.retain(|m| words.drawn.contains(m));
    Ok(methods)
}

/// Checks a `[[figure]]`.
///
/// # Errors
/// The first thing that is wrong: an unknown kind, a key that the kind does not read, one that it needs and that is
/// left out, or a wrong value.
pub fn read_figure(source: Source<'_>, wire: &wire::Figure, words: &Words) -> Result<Figure, SpecError> {
    check_file_name(source, &wire.name)?;
    let word = wire.kind.get_ref().as_str();
    let Some(kind) = FigureKind::from_word(word) else {
        let known = FIGURE_KINDS.iter().map(|kind| kind.word);
        return Err(source.unknown(wire.kind.span(), "figure kind", word, known));
    };
    // A key that the kind does not read would have no effect.
    let is_read = |key: FigureKey| FigureKey::ALL.iter().any(|k| k.word() == key.word() && kind.reads(*k));
    for key in FigureKey::ALL.into_iter().filter(|key| !is_read(*key)) {
        if let Some(place) = key.place(wire) {
            return Err(source.error(place, format!("a `{word}` figure has no `{}`", key.word())));
        }
    }
    if kind.required.iter().any(|key| key.place(wire).is_none()) {
        let keys: Vec<String> = kind.required.iter().map(|key| format!("`{}`", key.word())).collect();
        let message = format!("a `{word}` figure needs {}", keys.join(" and "));
        return Err(source.error(wire.name.span(), message));
    }
    let mut params = FigureParams::default();
    for key in FigureKey::ALL.into_iter().filter(|key| kind.reads(*key)) {
        key.read(source, wire, words, &mut params)?;
    }
    let width = Width::read(source, wire)?;
    Ok(Figure { name: wire.name.get_ref().clone(), caption: wire.caption.clone(), width, kind, params })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::read::parse;

    #[test]
    fn a_figure_is_as_wide_as_the_text_or_a_column() {
        let read = |width: &str| {
            let text = include_str!("../../../../experiments/sanmiguel2015/fig3.toml");
            let text = text.replace("kind = \"strips\"", &format!("kind = \"strips\"{width}"));
            let figures = parse("fig3.toml", &text).map(|e| e.figures);
            figures.map(|f| f[0].width).map_err(|e| e.to_string())
        };
        assert_eq!(read(""), Ok(Width::Text));
        assert_eq!(read("\nwidth = \"column\""), Ok(Width::Column));
        let wrong = read("\nwidth = \"colum\"").unwrap_err();
        assert!(wrong.contains("colum") && wrong.contains("`column`"), "{wrong}");
    }

    #[test]
    fn every_kind_has_a_word_of_its_own_and_no_key_twice() {
        for (i, kind) in FIGURE_KINDS.iter().enumerate() {
            assert!(FIGURE_KINDS[..i].iter().all(|other| other.word != kind.word), "{}", kind.word);
            let keys: Vec<&str> = kind.required.iter().chain(kind.optional).map(|k| k.word()).collect();
            assert!((1..keys.len()).all(|k| !keys[..k].contains(&keys[k])), "{}", kind.word);
        }
    }
}
