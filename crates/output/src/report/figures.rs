//! The figures an experiment asks for, from its results.

use super::delays;
use super::results::{Results, ResultsError, TrackSeries};
use super::stills;
use crate::analysis::Chart;
use crate::detector::Condition;
use crate::detector::track_quality::machine::{Action, TRANSITIONS, Transition};
use crate::engine::execute::analyse::Analysed;
use crate::figure::{
    Arrow, BoxStyle, Colour, Curve, Curves, Dash, FigureError, FrameAxis, Panel, Range, Series, States,
    Still, Strip, Style, Threshold, spans_where,
};
use crate::region::Region;
use crate::score::TrackScore;
use crate::score::measures::Metric;
use crate::signal::distribution_field::{self, Displacement};
use crate::spec::table::{self, Figure, FigureKind, Made};
use crate::table::folder;
use crate::table::measures::Measure;
use crate::table::number;
use std::collections::BTreeMap;

/// A figure drawn.
pub struct Drawn {
    /// Name, also of its files.
    pub name: String,
    /// Caption, with the data it rests on.
    pub caption: String,
    /// SVG text.
    pub svg: String,
    /// PNG bytes.
    pub png: Vec<u8>,
}

/// Why a figure is not there.
#[derive(Debug, thiserror::Error)]
pub enum DrawError {
    /// The results cannot be read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The drawing failed.
    #[error("figure {name}: {error}")]
    Figure {
        /// Name of the figure.
        name: String,
        /// What went wrong.
        error: FigureError,
    },
}

/// Draws one figure; `None`, with a reason, where its data is not there.
///
/// # Errors
/// When results cannot be read or the drawing fails.
pub fn draw(results: &Results, figure: &Figure) -> Result<Result<Drawn, String>, DrawError> {
    let note = folder::data_note(&results.experiment, &results.manifest);
    let note = format!("suite {}: {note}", results.manifest.suite.name);
    let fail = |error| DrawError::Figure { name: figure.name.clone(), error };
    let lines = |curves: Curves, nothing: String| -> Result<Result<_, String>, DrawError> {
        if curves.series.iter().flat_map(|c| &c.points).all(|p| p.1.is_nan()) {
            return Ok(Err(nothing));
        }
        Ok(Ok((curves.to_svg().map_err(fail)?, curves.to_png().map_err(fail)?, String::new())))
    };
    let drawn = match &figure.kind {
        FigureKind::Strips { tracker, sequences, panels, stills } => {
            let tracker = stills::tracker(results, tracker.as_deref());
            let tracks = results.tracks(tracker)?;
            let tracks: Vec<&TrackSeries> = tracks.iter().collect();
            let shown = stills::chosen(results, sequences, &tracks);
            if shown.is_empty() {
                return Ok(Err(format!("none of its sequences is there with tracker {tracker}")));
            }
            let absent: Vec<&str> = sequences
                .iter()
                .filter(|name| !shown.iter().any(|t| t.sequence == **name))
                .map(String::as_str)
                .collect();
            let mut strip = strip(results, &note, tracker, &shown, panels);
            if *stills > 0 {
                strip.stills = load_stills(results, figure, &tracks)?;
            }
            let extra = match absent.as_slice() {
                [] => String::new(),
                names => format!(" Not here: {}.", names.join(", ")),
            };
            Ok((strip.to_svg().map_err(fail)?, strip.to_png().map_err(fail)?, extra))
        }
        FigureKind::Machine => {
            let states = machine();
            Ok((states.to_svg().map_err(fail)?, states.to_png().map_err(fail)?, String::new()))
        }
        FigureKind::Chart(shows) => {
            lines(chart(results, shows), format!("there is no analysis {}", shows.analysis))?
        }
        FigureKind::Sweep { metric, x, methods } => {
            let nothing = format!("{} has no value for any {x}", metric.name());
            lines(sweep(results, &note, *metric, x, methods), nothing)?
        }
        FigureKind::Delay { methods } => {
            lines(delays::delays(results, &note, methods)?, "no method has an event to find".to_string())?
        }
        FigureKind::Curve { y, x, methods } => {
            let nothing = format!("{} and {} have no value", y.name(), x.name());
            lines(curve(results, &note, *y, *x, methods), nothing)?
        }
    };
    let (svg, png, extra) = match drawn {
        Ok(drawn) => drawn,
        Err(nothing) => return Ok(Err(nothing)),
    };
    let caption = format!("{} ({note}.{extra})", figure.caption.as_deref().unwrap_or(&figure.name));
    Ok(Ok(Drawn { name: figure.name.clone(), caption, svg, png }))
}

fn strip(
    results: &Results,
    note: &str,
    tracker: &str,
    shown: &[&TrackSeries],
    panels: &[Vec<table::Panel>],
) -> Strip {
    let single = shown.len() == 1;
    let mut strip = Strip {
        title: String::new(),
        note: format!("{tracker}, {note}"),
        stills: Vec::new(),
        headings: Vec::new(),
        rows: Vec::new(),
    };
    if single {
        strip.title = shown[0].sequence.clone();
        let mut letter = 'a';
        for row in panels {
            let mut drawn: Vec<Panel> = row.iter().map(|p| panel(results, tracker, shown[0], p)).collect();
            for p in &mut drawn {
                p.caption = format!("({letter})");
                letter = char::from_u32(letter as u32 + 1).unwrap_or('z');
            }
            strip.rows.push(drawn);
        }
    } else {
        // A column a sequence, all panels below each other.
        strip.headings = shown.iter().map(|t| t.sequence.clone()).collect();
        for kind in panels.iter().flatten() {
            strip.rows.push(shown.iter().map(|t| panel(results, tracker, t, kind)).collect());
        }
    }
    strip
}

fn panel(results: &Results, tracker: &str, track: &TrackSeries, kind: &table::Panel) -> Panel {
    let first = track.numbers.first().copied().unwrap_or(1);
    let frames = FrameAxis { first: u32::try_from(first).unwrap_or(0), count: track.error.len() };
    let judged = |method: &str| -> TrackScore {
        let (silent, still) = (vec![false; track.error.len()], vec![0; track.error.len()]);
        let said = track.method(method).map_or((&silent, &still), |m| (&m.alarm, &m.changes));
        let protocol = results.experiment.protocol_of(method);
        protocol.map_or_else(TrackScore::default, |p| (p.score)(&track.error, said.0, said.1))
    };
    let lost: Vec<bool> = track.error.iter().map(|e| *e >= 1.0).collect();
    let blank = |label: &str| Panel { spans: spans_where(&lost), ..Panel::new(label, frames) };
    match kind {
        table::Panel::Error => Panel {
            range: Range::Fixed(0.0, 1.0),
            series: vec![Series {
                name: "Oₜ".into(),
                values: track.error.clone(),
                style: Style::new(Colour::Black, Dash::Solid),
            }],
            events: stills::events(results, track),
            ..blank("Oₜ")
        },
        table::Panel::Signal(method) | table::Panel::Forecast(method) => {
            let Some(m) = track.method(method) else { return blank(method) };
            let mut series = vec![Series {
                name: symbol(results, method).into(),
                values: m.signal.clone(),
                style: Style::new(Colour::Blue, Dash::Solid),
            }];
            if matches!(kind, table::Panel::Forecast(_)) {
                series.push(Series {
                    name: "forecast".into(),
                    values: m.forecast.clone(),
                    style: Style::new(Colour::Vermilion, Dash::Dashed),
                });
            }
            Panel {
                series,
                events: judged(method).events,
                ..blank(&format!("{} ({method})", symbol(results, method)))
            }
        }
        table::Panel::Labels(methods) => {
            // Lanes from above in the order of the methods; a label lifts its line.
            let lane = |(i, method): (usize, &String)| {
                let base = (methods.len() - 1 - i) as f64;
                let alarm = track.method(method).map(|m| m.alarm.clone()).unwrap_or_default();
                let height = |t: usize| base + if alarm.get(t) == Some(&true) { 0.75 } else { 0.1 };
                let values = (0..track.error.len()).map(height).collect();
                Series { name: method.clone(), values, style: Style::nth(i) }
            };
            Panel {
                range: Range::Fixed(0.0, methods.len() as f64),
                series: methods.iter().enumerate().map(lane).collect(),
                events: methods.first().map_or(Vec::new(), |m| judged(m).events),
                ..blank("label")
            }
        }
        table::Panel::Condition(methods) => {
            let lane = |(i, method): (usize, &String)| {
                let values = track.method(method).map(|m| m.condition.clone()).filter(|c| !c.is_empty());
                let values = values.unwrap_or_else(|| vec![f64::NAN; track.error.len()]);
                Series { name: method.clone(), values, style: Style::nth(i) }
            };
            Panel {
                range: Range::Fixed(-0.1, 1.1),
                series: methods.iter().enumerate().map(lane).collect(),
                ..blank("condition")
            }
        }
        table::Panel::Score(methods) => {
            // A forecast's score is the size of its error z; other scores go by their method's name.
            let label = |name: &String| {
                let has_forecast =
                    track.method(name).is_some_and(|m| m.forecast.iter().any(|f| f.is_finite()));
                if has_forecast { format!("|zₜ| ({name})") } else { name.clone() }
            };
            let labels: Vec<String> = methods.iter().map(label).collect();
            let mut drawn = blank(&labels.join(", "));
            for (i, method) in methods.iter().enumerate() {
                let Some(m) = track.method(method) else { continue };
                let style = Style::nth(i);
                drawn.series.push(Series { name: method.clone(), values: m.score.clone(), style });
                let threshold = results.manifest.method(method).and_then(|r| r.thresholds.get(tracker));
                let known = |t: &f64| drawn.thresholds.iter().any(|d: &Threshold| d.value == *t);
                if let Some(value) = threshold.filter(|t| !known(t)) {
                    drawn.thresholds.push(Threshold {
                        name: format!("threshold {value}"),
                        value: *value,
                        style: Style::new(Colour::Grey, Dash::Dashed),
                    });
                }
                let score = judged(method);
                drawn.events = score.events;
                if methods.len() == 1 {
                    drawn.detections = score.detections;
                }
            }
            drawn
        }
    }
}

fn load_stills(
    results: &Results,
    figure: &Figure,
    tracks: &[&TrackSeries],
) -> Result<Vec<Still>, ResultsError> {
    let Some(request) = stills::request(results, figure, tracks) else { return Ok(Vec::new()) };
    let Some(track) = tracks.iter().find(|t| t.sequence == request.sequence) else { return Ok(Vec::new()) };
    let truth: BTreeMap<(String, i64), Region> = results.truth()?;
    // The region around the target that a distribution field is compared with.
    let signals =
        results.experiment.methods.iter().flat_map(|m| &m.variants).filter_map(|v| v.signal.as_ref());
    let has_background = signals.into_iter().any(|s| s.kind == distribution_field::ENTRY.kind);
    let mut all = Vec::new();
    for t in request.frames {
        // Results of a run that could not decode the frame again have no still; the rest is shown.
        let Ok(pixels) = stills::load(results, &request.figure, t) else { continue };
        let number = track.numbers[t];
        let (past, current) = (&track.rects[..t], &track.rects[t]);
        let history = distribution_field::Params::default().history;
        let background = distribution_field::background_region(past, current, history, Displacement::Past);
        let mut boxes = vec![(Region::Rect(track.rects[t]), BoxStyle::State)];
        if has_background {
            boxes.insert(0, (Region::Rect(background), BoxStyle::Background));
        }
        if let Some(region) = truth.get(&(track.sequence.clone(), number)) {
            boxes.push((region.clone(), BoxStyle::Truth));
        }
        let caption = if track.error[t] >= 1.0 { "lost".to_string() } else { String::new() };
        all.push(Still { number: u32::try_from(number).unwrap_or(0), pixels, boxes, caption });
    }
    Ok(all)
}

/// The letter of the signal that a method reads.
fn symbol(results: &Results, method: &str) -> &'static str {
    let method = results.experiment.methods.iter().find(|m| m.name == method);
    let signal = method.and_then(|m| m.variants.first()).and_then(|v| v.signal.as_ref());
    signal.map_or("yₜ", |s| s.signal.symbol())
}

/// What an analysis made, on every tracker.
fn chart(results: &Results, shows: &Made) -> Curves {
    let found: Vec<(&Analysed, &Chart)> = results
        .analyses
        .iter()
        .filter(|a| a.analysis == shows.analysis)
        .filter_map(|a| Some((a, a.findings.charts.iter().find(|c| c.name == shows.part)?)))
        .collect();
    let several = found.len() > 1;
    let named = |(analysed, chart): &(&Analysed, &Chart)| {
        let who = &analysed.tracker;
        let named = |(name, points): &(String, Vec<(f64, f64)>)| {
            let name = match name.as_str() {
                "" => who.clone(),
                value if value.starts_with('[') => format!("{who} {value}"),
                _ if several => format!("{who}, {name}"),
                _ => name.clone(),
            };
            (name, points.clone())
        };
        chart.curves.iter().map(named).collect::<Vec<_>>()
    };
    let of_first = |text: fn(&Chart) -> &str| found.first().map_or("", |(_, c)| text(c));
    let note = found.first().map(|(a, _)| format!("{}, {}", a.suites_note(), number::runs(a.runs)));
    let curves = found.iter().flat_map(named).collect();
    Curves {
        y_log: found.first().is_some_and(|(_, c)| c.y_log),
        ..plain(&note.unwrap_or_default(), of_first(|c| &c.x), of_first(|c| &c.y), curves)
    }
}

/// The state machine of ARTE, drawn from its own table.
fn machine() -> States {
    let states = [Condition::LockedOn, Condition::LockingIn, Condition::Scanning];
    let place = |c: Condition| states.iter().position(|s| *s == c).unwrap_or(0);
    let arrow = |row: &Transition| {
        let done = (row.then != Action::Nothing).then(|| format!("{}: {}", row.on.name(), row.then.name()));
        Arrow { from: place(row.from), to: place(row.to), label: vec![done.unwrap_or(row.on.name().into())] }
    };
    States {
        title: String::new(),
        note: "of the events of a frame the first in the table's order counts".into(),
        states: states.map(|c| c.name().to_string()).into(),
        arrows: TRANSITIONS.iter().map(arrow).collect(),
    }
}

/// Curves by name on linear axes, the vertical one from 0.
pub(super) fn plain(note: &str, x: &str, y: &str, curves: Vec<(String, Vec<(f64, f64)>)>) -> Curves {
    let curve = |(i, (name, points))| Curve { name, points, style: Style::nth(i) };
    Curves {
        title: String::new(),
        note: note.to_string(),
        x_label: x.to_string(),
        y_label: y.to_string(),
        x_log: false,
        y_log: false,
        x_range: Range::Auto,
        y_range: Range::FromZero,
        square: false,
        series: curves.into_iter().enumerate().map(curve).collect(),
        marks: Vec::new(),
    }
}

fn sweep(results: &Results, note: &str, metric: Metric, x: &str, methods: &[String]) -> Curves {
    // One curve for each tracker, method and combination of the other axes.
    let mut curves: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
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

/// One metric over another: for each tracker and method its grid points in the grid's order, along the first
/// axis; a curve for each combination of the others.
fn curve(results: &Results, note: &str, y: Metric, x: Metric, methods: &[String]) -> Curves {
    let mut shown: Vec<&Measure> = results.measures.iter().filter(|m| methods.contains(&m.method)).collect();
    let several = shown.iter().any(|m| m.tracker != shown[0].tracker);
    let along = |m: &Measure| m.point().first().map_or(0.0, |(_, at)| *at);
    // Stable, so that methods stay in the order of the experiment.
    shown.sort_by(|a, b| along(a).total_cmp(&along(b)));
    let mut curves: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
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
