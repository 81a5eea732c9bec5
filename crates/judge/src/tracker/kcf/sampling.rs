//! Conversion of a window of the frame to a patch of the template's size.

use crate::image::patch::{Axis, Colors, Outside, Patch};
use crate::image::{Frame, Window};
use crate::tracker::correlation::block_means;
use serde::{Deserialize, Serialize};

/// Rule for reading the pixels of a resized window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// A window of whole pixels, interpolated bilinearly.
    WholePixels,
    /// A window around the exact center, interpolated bilinearly.
    Exact,
    /// A window around the exact center. Each value is the mean of as many samples in each direction as it
    /// covers pixels.
    Area,
}

impl Sampling {
    /// Patch of `size` columns and rows around `center`, in pixels of the frame. `ratio` is the side of a
    /// patch pixel.
    pub fn patch(
        self,
        frame: &Frame,
        center: (f64, f64),
        size: (usize, usize),
        ratio: f64,
        colors: Colors,
    ) -> Patch {
        if self == Self::WholePixels {
            let side = |n: usize| ((n as f64 * ratio) as usize).max(1);
            let start = |c: f64, side: usize| (c - (side / 2) as f64).floor() as i64;
            let (w, h) = (side(size.0), side(size.1));
            let window = Window { x: start(center.0, w), y: start(center.1, h), w, h };
            return Patch::resized(frame, &window, size.0, size.1, colors);
        }
        let times = if self == Self::Area { ratio.ceil().max(1.0) as usize } else { 1 };
        let axis = |c: f64, n: usize| Axis::around(c, n as f64 * ratio, n * times);
        let (across, down) = (axis(center.0, size.0), axis(center.1, size.1));
        block_means(&Patch::sampled(frame, &across, &down, Outside::Repeated, colors), times)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Frame {
        Frame::from_fn(40, 30, |x, y| [(5 * x) as u8, (5 * y) as u8, 9])
    }

    // By hand: a sample in the middle of pixel x has the value 5 x; blocks of a ramp have the value in their middle.
    #[test]
    fn windows_are_where_they_should_be() {
        let first = |sampling: Sampling, x: f64, size: usize, ratio: f64| {
            sampling.patch(&ramp(), (x, 15.0), (size, 4), ratio, Colors::Rgb).values[0]
        };
        for sampling in [Sampling::Exact, Sampling::Area] {
            assert!((first(sampling, 20.0, 4, 2.0) - 5.0 * 16.5).abs() < 1e-3, "{sampling:?}");
            assert!((first(sampling, 20.3, 4, 2.0) - 5.0 * 16.8).abs() < 1e-3, "{sampling:?}");
        }
        // Columns 16 to 23 in four pairs; a part of a pixel is cut off, of places and of sides.
        assert_eq!(first(Sampling::WholePixels, 20.0, 4, 2.0), 5.0 * 16.5);
        assert_eq!(first(Sampling::WholePixels, 20.9, 4, 2.2), 5.0 * 16.5);
    }

    // A checkerboard is gray in the mean of areas, and not when samples fall on pixels.
    #[test]
    fn areas_are_averaged() {
        let board = Frame::from_fn(40, 30, |x, y| [if (x + y) % 2 == 0 { 0 } else { 200 }; 3]);
        let shades =
            |sampling: Sampling| sampling.patch(&board, (20.0, 15.0), (6, 6), 3.0, Colors::Gray).values;
        assert!(shades(Sampling::Area).iter().all(|v| (70.0..130.0).contains(v)));
        assert!(shades(Sampling::Exact).iter().any(|v| *v < 1.0 || *v > 199.0));
    }
}
