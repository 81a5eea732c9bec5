//! `curve`: one metric over another, such as a receiver operating curve.

use super::drawer::{DrawError, Drawer, Drawing, Scope};
use super::lines::{NamedCurve, drawing, plain};
use crate::figure::{Curves, Range};
use crate::results::Measure;
use crate::results::Results;
use crate::score::Metric;

/// The entry of this kind.
pub const DRAWER: Drawer = Drawer { word: "curve", shows_tracks: false, draw };

fn draw(scope: &Scope<'_>) -> Result<Drawing, DrawError> {
    let params = scope.params();
    let y = *scope.given("metric", params.metric.as_ref())?;
    let x = *scope.given("x", params.x_metric.as_ref())?;
    let curves = curve(scope.results, &scope.note, y, x, &params.methods);
    Ok(drawing(curves, format!("{} and {} have no value", y.name(), x.name())))
}

/// One metric over another: for each tracker and method its grid points in the grid's order, along the first
/// axis; a curve for each combination of the others.
fn curve(results: &Results, note: &str, y: Metric, x: Metric, methods: &[String]) -> Curves {
    let mut shown: Vec<&Measure> = results.measures.iter().filter(|m| methods.contains(&m.method)).collect();
    let several = shown.iter().any(|m| m.tracker != shown[0].tracker);
    let along = |m: &Measure| m.point().first().map_or(0.0, |(_, at)| *at);
    // Stable, so that methods stay in the order of the experiment.
    shown.sort_by(|a, b| along(a).total_cmp(&along(b)));
    let mut curves: Vec<NamedCurve> = Vec::new();
    for method in methods {
        for m in shown.iter().filter(|m| m.method == *method) {
            let mut name = vec![m.method.clone()];
            name.extend(several.then(|| m.tracker.clone()));
            name.extend(m.point().iter().skip(1).map(|(axis, v)| format!("{axis} {v}")));
            let name = name.join(", ");
            let at = (m.value(x).unwrap_or(f64::NAN), m.value(y).unwrap_or(f64::NAN));
            match curves.iter_mut().find(|(known, _)| *known == name) {
                Some((_, points)) => points.push(at),
                None => curves.push((name, vec![at])),
            }
        }
    }
    // Rates begin at 0 and end at 1, or before where there is nothing near.
    let range = |side: fn(&(f64, f64)) -> f64| {
        let all = || curves.iter().flat_map(|(_, points)| points).map(side).filter(|v| !v.is_nan());
        let highest = all().fold(0.0, f64::max);
        let end = [0.1, 0.2, 0.5, 1.0].into_iter().find(|end| highest <= *end);
        end.filter(|_| all().all(|v| v >= 0.0)).map_or(Range::Auto, |end| Range::Fixed(0.0, end))
    };
    let (x_range, y_range) = (range(|p| p.0), range(|p| p.1));
    Curves { square: true, x_range, y_range, ..plain(note, x.name(), y.name(), curves) }
}
