//! From judged cells to files and pages. Each module uses only those above it.
//!
//! | module | from | to |
//! |---|---|---|
//! | [`results`] | judged cells | the files of a results folder, and back |
//! | [`sampling`] | counts of sequences | confidence intervals of numbers computed from them |
//! | [`table`] | results | tables as CSV, Parquet, Markdown and LaTeX |
//! | [`figure`] | plain series | SVG, PDF and PNG |
//! | [`user_file`] | bytes | files that the user names |
//! | [`report`] | results, tables, figures | an offline HTML page for each experiment, one over all |

pub mod figure;
pub mod report;
pub mod results;
pub mod sampling;
pub mod table;
#[cfg(test)]
mod testing;
pub mod user_file;
