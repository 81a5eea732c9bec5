//! `frame_pairs.csv`: differences between two methods in measures by frame, all trackers together.
//!
//! ```text
//! d      = measure of one method - measure of the other
//! bounds = quantiles of d over bootstrap samples of sequences, in each of which both have the same sequences
//! ```
//!
//! Only methods without a grid are compared, and only if they have results on the same tracks; otherwise the
//! difference could come from the tracks. Measures are those of `frame_measures.csv`.

pub use super::files::Pair;

use super::frame_measures::{EVERY_TRACKER, Row};
use super::rows::{Column, Field, TableError, group, ungroup};
use polars::prelude::{Column as Values, DataFrame};
use trackfail_methods::score::frames::bootstrap::interval;

/// A difference with its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Difference {
    /// Difference of the measure; `None` if a method has no value.
    pub value: Option<f64>,
    /// Bounds of the difference.
    pub bounds: Option<(f64, f64)>,
}

impl Difference {
    /// Difference with both methods swapped.
    pub fn turned(self) -> Self {
        Self { value: self.value.map(|v| -v), bounds: self.bounds.map(|(low, high)| (-high, -low)) }
    }
}

impl<'a> Field<'a> for Difference {
    fn write(columns: &[Column], values: Vec<Self>) -> Vec<Values> {
        group(columns, &values, |d, k| [d.value, d.bounds.map(|b| b.0), d.bounds.map(|b| b.1)][k])
    }

    fn read(columns: &[Column], frame: &'a DataFrame) -> Result<Vec<Self>, TableError> {
        ungroup(columns, frame, |numbers| Self { value: numbers[0], bounds: numbers[1].zip(numbers[2]) })
    }
}

/// Rows of the file, from those of `frame_measures.csv`.
pub(super) fn rows(rows: &[Row<'_>]) -> Vec<Pair> {
    let all: Vec<&Row<'_>> = rows.iter().filter(|row| row.tracker == EVERY_TRACKER).collect();
    let points = |row: &&&Row<'_>| all.iter().filter(|r| r.first.method == row.first.method).count();
    let single: Vec<&Row<'_>> = all.iter().filter(|row| points(row) == 1).copied().collect();
    let mut pairs = Vec::new();
    for (k, a) in single.iter().enumerate() {
        for b in single[k + 1..].iter().filter(|other| other.tracks == a.tracks) {
            let difference = |name: &str, [of_a, of_b]: [&[f64]; 2]| {
                let value = a.measures.get(name).zip(b.measures.get(name)).map(|(a, b)| a - b);
                let samples = of_a.iter().zip(of_b).map(|(a, b)| a - b).collect();
                Difference { value, bounds: value.and(interval(samples)) }
            };
            pairs.push(Pair {
                method: a.first.method.clone(),
                other: b.first.method.clone(),
                tracks: a.tracks.len() as i64,
                auroc: difference("auroc", [&a.sampled.auroc[..], &b.sampled.auroc]),
                found_at_5: difference("found_at_5", [&a.sampled.found_at_5[..], &b.sampled.found_at_5]),
            });
        }
    }
    pairs
}

impl Pair {
    /// Pair with both methods swapped.
    pub fn turned(&self) -> Self {
        Self {
            method: self.other.clone(),
            other: self.method.clone(),
            tracks: self.tracks,
            auroc: self.auroc.turned(),
            found_at_5: self.found_at_5.turned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::rows::Rows;
    use trackfail_engine::{Cell, CellError};
    use trackfail_methods::score::FrameMeasures;
    use trackfail_methods::score::frames::measures::Sampled;

    fn row<'a>(cell: &'a Cell, auroc: [f64; 3], tracks: &[(usize, usize)]) -> Row<'a> {
        let mut measures = FrameMeasures::default();
        measures.set("auroc", Some(auroc[0]));
        let sampled = Sampled { auroc: auroc[1..].to_vec(), found_at_5: vec![f64::NAN; 2] };
        let tracker = EVERY_TRACKER.to_string();
        Row { tracker, first: cell, measures, sampled, tracks: tracks.to_vec() }
    }

    // The samples of a are better than those of b by .25 and .75; both differ from c only on other tracks.
    #[test]
    fn only_methods_on_the_same_tracks_are_compared() {
        let cells = ["a", "b", "c"].map(|method| {
            let [tracker, method, params] = ["t", method, ""].map(String::from);
            let (signal, threshold, result) = (None, None, Err(CellError::Missing(String::new())));
            Cell { sequence: 0, tracker, run: 0, method, params, job: 0, signal, threshold, result }
        });
        let rows = [
            row(&cells[0], [0.75, 0.5, 1.0], &[(0, 0), (1, 0)]),
            row(&cells[1], [0.25, 0.25, 0.25], &[(0, 0), (1, 0)]),
            row(&cells[2], [0.25, 0.25, 0.25], &[(0, 0)]),
        ];
        let frame = Pair::read(Pair::csv("s", super::rows(&rows)).unwrap()).unwrap();
        let read = Pair::rows(&frame).unwrap();
        let [pair] = read.as_slice() else { panic!("{read:?}") };
        assert_eq!((pair.method.as_str(), pair.other.as_str()), ("a", "b"));
        let (low, high) = pair.auroc.bounds.unwrap();
        assert_eq!(pair.auroc.value, Some(0.5));
        assert!((0.25..0.27).contains(&low) && (0.73..=0.75).contains(&high));
        assert_eq!(pair.found_at_5, Difference::default());
        let turned = pair.turned();
        assert_eq!((turned.auroc.value, turned.auroc.bounds), (Some(-0.5), Some((-high, -low))));
        assert_eq!(turned.turned(), *pair);
    }
}
