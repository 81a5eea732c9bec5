//! From judged cells to files and pages.
//!
//! | module | from | to |
//! |---|---|---|
//! | [`table`] | judged cells | CSV, Parquet, Markdown, LaTeX, and the manifest |
//! | [`figure`] | plain series | SVG and PNG |
//! | [`report`] | a results folder alone | an offline HTML page for each experiment, one over all |

pub mod figure;
pub mod report;
pub mod table;

use trackfail_core::{direction, image, num, plugin, region};
use trackfail_dataset as dataset;
use trackfail_engine::{self as engine, spec};
use trackfail_methods::{analysis, detector, score, signal};
