//! `curve`: one metric over another, such as precision over recall or a receiver operating curve.

use super::bands::Bands;
use super::drawer::{DrawError, Drawer, Drawing, Scope};
use super::lines::{Line, arrange, drawing, with_remark};
use super::published;
use crate::figure::{CurveAxis, Curves, Range};
use crate::report::operating;
use crate::report::standings::ordering_metric;
use crate::table::layout::is_anchor;
use crate::table::number::Style;
use trackfail_methods::score::Metric;

/// The entry of this kind.
pub const DRAWER: Drawer = Drawer { word: "curve", shows_tracks: false, draw };

fn draw(scope: &Scope<'_>) -> Result<Drawing, DrawError> {
    let params = scope.params();
    let y = *scope.given("metric", params.metric.as_ref())?;
    let x = *scope.given("x", params.x_metric.as_ref())?;
    let (curves, remark) = curve(scope, y, x, &params.methods);
    let drawing = drawing(curves, format!("{} and {} have no value", y.name(), x.name()));
    Ok(with_remark(drawing, &remark))
}

/// Area under precision over recall, a sum of steps: of each point its precision, over the recall that it adds to the
/// points before it (in order of recall, the first from 0).
pub fn average_precision(points: &[(f64, f64)]) -> f64 {
    let mut before = 0.0;
    let mut area = 0.0;
    for (recall, precision) in points.iter().filter(|p| p.0.is_finite() && p.1.is_finite()) {
        area += (recall - before) * precision;
        before = *recall;
    }
    area
}

/// How an average precision is printed: `.26`.
pub const SHORT: Style = Style { decimals: 2, bare: true };

/// A point of a curve, with what it is made of.
#[derive(Clone, Copy)]
struct At {
    point: (f64, f64),
    bounds: (f64, f64),
    /// The metric that methods are ordered by, larger is better.
    worth: f64,
    is_published: bool,
}

/// Orders the points of a curve by recall where that is one of the metrics, so that it does not turn back where a threshold
/// finds less than a stricter one; else by what is along x. Of equal ones the best is first.
fn ordered(points: &mut [At], y: Metric) {
    let by_y = y == Metric::RECALL;
    let key = |at: &At| if by_y { (at.point.1, at.point.0) } else { (at.point.0, -at.point.1) };
    points.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
}

/// One metric over another: a curve for each tracker, method and combination of the axes after the first.
fn curve(scope: &Scope<'_>, y: Metric, x: Metric, methods: &[String]) -> (Curves, String) {
    let (results, experiment) = (scope.results, &scope.results.experiment);
    let best_by = ordering_metric(experiment);
    let bands = Bands::new(results, scope.units);
    let mut groups: Vec<(Line, Vec<At>)> = Vec::new();
    for method in methods {
        let known = experiment.methods.iter().find(|m| m.name == *method);
        let published = known.and_then(operating::variant);
        for m in results.measures.iter().filter(|m| m.method == *method) {
            let others: Vec<(String, f64)> = m.point().into_iter().skip(1).collect();
            let is_it = |l: &Line| (&l.method, &l.tracker, &l.others) == (&m.method, &m.tracker, &others);
            let k = groups.iter().position(|(l, _)| is_it(l)).unwrap_or_else(|| {
                let (method, tracker) = (m.method.clone(), m.tracker.clone());
                let point = published::point(experiment, m, x, y).into_iter().collect();
                let line =
                    Line { method, tracker, others, published: point, marked: true, ..Line::default() };
                groups.push((line, Vec::new()));
                groups.len() - 1
            });
            groups[k].1.push(At {
                point: (m.value(x).unwrap_or(f64::NAN), m.value(y).unwrap_or(f64::NAN)),
                bounds: bands.bounds(m, y),
                worth: m.value(best_by).unwrap_or(f64::NEG_INFINITY),
                is_published: published.is_some_and(|v| v.params() == m.params),
            });
        }
    }
    let (mut has_published, mut has_best) = (false, false);
    let is_precision_recall = (x, y) == (Metric::RECALL, Metric::PRECISION);
    let line = |(mut line, mut points): (Line, Vec<At>)| {
        points.retain(|at| at.point.0.is_finite() && at.point.1.is_finite());
        ordered(&mut points, y);
        line.points = points.iter().map(|at| at.point).collect();
        if points.len() > 1 && !is_anchor(experiment, &line.method) {
            line.band = points.iter().map(|at| at.bounds).collect();
            let printed = points.iter().find(|at| at.is_published);
            let best = points.iter().max_by(|a, b| a.worth.total_cmp(&b.worth));
            has_published |= printed.is_some();
            has_best |= printed.is_none();
            line.operating = printed.or(best).map(|at| at.point);
            if is_precision_recall {
                line.summary = format!("AP {}", SHORT.format(average_precision(&line.points)));
            }
        }
        line
    };
    let lines: Vec<Line> = groups.into_iter().map(line).collect();
    let best = best_by.heading();
    let mut remark = match (has_published, has_best) {
        (true, false) => " Rings are at the published parameters.".to_string(),
        (true, true) => {
            format!(
                " Rings are at the published parameters, or where none are at the best {best} of these sequences."
            )
        }
        (false, true) => format!(" Rings are at the best {best} of these sequences."),
        (false, false) => String::new(),
    };
    if is_precision_recall {
        remark.push_str(
            " AP is the area under the points in steps, from recall 0 to the largest one. Dashed lines have equal F.",
        );
    }
    let names = (x.title(), y.title());
    let all = |side: fn(&(f64, f64)) -> f64| lines.iter().flat_map(|l| &l.points).map(side);
    let bounds = lines.iter().flat_map(|l| &l.band).flat_map(|b| [b.0, b.1]).filter(|b| b.is_finite());
    let x_axis = CurveAxis { range: range(x, all(|p| p.0)), ..CurveAxis::new(&names.0) };
    let y_axis = CurveAxis { range: range(y, all(|p| p.1).chain(bounds)), ..CurveAxis::new(&names.1) };
    let curves = arrange(experiment, &scope.note, (&names.0, &names.1), lines.clone());
    (Curves { square: true, iso_f: is_precision_recall, x: x_axis, y: y_axis, ..curves }, remark)
}

/// Shares begin at 0 and end at 1, or before where there is nothing near; other values at what there is.
fn range(metric: Metric, values: impl Iterator<Item = f64> + Clone) -> Range {
    let highest = values.clone().fold(0.0, f64::max);
    let end = [0.1, 0.2, 0.5, 1.0].into_iter().find(|end| highest <= *end);
    let is_share = metric.unit().is_empty() && values.clone().all(|v| v >= 0.0);
    match end.filter(|_| is_share) {
        Some(end) => Range::Fixed(0.0, end),
        None if values.clone().all(|v| v >= 0.0) => Range::FromZero,
        None => Range::Auto,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> At {
        At { point: (x, y), bounds: (f64::NAN, f64::NAN), worth: y, is_published: false }
    }

    fn in_order(points: &[(f64, f64)], y: Metric) -> Vec<(f64, f64)> {
        let mut all: Vec<At> = points.iter().map(|p| at(p.0, p.1)).collect();
        ordered(&mut all, y);
        all.into_iter().map(|at| at.point).collect()
    }

    // A threshold that finds less than a stricter one would turn the curve back.
    #[test]
    fn points_are_in_the_order_of_recall() {
        let points = [(0.4, 0.2), (0.1, 0.9), (0.4, 0.5), (0.3, 0.6)];
        let expected = [(0.1, 0.9), (0.3, 0.6), (0.4, 0.5), (0.4, 0.2)];
        assert_eq!(in_order(&points, Metric::PRECISION), expected);
        let points = [(0.2, 0.4), (0.1, 0.4), (0.3, 0.2)];
        assert_eq!(in_order(&points, Metric::RECALL), [(0.3, 0.2), (0.1, 0.4), (0.2, 0.4)]);
    }

    // By hand: .1 at .9, .2 more at .6 and .1 more at .5; the second point at .4 adds nothing.
    #[test]
    fn average_precision_is_a_sum_of_steps() {
        let points = [(0.1, 0.9), (0.3, 0.6), (0.4, 0.5), (0.4, 0.2), (0.5, f64::NAN)];
        assert!((average_precision(&points) - (0.09 + 0.12 + 0.05)).abs() < 1e-12);
        assert_eq!((SHORT.format(0.261), SHORT.format(1.0)), (".26".to_string(), "1.00".to_string()));
    }

    #[test]
    fn shares_end_at_a_round_number_beyond_them() {
        let of = |metric, values: &[f64]| range(metric, values.iter().copied());
        assert_eq!(of(Metric::RECALL, &[0.1, 0.3]), Range::Fixed(0.0, 0.5));
        assert_eq!(of(Metric::DELAY_MEDIAN, &[0.5, -1.0]), Range::Auto);
        assert_eq!(of(Metric::F_OVER_CHANCE, &[0.5, -0.1]), Range::Auto);
    }
}
