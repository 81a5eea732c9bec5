//! `sweep`: a metric over a grid axis.

use super::bands::Bands;
use super::drawer::{DrawError, Drawer, Drawing, Scope};
use super::lines::{Line, arrange, capitalized, drawing, with_remark};
use super::published;
use crate::figure::{Color, Curves, Dash, Entry, Sign, Style, Symbol};
use crate::report::operating;
use crate::results::Measure;
use trackfail_methods::score::Metric;

/// The entry of this kind.
pub const DRAWER: Drawer = Drawer { word: "sweep", shows_tracks: false, draw };

fn draw(scope: &Scope<'_>) -> Result<Drawing, DrawError> {
    let params = scope.params();
    let metric = *scope.given("metric", params.metric.as_ref())?;
    let x = scope.given("x", params.x_axis.as_ref())?;
    let curves = sweep(scope, metric, x, &params.methods);
    let has_ring = curves.facets.iter().flat_map(|f| &f.signs).any(|s| s.0 == Sign::Operating);
    let remark = if has_ring { " Rings are at the published parameters." } else { "" };
    Ok(with_remark(drawing(curves, format!("{} has no value for any {x}", metric.name())), remark))
}

/// The published value of the axis for each method: upright lines, equal ones once.
fn uprights(scope: &Scope<'_>, x: &str, methods: &[String]) -> Vec<f64> {
    let shown = scope.results.experiment.methods.iter().filter(|m| methods.contains(&m.name));
    let published = shown.filter_map(operating::published).flatten();
    let mut values: Vec<f64> = published.filter(|(axis, _)| axis == x).map(|(_, at)| at).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// One curve for each tracker, method and combination of the other axes.
fn sweep(scope: &Scope<'_>, metric: Metric, x: &str, methods: &[String]) -> Curves {
    let (results, experiment) = (scope.results, &scope.results.experiment);
    let shown = || results.measures.iter().filter(|m| methods.contains(&m.method));
    let mut ends: Vec<f64> =
        shown().flat_map(Measure::point).filter(|(axis, _)| axis == x).map(|(_, at)| at).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let bands = Bands::new(results, scope.units);
    let mut lines: Vec<Line> = Vec::new();
    for m in shown() {
        let point = m.point();
        let value = m.value(metric).unwrap_or(f64::NAN);
        let bounds = bands.bounds(m, metric);
        let own = point.iter().find(|(axis, _)| axis == x).map(|(_, at)| *at);
        // A method that knows nothing of the axis is the same all along it.
        let at = own.map_or(ends.clone(), |at| vec![at]);
        let others: Vec<(String, f64)> = point.into_iter().filter(|(axis, _)| axis != x).collect();
        let is_it = |l: &Line| (&l.method, &l.tracker, &l.others) == (&m.method, &m.tracker, &others);
        let k = lines.iter().position(is_it).unwrap_or_else(|| {
            let published = published::along(experiment, m, metric, x);
            let (method, tracker) = (m.method.clone(), m.tracker.clone());
            lines.push(Line { method, tracker, others: others.clone(), published, ..Line::default() });
            lines.len() - 1
        });
        let line = &mut lines[k];
        line.marked |= own.is_some();
        line.points.extend(at.iter().map(|at| (*at, value)));
        line.band.extend(at.iter().map(|_| bounds));
        let method = experiment.methods.iter().find(|method| method.name == m.method);
        let operated = method.filter(|method| method.variants.len() > 1).and_then(operating::variant);
        if operated.is_some_and(|v| v.params() == m.params) {
            line.operating = own.map(|at| (at, value));
        }
    }
    for line in &mut lines {
        let mut order: Vec<usize> = (0..line.points.len()).collect();
        order.sort_by(|a, b| line.points[*a].0.total_cmp(&line.points[*b].0));
        (line.points, line.band) = order.iter().map(|k| (line.points[*k], line.band[*k])).unzip();
    }
    let names = (capitalized(x), metric.title());
    let mut curves = arrange(experiment, &scope.note, (&names.0, &names.1), lines);
    let style = Style { width: 1.1, ..Style::new(Color::Gray, Dash::Dashed) };
    for at in uprights(scope, x, methods).into_iter().filter(|at| ends.contains(at)) {
        curves.facets.iter_mut().for_each(|f| f.uprights.push((at, style)));
        curves.legend.push(Entry::new(Symbol::Upright(style), format!("published {x} {at}")));
    }
    curves
}
