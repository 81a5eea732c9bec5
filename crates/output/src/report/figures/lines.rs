//! Curves of methods, arranged: color is the method, line style or panel the tracker, and a map of ordered colors the
//! values of a parameter. Where a panel would hold too many curves, each has a panel of its own, before the others in gray.

use super::drawer::Drawing;
use crate::figure::{
    Color, Curve, CurveAxis, Curves, Dash, Entry, Facet, Marker, Range, Sign, Style, Symbol,
};
use crate::report::colors;
use crate::table::layout::is_anchor;
use trackfail_engine::spec::Experiment;

/// A curve of a method on a tracker.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Line {
    /// Method.
    pub method: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Axes of the grid, other than that along the curve, with their values.
    pub others: Vec<(String, f64)>,
    /// Points in drawing order.
    pub points: Vec<(f64, f64)>,
    /// Bounds of each point's value; empty without any.
    pub band: Vec<(f64, f64)>,
    /// Whether marks stand at its points.
    pub marked: bool,
    /// The point at which the method is operated.
    pub operating: Option<(f64, f64)>,
    /// The points that a paper prints.
    pub published: Vec<(f64, f64)>,
    /// A number that sums the curve up, such as `AP .41`; may be empty.
    pub summary: String,
}

/// Most curves of a panel; of more, each has a panel of its own.
const MAX_CURVES: usize = 4;
/// Most curves of a panel in which trackers are told apart by the line style.
const MAX_DASHED: usize = 8;

/// What tells the curves of a panel apart, and what the panels.
#[derive(Debug, Clone, PartialEq)]
enum PanelPlan {
    /// Colors are methods, line styles trackers, and panels are what is left.
    Methods { dashed: bool },
    /// A panel for each method; the others stand behind.
    PanelOfMethod,
    /// Colors are the values of this axis.
    Ordered(String, Vec<f64>),
}

fn distinct<'l, T: PartialEq>(lines: &'l [Line], of: impl Fn(&'l Line) -> T) -> Vec<T> {
    let mut all: Vec<T> = Vec::new();
    for value in lines.iter().map(of) {
        if !all.contains(&value) {
            all.push(value);
        }
    }
    all
}

fn values_of(lines: &[Line], axis: &str) -> Vec<f64> {
    let mut values: Vec<f64> =
        lines.iter().flat_map(|l| &l.others).filter(|(a, _)| a == axis).map(|(_, v)| *v).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Arranges curves.
struct Arranged<'e> {
    experiment: &'e Experiment,
    lines: Vec<Line>,
    plan: PanelPlan,
}

impl Arranged<'_> {
    fn is_anchor(&self, line: &Line) -> bool {
        is_anchor(self.experiment, &line.method)
    }

    /// The style of a method, the same in all figures of its experiment; anchors are gray.
    fn style(&self, line: &Line) -> (Style, Marker) {
        let Some(k) = colors::place(self.experiment, &line.method) else {
            let mut anchors = self.experiment.methods.iter().filter(|m| is_anchor(self.experiment, &m.name));
            let k = anchors.position(|m| m.name == line.method).unwrap_or(0);
            return (Style::new(Color::Gray, Dash::nth(k + 1)), Marker::nth(k + 1));
        };
        let style = match &self.plan {
            PanelPlan::Ordered(axis, values) => {
                let value = line.others.iter().find(|(a, _)| a == axis).map(|(_, v)| *v);
                let at = value.and_then(|v| values.iter().position(|w| *w == v)).unwrap_or(0);
                return (Style::new(Color::ordered(at, values.len()), Dash::Solid), Marker::nth(at));
            }
            PanelPlan::Methods { dashed: true } => {
                let trackers = distinct(&self.lines, |l| &l.tracker);
                let tracker = trackers.iter().position(|t| **t == line.tracker).unwrap_or(0);
                Style::new(Style::nth(k).color, Dash::nth(tracker))
            }
            _ => Style::new(Style::nth(k).color, Dash::Solid),
        };
        (style, Marker::nth(k))
    }

    /// The panel that a line belongs to: its heading, empty with a single panel. Anchors that do not differ from panel to
    /// panel are in all of them.
    fn panel(&self, line: &Line) -> String {
        let mut parts = Vec::new();
        if self.plan == PanelPlan::PanelOfMethod {
            parts.push(line.method.clone());
        }
        let dashed = self.plan == PanelPlan::Methods { dashed: true };
        if !dashed && distinct(&self.lines, |l| &l.tracker).len() > 1 {
            parts.push(line.tracker.clone());
        }
        if let PanelPlan::Ordered(..) = self.plan
            && distinct(&self.lines, |l| &l.method).len() > 1
        {
            parts.push(line.method.clone());
        }
        for (axis, value) in &line.others {
            let is_color = matches!(&self.plan, PanelPlan::Ordered(mapped, _) if mapped == axis);
            if !is_color && values_of(&self.lines, axis).len() > 1 {
                parts.push(format!("{axis} {value}"));
            }
        }
        parts.join(", ")
    }

    fn facets(&self) -> Vec<Facet> {
        let own: Vec<&Line> = self.lines.iter().filter(|l| !self.is_shared(l)).collect();
        let mut panels: Vec<String> = Vec::new();
        for line in &own {
            let panel = self.panel(line);
            if !panels.contains(&panel) {
                panels.push(panel);
            }
        }
        if panels.is_empty() {
            panels.push(String::new());
        }
        let single = panels.len() == 1;
        let facet = |panel: &String| {
            let is_mine = |l: &&Line| self.is_shared(l) || self.panel(l) == *panel;
            let mine: Vec<&Line> = self.lines.iter().filter(is_mine).collect();
            let bands = mine.iter().filter(|l| !l.band.is_empty() && l.points.len() > 1).count();
            // Of many bands over each other none could be read; of an ordered parameter the published value has one.
            let has_band = |line: &Line| match self.plan {
                PanelPlan::Ordered(..) => line.operating.is_some(),
                _ => bands <= MAX_CURVES,
            };
            let curve = |line: &&Line| {
                let (style, marker) = self.style(line);
                let marker =
                    if line.points.len() == 1 { Some(marker) } else { line.marked.then_some(marker) };
                let band = if has_band(line) { line.band.clone() } else { Vec::new() };
                Curve { points: line.points.clone(), band, style, marker }
            };
            let signs = |line: &&Line| {
                let color = self.style(line).0.color;
                let operating = line.operating.map(|at| (Sign::Operating, at, color));
                let published = line.published.iter().map(|at| (Sign::Published, *at, color));
                operating.into_iter().chain(published).collect::<Vec<_>>()
            };
            let behind =
                |l: &&Line| self.plan == PanelPlan::PanelOfMethod && !self.is_shared(l) && !is_mine(l);
            let summary = mine.iter().find(|l| !l.summary.is_empty() && !self.is_shared(l));
            let summary =
                summary.filter(|_| self.plan == PanelPlan::PanelOfMethod).map(|l| l.summary.clone());
            let label = if single { String::new() } else { panel.clone() };
            Facet {
                label: [Some(label), summary]
                    .into_iter()
                    .flatten()
                    .filter(|t| !t.is_empty())
                    .collect::<Vec<_>>()
                    .join(", "),
                series: mine.iter().map(curve).collect(),
                behind: self.lines.iter().filter(behind).map(|l| l.points.clone()).collect(),
                signs: mine.iter().flat_map(signs).collect(),
                ..Facet::default()
            }
        };
        panels.iter().map(facet).collect()
    }

    /// Whether a line stands in all panels: an anchor's point where panels are methods.
    fn is_shared(&self, line: &Line) -> bool {
        self.plan == PanelPlan::PanelOfMethod && self.is_anchor(line)
    }

    fn legend(&self) -> Vec<Entry> {
        let mut legend: Vec<Entry> = Vec::new();
        let panels = self.plan == PanelPlan::PanelOfMethod;
        for line in self.lines.iter().filter(|l| !panels || self.is_shared(l)) {
            let (style, marker) = self.style(line);
            let style = Style { dash: if self.is_anchor(line) { style.dash } else { Dash::Solid }, ..style };
            let name = match &self.plan {
                PanelPlan::Ordered(axis, _) if !self.is_anchor(line) => {
                    let value = line.others.iter().find(|(a, _)| a == axis).map_or(f64::NAN, |(_, v)| *v);
                    format!("{axis} {value}")
                }
                _ => line.method.clone(),
            };
            let alone = self.lines.iter().filter(|l| l.method == line.method).count() == 1;
            let name = match line.summary.as_str() {
                "" => name,
                summary if alone => format!("{name} ({summary})"),
                _ => name,
            };
            let marked = line.marked.then_some(marker);
            let symbol = match line.points.len() {
                1 => Symbol::Mark(style.color, marker),
                _ => Symbol::Line(style, marked),
            };
            if legend.iter().all(|e| e.name != name) {
                legend.push(Entry::new(symbol, name));
            }
        }
        if let PanelPlan::Ordered(axis, values) = &self.plan {
            // In the order of the values, whatever order the lines have.
            let place = |e: &Entry| values.iter().position(|v| e.name == format!("{axis} {v}"));
            legend.sort_by_key(|e| place(e).unwrap_or(usize::MAX));
        }
        if self.plan == (PanelPlan::Methods { dashed: true }) {
            for (k, tracker) in distinct(&self.lines, |l| &l.tracker).into_iter().enumerate() {
                let symbol = Symbol::Line(Style::new(Color::Gray, Dash::nth(k)), None);
                legend.push(Entry::new(symbol, tracker.as_str()));
            }
        }
        if panels {
            let other = Style { width: 1.0, ..Style::new(Color::Mapped([0xC9, 0xC9, 0xC9]), Dash::Solid) };
            legend.push(Entry::new(Symbol::Line(other, None), "the other methods"));
        }
        if self.lines.iter().any(|l| l.operating.is_some()) {
            legend.push(Entry::new(Symbol::Sign(Sign::Operating, Color::Gray), "operating point"));
        }
        if self.lines.iter().any(|l| !l.published.is_empty()) {
            legend.push(Entry::new(Symbol::Sign(Sign::Published, Color::Gray), "published"));
        }
        legend
    }
}

fn plan(experiment: &Experiment, lines: &[Line]) -> PanelPlan {
    let curves = lines.iter().filter(|l| l.points.len() > 1).count();
    let methods = distinct(lines, |l| &l.method).len();
    let trackers = distinct(lines, |l| &l.tracker).len();
    let own: Vec<Line> = lines.iter().filter(|l| !is_anchor(experiment, &l.method)).cloned().collect();
    let axes = distinct(&own, |l| l.others.iter().map(|(a, _)| a.clone()).collect::<Vec<_>>()).concat();
    let widest = axes.iter().max_by_key(|axis| (values_of(&own, axis).len(), std::cmp::Reverse(*axis)));
    if let Some(axis) = widest.filter(|a| values_of(&own, a).len() > 1) {
        return PanelPlan::Ordered(axis.clone(), values_of(&own, axis));
    }
    if trackers > 1 {
        return PanelPlan::Methods { dashed: methods * trackers <= MAX_DASHED };
    }
    if curves > MAX_CURVES { PanelPlan::PanelOfMethod } else { PanelPlan::Methods { dashed: false } }
}

/// The curves on linear axes, arranged.
pub fn arrange(experiment: &Experiment, note: &str, (x, y): (&str, &str), lines: Vec<Line>) -> Curves {
    let plan = plan(experiment, &lines);
    let arranged = Arranged { experiment, lines, plan };
    let facets = arranged.facets();
    let mut legend = arranged.legend();
    if facets.iter().flat_map(|f| &f.series).flat_map(|c| &c.band).any(|b| b.0.is_finite()) {
        legend.push(Entry::new(Symbol::Band(Color::Gray), "95 % bootstrap interval"));
    }
    Curves { facets, legend, ..plain(note, x, y) }
}

/// Linear axes without curves, the vertical one from 0.
pub fn plain(note: &str, x: &str, y: &str) -> Curves {
    Curves {
        title: String::new(),
        note: note.to_string(),
        x: CurveAxis::new(x),
        y: CurveAxis { range: Range::FromZero, ..CurveAxis::new(y) },
        square: false,
        iso_f: false,
        facets: Vec::new(),
        legend: Vec::new(),
    }
}

/// The sentence of a caption that says what bands are; empty without bands.
pub fn remark_on_bands(curves: &Curves) -> &'static str {
    let mut bands = curves.facets.iter().flat_map(|f| &f.series).flat_map(|c| &c.band);
    if bands.any(|b| b.0.is_finite()) {
        " Bands are 95 % intervals, point by point, by bootstrap over sequences."
    } else {
        ""
    }
}

/// The curves as a drawing, or `reason` where none of them has a value.
pub fn drawing(curves: Curves, reason: String) -> Drawing {
    let mut points = curves.facets.iter().flat_map(|f| &f.series).flat_map(|c| &c.points);
    if points.all(|p| p.1.is_nan() || p.0.is_nan()) {
        return Drawing::NoData(reason);
    }
    let remark = remark_on_bands(&curves).to_string();
    Drawing::Plot { plot: Box::new(curves), remark }
}

/// The same with a sentence more in its caption.
pub fn with_remark(drawing: Drawing, more: &str) -> Drawing {
    match drawing {
        Drawing::Plot { plot, remark } => Drawing::Plot { plot, remark: remark + more },
        none => none,
    }
}

/// A name for an axis or a heading: a word begins with a capital, a symbol stays as it is.
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
