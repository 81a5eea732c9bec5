//! The figures an experiment asks for, drawn from its results.
//!
//! Every kind is a line in `DRAWERS`; what its word is and which keys it reads is a line in
//! [`FIGURE_KINDS`](trackfail_engine::spec::figure::FIGURE_KINDS), because experiment files are checked without results.

mod analysis;
mod bands;
mod lines;
mod machine;
mod metrics;
pub(super) mod published;
mod radar;
mod strips;
mod warning;

use crate::figure::{Figure, FigureError, Files, Mark, PER_INCH};
use crate::results::{Results, ResultsError, TrackSeries};
use crate::sampling::Units;
use crate::table;
use trackfail_engine::spec::figure as spec;

/// Draws a figure of one kind.
type Draw = fn(&Scope<'_>) -> Result<Drawing, DrawError>;

/// A drawer for every kind of figure, by its word in experiment files.
const DRAWERS: &[(&str, Draw)] = &[
    ("strips", strips::draw),
    ("sweep", metrics::sweep),
    ("curve", metrics::curve),
    ("delay", metrics::delay),
    ("warning", warning::draw),
    ("chart", analysis::draw),
    ("radar", radar::draw),
    ("machine", machine::draw),
];
/// Kinds that are drawn from tracks.
const OF_TRACKS: [&str; 2] = ["strips", "delay"];

/// Input of a drawer.
struct Scope<'r> {
    /// The experiment's results.
    results: &'r Results,
    /// Its tracks, from [`Results::all_tracks`], for drawers that show some.
    tracks: &'r [TrackSeries],
    /// Counts by sequence, from [`Results::scores`].
    units: &'r Units,
    /// The figure that is asked for.
    figure: &'r spec::Figure,
    /// Which data there is: `suite d1: 12 of 21 targets`.
    note: String,
}

impl<'r> Scope<'r> {
    /// The figure's checked keys.
    fn params(&self) -> &'r spec::FigureParams {
        &self.figure.params
    }

    /// The place of a tracker in the experiment, which gives its color on all pages of it.
    fn place(&self, tracker: &str) -> Option<usize> {
        self.results.experiment.trackers.iter().position(|t| t.label == tracker)
    }

    /// The value of a key that the figure's kind requires.
    ///
    /// # Errors
    /// When it is left out, which the check of the experiment rules out.
    fn given<'p, T>(&self, key: &'static str, value: Option<&'p T>) -> Result<&'p T, DrawError> {
        value.ok_or_else(|| DrawError::Key { name: self.figure.name.clone(), key })
    }
}

/// Result of a drawer.
enum Drawing {
    /// A figure, and sentences for the end of its caption, each behind a blank; may be empty.
    Figure(Box<Figure>, String),
    /// There is no data for it, for the reason given.
    NoData(String),
}

impl Drawing {
    /// The curves with the remark, or `reason` where none of them has a value.
    fn of_curves(figure: Figure, remark: &str, reason: String) -> Self {
        let marks = || figure.rows.iter().flatten().flat_map(|panel| &panel.marks);
        let has_point = |mark: &Mark| match mark {
            Mark::Line { points, .. } => points.iter().any(|p| p.0.is_finite() && p.1.is_finite()),
            _ => false,
        };
        if !marks().any(has_point) {
            return Self::NoData(reason);
        }
        let has_bands = marks().any(|mark| matches!(mark, Mark::Band(..)));
        let of_bands = " Bands are 95 % intervals, point by point, by bootstrap over sequences.";
        let remark = format!("{}{remark}", if has_bands { of_bands } else { "" });
        Self::Figure(Box::new(figure), remark)
    }
}

/// A figure that could not be drawn although there is data for it.
#[derive(Debug, thiserror::Error)]
pub enum DrawError {
    /// The results cannot be read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The drawing failed.
    #[error("figure {name}: {error}")]
    Figure {
        /// Name of the figure.
        name: String,
        /// Error of the drawing.
        error: FigureError,
    },
    /// A key that the kind of figure requires was not checked for.
    #[error("figure {name} has no `{key}`")]
    Key {
        /// Name of the figure.
        name: String,
        /// The key.
        key: &'static str,
    },
    /// No drawer has the word of the figure's kind.
    #[error("figure {name}: nothing draws the kind `{kind}`")]
    Kind {
        /// Name of the figure.
        name: String,
        /// Word of its kind.
        kind: &'static str,
    },
}

/// A figure that was drawn.
pub struct DrawnFigure {
    /// Name, also of its files.
    pub name: String,
    /// Caption, with the data it rests on.
    pub caption: String,
    /// The figure in all formats.
    pub files: Files,
}

/// Outcome of drawing a figure that an experiment asks for.
pub enum FigureOutcome {
    /// It was drawn.
    Drawn(DrawnFigure),
    /// There is no data for it, for the reason given.
    NoData(String),
}

/// Whether any of the figures is drawn from tracks.
pub fn show_tracks(figures: &[spec::Figure]) -> bool {
    figures.iter().any(|figure| OF_TRACKS.contains(&figure.kind.word))
}

/// Draws one figure; `tracks` are those of [`Results::all_tracks`], `units` the counts of [`Results::scores`].
///
/// # Errors
/// When results cannot be read or the drawing fails.
pub fn draw(
    results: &Results,
    tracks: &[TrackSeries],
    units: &Units,
    figure: &spec::Figure,
) -> Result<FigureOutcome, DrawError> {
    let note = table::data_note(&results.experiment, &results.manifest);
    let note = format!("suite {}: {note}", results.manifest.suite.name);
    let (name, kind) = (figure.name.clone(), figure.kind.word);
    let Some((_, drawer)) = DRAWERS.iter().find(|(word, _)| *word == kind) else {
        return Err(DrawError::Kind { name, kind });
    };
    let scope = Scope { results, tracks, units, figure, note };
    let (drawn, remark) = match drawer(&scope)? {
        Drawing::Figure(drawn, remark) => (drawn, remark),
        Drawing::NoData(reason) => return Ok(FigureOutcome::NoData(reason)),
    };
    let fail = |error| DrawError::Figure { name: name.clone(), error };
    let files = drawn.draw(figure.width.inches() * PER_INCH).map_err(fail)?;
    let caption = format!("{} ({}.{remark})", figure.caption.as_deref().unwrap_or(&name), scope.note);
    Ok(FigureOutcome::Drawn(DrawnFigure { name, caption, files }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_figure_has_a_drawer() {
        assert!(spec::FIGURE_KINDS.iter().map(|k| k.word).eq(DRAWERS.iter().map(|d| d.0)));
        assert!(OF_TRACKS.iter().all(|word| DRAWERS.iter().any(|d| d.0 == *word)));
    }
}
