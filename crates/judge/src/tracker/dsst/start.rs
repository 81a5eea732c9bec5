//! Start of a target: its place and size in whole pixels.

use crate::region::{Rect, Region};
use serde::{Deserialize, Serialize};

/// Rule that rounds the first region to whole pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Start {
    /// The pixel that holds the region's center, and the region's own sides.
    #[default]
    Release,
    /// As in the entry of VOT2014: coordinates count from 1, and quadrilaterals are a pixel larger in each
    /// direction.
    Vot2014,
}

impl Start {
    /// Pixel of the center (0-based), and the amount added to both sides. `first` is the upright rectangle of
    /// the region.
    pub fn pixel(self, region: &Region, first: &Rect) -> ((f64, f64), f64) {
        let (x, y) = first.center();
        match (self, region) {
            (Self::Release, _) => ((x.floor(), y.floor()), 0.0),
            (Self::Vot2014, Region::Polygon(_)) => ((x.round() - 1.0, y.round() - 1.0), 1.0),
            (Self::Vot2014, _) => (((x - 0.5).round() - 1.0, (y - 0.5).round() - 1.0), 0.0),
        }
    }
}

/// Rectangle at which a region starts.
pub fn upright(region: &Region) -> Rect {
    let Region::Polygon(corners) = region else { return region.rect() };
    let n = corners.len() as f64;
    let mean = |k: fn(&(f64, f64)) -> f64| corners.iter().map(k).sum::<f64>() / n;
    let Rect { w, h, .. } = region.bounds();
    let factor = (region.area() / (w * h)).sqrt();
    let (w, h) = (w * factor, h * factor);
    Rect::new(mean(|c| c.0) - 0.5 * w, mean(|c| c.1) - 0.5 * h, w, h)
}

#[cfg(test)]
mod tests {
    use super::*;

    // By hand: corners from (10.2, 20) to (30.2, 60.6) have the center (20.2, 40.3), which is pixel 20, 40 of those
    // counted from 1; a rectangle's center is half a pixel less.
    #[test]
    fn the_entry_counts_pixels_from_one() {
        let rect = Rect::new(10.2, 20.0, 20.0, 40.6);
        let corners = vec![(10.2, 20.0), (30.2, 20.0), (30.2, 60.6), (10.2, 60.6)];
        let polygon = Region::Polygon(corners);
        let first = upright(&polygon);
        assert_eq!(Start::Release.pixel(&polygon, &first), ((20.0, 40.0), 0.0));
        assert_eq!(Start::Vot2014.pixel(&polygon, &first), ((19.0, 39.0), 1.0));
        assert_eq!(Start::Vot2014.pixel(&Region::Rect(rect), &rect), ((19.0, 39.0), 0.0));
    }
}
