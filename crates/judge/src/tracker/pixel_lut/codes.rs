//! Quantized pixels of the searched part of a frame.

use crate::image::{Frame, luma};

/// Number of color codes: 8 x 8 x 8.
pub const COLORS: usize = 512;
/// Number of tone codes: 16 gray levels times 16, of which 9 are used (8 directions and flat).
pub const TONES: usize = 256;
/// Direction code of pixels without a gradient.
const FLAT: u8 = 8;

/// Codes of a block of pixels. Beyond the frame its border is repeated.
#[derive(Debug, Clone, Default)]
pub struct Codes {
    /// Column of the first pixel.
    pub left: i64,
    /// Row of the first pixel.
    pub top: i64,
    /// Number of pixels per row.
    pub width: usize,
    /// Color codes: the upper three bits of red, green and blue.
    pub colors: Vec<u16>,
    /// Tone codes: the upper four bits of the luma, then the direction of its gradient.
    pub tones: Vec<u8>,
    gray: Vec<u8>,
}

impl Codes {
    /// Codes the block of `width` by `height` pixels from `(left, top)` on. A pixel is flat if its central
    /// differences, in gray levels over two pixels, have a length below `flat_below`.
    pub fn look(
        &mut self,
        frame: &Frame,
        (left, top): (i64, i64),
        (width, height): (usize, usize),
        flat_below: f64,
    ) {
        (self.left, self.top, self.width) = (left, top, width);
        self.colors.clear();
        self.tones.clear();
        self.gray.clear();
        let inside = |v: i64, room: usize| v.clamp(0, room as i64 - 1) as usize;
        // A pixel more on every side for the differences.
        let columns: Vec<usize> =
            (-1..=width as i64).map(|i| 3 * inside(left.saturating_add(i), frame.width())).collect();
        for j in -1..=height as i64 {
            let row = frame.row(inside(top.saturating_add(j), frame.height()));
            self.gray.extend(columns.iter().map(|&i| luma([row[i], row[i + 1], row[i + 2]])));
            if (0..height as i64).contains(&j) {
                self.colors.extend(columns[1..=width].iter().map(|&i| {
                    let [r, g, b] = [row[i], row[i + 1], row[i + 2]].map(|v| u16::from(v >> 5));
                    r << 6 | g << 3 | b
                }));
            }
        }
        // No gradient has no direction.
        let limit = ((flat_below * flat_below).ceil() as i32).max(1);
        let stride = width + 2;
        for j in 1..=height {
            let row = |j: usize| &self.gray[j * stride..][..stride];
            let (above, here, below) = (row(j - 1), row(j), row(j + 1));
            self.tones.extend((1..=width).map(|i| {
                let gx = i32::from(here[i + 1]) - i32::from(here[i - 1]);
                let gy = i32::from(below[i]) - i32::from(above[i]);
                let direction = if gx * gx + gy * gy < limit { FLAT } else { octant(gx, gy) };
                (here[i] & 0xf0) | direction
            }));
        }
    }
}

/// Octant of a direction other than `(0, 0)`, counted from the x axis towards the y axis. A direction on a
/// border belongs to one of the two.
fn octant(gx: i32, gy: i32) -> u8 {
    // Within a quadrant the two halves change places from one quadrant to the next.
    let quadrant = u8::from(gy < 0) << 1 | u8::from((gx < 0) != (gy < 0));
    let steep = gy.abs() > gx.abs();
    2 * quadrant + u8::from(steep != (quadrant & 1 == 1))
}
