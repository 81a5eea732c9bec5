//! Files with columns. `rows!` declares a file: its row, its columns, its writer and reader. Rows are converted to a
//! `DataFrame` of polars, which becomes CSV or Parquet; reading goes the other way.

use super::bytes::{from_csv, to_csv, to_parquet};
use polars::prelude::{Column as Values, *};
use std::io::Cursor;
use std::str::FromStr;

/// Reason why a file with columns cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// Polars cannot read or write the table.
    #[error("table: {0}")]
    Polars(#[from] PolarsError),
    /// A column is missing, is unknown, occurs twice, or has a text where a number belongs; the text says which one.
    #[error("{0}")]
    Column(String),
}

impl TableError {
    /// Error for a text where a number belongs.
    pub(super) fn not_a_number(column: &str, found: impl std::fmt::Display) -> Self {
        Self::Column(format!("column `{column}`: `{found}` is not a number"))
    }
}

/// Type of a column's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// UTF-8 text.
    Text,
    /// Integer of 64 bits.
    Integer,
    /// Integer of 32 bits.
    Small,
    /// Floating-point number of 64 bits.
    Real,
}

impl Kind {
    /// The type in polars.
    pub(super) fn in_polars(self) -> DataType {
        match self {
            Self::Text => DataType::String,
            Self::Integer => DataType::Int64,
            Self::Small => DataType::Int32,
            Self::Real => DataType::Float64,
        }
    }
}

/// Declaration of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Name in the header of the file.
    pub name: &'static str,
    /// Type of the values.
    pub kind: Kind,
    /// True for texts of which an empty one is a missing value.
    pub is_optional: bool,
    /// True if files of earlier versions lack the column.
    pub recent: bool,
}

impl Column {
    /// The column, in which an empty text is a missing value.
    pub const fn optional(self) -> Self {
        Self { is_optional: true, ..self }
    }

    /// The column, marked as missing in files of earlier versions.
    pub const fn recent(self) -> Self {
        Self { recent: true, ..self }
    }

    /// Parses a column of texts as numbers; `None` for missing and empty texts.
    fn parse<T: FromStr>(&self, texts: &Values) -> Result<Vec<Option<T>>, TableError> {
        let number = |text: &str| text.parse::<T>().map_err(|_| TableError::not_a_number(self.name, text));
        let texts = texts.str()?.iter().map(|text| text.filter(|t| !t.is_empty()));
        texts.map(|text| text.map(number).transpose()).collect()
    }

    /// Column of a file with values of the declared type. If an early file lacks it, all values are missing.
    fn typed(&self, frame: &DataFrame) -> Result<Values, TableError> {
        let Ok(found) = frame.column(self.name) else {
            return Ok(Values::full_null(self.name.into(), frame.height(), &self.kind.in_polars()));
        };
        if *found.dtype() != DataType::String {
            return Ok(found.clone());
        }
        let name = || PlSmallStr::from(self.name);
        Ok(match self.kind {
            Kind::Text => found.clone(),
            Kind::Integer => Values::new(name(), self.parse::<i64>(found)?),
            Kind::Small => Values::new(name(), self.parse::<i32>(found)?),
            Kind::Real => Values::new(name(), self.parse::<f64>(found)?),
        })
    }
}

/// Column of texts.
pub(super) const fn text(name: &'static str) -> Column {
    Column { name, kind: Kind::Text, is_optional: false, recent: false }
}

/// Column of integers of 64 bits.
pub(super) const fn integer(name: &'static str) -> Column {
    Column { kind: Kind::Integer, ..text(name) }
}

/// Column of integers of 32 bits.
pub(super) const fn small(name: &'static str) -> Column {
    Column { kind: Kind::Small, ..text(name) }
}

/// Column of floating-point numbers.
pub(super) const fn real(name: &'static str) -> Column {
    Column { kind: Kind::Real, ..text(name) }
}

/// Name of a file in compact results, which store it as Parquet.
pub(super) fn packed(name: &str) -> String {
    name.replace(".csv", ".parquet")
}

/// Rows of a file, implemented by `rows!`.
pub(crate) trait Rows<'a>: Sized {
    /// Name of the file in the results folder.
    const NAME: &'static str;

    /// Columns of the file, in their order.
    fn columns() -> Vec<Column>;

    /// Converts rows to a frame; `same` is the text of columns that have one value.
    fn frame(same: &str, rows: impl IntoIterator<Item = Self>) -> Result<DataFrame, TableError>;

    /// Converts a frame from [`Rows::read`] or [`Rows::each_part`] to rows.
    fn rows(frame: &'a DataFrame) -> Result<Vec<Self>, TableError>;

    fn csv(same: &str, rows: impl IntoIterator<Item = Self>) -> Result<Vec<u8>, TableError> {
        to_csv(Self::frame(same, rows)?)
    }

    fn parquet(same: &str, rows: impl IntoIterator<Item = Self>) -> Result<Vec<u8>, TableError> {
        to_parquet(Self::frame(same, rows)?)
    }

    /// Reads a CSV or Parquet file. Its header must be the declared one.
    fn read(bytes: Vec<u8>) -> Result<DataFrame, TableError> {
        let is_parquet = bytes.starts_with(b"PAR1");
        let read =
            if is_parquet { ParquetReader::new(Cursor::new(bytes)).finish()? } else { from_csv(bytes)? };
        let columns = Self::columns();
        check(&columns, read.get_column_names().into_iter().map(PlSmallStr::as_str))?;
        typed(&columns, &read)
    }

    /// Passes a Parquet file to `take`, one row group at a time, without the first column, whose text is the
    /// same in all rows.
    fn each_part(
        bytes: Vec<u8>,
        mut take: impl FnMut(DataFrame) -> Result<(), TableError>,
    ) -> Result<(), TableError> {
        let mut reader = ParquetReader::new(Cursor::new(&bytes));
        let header = reader.schema()?;
        let columns = Self::columns();
        check(&columns, header.iter_names().map(PlSmallStr::as_str))?;
        let about = reader.get_metadata()?.clone();
        let there = columns[1..].iter().filter(|column| header.contains(column.name));
        let names: Vec<String> = there.map(|column| column.name.to_string()).collect();
        let mut from = 0;
        for rows in about.row_groups.iter().map(|group| group.num_rows()) {
            let mut reader = ParquetReader::new(Cursor::new(&bytes));
            reader.set_metadata(about.clone());
            let part = reader.with_columns(Some(names.clone())).with_slice(Some((from, rows))).finish()?;
            take(typed(&columns[1..], &part)?)?;
            from += rows;
        }
        Ok(())
    }
}

/// Columns of a frame, with values of the declared types.
fn typed(columns: &[Column], read: &DataFrame) -> Result<DataFrame, TableError> {
    let all = columns.iter().map(|column| column.typed(read)).collect::<Result<Vec<_>, _>>()?;
    Ok(DataFrame::new(read.height(), all)?)
}

/// Checks that a header has all columns that are not recent, and no unknown ones.
fn check<'n>(columns: &[Column], names: impl Iterator<Item = &'n str>) -> Result<(), TableError> {
    let mut lacking: Vec<&Column> = columns.iter().collect();
    for name in names {
        match lacking.iter().position(|c| c.name == name) {
            Some(k) => drop(lacking.remove(k)),
            None => return Err(TableError::Column(format!("the column `{name}` does not belong here"))),
        }
    }
    match lacking.into_iter().find(|c| !c.recent) {
        Some(column) => Err(TableError::Column(format!("the column `{}` is missing", column.name))),
        None => Ok(()),
    }
}

/// Columns that have the same text in all rows.
pub(super) fn same(columns: &[Column], text: &str, rows: usize) -> Vec<Values> {
    columns.iter().map(|column| Values::new(column.name.into(), vec![text; rows])).collect()
}

/// Declares files: for each, the struct of a row with the columns of each field. A column in brackets before
/// or after the fields has the same text in all rows and no field.
macro_rules! rows {
    ($(
        $(#[$about:meta])*
        $vis:vis struct $row:ident $(<$life:lifetime>)? in $file:literal, [$($first:expr)?] {
            $( $(#[$of:meta])* $field:ident: $kind:ty = $columns:expr, )*
        } [$($last:expr)?]
    )*) => {$(
        $(#[$about])*
        #[derive(Debug, Clone, Default, PartialEq)]
        $vis struct $row $(<$life>)? {
            $( $(#[$of])* pub $field: $kind, )*
        }

        impl<'a> $crate::results::rows::Rows<'a> for $row $(<$life>)? {
            const NAME: &'static str = $file;

            fn columns() -> Vec<$crate::results::rows::Column> {
                let mut columns = Vec::new();
                columns.extend_from_slice(&[$($first)?]);
                $( columns.extend_from_slice(&$columns); )*
                columns.extend_from_slice(&[$($last)?]);
                columns
            }

            fn frame(
                same: &str,
                rows: impl IntoIterator<Item = Self>,
            ) -> Result<polars::prelude::DataFrame, $crate::results::rows::TableError> {
                use $crate::results::rows::{Field, same as repeated};
                $( let mut $field: Vec<$kind> = Vec::new(); )*
                for row in rows {
                    $( $field.push(row.$field); )*
                }
                let height = [$($field.len()),*][0];
                let mut columns = repeated(&[$($first)?], same, height);
                $( columns.extend(<$kind as Field<'a>>::write(&$columns, $field)); )*
                columns.extend(repeated(&[$($last)?], same, height));
                Ok(polars::prelude::DataFrame::new(height, columns)?)
            }

            fn rows(
                frame: &'a polars::prelude::DataFrame,
            ) -> Result<Vec<Self>, $crate::results::rows::TableError> {
                let mut rows = vec![Self::default(); frame.height()];
                $(
                    let values = <$kind as $crate::results::rows::Field<'a>>::read(&$columns, frame)?;
                    rows.iter_mut().zip(values).for_each(|(row, value)| row.$field = value);
                )*
                Ok(rows)
            }
        }
    )*};
}
pub(super) use rows;

/// A field of a row: values of one or several columns.
pub(super) trait Field<'a>: Sized {
    /// Columns with the values of all rows.
    fn write(columns: &[Column], values: Vec<Self>) -> Vec<Values>;
    /// Values of all rows, from the columns of a data frame.
    fn read(columns: &[Column], frame: &'a DataFrame) -> Result<Vec<Self>, TableError>;
}

/// Writes a column of texts. If it is optional, an empty text is a missing value: in CSV an empty field and
/// not `""`.
fn write_texts<'v>(columns: &[Column], values: impl Iterator<Item = &'v str>) -> Vec<Values> {
    let name = columns[0].name.into();
    vec![match columns[0].is_optional {
        false => Values::new(name, values.collect::<Vec<_>>()),
        true => Values::new(name, values.map(|text| (!text.is_empty()).then_some(text)).collect::<Vec<_>>()),
    }]
}

macro_rules! texts {
    ($($text:ty, $to:expr, $from:expr;)*) => {$(
        impl<'a> Field<'a> for $text {
            fn write(columns: &[Column], values: Vec<Self>) -> Vec<Values> {
                write_texts(columns, values.iter().map($to))
            }

            fn read(columns: &[Column], frame: &'a DataFrame) -> Result<Vec<Self>, TableError> {
                let texts = frame.column(columns[0].name)?.str()?;
                Ok(texts.iter().map($from).collect())
            }
        }
    )*};
}
texts! {
    &'a str, |text| *text, Option::unwrap_or_default;
    Option<&'a str>, |text| text.unwrap_or_default(), |text| text.filter(|text| !text.is_empty());
    String, String::as_str, |text| text.unwrap_or_default().to_string();
}

macro_rules! numbers {
    ($($number:ident, $missing:expr;)*) => {$(
        impl<'a> Field<'a> for Option<$number> {
            fn write(columns: &[Column], values: Vec<Self>) -> Vec<Values> {
                vec![Values::new(columns[0].name.into(), values)]
            }

            fn read(columns: &[Column], frame: &'a DataFrame) -> Result<Vec<Self>, TableError> {
                Ok(frame.column(columns[0].name)?.$number()?.iter().collect())
            }
        }

        impl<'a> Field<'a> for $number {
            fn write(columns: &[Column], values: Vec<Self>) -> Vec<Values> {
                vec![Values::new(columns[0].name.into(), values)]
            }

            fn read(columns: &[Column], frame: &'a DataFrame) -> Result<Vec<Self>, TableError> {
                let lacking = || TableError::not_a_number(columns[0].name, "");
                let there = |v: Option<$number>| v.or($missing).ok_or_else(lacking);
                <Option<$number>>::read(columns, frame)?.into_iter().map(there).collect()
            }
        }
    )*};
}
// Behind each type what stands for a missing value; none where there must be one.
numbers! {
    i32, None;
    i64, None;
    f64, Some(f64::NAN);
}

/// Three names at the start of rows, one column each.
impl<'a, A: Field<'a>, B: Field<'a>, C: Field<'a>> Field<'a> for (A, B, C) {
    fn write(columns: &[Column], values: Vec<Self>) -> Vec<Values> {
        let (first, second, third): (Vec<A>, Vec<B>, Vec<C>) = values.into_iter().collect();
        [A::write(&columns[..1], first), B::write(&columns[1..2], second), C::write(&columns[2..], third)]
            .concat()
    }

    fn read(columns: &[Column], frame: &'a DataFrame) -> Result<Vec<Self>, TableError> {
        let others = B::read(&columns[1..2], frame)?.into_iter().zip(C::read(&columns[2..], frame)?);
        let all = A::read(&columns[..1], frame)?.into_iter().zip(others);
        Ok(all.map(|(first, (second, third))| (first, second, third)).collect())
    }
}

/// Writes values that have several numeric columns; `number` returns the number for the column of an index.
pub(super) fn group<T>(
    columns: &[Column],
    values: &[T],
    number: impl Fn(&T, usize) -> Option<f64>,
) -> Vec<Values> {
    let of = |(k, column): (usize, &Column)| {
        let (name, numbers) = (column.name.into(), values.iter().map(|value| number(value, k)));
        match column.kind {
            Kind::Integer => Values::new(name, numbers.map(|v| v.map(|v| v as i64)).collect::<Vec<_>>()),
            _ => Values::new(name, numbers.collect::<Vec<_>>()),
        }
    };
    columns.iter().enumerate().map(of).collect()
}

/// Reads several numeric columns, and builds a value from the numbers of each row.
pub(super) fn ungroup<T>(
    columns: &[Column],
    frame: &DataFrame,
    value: impl Fn(&[Option<f64>]) -> T,
) -> Result<Vec<T>, TableError> {
    let of = |column: &Column| -> Result<Vec<Option<f64>>, TableError> {
        let reals = frame.column(column.name)?.cast(&DataType::Float64)?;
        Ok(reals.f64()?.iter().collect())
    };
    let all = columns.iter().map(of).collect::<Result<Vec<_>, _>>()?;
    let row = |i: usize| value(&all.iter().map(|numbers| numbers[i]).collect::<Vec<_>>());
    Ok((0..frame.height()).map(row).collect())
}

/// Numbers of which all or none are there: bounds, a mean and its deviation, corners.
impl<'a, const N: usize> Field<'a> for Option<[f64; N]> {
    fn write(columns: &[Column], values: Vec<Self>) -> Vec<Values> {
        group(columns, &values, |numbers, k| numbers.map(|numbers| numbers[k]))
    }

    fn read(columns: &[Column], frame: &'a DataFrame) -> Result<Vec<Self>, TableError> {
        ungroup(columns, frame, |numbers| {
            let known: Option<Vec<f64>> = numbers.iter().copied().collect();
            <[f64; N]>::try_from(known?).ok()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::bytes::parts_to_parquet;
    use polars_parquet::write::schema_to_metadata_key;

    const SUITE: Column = text("suite");
    const NAME: Column = text("name");
    const V: Column = real("v");
    const W: Column = integer("w");

    rows! {
        struct One in "one.csv", [] { v: f64 = [V], } []
        struct Two in "two.csv", [] { v: Option<f64> = [V], w: i64 = [W], } []
        struct New in "new.csv", [] { v: f64 = [V], w: Option<i64> = [W.recent()], } []
        struct Named<'a> in "named.parquet", [SUITE] { name: &'a str = [NAME], v: f64 = [V], } []
    }

    #[test]
    fn floats_survive_both_formats_bit_by_bit() {
        let values = [0.1 + 0.2, 1e-300, -0.0, 5e-324, 1.0 / 3.0, 123_456_789.123_456_78];
        let rows = || values.map(|v| One { v });
        for bytes in [One::csv("", rows()).unwrap(), One::parquet("", rows()).unwrap()] {
            let frame = One::read(bytes).unwrap();
            let bits: Vec<u64> = One::rows(&frame).unwrap().iter().map(|row| row.v.to_bits()).collect();
            assert_eq!(bits, values.map(f64::to_bits));
        }
    }

    // Arrow's readers go by these types: `large_string` can be filtered, `string_view` cannot.
    #[test]
    fn texts_of_parquet_are_large_strings() {
        let frame = || Named::frame("s", ["a", "b"].map(|name| Named { name, v: 1.0 })).unwrap();
        let mut parts = Vec::new();
        parts_to_parquet(&mut parts, [Ok::<_, TableError>(frame()), Ok(frame())]).unwrap();
        let texts = ["suite", "name"].map(|name| (name, ArrowDataType::LargeUtf8));
        let types = texts.into_iter().chain([("v", ArrowDataType::Float64)]);
        let fields = types.map(|(name, kind)| ArrowField::new(name.into(), kind, true));
        let expected = schema_to_metadata_key(&fields.map(|f| (f.name.clone(), f)).collect());
        for (bytes, times) in [(to_parquet(frame()).unwrap(), 1), (parts, 2)] {
            let metadata = polars_parquet::read::read_metadata(&mut Cursor::new(&bytes)).unwrap();
            assert_eq!(metadata.key_value_metadata.as_deref().unwrap(), std::slice::from_ref(&expected));
            let mut names = Vec::new();
            let take = |frame: DataFrame| {
                names.extend(Named::rows(&frame)?.iter().map(|row| row.name.to_string()));
                Ok(())
            };
            Named::each_part(bytes, take).unwrap();
            assert_eq!(names, ["a", "b"].repeat(times));
        }
    }

    #[test]
    fn headers_have_the_declared_columns_and_no_others() {
        let refused = |csv: &str| One::read(csv.as_bytes().to_vec()).err().unwrap().to_string();
        assert_eq!(refused("w\n1\n"), "the column `w` does not belong here");
        assert_eq!(refused("v,w\n1,2\n"), "the column `w` does not belong here");
        assert_eq!(refused("v\nx\n"), "column `v`: `x` is not a number");
        let two = |csv: &str| Two::rows(&Two::read(csv.as_bytes().to_vec())?);
        assert_eq!(two("v\n1\n").unwrap_err().to_string(), "the column `w` is missing");
        assert_eq!(two("v,w\n,7\n").unwrap(), [Two { v: None, w: 7 }]);
        assert_eq!(two("v,w\n1,7.5\n").unwrap_err().to_string(), "column `w`: `7.5` is not a number");
        assert_eq!(two("v,w\n1,\n").unwrap_err().to_string(), "column `w`: `` is not a number");
        let old = New::read(b"v\n1\n".to_vec()).unwrap();
        assert_eq!(New::rows(&old).unwrap(), [New { v: 1.0, w: None }]);
    }
}
