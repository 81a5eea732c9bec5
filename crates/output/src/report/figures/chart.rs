//! `chart`: a chart that an analysis makes, on every tracker.
//!
//! A chart with one curve a tracker shows them all in a panel, or, where they are many, each in a panel of its own before
//! the others; one with a point a tracker names the points. One with several curves has a panel a tracker. Curves whose
//! names differ in a number alone, such as the length of a window, have ordered colors.

use super::curve::SHORT;
use super::drawer::{DrawError, Drawer, Drawing, Scope};
use super::lines::{capitalized, drawing, plain};
use crate::figure::{
    Color, Curve, CurveAxis, Curves, Dash, Entry, Facet, Marker, Range, Sign, Style, Symbol,
};
use crate::results::Results;
use crate::results::manifest;
use crate::table::suites::suites_note;
use trackfail_engine::execute::analyse::Analysed;
use trackfail_engine::spec::table::FindingName;
use trackfail_methods::analysis::Chart;

/// The entry of this kind.
pub const DRAWER: Drawer = Drawer { word: "chart", shows_tracks: false, draw };

/// Most trackers whose curves share a panel.
const MAX_CURVES: usize = 7;

fn draw(scope: &Scope<'_>) -> Result<Drawing, DrawError> {
    let shows = scope.given("shows", scope.params().shows.as_ref())?;
    Ok(drawing(chart(scope.results, shows), format!("there is no analysis {}", shows.analysis)))
}

/// A curve under the name that a legend has.
type Named = (String, Vec<(f64, f64)>);

/// Draws a chart of an analysis, on every tracker.
fn chart(results: &Results, shows: &FindingName) -> Curves {
    let found: Vec<(&Analysed, &Chart)> = results
        .analyses
        .iter()
        .filter(|a| a.analysis == shows.analysis)
        .filter_map(|a| Some((a, a.findings.charts.iter().find(|c| c.name == shows.part)?)))
        .collect();
    let Some((first, look)) = found.first() else { return plain("", "", "") };
    let is_precision_recall = look.x == "recall" && look.y == "precision";
    // A curve without a name, or with a number in brackets, is its tracker's.
    let of_tracker = |(analysed, chart): &(&Analysed, &Chart)| -> Option<Named> {
        let [(name, points)] = chart.curves.as_slice() else { return None };
        let who = &analysed.tracker;
        let number = name.strip_prefix('[').and_then(|n| n.strip_suffix(']'));
        match number {
            Some(number) if is_precision_recall => Some((
                format!("{who} (AP {}, F {})", SHORT.format(area(points)), number.trim_start_matches('0')),
                points.clone(),
            )),
            Some(number) => Some((format!("{who} [{number}]"), points.clone())),
            None => name.is_empty().then(|| (who.clone(), points.clone())),
        }
    };
    let of_trackers: Option<Vec<Named>> = found.iter().map(of_tracker).collect();
    let (facets, legend) = match of_trackers {
        Some(named) if named.iter().all(|(_, points)| points.len() == 1) => points(&named),
        Some(named) if named.len() > MAX_CURVES => apart(&named),
        Some(named) => together(&named, is_precision_recall),
        None => by_name(&found),
    };
    let note = format!("{}, {}", suites_note(first), manifest::runs(first.runs));
    let frame = plain(&note, &capitalized(&look.x), &capitalized(&look.y));
    let y = CurveAxis { log: look.y_log, ..frame.y.clone() };
    let (x, y) = if is_precision_recall {
        let share = |axis: CurveAxis| CurveAxis { range: Range::Fixed(0.0, 1.0), ..axis };
        (share(frame.x.clone()), share(y))
    } else {
        (frame.x.clone(), y)
    };
    Curves { facets, legend, x, y, square: is_precision_recall, iso_f: is_precision_recall, ..frame }
}

/// Area under a curve of many points, by trapezoids.
fn area(points: &[(f64, f64)]) -> f64 {
    points.windows(2).map(|p| (p[1].0 - p[0].0) * (p[0].1 + p[1].1) / 2.0).sum()
}

/// The point with the largest F of a curve of precision over recall.
fn best(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let f = |p: &(f64, f64)| if p.0 + p.1 > 0.0 { 2.0 * p.0 * p.1 / (p.0 + p.1) } else { 0.0 };
    points.iter().copied().max_by(|a, b| f(a).total_cmp(&f(b)))
}

type Parts = (Vec<Facet>, Vec<Entry>);

/// A point a tracker, with its name beside it.
fn points(named: &[Named]) -> Parts {
    let curve = |(k, (_, points)): (usize, &Named)| Curve::new(points.clone(), Style::nth(k), Marker::nth(k));
    let name = |(name, points): &Named| points.first().map(|at| (name.clone(), *at));
    let facet = Facet {
        series: named.iter().enumerate().map(curve).collect(),
        names: named.iter().filter_map(name).collect(),
        ..Facet::default()
    };
    (vec![facet], Vec::new())
}

/// All trackers in one panel. Line styles differ too, so that equal curves show.
fn together(named: &[Named], mark_best: bool) -> Parts {
    let style = |k: usize| Style { dash: Dash::nth(k), ..Style::nth(k) };
    let mut legend: Vec<Entry> = Vec::new();
    let mut facet = Facet::default();
    for (k, (name, points)) in named.iter().enumerate() {
        let curve = Curve::new(points.clone(), style(k), Marker::nth(k));
        legend.push(Entry::new(Symbol::Line(style(k), curve.marker), name.as_str()));
        facet.series.push(curve);
        let best = best(points).filter(|_| mark_best);
        facet.signs.extend(best.map(|at| (Sign::Operating, at, style(k).color)));
    }
    if mark_best {
        legend.push(Entry::new(Symbol::Sign(Sign::Operating, Color::Gray), "largest F"));
    }
    (vec![facet], legend)
}

/// A panel a tracker, before the curves of the others.
fn apart(named: &[Named]) -> Parts {
    let style = Style { width: 1.8, ..Style::new(Color::Blue, Dash::Solid) };
    let facet = |(k, (name, points)): (usize, &Named)| Facet {
        label: name.clone(),
        series: vec![Curve { marker: None, ..Curve::new(points.clone(), style, Marker::Circle) }],
        behind: named.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, n)| n.1.clone()).collect(),
        ..Facet::default()
    };
    let other = Style::new(Color::Mapped([0xC9, 0xC9, 0xC9]), Dash::Solid);
    let legend = vec![
        Entry::new(Symbol::Line(style, None), "the tracker of the panel"),
        Entry::new(Symbol::Line(other, None), "the other trackers"),
    ];
    (named.iter().enumerate().map(facet).collect(), legend)
}

/// Names that differ in one number alone: the numbers, in the order of the names.
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

/// The points of a curve, with a gap where the values of empty bins are left out: on a logarithmic axis these have no
/// place, and a line over them would say that there is something. Points that are not the middles of equal bins are as
/// they are.
fn broken(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let steps = || points.windows(2).map(|p| p[1].0 - p[0].0);
    let bin = steps().fold(f64::INFINITY, f64::min);
    let is_whole = |step: f64| (step / bin - (step / bin).round()).abs() < 1e-3;
    if points.len() < 4 || bin <= 0.0 || !steps().all(is_whole) {
        return points.to_vec();
    }
    let mut out = points[..1].to_vec();
    for p in points.windows(2) {
        if p[1].0 - p[0].0 > 1.5 * bin {
            out.push((f64::NAN, f64::NAN));
        }
        out.push(p[1]);
    }
    out
}

/// Several curves by name: a panel a tracker.
fn by_name(found: &[(&Analysed, &Chart)]) -> Parts {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in found.iter().flat_map(|(_, c)| &c.curves) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let ordered = numbers(&names).is_some();
    let style = |name: &str| {
        let k = names.iter().position(|n| *n == name).unwrap_or(0);
        let style = if ordered {
            Style::new(Color::ordered(k, names.len()), Dash::Solid)
        } else {
            Style { dash: Dash::nth(k), ..Style::nth(k) }
        };
        (style, Marker::nth(k))
    };
    // Marks stand on all curves of a chart or on none.
    let few = found.iter().flat_map(|(_, c)| &c.curves).all(|(_, p)| p.len() <= MAX_MARKED);
    let curve = |(name, points): &(String, Vec<(f64, f64)>)| {
        let (style, marker) = style(name);
        Curve { marker: few.then_some(marker), ..Curve::new(points.clone(), style, marker) }
    };
    let of_chart = |chart: &Chart| -> Vec<Curve> {
        let gaps = |(name, points): &Named| {
            (name.clone(), if chart.y_log { broken(points) } else { points.clone() })
        };
        chart.curves.iter().map(gaps).map(|named| curve(&named)).collect()
    };
    let facet = |(analysed, chart): &(&Analysed, &Chart)| Facet {
        label: if found.len() > 1 { analysed.tracker.clone() } else { String::new() },
        series: of_chart(chart),
        ..Facet::default()
    };
    let entry = |name: &&str| {
        let (style, marker) = style(name);
        Entry::new(Symbol::Line(style, few.then_some(marker)), *name)
    };
    (found.iter().map(facet).collect(), names.iter().map(entry).collect())
}

/// Most points of curves that have marks.
const MAX_MARKED: usize = 16;

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

    fn named(n: usize, points: usize) -> Vec<Named> {
        let curve = |k: usize| (0..points).map(|x| (x as f64, (k * x) as f64)).collect();
        (0..n).map(|k| (format!("T{k}"), curve(k))).collect()
    }

    #[test]
    fn many_trackers_have_a_panel_each_before_the_others() {
        let (facets, legend) = apart(&named(12, 40));
        assert_eq!((facets.len(), legend.len()), (12, 2));
        assert!(facets.iter().all(|f| f.series.len() == 1 && f.behind.len() == 11));
        let (facets, legend) = together(&named(5, 40), true);
        assert_eq!((facets[0].series.len(), facets[0].signs.len(), legend.len()), (5, 5, 6));
        let (facets, legend) = points(&named(14, 1));
        assert_eq!((facets[0].names.len(), legend.len()), (14, 0));
    }

    // By hand: trapezoids of 1 by .75 and 1 by .25; F is largest at (1, .5).
    #[test]
    fn the_area_and_the_best_point_by_hand() {
        let points = [(0.0, 1.0), (1.0, 0.5), (2.0, 0.0)];
        assert!((area(&points) - 1.0).abs() < 1e-12);
        assert_eq!(best(&points), Some((1.0, 0.5)));
    }
}
