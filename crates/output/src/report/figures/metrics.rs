//! `sweep`, `curve`, `delay` and `warning`: a metric over a grid axis, one metric over another, how long
//! after an event it is detected, and how long before.

use super::lines::{Line, arrange, capitalized, values};
use super::{Scope, of_curves, published};
use crate::figure::{Axis, Color, Dash, Entry, Figure, Form, Mark, Range, Style, Symbol};
use crate::report::operating;
use crate::report::page::ReportError;
use crate::report::sentences::say;
use crate::report::standings::{Estimate, ordering_metric};
use crate::results::frame_measures::EVERY_TRACKER;
use crate::results::{Measure, TrackSeries, grouped};
use crate::sampling::Sampling;
use crate::table::layout::is_anchor;
use crate::table::number;
use serde_json::json;
use std::ops::RangeInclusive;
use trackfail_engine::spec::Tracker;
use trackfail_methods::score::frames::warning::HORIZONS;
use trackfail_methods::score::khalid2016::TOLERANCE;
use trackfail_methods::score::{FrameMeasures, Metric, TrackScore};

/// Style of an average precision: `.26`.
pub const SHORT: number::Style = number::Style { decimals: 2, bare: true };
/// Line style of chance level.
const CHANCE: Style = Style { color: Color::GRAY, dash: Dash::DOTTED, width: 1.1 };

/// A point with its bounds.
type Bounded = ((f64, f64), (f64, f64));

/// Lines without points, each with its measures: one for each method, tracker and point of `others`, the other grid axes.
fn curves<'m>(
    measures: impl Iterator<Item = &'m Measure>,
    others: impl Fn(&Measure) -> Vec<(String, f64)>,
) -> Vec<(Line, Vec<&'m Measure>)> {
    let key = |m: &'m Measure| (m.method.as_str(), m.tracker.as_str(), format!("{:?}", others(m)));
    let line = |(_, same): (_, Vec<&'m Measure>)| {
        let (method, tracker, others) = (same[0].method.clone(), same[0].tracker.clone(), others(same[0]));
        (Line { method, tracker, others, ..Line::default() }, same)
    };
    grouped(measures, key).into_iter().map(line).collect()
}

/// Draws a metric over a grid axis, with a curve for each tracker, method and combination of other axes.
pub(super) fn sweep(scope: &Scope<'_>) -> Result<(Figure, String), ReportError> {
    let params = &scope.figure.params;
    let metric = *scope.given("metric", params.metric.as_ref())?;
    let x = scope.given("x", params.x_axis.as_ref())?;
    let experiment = &scope.results.experiment;
    let shown = || scope.results.measures.iter().filter(|m| params.methods.contains(&m.method));
    let ends = values(shown().flat_map(Measure::point), x);
    let others = |m: &Measure| m.point().into_iter().filter(|(axis, _)| axis != x).collect();
    let line = |(mut line, measures): (Line, Vec<&Measure>)| {
        let mut points: Vec<Bounded> = Vec::new();
        let method = experiment.methods.iter().find(|method| method.name == line.method);
        let operated = method.filter(|method| method.variants.len() > 1).and_then(operating::variant);
        line.published = published::along(experiment, measures[0], metric, x);
        for m in measures {
            let own = m.point().into_iter().find(|(axis, _)| axis == x).map(|(_, at)| at);
            let (value, bounds) = (m.value(metric).unwrap_or(f64::NAN), scope.bounds(m, metric));
            line.marked |= own.is_some();
            // A method that knows nothing of the axis is the same all along it.
            let along = own.map_or(ends.clone(), |at| vec![at]);
            points.extend(along.into_iter().map(|at| ((at, value), bounds)));
            if operated.is_some_and(|v| v.params() == m.params) {
                line.operating = own.map(|at| (at, value));
            }
        }
        points.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
        (line.points, line.band) = points.into_iter().unzip();
        line
    };
    let lines: Vec<Line> = curves(shown(), others).into_iter().map(line).collect();
    let axes = (Axis::new(&capitalized(x), Range::Auto), Axis::new(&metric.title(), Range::FromZero));
    let mut figure = arrange(experiment, &scope.note, axes, &lines);
    let style = Style { width: 1.1, ..Style::new(Color::GRAY, Dash::DASHED) };
    let known = experiment.methods.iter().filter(|m| params.methods.contains(&m.name));
    let published = values(known.filter_map(operating::published).flatten(), x);
    for at in published.into_iter().filter(|at| ends.contains(at)) {
        let entry = Entry::new(Symbol::Upright(style), format!("published {x} {at}"));
        rule(&mut figure, &Mark::Upright(at, style), entry);
    }
    let has_ring = lines.iter().any(|line| line.operating.is_some());
    let remark = if has_ring { " Rings are at the published parameters." } else { "" };
    of_curves(figure, remark, format!("{} has no value for any {x}", metric.name()))
}

/// Adds a mark to all panels, behind all others.
fn behind(figure: &mut Figure, mark: &Mark) {
    figure.rows.iter_mut().flatten().for_each(|panel| panel.marks.insert(0, mark.clone()));
}

/// Adds a mark to all panels, behind all others, with an entry at the end of the legend.
fn rule(figure: &mut Figure, mark: &Mark, entry: Entry) {
    behind(figure, mark);
    figure.legend.push(entry);
}

/// Legend entry of chance level.
fn chance() -> Entry {
    Entry::new(Symbol::Line(CHANCE, None), "chance")
}

/// Area under precision over recall as a sum of steps. Each point contributes its precision times the recall
/// that it adds to earlier points (in order of recall, from 0).
fn average_precision(points: &[(f64, f64)]) -> f64 {
    let mut before = 0.0;
    let mut area = 0.0;
    for (recall, precision) in points.iter().filter(|p| p.0.is_finite() && p.1.is_finite()) {
        area += (recall - before) * precision;
        before = *recall;
    }
    area
}

/// A point of a curve, with the measure behind it.
#[derive(Clone, Copy)]
struct At {
    point: (f64, f64),
    bounds: (f64, f64),
    /// Value by which points are ordered; larger is better.
    worth: f64,
    is_published: bool,
}

/// Sorts the points of a curve by recall if one of the metrics is recall, else by the metric along x. Thus
/// the curve does not turn back where a threshold finds less than a stricter one. Of equal points the best is
/// first.
fn ordered(points: &mut [At], y: Metric) {
    let by_y = y == Metric::RECALL;
    let key = |at: &At| if by_y { (at.point.1, at.point.0) } else { (at.point.0, -at.point.1) };
    points.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
}

/// Draws one metric over another, with a curve for each tracker, method and combination of the axes after the
/// first.
pub(super) fn curve(scope: &Scope<'_>) -> Result<(Figure, String), ReportError> {
    let params = &scope.figure.params;
    let y = *scope.given("metric", params.metric.as_ref())?;
    let x = *scope.given("x", params.x_metric.as_ref())?;
    let (results, experiment) = (scope.results, &scope.results.experiment);
    let best_by = ordering_metric(experiment);
    let is_precision_recall = (x, y) == (Metric::RECALL, Metric::PRECISION);
    let (mut lines, mut has_published, mut has_best) = (Vec::new(), false, false);
    let measures =
        params.methods.iter().flat_map(|method| results.measures.iter().filter(move |m| m.method == *method));
    for (mut line, measures) in curves(measures, |m| m.point().into_iter().skip(1).collect()) {
        let known = experiment.methods.iter().find(|m| m.name == line.method);
        let operated = known.and_then(operating::variant);
        let at = |m: &&Measure| At {
            point: (m.value(x).unwrap_or(f64::NAN), m.value(y).unwrap_or(f64::NAN)),
            bounds: scope.bounds(m, y),
            worth: m.value(best_by).unwrap_or(f64::NEG_INFINITY),
            is_published: operated.is_some_and(|v| v.params() == m.params),
        };
        let mut points: Vec<At> = measures.iter().map(at).collect();
        points.retain(|at| at.point.0.is_finite() && at.point.1.is_finite());
        ordered(&mut points, y);
        line.marked = true;
        line.published = published::point(experiment, measures[0], x, y).into_iter().collect();
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
        lines.push(line);
    }
    let best = has_best.then_some(best_by.heading);
    let about = json!({ "published": has_published, "best": best, "has_area": is_precision_recall });
    let all = |side: fn(&(f64, f64)) -> f64| lines.iter().flat_map(|l| &l.points).map(side);
    let bounds = lines.iter().flat_map(|l| &l.band).flat_map(|b| [b.0, b.1]).filter(|b| b.is_finite());
    let axes = (
        Axis::new(&x.title(), range(x, all(|p| p.0))),
        Axis::new(&y.title(), range(y, all(|p| p.1).chain(bounds))),
    );
    let figure = arrange(experiment, &scope.note, axes, &lines);
    let mut figure = Figure { form: Form::Square, ..figure };
    if is_precision_recall {
        behind(&mut figure, &Mark::IsoF);
    }
    let reason = format!("{} and {} have no value", y.name(), x.name());
    if (x, y) == (Metric::FPR, Metric::RECALL) && lines.iter().any(|line| !line.points.is_empty()) {
        rule(&mut figure, &Mark::line(vec![(0.0, 0.0), (1.0, 1.0)], CHANCE), chance());
    }
    of_curves(figure, &say("curve", about), reason)
}

/// Range of an axis. Shares begin at 0 and end at 1, or earlier if there are no values near 1; other metrics
/// end at their values.
fn range(metric: Metric, values: impl Iterator<Item = f64> + Clone) -> Range {
    let highest = values.clone().fold(0.0, f64::max);
    let end = [0.1, 0.2, 0.5, 1.0].into_iter().find(|end| highest <= *end);
    let is_share = metric.unit.is_empty() && values.clone().all(|v| v >= 0.0);
    match end.filter(|_| is_share) {
        Some(end) => Range::Fixed(0.0, end),
        None if values.clone().all(|v| v >= 0.0) => Range::FromZero,
        None => Range::Auto,
    }
}

/// Draws the share of events that are detected within a number of frames, with a curve for each method
/// without a grid, for each of its trackers. Only first runs count.
pub(super) fn delay(scope: &Scope<'_>) -> Result<(Figure, String), ReportError> {
    let (results, mut found) = (scope.results, Vec::new());
    for tracker in &results.experiment.trackers {
        for method in &scope.figure.params.methods {
            let Some(protocol) = results.experiment.protocol_of(method) else { continue };
            let score = |track: &TrackSeries| {
                let series = track.method(method)?;
                Some(track.judge(protocol, &series.alarm, &series.changes))
            };
            let tracks = scope.tracks.iter().filter(|track| track.tracker == tracker.label);
            let scores: Vec<TrackScore> = tracks.filter_map(score).collect();
            found.push((method, tracker, scores));
        }
    }
    let window = window(found.iter().flat_map(|(.., scores)| scores));
    let line = |(method, tracker, scores): &(&String, &Tracker, Vec<TrackScore>)| {
        let (method, tracker) = ((*method).clone(), tracker.label.clone());
        let found = found_by(scores, window.clone(), &scope.units.sampling)?;
        let (points, band) = found.into_iter().unzip();
        Some(Line { method, tracker, points, band, ..Line::default() })
    };
    let lines: Vec<Line> = found.iter().filter_map(line).collect();
    let axes = (
        Axis::new("Frames after the event", Range::Auto),
        Axis::new("Share of events found", Range::Fixed(0.0, 1.0)),
    );
    let figure = arrange(&results.experiment, &scope.note, axes, &lines);
    of_curves(figure, "", "no method has an event to find".to_string())
}

/// Delays from minus to plus the tolerance of Khalid et al., and those of all matches.
fn window<'s>(scores: impl Iterator<Item = &'s TrackScore>) -> RangeInclusive<i64> {
    let tolerance = TOLERANCE as i64;
    let widen = |(low, high): (i64, i64), delay: i64| (low.min(delay), high.max(delay));
    let (low, high) = scores.flat_map(TrackScore::delays).fold((-tolerance, tolerance), widen);
    low..=high
}

/// For each delay d in frames, the share of all events whose matched detection came at most d frames after
/// the event, with its bounds by bootstrap over tracks, one per sequence; NaN if there are none. With all
/// delays in the window the curve ends at the recall. `None` without an event.
fn found_by(scores: &[TrackScore], window: RangeInclusive<i64>, sampling: &Sampling) -> Option<Vec<Bounded>> {
    let share = |c: &[i64; 2]| (c[1] > 0).then(|| c[0] as f64 / c[1] as f64);
    let at = |d: i64| {
        let found = |s: &TrackScore| s.delays().filter(|delay| *delay <= d).count() as i64;
        let units: Vec<[i64; 2]> = scores.iter().map(|s| [found(s), s.events.len() as i64]).collect();
        let sum = units.iter().fold([0; 2], |sum, unit| [sum[0] + unit[0], sum[1] + unit[1]]);
        let bounds = sampling.interval(&units, share).unwrap_or((f64::NAN, f64::NAN));
        Some(((d as f64, share(&sum)?), bounds))
    };
    window.map(at).collect()
}

/// Draws if scores rise before a loss: the area under the ROC curve of "a loss begins within k frames" over
/// k. There is a curve for each method without a grid, on all trackers together if the experiment pools them,
/// else on each tracker.
pub(super) fn warning(scope: &Scope<'_>) -> Result<(Figure, String), ReportError> {
    let experiment = &scope.results.experiment;
    let trackers: Vec<&str> = match experiment.leaderboard {
        true => vec![EVERY_TRACKER],
        false => experiment.trackers.iter().map(|tracker| tracker.label.as_str()).collect(),
    };
    let lines: Vec<Line> = trackers
        .into_iter()
        .flat_map(|tracker| scope.figure.params.methods.iter().map(move |method| (tracker, method)))
        .filter_map(|(tracker, method)| {
            let key = [tracker.to_string(), method.clone(), String::new()];
            let points = warned(scope.results.frame_measures.get(&key)?);
            let (points, band) = points.into_iter().unzip();
            let (method, tracker) = (method.clone(), tracker.to_string());
            Some(Line { method, tracker, points, band, marked: true, ..Line::default() })
        })
        .collect();
    let axes =
        (Axis::new("Frames before the loss, at most", Range::FromZero), Axis::new("AUROC", Range::Auto));
    let mut figure = arrange(experiment, &scope.note, axes, &lines);
    rule(&mut figure, &Mark::Level(0.5, CHANCE), chance());
    of_curves(figure, "", "no method has a score before a loss".to_string())
}

/// Measure of each horizon; NaN if there is none.
fn warned(measures: &FrameMeasures) -> Vec<Bounded> {
    let point = |horizon: usize| {
        let estimate = Estimate::of_frames(measures, &format!("auroc_within_{horizon}"));
        let none = (f64::NAN, f64::NAN);
        ((horizon as f64, estimate.value.unwrap_or(f64::NAN)), estimate.bounds.unwrap_or(none))
    };
    HORIZONS.map(point).into()
}

#[cfg(test)]
mod tests;
