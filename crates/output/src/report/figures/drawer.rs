//! Types that all drawers share: their entry, their input and their result.

use crate::figure::{FigureError, Plot};
use crate::results::{Results, ResultsError, TrackSeries};
use crate::sampling::Units;
use trackfail_engine::spec::figure::{Figure, FigureParams};

/// Draws the figures of one kind.
pub struct Drawer {
    /// The word of its kind in experiment files.
    pub word: &'static str,
    /// Whether it draws from tracks.
    pub shows_tracks: bool,
    /// Draws one figure.
    pub draw: fn(&Scope<'_>) -> Result<Drawing, DrawError>,
}

/// Input of a drawer.
pub struct Scope<'r> {
    /// The experiment's results.
    pub results: &'r Results,
    /// Its tracks, from [`Results::all_tracks`], for drawers that show some.
    pub tracks: &'r [TrackSeries],
    /// Counts by sequence, from [`Results::scores`].
    pub units: &'r Units,
    /// The figure that is asked for.
    pub figure: &'r Figure,
    /// Which data there is: `suite d1: 12 of 21 targets`.
    pub note: String,
}

impl<'r> Scope<'r> {
    /// The figure's checked keys.
    pub fn params(&self) -> &'r FigureParams {
        &self.figure.params
    }

    /// The value of a key that the figure's kind requires.
    ///
    /// # Errors
    /// When it is left out, which the check of the experiment rules out.
    pub fn given<'p, T>(&self, key: &'static str, value: Option<&'p T>) -> Result<&'p T, DrawError> {
        value.ok_or_else(|| DrawError::Key { name: self.figure.name.clone(), key })
    }
}

/// Result of a drawer.
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
    pub fn of(plot: impl Plot + 'static) -> Self {
        Self::Plot { plot: Box::new(plot), remark: String::new() }
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
