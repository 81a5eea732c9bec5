//! Gray values.

use super::{Frame, Window};
use multiversion::multiversion;

/// Luma of an RGB pixel, 0 to 255: .2989 R + .5870 G + .1140 B (ITU-R BT.601 as MATLAB rounds it), rounded
/// half up.
#[inline(always)]
pub fn luma([r, g, b]: [u8; 3]) -> u8 {
    ((2989 * u32::from(r) + 5870 * u32::from(g) + 1140 * u32::from(b) + 5000) / 10_000) as u8
}

/// Luma of the pixels in a window, rows from the top. The window must lie on the frame.
pub fn luma_of(frame: &Frame, window: &Window) -> Vec<u8> {
    let (left, top) = (window.x as usize, window.y as usize);
    let mut values = Vec::with_capacity(window.w * window.h);
    for y in top..top + window.h {
        let pixels = frame.row(y)[3 * left..3 * (left + window.w)].as_chunks::<3>().0;
        extend_with_luma(pixels, &mut values);
    }
    values
}

#[multiversion(targets("x86_64+avx2"))]
fn extend_with_luma(pixels: &[[u8; 3]], values: &mut Vec<u8>) {
    values.extend(pixels.iter().map(|p| luma(*p)));
}

/// Gray values of a frame, or of a part of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gray {
    /// Width of the frame in pixels.
    pub width: usize,
    /// Height of the frame in pixels.
    pub height: usize,
    /// Part of the frame whose values are known.
    pub part: Window,
    /// Four values for each pixel of the part, rows from the top, in ascending bytes: the pixel itself,
    /// right, below, and below right. Pixels beyond the part repeat its border. So an interpolation takes a
    /// single look-up.
    pub corners: Vec<u32>,
}

impl Gray {
    /// Luma of the pixels in a window of at least one pixel.
    pub fn of_part(frame: &Frame, window: &Window) -> Self {
        let part = window.clipped(frame).unwrap_or(Window { x: 0, y: 0, w: 1, h: 1 });
        Self::of_values(frame.width(), frame.height(), part, &luma_of(frame, &part))
    }

    /// Gray values of a part, from its values, rows from the top.
    pub(super) fn of_values(width: usize, height: usize, part: Window, values: &[u8]) -> Self {
        let row = |y: usize| &values[y * part.w..(y + 1) * part.w];
        let mut corners = Vec::with_capacity(values.len());
        for y in 0..part.h {
            let (upper, lower) = (row(y), row((y + 1).min(part.h - 1)));
            let corner =
                |x: usize, next: usize| u32::from_le_bytes([upper[x], upper[next], lower[x], lower[next]]);
            corners.extend((1..part.w).map(|next| corner(next - 1, next)));
            corners.push(corner(part.w - 1, part.w - 1));
        }
        Self { width, height, part, corners }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // python3, Pillow: [Image.new('RGB', (1, 1), c).convert('L').getpixel((0, 0)) for c in
    //   [(0, 0, 0), (255, 255, 255), (255, 0, 0), (0, 255, 0), (0, 0, 255), (12, 200, 99)]]
    #[test]
    fn is_the_luma_of_pillow() {
        let pixels: [[u8; 3]; 6] =
            [[0, 0, 0], [255, 255, 255], [255, 0, 0], [0, 255, 0], [0, 0, 255], [12, 200, 99]];
        let frame = Frame::from_fn(3, 2, |x, y| pixels[3 * y + x]);
        let gray = Gray::of_part(&frame, &Window { x: 0, y: 0, w: 3, h: 2 });
        assert_eq!((gray.width, gray.height), (3, 2));
        let corners = |gray: &Gray| gray.corners.iter().map(|c| c.to_le_bytes()).collect::<Vec<_>>();
        let repeated = [[150, 29, 150, 29], [29, 132, 29, 132], [132; 4]];
        assert_eq!(corners(&gray)[..3], [[0, 255, 150, 29], [255, 76, 29, 132], [76, 76, 132, 132]]);
        assert_eq!(corners(&gray)[3..], repeated);
        let part = Gray::of_part(&frame, &Window { x: 1, y: -3, w: 9, h: 4 });
        assert_eq!(part.part, Window { x: 1, y: 0, w: 2, h: 1 });
        assert_eq!(corners(&part), [[255, 76, 255, 76], [76; 4]]);
    }
}
