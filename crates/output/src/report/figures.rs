//! Figures of an experiment, drawn from its results.
//!
//! Each kind is a line in `DRAWERS`. Its word and keys are declared in
//! [`FIGURE_KINDS`](trackfail_engine::spec::figure::FIGURE_KINDS), because experiment files are checked
//! without results.

mod analysis;
pub(super) mod lines;
mod machine;
mod metrics;
pub(super) mod published;
mod radar;
mod strips;

use super::page::ReportError;
use super::standings::Estimate;
use crate::figure::{Figure, Files, Mark, PER_INCH, WIDTH};
use crate::results::{Measure, Results, TrackSeries};
use crate::sampling::{Units, metric_of_sum};
use crate::table;
use trackfail_engine::spec::figure as spec;
use trackfail_methods::score::Metric;
use trackfail_methods::score::metric::Source;

/// Draws a figure of one kind. The text is appended to its caption: sentences with a blank before each, or
/// nothing.
type Draw = fn(&Scope<'_>) -> Result<(Figure, String), ReportError>;

/// Drawers of all kinds of figures, by their words in experiment files.
const DRAWERS: &[(&str, Draw)] = &[
    ("strips", strips::draw),
    ("sweep", metrics::sweep),
    ("curve", metrics::curve),
    ("delay", metrics::delay),
    ("warning", metrics::warning),
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
    /// Tracks of [`Results::all_tracks`]; empty unless the drawer needs them.
    tracks: &'r [TrackSeries],
    /// Counts by sequence, from [`Results::scores`].
    units: &'r Units,
    /// Figure as the experiment defines it.
    figure: &'r spec::Figure,
    /// Data behind the figure: `suite d1: 12 of 21 targets`.
    note: String,
}

impl Scope<'_> {
    /// Index of a tracker in the experiment, which decides its color on all pages.
    fn place(&self, tracker: &str) -> Option<usize> {
        self.results.experiment.trackers.iter().position(|t| t.label == tracker)
    }

    /// Value of a key that the kind of figure requires.
    ///
    /// # Errors
    /// When the key is left out, which the check of the experiment excludes.
    fn given<'p, T>(&self, key: &str, value: Option<&'p T>) -> Result<&'p T, ReportError> {
        value.ok_or_else(|| ReportError::Unfit(format!("figure {} has no `{key}`", self.figure.name)))
    }

    /// Bounds of a metric's value by bootstrap over sequences; NaN for metrics that are not made of counts,
    /// and with few sequences.
    fn bounds(&self, measure: &Measure, metric: Metric) -> (f64, f64) {
        let counts = self.units.of_measure(measure).filter(|_| metric.source == Source::Counts);
        let chance = self.results.experiment.chance_of(&measure.method);
        let of = |sum: &[i64; 4]| metric_of_sum(metric, chance, sum);
        let bounds = counts.and_then(|counts| Estimate::of_counts(counts, of, &self.units.sampling).bounds);
        bounds.unwrap_or((f64::NAN, f64::NAN))
    }
}

/// The figure with its remark; an error with this reason if none of its curves has a value.
fn of_curves(figure: Figure, remark: &str, reason: String) -> Result<(Figure, String), ReportError> {
    let marks = || figure.rows.iter().flatten().flat_map(|panel| &panel.marks);
    let has_point = |mark: &Mark| match mark {
        Mark::Line { points, .. } => points.iter().any(|p| p.0.is_finite() && p.1.is_finite()),
        _ => false,
    };
    if !marks().any(has_point) {
        return Err(ReportError::NoData(reason));
    }
    let has_bands = marks().any(|mark| matches!(mark, Mark::Band(..)));
    let of_bands = " Bands are 95 % intervals, point by point, by bootstrap over sequences.";
    let remark = format!("{}{remark}", if has_bands { of_bands } else { "" });
    Ok((figure, remark))
}

/// A figure of a report with its caption.
#[derive(Debug, Clone, PartialEq)]
pub struct Captioned {
    /// Name of the figure and of its files.
    pub name: String,
    /// The figure.
    pub figure: Figure,
    /// Caption, including the data behind the figure.
    pub caption: String,
    /// Width in units.
    pub width: f64,
}

impl Captioned {
    /// A figure at the text width of a page.
    pub fn new(name: String, figure: Figure, caption: String) -> Self {
        Self { name, figure, caption, width: WIDTH }
    }

    /// Draws the figure in all formats.
    ///
    /// # Errors
    /// When the drawing fails.
    pub fn draw(&self) -> Result<Files, ReportError> {
        let drawn = self.figure.draw(self.width);
        drawn.map_err(|e| ReportError::Unfit(format!("figure {}: {e}", self.name)))
    }
}

/// True if one of the figures is drawn from tracks.
pub fn show_tracks(figures: &[spec::Figure]) -> bool {
    figures.iter().any(|figure| OF_TRACKS.contains(&figure.kind.word))
}

/// Draws a figure of an experiment; `tracks` come from [`Results::all_tracks`], `units` has the counts of
/// [`Results::scores`].
///
/// # Errors
/// When there are no data for the figure, or results cannot be read.
pub fn make(
    results: &Results,
    tracks: &[TrackSeries],
    units: &Units,
    figure: &spec::Figure,
) -> Result<Captioned, ReportError> {
    let note = table::data_note(&results.experiment, &results.manifest);
    let note = format!("suite {}: {note}", results.manifest.suite.name);
    let (name, kind) = (figure.name.clone(), figure.kind.word);
    let Some((_, drawer)) = DRAWERS.iter().find(|(word, _)| *word == kind) else {
        return Err(ReportError::Unfit(format!("figure {name}: nothing draws the kind `{kind}`")));
    };
    let scope = Scope { results, tracks, units, figure, note };
    let (drawn, remark) = drawer(&scope)?;
    let caption = format!("{} ({}.{remark})", figure.caption.as_deref().unwrap_or(&name), scope.note);
    Ok(Captioned { width: figure.width.inches() * PER_INCH, ..Captioned::new(name, drawn, caption) })
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
