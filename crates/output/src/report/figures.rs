//! The figures an experiment asks for, drawn from its results.
//!
//! Every kind is a file below and a line in [`DRAWERS`]; what its word is and which keys it reads is a line in
//! [`FIGURE_KINDS`](trackfail_engine::spec::figure::FIGURE_KINDS), because experiment files are checked without results.

mod bands;
mod chart;
mod curve;
mod delay;
mod drawer;
mod lines;
mod machine;
mod panels;
pub(super) mod published;
mod strips;
mod sweep;

pub use drawer::{DrawError, Drawer, Drawing, Scope};

use crate::figure::{Files, PER_INCH};
use crate::results::{Results, TrackSeries};
use crate::sampling::Units;
use crate::table;
use trackfail_engine::spec::figure::Figure;

/// A drawer for every kind of figure.
pub const DRAWERS: &[Drawer] =
    &[strips::DRAWER, sweep::DRAWER, curve::DRAWER, delay::DRAWER, chart::DRAWER, machine::DRAWER];

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
pub fn show_tracks(figures: &[Figure]) -> bool {
    let shows = |figure: &Figure| DRAWERS.iter().any(|d| d.word == figure.kind.word && d.shows_tracks);
    figures.iter().any(shows)
}

/// Draws one figure; `tracks` are those of [`Results::all_tracks`], `units` the counts of [`Results::scores`].
///
/// # Errors
/// When results cannot be read or the drawing fails.
pub fn draw(
    results: &Results,
    tracks: &[TrackSeries],
    units: &Units,
    figure: &Figure,
) -> Result<FigureOutcome, DrawError> {
    let note = table::data_note(&results.experiment, &results.manifest);
    let note = format!("suite {}: {note}", results.manifest.suite.name);
    let (name, kind) = (figure.name.clone(), figure.kind.word);
    let Some(drawer) = DRAWERS.iter().find(|d| d.word == kind) else {
        return Err(DrawError::Kind { name, kind });
    };
    let scope = Scope { results, tracks, units, figure, note };
    let (plot, remark) = match (drawer.draw)(&scope)? {
        Drawing::Plot { plot, remark } => (plot, remark),
        Drawing::NoData(reason) => return Ok(FigureOutcome::NoData(reason)),
    };
    let fail = |error| DrawError::Figure { name: name.clone(), error };
    let files = plot.draw(figure.width.inches() * PER_INCH).map_err(fail)?;
    let caption = format!("{} ({}.{remark})", figure.caption.as_deref().unwrap_or(&name), scope.note);
    Ok(FigureOutcome::Drawn(DrawnFigure { name, caption, files }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_engine::spec::figure::FIGURE_KINDS;

    #[test]
    fn every_kind_of_figure_has_a_drawer() {
        assert!(FIGURE_KINDS.iter().map(|k| k.word).eq(DRAWERS.iter().map(|d| d.word)));
    }
}
