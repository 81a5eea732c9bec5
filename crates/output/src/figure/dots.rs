//! Dot plots: a row for each reading, a panel for each statistic, a dot with its interval, and the published value as an
//! upright line through the panel.

use super::axes::{Axis, Range, usable};
use super::draw::Plot;
use super::error::FigureError;
use super::font;
use super::heading::heading;
use super::scene::{Anchor, Area, Item, Scene, Stroke};
use super::sign::{Sign, draw_sign};
use super::style::{Color, Dash, INK, MARGIN, MEDIUM, SMALL, SOFT};

/// A value with its bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// The value.
    pub value: f64,
    /// Lower and upper bound, where they are known.
    pub bounds: Option<(f64, f64)>,
}

/// A panel: one statistic of all rows.
#[derive(Debug, Clone, PartialEq)]
pub struct DotPanel {
    /// Name of the statistic.
    pub label: String,
    /// The value that is marked in all rows.
    pub mark: Option<f64>,
    /// The value that a paper prints for each row; may be empty.
    pub published: Vec<Option<f64>>,
    /// The dot of each row.
    pub values: Vec<Option<Dot>>,
}

/// Panels beside each other with common rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Dots {
    /// Title; may be empty.
    pub title: String,
    /// Note under the title; may be empty.
    pub note: String,
    /// Names of the rows, from the top.
    pub rows: Vec<String>,
    /// The panels, from the left.
    pub panels: Vec<DotPanel>,
    /// Whether all panels have one axis, because they show one statistic.
    pub shared_axis: bool,
    /// The color of each row; blue where there is none.
    pub colors: Vec<Color>,
    /// The value that chance gives: a dashed line in every panel.
    pub chance: Option<f64>,
}

/// Height of a row, in units.
const ROW: f64 = 17.0;
/// Least and most room for the names of rows, in units.
const LEAST_NAMES: f64 = 60.0;
const NAMES: f64 = 210.0;
/// Least width of a panel, in units.
const LEAST: f64 = 80.0;
/// Room between two panels, in units.
const GAP: f64 = 18.0;
/// About the number of ticks of a panel.
const TICKS: usize = 3;
/// Height of a panel's heading of two lines, in units.
const HEADING: f64 = 30.0;
const GRID: Stroke = Stroke { rgb: [0xDD, 0xDD, 0xDD], width: 0.7, dash: Dash::Solid };

impl Plot for Dots {
    fn scene(&self, width: f64) -> Result<Scene, FigureError> {
        if self.rows.is_empty() || self.panels.is_empty() {
            return Err(FigureError::Empty("a dot plot needs a row and a panel"));
        }
        let mut scene = Scene::new(&self.title, width);
        let mut y = heading(&mut scene, &self.title, &self.note);
        let longest = self.rows.iter().map(|name| font::width(name, MEDIUM)).fold(0.0, f64::max);
        let names = (longest + 8.0).clamp(LEAST_NAMES.min(width / 3.0), NAMES.min(width / 3.0));
        let room = width - 2.0 * MARGIN - names;
        // Panels that have no room beside each other stand below, with the names of the rows again.
        let most = (((room + GAP) / (LEAST + GAP)) as usize).max(1);
        let count = self.panels.len().div_ceil(self.panels.len().div_ceil(most));
        let w = (room - GAP * (count - 1) as f64) / count as f64;
        let shared = if self.shared_axis { Some(range(&self.panels, self.chance)?) } else { None };
        for panels in self.panels.chunks(count) {
            let top = y + HEADING;
            let bottom = top + ROW * self.rows.len() as f64;
            for (k, name) in self.rows.iter().enumerate() {
                let y = top + ROW * (k as f64 + 0.5);
                let name = font::fit(name, MEDIUM, names - 8.0);
                scene.text(&name, (MARGIN + names - 8.0, y), MEDIUM, Anchor::End, INK);
            }
            for (k, panel) in panels.iter().enumerate() {
                let x = MARGIN + names + k as f64 * (w + GAP);
                let range = shared.map_or_else(|| range(std::slice::from_ref(panel), self.chance), Ok)?;
                self.draw_panel(&mut scene, panel, &Area { x, y: top, w, h: bottom - top }, range);
            }
            y = bottom + 28.0;
        }
        scene.height = y - 4.0 + MARGIN / 2.0;
        Ok(scene)
    }
}

/// Lower and upper end of an axis that has all values, bounds and marks of some panels, and what chance gives.
fn range(panels: &[DotPanel], chance: Option<f64>) -> Result<(f64, f64), FigureError> {
    let ends = |Dot { value, bounds }: Dot| {
        [Some(value), bounds.map(|b| b.0), bounds.map(|b| b.1)].into_iter().flatten()
    };
    let of_panel = |p: &DotPanel| {
        let values = p.values.iter().flatten().copied().flat_map(ends);
        values.chain(p.mark).chain(p.published.iter().flatten().copied()).collect::<Vec<_>>()
    };
    let all = panels.iter().flat_map(of_panel).chain(chance);
    Range::Auto.resolve(all.filter(|v| usable(*v)), false, TICKS)
}

impl Dots {
    fn draw_panel(&self, scene: &mut Scene, panel: &DotPanel, area: &Area, range: (f64, f64)) {
        let axis = Axis::new(range, (area.x, area.right()), 6.0, false);
        for (k, line) in font::wrap(&panel.label, SMALL, area.w, 2).iter().enumerate() {
            let y = area.y - HEADING + 8.0 + 12.0 * k as f64;
            scene.text(line, (area.x + area.w / 2.0, y), SMALL, Anchor::Middle, INK);
        }
        for k in 0..panel.values.len() {
            let y = area.y + ROW * (k as f64 + 0.5);
            scene.line(vec![(area.x, y), (area.right(), y)], GRID);
        }
        scene.line(
            vec![(area.x, area.bottom()), (area.right(), area.bottom())],
            Stroke { rgb: SOFT, width: 0.8, dash: Dash::Solid },
        );
        // Two or three ticks whose labels fit beside each other.
        let ticks = axis.ticks(TICKS);
        let mut free = f64::NEG_INFINITY;
        for (value, label) in &ticks {
            let x = axis.place(*value);
            scene.line(
                vec![(x, area.bottom()), (x, area.bottom() + 3.5)],
                Stroke { rgb: SOFT, width: 0.8, dash: Dash::Solid },
            );
            let half = font::width(label, SMALL) / 2.0;
            if x - half > free && x + half <= area.right() + GAP / 2.0 {
                scene.text(label, (x, area.bottom() + 12.0), SMALL, Anchor::Middle, SOFT);
                free = x + half + 3.0;
            }
        }
        if let Some(chance) = self.chance.filter(|v| usable(*v)) {
            let x = axis.place(chance);
            let stroke = Stroke { rgb: SOFT, width: 1.0, dash: Dash::Dashed };
            scene.line(vec![(x, area.y), (x, area.bottom())], stroke);
        }
        if let Some(mark) = panel.mark.filter(|v| usable(*v)) {
            let x = axis.place(mark);
            // Black, because a method has each of the other colors.
            let stroke = Stroke { rgb: Color::Black.rgb(), width: 1.4, dash: Dash::Solid };
            scene.line(vec![(x, area.y), (x, area.bottom())], stroke);
        }
        for (k, value) in panel.values.iter().enumerate() {
            let Some(Dot { value, bounds }) = value.filter(|dot| usable(dot.value)) else { continue };
            let y = area.y + ROW * (k as f64 + 0.5);
            let color = self.colors.get(k).copied().unwrap_or(Color::Blue);
            if let Some(printed) = panel.published.get(k).copied().flatten().filter(|v| usable(*v)) {
                draw_sign(scene, Sign::Published, (axis.place(printed), y), color);
            }
            if let Some((low, high)) = bounds.filter(|(low, high)| usable(*low) && usable(*high)) {
                let stroke = Stroke { rgb: color.rgb(), width: 1.6, dash: Dash::Solid };
                scene.line(vec![(axis.place(low), y), (axis.place(high), y)], stroke);
            }
            scene.items.push(Item::Circle { center: (axis.place(value), y), radius: 3.0, rgb: color.rgb() });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_panels_and_marks_are_there() {
        let panel = |label: &str, mark| DotPanel {
            label: label.into(),
            mark,
            published: vec![None, Some(0.6)],
            values: vec![Some(Dot { value: 0.4, bounds: Some((0.2, 0.5)) }), None],
        };
        let dots = Dots {
            title: "Readings of CovF".into(),
            note: String::new(),
            rows: vec!["as printed".into(), "x<y".into()],
            panels: vec![panel("recall", Some(0.7)), panel("precision", None)],
            shared_axis: false,
            colors: vec![Color::Green, Color::Gray],
            chance: Some(0.5),
        };
        let scene = dots.scene(crate::figure::WIDTH).unwrap();
        let circles = scene.items.iter().filter(|i| matches!(i, Item::Circle { .. })).count();
        let black = Color::Black.rgb();
        let marks = scene
            .items
            .iter()
            .filter(|i| matches!(i, Item::Line { stroke, .. } if stroke.rgb == black))
            .count();
        assert_eq!((circles, marks), (2, 1));
        let with = |stroke: [u8; 3], dash| {
            let is_it =
                |i: &&Item| matches!(i, Item::Line { stroke: s, .. } if (s.rgb, s.dash) == (stroke, dash));
            scene.items.iter().filter(is_it).count()
        };
        // Each panel has the interval of the first row in its color, and the line of chance.
        assert_eq!((with(Color::Green.rgb(), Dash::Solid), with(SOFT, Dash::Dashed)), (2, 2));
        let svg = dots.to_svg().unwrap();
        assert!(svg.contains("x&lt;y") && svg.contains("precision"));
        assert!(Dots { rows: vec![], ..dots }.to_svg().is_err());
    }

    // Both panels have values of .4; with an axis of its own, the one without a mark has it further to the right.
    #[test]
    fn equal_values_of_a_shared_axis_are_in_equal_places() {
        let dot = |value| Some(Dot { value, bounds: None });
        let panel = |high| DotPanel {
            label: "p".into(),
            mark: None,
            published: vec![],
            values: vec![dot(0.0), dot(0.4), dot(high)],
        };
        let places = |shared_axis| {
            let (rows, panels) = (["a", "b", "c"].map(String::from).into(), vec![panel(0.4), panel(1.0)]);
            let (title, note) = (String::new(), String::new());
            let dots = Dots { title, note, rows, panels, shared_axis, colors: vec![], chance: None };
            let scene = dots.scene(crate::figure::WIDTH).unwrap();
            let circle = |i: &Item| if let Item::Circle { center, .. } = i { Some(center.0) } else { None };
            let x: Vec<f64> = scene.items.iter().filter_map(circle).collect();
            (x[1] - x[0], x[4] - x[3])
        };
        let (own, shared) = (places(false), places(true));
        assert!((shared.0 - shared.1).abs() < 1e-9 && own.0 > 2.0 * own.1, "{own:?} {shared:?}");
    }
}
