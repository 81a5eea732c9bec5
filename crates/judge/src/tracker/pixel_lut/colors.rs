//! Colors of the target and of its surroundings.

use super::codes::Codes;
use crate::image::Frame;
use crate::image::Window;
use crate::region::Rect;

/// Number of bins: 16 x 16 x 16.
const BINS: usize = 4096;

/// Color shares inside and around the target.
#[derive(Debug, Clone)]
pub struct Colors {
    inside: Vec<f64>,
    around: Vec<f64>,
    counts: [Vec<u32>; 2],
}

fn bin(frame: &Frame, x: i64, y: i64) -> usize {
    let [r, g, b] = frame.pixel_clamped(x, y).map(|v| usize::from(v >> 4));
    r << 8 | g << 4 | b
}

impl Colors {
    /// Empty shares, for which all colors have probability 1/2.
    pub fn new() -> Self {
        Self { inside: vec![0.0; BINS], around: vec![0.0; BINS], counts: [vec![0; BINS], vec![0; BINS]] }
    }

    /// Moves the shares towards those of a frame by `rate`: those of the box, and of the rest of the coded
    /// block.
    pub fn follow(&mut self, frame: &Frame, codes: &Codes, target: &Rect, rate: f64) {
        let inner = Window::from_rect(target);
        self.counts.iter_mut().for_each(|c| c.fill(0));
        let height = codes.colors.len() / codes.width.max(1);
        let block = Window { x: codes.left, y: codes.top, w: codes.width, h: height };
        let Some(block) = block.clipped(frame) else { return };
        for y in block.y..block.y + block.h as i64 {
            let row_inside = (inner.y..inner.y + inner.h as i64).contains(&y);
            for x in block.x..block.x + block.w as i64 {
                let outside = !(row_inside && (inner.x..inner.x + inner.w as i64).contains(&x));
                self.counts[usize::from(outside)][bin(frame, x, y)] += 1;
            }
        }
        for (shares, counts) in [&mut self.inside, &mut self.around].into_iter().zip(&self.counts) {
            let sum = counts.iter().sum::<u32>();
            if sum > 0 {
                for (share, count) in shares.iter_mut().zip(counts) {
                    *share += rate * (f64::from(*count) / f64::from(sum) - *share);
                }
            }
        }
    }

    /// `P(target | color)` with equal priors. Rarely seen colors have about 1/2.
    pub fn probability(&self, frame: &Frame, x: i64, y: i64) -> f64 {
        let bin = bin(frame, x, y);
        let (inside, around) = (self.inside[bin] + 1e-4, self.around[bin] + 1e-4);
        inside / (inside + around)
    }
}
