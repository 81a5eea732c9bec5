//! The figures an experiment asks for, drawn from its results.
//!
//! Every kind is a file below and a line in [`DRAWERS`]; what its word is and which keys it reads is a line in
//! [`FIGURE_KINDS`](crate::spec::figure::FIGURE_KINDS), because experiment files are checked without results.

mod chart;
mod curve;
mod delay;
mod lines;
mod machine;
mod panels;
mod strips;
mod sweep;

use crate::figure::{FigureError, Plot};
use crate::results::{Results, ResultsError};
use crate::spec::figure::{Figure, FigureParams};
use crate::table;

/// Draws the figures of one kind.
pub struct Drawer {
    /// The word of its kind in experiment files.
    pub word: &'static str,
    /// Draws one figure.
    pub draw: fn(&Scope<'_>) -> Result<Drawing, DrawError>,
}

/// A drawer for every kind of figure.
pub const DRAWERS: [Drawer; 6] =
    [strips::DRAWER, sweep::DRAWER, curve::DRAWER, delay::DRAWER, chart::DRAWER, machine::DRAWER];

/// What a drawer draws from.
pub struct Scope<'r> {
    /// The experiment's results.
    pub results: &'r Results,
    /// The figure that is asked for.
    pub figure: &'r Figure,
    /// Which data there is: `suite d1: 12 of 21 targets`.
    pub note: String,
}

impl<'r> Scope<'r> {
    /// The figure's checked keys.
    fn params(&self) -> &'r FigureParams {
        &self.figure.params
    }

    /// The value of a key that the figure's kind requires.
    fn given<'p, T>(&self, key: &'static str, value: Option<&'p T>) -> Result<&'p T, DrawError> {
        value.ok_or_else(|| DrawError::Key { name: self.figure.name.clone(), key })
    }
}

/// What a drawer makes.
pub enum Drawing {
    /// A figure.
    Plot {
        /// The figure.
        plot: Box<dyn Plot>,
        /// Sentences for the end of its caption, each behind a blank; may be empty.
        remark: String,
    },
    /// There is no data for it, for the reason given.
    NoData(String),
}

impl Drawing {
    /// A figure without a remark.
    fn of(plot: impl Plot + 'static) -> Self {
        Self::Plot { plot: Box::new(plot), remark: String::new() }
    }
}

/// A figure that was drawn.
pub struct DrawnFigure {
    /// Name, also of its files.
    pub name: String,
    /// Caption, with the data it rests on.
    pub caption: String,
    /// SVG text.
    pub svg: String,
    /// PNG bytes.
    pub png: Vec<u8>,
}

/// What became of a figure that an experiment asks for.
pub enum FigureOutcome {
    /// It was drawn.
    Drawn(DrawnFigure),
    /// There is no data for it, for the reason given.
    NoData(String),
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
        /// What went wrong.
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

/// Draws one figure.
///
/// # Errors
/// When results cannot be read or the drawing fails.
pub fn draw(results: &Results, figure: &Figure) -> Result<FigureOutcome, DrawError> {
    let note = table::data_note(&results.experiment, &results.manifest);
    let note = format!("suite {}: {note}", results.manifest.suite.name);
    let (name, kind) = (figure.name.clone(), figure.kind.word);
    let Some(drawer) = DRAWERS.iter().find(|d| d.word == kind) else {
        return Err(DrawError::Kind { name, kind });
    };
    let scope = Scope { results, figure, note };
    let (plot, remark) = match (drawer.draw)(&scope)? {
        Drawing::Plot { plot, remark } => (plot, remark),
        Drawing::NoData(reason) => return Ok(FigureOutcome::NoData(reason)),
    };
    let fail = |error| DrawError::Figure { name: name.clone(), error };
    let (svg, png) = (plot.to_svg().map_err(fail)?, plot.to_png().map_err(fail)?);
    let caption = format!("{} ({}.{remark})", figure.caption.as_deref().unwrap_or(&name), scope.note);
    Ok(FigureOutcome::Drawn(DrawnFigure { name, caption, svg, png }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::figure::FIGURE_KINDS;

    #[test]
    fn every_kind_of_figure_has_a_drawer() {
        assert!(FIGURE_KINDS.iter().map(|k| k.word).eq(DRAWERS.iter().map(|d| d.word)));
    }
}
