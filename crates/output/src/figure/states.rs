//! State diagrams: boxes on a circle, arrows with labels between them.

use super::draw::Plot;
use super::error::FigureError;
use super::font;
use super::heading::heading;
use super::scene::{Anchor, Item, Point, Scene, Stroke};
use super::style::{Color, Dash, INK, MARGIN, MEDIUM, SMALL, SOFT, WIDTH};

/// An arrow.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Arrow {
    /// Index of the state it leaves.
    pub from: usize,
    /// Index of the state it leads to; the same for a loop.
    pub to: usize,
    /// Its label, line by line.
    pub label: Vec<String>,
}

/// A state diagram. Arrows between the same states in the same direction share a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct States {
    /// Title; may be empty.
    pub title: String,
    /// Note under the title; may be empty.
    pub note: String,
    /// Names of the states, clockwise from the top.
    pub states: Vec<String>,
    /// The arrows.
    pub arrows: Vec<Arrow>,
}

/// Half the height of a box, in units.
const HALF: f64 = 16.0;
/// Most room for a label in a column, in units.
const NARROW: f64 = 96.0;
/// Room beside a name in its box, in units.
const ROOM: f64 = 14.0;
/// Distance of an arrow from the line between the middles of its boxes, in units.
const APART: f64 = 7.0;
/// Stroke of arrows.
const LINE_STYLE: Stroke = Stroke { rgb: INK, width: 1.2, dash: Dash::Solid };
/// Height of a line of a label, in units.
const LINE: f64 = 14.0;

impl Plot for States {
    fn scene(&self, width: f64) -> Result<Scene, FigureError> {
        let n = self.states.len();
        let is_known = |a: &Arrow| a.from < n && a.to < n;
        if n == 0 || !self.arrows.iter().all(is_known) {
            return Err(FigureError::Empty("a state diagram needs states, and arrows between them"));
        }
        let mut scene = Scene::new(&self.title, width);
        let top = heading(&mut scene, &self.title, &self.note);
        let is_narrow = width < WIDTH;
        let (rx, ry) = if is_narrow { (0.33 * width, 130.0) } else { (0.3 * width, 110.0) };
        let center = (width / 2.0, top + HALF + 8.0 + ry);
        let place = |i: usize| {
            let angle = std::f64::consts::TAU * i as f64 / n as f64;
            (center.0 + rx * angle.sin(), center.1 - ry * angle.cos())
        };
        let half_width = |i: usize| font::width(&self.states[i], MEDIUM) / 2.0 + ROOM;
        let mut pairs: Vec<(usize, usize)> = Vec::new();
        for arrow in &self.arrows {
            if !pairs.contains(&(arrow.from, arrow.to)) {
                pairs.push((arrow.from, arrow.to));
            }
        }
        for &(from, to) in &pairs {
            let same = self.arrows.iter().filter(|a| (a.from, a.to) == (from, to));
            let label: Vec<&str> = same.flat_map(|a| &a.label).map(String::as_str).collect();
            let (a, b) = (place(from), place(to));
            if from == to && is_narrow {
                // Below the box, as there is no room beside it.
                let corner = |dx: f64, dy: f64| (a.0 + dx, a.1 + HALF + dy);
                scene.line(vec![corner(-APART, 0.0), corner(-APART, 16.0), corner(APART, 16.0)], LINE_STYLE);
                arrow(&mut scene, corner(APART, 16.0), corner(APART, 0.0), (0.0, -1.0));
                self.label(&mut scene, &label, corner(0.0, 14.0), (0.0, 1.0));
                continue;
            }
            if from == to {
                let side = if a.0 < center.0 - 1.0 { -1.0 } else { 1.0 };
                let x = a.0 + side * half_width(from);
                let corner = |dx: f64, dy: f64| (x + side * dx, a.1 + dy);
                scene.line(vec![corner(0.0, -APART), corner(20.0, -APART), corner(20.0, APART)], LINE_STYLE);
                arrow(&mut scene, corner(20.0, APART), corner(0.0, APART), (-side, 0.0));
                self.label(&mut scene, &label, corner(18.0, 0.0), (side, 0.0));
                continue;
            }
            let length = (b.0 - a.0).hypot(b.1 - a.1);
            let along = ((b.0 - a.0) / length, (b.1 - a.1) / length);
            // To the left of the way, or outwards where there is no way back.
            let left = (along.1, -along.0);
            let middle = ((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0);
            let outwards = (middle.0 - center.0) * left.0 + (middle.1 - center.1) * left.1 >= 0.0;
            let side = if pairs.contains(&(to, from)) || outwards { 1.0 } else { -1.0 };
            let normal = (side * left.0, side * left.1);
            let shifted = |p: Point| (p.0 + APART * normal.0, p.1 + APART * normal.1);
            let (start, end) = (shifted(a), shifted(b));
            let start = border(start, along, a, half_width(from));
            let end = border(end, (-along.0, -along.1), b, half_width(to));
            arrow(&mut scene, start, end, along);
            self.label(&mut scene, &label, ((start.0 + end.0) / 2.0, (start.1 + end.1) / 2.0), normal);
        }
        for (i, name) in self.states.iter().enumerate() {
            let (x, y) = place(i);
            let w = half_width(i);
            let corners = [(x - w, y - HALF), (x + w, y - HALF), (x + w, y + HALF), (x - w, y + HALF)];
            let outline: Vec<Point> = corners.iter().chain(&corners[..1]).copied().collect();
            scene.line(outline, Stroke { rgb: Color::Blue.rgb(), width: 1.6, dash: Dash::Solid });
            scene.text(name, (x, y), MEDIUM, Anchor::Middle, INK);
        }
        let lowest = scene.items.iter().map(|item| match item {
            Item::Text { at, .. } => at.1 + LINE / 2.0,
            Item::Line { points, .. } => points.iter().map(|p| p.1).fold(0.0, f64::max),
            _ => center.1 + ry + HALF,
        });
        scene.height = lowest.fold(0.0, f64::max) + MARGIN;
        Ok(scene)
    }
}

impl States {
    /// Draws the lines of a label beside `at`, on the side that `normal` points to.
    fn label(&self, scene: &mut Scene, lines: &[&str], at: Point, normal: Point) {
        let left = at.0 + 8.0 * normal.0;
        let right = scene.width - left;
        let (anchor, room) = match normal.0 {
            x if x > 0.3 => (Anchor::Start, right),
            x if x < -0.3 => (Anchor::End, left),
            _ => (Anchor::Middle, 2.0 * left.min(right)),
        };
        let room = if scene.width < WIDTH { room.min(NARROW) } else { room };
        let lines: Vec<String> =
            lines.iter().flat_map(|line| font::wrap(line, SMALL, room - MARGIN, 3)).collect();
        let height = LINE * lines.len() as f64;
        let (x, y) = (at.0 + 8.0 * normal.0, at.1 + (8.0 + height / 2.0) * normal.1);
        for (k, line) in lines.iter().enumerate() {
            let y = y - height / 2.0 + LINE * (k as f64 + 0.5);
            scene.text(line, (x, y), SMALL, anchor, SOFT);
        }
    }
}

/// Where a ray from `start` leaves the box of half width `w` around `middle`.
fn border(start: Point, along: Point, middle: Point, w: f64) -> Point {
    let reach = |from: f64, along: f64, middle: f64, half: f64| {
        if along == 0.0 { f64::INFINITY } else { ((half * along.signum()) - (from - middle)) / along }
    };
    let t = reach(start.0, along.0, middle.0, w).min(reach(start.1, along.1, middle.1, HALF)).max(0.0);
    (start.0 + t * along.0, start.1 + t * along.1)
}

fn arrow(scene: &mut Scene, start: Point, end: Point, along: Point) {
    scene.line(vec![start, end], LINE_STYLE);
    let back = (end.0 - 9.0 * along.0, end.1 - 9.0 * along.1);
    let wing = |k: f64| (back.0 + k * along.1, back.1 - k * along.0);
    scene.items.push(Item::Polygon { corners: vec![end, wing(3.6), wing(-3.6)], rgb: INK });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn diagram() -> States {
        let arrow = |from, to, label: &str| Arrow { from, to, label: vec![label.to_string()] };
        States {
            title: "Machine".into(),
            note: String::new(),
            states: ["one", "two", "three"].map(String::from).into(),
            arrows: vec![
                arrow(0, 1, "there"),
                arrow(1, 0, "back"),
                arrow(1, 2, "on"),
                arrow(1, 2, "and on"),
                arrow(2, 2, "round"),
            ],
        }
    }

    #[test]
    fn everything_is_shown_once_and_inside() {
        let svg = diagram().to_svg().unwrap();
        for word in ["one", "two", "three", "there", "back", "on", "and on", "round"] {
            assert_eq!(svg.matches(&format!(">\n{word}\n<")).count(), 1, "{word}");
        }
        let scene = diagram().scene(WIDTH).unwrap();
        // Two arrows of the same way share a line: three lines, two for the loop, and three boxes.
        assert_eq!(scene.items.iter().filter(|i| matches!(i, Item::Line { .. })).count(), 8);
        for item in &scene.items {
            if let Item::Line { points, .. } = item {
                assert!(points.iter().all(|p| p.0 > 0.0 && p.0 < WIDTH && p.1 > 0.0 && p.1 < scene.height));
            }
        }
    }

    // By hand: a box of 20 x 16 around (0, 0); from (0, 7) to the right it is left at x = 20, upwards at y = -16.
    #[test]
    fn arrows_begin_at_the_border() {
        assert_eq!(border((0.0, 7.0), (1.0, 0.0), (0.0, 0.0), 20.0), (20.0, 7.0));
        assert_eq!(border((3.0, 0.0), (0.0, -1.0), (0.0, 0.0), 20.0), (3.0, -16.0));
    }

    #[test]
    fn arrows_to_nowhere_are_refused() {
        let wrong =
            |from, to| States { arrows: vec![Arrow { from, to, label: vec![] }], ..diagram() }.to_svg();
        assert!(wrong(0, 3).is_err() && wrong(3, 1).is_err());
        assert!(States { states: vec![], arrows: vec![], ..diagram() }.to_svg().is_err());
    }
}
