//! Looks of NanoTrack: scores and boxes that the network gives to the cells around a place of a frame.

use crate::image::patch::Patch;
use crate::image::{Frame, Window};
use crate::network::nanotrack::{Network, Template, Version, sigmoid};
use crate::region::Rect;
use crate::tracker::first_largest;

/// Pixels of the search region between neighboring cells of the maps.
const STRIDE: f64 = 16.0;

/// Side of the template crop in pixels; that of the search region follows.
const TEMPLATE_SIDE: usize = 127;
const SEARCH_SIDE: usize = 255;

/// Center and sides of a box, in pixels of the frame. As in the network, the center of the first pixel is at
/// 0.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Place {
    /// Center: column and row.
    pub center: [f64; 2],
    /// Width and height.
    pub sides: [f64; 2],
}

impl Place {
    /// Place of a box. Sides are at least one pixel.
    pub fn of(rect: &Rect) -> Self {
        let sides = [rect.w.max(1.0), rect.h.max(1.0)];
        Self { center: [rect.x + (sides[0] - 1.0) / 2.0, rect.y + (sides[1] - 1.0) / 2.0], sides }
    }

    /// The place, clamped: its center is at most three frame sides outside of the frame, and its sides are at
    /// most three frame sides.
    pub fn near(&self, room: [f64; 2]) -> Self {
        Self {
            center: std::array::from_fn(|k| self.center[k].clamp(-3.0 * room[k], 4.0 * room[k])),
            sides: std::array::from_fn(|k| self.sides[k].min(3.0 * room[k])),
        }
    }

    /// Side of the template around the place, in pixels of the frame.
    fn context(&self) -> f64 {
        side_with_margin(self.sides)
    }

    /// Square of the frame around the place, resized to `to` x `to` pixels and rounded to bytes.
    fn crop(&self, frame: &Frame, side: f64, to: usize, color: [f32; 3]) -> Vec<f32> {
        let side = side.round_ties_even().max(1.0);
        let [x, y] = self.center.map(|c| (c - (side + 1.0) / 2.0 + 0.5).floor() as i64);
        let window = Window { x, y, w: side as usize, h: side as usize };
        let mut patch = Patch::resized_over(frame, &window, to, to, color);
        patch.round();
        patch.values
    }
}

/// Side with margin: `sqrt((w + p) (h + p))` with `p = (w + h) / 2`.
fn side_with_margin([w, h]: [f64; 2]) -> f64 {
    let margin = (w + h) / 2.0;
    ((w + margin) * (h + margin)).sqrt()
}

/// A target in the form that the network compares.
pub struct Target {
    network: &'static Network,
    template: Template,
    /// Features of the template, from which it can be restored.
    pub features: Vec<f32>,
    /// Mean color of the first frame, which fills pixels outside of frames.
    pub color: [f32; 3],
}

impl Target {
    /// Target at a place of the first frame.
    pub fn new(version: Version, frame: &Frame, place: &Place) -> Self {
        let color = mean_color(frame);
        let crop = place.crop(frame, place.context(), TEMPLATE_SIDE, color);
        let network = Network::of(version);
        let features = network.features(&crop, TEMPLATE_SIDE);
        Self { network, template: network.template(&features), features: features.flat(), color }
    }

    /// Restores a target of its color and features; `None` if the number of features is wrong.
    pub fn remembered(version: Version, color: [f32; 3], features: Vec<f32>) -> Option<Self> {
        let network = Network::of(version);
        let template = network.template(&network.features_of_template(&features)?);
        Some(Self { network, template, features, color })
    }

    /// Scores and boxes of the cells around a place.
    pub fn look(&self, frame: &Frame, place: &Place) -> Look {
        let context = place.context();
        let crop =
            place.crop(frame, context * SEARCH_SIDE as f64 / TEMPLATE_SIDE as f64, SEARCH_SIDE, self.color);
        let answers = self.network.compare(&self.template, &self.network.features(&crop, SEARCH_SIDE));
        let (side, scale) = (answers.len().isqrt(), TEMPLATE_SIDE as f64 / context);
        let [influence, strength, rate] = constants(self.network.version());
        let window: Vec<f64> = (0..side).map(|i| hann(i, side)).collect();
        let size = place.sides.map(|side| side * scale);
        let cells = answers.into_iter().enumerate().map(|(cell, (classes, distances))| {
            let (row, column) = (cell / side, cell % side);
            let [background, target] = classes.map(f64::from);
            let [left, top, right, bottom] = distances.map(|d| libm::exp(f64::from(d)));
            let shift = [(right - left) / 2.0, (bottom - top) / 2.0];
            let [x, y] = [column, row].map(|i| offset(i, side));
            let sides = [left + right, top + bottom];
            let penalty = penalty(strength, sides, size);
            let score = sigmoid(target - background);
            let window = window[row] * window[column];
            Cell {
                score,
                shift: [x + shift[0], y + shift[1]].map(|d| d / scale),
                sides: sides.map(|s| s / scale),
                penalty,
                rank: penalty * score * (1.0 - influence) + window * influence,
            }
        });
        let cells: Vec<Cell> = cells.collect();
        let best = first_largest(cells.iter().map(|cell| cell.rank));
        Look { place: *place, cells, side, best, cell: STRIDE / scale, rate }
    }
}

/// Constants of a version: window influence, strength of the penalty, and learning rate.
fn constants(version: Version) -> [f64; 3] {
    match version {
        Version::V2 => [0.490, 0.150, 0.385],
        Version::V3 => [0.455, 0.138, 0.348],
    }
}

/// Penalty `exp(-k (s r - 1))` of strength `k` for the changes of size and shape from `size` to `sides`.
fn penalty(strength: f64, sides: [f64; 2], size: [f64; 2]) -> f64 {
    let change = |ratio: f64| ratio.max(1.0 / ratio);
    let scale = change(side_with_margin(sides) / side_with_margin(size));
    let shape = change((size[0] / size[1]) / (sides[0] / sides[1]));
    libm::exp(-strength * (scale * shape - 1.0))
}

/// Place of a row or column relative to the middle of the search region, in pixels of the region.
fn offset(i: usize, side: usize) -> f64 {
    STRIDE * (i as f64 - (side / 2) as f64)
}

/// Symmetric Hann window of `side` values, zero at both ends.
fn hann(i: usize, side: usize) -> f64 {
    0.5 - 0.5 * libm::cos(std::f64::consts::TAU * i as f64 / (side - 1) as f64)
}

fn mean_color(frame: &Frame) -> [f32; 3] {
    let mut sums = [0_u64; 3];
    for pixel in frame.bytes().as_chunks::<3>().0 {
        for (sum, v) in sums.iter_mut().zip(pixel) {
            *sum += u64::from(*v);
        }
    }
    let pixels = frame.bytes().len() as u64 / 3;
    // Whole, as in the source, where it is written into bytes.
    sums.map(|sum| (sum / pixels.max(1)) as f32)
}

/// A cell of the maps.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// Probability that the cell's box is the target.
    pub score: f64,
    /// Center of the cell's box relative to that of the look, in pixels of the frame.
    pub shift: [f64; 2],
    /// Sides of the cell's box in pixels of the frame.
    pub sides: [f64; 2],
    /// Penalty `exp(-k (s r - 1))` for changes of size and shape.
    pub penalty: f64,
    /// Score after penalty and window.
    pub rank: f64,
}

/// Cells around a place, `side` x `side`, row by row.
pub struct Look {
    /// Place at which the network looked.
    pub place: Place,
    /// All cells, row by row.
    pub cells: Vec<Cell>,
    /// Number of rows, and of columns.
    pub side: usize,
    /// Index of the cell that the tracker chooses, by score, penalty and window.
    pub best: usize,
    /// Distance between neighboring cells in pixels of the frame.
    pub cell: f64,
    /// Learning rate of the sides.
    pub rate: f64,
}

impl Look {
    /// Cell that the tracker chooses.
    pub fn chosen(&self) -> &Cell {
        &self.cells[self.best]
    }

    /// Box of a cell.
    pub fn rect(&self, cell: &Cell) -> Rect {
        let [w, h] = cell.sides;
        let [x, y] = std::array::from_fn(|k| self.place.center[k] + cell.shift[k]);
        Rect::new(x - (w - 1.0) / 2.0, y - (h - 1.0) / 2.0, w, h)
    }

    /// Next place of the tracker: the center of the chosen cell, and sides moved towards those of the cell by
    /// penalty times score times learning rate. The center stays in the frame; sides are from 10 pixels to
    /// those of the frame.
    pub fn next(&self, frame: &Frame) -> Place {
        let chosen = self.chosen();
        let rate = chosen.penalty * chosen.score * self.rate;
        let room = [frame.width() as f64, frame.height() as f64];
        Place {
            center: std::array::from_fn(|k| (self.place.center[k] + chosen.shift[k]).max(0.0).min(room[k])),
            sides: std::array::from_fn(|k| {
                (self.place.sides[k] * (1.0 - rate) + chosen.sides[k] * rate).max(10.0).min(room[k])
            }),
        }
    }

    /// Center of a cell in the frame, with the center of the first pixel at 0.
    pub fn point(&self, [column, row]: [i64; 2]) -> (f64, f64) {
        let place =
            |k: usize, i: i64| self.place.center[k] + offset(i as usize, self.side) * self.cell / STRIDE;
        (place(0, column), place(1, row))
    }
}
