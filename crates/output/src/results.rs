//! Results of an experiment: the only module that writes and reads the files of a run,
//! `results/<experiment>/`.
//!
//! Files with columns are declared once, in `files`: writer and reader share the declaration, and a column that is missing
//! or does not belong there is an error. The rows are filled here:
//!
//! | module | file |
//! |---|---|
//! | [`scores`] | `scores.csv`: counts of every cell |
//! | [`measures`] | `measures.csv`: pooled numbers |
//! | [`frame_measures`] | `frame_measures.csv`: pooled numbers made of the score and alarm of every frame |
//! | [`frame_pairs`] | `frame_pairs.csv`: differences of these numbers between methods, of experiments of the leaderboard |
//! | [`readings`] | `readings.csv`: published numbers beside those of each reading |
//! | `fill` | `frames.parquet`: boxes, scores and labels of every frame; `signals.parquet`: signals and forecasts; `truth.parquet`: ground truth; `conditions.parquet`, `checks.csv`: of methods that follow the tracker's condition; `pieces.csv`: of protocols in which a restart begins a new track |
//! | [`TableRow`] | `tables/*.csv` and `*.parquet`: the tables, written when the report is rendered |
//! | [`detections`] | what `trackfail detect` prints |
//!
//! Files of other kinds:
//!
//! | module | file |
//! |---|---|
//! | [`ANALYSES`] | `analyses.json` |
//! | [`models`] | `models/*.json` |
//! | [`manifest`] | `manifest.json`: what the results rest on |
//! | [`run`] | `run.json`: what differs from run to run |
//! | [`beside`] | `beside/`: kept results that stand beside the own ones |
//! | [`unfinished`] | none: the cells of the manifest that have no result, in groups |
//! | [`sent`] | all of them as one zip file, and its check |
//!
//! [`write`](fn@write) writes a folder, [`Results`] reads it.

pub mod beside;
mod bytes;
mod cells;
#[cfg(test)]
mod columns_tests;
pub mod detections;
mod files;
mod fill;
mod folder;
pub mod frame_measures;
pub mod frame_pairs;
mod json;
pub mod manifest;
pub mod measures;
pub mod models;
mod presentation;
pub mod readings;
pub mod rows;
pub mod run;
pub mod scores;
pub mod sent;
mod tracks;
pub mod unfinished;

pub use bytes::{texts_from_csv, texts_to_csv};
pub(crate) use cells::{grouped, in_parts};
pub use cells::{method_label, parse_point};
pub use files::TableRow;
pub use folder::{Detail, Results, remove_others, write};
pub use json::to_json;
pub use manifest::{FailedCell, Manifest};
pub use measures::Measure;
pub use rows::TableError;
pub use run::RunRecord;
pub use scores::CellScore;
pub use tracks::{MethodSeries, ReverseCheck, TrackFilter, TrackSeries, Truth};

use std::io::{Error as IoError, ErrorKind};
use std::path::PathBuf;
use trackfail_dataset::DatasetError;
use trackfail_dataset::fetch::FetchError;
use trackfail_engine::spec::SpecError;
use trackfail_engine::store::StoreError;

/// Name of the file of findings, with an entry for each analysis and tracker; absent if the experiment has no analysis, or
/// all failed.
pub const ANALYSES: &str = "analyses.json";
/// Name of the folder of tables: those of an experiment as CSV and as Parquet, cell by cell, for programs.
pub const TABLES: &str = "tables";
/// Name of the experiment file in a results folder, as it was run.
pub const SPEC: &str = "experiment.toml";
/// Name of the file of user suites in a results folder; absent if the experiment uses none.
pub const USER_SUITES: &str = "suites.lock";
/// Name of the folder of video frames that figures show.
pub const STILLS: &str = "stills";
/// The folders of a results folder that hold nothing else.
pub const OWNED: [&str; 4] = [TABLES, models::FOLDER, STILLS, beside::FOLDER];

/// Reason why a results folder cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// A file cannot be written or read, or is not what the run wrote there.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A file is absent, unreadable or too large.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A file with columns cannot be written.
    #[error(transparent)]
    Made(#[from] TableError),
    /// A file that somebody sent is no archive, or one that is refused.
    #[error(transparent)]
    Archive(#[from] FetchError),
    /// The experiment file kept beside the results is wrong.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// An experiment does not belong to these results, or beside them; the text says what differs.
    #[error("{0}")]
    Unfit(String),
    /// The folder holds no finished run.
    #[error("{}: no manifest.json; run the experiment first", .0.display())]
    Unfinished(PathBuf),
}

impl ResultsError {
    /// True if the operating system refused; a file that is not there, and all that is wrong with the files, are faults of the
    /// results.
    pub fn is_io(&self) -> bool {
        let refused = match self {
            Self::Archive(e) => return !e.is_data(),
            Self::Store(e) => e.source.downcast_ref::<IoError>(),
            Self::Dataset(DatasetError::Io { source, .. }) => Some(source),
            _ => None,
        };
        refused.is_some_and(|e| e.kind() != ErrorKind::NotFound)
    }
}
