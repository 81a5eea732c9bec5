//! polars frames to and from CSV and Parquet.

use super::column::Column;
use polars::prelude::*;
use polars_parquet::write::schema_to_metadata_key;
use std::io::Cursor;

/// A file with columns that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// polars refuses.
    #[error("table: {0}")]
    Polars(#[from] PolarsError),
    /// A column is missing.
    #[error("the column `{0}` is missing")]
    MissingColumn(&'static str),
    /// A column is there that the file does not have, or has only once.
    #[error("the column `{0}` does not belong here")]
    UnknownColumn(String),
    /// Text where a number belongs.
    #[error("column `{column}`: `{found}` is not a number")]
    Number {
        /// Name of the column.
        column: &'static str,
        /// The text.
        found: String,
    },
    /// A writer that does not keep to the declaration of its file, which is a bug.
    #[error("{0}: the columns are not the declared ones")]
    Undeclared(&'static str),
}

/// CSV with a header; floats are written so that reading gives the same bits, missing values are empty.
pub(super) fn to_csv(mut frame: DataFrame) -> Result<Vec<u8>, TableError> {
    let mut bytes = Vec::new();
    CsvWriter::new(&mut bytes).finish(&mut frame)?;
    Ok(bytes)
}

/// Parquet with zstd compression.
pub(super) fn to_parquet(mut frame: DataFrame) -> Result<Vec<u8>, TableError> {
    let mut bytes = Vec::new();
    parquet_writer(&mut bytes, frame.schema()).finish(&mut frame)?;
    Ok(bytes)
}

/// A writer of Parquet with zstd compression whose schema of Arrow types has texts as `large_string`. By itself polars says
/// `string_view`, which Arrow's own readers load but cannot compare, filter or sort.
fn parquet_writer<W: std::io::Write>(to: W, schema: &Schema) -> ParquetWriter<W> {
    let arrow = schema_to_metadata_key(&schema.to_arrow(CompatLevel::oldest()));
    let about = KeyValueMetadata::Static(vec![arrow]);
    let writer = ParquetWriter::new(to).with_compression(ParquetCompression::Zstd(None));
    writer.with_key_value_metadata(Some(about))
}

/// Writes Parquet with zstd compression from frames with the same columns, a row group each; nothing without a frame.
pub(super) fn parts_to_parquet<E: From<TableError>>(
    file: &mut dyn std::io::Write,
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

/// CSV of texts under headings, one row an array; empty texts are missing values.
///
/// # Errors
/// When a row has fewer fields than there are headings, or a heading stands twice.
pub fn texts_to_csv(headings: &[&str], rows: &[Vec<String>]) -> Result<Vec<u8>, TableError> {
    let field = |row: &Vec<String>, k: usize| row.get(k).filter(|text| !text.is_empty()).cloned();
    let values = |k: usize| rows.iter().map(|row| field(row, k)).collect::<Vec<_>>();
    let columns =
        headings.iter().enumerate().map(|(k, h)| polars::prelude::Column::new((*h).into(), values(k)));
    to_csv(DataFrame::new(rows.len(), columns.collect())?)
}

/// Headings and rows of a CSV file, every field as text.
///
/// # Errors
/// When the bytes are not a table.
pub fn texts_from_csv(bytes: Vec<u8>) -> Result<(Vec<String>, Vec<Vec<String>>), TableError> {
    let rows = Rows::from_csv(bytes)?;
    let headings: Vec<String> = rows.names().into_iter().map(str::to_string).collect();
    let text = |name: &String| rows.0.column(name)?.str();
    let columns = headings.iter().map(text).collect::<Result<Vec<_>, PolarsError>>()?;
    let field = |i: usize| columns.iter().map(move |c| c.get(i).unwrap_or_default().to_string());
    let all = (0..rows.len()).map(|i| field(i).collect()).collect();
    Ok((headings, all))
}

/// The rows of a file that was read. Fields of CSV files are texts until they are asked for as numbers.
pub(super) struct Rows(DataFrame);

impl Rows {
    /// A CSV file with every field as text.
    pub fn from_csv(bytes: Vec<u8>) -> Result<Self, TableError> {
        let options = CsvReadOptions::default().with_infer_schema_length(Some(0)).with_has_header(true);
        Ok(Self(options.into_reader_with_file_handle(Cursor::new(bytes)).finish()?))
    }

    /// A Parquet file with every field as text.
    pub fn from_parquet(bytes: Vec<u8>) -> Result<Self, TableError> {
        let frame = ParquetReader::new(Cursor::new(bytes)).finish()?;
        let text = |column: &polars::prelude::Column| match column.dtype() {
            // Texts from which the same bits are read.
            DataType::Float64 => {
                let texts = column.f64()?.iter().map(|v| v.map(|v| v.to_string()));
                let texts = StringChunked::from_iter(texts).with_name(column.name().clone());
                Ok(polars::prelude::Column::from(texts.into_series()))
            }
            _ => column.cast(&DataType::String),
        };
        let columns = frame.columns().iter().map(text).collect::<Result<_, _>>()?;
        Ok(Self(DataFrame::new(frame.height(), columns)?))
    }

    /// Gives `take` some columns of a Parquet file whose header passes a check, a row group at a time.
    pub fn each_part_of_parquet(
        bytes: Vec<u8>,
        check: impl Fn(Vec<&str>) -> Result<(), TableError>,
        columns: &[Column],
        mut take: impl FnMut(Self) -> Result<(), TableError>,
    ) -> Result<(), TableError> {
        let mut reader = ParquetReader::new(Cursor::new(&bytes));
        let header = reader.schema()?;
        check(header.iter_names().map(PlSmallStr::as_str).collect())?;
        let about = reader.get_metadata()?.clone();
        let is_there = |column: &&Column| !column.recent || header.contains(column.name);
        let names: Vec<String> = columns.iter().filter(is_there).map(|c| c.name.to_string()).collect();
        let mut from = 0;
        for rows in about.row_groups.iter().map(|group| group.num_rows()) {
            let mut reader = ParquetReader::new(Cursor::new(&bytes));
            reader.set_metadata(about.clone());
            let reader = reader.with_columns(Some(names.clone())).with_slice(Some((from, rows)));
            take(Self(reader.finish()?))?;
            from += rows;
        }
        Ok(())
    }

    /// The header.
    pub fn names(&self) -> Vec<&str> {
        self.0.get_column_names().into_iter().map(PlSmallStr::as_str).collect()
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.0.height()
    }

    /// The rows for which `keep` is true.
    pub fn filter(self, keep: Vec<bool>) -> Result<Self, TableError> {
        Ok(Self(self.0.filter(&BooleanChunked::from_iter(keep))?))
    }

    /// Texts; missing ones are empty.
    pub fn texts(&self, column: &Column) -> Result<Vec<&str>, TableError> {
        let values = self.0.column(column.name)?.str()?;
        Ok(values.iter().map(Option::unwrap_or_default).collect())
    }

    /// Floats; missing ones are NaN.
    pub fn reals(&self, column: &Column) -> Result<Vec<f64>, TableError> {
        let values = self.0.column(column.name)?.f64()?;
        Ok(values.iter().map(|v| v.unwrap_or(f64::NAN)).collect())
    }

    /// Integers of 64 bits; missing ones are 0.
    pub fn integers(&self, column: &Column) -> Result<Vec<i64>, TableError> {
        let values = self.0.column(column.name)?.i64()?;
        Ok(values.iter().map(Option::unwrap_or_default).collect())
    }

    /// Integers of 32 bits; missing ones are 0.
    pub fn small(&self, column: &Column) -> Result<Vec<i32>, TableError> {
        let values = self.0.column(column.name)?.i32()?;
        Ok(values.iter().map(Option::unwrap_or_default).collect())
    }

    /// The numbers of a CSV column; none where the field is empty, or where an early file lacks the column.
    pub fn numbers<T: std::str::FromStr>(&self, column: &Column) -> Result<Vec<Option<T>>, TableError> {
        if column.recent && !self.names().contains(&column.name) {
            return Ok((0..self.len()).map(|_| None).collect());
        }
        let read = |text: &str| match text {
            "" => Ok(None),
            text => text.parse().map(Some).map_err(|_| not_a_number(column, text)),
        };
        self.texts(column)?.into_iter().map(read).collect()
    }

    /// The numbers of a CSV column that must have one in every row.
    pub fn all_numbers<T: std::str::FromStr>(&self, column: &Column) -> Result<Vec<T>, TableError> {
        let numbers = self.numbers(column)?.into_iter();
        numbers.map(|number| number.ok_or_else(|| not_a_number(column, ""))).collect()
    }
}

fn not_a_number(column: &Column, found: &str) -> TableError {
    TableError::Number { column: column.name, found: found.to_string() }
}

#[cfg(test)]
mod tests {
    use super::super::column::TableFile;
    use super::*;

    const V: Column = Column::real("v", "", "A number");
    const FILE: TableFile = TableFile { name: "v", about: "", columns: &[V] };

    #[test]
    fn floats_survive_both_formats_bit_by_bit() {
        let values = [0.1 + 0.2, 1e-300, -0.0, 5e-324, 1.0 / 3.0, 123_456_789.123_456_78];
        let bits = |read: Vec<f64>| read.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        let frame = || FILE.frame(vec![V.of(values)]).unwrap();
        let csv = FILE.read_csv(to_csv(frame()).unwrap()).unwrap();
        assert_eq!(bits(csv.all_numbers(&V).unwrap()), values.map(f64::to_bits));
        let mut parquet = Vec::new();
        let take = |rows: Rows| {
            parquet.extend(rows.reals(&V)?);
            Ok(())
        };
        FILE.read_parquet_parts(to_parquet(frame()).unwrap(), &[V], take).unwrap();
        assert_eq!(bits(parquet), values.map(f64::to_bits));
    }

    // Arrow's readers go by these types: `large_string` can be filtered, `string_view` cannot.
    #[test]
    fn texts_of_parquet_are_large_strings() {
        const NAME: Column = Column::text("name", "A name");
        const NAMED: TableFile = TableFile { name: "named", about: "", columns: &[NAME, V] };
        let frame = || NAMED.frame(vec![NAME.of(["a", "b"]), V.of([1.0, 2.0])]).unwrap();
        let mut parts = Vec::new();
        parts_to_parquet(&mut parts, [Ok::<_, TableError>(frame()), Ok(frame())]).unwrap();
        let types = [("name", ArrowDataType::LargeUtf8), ("v", ArrowDataType::Float64)];
        let fields = types.map(|(name, kind)| ArrowField::new(name.into(), kind, true));
        let expected = schema_to_metadata_key(&fields.into_iter().map(|f| (f.name.clone(), f)).collect());
        for bytes in [to_parquet(frame()).unwrap(), parts] {
            let metadata = polars_parquet::read::read_metadata(&mut Cursor::new(&bytes)).unwrap();
            assert_eq!(metadata.key_value_metadata.as_deref().unwrap(), std::slice::from_ref(&expected));
            let mut names = Vec::new();
            let take = |rows: Rows| {
                names.extend(rows.texts(&NAME)?.into_iter().map(str::to_string));
                Ok(())
            };
            NAMED.read_parquet_parts(bytes, &[NAME], take).unwrap();
            assert_eq!(names[..2], ["a", "b"]);
        }
    }

    #[test]
    fn headers_have_the_declared_columns_and_no_others() {
        let refused = |csv: &str| FILE.read_csv(csv.as_bytes().to_vec()).err().unwrap().to_string();
        assert_eq!(refused("w\n1\n"), "the column `w` does not belong here");
        assert_eq!(refused("v,w\n1,2\n"), "the column `w` does not belong here");
        const TWO: TableFile = TableFile { columns: &[V, Column::real("w", "", "")], ..FILE };
        let lacking = TWO.read_csv(b"v\n1\n".to_vec()).err().unwrap().to_string();
        assert_eq!(lacking, "the column `w` is missing");
        const NEW: TableFile = TableFile { columns: &[V, Column::real("w", "", "").recent()], ..FILE };
        let rows = NEW.read_csv(b"v\n1\n".to_vec()).unwrap();
        assert_eq!(rows.numbers::<f64>(&NEW.columns[1]).unwrap(), [None]);
        let wrong = FILE.read_csv(b"v\nx\n".to_vec()).unwrap();
        assert_eq!(wrong.numbers::<f64>(&V).unwrap_err().to_string(), "column `v`: `x` is not a number");
        assert!(FILE.frame(vec![NEW.columns[1].of([1.0])]).is_err());
    }
}
