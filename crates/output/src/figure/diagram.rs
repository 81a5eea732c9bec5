//! Boxes with names and arrows between them, for state diagrams.

use super::font;
use super::page::{Area, LINE, Page, Point};
use super::style::{Color, INK, MARGIN, MEDIUM, SMALL, SOFT, Style, WIDTH};
use plotters::style::text_anchor::HPos;

/// Half of a box's height, in units.
const HALF: f64 = 16.0;
/// Total horizontal room around the name in a box, in units.
const ROOM: f64 = 14.0;
/// Most horizontal room for a label within a column, in units.
const NARROW: f64 = 96.0;
/// Distance of an arrow from the line between the centers of its boxes, and length of a loop, in units.
const APART: f64 = 7.0;
const LOOP: f64 = 18.0;

const ARROW: Style = Style::solid(INK, 1.2);

/// Outline of the box around a name.
fn outline(at: Point, name: &str) -> Area {
    Area::around(at, font::width(name, MEDIUM) / 2.0 + ROOM, HALF)
}

/// Draws a box with its name.
pub fn node(page: &mut Page, at: Point, name: &str) {
    let mut corners = outline(at, name).corners();
    corners.push(corners[0]);
    page.line(corners, Style::solid(Color::BLUE, 1.6));
    page.text(name, at, MEDIUM, HPos::Center, INK);
}

/// Draws an arrow with its label between two boxes, which are given by their centers and names. An arrow of a
/// pair is drawn on its own side of the connecting line; a single one on the outer side of the area. An arrow
/// from a box to itself is a loop.
pub fn arrow(page: &mut Page, area: &Area, ends: [(Point, &str); 2], label: &[String], is_pair: bool) {
    let [a, b] = ends.map(|end| end.0);
    let [from, to] = ends.map(|(at, name)| outline(at, name));
    let center = area.middle();
    if a == b {
        // In a column there is no room beside a box, but below it.
        let (out, at) = match page.width < WIDTH {
            true => ((0.0, 1.0), (a.0, from.bottom())),
            false if a.0 < center.0 - 1.0 => ((-1.0, 0.0), (from.x, a.1)),
            false => ((1.0, 0.0), (from.right(), a.1)),
        };
        let corner = |along: f64, across: f64| {
            (at.0 + along * out.0 + across * out.1, at.1 + along * out.1 + across * out.0)
        };
        page.line(vec![corner(0.0, -APART), corner(LOOP, -APART), corner(LOOP, APART)], ARROW);
        head(page, corner(LOOP, APART), corner(0.0, APART));
        write(page, label, corner(LOOP - 2.0, 0.0), out);
        return;
    }
    let along = direction(a, b);
    let left = (along.1, -along.0);
    let middle = ((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0);
    let outwards = (middle.0 - center.0) * left.0 + (middle.1 - center.1) * left.1 >= 0.0;
    let side = if is_pair || outwards { 1.0 } else { -1.0 };
    let normal = (side * left.0, side * left.1);
    let [a, b] = [a, b].map(|p| (p.0 + APART * normal.0, p.1 + APART * normal.1));
    // The part of the way that lies outside of both boxes.
    let start = from.clip(a, b).map_or(a, |inside| inside.1);
    let end = to.clip(a, b).map_or(b, |inside| inside.0);
    head(page, start, end);
    write(page, label, ((start.0 + end.0) / 2.0, (start.1 + end.1) / 2.0), normal);
}

/// Unit vector from `a` to `b`.
fn direction(a: Point, b: Point) -> Point {
    let length = (b.0 - a.0).hypot(b.1 - a.1);
    ((b.0 - a.0) / length, (b.1 - a.1) / length)
}

/// Draws a line that ends in an arrowhead.
fn head(page: &mut Page, start: Point, end: Point) {
    let along = direction(start, end);
    let wing = |k: f64| (end.0 - 9.0 * along.0 + k * along.1, end.1 - 9.0 * along.1 - k * along.0);
    page.line(vec![start, end], ARROW);
    page.fill(vec![end, wing(3.6), wing(-3.6)], INK);
}

/// Writes the lines of a label beside `at`, on the side to which `normal` points.
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
