//! One panel of a strip: values over the frames of a sequence.

use super::axes::{self, Axis, Range};
use super::error::FigureError;
use super::font;
use super::legend::{self, Entry, Rows, Symbol};
use super::scene::{Anchor, Area, Item, Point, Scene, Stroke};
use super::style::Edge;
use super::style::{Color, Dash, INK, MEDIUM, SMALL, SOFT, Style};

/// The frames of a panel: number of the first in its dataset, and how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameAxis {
    /// Number of the first frame.
    pub first: u32,
    /// Number of frames, at least 1.
    pub count: usize,
}

/// A line of a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend; may be empty in a panel with one series.
    pub name: String,
    /// One value a frame; NaN and infinity leave a gap.
    pub values: Vec<f64>,
    /// How it is drawn.
    pub style: Style,
}

/// A level that values are compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct Threshold {
    /// Name in the legend, with the value if it is to be read: `τ₁ = 0.004`.
    pub name: String,
    /// The level.
    pub value: f64,
    /// How it is drawn.
    pub style: Style,
}

/// A panel. Frames are counted from 0 in `spans`, `events` and `alarms`.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Short text above the panel, such as `(a)`; may be empty.
    pub caption: String,
    /// Name of the vertical axis: what the values are.
    pub label: String,
    /// The horizontal axis.
    pub frames: FrameAxis,
    /// The vertical axis.
    pub range: Range,
    /// Names of values on the vertical axis, in place of numbers; numbers where it is empty.
    pub names: Vec<(f64, String)>,
    /// The lines, the first at the back.
    pub series: Vec<Series>,
    /// Whether a legend names the lines, where there are several.
    pub legend: bool,
    /// Levels that values are compared with.
    pub thresholds: Vec<Threshold>,
    /// Shaded runs of frames: where the target is lost (O_t = 1).
    pub spans: Vec<std::ops::Range<usize>>,
    /// Frames with an upright line: the target is lost, or found again.
    pub events: Vec<(usize, Edge)>,
    /// Frames with a triangle at the top: an alarm begins, or ends.
    pub alarms: Vec<(usize, Edge)>,
    /// The color of these triangles.
    pub alarm_color: Color,
}

impl Panel {
    /// A panel without lines.
    pub fn new(label: &str, frames: FrameAxis) -> Self {
        Self {
            caption: String::new(),
            label: label.to_owned(),
            frames,
            range: Range::Auto,
            names: Vec::new(),
            series: Vec::new(),
            legend: true,
            thresholds: Vec::new(),
            spans: Vec::new(),
            events: Vec::new(),
            alarms: Vec::new(),
            alarm_color: Color::Vermilion,
        }
    }
}

/// The runs of `true`, for [`Panel::spans`].
pub fn spans_where(flags: &[bool]) -> Vec<std::ops::Range<usize>> {
    let mut out: Vec<std::ops::Range<usize>> = Vec::new();
    for (i, _) in flags.iter().enumerate().filter(|(_, f)| **f) {
        match out.last_mut() {
            Some(run) if run.end == i => run.end += 1,
            _ => out.push(i..i + 1),
        }
    }
    out
}

/// Shade of the frames where the target is lost.
pub const SHADE: [u8; 3] = [0xE3, 0xE3, 0xE3];
/// Line where the target is lost.
pub const LOSS: Style = Style { color: Color::Black, dash: Dash::Dotted, width: 1.0 };
/// Line where it is found again.
pub const RECOVERY: Style = Style { color: Color::Gray, dash: Dash::DashDot, width: 1.0 };
/// Height of the band for alarms, in units.
const BAND: f64 = 8.0;
/// Room for the names of rows, in units.
const MAX_NAME: f64 = 90.0;
/// Between the ends of the range and the frame, in units.
const ROOM: f64 = 4.0;

/// The layout of a panel for a width, to be drawn when the heights of its row are known.
pub struct PanelLayout<'a> {
    panel: &'a Panel,
    y_range: (f64, f64),
    entries: Vec<Entry>,
    legend: Rows,
    caption: String,
    beside: bool,
}

impl<'a> PanelLayout<'a> {
    /// The layout in an area of this size, its labels aside.
    pub fn new(panel: &'a Panel, (width, height): (f64, f64)) -> Result<Self, FigureError> {
        if panel.frames.count == 0 {
            return Err(FigureError::Empty("a panel has no frames"));
        }
        for s in &panel.series {
            if s.values.len() != panel.frames.count {
                let (series, got) = (s.name.clone(), s.values.len());
                return Err(FigureError::Length { series, got, expected: panel.frames.count });
            }
        }
        let values = panel.series.iter().flat_map(|s| &s.values).copied();
        let values = values.chain(panel.thresholds.iter().map(|t| t.value));
        let y_range = panel.range.resolve(values, false, axes::max_ticks_y(height))?;
        let named = panel.series.len() > 1 && panel.legend;
        let mut entries: Vec<Entry> = Vec::new();
        for s in panel.series.iter().filter(|s| named && !s.name.is_empty()) {
            entries.push(Entry { symbol: Symbol::Line(s.style, None), name: s.name.clone() });
        }
        for t in panel.thresholds.iter().filter(|t| !t.name.is_empty()) {
            entries.push(Entry { symbol: Symbol::Line(t.style, None), name: t.name.clone() });
        }
        let caption = font::fit(&panel.caption, MEDIUM, width);
        let taken = if caption.is_empty() { 0.0 } else { font::width(&caption, MEDIUM) + 12.0 };
        // The legend stands beside the caption when it fits there in one row.
        let short = Rows::new(&entries, (width - taken).max(60.0));
        let beside = short.height() <= legend::ROW && taken < width / 2.0;
        let legend = if beside { short } else { Rows::new(&entries, width) };
        Ok(Self { panel, y_range, entries, legend, caption, beside })
    }

    /// Drops the legend, where the panel on the left shows the same.
    pub fn without_legend(&mut self) {
        self.legend = Rows::new(&[], 0.0);
    }

    /// Entries of the legend.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Height of caption and legend.
    pub fn head(&self) -> f64 {
        let caption = if self.caption.is_empty() { 0.0 } else { legend::ROW };
        let text =
            if self.beside { self.legend.height().max(caption) } else { self.legend.height() + caption };
        if text > 0.0 { text + 3.0 } else { 0.0 }
    }

    fn band(&self) -> f64 {
        if self.panel.alarms.is_empty() { 0.0 } else { BAND }
    }

    fn y_axis(&self, area: &Area) -> Axis {
        Axis::new(self.y_range, (area.bottom(), area.y + self.band()), ROOM, false)
    }

    /// Ticks of the vertical axis: names, or numbers.
    fn rows(&self, area: &Area) -> Vec<(f64, String)> {
        if self.panel.names.is_empty() {
            return self.y_axis(area).ticks(axes::max_ticks_y(area.h));
        }
        let fit = |(at, name): &(f64, String)| (*at, font::fit(name, SMALL, MAX_NAME));
        self.panel.names.iter().map(fit).collect()
    }

    /// Width of the widest tick label on the left for a plot of this height.
    pub fn labels(&self, height: f64) -> f64 {
        axes::label_width(&self.rows(&Area { x: 0.0, y: 0.0, w: 1.0, h: height }))
    }

    /// Draws the plot in `area` and caption and legend above it, from `left` on.
    pub fn draw(&self, scene: &mut Scene, area: &Area, left: f64, head: f64, label_x: bool) {
        let top = area.y - head;
        scene.text(&self.caption, (left, top + legend::ROW / 2.0), MEDIUM, Anchor::Start, INK);
        let (x, y) = match (self.caption.is_empty(), self.beside) {
            // Over the plot where that leaves enough room, else over its labels too.
            (true, _) => (
                left.max(area.x.min(area.right() - self.legend.width())),
                area.y - self.legend.height() - 3.0,
            ),
            (false, true) => (left + font::width(&self.caption, MEDIUM) + 12.0, top),
            (false, false) => (left, top + legend::ROW),
        };
        self.legend.draw(scene, (x, y));

        let FrameAxis { first, count } = self.panel.frames;
        let (first, last) = (f64::from(first), f64::from(first) + (count - 1) as f64);
        let ends = if count == 1 { (first - 0.5, first + 0.5) } else { (first, last) };
        let x_axis = Axis::new(ends, (area.x, area.right()), ROOM, false).whole();
        let y_axis = self.y_axis(area);
        let x_of = |t: usize| x_axis.place(first + t as f64);

        for span in self.panel.spans.iter().filter(|s| s.start < s.end && s.start < count) {
            let half = (x_of(1) - x_of(0)) / 2.0;
            let from = (x_of(span.start) - half).max(area.x);
            let to = (x_of(span.end.min(count) - 1) + half).min(area.right());
            let area = Area { x: from, w: (to - from).max(0.5), ..*area };
            scene.items.push(Item::Rect { area, rgb: SHADE });
        }
        for &(t, edge) in self.panel.events.iter().filter(|e| e.0 < count) {
            let style = if edge == Edge::Begins { LOSS } else { RECOVERY };
            scene.line(vec![(x_of(t), area.y), (x_of(t), area.bottom())], Stroke::of(&style));
        }
        for t in self.panel.thresholds.iter().filter(|t| axes::usable(t.value)) {
            let y = y_axis.place(t.value);
            scene.clipped(&[(area.x, y), (area.right(), y)], area, Stroke::of(&t.style));
        }
        for series in &self.panel.series {
            for run in runs(&series.values) {
                let points: Vec<Point> = run.map(|t| (x_of(t), y_axis.place(series.values[t]))).collect();
                match points[..] {
                    [one] if area.clip(one, one).is_some() => {
                        let (rgb, radius) = (series.style.color.rgb(), series.style.width);
                        scene.items.push(Item::Circle { center: one, radius, rgb });
                    }
                    _ => scene.clipped(&axes::thinned(&points), area, Stroke::of(&series.style)),
                }
            }
        }
        for &(t, edge) in self.panel.alarms.iter().filter(|a| a.0 < count) {
            legend::alarm(scene, (x_of(t), area.y + BAND - 1.0), (self.panel.alarm_color, edge));
        }
        let drawn = self.panel.series.iter().flat_map(|s| &s.values).any(|v| axes::usable(*v));
        if !drawn {
            let middle = (area.x + area.w / 2.0, area.y + area.h / 2.0);
            scene.text("no values", middle, SMALL, Anchor::Middle, SOFT);
        }
        let labels = axes::Labelled { x: label_x, y: true };
        axes::frame_of_rows(scene, area, &x_axis, &y_axis, &self.rows(area), labels);
    }
}

/// The runs of values that can be drawn.
fn runs(values: &[f64]) -> Vec<std::ops::Range<usize>> {
    spans_where(&values.iter().map(|v| axes::usable(*v)).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_by_hand() {
        assert_eq!(spans_where(&[true, false, true, true]), [0..1, 2..4]);
        assert!(spans_where(&[]).is_empty());
    }

    #[test]
    fn gaps_split_lines() {
        assert_eq!(runs(&[f64::NAN, 1.0, 2.0, f64::INFINITY, 3.0]), [1..3, 4..5]);
    }

    #[test]
    fn a_series_of_the_wrong_length_is_an_error() {
        let mut panel = Panel::new("y", FrameAxis { first: 1, count: 3 });
        panel.series.push(Series { name: "a".into(), values: vec![0.0; 2], style: Style::nth(0) });
        let error = PanelLayout::new(&panel, (100.0, 100.0)).err();
        assert_eq!(error, Some(FigureError::Length { series: "a".into(), got: 2, expected: 3 }));
    }
}
