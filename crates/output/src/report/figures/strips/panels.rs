//! The panels of a strip figure.

use crate::figure::{Axis, Color, Dash, Entry, Mark, Marker, Panel, Range, Style, Symbol};
use crate::report::colors;
use crate::report::figures::lines::distinct;
use crate::report::stills;
use crate::results::{Results, TrackSeries};
use trackfail_engine::spec::figure as spec;
use trackfail_methods::detector::Condition;
use trackfail_methods::score::frames::truth::runs;
use trackfail_methods::score::{TrackScore, sanmiguel2015};

/// Style of the line at which the target is lost.
pub const LOSS: Style = Style { color: Color::BLACK, dash: Dash::DOTTED, width: 1.0 };
/// Style of the line at which the target is found again.
pub const RECOVERY: Style = Style { color: Color::GRAY, dash: Dash::DASH_DOT, width: 1.0 };

/// Panel of one kind over the frames of a track.
pub fn panel(results: &Results, track: &TrackSeries, kind: &spec::Panel) -> Panel {
    let first = track.numbers.first().and_then(|first| u32::try_from(*first).ok()).unwrap_or(1);
    let over = Over { results, track, first };
    match kind {
        spec::Panel::Error => over.error(),
        spec::Panel::Signal(method) => over.signal(method, false),
        spec::Panel::Forecast(method) => over.signal(method, true),
        spec::Panel::Labels(methods) => over.labels(methods),
        spec::Panel::Condition(methods) => over.conditions(methods),
        spec::Panel::Score(methods) => over.scores(methods),
    }
}

/// A track with its results.
struct Over<'r> {
    results: &'r Results,
    track: &'r TrackSeries,
    /// Number of the first frame, as the sequence counts it.
    first: u32,
}

impl Over<'_> {
    /// Place of frame `t` (0-based) on the axis.
    fn at(&self, t: usize) -> f64 {
        f64::from(self.first) + t as f64
    }

    /// Panel without lines. Frames with a lost target are shaded.
    fn blank(&self, label: &str, range: Range) -> Panel {
        let lost: Vec<bool> = self.track.error.iter().map(|e| *e >= 1.0).collect();
        let shade =
            |run: std::ops::Range<usize>| Mark::Shade(self.at(run.start) - 0.5..self.at(run.end) - 0.5);
        Panel {
            x: Axis::frames(self.first, self.track.error.len()),
            y: Axis::new(label, range),
            marks: runs(&lost).into_iter().map(shade).collect(),
            ..Panel::default()
        }
    }

    /// Events and detections of a method by its protocol; events alone for a method without alarms.
    fn judged(&self, method: &str) -> TrackScore {
        let Some(protocol) = self.results.experiment.protocol_of(method) else {
            return TrackScore::default();
        };
        let series = self.track.method(method);
        let (alarm, changes) = series.map_or((&[][..], &[][..]), |m| (&m.alarm[..], &m.changes[..]));
        self.track.judge(protocol, alarm, changes)
    }

    /// Line style of a method: solid, unless another method has the same color. Such curves step up and down,
    /// so that dashes would be hard to see.
    fn style(&self, method: &str) -> Style {
        colors::style(&self.results.experiment, method).0
    }

    fn line(&self, values: &[f64], style: Style) -> Mark {
        Mark::line(values.iter().enumerate().map(|(t, value)| (self.at(t), *value)).collect(), style)
    }

    /// Marks of the events. A dash-dotted line is at the end of the loss.
    fn events(&self, events: &[usize]) -> Vec<Mark> {
        let found = sanmiguel2015::events(&self.track.error);
        let style = |t: usize| if found.get(t) == Some(&-1) { RECOVERY } else { LOSS };
        events.iter().map(|t| Mark::Upright(self.at(*t), style(*t))).collect()
    }

    fn error(&self) -> Panel {
        let mut panel = self.blank("Oₜ", Range::Fixed(0.0, 1.0));
        panel.marks.extend(self.events(&stills::events(self.results, self.track)));
        panel.marks.push(self.line(&self.track.error, Style::new(Color::BLACK, Dash::SOLID)));
        panel
    }

    fn signal(&self, method: &str, with_forecast: bool) -> Panel {
        let Some(m) = self.track.method(method) else { return self.blank(method, Range::Auto) };
        let symbol = symbol(self.results, method);
        let mut panel = self.blank(&format!("{symbol} ({method})"), Range::Auto);
        panel.marks.extend(self.events(&self.judged(method).events));
        let own = Style { dash: Dash::SOLID, ..self.style(method) };
        panel.marks.push(self.line(&m.signal, own));
        if with_forecast {
            let forecast = Style::new(Color::BLACK, Dash::DASHED);
            panel.marks.push(self.line(&m.forecast, forecast));
            let named = [(own, symbol), (forecast, "forecast")];
            panel.legend = named.map(|(style, name)| Entry::new(Symbol::Line(style, None), name)).into();
        }
        panel
    }

    /// Panel with one lane per method, the first at the top. An alarm lifts the line of its method.
    fn labels(&self, methods: &[String]) -> Panel {
        let base = |i: usize| (methods.len() - 1 - i) as f64;
        let mut panel = self.blank("alarm", Range::Fixed(0.0, methods.len() as f64));
        panel.y.names = methods.iter().enumerate().map(|(i, m)| (base(i) + 0.4, m.clone())).collect();
        let events = methods.first().map(|m| self.judged(m).events).unwrap_or_default();
        panel.marks.extend(self.events(&events));
        for (i, method) in methods.iter().enumerate() {
            let alarm = self.track.method(method).map(|m| m.alarm.clone()).unwrap_or_default();
            let height = |t: usize| base(i) + if alarm.get(t) == Some(&true) { 0.75 } else { 0.1 };
            let values: Vec<f64> = (0..self.track.error.len()).map(height).collect();
            panel.marks.push(self.line(&values, self.style(method)));
        }
        panel
    }

    /// Panel with one row per condition, the best at the top. Lines of several methods are shifted slightly.
    fn conditions(&self, methods: &[String]) -> Panel {
        let mut panel = self.blank("condition", Range::Fixed(-0.15, 1.15));
        let all = [Condition::LockedOn, Condition::LockingIn, Condition::Scanning];
        panel.y.names = all.map(|c| (c.level(), c.name().to_string())).into();
        for (i, method) in methods.iter().enumerate() {
            let apart = 0.05 * ((methods.len() - 1) as f64 / 2.0 - i as f64);
            let condition = self.track.method(method).map_or(&[][..], |m| &m.condition[..]);
            let values: Vec<f64> = condition.iter().map(|v| v + apart).collect();
            panel.marks.push(self.line(&values, self.style(method)));
            panel.legend.push(Entry::new(Symbol::Line(self.style(method), None), method.as_str()));
        }
        if methods.len() < 2 {
            panel.legend.clear();
        }
        panel
    }

    fn scores(&self, methods: &[String]) -> Panel {
        // The score of a forecast is the size of its error z; other scores go by their method's name.
        let label = |name: &String| {
            let series = self.track.method(name);
            let has_forecast = series.is_some_and(|m| m.forecast.iter().any(|f| f.is_finite()));
            if has_forecast { format!("|zₜ| ({name})") } else { name.clone() }
        };
        let labels: Vec<String> = methods.iter().map(label).collect();
        let mut panel = self.blank(&labels.join(", "), Range::Auto);
        let (mut lines, mut levels, mut events) = (Vec::new(), Vec::new(), Vec::new());
        let mut alarms: Vec<Mark> = Vec::new();
        for method in methods {
            let Some(m) = self.track.method(method) else { continue };
            let style = self.style(method);
            lines.push(self.line(m.compared(), style));
            panel.legend.push(Entry::new(Symbol::Line(style, None), method.as_str()));
            let record = self.results.manifest.method(method);
            levels.extend(record.and_then(|r| r.thresholds.get(&self.track.tracker)).copied());
            let score = self.judged(method);
            if methods.len() == 1 {
                let ends = |t: usize| m.changes.get(t).is_some_and(|c| *c < 0);
                let marker = |t: usize| if ends(t) { Marker::AlarmEnds } else { Marker::AlarmBegins };
                let alarm = |t: &usize| Mark::Top(self.at(*t), marker(*t), style.color);
                alarms = score.detections.iter().map(alarm).collect();
            }
            events = score.events;
        }
        if lines.len() < 2 {
            panel.legend.clear();
        }
        let style = Style::new(Color::GRAY, Dash::DASHED);
        panel.marks.extend(self.events(&events));
        for level in distinct(levels) {
            panel.marks.push(Mark::Level(level, style));
            panel.legend.push(Entry::new(Symbol::Line(style, None), format!("threshold {level}")));
        }
        panel.marks.extend(lines);
        panel.marks.extend(alarms);
        panel
    }
}

/// Symbol of the signal that a method reads.
fn symbol(results: &Results, method: &str) -> &'static str {
    let method = results.experiment.methods.iter().find(|m| m.name == method);
    let signal = method.and_then(|m| m.variants.first()).and_then(|v| v.signals.first());
    signal.map_or("yₜ", |s| s.signal.facts().symbol)
}
