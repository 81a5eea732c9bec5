//! `frame_pairs.csv`: how far two methods are apart frame by frame, all trackers together.
//!
//! ```text
//! d      = measure of one method - measure of the other
//! bounds = quantiles of d over bootstrap samples of sequences, in each of which both have the same sequences
//! ```
//!
//! Only methods without a grid are compared, and only those with results on the same tracks: a difference between
//! methods on different tracks would be one between the tracks. Measures are those of `frame_measures.csv`.

use super::column::{Column, METHOD, SUITE, TableFile};
use super::frame::{TableError, to_csv};
use super::frame_measures::{EVERY_TRACKER, Row};
use trackfail_methods::score::frames::bootstrap::interval;

const OTHER: Column = Column::text("other", "Name of the method that it is compared with");
const TRACKS: Column = Column::integer("tracks", "", "Number of the tracks that both were run on");

const NO_VALUE: &str = "one of the two has no value";
const NO_INTERVAL: &str = "there is no value, or there are fewer than three sequences";

/// The file.
pub const FILE: TableFile = TableFile {
    name: "frame_pairs.csv",
    about: "One row for each two methods with results on the same tracks, all trackers together, in experiments of the \
            leaderboard: differences of measures of frame_measures.csv, the first method less the other. Bounds are those of a \
            95 % bootstrap interval over sequences, with the same sequences for both. Runs of earlier versions have no such file.",
    columns: &[SUITE, METHOD, OTHER, TRACKS, AUROC[0], AUROC[1], AUROC[2], FOUND[0], FOUND[1], FOUND[2]],
};

const AUROC: [Column; 3] = [
    Column::real("auroc_difference", "", "Difference of `auroc`").empty(NO_VALUE),
    Column::real("auroc_difference_low", "", "Lower bound of `auroc_difference`").empty(NO_INTERVAL),
    Column::real("auroc_difference_high", "", "Upper bound of `auroc_difference`").empty(NO_INTERVAL),
];

const FOUND: [Column; 3] = [
    Column::real("found_at_5_difference", "", "Difference of `found_at_5`").empty(NO_VALUE),
    Column::real("found_at_5_difference_low", "", "Lower bound of `found_at_5_difference`")
        .empty(NO_INTERVAL),
    Column::real("found_at_5_difference_high", "", "Upper bound of `found_at_5_difference`")
        .empty(NO_INTERVAL),
];

/// A difference with its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Difference {
    /// The difference.
    pub value: Option<f64>,
    /// Its bounds.
    pub bounds: Option<(f64, f64)>,
}

impl Difference {
    fn between(values: [Option<f64>; 2], samples: [&[f64]; 2]) -> Self {
        let [one, other] = samples;
        let differences = one.iter().zip(other).map(|(a, b)| a - b).collect();
        let value = values[0].zip(values[1]).map(|(a, b)| a - b);
        Self { value, bounds: value.and(interval(differences)) }
    }

    fn numbers(self) -> [Option<f64>; 3] {
        [self.value, self.bounds.map(|b| b.0), self.bounds.map(|b| b.1)]
    }
}

/// Writes the file from the rows of `frame_measures.csv`.
///
/// # Errors
/// When polars refuses.
pub(super) fn write(suite: &str, rows: &[Row<'_>]) -> Result<Vec<u8>, TableError> {
    let all: Vec<&Row<'_>> = rows.iter().filter(|row| row.tracker == EVERY_TRACKER).collect();
    let points = |row: &&&Row<'_>| all.iter().filter(|r| r.first.method == row.first.method).count();
    let single: Vec<&Row<'_>> = all.iter().filter(|row| points(row) == 1).copied().collect();
    let mut pairs: Vec<(&Row<'_>, &Row<'_>)> = Vec::new();
    for (k, row) in single.iter().enumerate() {
        pairs.extend(
            single[k + 1..].iter().filter(|other| other.tracks == row.tracks).map(|other| (*row, *other)),
        );
    }
    let of = |name: fn(&Row<'_>) -> Option<f64>, samples: for<'r> fn(&'r Row<'_>) -> &'r [f64]| {
        let difference = |(a, b): &(&Row<'_>, &Row<'_>)| {
            Difference::between([name(a), name(b)], [samples(a), samples(b)]).numbers()
        };
        pairs.iter().map(difference).collect::<Vec<_>>()
    };
    let auroc = of(|row| row.measures.get("auroc"), |row| &row.sampled.auroc[..]);
    let found = of(|row| row.measures.get("found_at_5"), |row| &row.sampled.found_at_5[..]);
    let text = |f: fn(&(&Row<'_>, &Row<'_>)) -> String| pairs.iter().map(f).collect::<Vec<_>>();
    let mut columns = vec![
        SUITE.of(vec![suite; pairs.len()]),
        METHOD.of(text(|p| p.0.first.method.clone())),
        OTHER.of(text(|p| p.1.first.method.clone())),
        TRACKS.of(pairs.iter().map(|p| p.0.tracks.len() as i64).collect::<Vec<_>>()),
    ];
    for (names, numbers) in [(AUROC, auroc), (FOUND, found)] {
        for (k, column) in names.iter().enumerate() {
            columns.push(column.of(numbers.iter().map(|n| n[k]).collect::<Vec<_>>()));
        }
    }
    to_csv(FILE.frame(columns)?)
}

/// A pair of methods, and how far they are apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// The method.
    pub method: String,
    /// The other one.
    pub other: String,
    /// Difference of the AUROC.
    pub auroc: Difference,
    /// Difference of the share of losses found at 5 false alarms per 1000 good frames.
    pub found_at_5: Difference,
}

impl Pair {
    /// The pair the other way round.
    pub fn turned(&self) -> Self {
        let turn = |d: Difference| Difference {
            value: d.value.map(|v| -v),
            bounds: d.bounds.map(|(low, high)| (-high, -low)),
        };
        let (method, other) = (self.other.clone(), self.method.clone());
        Self { method, other, auroc: turn(self.auroc), found_at_5: turn(self.found_at_5) }
    }
}

/// Reads the file.
///
/// # Errors
/// When the columns are not those of the file, or a number is damaged.
pub fn read(bytes: Vec<u8>) -> Result<Vec<Pair>, TableError> {
    let rows = FILE.read_csv(bytes)?;
    let numbers = |columns: [Column; 3]| -> Result<Vec<Difference>, TableError> {
        let [value, low, high] = [&columns[0], &columns[1], &columns[2]].map(|column| rows.numbers(column));
        let bounds = low?.into_iter().zip(high?).map(|(low, high)| low.zip(high));
        Ok(value?.into_iter().zip(bounds).map(|(value, bounds)| Difference { value, bounds }).collect())
    };
    let (auroc, found) = (numbers(AUROC)?, numbers(FOUND)?);
    let names = rows.texts(&METHOD)?.into_iter().zip(rows.texts(&OTHER)?);
    let pair = |((method, other), (auroc, found_at_5)): ((&str, &str), (Difference, Difference))| Pair {
        method: method.to_string(),
        other: other.to_string(),
        auroc,
        found_at_5,
    };
    Ok(names.zip(auroc.into_iter().zip(found)).map(pair).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_engine::{Cell, CellError};
    use trackfail_methods::score::FrameMeasures;
    use trackfail_methods::score::frames::measures::Sampled;

    fn measures_of(auroc: f64) -> FrameMeasures {
        let mut measures = FrameMeasures::default();
        measures.set("auroc", Some(auroc));
        measures
    }

    fn row<'a>(cell: &'a Cell, auroc: [f64; 3], tracks: &[(usize, usize)]) -> Row<'a> {
        Row {
            tracker: EVERY_TRACKER.to_string(),
            first: cell,
            measures: measures_of(auroc[0]),
            sampled: Sampled { auroc: auroc[1..].to_vec(), found_at_5: vec![f64::NAN; 2] },
            tracks: tracks.to_vec(),
        }
    }

    // The samples of a are better than those of b by .25 and .75; both differ from c only on other tracks.
    #[test]
    fn only_methods_on_the_same_tracks_are_compared() {
        let cells = ["a", "b", "c"].map(|method| Cell {
            sequence: 0,
            tracker: "t".into(),
            run: 0,
            method: method.into(),
            params: String::new(),
            job: 0,
            signal: None,
            threshold: None,
            result: Err(CellError::Missing(String::new())),
        });
        let rows = [
            row(&cells[0], [0.75, 0.5, 1.0], &[(0, 0), (1, 0)]),
            row(&cells[1], [0.25, 0.25, 0.25], &[(0, 0), (1, 0)]),
            row(&cells[2], [0.25, 0.25, 0.25], &[(0, 0)]),
        ];
        let read = read(write("s", &rows).unwrap()).unwrap();
        let [pair] = read.as_slice() else { panic!("{read:?}") };
        assert_eq!((pair.method.as_str(), pair.other.as_str()), ("a", "b"));
        let (low, high) = pair.auroc.bounds.unwrap();
        assert!(
            pair.auroc.value == Some(0.5) && (0.25..0.27).contains(&low) && (0.73..=0.75).contains(&high)
        );
        assert_eq!(pair.found_at_5, Difference::default());
        let turned = pair.turned();
        assert_eq!((turned.auroc.value, turned.auroc.bounds), (Some(-0.5), Some((-high, -low))));
        assert_eq!(turned.turned(), *pair);
    }
}
