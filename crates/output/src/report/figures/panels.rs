//! The panels of a strip figure.

use crate::figure::{Color, Dash, FrameAxis, Panel, Range, Series, Style, Threshold, spans_where};
use crate::report::results::{Results, TrackSeries};
use crate::report::stills;
use crate::score::TrackScore;
use crate::spec::figure;

/// One panel over the frames of a track.
pub fn panel(results: &Results, tracker: &str, track: &TrackSeries, kind: &figure::Panel) -> Panel {
    let first = track.numbers.first().copied().unwrap_or(1);
    let frames = FrameAxis { first: u32::try_from(first).unwrap_or(0), count: track.error.len() };
    let judged = |method: &str| -> TrackScore {
        let (no_alarm, no_change) = (vec![false; track.error.len()], vec![0; track.error.len()]);
        let (alarm, changes) =
            track.method(method).map_or((&no_alarm, &no_change), |m| (&m.alarm, &m.changes));
        let protocol = results.experiment.protocol_of(method);
        protocol.map_or_else(TrackScore::default, |p| (p.score)(&track.error, alarm, changes))
    };
    let lost: Vec<bool> = track.error.iter().map(|e| *e >= 1.0).collect();
    let blank = |label: &str| Panel { spans: spans_where(&lost), ..Panel::new(label, frames) };
    match kind {
        figure::Panel::Error => Panel {
            range: Range::Fixed(0.0, 1.0),
            series: vec![Series {
                name: "Oₜ".into(),
                values: track.error.clone(),
                style: Style::new(Color::Black, Dash::Solid),
            }],
            events: stills::events(results, track),
            ..blank("Oₜ")
        },
        figure::Panel::Signal(method) | figure::Panel::Forecast(method) => {
            let Some(m) = track.method(method) else { return blank(method) };
            let mut series = vec![Series {
                name: symbol(results, method).into(),
                values: m.signal.clone(),
                style: Style::new(Color::Blue, Dash::Solid),
            }];
            if matches!(kind, figure::Panel::Forecast(_)) {
                series.push(Series {
                    name: "forecast".into(),
                    values: m.forecast.clone(),
                    style: Style::new(Color::Vermilion, Dash::Dashed),
                });
            }
            Panel {
                series,
                events: judged(method).events,
                ..blank(&format!("{} ({method})", symbol(results, method)))
            }
        }
        figure::Panel::Labels(methods) => {
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
        figure::Panel::Condition(methods) => {
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
        figure::Panel::Score(methods) => {
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
                        style: Style::new(Color::Gray, Dash::Dashed),
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

/// The letter of the signal that a method reads.
fn symbol(results: &Results, method: &str) -> &'static str {
    let method = results.experiment.methods.iter().find(|m| m.name == method);
    let signal = method.and_then(|m| m.variants.first()).and_then(|v| v.signal.as_ref());
    signal.map_or("yₜ", |s| s.signal.symbol())
}
