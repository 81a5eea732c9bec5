//! `tables/*.csv` and `tables/*.parquet`: the tables of an experiment, cell by cell, for programs.

use super::cells::some_text;
use super::column::{Column, TableFile};
use super::frame::{self, TableError};
use polars::prelude::DataFrame;

/// The folder of the tables.
pub const FOLDER: &str = "tables";

const GROUP: Column =
    Column::text("group", "Name of the rows' group: a tracker, an attribute, or what the rows are of")
        .empty("the table has one group only");
const PUBLISHED_TRACKER: Column =
    Column::text("published_tracker", "Tracker whose published numbers stand beside ours")
        .empty("nothing is published");
const ROW: Column =
    Column::text("row", "Label of the row: a metric, method or grid value").empty("it has none");
const COLUMN: Column = Column::text("column", "Heading of the column").empty("it has none");
const OURS: Column = Column::real("ours", "", "Our number with all its digits").empty("there is none");
const PUBLISHED: Column = Column::text("published", "The published number as printed").empty("there is none");
const DIFFERENCE: Column = Column::text("difference", "Ours minus published, both rounded as printed")
    .empty("one of them is missing");
const DATA: Column = Column::text("data", "What all numbers rest on: `12 of 21 targets`");

/// Both files of a table.
pub const FILE: TableFile = TableFile {
    name: "tables/<table>.csv, tables/<table>.parquet",
    about: "One row for each cell of a table of the experiment, as CSV and as Parquet.",
    columns: &[GROUP, PUBLISHED_TRACKER, ROW, COLUMN, OURS, PUBLISHED, DIFFERENCE, DATA],
};

/// One cell of a table.
pub struct TableRow<'a> {
    /// Name of its group; may be empty.
    pub group: &'a str,
    /// Tracker whose published numbers stand beside ours.
    pub published_tracker: Option<&'a str>,
    /// Label of its row; may be empty.
    pub row: &'a str,
    /// Heading of its column; may be empty.
    pub column: &'a str,
    /// Our number.
    pub ours: Option<f64>,
    /// The published number as printed.
    pub published: Option<&'a str>,
    /// Ours minus published as printed.
    pub difference: Option<&'a str>,
}

/// The table as CSV. Fields are written as they are, for programs; names that a spreadsheet would take for a formula
/// (they begin with `=`, `+`, `-` or `@`) are refused where experiments are read.
///
/// # Errors
/// When polars refuses.
pub fn csv(rows: &[TableRow<'_>], data: &str) -> Result<Vec<u8>, TableError> {
    frame::to_csv(frame(rows, data)?)
}

/// The table as Parquet.
///
/// # Errors
/// When polars refuses.
pub fn parquet(rows: &[TableRow<'_>], data: &str) -> Result<Vec<u8>, TableError> {
    frame::to_parquet(frame(rows, data)?)
}

fn frame(rows: &[TableRow<'_>], data: &str) -> Result<DataFrame, TableError> {
    FILE.frame(vec![
        GROUP.of(rows.iter().map(|r| some_text(r.group)).collect::<Vec<_>>()),
        PUBLISHED_TRACKER.of(rows.iter().map(|r| r.published_tracker).collect::<Vec<_>>()),
        ROW.of(rows.iter().map(|r| some_text(r.row)).collect::<Vec<_>>()),
        COLUMN.of(rows.iter().map(|r| some_text(r.column)).collect::<Vec<_>>()),
        OURS.of(rows.iter().map(|r| r.ours).collect::<Vec<_>>()),
        PUBLISHED.of(rows.iter().map(|r| r.published).collect::<Vec<_>>()),
        DIFFERENCE.of(rows.iter().map(|r| r.difference).collect::<Vec<_>>()),
        DATA.of(vec![data; rows.len()]),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_files_have_the_same_columns_and_empty_fields_where_nothing_is() {
        let row = |published| TableRow {
            group: "",
            published_tracker: None,
            row: "precision",
            column: "DT|EF",
            ours: Some(0.12),
            published,
            difference: None,
        };
        let rows = [row(Some(".110")), row(None)];
        let text = String::from_utf8(csv(&rows, "12 of 21 targets").unwrap()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "group,published_tracker,row,column,ours,published,difference,data");
        assert_eq!(lines[1], ",,precision,DT|EF,0.12,.110,,12 of 21 targets");
        assert_eq!(lines[2], ",,precision,DT|EF,0.12,,,12 of 21 targets");
        let bytes = parquet(&rows, "").unwrap();
        assert_eq!(bytes, parquet(&rows, "").unwrap());
        let read = |bytes| {
            let (mut ours, mut published) = (Vec::new(), Vec::new());
            let take = |rows: frame::Rows| {
                ours.extend(rows.reals(&OURS)?);
                published.extend(rows.texts(&PUBLISHED)?.into_iter().map(str::to_string));
                Ok(())
            };
            FILE.read_parquet_parts(bytes, FILE.columns, take).unwrap();
            (ours, published)
        };
        assert_eq!(read(bytes), (vec![0.12, 0.12], vec![".110".to_string(), String::new()]));
        assert_eq!(read(parquet(&[], "").unwrap()), (vec![], vec![]));
    }
}
