//! The head of a page: the figure and the table that show what its verdict says, beside each other where the table has
//! room there.

use super::page::{FigureView, Page};
use crate::table::layout::{self, Cell, Label, LabelKind, TableLayout};
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::figure::Figure;
use trackfail_engine::spec::table::{Side, Table};
use trackfail_methods::score::Metric;

/// Name of the figure of all methods with their intervals.
pub const HEADLINE: &str = "headline";

/// Room for a table beside a figure on a screen of 1400 pixels, in pixels.
const ROOM: f64 = 700.0;
/// Most width of a heading of rows, in pixels; longer ones are broken.
const MAX_HEADING: f64 = 288.0;
/// Least width of a column without its padding, and that padding, in pixels.
const COLUMN: (f64, f64) = (64.0, 15.0);
/// Width of a letter of a heading, of a number, and of the small text below a number, in pixels.
const LETTERS: [f64; 3] = [11.0, 10.4, 7.8];

/// Whether a figure shows a metric: along its curves or, for F, by lines of equal F.
fn shows(figure: &Figure, metric: Metric) -> bool {
    let [y, x] = [figure.params.metric, figure.params.x_metric];
    let is_curve = ["sweep", "curve"].contains(&figure.kind.word);
    let has_iso_f = [x, y] == [Some(Metric::RECALL), Some(Metric::PRECISION)] && metric == Metric::F_SCORE;
    is_curve && (y == Some(metric) || has_iso_f)
}

/// Whether methods have at least half of the best ones, one for each tracker.
fn has_most(methods: &[String], best: &[String]) -> bool {
    2 * best.iter().filter(|method| methods.contains(method)).count() >= best.len()
}

/// Puts the figure that answers the page's question at the head. For methods it is the curve of the verdict's metric with the
/// best of them, or else the figure of all of them with their intervals; for readings it is the first of theirs; otherwise the first
/// figure stays.
pub fn figure_first(
    figures: &mut [FigureView],
    experiment: &Experiment,
    (metric, best): (Option<Metric>, &[String]),
    is_about_readings: bool,
) {
    let of_file = |file: &str| {
        let is_it = |f: &&Figure| file == format!("figures/{}.svg", f.name);
        experiment.figures.iter().find(is_it)
    };
    let own = experiment.figures.len();
    let place = if is_about_readings {
        (figures.len() > own).then_some(own)
    } else if experiment.methods.is_empty() {
        None
    } else {
        let headline = format!("figures/{HEADLINE}");
        let place = figures.iter().position(|f| {
            metric
                .zip(of_file(&f.file))
                .is_some_and(|(m, f)| shows(f, m) && has_most(&f.params.methods, best))
        });
        place.or_else(|| figures.iter().position(|f| f.file.starts_with(&headline)))
    };
    if let Some(place) = place.filter(|place| *place < figures.len()) {
        figures[..=place].rotate_right(1);
    }
}

/// Whether a table has a metric of methods.
fn has(table: &Table, metric: Metric) -> bool {
    let of_rows = matches!(&table.rows, Side::Metrics(metrics) if metrics.contains(&metric));
    table.shows.is_none() && (of_rows || table.metric == Some(metric) || table.ranked == Some(metric))
}

/// The table of an experiment that shows its metric for most of its methods without anchors, with its place among its
/// tables; the first of equal ones.
fn main_table(experiment: &Experiment, metric: Metric) -> Option<(usize, &Table)> {
    let competing =
        |t: &Table| t.methods.iter().filter(|method| !layout::is_anchor(experiment, method)).count();
    let with = experiment.tables.iter().enumerate().filter(|(_, t)| has(t, metric));
    with.rev().max_by_key(|(_, t)| competing(t))
}

/// Puts the table with the verdict's metric at the head: the experiment's own one or, where that lacks most of the methods in
/// `best` (one for each tracker), that of the ranked methods with their intervals. The experiment's own tables are the
/// first of the page.
pub fn table_first(
    page: &mut Page,
    experiment: &Experiment,
    metric: Metric,
    (ranked, best): (Option<TableLayout>, &[String]),
) {
    // Trackers are compared by the tables that the experiment has of them, and one that begins with the table of an analysis
    // is about that.
    let begins_with_analysis = experiment.tables.first().is_some_and(|t| t.shows.is_some());
    if experiment.methods.is_empty() || begins_with_analysis {
        return;
    }
    let main = main_table(experiment, metric);
    match (main, ranked) {
        (Some((k, table)), _) if k < page.tables.len() && has_most(&table.methods, best) => {
            page.tables[..=k].rotate_right(1);
        }
        (_, Some(ranked)) if !best.is_empty() => page.tables.insert(0, ranked),
        _ => {}
    }
}

/// Whether a table has room beside a figure, by the letters of what it shows.
pub fn fits_beside(table: &TableLayout) -> bool {
    let is_result = |label: &Label| label.kind == LabelKind::Result;
    let all = !table.columns.iter().any(is_result);
    let shown = (0..table.columns.len()).filter(|k| all || is_result(&table.columns[*k]));
    let [heading, number, small] = LETTERS;
    let letters = |text: &str| text.chars().count() as f64;
    let rows = || table.groups.iter().flat_map(|g| &g.rows);
    let of_cell = |cell: &Cell| {
        let ours = cell.ours.as_deref().map_or(0.0, |text| number * letters(text));
        let below = [("published ", &cell.published), ("difference ", &cell.difference)];
        let below =
            below.map(|(word, text)| text.as_ref().map_or(0.0, |t| small * (letters(word) + letters(t))));
        below.into_iter().fold(ours, f64::max)
    };
    let width = |k: usize| {
        let words = table.columns[k].shown.split_whitespace().map(|word| heading * letters(word));
        let cells = rows().filter_map(|row| row.cells.get(k)).map(of_cell);
        words.chain(cells).fold(COLUMN.0, f64::max) + COLUMN.1
    };
    let names = rows()
        .filter(|row| row.label.kind == LabelKind::Result)
        .map(|row| heading * letters(&row.label.shown));
    let first = names.fold(heading * letters(&table.corner), f64::max).min(MAX_HEADING);
    first + COLUMN.1 + shown.map(width).sum::<f64>() <= ROOM
}

#[cfg(test)]
mod tests;
