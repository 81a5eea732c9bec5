//! The classifier: a weight for every code of every cell, learned from examples.

use super::codes::{COLORS, Codes, TONES};

/// Codes under the cells of one window.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Pattern {
    /// Color codes, one a cell.
    pub colors: Vec<u16>,
    /// Tone codes, one a cell.
    pub tones: Vec<u8>,
}

/// The target in a frame and windows that are not it.
#[derive(Debug, Clone)]
pub struct Example {
    /// The target's window.
    pub target: Pattern,
    /// Other windows and their losses `1 - IoU`.
    pub others: Vec<(Pattern, f32)>,
    /// Learning rate of each cell, from 0 to 1.
    pub mask: Vec<f32>,
}

/// Weights of all cells.
#[derive(Debug, Clone)]
pub struct Model {
    /// Color weights, [`COLORS`] a cell.
    pub colors: Vec<f32>,
    /// Weights of gray levels (even rows) and directions (odd rows), 16 each, 32 a cell.
    pub tones: Vec<f32>,
    /// Look-up tables: the weights that were not shrunk away, those of gray level and direction added up.
    lut_colors: Vec<f32>,
    lut_tones: Vec<f32>,
    sizes: Vec<u32>,
}

impl Model {
    /// All weights 0.
    pub fn new(cells: usize) -> Self {
        Self {
            colors: vec![0.0; COLORS * cells],
            tones: vec![0.0; 32 * cells],
            lut_colors: vec![0.0; COLORS * cells],
            lut_tones: vec![0.0; TONES * cells],
            sizes: Vec::new(),
        }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.tones.len() / 32
    }

    /// `w . phi` with all weights.
    pub fn score(&self, pattern: &Pattern) -> f32 {
        let cells = pattern.colors.iter().zip(&pattern.tones);
        let weights = self.colors.chunks_exact(COLORS).zip(self.tones.chunks_exact(32));
        let mut sum = 0.0;
        for ((&color, &tone), (colors, tones)) in cells.zip(weights) {
            let (gray, direction) = (usize::from(tone >> 4), usize::from(tone & 15));
            sum += colors[usize::from(color) % COLORS] + tones[gray] + tones[16 + direction];
        }
        sum
    }

    /// One passive-aggressive step on the constraint `w . (phi(target) - phi(other)) >= loss`: the smallest
    /// change, in the metric of the mask, that meets it, at most `most` times the difference. Gives the
    /// step's length.
    pub fn step(&mut self, target: &Pattern, (other, loss): &(Pattern, f32), mask: &[f32], most: f32) -> f32 {
        let short = loss - (self.score(target) - self.score(other));
        if short <= 0.0 {
            return 0.0;
        }
        // Every one-hot code that differs adds 1 on either side; features have length 1 / sqrt(3 cells).
        let unit = 1.0 / (3 * self.cells()) as f32;
        let mut length = 0.0;
        for (k, m) in mask.iter().enumerate() {
            let (a, b) = (target.tones[k], other.tones[k]);
            let differ = u8::from(target.colors[k] != other.colors[k])
                + u8::from(a >> 4 != b >> 4)
                + u8::from(a & 15 != b & 15);
            length += m * f32::from(2 * differ);
        }
        length *= unit;
        if length <= 0.0 {
            return 0.0;
        }
        let step = (short / length).min(most);
        for (pattern, sign) in [(target, step), (other, -step)] {
            for (k, m) in mask.iter().enumerate() {
                let change = sign * m * unit;
                self.colors[COLORS * k + usize::from(pattern.colors[k])] += change;
                self.tones[32 * k + usize::from(pattern.tones[k] >> 4)] += change;
                self.tones[32 * k + 16 + usize::from(pattern.tones[k] & 15)] += change;
            }
        }
        step
    }

    /// One step on the most violated constraint of an example. Gives the step's length.
    pub fn learn(&mut self, example: &Example, most: f32) -> f32 {
        let mut worst: Option<(f32, &(Pattern, f32))> = None;
        for other in &example.others {
            let v = other.1 + self.score(&other.0);
            if worst.is_none_or(|(w, _)| v > w) {
                worst = Some((v, other));
            }
        }
        worst.map_or(0.0, |(_, other)| self.step(&example.target, other, &example.mask, most))
    }

    /// Fills the tables that are looked up, without the share `shrink` of the weights nearest to 0 (of
    /// those that are not 0).
    pub fn tabulate(&mut self, shrink: f64) {
        // Bits of floats that are not negative are in the order of the floats.
        let mut limit = 0;
        if shrink > 0.0 {
            self.sizes.clear();
            let sizes = self.colors.iter().chain(&self.tones).map(|w| w.abs().to_bits());
            self.sizes.extend(sizes.filter(|s| *s > 0));
            let place = (shrink * self.sizes.len() as f64) as usize;
            if place < self.sizes.len() {
                limit = *self.sizes.select_nth_unstable(place).1;
            }
        }
        let kept = |w: f32| if w.abs().to_bits() >= limit { w } else { 0.0 };
        for (lut, w) in self.lut_colors.iter_mut().zip(&self.colors) {
            *lut = kept(*w);
        }
        for (lut, w) in self.lut_tones.chunks_exact_mut(TONES).zip(self.tones.chunks_exact(32)) {
            let directions: [f32; 16] = std::array::from_fn(|d| kept(w[16 + d]));
            for (row, gray) in lut.chunks_exact_mut(16).zip(w) {
                let gray = kept(*gray);
                row.iter_mut().zip(directions).for_each(|(l, d)| *l = gray + d);
            }
        }
    }

    /// Share of a cell in a window's score, by the tables.
    pub fn share(&self, cell: usize, color: u16, tone: u8) -> f32 {
        self.lut_colors[COLORS * cell + usize::from(color)] + self.lut_tones[TONES * cell + usize::from(tone)]
    }

    /// Scores of `side * side` windows by the tables, rows from the top: window `(dx, dy)` has its cells at
    /// `(columns[i] + dx, rows[j] + dy)` of the codes.
    pub fn scan(&self, codes: &Codes, columns: &[usize], rows: &[usize], side: usize, scores: &mut Vec<f32>) {
        scores.clear();
        scores.resize(side * side, 0.0);
        let colors = self.lut_colors.as_chunks::<COLORS>().0;
        let tones = self.lut_tones.as_chunks::<TONES>().0;
        let places = rows.iter().flat_map(|&y| columns.iter().map(move |&x| (x, y)));
        for ((x, y), (colors, tones)) in places.zip(colors.iter().zip(tones)) {
            for (dy, scores) in scores.chunks_exact_mut(side).enumerate() {
                let at = (y + dy) * codes.width + x;
                let line = codes.colors[at..][..side].iter().zip(&codes.tones[at..][..side]);
                for (score, (&color, &tone)) in scores.iter_mut().zip(line) {
                    *score += colors[usize::from(color) % COLORS] + tones[usize::from(tone)];
                }
            }
        }
    }
}
