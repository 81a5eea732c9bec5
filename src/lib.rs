//! trackfail: a benchmark of detectors that tell when a visual object tracker has lost its target.
//!
//! The modules in the order in which data flow through them. Each crate uses only those above it, each module only those
//! above it in its crate; a plugin ([`tracker`], [`signal`], [`detector`], [`analysis`]) is two files: its own and its
//! module's list. ARCHITECTURE.md follows one run step by step and says where each change goes.
//!
//! | crate | module | from | to |
//! |---|---|---|---|
//! | core | [`region`], [`mod@image`], [`num`], [`direction`], [`plugin`] | | rectangles and polygons, pixels, numerics, which way is better, lists of plugins |
//! | judge | [`tracker`] | a sequence | a region for each frame |
//! | | [`signal`] | frames and regions | one number for each frame |
//! | | [`detector`] | a signal; for ARTE and ARTE* also reverse runs of the tracker | a label for each frame |
//! | | [`score`] | labels and ground truth | counts and metrics, by versioned protocols |
//! | | [`method`] | a name, or plugins with parameters | signals and a detector |
//! | | [`judge`], [`monitor`] | frames and boxes of a tracker | a judgment of each frame: whole tracks, or live |
//! | dataset | [`dataset`] | folders, `datasets/*.toml`, downloads, `scenes/*.toml` | sequences: frames and ground truth |
//! | methods | [`tracker`], [`signal`], [`detector`] | result files, foreign programs | the same, beside those of judge |
//! | | [`analysis`] | signals or regions of whole suites | numbers, tables and charts about signals and trackers |
//! | engine | [`spec`] | `experiments/*.toml` | checked experiments |
//! | | [`engine`] | an experiment and its suites | judged cells, stored under content addresses |
//! | output | [`results`] | judged cells | the files of a results folder, written and read |
//! | | [`sampling`] | counts of sequences | confidence intervals of numbers computed from them |
//! | | [`table`] | results | tables as CSV, Parquet, Markdown and LaTeX |
//! | | [`figure`] | plain series | SVG, PDF and PNG |
//! | | [`report`] | results alone | an offline HTML page for each experiment, one over all; the parts of a number |
//! | this one | [`cli`] | arguments | calls of the above, exit codes |
//!
//! Words: a *method* is a signal with a detector under the name a paper gives it; a *cell* is a method
//! on one tracker's run over one sequence; its *address* is the digest of all it is made from; an *event*
//! is a frame in which the tracker fails.

pub mod cli;

pub use trackfail_core::{direction, image, num, plugin, region};
pub use trackfail_dataset as dataset;
pub use trackfail_engine::{self as engine, spec};
pub use trackfail_judge::{self as judge, method, monitor};
pub use trackfail_methods::{analysis, detector, score, signal, tracker};
pub use trackfail_output::{figure, report, results, sampling, table, user_file};
