//! polars frames to and from CSV and Parquet: the one place that knows the crate.

use polars::prelude::*;
use std::io::Cursor;

/// A frame that could not be made, written or read.
#[derive(Debug, thiserror::Error)]
#[error("table: {0}")]
pub struct FrameError(#[from] PolarsError);

impl FrameError {
    /// Text where a number belongs.
    pub fn number(found: &str) -> Self {
        Self(polars_err!(ComputeError: "`{}` is no number", found))
    }
}

/// A frame from its columns, which must have one length.
///
/// # Errors
/// When lengths differ.
pub fn frame(columns: Vec<Column>) -> Result<DataFrame, FrameError> {
    let height = columns.first().map_or(0, Column::len);
    Ok(DataFrame::new(height, columns)?)
}

/// CSV with a header; floats are written so that reading gives the same bits, missing values are empty.
///
/// # Errors
/// When polars refuses.
pub fn to_csv(frame: &mut DataFrame) -> Result<Vec<u8>, FrameError> {
    let mut bytes = Vec::new();
    CsvWriter::new(&mut bytes).finish(frame)?;
    Ok(bytes)
}

/// Parquet with zstd compression.
///
/// # Errors
/// When polars refuses.
pub fn to_parquet(frame: &mut DataFrame) -> Result<Vec<u8>, FrameError> {
    let mut bytes = Vec::new();
    ParquetWriter::new(&mut bytes).with_compression(ParquetCompression::Zstd(None)).finish(frame)?;
    Ok(bytes)
}

/// Parquet with zstd compression from frames with the same columns, a row group each; at least one.
///
/// # Errors
/// When polars refuses, or a part cannot be had.
pub fn parts_to_parquet<E: From<FrameError>>(
    parts: impl IntoIterator<Item = Result<DataFrame, E>>,
) -> Result<Vec<u8>, E> {
    let refused = |e: PolarsError| E::from(FrameError(e));
    let mut bytes = Vec::new();
    let mut parts = parts.into_iter();
    let Some(first) = parts.next().transpose()? else { return Ok(bytes) };
    let writer = ParquetWriter::new(&mut bytes).with_compression(ParquetCompression::Zstd(None));
    let mut writer = writer.batched(first.schema()).map_err(refused)?;
    for part in std::iter::once(Ok(first)).chain(parts) {
        writer.write_batch(&part?).map_err(refused)?;
    }
    writer.finish().map_err(refused)?;
    Ok(bytes)
}

/// The columns of a Parquet file.
///
/// # Errors
/// When the bytes are no Parquet file or lack a column.
pub fn from_parquet(bytes: Vec<u8>, columns: &[&str]) -> Result<DataFrame, FrameError> {
    let names = columns.iter().map(|c| c.to_string()).collect();
    Ok(ParquetReader::new(Cursor::new(bytes)).with_columns(Some(names)).finish()?)
}

/// A CSV file with every column as text.
///
/// # Errors
/// When the bytes are no table.
pub fn from_csv(bytes: Vec<u8>) -> Result<DataFrame, FrameError> {
    let options = CsvReadOptions::default().with_infer_schema_length(Some(0)).with_has_header(true);
    Ok(options.into_reader_with_file_handle(Cursor::new(bytes)).finish()?)
}

/// Headings and rows of a CSV file, every field as text.
///
/// # Errors
/// When the bytes are no table.
pub fn all_texts(bytes: Vec<u8>) -> Result<(Vec<String>, Vec<Vec<String>>), FrameError> {
    let table = from_csv(bytes)?;
    let headings: Vec<String> = table.get_column_names().iter().map(|n| n.to_string()).collect();
    let columns = headings.iter().map(|name| texts(&table, name)).collect::<Result<Vec<_>, _>>()?;
    let row = |i: usize| columns.iter().map(|c| c[i].clone()).collect();
    Ok((headings, (0..table.height()).map(row).collect()))
}

/// A text column's values; missing ones are empty.
///
/// # Errors
/// When the column is not there or no text.
pub fn texts(frame: &DataFrame, name: &str) -> Result<Vec<String>, FrameError> {
    let column = frame.column(name)?.str()?;
    Ok(column.iter().map(|v| v.unwrap_or_default().to_string()).collect())
}

/// A float column's values; missing ones are NaN.
///
/// # Errors
/// When the column is not there or no floats.
pub fn floats(frame: &DataFrame, name: &str) -> Result<Vec<f64>, FrameError> {
    let column = frame.column(name)?.f64()?;
    Ok(column.iter().map(|v| v.unwrap_or(f64::NAN)).collect())
}

/// An integer column's values.
///
/// # Errors
/// When the column is not there, no 64-bit integers, or has missing values.
pub fn integers(frame: &DataFrame, name: &str) -> Result<Vec<i64>, FrameError> {
    let column = frame.column(name)?.i64()?;
    Ok(column.iter().map(|v| v.unwrap_or_default()).collect())
}

/// A column of 32-bit integers.
///
/// # Errors
/// When the column is not there, no 32-bit integers, or has missing values.
pub fn small_integers(frame: &DataFrame, name: &str) -> Result<Vec<i32>, FrameError> {
    let column = frame.column(name)?.i32()?;
    Ok(column.iter().map(|v| v.unwrap_or_default()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_survive_both_formats_bit_by_bit() {
        let values = [0.1 + 0.2, 1e-300, -0.0, 5e-324, 1.0 / 3.0, 123_456_789.123_456_78];
        let make = || frame(vec![Column::new("v".into(), values)]).unwrap();
        let csv = String::from_utf8(to_csv(&mut make()).unwrap()).unwrap();
        let read: Vec<f64> = csv.lines().skip(1).map(|l| l.parse().unwrap()).collect();
        assert_eq!(read.iter().map(|v| v.to_bits()).collect::<Vec<_>>(), values.map(f64::to_bits));
        let parquet = from_parquet(to_parquet(&mut make()).unwrap(), &["v"]).unwrap();
        assert_eq!(floats(&parquet, "v").unwrap().map_bits(), values.map(f64::to_bits));
    }

    trait MapBits {
        fn map_bits(&self) -> Vec<u64>;
    }

    impl MapBits for Vec<f64> {
        fn map_bits(&self) -> Vec<u64> {
            self.iter().map(|v| v.to_bits()).collect()
        }
    }
}
