//! One panel of curves.

use super::{Curve, Curves, Facet};
use crate::figure::axes::{self, Axis};
use crate::figure::font;
use crate::figure::scene::{Anchor, Area, Item, Point, Scene, Stroke};
use crate::figure::sign::draw_sign;
use crate::figure::style::{Dash, INK, SMALL, SOFT};

/// Lines of other panels.
const BEHIND: Stroke = Stroke { rgb: [0xC9, 0xC9, 0xC9], width: 0.8, dash: Dash::Solid };
/// Lines of equal F.
const ISO: Stroke = Stroke { rgb: [0xDC, 0xDC, 0xDC], width: 0.8, dash: Dash::Dashed };
/// Most lines of equal F.
const MAX_ISO: usize = 5;

/// A panel's area with its axes.
pub struct Place {
    pub area: Area,
    pub x: Axis,
    pub y: Axis,
}

impl Place {
    fn of(&self, p: (f64, f64)) -> Point {
        (self.x.place(p.0), self.y.place(p.1))
    }

    fn is_inside(&self, at: Point) -> bool {
        self.area.clip(at, at).is_some()
    }

    /// Draws everything but the frame.
    pub fn draw(&self, scene: &mut Scene, curves: &Curves, facet: &Facet) {
        let shown = |p: &(f64, f64)| curves.x.shows(p.0) && curves.y.shows(p.1);
        let area = &self.area;
        if curves.iso_f {
            self.iso_f(scene);
        }
        for points in &facet.behind {
            for run in points.split(|p| !shown(p)) {
                let places: Vec<Point> = run.iter().map(|p| self.of(*p)).collect();
                scene.clipped(&axes::thinned(&places), area, BEHIND);
            }
        }
        for curve in &facet.series {
            self.band(scene, curves, curve);
        }
        for (at, style) in facet.uprights.iter().filter(|u| curves.x.shows(u.0)) {
            let x = self.x.place(*at);
            scene.clipped(&[(x, area.y), (x, area.bottom())], area, Stroke::of(style));
        }
        for curve in &facet.series {
            let rgb = curve.style.color.rgb();
            for run in curve.points.split(|p| !shown(p)).filter(|r| !r.is_empty()) {
                let places: Vec<Point> = run.iter().map(|p| self.of(*p)).collect();
                scene.clipped(&axes::thinned(&places), area, Stroke::of(&curve.style));
                for &at in places.iter().filter(|p| self.is_inside(**p)) {
                    match curve.marker {
                        Some(marker) => marker.draw(scene, at, rgb),
                        None if run.len() == 1 => {
                            scene.items.push(Item::Circle { center: at, radius: curve.style.width, rgb });
                        }
                        None => {}
                    }
                }
            }
        }
        for (sign, at, color) in facet.signs.iter().filter(|s| shown(&s.1)) {
            let at = self.of(*at);
            if self.is_inside(at) {
                draw_sign(scene, *sign, at, *color);
            }
        }
        self.names(scene, facet);
    }

    /// The band between the bounds of a curve, cut off at the panel's upper and lower end.
    fn band(&self, scene: &mut Scene, curves: &Curves, curve: &Curve) {
        // From left to right, although a curve in the order of what is along y may turn back.
        let mut pairs: Vec<_> = curve.points.iter().zip(&curve.band).collect();
        pairs.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
        let known = |pair: &(&(f64, f64), &(f64, f64))| {
            curves.x.shows(pair.0.0) && curves.y.shows(pair.1.0) && curves.y.shows(pair.1.1)
        };
        let inside = |y: f64| self.y.place(y).clamp(self.area.y, self.area.bottom());
        for run in pairs.split(|pair| !known(pair)).filter(|run| run.len() > 1) {
            let upper = run.iter().map(|(p, b)| (self.x.place(p.0), inside(b.1))).collect();
            let lower = run.iter().map(|(p, b)| (self.x.place(p.0), inside(b.0))).collect();
            scene.items.push(Item::Band { upper, lower, rgb: curve.style.color.rgb() });
        }
    }

    /// Lines of equal F = 2 P R / (P + R): P = F R / (2 R - F), each named at its end.
    fn iso_f(&self, scene: &mut Scene) {
        let ends = |axis: &Axis| axis.ends().1.min(1.0);
        let (recall, precision) = (ends(&self.x), ends(&self.y));
        if recall <= 0.0 || precision <= 0.0 {
            return;
        }
        let highest = 2.0 * recall * precision / (recall + precision);
        let ticks = Axis::new((0.0, highest), (0.0, 1.0), 0.0, false).ticks(MAX_ISO);
        for (f, name) in ticks.into_iter().filter(|t| t.0 > 0.0 && t.0 < highest * 0.97) {
            // From the recall at which it meets the panel's upper edge.
            let first = f * precision / (2.0 * precision - f);
            let at = |k: usize| {
                let r = first + (recall - first) * (k as f64 / 100.0).powi(2);
                (r, if k == 0 { precision } else { f * r / (2.0 * r - f) })
            };
            let line: Vec<Point> = (0..=100).map(|k| self.of(at(k))).collect();
            scene.clipped(&line, &self.area, ISO);
            if let Some(end) = line.last() {
                let name = format!("F {}", name.trim_start_matches('0'));
                let w = font::width(&name, SMALL) + 4.0;
                let (x, y) = (end.0 - w, end.1 - 6.0);
                scene.items.push(Item::Rect { area: Area { x, y, w, h: 12.0 }, rgb: [255; 3] });
                scene.text(&name, (end.0 - 2.0, end.1), SMALL, Anchor::End, SOFT);
            }
        }
    }

    /// Names beside points, each at the first of four sides where nothing else stands.
    fn names(&self, scene: &mut Scene, facet: &Facet) {
        let points: Vec<Point> = facet.names.iter().map(|n| self.of(n.1)).collect();
        let mut taken: Vec<Area> =
            points.iter().map(|p| Area { x: p.0 - 4.0, y: p.1 - 4.0, w: 8.0, h: 8.0 }).collect();
        let apart = |a: &Area, b: &Area| {
            a.right() <= b.x || b.right() <= a.x || a.bottom() <= b.y || b.bottom() <= a.y
        };
        for ((name, _), &(x, y)) in facet.names.iter().zip(&points) {
            let name = font::fit(name, SMALL, self.area.w / 2.0);
            let w = font::width(&name, SMALL);
            let sides = [(6.0, 0.0), (-6.0 - w, 0.0), (-w / 2.0, -11.0), (-w / 2.0, 12.0)];
            let room = sides.map(|(dx, dy)| Area { x: x + dx, y: y + dy - 6.0, w, h: 12.0 });
            let fits = |a: &&Area| {
                let within = a.x >= self.area.x && a.right() <= self.area.right() + 4.0;
                within && a.bottom() <= self.area.bottom() && taken.iter().all(|t| apart(a, t))
            };
            let place = *room.iter().find(fits).unwrap_or(&room[0]);
            scene.text(&name, (place.x, place.y + 6.0), SMALL, Anchor::Start, INK);
            taken.push(place);
        }
    }
}
