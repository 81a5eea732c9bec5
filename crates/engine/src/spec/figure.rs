//! Figures of an experiment: the list of kinds, and the keys that each kind reads.
//!
//! A kind is declared in [`FIGURE_KINDS`] with its word and keys, and drawn by one file that is listed in the
//! report's drawers; a test there compares both lists. Each key has one reader here for all kinds, so a kind
//! needs code here only if it has a new key.

use super::error::{At, MAX_WORD};
use super::limits::MAX_PARTS;
use super::name::check_file_name;
use super::table::{FindingName, Words, all_known, grid_axis, read_methods, read_shows};
use super::width::Width;
use super::wire;
use std::collections::BTreeSet;
use trackfail_dataset::text::shorten_to;
use trackfail_methods::score::Metric;

/// A kind of figure: its word in experiment files and the keys it reads.
#[derive(Debug, PartialEq, Eq)]
pub struct FigureKind {
    /// Name of the kind in experiment files.
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
        word: "warning",
        summary: "AUROC of a loss within the next frames, over their number, a curve for each method without a grid",
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
        word: "radar",
        summary: "a column of a table that an analysis makes, a spoke for each row, a polygon for each of the eight best trackers",
        required: &[FigureKey::ShowsTable, FigureKey::Column],
        optional: &[],
    },
    FigureKind {
        word: "machine",
        summary: "the conditions of a tracker that ARTE follows, with the events that change them",
        required: &[],
        optional: &[],
    },
];

/// A key of a `[[figure]]`. A key of several meanings has several variants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FigureKey {
    /// `metric`: the metric along y.
    Metric,
    /// `x`: a grid axis.
    XAxis,
    /// `x`: a metric.
    XMetric,
    /// `methods`: methods, with or without a grid; all if left out.
    Methods,
    /// `methods`: methods without a grid; all of these if left out.
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
    /// `shows`: a table of an analysis.
    ShowsTable,
    /// `column`: a column of that table.
    Column,
}

/// A figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// File name.
    pub name: String,
    /// Text below the figure.
    pub caption: Option<String>,
    /// Width in print.
    pub width: Width,
    /// Kind of figure, which decides how it is drawn.
    pub kind: &'static FigureKind,
    /// The checked keys.
    pub params: FigureParams,
}

/// Checked keys of a figure. Those that its kind does not read are empty.
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
    /// Label of the tracker; `None` for the experiment's first one.
    pub tracker: Option<String>,
    /// Sequences side by side; empty for the one with most events.
    pub sequences: Vec<String>,
    /// Rows of panels.
    pub panels: Vec<Vec<Panel>>,
    /// Number of video frames.
    pub stills: usize,
    /// Chart or table of an analysis.
    pub shows: Option<FindingName>,
    /// Column of that table.
    pub column: Option<String>,
}

/// Content of one panel of a strip figure, such as `score:DTEF+RAW`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Panel {
    /// Overlap error O_t.
    Error,
    /// Signal of a method.
    Signal(String),
    /// Signal of a method, with its forecast.
    Forecast(String),
    /// Scores of one or more methods, with their thresholds.
    Score(Vec<String>),
    /// Labels of one or more methods, one lane each.
    Labels(Vec<String>),
    /// Condition of the tracker, as one or more methods estimate it.
    Condition(Vec<String>),
}

/// Most video frames above a strip figure.
const MAX_STILLS: usize = 12;

impl FigureKind {
    /// The kind with this word.
    pub fn from_word(word: &str) -> Option<&'static Self> {
        FIGURE_KINDS.iter().find(|kind| kind.word == word)
    }

    fn keys(&self) -> impl Iterator<Item = &FigureKey> {
        self.required.iter().chain(self.optional)
    }

    /// Keys of the file that this kind does not read but others do.
    pub(super) fn unread(&self) -> impl Iterator<Item = &'static str> {
        let words = |kind: &Self| kind.keys().map(|key| key.word()).collect::<BTreeSet<_>>();
        let (mine, mut all) = (words(self), BTreeSet::new());
        FIGURE_KINDS.iter().for_each(|kind| all.extend(words(kind)));
        all.into_iter().filter(move |word| !mine.contains(word))
    }
}

impl FigureKey {
    /// Name of the key in experiment files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Metric => "metric",
            Self::XAxis | Self::XMetric => "x",
            Self::Methods | Self::MethodsWithoutGrid => "methods",
            Self::Tracker => "tracker",
            Self::Sequences => "sequences",
            Self::Panels => "panels",
            Self::Stills => "stills",
            Self::Shows | Self::ShowsTable => "shows",
            Self::Column => "column",
        }
    }

    /// Checks the value of the key and stores it in `params`.
    fn read(self, at: At<'_>, wire: &wire::Figure, words: &Words, params: &mut FigureParams) {
        let given = at.key(self.word());
        match self {
            Self::Metric => params.metric = wire.metric.as_deref().and_then(Metric::from_name),
            Self::XAxis => params.x_axis = wire.x.as_deref().and_then(|x| grid_axis(given, x, words)),
            Self::XMetric => {
                params.x_metric = wire.x.as_deref().and_then(Metric::from_name);
                if let (Some(x), None) = (&wire.x, params.x_metric) {
                    given.tell(Metric::unknown(&shorten_to(x, MAX_WORD)));
                }
            }
            Self::Methods => params.methods = read_methods(at, wire.methods.as_deref(), words),
            Self::MethodsWithoutGrid => {
                params.methods = read_methods(at, wire.methods.as_deref(), words);
                for (index, name) in wire.methods.iter().flatten().enumerate() {
                    if words.methods.contains(name) && !words.drawn.contains(name) {
                        let message =
                            format!("`{name}` has a grid; this kind of figure shows methods without one");
                        given.item(index).tell(message);
                    }
                }
                params.methods.retain(|m| words.drawn.contains(m));
            }
            Self::Tracker => {
                all_known(given, "tracker", wire.tracker.as_slice(), &words.trackers);
                params.tracker = wire.tracker.clone();
            }
            Self::Sequences => {
                if !words.sequences.is_empty() {
                    all_known(given, "sequence", &wire.sequences, &words.sequences);
                }
                params.sequences = wire.sequences.clone();
            }
            Self::Panels => {
                let panels = wire.panels.iter().map(Vec::len).sum::<usize>();
                if wire.panels.iter().any(Vec::is_empty) || panels > MAX_PARTS {
                    at.key("name").tell(format!(
                        "a `strips` figure needs `panels`, at most {MAX_PARTS}, and none of its rows is empty"
                    ));
                    return;
                }
                for (k, row) in wire.panels.iter().enumerate() {
                    let at = given.item(k);
                    let panels = row.iter().enumerate();
                    let panels = panels.filter_map(|(k, text)| read_panel(at.item(k), text, words));
                    params.panels.push(panels.collect());
                }
            }
            Self::Stills => {
                params.stills = wire.stills.unwrap_or(0);
                if params.stills > MAX_STILLS {
                    given.tell(format!("`stills` must be 0 to {MAX_STILLS}, not {}", params.stills));
                }
            }
            Self::Shows => params.shows = read_shows(at, wire.shows.as_ref(), words, |names| &names.charts),
            Self::ShowsTable => {
                params.shows = read_shows(at, wire.shows.as_ref(), words, |names| &names.tables)
            }
            Self::Column => params.column = wire.column.clone(),
        }
    }
}

impl Figure {
    /// Figure of an experiment that defines no tables and figures: recall over precision if a method has a
    /// grid, otherwise the delay of detections. `None` if no method reads a signal.
    pub(super) fn of_methods(words: &Words) -> Option<Self> {
        let has_grid = words.methods.iter().any(|method| !words.drawn.contains(method));
        let (name, word, params) = if has_grid {
            let (metric, x_metric) = (Some(Metric::PRECISION), Some(Metric::RECALL));
            let params =
                FigureParams { metric, x_metric, methods: words.methods.clone(), ..FigureParams::default() };
            ("precision-recall", "curve", params)
        } else if words.with_signal.is_empty() {
            return None;
        } else {
            ("delay", "delay", FigureParams { methods: words.drawn.clone(), ..FigureParams::default() })
        };
        let kind = FigureKind::from_word(word)?;
        Some(Self { name: name.to_string(), caption: None, width: Width::default(), kind, params })
    }

    /// Checks a `[[figure]]`: keys that its kind does not read, missing keys, and values.
    pub(super) fn read(at: At<'_>, wire: &wire::Figure, words: &Words) -> Option<Self> {
        check_file_name(at.key("name"), &wire.name);
        let width = wire.width.as_deref().and_then(Width::from_word).unwrap_or_default();
        let kind = FigureKind::from_word(&wire.kind)?;
        // A key that the kind does not read would have no effect.
        for key in kind.unread().filter(|key| at.has(key)) {
            at.key(key).tell(format!("a `{}` figure has no `{key}`", kind.word));
        }
        let is_empty = |key: &FigureKey| *key == FigureKey::Panels && wire.panels.is_empty();
        if kind.required.iter().any(|key| !at.has(key.word()) || is_empty(key)) {
            let keys: Vec<String> = kind.required.iter().map(|key| format!("`{}`", key.word())).collect();
            at.key("name").tell(format!("a `{}` figure needs {}", kind.word, keys.join(" and ")));
        }
        let mut params = FigureParams::default();
        for key in kind.keys() {
            key.read(at, wire, words, &mut params);
        }
        Some(Self { name: wire.name.clone(), caption: wire.caption.clone(), width, kind, params })
    }
}

/// Checks a panel of a figure.
fn read_panel(at: At<'_>, text: &str, words: &Words) -> Option<Panel> {
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    let is_in = |list: &[String], name: &str| list.iter().any(|known| known == name);
    let method = |name: &str| {
        if !is_in(&words.methods, name) {
            at.tell_unknown("method", name, words.methods.iter().map(String::as_str));
        } else if !is_in(&words.drawn, name) {
            at.tell(format!("`{name}` has a grid; only methods without one can be drawn over frames"));
        }
        name.to_string()
    };
    let signal = |name: &str| {
        if is_in(&words.drawn, name) && !is_in(&words.with_signal, name) {
            at.tell(format!("`{name}` reads no signal that could be drawn"));
        }
        method(name)
    };
    let methods = || rest.split('+').map(method).collect();
    Some(match kind {
        "error" if rest.is_empty() => Panel::Error,
        "signal" => Panel::Signal(signal(rest)),
        "forecast" => Panel::Forecast(signal(rest)),
        "score" => Panel::Score(methods()),
        "labels" => Panel::Labels(methods()),
        "condition" => Panel::Condition(methods()),
        _ => {
            let known = ["error", "signal", "forecast", "score", "labels", "condition"];
            at.tell_unknown("panel", kind, known);
            return None;
        }
    })
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
            parse("fig3.toml", &text).unwrap().figures[0].width
        };
        assert_eq!([read(""), read("\nwidth = \"column\"")], [Width::Text, Width::Column]);
    }

    #[test]
    fn a_radar_shows_a_column_of_a_table_and_no_chart() {
        let read = |shown: &str| {
            let text = include_str!("../../../../experiments/compare/vot2014.toml");
            let radar = "shows = \"resets.attributes\"\ncolumn = \"accuracy\"\n\n# Results";
            assert_eq!(text.matches(radar).count(), 1);
            let text = text.replace(radar, &format!("{shown}\n\n# Results"));
            let params = |e: crate::spec::Experiment| e.figures.last().map(|f| f.params.clone());
            parse("vot2014.toml", &text).map(params).map_err(|e| e.to_string())
        };
        let shown = read("shows = \"exact.attributes\"\ncolumn = \"failures\"").unwrap().unwrap();
        assert_eq!(shown.shows.map(|s| s.to_string()).as_deref(), Some("exact.attributes"));
        assert_eq!(shown.column.as_deref(), Some("failures"));
        let wrong = read("shows = \"resets.expected-overlap\"\ncolumn = \"failures\"").unwrap_err();
        assert!(wrong.contains("resets.expected-overlap"), "{wrong}");
        let wrong = read("shows = \"resets.attributes\"").unwrap_err();
        assert!(wrong.contains("a `radar` figure needs `shows` and `column`"), "{wrong}");
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
