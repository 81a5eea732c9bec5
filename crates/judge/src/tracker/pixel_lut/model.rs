//! The classifier: a weight for each code of each cell, learned from examples.

use super::codes::{COLORS, Codes, TONES};
use crate::tracker::first_largest;

/// Codes under the cells of one window.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// Color codes, one per cell.
    pub colors: Vec<u16>,
    /// Tone codes, one per cell.
    pub tones: Vec<u8>,
}

/// Training example: the target's window in a frame, and other windows.
#[derive(Debug, Clone)]
pub struct Example {
    /// Window of the target.
    pub target: Pattern,
    /// Other windows and their losses `1 - IoU`.
    pub others: Vec<(Pattern, f32)>,
    /// Learning rate of each cell, from 0 to 1.
    pub mask: Vec<f32>,
}

/// Weights of all cells.
#[derive(Debug, Clone)]
pub struct Model {
    /// Color weights, [`COLORS`] per cell.
    pub colors: Vec<f32>,
    /// Weights of gray levels (even rows) and directions (odd rows), 16 each, 32 per cell.
    pub tones: Vec<f32>,
    /// Look-up table of the tones: the weights of gray level and direction added up.
    lut_tones: Vec<f32>,
}

impl Model {
    /// Creates a model in which all weights are 0.
    pub fn new(cells: usize) -> Self {
        Self {
            colors: vec![0.0; COLORS * cells],
            tones: vec![0.0; 32 * cells],
            lut_tones: vec![0.0; TONES * cells],
        }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.tones.len() / 32
    }

    /// `w . phi`.
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
    /// change, in the metric of the mask, that meets the constraint, at most `most` times the difference.
    /// Returns the length of the step.
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

    /// One step on the most violated constraint of an example. Returns the length of the step.
    pub fn learn(&mut self, example: &Example, most: f32) -> f32 {
        let violations = example.others.iter().map(|(other, loss)| f64::from(loss + self.score(other)));
        let worst = example.others.get(first_largest(violations));
        worst.map_or(0.0, |other| self.step(&example.target, other, &example.mask, most))
    }

    /// Fills the table of the tones.
    pub fn tabulate(&mut self) {
        for (lut, w) in self.lut_tones.chunks_exact_mut(TONES).zip(self.tones.chunks_exact(32)) {
            let (grays, directions) = w.split_at(16);
            for (row, gray) in lut.chunks_exact_mut(16).zip(grays) {
                row.iter_mut().zip(directions).for_each(|(l, d)| *l = gray + d);
            }
        }
    }

    /// Scores of `side * side` windows, rows from the top: window `(dx, dy)` has its cells at `(columns[i] + dx,
    /// rows[j] + dy)` of the codes. The table of the tones must be filled.
    pub fn scan(&self, codes: &Codes, columns: &[usize], rows: &[usize], side: usize, scores: &mut Vec<f32>) {
        scores.clear();
        scores.resize(side * side, 0.0);
        let colors = self.colors.as_chunks::<COLORS>().0;
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
