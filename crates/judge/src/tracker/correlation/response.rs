//! Response maps of correlation filters: as numbers, and read as a density of the target's place.
//!
//! A map `F` has `n = w h` cells and wraps around at its borders, as the filter's shifts do; so do all windows around
//! its peak, the highest value, in cell `p`. `d = c - p` is the place of cell `c` relative to the peak, wrapped to
//! `-w/2 ... w/2` by `-h/2 ... h/2`; a cell exactly opposite counts half on either side. A map of places in a search
//! region ends at its borders instead, and windows are cut off there.
//!
//! ```text
//! sidelobe          cells with |dx| > 5 or |dy| > 5
//! narrow sidelobe   cells with |dx| > round(w / 20) or |dy| > round(h / 20)
//! second peak       largest value of the cells with |dx| > round(b w / 2) or |dy| > round(b h / 2)
//! density           q(c) = max(0, F(c) - mean - k s)         mean and s, the deviation, are those of the whole map
//! moments           m = z + a sum q d / sum q,      C = a^2 (sum q d d' / sum q - (sum q d / sum q)(sum q d / sum q)')
//!                   effective samples (sum q)^2 / sum q^2,  entropy -sum p ln p / ln n,  p = q / sum q
//! ```
//!
//! `z` is the center of the region that the tracker answers, `a` the side of a cell in pixels of the frame,
//! `b` is `neighborhood` and `k` is `threshold`. Deviations are of all cells, without a correction for their
//! number. If a map has no contrast, or no value above the threshold, the density is uniform. If the sidelobe
//! has no cell (maps of small targets are less than 11 cells wide), the whole map is used.
//!
//! Sources: 11 x 11 cells, Bolme et al., CVPR 2010; 5 % of the sides each way, the code of FuCoLoT (Lukezic et al.,
//! ACCV 2018); the box of the second peak, ATOM (Danelljan et al., CVPR 2019) and its successors, whose box has 2.2
//! times the target's sides on a map over 5 times its sides. The windows of the trackers here are 2 and 2.5 times the
//! target, in which such a box would leave little or nothing; so the share of the map's sides is kept, 2.2 / 5 = 0.44.
//!
//! The density is a choice: a filter is trained to answer a bell around the target and 0 elsewhere, so its response
//! has the form of a density already, and what is subtracted is the rest that every cell has. With `threshold = 0`
//! half of that rest stays, and its share of the mass grows with the area of the map.

use super::{Peak, signed};
use crate::plugin;
use crate::tracker::{Moments, Response, TrackerState, first_largest};
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;
use std::ops::Range;

/// Options for reading a response map.
#[derive(Debug, Clone, Copy, PartialEq, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MapOptions {
    /// Side of the box around the peak that excludes second peaks, as a share of the map's side, from 0 to 1.
    #[default(0.44)]
    pub neighborhood: f64,
    /// Number of standard deviations above the mean from which on a value counts as density, from 0 to 10.
    #[default(1.0)]
    pub threshold: f64,
}

impl MapOptions {
    /// Range of `neighborhood` as a parameter of a tracker.
    pub const NEIGHBORHOOD: plugin::Range = plugin::Range::within("response.neighborhood", 0.0, 1.0);

    /// Range of `threshold` as a parameter of a tracker.
    pub const THRESHOLD: plugin::Range = plugin::Range::within("response.threshold", 0.0, 10.0);
}

/// A response map.
#[derive(Debug, Clone)]
pub struct ResponseMap {
    values: Vec<f32>,
    width: usize,
    /// True if the last column and row are neighbors of the first.
    wraps: bool,
    peak: Peak,
    /// Side of a cell in pixels of the frame.
    cell: f64,
}

impl ResponseMap {
    /// Map of zeros that wraps around.
    pub fn new(width: usize, height: usize) -> Self {
        Self { values: vec![0.0; width * height], width, wraps: true, peak: Peak::default(), cell: 0.0 }
    }

    /// Map with borders. The peak is the first of the largest values.
    pub fn with_borders(values: Vec<f32>, width: usize, cell: f64) -> Self {
        let at = first_largest(values.iter().map(|v| f64::from(*v)));
        let peak = Peak { value: values[at], x: (at % width) as i64, y: (at / width) as i64 };
        Self { values, width, wraps: false, peak, cell }
    }

    /// Column and row of the peak.
    pub fn place(&self) -> [i64; 2] {
        [self.peak.x, self.peak.y]
    }

    /// Takes the values of a plane of the same size, and puts the old values into the plane.
    pub fn take(&mut self, plane: &mut Vec<f32>, peak: Peak, cell: f64) {
        std::mem::swap(&mut self.values, plane);
        (self.peak, self.cell) = (peak, cell);
    }

    /// Sets all responses to zero. Used when the patch has no contrast.
    pub fn clear(&mut self, cell: f64) {
        self.values.fill(0.0);
        (self.peak, self.cell) = (Peak::default(), cell);
    }

    /// Adds the numbers and the density of this map to a tracker's answer, whose center is the place of the
    /// peak.
    pub fn describe(&self, options: &MapOptions, state: TrackerState) -> TrackerState {
        let center = state.region.bounds().center();
        self.describe_around(center, options, state)
    }

    /// Adds the numbers and the density of this map, whose peak is at `center` in the frame, to a tracker's
    /// answer.
    pub fn describe_around(
        &self,
        center: (f64, f64),
        options: &MapOptions,
        state: TrackerState,
    ) -> TrackerState {
        let response = self.numbers(options);
        let moments = self.moments(options, &response, center);
        TrackerState { response: Some(response), posterior: Some(moments), ..state }
    }

    /// Cells within a distance in columns and rows from the peak.
    fn around_peak(&self, reach: [usize; 2]) -> [Arc; 2] {
        let around = if self.wraps { Arc::around } else { Arc::within };
        std::array::from_fn(|k| around(self.place()[k], reach[k], self.sides()[k]))
    }

    /// Numbers of columns and rows.
    fn sides(&self) -> [usize; 2] {
        [self.width, self.values.len() / self.width]
    }

    fn numbers(&self, options: &MapOptions) -> Response {
        let n = self.values.len() as f64;
        let mean = sum(&self.values, |v| v) / n;
        let whole = Sums { count: n, ..Sums::of(&self.values, mean) };
        let sides = self.sides();
        let sidelobe = |reach: [usize; 2]| whole.without(&self.sums_around_peak(reach, mean)).spread(mean);
        let (sidelobe_mean, sidelobe_deviation) = sidelobe([5, 5]);
        let (narrow_sidelobe_mean, narrow_sidelobe_deviation) =
            sidelobe(sides.map(|n| (0.05 * n as f64).round() as usize));
        let lowest = extreme(&self.values, f32::INFINITY, |a, b| b < a);
        Response {
            peak: f64::from(self.peak.value),
            second_peak: f64::from(self.second_peak(options.neighborhood).unwrap_or(lowest)),
            lowest: f64::from(lowest),
            mean,
            deviation: whole.spread(mean).1,
            sidelobe_mean,
            sidelobe_deviation,
            narrow_sidelobe_mean,
            narrow_sidelobe_deviation,
        }
    }

    /// Sums over the cells within a distance in columns and rows from the peak.
    fn sums_around_peak(&self, reach: [usize; 2], mean: f64) -> Sums {
        let [columns, rows] = self.around_peak(reach);
        let mut sums = Sums::default();
        for y in rows.inside().into_iter().flatten() {
            let row = &self.values[y * self.width..][..self.width];
            columns.inside().into_iter().for_each(|part| sums.add(&Sums::of(&row[part], mean)));
        }
        sums
    }

    /// Largest value outside the box around the peak; `None` if the box covers the whole map.
    fn second_peak(&self, neighborhood: f64) -> Option<f32> {
        let reach = self.sides().map(|n| (0.5 * neighborhood * n as f64).round() as usize);
        let [columns, rows] = self.around_peak(reach);
        let beside = rows.inside().into_iter().flatten().flat_map(|y| {
            columns.outside().map(|part| y * self.width + part.start..y * self.width + part.end)
        });
        let others = rows.outside().map(|part| part.start * self.width..part.end * self.width);
        let parts = others.into_iter().chain(beside).filter(|part| !part.is_empty());
        let largest = |part: Range<usize>| extreme(&self.values[part], f32::NEG_INFINITY, |a, b| b > a);
        parts.map(largest).reduce(|a, b| if b > a { b } else { a })
    }

    /// Moments of the map as a density. `center` is the place of the peak in the frame.
    fn moments(&self, options: &MapOptions, response: &Response, center: (f64, f64)) -> Moments {
        let n = self.values.len() as f64;
        let threshold = response.mean + options.threshold * response.deviation;
        let uniform = response.deviation <= 0.0 || response.peak <= threshold;
        let [across, down] = [0, 1]
            .map(|k| offsets(self.place()[k], self.sides()[k], self.wraps).collect::<Vec<(f64, f64)>>());
        let (mut total, mut squares, mut logarithms) = (0.0, 0.0, 0.0);
        let (mut x, mut y, mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (row, (dy, dy2)) in self.values.chunks_exact(self.width).zip(&down) {
            let (mut row_total, mut row_x) = (0.0, 0.0);
            for (v, (dx, dx2)) in row.iter().zip(&across) {
                let q = if uniform { 1.0 } else { f64::from(*v) - threshold };
                if q > 0.0 {
                    row_total += q;
                    row_x += q * dx;
                    xx += q * dx2;
                    squares += q * q;
                    logarithms += q * q.ln();
                }
            }
            total += row_total;
            x += row_x;
            xy += row_x * dy;
            y += row_total * dy;
            yy += row_total * dy2;
        }
        let (x, y, area) = (x / total, y / total, self.cell * self.cell);
        let (xx, xy, yy) = (xx / total - x * x, xy / total - x * y, yy / total - y * y);
        let entropy = if n > 1.0 { (total.ln() - logarithms / total) / n.ln() } else { 1.0 };
        Moments {
            mean: vec![center.0 + self.cell * x, center.1 + self.cell * y],
            covariance: vec![area * xx.max(0.0), area * xy, area * xy, area * yy.max(0.0)],
            effective_samples: (total * total / squares).clamp(1.0, n),
            samples: n,
            entropy: entropy.clamp(0.0, 1.0),
            likelihood: response.peak,
            particles: Vec::new(),
        }
    }
}

/// Offsets of the cells `0..n` of a side from cell `at`, and their squares.
fn offsets(at: i64, n: usize, wraps: bool) -> impl Iterator<Item = (f64, f64)> {
    (0..n as i64).map(move |i| {
        if !wraps {
            let d = (i - at) as f64;
            return (d, d * d);
        }
        let d = signed((i - at).rem_euclid(n as i64) as usize, n) as f64;
        (if 2.0 * d.abs() == n as f64 { 0.0 } else { d }, d * d)
    })
}

/// Neighboring cells along a side, continuing at the start if the side wraps.
#[derive(Clone, Copy)]
struct Arc {
    start: usize,
    len: usize,
    side: usize,
}

impl Arc {
    /// Cells within `reach` of cell `at`, on a side that wraps.
    fn around(at: i64, reach: usize, side: usize) -> Self {
        let start = (at - reach as i64).rem_euclid(side as i64) as usize;
        Self { start, len: (2 * reach + 1).min(side), side }
    }

    /// Cells within `reach` of cell `at`, on a side with ends.
    fn within(at: i64, reach: usize, side: usize) -> Self {
        let start = (at - reach as i64).max(0) as usize;
        Self { start, len: (at as usize + reach + 1).min(side) - start, side }
    }

    /// Index ranges of the cells. The second range begins at 0.
    fn inside(&self) -> [Range<usize>; 2] {
        let first = self.len.min(self.side - self.start);
        [self.start..self.start + first, 0..self.len - first]
    }

    /// Index ranges of the other cells of the side.
    fn outside(&self) -> [Range<usize>; 2] {
        let start = (self.start + self.len) % self.side;
        Self { start, len: self.side - self.len, side: self.side }.inside()
    }
}

/// Number of values, and sums of their differences from the map's mean and of the squared differences.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    count: f64,
    differences: f64,
    squares: f64,
}

impl Sums {
    fn of(values: &[f32], mean: f64) -> Self {
        let differences = sum(values, |v| v - mean);
        Self { count: values.len() as f64, differences, squares: sum(values, |v| (v - mean) * (v - mean)) }
    }

    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.differences += other.differences;
        self.squares += other.squares;
    }

    /// Sums of the values that are not in `others`, or of all values if that leaves none.
    fn without(&self, others: &Self) -> Self {
        if others.count >= self.count {
            return *self;
        }
        Self {
            count: self.count - others.count,
            differences: self.differences - others.differences,
            squares: self.squares - others.squares,
        }
    }

    /// Mean and standard deviation of the values.
    fn spread(&self, mean: f64) -> (f64, f64) {
        let difference = self.differences / self.count;
        (mean + difference, (self.squares / self.count - difference * difference).max(0.0).sqrt())
    }
}

/// Number of sums that are accumulated side by side.
const LANES: usize = 8;

/// Sum of a function of each value, in a fixed order.
fn sum(values: &[f32], of: impl Fn(f64) -> f64) -> f64 {
    let mut lanes = [0.0; LANES];
    let (whole, rest) = values.as_chunks::<LANES>();
    for chunk in whole {
        lanes.iter_mut().zip(chunk).for_each(|(lane, v)| *lane += of(f64::from(*v)));
    }
    lanes.iter_mut().zip(rest).for_each(|(lane, v)| *lane += of(f64::from(*v)));
    lanes.iter().sum()
}

/// The `better` value among all, or `worst` if there are none.
fn extreme(values: &[f32], worst: f32, better: impl Fn(f32, f32) -> bool) -> f32 {
    let choose = |a: f32, b: f32| if better(a, b) { b } else { a };
    let (whole, rest) = values.as_chunks::<LANES>();
    let mut lanes = [worst; LANES];
    for chunk in whole {
        lanes.iter_mut().zip(chunk).for_each(|(lane, v)| *lane = choose(*lane, *v));
    }
    lanes.into_iter().chain(rest.iter().copied()).fold(worst, choose)
}

#[cfg(test)]
mod tests;
