//! Boxes with names and arrows between them, for state diagrams.

use super::font;
use super::page::{Area, LINE, Page, Point, Stroke};
use super::style::{Color, INK, MARGIN, MEDIUM, SMALL, SOFT, WIDTH};
use plotters::style::text_anchor::HPos;

/// Half the height of a box, in units.
const HALF: f64 = 16.0;
/// Room beside a name in its box, in units.
const ROOM: f64 = 14.0;
/// Most room for a label in a column, in units.
const NARROW: f64 = 96.0;
/// Distance of an arrow from the line between the middles of its boxes, and length of a loop, in units.
const APART: f64 = 7.0;
const LOOP: f64 = 18.0;

fn half_width(name: &str) -> f64 {
    font::width(name, MEDIUM) / 2.0 + ROOM
}

/// Draws a box with its name.
pub fn node(page: &mut Page, (x, y): Point, name: &str) {
    let w = half_width(name);
    let mut outline = Area { x: x - w, y: y - HALF, w: 2.0 * w, h: 2.0 * HALF }.corners();
    outline.push(outline[0]);
    page.line(outline, Stroke::solid(Color::Blue.rgb(), 1.6));
    page.text(name, (x, y), MEDIUM, HPos::Center, INK);
}

/// Draws an arrow between two boxes, given by their middles and names, with its label; one of a pair lies on its side of
/// the way, any other one on the outer side of the area. An arrow from a box to itself is a loop.
pub fn arrow(page: &mut Page, area: &Area, ends: [(Point, &str); 2], label: &[String], is_pair: bool) {
    let [a, b] = ends.map(|end| end.0);
    let [from, to] = ends.map(|end| half_width(end.1));
    let center = (area.x + area.w / 2.0, area.y + area.h / 2.0);
    if a == b {
        // In a column there is no room beside a box, but below it.
        let (out, at) = if page.width < WIDTH {
            ((0.0, 1.0), (a.0, a.1 + HALF))
        } else {
            let side = if a.0 < center.0 - 1.0 { -1.0 } else { 1.0 };
            ((side, 0.0), (a.0 + side * from, a.1))
        };
        let corner = |along: f64, across: f64| {
            (at.0 + along * out.0 + across * out.1, at.1 + along * out.1 + across * out.0)
        };
        page.line(vec![corner(0.0, -APART), corner(LOOP, -APART)], LINE_STROKE);
        page.line(vec![corner(LOOP, -APART), corner(LOOP, APART)], LINE_STROKE);
        head(page, corner(LOOP, APART), corner(0.0, APART));
        write(page, label, corner(LOOP - 2.0, 0.0), out);
        return;
    }
    let length = (b.0 - a.0).hypot(b.1 - a.1);
    let along = ((b.0 - a.0) / length, (b.1 - a.1) / length);
    let left = (along.1, -along.0);
    let middle = ((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0);
    let outwards = (middle.0 - center.0) * left.0 + (middle.1 - center.1) * left.1 >= 0.0;
    let side = if is_pair || outwards { 1.0 } else { -1.0 };
    let normal = (side * left.0, side * left.1);
    let shifted = |p: Point| (p.0 + APART * normal.0, p.1 + APART * normal.1);
    let start = border(shifted(a), along, a, from);
    let end = border(shifted(b), (-along.0, -along.1), b, to);
    head(page, start, end);
    write(page, label, ((start.0 + end.0) / 2.0, (start.1 + end.1) / 2.0), normal);
}

const LINE_STROKE: Stroke = Stroke::solid(INK, 1.2);

/// A line that ends in the head of an arrow.
fn head(page: &mut Page, start: Point, end: Point) {
    let length = (end.0 - start.0).hypot(end.1 - start.1);
    let along = ((end.0 - start.0) / length, (end.1 - start.1) / length);
    let wing = |k: f64| (end.0 - 9.0 * along.0 + k * along.1, end.1 - 9.0 * along.1 - k * along.0);
    page.line(vec![start, end], LINE_STROKE);
    page.fill(vec![end, wing(3.6), wing(-3.6)], INK);
}

/// Where a ray from `start` leaves the box of half width `w` around `middle`.
fn border(start: Point, along: Point, middle: Point, w: f64) -> Point {
    let reach = |from: f64, along: f64, middle: f64, half: f64| {
        if along == 0.0 { f64::INFINITY } else { ((half * along.signum()) - (from - middle)) / along }
    };
    let t = reach(start.0, along.0, middle.0, w).min(reach(start.1, along.1, middle.1, HALF)).max(0.0);
    (start.0 + t * along.0, start.1 + t * along.1)
}

/// Writes the lines of a label beside `at`, on the side that `normal` points to.
fn write(page: &mut Page, label: &[String], at: Point, normal: Point) {
    let left = at.0 + 8.0 * normal.0;
    let right = page.width - left;
    let (anchor, room) = match normal.0 {
        x if x > 0.3 => (HPos::Left, right),
        x if x < -0.3 => (HPos::Right, left),
        _ => (HPos::Center, 2.0 * left.min(right)),
    };
    let room = if page.width < WIDTH { room.min(NARROW) } else { room };
    let lines: Vec<String> = label.iter().flat_map(|line| font::wrap(line, SMALL, room - MARGIN)).collect();
    let height = LINE * lines.len() as f64;
    let y = at.1 + (8.0 + height / 2.0) * normal.1 - height / 2.0;
    page.lines(&lines, (left, y), SMALL, anchor, SOFT);
}

#[cfg(test)]
mod tests {
    use super::*;

    // By hand: a box of 20 x 16 around (0, 0); from (0, 7) to the right it is left at x = 20, upwards at y = -16.
    #[test]
    fn arrows_begin_at_the_border() {
        assert_eq!(border((0.0, 7.0), (1.0, 0.0), (0.0, 0.0), 20.0), (20.0, 7.0));
        assert_eq!(border((3.0, 0.0), (0.0, -1.0), (0.0, 0.0), 20.0), (3.0, -16.0));
    }
}
