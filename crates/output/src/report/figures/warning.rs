//! `warning`: whether scores rise before a loss, as the area under the ROC curve of "a loss begins within k frames" over k.

use super::lines::{Line, arrange};
use super::metrics::{CHANCE, chance, rule};
use super::{DrawError, Drawing, Scope};
use crate::figure::{Axis, Mark, Range};
use crate::report::standings::Estimate;
use crate::results::frame_measures::EVERY_TRACKER;
use trackfail_methods::score::FrameMeasures;
use trackfail_methods::score::frames::warning::HORIZONS;

/// Draws a curve for each method without a grid: on all trackers together where the experiment has them so, else on each.
pub(super) fn draw(scope: &Scope<'_>) -> Result<Drawing, DrawError> {
    let experiment = &scope.results.experiment;
    let trackers: Vec<&str> = match experiment.leaderboard {
        true => vec![EVERY_TRACKER],
        false => experiment.trackers.iter().map(|tracker| tracker.label.as_str()).collect(),
    };
    let lines: Vec<Line> = trackers
        .into_iter()
        .flat_map(|tracker| scope.params().methods.iter().map(move |method| (tracker, method)))
        .filter_map(|(tracker, method)| {
            let key = [tracker.to_string(), method.clone(), String::new()];
            let points = points(scope.results.frame_measures.get(&key)?);
            let (points, band) = points.into_iter().unzip();
            let (method, tracker) = (method.clone(), tracker.to_string());
            Some(Line { method, tracker, points, band, marked: true, ..Line::default() })
        })
        .collect();
    let axes =
        (Axis::new("Frames before the loss, at most", Range::FromZero), Axis::new("AUROC", Range::Auto));
    let mut figure = arrange(experiment, &scope.note, axes, &lines);
    rule(&mut figure, &Mark::Level(0.5, CHANCE), chance());
    Ok(Drawing::of_curves(figure, "", "no method has a score before a loss".to_string()))
}

/// A point with its bounds.
type Bounded = ((f64, f64), (f64, f64));

/// The measure of each horizon; NaN where there is none.
fn points(measures: &FrameMeasures) -> Vec<Bounded> {
    let point = |horizon: usize| {
        let estimate = Estimate::of_frames(measures, &format!("auroc_within_{horizon}"));
        let none = (f64::NAN, f64::NAN);
        ((horizon as f64, estimate.value.unwrap_or(f64::NAN)), estimate.bounds.unwrap_or(none))
    };
    HORIZONS.map(point).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_horizon_without_a_measure_is_a_gap() {
        let mut measures = FrameMeasures::default();
        for (column, value) in [
            ("auroc_within_5", 0.9),
            ("auroc_within_5_low", 0.8),
            ("auroc_within_5_high", 0.95),
            ("auroc_within_30", 0.7),
        ] {
            measures.set(column, Some(value));
        }
        let points = points(&measures);
        assert_eq!(points[0], ((5.0, 0.9), (0.8, 0.95)));
        assert!(points[1].0.1.is_nan() && points[2].1.0.is_nan());
        assert_eq!(points[2].0, (30.0, 0.7));
    }
}
