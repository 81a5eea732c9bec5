//! `chart`: a chart of an analysis, for all trackers.
//!
//! Trackers with one curve each share a panel, and the legend begins with the best. If each has a single
//! point, the names are beside the points, and intervals are bars. A chart with several curves has one panel
//! per tracker. Curves whose names differ only in a number, such as the length of a window, have ordered
//! colors.

use super::lines::{Line, Look, OPERATING, capitalized, compose, distinct};
use super::metrics::SHORT;
use super::{Scope, of_curves};
use crate::figure::{Axis, Color, Dash, Entry, Figure, Form, Mark, Marker, Range, Style, Symbol};
use crate::report::page::ReportError;
use crate::results::manifest;
use crate::table::suites::suites_note;
use trackfail_engine::execute::analyse::Analysed;
use trackfail_methods::analysis::{Chart, INTERVAL};

type Points = Vec<(f64, f64)>;

/// Width of the bar of an interval, in units.
const BAR: f64 = 0.7;
/// Most points of a curve that has markers.
const MAX_MARKED: usize = 16;

/// Draws the figure.
pub(super) fn draw(scope: &Scope<'_>) -> Result<(Figure, String), ReportError> {
    let shows = scope.given("shows", scope.figure.params.shows.as_ref())?;
    let analyses = scope.results.analyses.iter().filter(|a| a.analysis == shows.analysis);
    let found: Vec<(&Analysed, &Chart)> = analyses
        .filter_map(|a| Some((a, a.findings.charts.iter().find(|c| c.name == shows.part)?)))
        .collect();
    let reason = format!("the analysis {} has no chart {} with a point here", shows.analysis, shows.part);
    let Some((first, look)) = found.first() else { return Err(ReportError::NoData(reason)) };
    // Where trackers have other numbers of runs, the caption tells them.
    let is_same = found.iter().all(|(analysed, _)| analysed.runs == first.runs);
    let runs = is_same.then(|| format!(", {}", manifest::runs(first.runs)));
    let note = suites_note(first) + &runs.unwrap_or_default();
    let of_tracker = |(k, (analysed, chart)): (usize, &(&Analysed, &Chart))| {
        OfTracker::new(&analysed.tracker, chart, scope.place(&analysed.tracker).unwrap_or(k))
    };
    let of_trackers: Option<Vec<OfTracker>> = found.iter().enumerate().map(of_tracker).collect();
    let axes = |range: Range, y_range: Range| {
        let y = Axis { log: look.y_log, ..Axis::new(&capitalized(&look.y), y_range) };
        (Axis::new(&capitalized(&look.x), range), y)
    };
    let figure = match of_trackers {
        Some(trackers) if trackers.iter().all(|t| t.points.len() == 1) => {
            points(&note, axes(Range::Auto, Range::Auto), &trackers)
        }
        Some(trackers) => {
            let of_share = ["success", "precision"].contains(&look.y.as_str());
            let range =
                if of_share && !is_precision_recall(look) { Range::Fixed(0.0, 1.0) } else { Range::Auto };
            together(&note, axes(Range::Auto, range), trackers, is_precision_recall(look))
        }
        None => compose(&note, axes(Range::Auto, Range::FromZero), &by_name(&found), None, Vec::new()),
    };
    of_curves(figure, "", reason)
}

fn is_precision_recall(chart: &Chart) -> bool {
    chart.x == "recall" && chart.y == "precision"
}

/// The single curve of a tracker.
struct OfTracker {
    name: String,
    /// Number shown in the legend; NaN without one.
    number: f64,
    /// Index among all trackers.
    place: usize,
    points: Points,
    /// Corners of the interval of a single point.
    interval: Points,
}

impl OfTracker {
    /// Finds the single curve of a tracker: a curve without a name, or with a number in brackets. `None` if
    /// the tracker has several curves or one with another name.
    fn new(tracker: &str, chart: &Chart, place: usize) -> Option<Self> {
        let (name, points, interval) = match chart.curves.as_slice() {
            [(name, points)] => (name, points, Points::new()),
            [(name, points), (of, corners)] if of == INTERVAL => (name, points, corners.clone()),
            _ => return None,
        };
        let number = name.strip_prefix('[').and_then(|n| n.strip_suffix(']'));
        let name = match number {
            Some(number) if is_precision_recall(chart) => {
                let f = number.trim_start_matches('0');
                format!("{tracker} (AP {}, F {f})", SHORT.format(area(points)))
            }
            Some(_) => format!("{tracker} {name}"),
            None if name.is_empty() => tracker.to_string(),
            None => return None,
        };
        let number = number.and_then(|n| n.parse().ok()).unwrap_or(f64::NAN);
        Some(Self { name, number, place, points: points.clone(), interval })
    }

    fn curve(&self, style: Style) -> (Look, Line) {
        let marker = (self.points.len() <= MAX_MARKED).then_some(Marker::nth(self.place));
        curve("", &self.name, self.points.clone(), style, marker)
    }
}

/// A curve in a panel, with its name in the legend.
fn curve(panel: &str, name: &str, points: Points, style: Style, marker: Option<Marker>) -> (Look, Line) {
    let entry = Some(Entry::new(Symbol::Line(style, marker), name));
    (Look { panel: Some(panel.to_string()), entry, style, marker }, Line { points, ..Line::default() })
}

/// Area under a curve of many points, by trapezoids.
fn area(points: &[(f64, f64)]) -> f64 {
    points.windows(2).map(|p| (p[1].0 - p[0].0) * (p[0].1 + p[1].1) / 2.0).sum()
}

/// Point with the largest F on a curve of precision over recall.
fn best(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let f = |p: &(f64, f64)| if p.0 + p.1 > 0.0 { 2.0 * p.0 * p.1 / (p.0 + p.1) } else { 0.0 };
    points.iter().copied().max_by(|a, b| f(a).total_cmp(&f(b)))
}

/// Draws one point per tracker, with the name beside it.
fn points(note: &str, axes: (Axis, Axis), trackers: &[OfTracker]) -> Figure {
    let curves: Vec<(Look, Line)> = trackers.iter().map(|t| t.curve(Style::nth(t.place))).collect();
    let mut figure = compose(note, axes, &curves, None, Vec::new());
    figure.legend.clear();
    let names = trackers.iter().filter_map(|t| Some(Mark::Name(*t.points.first()?, t.name.clone())));
    if let Some(panel) = figure.rows.iter_mut().flatten().next() {
        panel.marks.splice(0..0, trackers.iter().flat_map(bars));
        panel.marks.extend(names);
    }
    figure
}

/// Bars of a tracker's interval on both axes.
fn bars(of: &OfTracker) -> Vec<Mark> {
    let (&[(left, lower), (right, upper)], &[(x, y)]) = (of.interval.as_slice(), of.points.as_slice()) else {
        return Vec::new();
    };
    let style = Style { width: BAR, ..Style::new(Style::nth(of.place).color, Dash::SOLID) };
    [vec![(left, y), (right, y)], vec![(x, lower), (x, upper)]].map(|ends| Mark::line(ends, style)).into()
}

/// Draws all trackers in one panel, with the best first in the legend. Line styles differ, too, so that equal
/// curves are visible.
fn together(
    note: &str,
    axes: (Axis, Axis),
    mut trackers: Vec<OfTracker>,
    is_precision_recall: bool,
) -> Figure {
    let key = |t: &OfTracker| if t.number.is_nan() { f64::NEG_INFINITY } else { t.number };
    trackers.sort_by(|a, b| key(b).total_cmp(&key(a)));
    let curve = |t: &OfTracker| {
        let (look, line) = t.curve(Style::dashed(t.place));
        (look, Line { operating: best(&t.points).filter(|_| is_precision_recall), ..line })
    };
    let curves: Vec<(Look, Line)> = trackers.iter().map(curve).collect();
    let mut figure = compose(note, axes, &curves, None, Vec::new());
    figure.form = Form::Square;
    for entry in figure.legend.iter_mut().filter(|entry| entry.name == OPERATING) {
        entry.name = "largest F".to_string();
    }
    if is_precision_recall {
        figure.rows.iter_mut().flatten().for_each(|panel| panel.marks.insert(0, Mark::IsoF));
    }
    figure
}

/// Numbers in the names, in their order, if the names differ only in one number; else `None`.
fn numbers(names: &[&str]) -> Option<Vec<f64>> {
    let split = |name: &str| {
        let from = name.find(|c: char| c.is_ascii_digit())?;
        let tail = &name[from..];
        let length = tail.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(tail.len());
        let number: f64 = tail[..length].parse().ok()?;
        Some((name[..from].to_string(), number, tail[length..].to_string()))
    };
    let parts: Vec<_> = names.iter().map(|name| split(name)).collect::<Option<_>>()?;
    let is_like = |p: &(String, f64, String)| (&p.0, &p.2) == (&parts[0].0, &parts[0].2);
    let grows = parts.windows(2).all(|p| p[0].1 < p[1].1);
    (parts.len() > 2 && parts.iter().all(is_like) && grows).then(|| parts.iter().map(|p| p.1).collect())
}

/// Points of a curve, with gaps where a logarithmic axis lacks values of empty bins: a line across would
/// pretend that there are values. Points that are not centers of equal bins are unchanged.
fn broken(points: &[(f64, f64)]) -> Points {
    let steps = || points.windows(2).map(|p| p[1].0 - p[0].0);
    let bin = steps().fold(f64::INFINITY, f64::min);
    let is_whole = |step: f64| (step / bin - (step / bin).round()).abs() < 1e-3;
    if points.len() < 4 || bin <= 0.0 || !steps().all(is_whole) {
        return points.to_vec();
    }
    let runs: Vec<&[(f64, f64)]> = points.chunk_by(|a, b| b.0 - a.0 <= 1.5 * bin).collect();
    runs.join(&(f64::NAN, f64::NAN))
}

/// Curves of trackers with several named ones: one panel per tracker.
fn by_name(found: &[(&Analysed, &Chart)]) -> Vec<(Look, Line)> {
    let all =
        || found.iter().flat_map(|(of, chart)| chart.curves.iter().map(move |curve| (of, chart, curve)));
    let names = distinct(all().map(|(.., (name, _))| name.as_str()));
    let is_ordered = numbers(&names).is_some();
    // Marks stand on all curves of a chart or on none.
    let few = all().all(|(.., (_, points))| points.len() <= MAX_MARKED);
    all()
        .map(|(of, chart, (name, points))| {
            let k = names.iter().position(|n| n == name).unwrap_or(0);
            let style = match is_ordered {
                true => Style::new(Color::ordered(k, names.len()), Dash::SOLID),
                false => Style::dashed(k),
            };
            let points = if chart.y_log { broken(points) } else { points.clone() };
            curve(&of.tracker, name, points, style, few.then_some(Marker::nth(k)))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_a_growing_number_are_ordered() {
        assert_eq!(numbers(&["L = 1", "L = 5", "L = 10"]), Some(vec![1.0, 5.0, 10.0]));
        let below = numbers(&["error below 0.1", "error below 0.2", "error below 1"]);
        assert_eq!(below, Some(vec![0.1, 0.2, 1.0]));
        assert_eq!(numbers(&["deviance", "penalty, d = 1", "penalty, d = 50"]), None);
        assert_eq!(numbers(&["a 1", "b 2", "c 3"]), None);
        assert_eq!(numbers(&["a 1", "a 2"]), None);
    }

    #[test]
    fn a_line_does_not_go_over_empty_bins() {
        let at = |places: &[f64]| places.iter().map(|x| (*x, 1.0)).collect::<Vec<_>>();
        let shown = |places: &[f64]| broken(&at(places)).iter().map(|p| p.0).collect::<Vec<_>>();
        let gaps = shown(&[0.5, 1.5, 2.5, 4.5, 5.5]);
        assert_eq!((gaps.len(), gaps[3].is_nan(), gaps[4]), (6, true, 4.5));
        assert_eq!(shown(&[0.5, 1.5, 2.5, 3.5]).len(), 4);
        // A grid of rates is none of bins.
        assert_eq!(shown(&[0.001, 0.005, 0.0175, 0.05, 0.1]).len(), 5);
    }

    fn trackers(n: usize, length: usize) -> Vec<OfTracker> {
        let of = |k: usize| {
            let points = (0..length).map(|x| (x as f64, (k * x) as f64)).collect();
            let mut curves = vec![(format!("[0.{k:02}]"), points)];
            curves.extend((length == 1).then(|| (INTERVAL.to_string(), vec![(0.0, -1.0), (1.0, 2.0)])));
            let chart = Chart { curves, ..Chart::default() };
            OfTracker::new(&format!("T{k}"), &chart, k).expect("a curve of a tracker")
        };
        (0..n).map(of).collect()
    }

    #[test]
    fn many_trackers_share_a_panel_and_the_best_is_first_in_the_legend() {
        let figure = together("", Default::default(), trackers(15, 40), false);
        let names: Vec<&str> = figure.legend.iter().map(|e| e.name.as_str()).collect();
        assert_eq!((figure.rows[0].len(), names.len()), (1, 15));
        assert_eq!((names[0], names[14]), ("T14 [0.14]", "T0 [0.00]"));
        let figure = together("", Default::default(), trackers(5, 40), true);
        assert_eq!(figure.legend.last().map(|e| e.name.as_str()), Some("largest F"));
        let figure = points("", Default::default(), &trackers(14, 1));
        let is_name = |mark: &&Mark| matches!(mark, Mark::Name(..));
        let marks = &figure.rows[0][0].marks;
        assert_eq!(marks.iter().filter(is_name).count(), 14);
        let bar = |mark: &Mark| match mark {
            Mark::Line { points, .. } if points.len() == 2 => Some(points.clone()),
            _ => None,
        };
        let bars: Vec<_> = marks.iter().filter_map(bar).collect();
        assert_eq!(bars[2..4], [[(0.0, 0.0), (1.0, 0.0)], [(0.0, -1.0), (0.0, 2.0)]]);
        assert_eq!(bars.len(), 28);
        assert!(figure.legend.is_empty());
    }

    // By hand: trapezoids of 1 by .75 and 1 by .25; F is largest at (1, .5).
    #[test]
    fn the_area_and_the_best_point_by_hand() {
        let points = [(0.0, 1.0), (1.0, 0.5), (2.0, 0.0)];
        assert!((area(&points) - 1.0).abs() < 1e-12);
        assert_eq!(best(&points), Some((1.0, 0.5)));
    }
}
