//! `radar`: a column of a table by attribute, with one spoke for each attribute and one polygon for each of
//! the best trackers.
//!
//! The first spoke is the value over all attributes: the row `overall` of the table, or else the number of
//! the analysis. A spoke begins at 0 and ends at the largest value of the trackers shown, as in pysot
//! (`draw_eao`). A share of it is therefore relative to the best tracker if larger values are better, and to
//! the worst otherwise. The label shows both ends of the range.

use super::Scope;
use super::lines::{capitalized, distinct};
use crate::figure::{Entry, Figure, Form, Mark, Marker, Panel, Polygon, Radar, Style, Symbol};
use crate::report::page::ReportError;
use crate::report::standings::Measured;
use crate::table::leaderboard::better_first;
use crate::table::number;
use crate::table::suites::suites_note;
use trackfail_core::direction::Direction;
use trackfail_engine::execute::analyse::Analysed;
use trackfail_methods::analysis::Findings;
use trackfail_methods::score::TrackerMetric;

/// Most polygons.
const MAX_TRACKERS: usize = 8;
/// Least number of spokes of a radar chart.
const MIN_SPOKES: usize = 3;
/// Name of the row over all attributes.
const OVERALL: &str = "overall";

/// Draws the figure.
pub(super) fn draw(scope: &Scope<'_>) -> Result<(Figure, String), ReportError> {
    let shows = scope.given("shows", scope.figure.params.shows.as_ref())?;
    let column = scope.given("column", scope.figure.params.column.as_ref())?;
    let found: Vec<&Analysed> =
        scope.results.analyses.iter().filter(|a| a.analysis == shows.analysis).collect();
    let of_tracker = |(k, analysed): (usize, &&Analysed)| OfTracker {
        name: analysed.tracker.clone(),
        place: scope.place(&analysed.tracker).unwrap_or(k),
        values: values(&analysed.findings, &shows.part, column),
    };
    let note = found.first().map_or_else(String::new, |first| suites_note(first));
    let few =
        || ReportError::NoData(format!("{shows} has fewer than {MIN_SPOKES} rows with `{column}` here"));
    let figure = radar(&note, column, found.iter().enumerate().map(of_tracker).collect()).ok_or_else(few)?;
    Ok((figure, String::new()))
}

/// A tracker with its values by spoke.
struct OfTracker {
    name: String,
    /// Index among all trackers.
    place: usize,
    values: Vec<(String, f64)>,
}

impl OfTracker {
    fn value(&self, spoke: &str) -> Option<f64> {
        self.values.iter().find(|(name, _)| name == spoke).map(|(_, value)| *value)
    }
}

/// Values of a column by row, with that over all attributes first.
fn values(findings: &Findings, table: &str, column: &str) -> Vec<(String, f64)> {
    let Some(grid) = findings.tables.iter().find(|t| t.name == table) else { return Vec::new() };
    let Some(k) = grid.columns.iter().position(|known| known == column) else { return Vec::new() };
    let value = |(row, values): &(String, Vec<Option<f64>>)| Some((row.clone(), values.get(k).copied()??));
    let mut values: Vec<(String, f64)> = grid.rows.iter().filter_map(value).collect();
    if let Some(at) = values.iter().position(|(row, _)| row == OVERALL) {
        values[..=at].rotate_right(1);
    } else if let Some(all) = TrackerMetric::of_heading(column).and_then(|m| findings.number(m.name)) {
        values.insert(0, (OVERALL.to_string(), all));
    }
    values.retain(|(_, value)| value.is_finite());
    values
}

/// The figure; `None` if there are too few spokes.
fn radar(note: &str, column: &str, mut trackers: Vec<OfTracker>) -> Option<Figure> {
    trackers.retain(|t| !t.values.is_empty());
    let direction = Measured::column(column).direction;
    let is_less_better = direction == Direction::LowerIsBetter;
    trackers.sort_by(|a, b| better_first(a.value(OVERALL), b.value(OVERALL), direction));
    let all = trackers.len();
    trackers.truncate(MAX_TRACKERS);
    let names = distinct(trackers.iter().flat_map(|t| &t.values).map(|(name, _)| name.as_str()));
    if names.len() < MIN_SPOKES {
        return None;
    }
    let shown = trackers.iter().flat_map(|t| &t.values).map(|(_, value)| *value);
    let digits = number::style_of_column(shown).unwrap_or(number::Style::DEFAULT);
    let range = |name: &&str| {
        let values = trackers.iter().filter_map(|t| t.value(name));
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    };
    let ranges: Vec<(f64, f64)> = names.iter().map(range).collect();
    let spoke = |(name, (low, high)): (&&str, &(f64, f64))| {
        let range = format!("{}–{}", digits.format(*low), digits.format(*high));
        [capitalized(&name.replace(['-', '_'], " ")), range]
    };
    let look = |t: &OfTracker| (Style::dashed(t.place), Marker::nth(t.place));
    let polygon = |t: &OfTracker| {
        let share = |v: f64, high: f64| if high > 0.0 { (v / high).clamp(0.0, 1.0) } else { 0.0 };
        let corner = |(name, (_, high)): (&&str, &(f64, f64))| t.value(name).map(|v| share(v, *high));
        let (style, marker) = look(t);
        Polygon { corners: names.iter().zip(&ranges).map(corner).collect(), style, marker }
    };
    let entry = |t: &OfTracker| {
        let (style, marker) = look(t);
        let value = t.value(OVERALL).map_or_else(String::new, |v| format!(" [{}]", digits.format(v)));
        Entry::new(Symbol::Line(style, Some(marker)), format!("{}{value}", t.name))
    };
    let radar = Radar {
        spokes: names.iter().zip(&ranges).map(spoke).collect(),
        polygons: trackers.iter().map(polygon).collect(),
    };
    let less = if is_less_better { ", less is better" } else { "" };
    let best =
        if all > MAX_TRACKERS { format!("; best {MAX_TRACKERS} of {all} trackers") } else { String::new() };
    Some(Figure {
        note: format!("{note}; {column}, from 0 to the largest value on each spoke{less}{best}"),
        form: Form::Radar,
        rows: vec![vec![Panel { marks: vec![Mark::Radar(radar)], ..Panel::default() }]],
        legend: trackers.iter().map(entry).collect(),
        ..Figure::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_methods::analysis::Grid;

    fn findings(column: &str, rows: &[(&str, Option<f64>)], number: (&str, f64)) -> Findings {
        let rows = rows.iter().map(|(row, value)| (row.to_string(), vec![None, *value])).collect();
        let (name, corner) = ("attributes".to_string(), "attribute".to_string());
        let grid = Grid { name, corner, columns: vec!["n".to_string(), column.to_string()], rows };
        Findings { numbers: vec![(number.0.to_string(), number.1)], tables: vec![grid], charts: Vec::new() }
    }

    fn tracker(place: usize, values: &[(&str, f64)]) -> OfTracker {
        let values = values.iter().map(|(name, value)| (name.to_string(), *value)).collect();
        OfTracker { name: format!("T{place}"), place, values }
    }

    fn chart(figure: &Figure) -> &Radar {
        match &figure.rows[0][0].marks[..] {
            [Mark::Radar(radar)] => radar,
            other => panic!("{other:?}"),
        }
    }

    fn legend(figure: &Figure) -> Vec<&str> {
        figure.legend.iter().map(|entry| entry.name.as_str()).collect()
    }

    #[test]
    fn overall_is_the_first_spoke_by_both_protocols() {
        let names = |values: &[(String, f64)]| {
            values.iter().map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
        };
        let success =
            findings("success AUC", &[("blur (2)", Some(0.4)), ("dark (1)", None)], ("success_auc", 0.5));
        assert_eq!(names(&values(&success, "attributes", "success AUC")), "overall 0.5, blur (2) 0.4");
        let rows = [("empty", Some(0.4)), ("blur", Some(0.2)), ("overall", Some(0.3))];
        let resets = findings("accuracy", &rows, ("accuracy", 0.9));
        assert_eq!(names(&values(&resets, "attributes", "accuracy")), "overall 0.3, empty 0.4, blur 0.2");
        assert!(values(&resets, "attributes", "failures").is_empty());
        assert!(values(&resets, "sequences", "accuracy").is_empty());
    }

    // By hand: 0.3 is half of 0.6, and 0.2 a quarter of 0.8.
    #[test]
    fn a_spoke_ends_at_its_largest_value_and_a_tracker_without_one_has_no_corner_there() {
        let first = [("overall", 0.3), ("fast-motion", 0.25), ("size_change (2)", 0.8)];
        let second = [("overall", 0.6), ("size_change (2)", 0.2)];
        let figure = radar("s", "success AUC", vec![tracker(0, &first), tracker(1, &second)]).unwrap();
        let Radar { spokes, polygons } = chart(&figure);
        let labels: Vec<String> = spokes.iter().map(|spoke| spoke.join(": ")).collect();
        let ranges = ["Overall: 0.300–0.600", "Size change (2): 0.200–0.800", "Fast motion: 0.250–0.250"];
        assert_eq!(labels, ranges);
        assert_eq!(polygons[0].corners, [Some(1.0), Some(0.25), None]);
        assert_eq!(polygons[1].corners, [Some(0.5), Some(1.0), Some(1.0)]);
        // Two spokes make no polygon.
        assert!(radar("s", "success AUC", vec![tracker(1, &second)]).is_none());
    }

    #[test]
    fn the_legend_begins_with_the_best_of_at_most_eight() {
        let values = |v: f64| [("overall", v), ("a", 0.0), ("b", 0.5)];
        let mut trackers: Vec<OfTracker> = (0..9).map(|k| tracker(k, &values(0.1 * k as f64))).collect();
        trackers.push(tracker(9, &values(0.1)[1..]));
        let figure = radar("s", "accuracy", trackers).unwrap();
        let names = legend(&figure);
        assert_eq!((names.len(), names[0], names[7]), (8, "T8 [0.800]", "T1 [0.100]"));
        assert!(figure.note.ends_with("; best 8 of 10 trackers"), "{}", figure.note);
        // A tracker has the color of its place, wherever it is in the legend.
        assert_eq!(chart(&figure).polygons[0].style.color, Style::nth(8).color);
        // On a spoke of zeros all are in the middle.
        assert!(chart(&figure).polygons.iter().all(|p| p.corners[1] == Some(0.0)));
        let few = vec![tracker(0, &values(3.0)), tracker(1, &values(2.0))];
        let figure = radar("s", "failures", few).unwrap();
        assert_eq!(legend(&figure), ["T1 [2.000]", "T0 [3.000]"]);
        assert!(figure.note.ends_with("less is better"), "{}", figure.note);
    }
}
