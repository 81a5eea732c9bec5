//! Signs at points of curves.

use super::scene::{Item, Point, Scene, Stroke};
use super::style::{Color, Dash};

/// Meaning of a single point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// A ring: the point at which a method is operated.
    Operating,
    /// A hollow diamond: what a paper prints.
    Published,
}

/// Draws a sign around a point.
pub fn draw_sign(scene: &mut Scene, sign: Sign, (x, y): Point, color: Color) {
    let rgb = color.rgb();
    match sign {
        Sign::Operating => {
            let angle = |k: i32| f64::from(k) / 24.0 * std::f64::consts::TAU;
            let ring: Vec<Point> =
                (0..=24).map(angle).map(|a| (x + 6.0 * a.cos(), y + 6.0 * a.sin())).collect();
            scene.line(ring.clone(), Stroke { rgb: [255; 3], width: 3.4, dash: Dash::Solid });
            scene.line(ring, Stroke { rgb, width: 1.8, dash: Dash::Solid });
        }
        Sign::Published => {
            let diamond = |r: f64| vec![(x, y - r), (x + r, y), (x, y + r), (x - r, y)];
            scene.items.push(Item::Polygon { corners: diamond(8.0), rgb: [255; 3] });
            scene.items.push(Item::Polygon { corners: diamond(6.5), rgb });
            scene.items.push(Item::Polygon { corners: diamond(3.6), rgb: [255; 3] });
        }
    }
}
