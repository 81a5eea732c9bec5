//! Windows of whole pixels, and the rule that rounds a real-valued box to one.

use super::Frame;
use crate::region::Rect;
use serde::{Deserialize, Serialize};

/// A block of whole pixels; its left top corner may lie outside the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Window {
    /// Left column.
    pub x: i64,
    /// Top row.
    pub y: i64,
    /// Columns, at least 1.
    pub w: usize,
    /// Rows, at least 1.
    pub h: usize,
}

/// Largest absolute coordinate in pixels, far beyond any frame; keeps absurd boxes from overflowing.
const MAX_COORDINATE: f64 = 1e6;
/// Longest side of a window in pixels, that of the largest frame.
const MAX_SIDE: f64 = 16_384.0;

impl Window {
    /// Left, top, width and height rounded to whole pixels (halves away from zero), at least 1x1.
    ///
    /// Sides beyond the largest readable frame are cut to it.
    pub fn from_rect(r: &Rect) -> Self {
        Self {
            x: r.x.clamp(-MAX_COORDINATE, MAX_COORDINATE).round() as i64,
            y: r.y.clamp(-MAX_COORDINATE, MAX_COORDINATE).round() as i64,
            w: r.w.clamp(1.0, MAX_SIDE).round() as usize,
            h: r.h.clamp(1.0, MAX_SIDE).round() as usize,
        }
    }

    /// Window of the frame that stands for a box: rounded, shifted inside and clipped.
    pub fn on_frame(r: &Rect, frame: &Frame) -> Self {
        let Self { x, y, w, h } = Self::from_rect(r).shifted_inside(frame);
        // NaN rounds to 0 pixels.
        Self { x, y, w: w.clamp(1, frame.width()), h: h.clamp(1, frame.height()) }
    }

    /// The window moved by the least amount that brings it inside the frame.
    ///
    /// A window larger than the frame is aligned with the frame's left (top) border; pixels beyond
    /// the right (bottom) border are then repeated border pixels when they are read.
    pub fn shifted_inside(&self, frame: &Frame) -> Self {
        let fit = |start: i64, len: usize, room: usize| start.clamp(0, (room as i64 - len as i64).max(0));
        Self { x: fit(self.x, self.w, frame.width()), y: fit(self.y, self.h, frame.height()), ..*self }
    }

    /// The part of the window that lies on the frame; `None` if there is none.
    pub fn clipped(&self, frame: &Frame) -> Option<Self> {
        let x0 = self.x.max(0);
        let y0 = self.y.max(0);
        let x1 = (self.x + self.w as i64).min(frame.width() as i64);
        let y1 = (self.y + self.h as i64).min(frame.height() as i64);
        (x1 > x0 && y1 > y0).then(|| Self { x: x0, y: y0, w: (x1 - x0) as usize, h: (y1 - y0) as usize })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_moved_inside_or_aligned() {
        let frame = Frame::new(10, 8, vec![0; 240]);
        let at = |x, y, w, h| Window { x, y, w, h }.shifted_inside(&frame);
        assert_eq!(at(-3, 7, 4, 4), Window { x: 0, y: 4, w: 4, h: 4 });
        assert_eq!(at(2, 2, 12, 3), Window { x: 0, y: 2, w: 12, h: 3 });
        let clipped = [(-3, 7), (10, 0)].map(|(x, y)| Window { x, y, w: 4, h: 4 }.clipped(&frame));
        assert_eq!(clipped, [Some(Window { x: 0, y: 7, w: 1, h: 1 }), None]);
    }

    #[test]
    fn boxes_become_pixels_of_the_frame() {
        let frame = Frame::new(10, 8, vec![0; 240]);
        let at = |x, y, w, h| Window::on_frame(&Rect::new(x, y, w, h), &frame);
        assert_eq!(at(-2.6, 6.0, 4.4, 3.5), Window { x: 0, y: 4, w: 4, h: 4 });
        assert_eq!(at(50.0, -9.0, 30.0, 2.0), Window { x: 0, y: 0, w: 10, h: 2 });
        assert_eq!(at(f64::NAN, 1.0, f64::NAN, 1.0), Window { x: 0, y: 1, w: 1, h: 1 });
    }

    #[test]
    fn absurd_boxes_stay_small() {
        let w = Window::from_rect(&Rect::new(1e300, -1e300, 1e300, 0.0));
        assert_eq!((w.w, w.h), (16_384, 1));
    }
}
