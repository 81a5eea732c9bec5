//! `truth.parquet`: the ground truth of the sequences.

use super::column::{Column, FRAME, SEQUENCE, SUITE, TableFile};
use super::frame::{TableError, to_parquet};
use std::collections::BTreeMap;
use trackfail_core::region::Region;
use trackfail_engine::Outcome;

const NOT_ANNOTATED: &str = "the target is not annotated";

const fn corner(name: &'static str, meaning: &'static str) -> Column {
    Column::real(name, "pixels", meaning).empty(NOT_ANNOTATED)
}

const CORNERS: [Column; 8] = [
    corner(
        "x1",
        "Horizontal place of the first corner; a box begins with its upper left one, then goes clockwise",
    ),
    corner("y1", "Vertical place of the first corner"),
    corner("x2", "Horizontal place of the second corner"),
    corner("y2", "Vertical place of the second corner"),
    corner("x3", "Horizontal place of the third corner"),
    corner("y3", "Vertical place of the third corner"),
    corner("x4", "Horizontal place of the fourth corner"),
    corner("y4", "Vertical place of the fourth corner"),
];

/// The file.
pub const FILE: TableFile = TableFile {
    name: "truth.parquet",
    about: "One row for each frame of every sequence, sequences sorted by name: the corners of the ground truth.",
    columns: &[
        SUITE, SEQUENCE, FRAME, CORNERS[0], CORNERS[1], CORNERS[2], CORNERS[3], CORNERS[4], CORNERS[5],
        CORNERS[6], CORNERS[7],
    ],
};

/// Writes the file.
///
/// # Errors
/// When polars refuses.
pub(super) fn write(outcome: &Outcome<'_>) -> Result<Vec<u8>, TableError> {
    let mut sequences: Vec<_> = outcome.sequences.iter().collect();
    sequences.sort_by(|a, b| a.name.cmp(&b.name));
    let (mut name, mut number) = (Vec::new(), Vec::new());
    let mut corners: Vec<Vec<Option<f64>>> = vec![Vec::new(); CORNERS.len()];
    for sequence in sequences {
        for (t, region) in sequence.truth.iter().enumerate() {
            name.push(sequence.name.as_str());
            number.push(i64::from(sequence.number(t)));
            let points = region.as_ref().map(|r| match r.corners() {
                four if four.len() == 4 => four,
                _ => r.rect().corners().to_vec(),
            });
            for (k, column) in corners.iter_mut().enumerate() {
                let point = points.as_ref().map(|p| p[k / 2]);
                column.push(point.map(|p| if k % 2 == 0 { p.0 } else { p.1 }));
            }
        }
    }
    let mut columns =
        vec![SUITE.of(vec![outcome.suite.as_str(); name.len()]), SEQUENCE.of(name), FRAME.of(number)];
    columns.extend(CORNERS.iter().zip(corners).map(|(column, values)| column.of(values)));
    to_parquet(FILE.frame(columns)?)
}

/// The ground truth by sequence and frame number.
pub type Truth = BTreeMap<String, BTreeMap<i64, Region>>;

/// Reads the ground truth; frames without annotation are left out.
///
/// # Errors
/// When the bytes are not such a file.
pub(super) fn read(bytes: Vec<u8>) -> Result<Truth, TableError> {
    let mut truth = Truth::new();
    FILE.read_parquet_parts(bytes, &FILE.columns[1..], |rows| {
        let (sequence, number) = (rows.texts(&SEQUENCE)?, rows.integers(&FRAME)?);
        let corners = CORNERS.iter().map(|c| rows.reals(c)).collect::<Result<Vec<_>, _>>()?;
        let mut from = 0;
        for name in sequence.chunk_by(|a, b| a == b) {
            let of_sequence = truth.entry(name[0].to_string()).or_default();
            let region = |i: usize| {
                let numbers: [f64; CORNERS.len()] = std::array::from_fn(|k| corners[k][i]);
                Some((number[i], Region::from_numbers(&numbers).ok()?))
            };
            of_sequence.extend((from..from + name.len()).filter_map(region));
            from += name.len();
        }
        Ok(())
    })?;
    Ok(truth)
}
