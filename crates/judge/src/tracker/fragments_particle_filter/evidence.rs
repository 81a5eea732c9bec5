//! Similarity of the fragments in a frame to those of the model.

use super::layout::Fragment;
use crate::image::Frame;
use crate::image::integral::{Counts, IntegralHistogram};

/// State of a particle: center x and y in pixels.
pub type Place = [f64; 2];

/// Bins of a histogram, 8 for each of red, green and blue.
const BINS: usize = 512;
/// The code of a pixel whose bin no fragment of the model has.
const NOWHERE: u16 = u16::MAX;
/// Maximum number of counts of an integral histogram: 128 MiB.
const MAX_COUNTS: usize = 1 << 25;

/// Histogram of a fragment in the first frame: nonempty bins with the roots of their shares.
type Model = Vec<(usize, f64)>;

/// Models of all fragments, and the frame that is compared with them.
#[derive(Debug, Clone)]
pub struct Evidence {
    fragments: Vec<Fragment>,
    models: Vec<Model>,
    /// For each bin of the histogram, its index among the model's bins.
    known: Vec<u16>,
    bins: usize,
    view: View,
}

/// Codes in the searched part of a frame.
#[derive(Debug, Clone, Default)]
struct View {
    left: i64,
    top: i64,
    width: usize,
    height: usize,
    codes: Vec<u16>,
    integral: IntegralHistogram,
    /// True if `integral` belongs to the current `codes`.
    summed: bool,
    counts: Vec<u32>,
}

impl Evidence {
    /// Learns the fragments of a target at `place` in its first frame.
    pub fn new(fragments: Vec<Fragment>, frame: &Frame, place: &Place) -> Self {
        let known = (0..BINS as u16).collect();
        let mut one = Self { fragments, models: Vec::new(), known, bins: BINS, view: View::default() };
        one.look(frame, std::slice::from_ref(place));
        let view = &mut one.view;
        let histogram = |fragment: &Fragment| {
            let (window, pixels) = view.window(fragment, place);
            view.count(window, BINS);
            (view.counts.clone(), f64::from(pixels.max(1)))
        };
        let histograms: Vec<(Vec<u32>, f64)> = one.fragments.iter().map(histogram).collect();
        one.known.fill(NOWHERE);
        one.bins = 0;
        for bin in 0..BINS {
            if histograms.iter().any(|(counts, _)| counts[bin] > 0) {
                one.known[bin] = one.bins as u16;
                one.bins += 1;
            }
        }
        for (counts, pixels) in &histograms {
            let filled = counts.iter().zip(&one.known).filter(|(count, _)| **count > 0);
            let root = |(&count, &bin): (&u32, &u16)| (usize::from(bin), (f64::from(count) / pixels).sqrt());
            one.models.push(filled.map(root).collect());
        }
        one
    }

    /// Number of fragments.
    pub fn len(&self) -> usize {
        self.fragments.len()
    }

    /// Prepares a frame for these places and those between them.
    pub fn look(&mut self, frame: &Frame, places: &[Place]) {
        let corners = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        let reach = self.fragments.iter().fold([0.0_f64; 2], |r, f| [r[0].max(f[2]), r[1].max(f[3])]);
        let (rx, ry) = (reach[0] + 2.0, reach[1] + 2.0);
        let [left, top, right, bottom] = places.iter().fold(corners, |b, &[x, y]| {
            [b[0].min(x - rx), b[1].min(y - ry), b[2].max(x + rx), b[3].max(y + ry)]
        });
        let within = |v: f64, room: usize| (v.max(0.0) as usize).min(room);
        let columns = within(left, frame.width())..within(right, frame.width());
        let rows = within(top, frame.height())..within(bottom, frame.height());
        let view = &mut self.view;
        (view.left, view.top) = (columns.start as i64, rows.start as i64);
        (view.width, view.height) = (columns.len(), rows.len());
        view.codes.clear();
        for y in rows {
            let pixels = frame.row(y)[3 * columns.start..3 * columns.end].as_chunks::<3>().0;
            view.codes.extend(pixels.iter().map(|&p| self.known[bin_of(p)]));
        }
        // Sums cost a few additions for every pixel and bin, direct counts one step for every pixel
        // of every fragment. Both are exact, so that the choice only affects the time.
        let summing = IntegralHistogram::room(view.width, view.height, self.bins);
        let area = |f: &Fragment| (f[2] - f[0] + 1.0) * (f[3] - f[1] + 1.0);
        let fragments: f64 = self.fragments.iter().map(area).sum();
        let counting = fragments * places.len() as f64;
        view.summed = summing <= MAX_COUNTS && summing as f64 <= 2.0 * counting;
        if view.summed {
            view.integral.build(&view.codes, view.width, self.bins);
        }
    }

    /// Bhattacharyya coefficient `sum_u sqrt(p_u q_u)` of each fragment at a place, in `[0, 1]`; 0 for a
    /// fragment without a pixel in the frame. The frame must be prepared for the place by [`Self::look`].
    pub fn likeness(&mut self, place: &Place, rho: &mut Vec<f64>) {
        rho.clear();
        for (fragment, model) in self.fragments.iter().zip(&self.models) {
            let (window, pixels) = self.view.window(fragment, place);
            let sum: f64 = if pixels == 0 {
                0.0
            } else if self.view.summed {
                compare(model, &self.view.integral.window(window))
            } else {
                self.view.count(window, self.bins);
                model.iter().map(|&(bin, q)| f64::from(self.view.counts[bin]).sqrt() * q).sum()
            };
            // Rounding may leave it just above 1.
            rho.push((sum / f64::from(pixels.max(1)).sqrt()).min(1.0));
        }
    }
}

fn compare(model: &Model, counts: &Counts<'_>) -> f64 {
    model.iter().map(|&(bin, q)| f64::from(counts.of(bin)).sqrt() * q).sum()
}

/// Bin of 8 x 8 x 8.
fn bin_of([r, g, b]: [u8; 3]) -> usize {
    usize::from(r >> 5) << 6 | usize::from(g >> 5) << 3 | usize::from(b >> 5)
}

impl View {
    /// The pixels of a fragment at a place, as columns and rows of the view, and their number: edges are
    /// rounded (halves up, so that whole shifts keep them), at least one pixel apart and cut to the frame.
    fn window(&self, fragment: &Fragment, &[x, y]: &Place) -> ([usize; 4], u32) {
        let span = |center: f64, from: f64, to: f64, start: i64, room: usize| {
            let edge = |e: f64| (center + e + 0.5).floor().clamp(-1e9, 1e9) as i64;
            let first = edge(from);
            let end = edge(to).max(first + 1);
            let cut = |v: i64| (v - start).clamp(0, room as i64) as usize;
            (cut(first), cut(end))
        };
        let (left, right) = span(x, fragment[0], fragment[2], self.left, self.width);
        let (top, bottom) = span(y, fragment[1], fragment[3], self.top, self.height);
        ([left, top, right, bottom], ((right - left) * (bottom - top)) as u32)
    }

    /// Counts the codes of a window pixel by pixel.
    fn count(&mut self, [left, top, right, bottom]: [usize; 4], bins: usize) {
        self.counts.clear();
        self.counts.resize(bins, 0);
        for y in top..bottom {
            for &code in &self.codes[y * self.width..][left..right] {
                if let Some(count) = self.counts.get_mut(usize::from(code)) {
                    *count += 1;
                }
            }
        }
    }
}
