//! Color histograms of ellipses: bins of colors, pixels of an ellipse, and the similarity of two histograms.
//!
//! The colors of a frame are converted to bin numbers once ([`Grid`]); an ellipse is then a sum over row
//! spans. Weights are integer multiples of 2^-36, so that sums do not depend on their order. Along a row, the
//! weight is a parabola in `x`, computed by two additions per pixel.

use crate::image::Frame;
use crate::num::integer;
use multiversion::multiversion;
use rand::{Rng, RngExt};
use std::ops::Range;

/// State of a particle: center x and y, half axes Hx and Hy in pixels, orientation in radians from the x axis
/// towards the y axis (clockwise on the screen, as y points down).
pub type Ellipse = [f64; 5];

/// Maximum number of bins per channel; [`Histogram`] has room for three such channels.
pub const MAX_BINS: u8 = 16;
const MAX_HISTOGRAM_BINS: usize = 4096;

/// Weight 1 of a pixel as an integer. Sums over 2^26 pixels, the largest frame, stay below 2^63.
const ONE: f64 = (1_u64 << 36) as f64;

/// Mapping of colors to bins, which are uniform on each channel, with the top edge closed.
///
/// RGB channels are in `[0, 255]`. HSV is hue, saturation and value in `[0, 1]`, hue 0 for grays, computed
/// in whole numbers and hence exact at the edges. Bin `(i, j, k)` has number `(i n1 + j) n2 + k`.
#[derive(Debug, Clone)]
pub struct Binning {
    hsv: bool,
    counts: [u32; 3],
    /// Contribution of each byte of each channel to the bin number.
    tables: [[u16; 256]; 3],
}

impl Binning {
    /// Creates a mapping with `counts` bins per channel, each from 1 to [`MAX_BINS`].
    pub fn new(hsv: bool, counts: [u8; 3]) -> Self {
        let counts = counts.map(|c| u32::from(c.clamp(1, MAX_BINS)));
        let strides = [counts[1] * counts[2], counts[2], 1];
        let table = |c: usize| {
            std::array::from_fn(|v| ((v as u32 * counts[c] / 255).min(counts[c] - 1) * strides[c]) as u16)
        };
        Self { hsv, counts, tables: [table(0), table(1), table(2)] }
    }

    /// Number of all bins.
    pub fn len(&self) -> usize {
        self.counts.iter().product::<u32>() as usize
    }

    /// Bin number of a color, below [`Binning::len`].
    pub fn bin(&self, rgb: [u8; 3]) -> u16 {
        if self.hsv { self.bin_of_hsv(rgb) } else { self.bin_of_rgb(rgb) }
    }

    fn bin_of_rgb(&self, [r, g, b]: [u8; 3]) -> u16 {
        self.tables[0][usize::from(r)] + self.tables[1][usize::from(g)] + self.tables[2][usize::from(b)]
    }

    fn bin_of_hsv(&self, [r, g, b]: [u8; 3]) -> u16 {
        let (top, low) = (r.max(g).max(b), r.min(g).min(b));
        let value = self.tables[2][usize::from(top)];
        if top == low {
            return value;
        }
        let span = u32::from(top - low);
        let saturation = (span * self.counts[1] / u32::from(top)).min(self.counts[1] - 1);
        let [r, g, b] = [r, g, b].map(u32::from);
        // Hue in sixths of the circle, times the span.
        let sixths = match u32::from(top) {
            t if t == r => (g + 6 * span - b) % (6 * span),
            t if t == g => 2 * span + b - r,
            _ => 4 * span + r - g,
        };
        let hue = sixths * self.counts[0] / (6 * span);
        (hue * self.counts[1] * self.counts[2] + saturation * self.counts[2]) as u16 + value
    }
}

/// Bin numbers of the pixels that ellipses may cover.
#[derive(Debug, Default)]
pub struct Grid {
    width: usize,
    height: usize,
    cells: Vec<u16>,
}

/// A grid is computed anew for each frame, so a clone is empty.
impl Clone for Grid {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Grid {
    /// Computes the bins of all pixels that the ellipses can cover. These include the pixels of their
    /// weighted mean, whose circle is inside the bounding box of their circles.
    pub fn look<'e>(
        &mut self,
        frame: &Frame,
        binning: &Binning,
        ellipses: impl IntoIterator<Item = &'e Ellipse>,
    ) {
        (self.width, self.height) = (frame.width(), frame.height());
        self.cells.resize(self.width * self.height, 0);
        let empty = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        let [left, top, right, bottom] = ellipses.into_iter().fold(empty, |b, &[x, y, hx, hy, _]| {
            let r = hx.max(hy);
            [b[0].min(x - r), b[1].min(y - r), b[2].max(x + r), b[3].max(y + r)]
        });
        // A pixel more on every side, for rounding; casts of negative numbers give 0.
        let columns = (left - 1.0) as usize..((right + 2.0) as usize).min(self.width);
        let rows = (top - 1.0) as usize..((bottom + 2.0) as usize).min(self.height);
        if columns.is_empty() {
            return;
        }
        for y in rows {
            let pixels = frame.row(y)[3 * columns.start..3 * columns.end].as_chunks::<3>().0;
            let cells = &mut self.cells[y * self.width..][columns.clone()];
            // The choice of space is made a row, not a pixel.
            if binning.hsv {
                cells.iter_mut().zip(pixels).for_each(|(c, &p)| *c = binning.bin_of_hsv(p));
            } else {
                cells.iter_mut().zip(pixels).for_each(|(c, &p)| *c = binning.bin_of_rgb(p));
            }
        }
    }
}

/// Shape of an ellipse for computations by row: `r^2 = a (dx - slope dy)^2 + per_row dy^2`.
struct Shape {
    center: (f64, f64),
    a: f64,
    slope: f64,
    per_row: f64,
    /// Half the height, and half the width in the row of the center.
    reach: (f64, f64),
    /// Second difference of the weights along a row.
    bend: i64,
    columns: f64,
}

impl Shape {
    fn new(&[cx, cy, hx, hy, theta]: &Ellipse, columns: usize) -> Self {
        let (sin, cos) = theta.sin_cos();
        let (u, v) = (hx.powi(2).recip(), hy.powi(2).recip());
        let a = cos * cos * u + sin * sin * v;
        let reach_y = a.sqrt() * hx * hy;
        Self {
            center: (cx, cy),
            a,
            slope: cos * sin * (v - u) / a,
            per_row: reach_y.powi(2).recip(),
            reach: (reach_y, a.sqrt().recip()),
            bend: (-2.0 * a * ONE).round() as i64,
            columns: columns as f64,
        }
    }

    /// Rows, of the first `height`, that have a pixel center inside.
    fn rows(&self, height: usize) -> Range<usize> {
        let (middle, reach) = (self.center.1, self.reach.0);
        (middle - reach + 0.5) as usize..((middle + reach - 0.5).ceil() as usize).min(height)
    }
}

/// Number of rows whose spans are computed together.
const ROWS: usize = 8;

/// For each row, the first column inside, the first column after the span, and the weight at the former with
/// its first difference.
struct Spans {
    start: [i64; ROWS],
    end: [i64; ROWS],
    weight: [i64; ROWS],
    step: [i64; ROWS],
}

/// Spans of the rows from `first` on.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn spans(shape: &Shape, first: usize) -> Spans {
    let &Shape { center: (cx, cy), a, slope, per_row, reach: (_, root), columns, .. } = shape;
    let mut spans = Spans { start: [0; ROWS], end: [0; ROWS], weight: [0; ROWS], step: [0; ROWS] };
    for row in 0..ROWS {
        let dy = (first + row) as f64 + 0.5 - cy;
        let peak = 1.0 - dy * dy * per_row;
        let (middle, reach) = (cx + slope * dy, peak.max(0.0).sqrt() * root);
        let start = (middle - reach + 0.5).max(0.0).min(columns).floor();
        let end = (middle + reach - 0.5).max(0.0).min(columns).ceil();
        spans.start[row] = integer(start);
        spans.end[row] = if peak > 0.0 { integer(end) } else { 0 };
        let dx = start + 0.5 - middle;
        spans.weight[row] = integer((ONE * (peak - a * dx * dx)).trunc());
        spans.step[row] = integer((ONE * a * (-2.0 * dx - 1.0)).trunc());
    }
    spans
}

/// Histogram during summation. Pixels at even and odd places of a row are summed separately: neighbors often
/// have the same bin, and an addition need not wait for the last one.
#[derive(Debug, Clone)]
pub struct Histogram {
    sums: Box<[[i64; 2]; MAX_HISTOGRAM_BINS]>,
    len: usize,
}

/// Reference histogram: numbers of the nonempty bins, with the square roots of their shares.
#[derive(Debug, Clone)]
pub struct Model(Vec<(u16, f64)>);

impl Model {
    /// Creates a model from shares that sum to 1, or are all 0.
    pub fn new(shares: &[f64]) -> Self {
        Self((0..).zip(shares).filter(|(_, q)| **q > 0.0).map(|(u, q)| (u, q.sqrt())).collect())
    }
}

impl Histogram {
    /// An empty histogram of `len` bins.
    pub fn new(len: usize) -> Self {
        Self { sums: Box::new([[0; 2]; MAX_HISTOGRAM_BINS]), len: len.min(MAX_HISTOGRAM_BINS) }
    }

    /// Sums the kernel `1 - r^2` over the pixels whose center is inside the ellipse (`r < 1`). The grid must have
    /// been made for this ellipse.
    pub fn sum_inside(&mut self, grid: &Grid, ellipse: &Ellipse) {
        self.sums[..self.len].fill([0; 2]);
        let shape = Shape::new(ellipse, grid.width);
        let bend = shape.bend;
        let Range { start: top, end: bottom } = shape.rows(grid.height);
        for first in (top..bottom).step_by(ROWS) {
            let spans = spans(&shape, first);
            for (row, y) in (first..bottom.min(first + ROWS)).enumerate() {
                let (start, end) = (spans.start[row] as usize, spans.end[row] as usize);
                if start >= end {
                    continue;
                }
                let (mut weight, mut step) = (spans.weight[row], spans.step[row]);
                // Wrapping only spares the checks; see `ONE`.
                let (pairs, rest) = grid.cells[y * grid.width..][start..end].as_chunks::<2>();
                for &[even, odd] in pairs {
                    self.add(even, 0, weight);
                    self.add(odd, 1, weight.wrapping_add(step));
                    weight = weight.wrapping_add(2 * step).wrapping_add(bend);
                    step = step.wrapping_add(2 * bend);
                }
                for &bin in rest {
                    self.add(bin, 0, weight);
                }
            }
        }
    }

    /// Counts `points` random places in the ellipse, at radius U(0, 1) and angle U(0, 2 pi). Places outside
    /// the frame are dropped. Colors are interpolated bilinearly between pixel centers.
    pub fn sum_points(
        &mut self,
        frame: &Frame,
        binning: &Binning,
        &[cx, cy, hx, hy, theta]: &Ellipse,
        points: u32,
        rng: &mut impl Rng,
    ) {
        self.sums[..self.len].fill([0; 2]);
        let (sin, cos) = theta.sin_cos();
        for _ in 0..points {
            let (radius, turn) = (rng.random::<f64>(), rng.random::<f64>());
            let (t, s) = (std::f64::consts::TAU * turn).sin_cos();
            let (p, q) = (hx * radius * s, hy * radius * t);
            let (x, y) = (cx + cos * p - sin * q, cy + sin * p + cos * q);
            if x >= 0.0 && y >= 0.0 && x < frame.width() as f64 && y < frame.height() as f64 {
                let bin = binning.bin(interpolated(frame, x - 0.5, y - 0.5));
                self.add(bin, 0, 1);
            }
        }
    }

    /// Shares of the bins; all 0 if the histogram is empty.
    pub fn shares(&self) -> Vec<f64> {
        let total = self.total();
        let share = |s: &[i64; 2]| if total > 0 { value(s) / total as f64 } else { 0.0 };
        self.sums[..self.len].iter().map(share).collect()
    }

    /// Bhattacharyya coefficient `sum sqrt(p q)`, in `[0, 1]`: 1 for equal histograms, 0 if one is empty.
    pub fn likeness(&self, model: &Model) -> f64 {
        let total = self.total();
        if total <= 0 {
            return 0.0;
        }
        let root = |bin: u16| value(&self.sums[usize::from(bin) % MAX_HISTOGRAM_BINS]).sqrt();
        let sum: f64 = model.0.iter().map(|&(bin, q)| root(bin) * q).sum();
        (sum / (total as f64).sqrt()).min(1.0)
    }

    fn add(&mut self, bin: u16, place: usize, weight: i64) {
        let sum = &mut self.sums[usize::from(bin) % MAX_HISTOGRAM_BINS][place];
        *sum = sum.wrapping_add(weight);
    }

    fn total(&self) -> i64 {
        self.sums[..self.len].as_flattened().iter().sum()
    }
}

/// Sum of a bin. Rounding may have made the weight of a row's last pixel slightly negative, which is clamped.
fn value([even, odd]: &[i64; 2]) -> f64 {
    (even + odd).max(0) as f64
}

/// Color at `(x, y)`, measured from the center of the first pixel, rounded to bytes. Border pixels are
/// repeated.
fn interpolated(frame: &Frame, x: f64, y: f64) -> [u8; 3] {
    let (i, j) = (x.floor(), y.floor());
    let (fx, fy) = (x - i, y - j);
    let at = |di: i64, dj: i64| frame.pixel_clamped(i as i64 + di, j as i64 + dj);
    let corners = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
    std::array::from_fn(|c| {
        let [a, b, d, e] = corners.map(|p| f64::from(p[c]));
        let (upper, lower) = (a + (b - a) * fx, d + (e - d) * fx);
        (upper + (lower - upper) * fy + 0.5) as u8
    })
}
