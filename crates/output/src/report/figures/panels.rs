//! The panels of a strip figure.

use crate::figure::{Color, Dash, Edge, FrameAxis, Panel, Range, Series, Style, Threshold, spans_where};
use crate::report::colors;
use crate::report::stills;
use crate::results::{Results, TrackSeries};
use trackfail_engine::spec::figure;
use trackfail_methods::detector::Condition;
use trackfail_methods::score::{TrackScore, sanmiguel2015};

/// One panel over the frames of a track.
pub fn panel(results: &Results, tracker: &str, track: &TrackSeries, kind: &figure::Panel) -> Panel {
    let over = Over { results, tracker, track };
    match kind {
        figure::Panel::Error => over.error(),
        figure::Panel::Signal(method) => over.signal(method, false),
        figure::Panel::Forecast(method) => over.signal(method, true),
        figure::Panel::Labels(methods) => over.labels(methods),
        figure::Panel::Condition(methods) => over.conditions(methods),
        figure::Panel::Score(methods) => over.scores(methods),
    }
}

/// A track, and the results it is from.
struct Over<'r> {
    results: &'r Results,
    tracker: &'r str,
    track: &'r TrackSeries,
}

impl Over<'_> {
    /// A panel without lines, with the frames shaded in which the target is lost.
    fn blank(&self, label: &str) -> Panel {
        let first = self.track.numbers.first().copied().unwrap_or(1);
        let frames = FrameAxis { first: u32::try_from(first).unwrap_or(0), count: self.track.error.len() };
        let lost: Vec<bool> = self.track.error.iter().map(|e| *e >= 1.0).collect();
        Panel { spans: spans_where(&lost), ..Panel::new(label, frames) }
    }

    /// Events and detections of a method by its protocol; events alone where it raised no alarm.
    fn judged(&self, method: &str) -> TrackScore {
        let Some(protocol) = self.results.experiment.protocol_of(method) else {
            return TrackScore::default();
        };
        let series = self.track.method(method);
        let (alarm, changes) = series.map_or((&[][..], &[][..]), |m| (&m.alarm[..], &m.changes[..]));
        self.track.judge(protocol, alarm, changes)
    }

    /// The color of a method.
    fn color(&self, method: &str) -> Color {
        colors::color(&self.results.experiment, method)
    }

    /// The line of a method; it is whole, as it steps up and down.
    fn style(&self, method: &str) -> Style {
        Style::new(self.color(method), Dash::Solid)
    }

    /// Events with what happens in them: the target is found where the tracker is not lost any more.
    fn signed(&self, events: Vec<usize>) -> Vec<(usize, Edge)> {
        let found = sanmiguel2015::events(&self.track.error);
        let edge = |t: usize| if found.get(t) == Some(&-1) { Edge::Ends } else { Edge::Begins };
        events.into_iter().map(|t| (t, edge(t))).collect()
    }

    /// Detections of a method, by whether its alarm begins or ends there.
    fn edges(&self, method: &str, detections: Vec<usize>) -> Vec<(usize, Edge)> {
        let changes = self.track.method(method).map_or(&[][..], |m| &m.changes);
        let edge = |t: usize| if changes.get(t).is_some_and(|c| *c < 0) { Edge::Ends } else { Edge::Begins };
        detections.into_iter().map(|t| (t, edge(t))).collect()
    }

    fn error(&self) -> Panel {
        Panel {
            range: Range::Fixed(0.0, 1.0),
            series: vec![Series {
                name: "Oₜ".into(),
                values: self.track.error.clone(),
                style: Style::new(Color::Black, Dash::Solid),
            }],
            events: self.signed(stills::events(self.results, self.track)),
            ..self.blank("Oₜ")
        }
    }

    fn signal(&self, method: &str, with_forecast: bool) -> Panel {
        let Some(m) = self.track.method(method) else { return self.blank(method) };
        let symbol = symbol(self.results, method);
        let line = |name: &str, values: &[f64], color, dash| Series {
            name: name.into(),
            values: values.to_vec(),
            style: Style::new(color, dash),
        };
        let mut series = vec![line(symbol, &m.signal, self.color(method), Dash::Solid)];
        if with_forecast {
            series.push(line("forecast", &m.forecast, Color::Black, Dash::Dashed));
        }
        let events = self.signed(self.judged(method).events);
        Panel { series, events, ..self.blank(&format!("{symbol} ({method})")) }
    }

    /// Lanes with the names of the methods, the first at the top; an alarm lifts a method's line.
    fn labels(&self, methods: &[String]) -> Panel {
        let base = |i: usize| (methods.len() - 1 - i) as f64;
        let lane = |(i, method): (usize, &String)| {
            let alarm = self.track.method(method).map(|m| m.alarm.clone()).unwrap_or_default();
            let height = |t: usize| base(i) + if alarm.get(t) == Some(&true) { 0.75 } else { 0.1 };
            let values = (0..self.track.error.len()).map(height).collect();
            Series { name: method.clone(), values, style: self.style(method) }
        };
        Panel {
            range: Range::Fixed(0.0, methods.len() as f64),
            names: methods.iter().enumerate().map(|(i, m)| (base(i) + 0.4, m.clone())).collect(),
            series: methods.iter().enumerate().map(lane).collect(),
            legend: false,
            events: methods.first().map_or(Vec::new(), |m| self.signed(self.judged(m).events)),
            ..self.blank("alarm")
        }
    }

    /// Rows with the names of the conditions, the best at the top. Lines of several methods lie a little apart.
    fn conditions(&self, methods: &[String]) -> Panel {
        let apart = |i: usize| 0.05 * ((methods.len() - 1) as f64 / 2.0 - i as f64);
        let lane = |(i, method): (usize, &String)| {
            let values = self.track.method(method).map(|m| m.condition.clone()).filter(|c| !c.is_empty());
            let values = values.unwrap_or_else(|| vec![f64::NAN; self.track.error.len()]);
            let values = values.into_iter().map(|v| v + apart(i)).collect();
            Series { name: method.clone(), values, style: self.style(method) }
        };
        let all = [Condition::LockedOn, Condition::LockingIn, Condition::Scanning];
        Panel {
            range: Range::Fixed(-0.15, 1.15),
            names: all.map(|c| (c.level(), c.name().to_string())).into(),
            series: methods.iter().enumerate().map(lane).collect(),
            ..self.blank("condition")
        }
    }

    fn scores(&self, methods: &[String]) -> Panel {
        // The score of a forecast is the size of its error z; other scores go by their method's name.
        let label = |name: &String| {
            let series = self.track.method(name);
            let has_forecast = series.is_some_and(|m| m.forecast.iter().any(|f| f.is_finite()));
            if has_forecast { format!("|zₜ| ({name})") } else { name.clone() }
        };
        let labels: Vec<String> = methods.iter().map(label).collect();
        let mut drawn = self.blank(&labels.join(", "));
        for method in methods {
            let Some(m) = self.track.method(method) else { continue };
            let style = self.style(method);
            drawn.series.push(Series { name: method.clone(), values: m.score.clone(), style });
            let record = self.results.manifest.method(method);
            let threshold = record.and_then(|r| r.thresholds.get(self.tracker));
            let known = |t: &f64| drawn.thresholds.iter().any(|d: &Threshold| d.value == *t);
            if let Some(value) = threshold.filter(|t| !known(t)) {
                drawn.thresholds.push(Threshold {
                    name: format!("threshold {value}"),
                    value: *value,
                    style: Style::new(Color::Gray, Dash::Dashed),
                });
            }
            let score = self.judged(method);
            drawn.events = self.signed(score.events);
            if methods.len() == 1 {
                drawn.alarms = self.edges(method, score.detections);
                drawn.alarm_color = style.color;
            }
        }
        drawn
    }
}

/// The letter of the signal that a method reads.
fn symbol(results: &Results, method: &str) -> &'static str {
    let method = results.experiment.methods.iter().find(|m| m.name == method);
    let signal = method.and_then(|m| m.variants.first()).and_then(|v| v.signal.as_ref());
    signal.map_or("yₜ", |s| s.signal.symbol())
}
