//! Tables for people, from results.
//!
//! [`layouts`] makes the tables that an experiment asks for, each a [`layout`](mod@layout) of texts whose cells know the
//! numbers that they show; [`write_tables`] writes them, [`render`] as CSV, Parquet, Markdown and plain text,
//! [`latex`](mod@latex) as LaTeX, and [`macros`] with a LaTeX command for every number. [`leaderboard`](mod@leaderboard)
//! ranks methods, [`build`] makes the tables that a report has by itself, [`number`] prints numbers as papers do,
//! [`suites`] names suites.

pub mod build;
mod experiment;
pub mod latex;
pub mod layout;
pub mod leaderboard;
pub mod macros;
pub mod number;
pub mod render;
pub mod suites;

pub use experiment::{data_note, layouts, pooled, write_tables};
