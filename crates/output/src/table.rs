//! Tables for people, from results.
//!
//! [`layouts`] makes the tables of an experiment. Each is a [`layout`](mod@layout) of texts, and each cell
//! stores the number that it shows. [`write_tables`] writes the tables: [`render`] as CSV, Parquet, Markdown
//! and plain text, [`latex`](mod@latex) as LaTeX, and [`macros`] makes a LaTeX command for each number.
//! [`leaderboard`](mod@leaderboard) ranks methods, [`build`] makes further tables of reports, [`number`]
//! prints numbers as papers do, [`suites`] describes suites in words.

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
