//! The results of an experiment: the one room that writes and reads the files of a run, `results/<experiment>/`.
//!
//! Files with columns are declared once, in `files`: writer, reader and the documentation ([`columns_markdown`]) share the
//! declaration, and a column that is missing or does not belong there is an error. The rows are filled here:
//!
//! | module | file |
//! |---|---|
//! | [`scores`] | `scores.csv`: counts of every cell |
//! | [`measures`] | `measures.csv`: pooled numbers |
//! | [`frame_measures`] | `frame_measures.csv`: pooled numbers made of the score and alarm of every frame |
//! | [`frame_pairs`] | `frame_pairs.csv`: differences of these numbers between methods, of experiments of the leaderboard |
//! | [`readings`] | `readings.csv`: published numbers beside those of each reading |
//! | `fill` | `frames.parquet`: boxes, scores and labels of every frame; `signals.parquet`: signals and forecasts; `truth.parquet`: ground truth; `conditions.parquet`, `checks.csv`: of methods that follow the tracker's condition; `pieces.csv`: of protocols in which a restart begins a new track |
//! | [`tables`] | `tables/*.csv` and `*.parquet`: the tables, written when the report is rendered |
//! | [`detections`] | what `trackfail detect` prints |
//!
//! Files of other kinds:
//!
//! | module | file |
//! |---|---|
//! | [`analyses`] | `analyses.json` |
//! | [`models`] | `models/*.json` |
//! | [`manifest`] | `manifest.json`: what the results rest on |
//! | [`run`] | `run.json`: what differs from run to run |
//! | [`unfinished`] | none: the cells of the manifest that have no result, in groups |
//!
//! [`write`](fn@write) writes a folder, [`Results`] reads it.

mod cells;
pub mod detections;
mod files;
mod fill;
mod folder;
pub mod frame_measures;
pub mod frame_pairs;
mod json;
pub mod manifest;
mod markdown;
pub mod measures;
pub mod models;
mod presentation;
pub mod readings;
pub mod rows;
pub mod run;
pub mod scores;
mod tracks;
pub mod unfinished;

pub(crate) use cells::{grouped, in_parts};
pub use cells::{method_label, parse_point};
pub use folder::{Detail, Results, remove_others, write};
pub use json::to_json;
pub use manifest::{FailedCell, Manifest};
pub use markdown::columns_markdown;
pub use measures::Measure;
pub use rows::{TableError, texts_from_csv, texts_to_csv};
pub use run::RunRecord;
pub use scores::CellScore;
pub use tracks::{MethodSeries, ReverseCheck, TrackFilter, TrackSeries, Truth};

use std::path::PathBuf;
use trackfail_dataset::DatasetError;
use trackfail_engine::spec::SpecError;
use trackfail_engine::store::StoreError;

/// `analyses.json`: what the experiment's analyses found out, one entry for each analysis and tracker.
pub mod analyses {
    /// The file; experiments without an analysis, and those where every analysis failed, have none.
    pub const FILE: &str = "analyses.json";
}

/// `tables/*.csv` and `tables/*.parquet`: the tables of an experiment, cell by cell, for programs.
pub mod tables {
    pub use super::files::TableRow;

    /// The folder of the tables.
    pub const FOLDER: &str = "tables";
}

/// The experiment file as it was run, in a results folder.
pub const SPEC: &str = "experiment.toml";
/// The user's suites that the experiment names, in the results folder of one that does.
pub const USER_SUITES: &str = "suites.lock";
/// The folder of the video frames that figures show.
pub const STILLS: &str = "stills";
/// The folders of a results folder that hold nothing else.
pub const OWNED: [&str; 3] = [tables::FOLDER, models::FOLDER, STILLS];

/// A results folder that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// A file cannot be written or read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A file is absent, unreadable or too large.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A file with columns cannot be made.
    #[error(transparent)]
    Made(#[from] TableError),
    /// A file with columns is not what it should be.
    #[error("{}: {source}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// Error of reading it.
        source: TableError,
    },
    /// A file with columns is so damaged that polars gives up.
    #[error("{}: a damaged file; run the experiment again", .0.display())]
    Damaged(PathBuf),
    /// A JSON file is not what it should be.
    #[error("{}: {source}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Error of reading it.
        source: serde_json::Error,
    },
    /// A file has another digest than the manifest states.
    #[error("{}: not the file that the run wrote (its SHA-256 is not the manifest's); run it again", .0.display())]
    Changed(PathBuf),
    /// The experiment file kept beside the results is wrong.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// An experiment file is not one of these results.
    #[error(
        "{}: not what the results in {} were run with; other: {} (captions, titles, order and selection may differ); \
         run it",
        path.display(), folder.display(), keys.join(", ")
    )]
    OtherNumbers {
        /// The experiment file.
        path: PathBuf,
        /// The results.
        folder: PathBuf,
        /// Keys of the experiment file that differ.
        keys: Vec<String>,
    },
    /// The folder holds no finished run.
    #[error("{}: no manifest.json; run the experiment first", .0.display())]
    Unfinished(PathBuf),
    /// Written by a later program.
    #[error("{}: results format {found}; this program reads up to {}", path.display(), manifest::FORMAT)]
    Format {
        /// The folder.
        path: PathBuf,
        /// Its format.
        found: u32,
    },
}
