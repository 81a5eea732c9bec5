//! trackfail: a benchmark of detectors that tell when a visual object tracker has lost its target.
//!
//! The modules in the order in which data flow through them; each uses only those above it, plugins
//! ([`tracker`], [`signal`], [`detector`]) are one file and two lines in their module's list.
//!
//! | module | from | to |
//! |---|---|---|
//! | [`region`], [`mod@image`], [`num`], [`plugin`] | | rectangles and polygons, pixels, numerics, lists of plugins |
//! | [`dataset`] | folders, `datasets.lock`, downloads, the synthetic renderer | sequences: frames and ground truth |
//! | [`tracker`] | a sequence | a region a frame: built-in trackers, replayed result files, foreign programs |
//! | [`signal`] | frames and regions | one number a frame |
//! | [`detector`] | a signal; for ARTE and ARTE* also the tracker, run backwards by the engine | a label a frame |
//! | [`analysis`] | a signal, or regions, on whole suites | numbers, tables and charts about the signal itself, or about trackers |
//! | [`score`] | labels and ground truth | counts and measures, by versioned protocols |
//! | [`spec`] | `experiments/*.toml` | checked experiments |
//! | [`engine`] | an experiment and its suites | judged cells, kept under content addresses; the writer of results |
//! | [`results`] | judged cells | the files of a results folder, and back |
//! | [`table`] | results | tables as CSV, Parquet, Markdown and LaTeX |
//! | [`figure`] | plain series | SVG and PNG |
//! | [`report`] | results alone | an offline HTML page for each experiment, one over all; what is behind a number |
//! | [`cli`] | arguments | calls of the above, exit codes |
//!
//! Words: a *method* is a signal with a detector under the name a paper gives it; a *cell* is a method
//! on one tracker's run over one sequence; its *address* is the digest of all it is made from; an *event*
//! is a frame in which the tracker fails.

pub mod cli;

pub use trackfail_core::{direction, image, num, plugin, region};
pub use trackfail_dataset as dataset;
pub use trackfail_engine::{self as engine, spec};
pub use trackfail_methods::{analysis, detector, score, signal, tracker};
pub use trackfail_output::{figure, report, results, table};
