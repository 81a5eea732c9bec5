//! `tables/*.csv` and `tables/*.parquet`: the tables of an experiment, cell by cell, for programs.

pub use super::files::TableRow;

use super::rows::{Rows, TableError};

/// The folder of the tables.
pub const FOLDER: &str = "tables";

/// The table as CSV. Fields are written as they are, for programs; names that a spreadsheet would take for a formula
/// (they begin with `=`, `+`, `-` or `@`) are refused where experiments are read.
///
/// # Errors
/// When polars refuses.
pub fn csv(rows: &[TableRow<'_>], data: &str) -> Result<Vec<u8>, TableError> {
    TableRow::csv(data, rows.iter().cloned())
}

/// The table as Parquet.
///
/// # Errors
/// When polars refuses.
pub fn parquet(rows: &[TableRow<'_>], data: &str) -> Result<Vec<u8>, TableError> {
    TableRow::parquet(data, rows.iter().cloned())
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
        let read = TableRow::read(bytes).unwrap();
        assert_eq!(TableRow::rows(&read).unwrap(), rows);
        let none = TableRow::read(parquet(&[], "").unwrap()).unwrap();
        assert!(TableRow::rows(&none).unwrap().is_empty());
    }
}
