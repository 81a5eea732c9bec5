//! Gray values.

use super::Frame;

/// Luma of an RGB pixel, 0 to 255: .2989 R + .5870 G + .1140 B (ITU-R BT.601 as MATLAB rounds it), rounded
/// half up.
pub fn luma([r, g, b]: [u8; 3]) -> u8 {
    ((2989 * u32::from(r) + 5870 * u32::from(g) + 1140 * u32::from(b) + 5000) / 10_000) as u8
}

/// A gray image, rows from the top, pixels from the left, a byte each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gray {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// `width * height` values.
    pub values: Vec<u8>,
}

impl Gray {
    /// The luma of every pixel of a frame.
    pub fn of(frame: &Frame) -> Self {
        let values = frame.bytes().chunks_exact(3).map(|p| luma([p[0], p[1], p[2]])).collect();
        Self { width: frame.width(), height: frame.height(), values }
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
        let gray = Gray::of(&frame);
        assert_eq!((gray.width, gray.height), (3, 2));
        assert_eq!(gray.values, [0, 255, 76, 150, 29, 132]);
    }
}
