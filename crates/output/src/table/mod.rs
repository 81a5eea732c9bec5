//! Results as polars frames and as tables for people.
//!
//! [`records`] and [`quality`] turn an outcome into the files of a results folder, [`measures`] holds the
//! pooled numbers, [`manifest`] tells what they rest on, [`folder`] writes it all, [`layout`] arranges them
//! as an experiment's tables ask, [`render`] writes those as CSV, Parquet and Markdown, [`latex`](mod@latex) as LaTeX, [`leaderboard`](mod@leaderboard) ranks methods,
//! and [`macros`] gives every number of them a LaTeX command.

pub mod folder;
pub mod frame;
pub mod latex;
pub mod layout;
pub mod leaderboard;
pub mod macros;
pub mod manifest;
pub mod measures;
pub mod number;
pub mod quality;
pub mod records;
pub mod render;
