//! Declarations of the files with columns: each column has one, which writer, reader and documentation share.

use super::frame::{Rows, TableError};
use polars::prelude::{Column as Series, DataFrame, DataType, NamedFrom};

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
    /// Its name in the documentation.
    pub fn words(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Integer => "integer, 64 bits",
            Self::Small => "integer, 32 bits",
            Self::Real => "float, 64 bits",
        }
    }

    fn data_type(self) -> DataType {
        match self {
            Self::Text => DataType::String,
            Self::Integer => DataType::Int64,
            Self::Small => DataType::Int32,
            Self::Real => DataType::Float64,
        }
    }
}

/// A column of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Name in the file's header.
    pub name: &'static str,
    /// Type of its values.
    pub kind: Kind,
    /// Unit of its values; empty for texts and for plain numbers.
    pub unit: &'static str,
    /// Meaning of a value.
    pub meaning: &'static str,
    /// When a value is missing; empty where there always is one.
    pub empty: &'static str,
    /// Whether files of earlier versions lack it.
    pub recent: bool,
}

impl Column {
    const fn new(name: &'static str, kind: Kind, unit: &'static str, meaning: &'static str) -> Self {
        Self { name, kind, unit, meaning, empty: "", recent: false }
    }

    /// A column of texts.
    pub const fn text(name: &'static str, meaning: &'static str) -> Self {
        Self::new(name, Kind::Text, "", meaning)
    }

    /// A column of 64-bit integers.
    pub const fn integer(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self::new(name, Kind::Integer, unit, meaning)
    }

    /// A column of 32-bit integers.
    pub const fn small(name: &'static str, meaning: &'static str) -> Self {
        Self::new(name, Kind::Small, "", meaning)
    }

    /// A column of floats.
    pub const fn real(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self::new(name, Kind::Real, unit, meaning)
    }

    /// The same, with missing values `when` that is the case.
    pub const fn empty(self, when: &'static str) -> Self {
        Self { empty: when, ..self }
    }

    /// The same, but files of earlier versions may lack it.
    pub const fn recent(self) -> Self {
        Self { recent: true, ..self }
    }

    /// The column with its values, for a writer.
    pub(super) fn of<T, P: ?Sized>(&self, values: T) -> Series
    where
        T: AsRef<P>,
        polars::prelude::Series: NamedFrom<T, P>,
    {
        Series::new(self.name.into(), values)
    }

    /// The column of a metric with its values, which are whole where the column holds integers.
    pub(super) fn of_metric(&self, values: impl Iterator<Item = Option<f64>>) -> Series {
        match self.kind {
            Kind::Integer => self.of(values.map(|v| v.map(|v| v as i64)).collect::<Vec<_>>()),
            _ => self.of(values.collect::<Vec<_>>()),
        }
    }
}

/// Name of the suite.
pub const SUITE: Column = Column::text("suite", "Name of the suite");
/// Name of the sequence.
pub const SEQUENCE: Column = Column::text("sequence", "Name of the sequence");
/// Label of the tracker.
pub const TRACKER: Column = Column::text("tracker", "Label of the tracker in the experiment");
/// Repetition of the tracker.
pub const RUN: Column = Column::integer("run", "", "Repetition of the tracker, from 0");
/// Number of the frame.
pub const FRAME: Column =
    Column::integer("frame", "", "Number of the frame, as the sequence numbers its frames");
/// Method.
pub const METHOD: Column = Column::text("method", "Name of the method");
/// Grid point.
pub const PARAMS: Column = Column::text("params", "Point of the method's grid: `horizon=5;window=20`")
    .empty("the method has no grid");

/// Missing counts.
const NO_RESULT: &str = "there is no result";
/// Missing ratios.
const NO_VALUE: &str = "there is no result, or the denominator is 0";

/// True positives.
pub const TP: Column =
    Column::integer("tp", "", "True positives: detections that match an event").empty(NO_RESULT);
/// False positives.
pub const FP: Column =
    Column::integer("fp", "", "False positives: detections that match no event").empty(NO_RESULT);
/// False negatives.
pub const FN: Column =
    Column::integer("fn", "", "False negatives: events that no detection matches").empty(NO_RESULT);
/// True negatives.
pub const TN: Column =
    Column::integer("tn", "frames", "True negatives: frames that are rightly silent").empty(NO_RESULT);
/// Events.
pub const EVENTS: Column =
    Column::integer("events", "", "Events of the ground truth: TP + FN").empty(NO_RESULT);
/// Detections.
pub const DETECTIONS: Column =
    Column::integer("detections", "", "Detections of the method: TP + FP").empty(NO_RESULT);
/// Precision.
pub const PRECISION: Column = Column::real("precision", "", "TP / (TP + FP)").empty(NO_VALUE);
/// Recall.
pub const RECALL: Column = Column::real("recall", "", "TP / (TP + FN)").empty(NO_VALUE);
/// F.
pub const F_SCORE: Column = Column::real("f_score", "", "2 TP / (2 TP + FP + FN)").empty(NO_VALUE);
/// False positive rate.
pub const FPR: Column = Column::real("fpr", "", "False positive rate: FP / (FP + TN)").empty(NO_VALUE);

/// A file with columns, as CSV or Parquet.
#[derive(Debug, Clone, Copy)]
pub struct TableFile {
    /// Its name in the results folder.
    pub name: &'static str,
    /// Meaning of a row, and the purpose of the file.
    pub about: &'static str,
    /// Its columns, in their order.
    pub columns: &'static [Column],
}

impl TableFile {
    /// The frame that is written, from the columns of the declaration in their order, all of one length; recent ones may be
    /// left out.
    ///
    /// # Errors
    /// When names, types or lengths are not those of the declaration.
    pub(super) fn frame(&self, columns: Vec<Series>) -> Result<DataFrame, TableError> {
        let is_there = |c: &&Column| !c.recent || columns.iter().any(|series| series.name() == c.name);
        let declared = self.columns.iter().filter(is_there).map(|c| (c.name, c.kind.data_type()));
        if !declared.eq(columns.iter().map(|c| (c.name().as_str(), c.dtype().clone()))) {
            return Err(TableError::Undeclared(self.name));
        }
        let height = columns.first().map_or(0, Series::len);
        Ok(DataFrame::new(height, columns)?)
    }

    /// Reads the file from CSV.
    ///
    /// # Errors
    /// When the bytes are no table, or its columns are not the declared ones.
    pub(super) fn read_csv(&self, bytes: Vec<u8>) -> Result<Rows, TableError> {
        let rows = Rows::from_csv(bytes)?;
        self.check(rows.names())?;
        Ok(rows)
    }

    /// Its name in compact results, which have it as Parquet.
    pub fn packed(&self) -> String {
        self.name.replace(".csv", ".parquet")
    }

    /// Reads the file, CSV or [packed](Self::packed), every field as text.
    ///
    /// # Errors
    /// When the bytes are neither, or its columns are not the declared ones.
    pub(super) fn read(&self, bytes: Vec<u8>) -> Result<Rows, TableError> {
        let is_packed = bytes.starts_with(b"PAR1");
        let rows = if is_packed { Rows::from_parquet(bytes) } else { Rows::from_csv(bytes) }?;
        self.check(rows.names())?;
        Ok(rows)
    }

    /// Reads some columns of the file from Parquet, a row group at a time.
    ///
    /// # Errors
    /// When the bytes are no Parquet file, or its columns are not the declared ones, and those of `take`.
    pub(super) fn read_parquet_parts(
        &self,
        bytes: Vec<u8>,
        columns: &[Column],
        take: impl FnMut(Rows) -> Result<(), TableError>,
    ) -> Result<(), TableError> {
        Rows::each_part_of_parquet(bytes, |names| self.check(names), columns, take)
    }

    /// Whether a header has every column that is not recent, and no others.
    fn check<'n>(&self, names: impl IntoIterator<Item = &'n str>) -> Result<(), TableError> {
        let mut lacking: Vec<&Column> = self.columns.iter().collect();
        for name in names {
            match lacking.iter().position(|c| c.name == name) {
                Some(k) => drop(lacking.remove(k)),
                None => return Err(TableError::UnknownColumn(name.to_string())),
            }
        }
        match lacking.into_iter().find(|c| !c.recent) {
            Some(column) => Err(TableError::MissingColumn(column.name)),
            None => Ok(()),
        }
    }
}
