//! Curves in panels. Colors are methods, line styles or panels are trackers, and ordered colors are values of
//! a parameter. If a panel would hold too many curves, each gets a panel of its own, with the others in gray
//! behind it.

use crate::figure::{Axis, Color, Dash, Entry, Figure, Mark, Marker, Panel, Style, Symbol};
use crate::report::colors;
use crate::results::grouped;
use crate::table::layout::is_anchor;
use trackfail_engine::spec::Experiment;

/// A curve of a method on a tracker.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Line {
    /// Name of the method.
    pub method: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Axes of the grid with their values, without the axis along the curve.
    pub others: Vec<(String, f64)>,
    /// Points in drawing order.
    pub points: Vec<(f64, f64)>,
    /// Bounds of each point; empty without any.
    pub band: Vec<(f64, f64)>,
    /// True if the points have markers.
    pub marked: bool,
    /// Operating point of the method.
    pub operating: Option<(f64, f64)>,
    /// Points that a paper prints.
    pub published: Vec<(f64, f64)>,
    /// Number that summarizes the curve, such as `AP .41`; may be empty.
    pub summary: String,
}

/// Look of a curve: panel, legend, line and marker.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Heading of the panel; `None` for a curve in all panels.
    pub panel: Option<String>,
    /// Legend entry. Equal entries are shown once.
    pub entry: Option<Entry>,
    /// Stroke of the line.
    pub style: Style,
    /// Marker of the points.
    pub marker: Option<Marker>,
}

/// Name of the operating point in legends.
pub const OPERATING: &str = "operating point";
/// Style of curves of other panels, drawn behind.
const BEHIND: Style = Style { color: Color([0xC9; 3]), dash: Dash::SOLID, width: 0.8 };
/// Most curves of a panel with bands. With more curves, each method has a panel of its own.
const MAX_CURVES: usize = 4;
/// Most curves of a panel in which line styles distinguish trackers.
const MAX_DASHED: usize = 8;

/// The items without repetitions, in order of first occurrence.
pub fn distinct<T: PartialEq>(all: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut known: Vec<T> = Vec::new();
    for value in all {
        if !known.contains(&value) {
            known.push(value);
        }
    }
    known
}

/// Arranges curves in panels, in order of first occurrence, and makes their legend; `more` is appended to it.
/// With `others`, the curves of other panels are drawn behind, in gray, under that name.
pub fn compose(
    note: &str,
    (x, y): (Axis, Axis),
    curves: &[(Look, Line)],
    others: Option<&str>,
    more: Vec<Entry>,
) -> Figure {
    let mut names = distinct(curves.iter().filter_map(|(look, _)| look.panel.as_deref()));
    if names.is_empty() {
        names.push("");
    }
    let panel = |name: &&str| {
        let (mine, rest): (Vec<_>, Vec<_>) =
            curves.iter().partition(|(look, _)| look.panel.as_deref().is_none_or(|panel| panel == *name));
        let behind = rest.iter().filter(|_| others.is_some());
        let mut marks: Vec<Mark> = behind.map(|(_, line)| Mark::line(line.points.clone(), BEHIND)).collect();
        let has_band = |l: &Line| l.points.len() > 1 && l.band.iter().any(|b| b.0.is_finite());
        let banded: Vec<_> = mine.iter().filter(|(_, line)| has_band(line)).collect();
        // Of many bands over each other none could be read.
        for (look, line) in banded.iter().filter(|_| banded.len() <= MAX_CURVES) {
            let bounds = line.points.iter().zip(&line.band).map(|(p, b)| (p.0, b.0, b.1));
            marks.push(Mark::Band(bounds.collect(), look.style.color));
        }
        marks.extend(mine.iter().map(|(look, line)| Mark::Line {
            points: line.points.clone(),
            style: look.style,
            marker: look.marker,
        }));
        for (look, line) in &mine {
            let sign = |at: &(f64, f64), marker| Mark::Point(*at, marker, look.style.color);
            marks.extend(line.operating.iter().map(|at| sign(at, Marker::Operating)));
            marks.extend(line.published.iter().map(|at| sign(at, Marker::Published)));
        }
        let title = if names.len() > 1 { (*name).to_string() } else { String::new() };
        Panel { title, x: x.clone(), y: y.clone(), marks, legend: Vec::new() }
    };
    let panels: Vec<Panel> = names.iter().map(panel).collect();

    let entries = grouped(curves.iter().filter_map(|(look, _)| look.entry.as_ref()), |e| e.name.as_str());
    let mut legend: Vec<Entry> = entries.into_iter().map(|(_, same)| same[0].clone()).collect();
    legend.extend(more);
    let sign = |marker| Symbol::Mark(Color::GRAY, marker);
    let has_band = panels.iter().flat_map(|p| &p.marks).any(|mark| matches!(mark, Mark::Band(..)));
    let signs = [
        (others.is_some(), Symbol::Line(Style { width: 1.0, ..BEHIND }, None), others.unwrap_or_default()),
        (curves.iter().any(|c| c.1.operating.is_some()), sign(Marker::Operating), OPERATING),
        (curves.iter().any(|c| !c.1.published.is_empty()), sign(Marker::Published), "published"),
        (has_band, Symbol::Band(Color::GRAY), "95 % bootstrap interval"),
    ];
    let signs = signs.into_iter().filter(|(is_there, ..)| *is_there);
    legend.extend(signs.map(|(_, symbol, name)| Entry::new(symbol, name)));
    Figure { note: note.to_string(), rows: vec![panels], legend, ..Figure::default() }
}

/// Rule by which curves are distinguished within a panel and spread over panels.
#[derive(Debug, Clone, PartialEq)]
enum Plan {
    /// Methods have their own colors, trackers their own line styles, and all other differences their own
    /// panels.
    Methods { dashed: bool },
    /// One panel per method, with the other curves behind.
    PanelOfMethod,
    /// Colors are the values of an axis.
    Ordered(String, Vec<f64>),
}

/// Values of an axis in ascending order, without repetitions.
pub fn values<S: AsRef<str>>(points: impl Iterator<Item = (S, f64)>, axis: &str) -> Vec<f64> {
    let mut values: Vec<f64> = points.filter(|(known, _)| known.as_ref() == axis).map(|(_, at)| at).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

fn values_of<'l>(lines: impl IntoIterator<Item = &'l Line>, axis: &str) -> Vec<f64> {
    values(lines.into_iter().flat_map(|l| &l.others).map(|(axis, at)| (axis, *at)), axis)
}

fn plan(experiment: &Experiment, lines: &[Line]) -> Plan {
    let own = || lines.iter().filter(|l| !is_anchor(experiment, &l.method));
    let axes = distinct(own().flat_map(|l| &l.others).map(|(axis, _)| axis));
    let widest = axes.iter().max_by_key(|axis| (values_of(own(), axis).len(), std::cmp::Reverse(**axis)));
    if let Some(axis) = widest.filter(|axis| values_of(own(), axis).len() > 1) {
        return Plan::Ordered((*axis).clone(), values_of(own(), axis));
    }
    let methods = distinct(lines.iter().map(|l| &l.method)).len();
    let trackers = distinct(lines.iter().map(|l| &l.tracker)).len();
    if trackers > 1 {
        // Dashes are free for trackers where no two methods have the same color.
        let whole = own().all(|l| colors::style(experiment, &l.method).0.dash == Dash::SOLID);
        return Plan::Methods { dashed: whole && methods * trackers <= MAX_DASHED };
    }
    match lines.iter().filter(|l| l.points.len() > 1).count() > MAX_CURVES {
        true => Plan::PanelOfMethod,
        false => Plan::Methods { dashed: false },
    }
}

/// Arranges the curves of methods in a figure.
pub fn arrange(experiment: &Experiment, note: &str, axes: (Axis, Axis), lines: &[Line]) -> Figure {
    let plan = plan(experiment, lines);
    let trackers = distinct(lines.iter().map(|l| l.tracker.as_str()));
    let several_methods = distinct(lines.iter().map(|l| &l.method)).len() > 1;
    let (dashed, of_panels) = (plan == Plan::Methods { dashed: true }, plan == Plan::PanelOfMethod);
    let mapped = if let Plan::Ordered(axis, _) = &plan { Some(axis) } else { None };
    let curve = |line: &Line| {
        let mut line = line.clone();
        let is_anchor = is_anchor(experiment, &line.method);
        let (mut style, mut marker) = colors::style(experiment, &line.method);
        let (mut key_style, mut name) = (style, line.method.clone());
        let mut panel: Vec<String> = Vec::new();
        match &plan {
            Plan::Ordered(axis, values) if !is_anchor && line.others.iter().any(|(a, _)| a == axis) => {
                let value = line.others.iter().find(|(a, _)| a == axis).map_or(f64::NAN, |(_, v)| *v);
                let at = values.iter().position(|v| *v == value).unwrap_or(0);
                style = Style::new(Color::ordered(at, values.len()), Dash::SOLID);
                (key_style, marker, name) = (style, Marker::nth(at), format!("{axis} {value}"));
                // Of an ordered parameter only the published value has a band.
                if line.operating.is_none() {
                    line.band.clear();
                }
            }
            Plan::Methods { dashed: true } if !is_anchor => {
                style.dash = Dash::nth(trackers.iter().position(|t| *t == line.tracker).unwrap_or(0));
            }
            Plan::PanelOfMethod => panel.push(line.method.clone()),
            _ => {}
        }
        if !dashed && trackers.len() > 1 {
            panel.push(line.tracker.clone());
        }
        if mapped.is_some() && several_methods {
            panel.push(line.method.clone());
        }
        let more = line.others.iter().filter(|(axis, _)| values_of(lines, axis).len() > 1);
        let more = more.filter(|(axis, _)| mapped != Some(axis));
        panel.extend(more.map(|(axis, value)| format!("{axis} {value}")));
        if of_panels && !line.summary.is_empty() {
            panel.push(line.summary.clone());
        }
        let is_alone = lines.iter().filter(|l| l.method == line.method).count() == 1;
        if !line.summary.is_empty() && is_alone {
            name = format!("{name} ({})", line.summary);
        }
        let marked = line.marked.then_some(marker);
        let (symbol, marker) = match line.points.len() {
            1 => (Symbol::Mark(style.color, marker), Some(marker)),
            _ => (Symbol::Line(key_style, marked), marked),
        };
        // Anchors that do not differ from panel to panel are in all of them.
        let panel = (!of_panels || !is_anchor).then(|| panel.join(", "));
        let entry = (!of_panels || is_anchor).then(|| Entry::new(symbol, name));
        (Look { panel, entry, style, marker }, line)
    };
    let curves: Vec<(Look, Line)> = lines.iter().map(curve).collect();
    let dash = |(k, name): (usize, &&str)| {
        Entry::new(Symbol::Line(Style::new(Color::GRAY, Dash::nth(k)), None), *name)
    };
    let more = trackers.iter().enumerate().filter(|_| dashed).map(dash).collect();
    let mut figure = compose(note, axes, &curves, of_panels.then_some("the other methods"), more);
    if let Plan::Ordered(axis, values) = &plan {
        // In the order of the values, whatever order the lines have.
        let place = |e: &Entry| values.iter().position(|v| e.name == format!("{axis} {v}"));
        figure.legend.sort_by_key(|e| place(e).unwrap_or(usize::MAX));
    }
    figure
}

/// Name of an axis or heading: a word is capitalized, a symbol stays unchanged.
pub fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    match (letters.next(), letters.clone().next()) {
        (Some(first), Some(second)) if second.is_ascii_lowercase() => {
            first.to_uppercase().chain(letters).collect()
        }
        _ => text.to_string(),
    }
}

#[cfg(test)]
mod tests;
