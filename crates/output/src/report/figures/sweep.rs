//! `sweep`: a metric over a grid axis.

use super::drawer::{DrawError, Drawer, Drawing, Scope};
use super::lines::{NamedCurve, drawing, plain};
use crate::figure::Curves;
use crate::results::Measure;
use crate::results::Results;
use crate::score::Metric;

/// The entry of this kind.
pub const DRAWER: Drawer = Drawer { word: "sweep", shows_tracks: false, draw };

fn draw(scope: &Scope<'_>) -> Result<Drawing, DrawError> {
    let params = scope.params();
    let metric = *scope.given("metric", params.metric.as_ref())?;
    let x = scope.given("x", params.x_axis.as_ref())?;
    let curves = sweep(scope.results, &scope.note, metric, x, &params.methods);
    Ok(drawing(curves, format!("{} has no value for any {x}", metric.name())))
}

/// One curve for each tracker, method and combination of the other axes.
fn sweep(results: &Results, note: &str, metric: Metric, x: &str, methods: &[String]) -> Curves {
    let mut curves: Vec<NamedCurve> = Vec::new();
    let shown = || results.measures.iter().filter(|m| methods.contains(&m.method));
    let several = shown().any(|m| shown().any(|n| n.tracker != m.tracker));
    let mut ends: Vec<f64> =
        shown().flat_map(Measure::point).filter(|(axis, _)| axis == x).map(|(_, at)| at).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    for m in shown() {
        let point = m.point();
        let value = m.value(metric).unwrap_or(f64::NAN);
        // A method that knows nothing of the axis is the same all along it.
        let at = point.iter().find(|(axis, _)| axis == x).map_or(ends.clone(), |(_, at)| vec![*at]);
        let others = point.iter().filter(|(axis, _)| axis != x).map(|(axis, v)| format!("{axis} {v}"));
        let mut name: Vec<String> = vec![m.method.clone()];
        if several {
            name.push(m.tracker.clone());
        }
        name.extend(others);
        let name = name.join(", ");
        let new = at.into_iter().map(|at| (at, value));
        match curves.iter_mut().find(|(n, _)| *n == name) {
            Some((_, points)) => points.extend(new),
            None => curves.push((name, new.collect())),
        }
    }
    for (_, points) in &mut curves {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    plain(note, x, metric.name(), curves)
}
