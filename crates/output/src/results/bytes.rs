//! CSV and Parquet of data frames.

use super::rows::TableError;
use polars::prelude::{Column as Values, *};
use polars_parquet::write::schema_to_metadata_key;
use std::io::{Cursor, Write};

/// CSV with a header. Floats are written so that reading gives the same bits; missing values are empty.
pub(super) fn to_csv(mut frame: DataFrame) -> Result<Vec<u8>, TableError> {
    let mut bytes = Vec::new();
    CsvWriter::new(&mut bytes).finish(&mut frame)?;
    Ok(bytes)
}

/// Reads a CSV file with all fields as text.
pub(super) fn from_csv(bytes: Vec<u8>) -> Result<DataFrame, TableError> {
    let options = CsvReadOptions::default().with_infer_schema_length(Some(0)).with_has_header(true);
    Ok(options.into_reader_with_file_handle(Cursor::new(bytes)).finish()?)
}

/// Parquet with zstd compression.
pub(super) fn to_parquet(mut frame: DataFrame) -> Result<Vec<u8>, TableError> {
    let mut bytes = Vec::new();
    parquet_writer(&mut bytes, frame.schema()).finish(&mut frame)?;
    Ok(bytes)
}

/// Writer of Parquet with zstd compression whose Arrow schema has texts as `large_string`. The default of
/// polars is `string_view`, which Arrow's own readers load but cannot compare, filter or sort.
fn parquet_writer<W: Write>(to: W, schema: &Schema) -> ParquetWriter<W> {
    let arrow = schema_to_metadata_key(&schema.to_arrow(CompatLevel::oldest()));
    let about = KeyValueMetadata::Static(vec![arrow]);
    let writer = ParquetWriter::new(to).with_compression(ParquetCompression::Zstd(None));
    writer.with_key_value_metadata(Some(about))
}

/// Writes frames with the same columns as Parquet with zstd compression, one row group each. Writes nothing
/// without frames.
pub(super) fn parts_to_parquet<E: From<TableError>>(
    file: &mut dyn Write,
    parts: impl IntoIterator<Item = Result<DataFrame, E>>,
) -> Result<(), E> {
    let refused = |e: PolarsError| E::from(TableError::Polars(e));
    let mut parts = parts.into_iter();
    let Some(first) = parts.next().transpose()? else { return Ok(()) };
    let mut writer = parquet_writer(file, first.schema()).batched(first.schema()).map_err(refused)?;
    for part in std::iter::once(Ok(first)).chain(parts) {
        writer.write_batch(&part?).map_err(refused)?;
    }
    writer.finish().map_err(refused)?;
    Ok(())
}

/// CSV of texts under headings, one row per array. Empty texts are missing values.
///
/// # Errors
/// When a row has fewer fields than there are headings, or a heading occurs twice.
pub fn texts_to_csv(headings: &[&str], rows: &[Vec<String>]) -> Result<Vec<u8>, TableError> {
    let field = |row: &Vec<String>, k: usize| row.get(k).filter(|text| !text.is_empty()).cloned();
    let values = |k: usize| rows.iter().map(|row| field(row, k)).collect::<Vec<_>>();
    let columns = headings.iter().enumerate().map(|(k, h)| Values::new((*h).into(), values(k)));
    to_csv(DataFrame::new(rows.len(), columns.collect())?)
}

/// Headings and rows of a CSV file, with all fields as text.
///
/// # Errors
/// When the bytes are not a table.
pub fn texts_from_csv(bytes: Vec<u8>) -> Result<(Vec<String>, Vec<Vec<String>>), TableError> {
    let frame = from_csv(bytes)?;
    let headings = frame.get_column_names().into_iter().map(PlSmallStr::to_string).collect();
    let columns = frame.columns().iter().map(Values::str).collect::<Result<Vec<_>, PolarsError>>()?;
    let field = |i: usize| columns.iter().map(move |c| c.get(i).unwrap_or_default().to_string());
    let all = (0..frame.height()).map(|i| field(i).collect()).collect();
    Ok((headings, all))
}
