//! The files with columns of a results folder, each declared once, and what `trackfail detect` prints. `docs/columns.md`
//! explains every column.
//!
//! To add a column, add a field here, its value where the rows are filled, and its meaning to the page.

use super::cells::TrackName;
use super::frame_measures::MEASURES;
use super::frame_pairs::Difference;
use super::rows::{Column, Rows, integer, real, rows, small, text};
use trackfail_methods::score::{Counts, FrameMeasures};

const SUITE: Column = text("suite");
const SEQUENCE: Column = text("sequence");
const TRACKER: Column = text("tracker");
const RUN: Column = integer("run");
const FRAME: Column = integer("frame");
const METHOD: Column = text("method");
const PARAMS: Column = text("params").optional();

/// Columns of the counts, and of ratios of these.
const COUNTS: [Column; 10] = [
    integer("tp"),
    integer("fp"),
    integer("fn"),
    integer("tn"),
    integer("events"),
    integer("detections"),
    real("precision"),
    real("recall"),
    real("f_score"),
    real("fpr"),
];

const CORNERS: [Column; 8] =
    [real("x1"), real("y1"), real("x2"), real("y2"), real("x3"), real("y3"), real("x4"), real("y4")];

rows! {
    /// Counts of a cell, or of all cells of a run of a tracker.
    pub(super) struct Score<'a> in "scores.csv", [SUITE] {
        track: TrackName<'a> = [SEQUENCE, TRACKER, RUN],
        method: &'a str = [METHOD],
        params: &'a str = [PARAMS],
        counts: Option<Counts> = COUNTS,
        status: String = [text("status")],
    } []

    /// Pooled numbers of a tracker and a method with its grid point.
    pub(super) struct MeasureRow<'a> in "measures.csv", [SUITE] {
        of: (&'a str, &'a str, &'a str) = [TRACKER, METHOD, PARAMS],
        done: i64 = [integer("done")],
        failed: i64 = [integer("failed")],
        counts: Option<Counts> = COUNTS,
        score: Option<[f64; 2]> = [real("score_mean"), real("score_std")],
        reverse_runs: Option<i64> = [integer("reverse_runs").recent()],
        reverse_frames: Option<i64> = [integer("reverse_frames").recent()],
        delay: Option<f64> = [real("delay_median").recent()],
    } []

    /// Measures by frame of a tracker (or of several together) and a method with its grid point.
    pub(super) struct Measured<'a> in "frame_measures.csv", [SUITE] {
        of: (&'a str, &'a str, &'a str) = [TRACKER, METHOD, PARAMS],
        measures: FrameMeasures = MEASURES,
    } []

    /// Difference between two methods.
    pub struct Pair in "frame_pairs.csv", [SUITE] {
        /// Name of the method.
        method: String = [METHOD],
        /// Name of the method that it is compared with.
        other: String = [text("other")],
        /// Number of tracks that both methods were run on.
        tracks: i64 = [integer("tracks")],
        /// Difference of AUROC.
        auroc: Difference = [
            real("auroc_difference"),
            real("auroc_difference_low"),
            real("auroc_difference_high"),
        ],
        /// Difference of the share of losses found at 5 false alarms per 1000 good frames.
        found_at_5: Difference = [
            real("found_at_5_difference"),
            real("found_at_5_difference_low"),
            real("found_at_5_difference_high"),
        ],
    } []

    /// A frame of a cell.
    pub(super) struct Frame<'a> in "frames.parquet", [SUITE] {
        track: TrackName<'a> = [SEQUENCE, TRACKER, RUN],
        frame: i64 = [FRAME],
        x: f64 = [real("x")],
        y: f64 = [real("y")],
        w: f64 = [real("w")],
        h: f64 = [real("h")],
        error: Option<f64> = [real("error")],
        method: &'a str = [METHOD],
        score: f64 = [real("score")],
        alarm_score: Option<f64> = [real("alarm_score").recent()],
        label: i32 = [small("label")],
        change: i32 = [small("change")],
    } []

    /// A frame of a cell whose method reads a signal.
    pub(super) struct Signal<'a> in "signals.parquet", [SUITE] {
        track: TrackName<'a> = [SEQUENCE, TRACKER, RUN],
        frame: i64 = [FRAME],
        method: &'a str = [METHOD],
        params: &'a str = [PARAMS.recent()],
        signal: f64 = [real("signal")],
        forecast: Option<f64> = [real("forecast")],
    } []

    /// The ground truth of a frame.
    pub(super) struct Target<'a> in "truth.parquet", [SUITE] {
        sequence: &'a str = [SEQUENCE],
        frame: i64 = [FRAME],
        corners: Option<[f64; 8]> = CORNERS,
    } []

    /// Condition of the tracker in a frame, according to a method.
    pub(super) struct ConditionRow<'a> in "conditions.parquet", [SUITE] {
        track: TrackName<'a> = [SEQUENCE, TRACKER, RUN],
        frame: i64 = [FRAME],
        method: &'a str = [METHOD],
        params: &'a str = [PARAMS.recent()],
        condition: f64 = [real("condition")],
    } []

    /// A check of a track by a reverse run.
    pub(super) struct CheckRow<'a> in "checks.csv", [SUITE] {
        track: TrackName<'a> = [SEQUENCE, TRACKER, RUN],
        method: &'a str = [METHOD],
        params: &'a str = [PARAMS],
        frame: i64 = [FRAME],
        reference: i64 = [integer("reference")],
        error: Option<f64> = [real("error")],
        accepted: i32 = [small("accepted")],
    } []

    /// A part of a track that was scored separately.
    pub(super) struct Piece in "pieces.csv", [SUITE] {
        track: (String, String, i64) = [SEQUENCE, TRACKER, RUN],
        first: i64 = [integer("first")],
        last: i64 = [integer("last")],
    } []

    /// A published number beside that of a reading, or the discrepancy of a reading.
    pub struct Row in "readings.csv", [SUITE] {
        /// Label of the tracker.
        tracker: String = [TRACKER],
        /// Name of the method.
        method: String = [METHOD],
        /// Label of the tracker of which this one is a reading.
        of_tracker: String = [text("of_tracker")],
        /// Name of the method of which this one is a reading.
        of_method: String = [text("of_method")],
        /// Name of the metric, or `discrepancy`.
        statistic: String = [text("statistic")],
        /// The published number.
        published: Option<f64> = [real("published")],
        /// Our number.
        ours: Option<f64> = [real("ours")],
        /// Our number minus the published one.
        difference: Option<f64> = [real("difference")],
        /// Bounds of our number.
        bounds: Option<[f64; 2]> = [real("low"), real("high")],
        /// Unit of the difference.
        scale: Option<f64> = [real("scale")],
        /// Share of bootstrap samples in which the reading has the smallest discrepancy.
        first: Option<f64> = [real("first")],
    } []

    /// One cell of a table.
    pub struct TableRow<'a> in "tables/<table>.csv, tables/<table>.parquet", [] {
        /// Name of the group; may be empty.
        group: &'a str = [text("group").optional()],
        /// Tracker whose published numbers stand beside ours.
        published_tracker: Option<&'a str> = [text("published_tracker").optional()],
        /// Label of the row; may be empty.
        row: &'a str = [text("row").optional()],
        /// Heading of the column; may be empty.
        column: &'a str = [text("column").optional()],
        /// Our number.
        ours: Option<f64> = [real("ours")],
        /// The published number as printed.
        published: Option<&'a str> = [text("published").optional()],
        /// Our number minus the published one, as printed.
        difference: Option<&'a str> = [text("difference").optional()],
    } [text("data")]

    /// Score, label, change and state of a frame of a user's track, by one method.
    pub(super) struct Judgement<'a> in "stdout of `trackfail detect` for boxes with numbers of targets", [] {
        frame: i64 = [FRAME],
        method: &'a str = [METHOD],
        score: Option<f64> = [real("score")],
        label: i32 = [small("label")],
        change: i32 = [small("change")],
        state: &'a str = [text("state")],
        target: Option<i64> = [integer("target")],
    } []
}

/// Names of the files that runs write, in the order of the documentation.
pub(super) const OF_FOLDER: [&str; 11] = [
    Score::NAME,
    MeasureRow::NAME,
    Measured::NAME,
    Pair::NAME,
    Frame::NAME,
    Signal::NAME,
    Target::NAME,
    ConditionRow::NAME,
    CheckRow::NAME,
    Piece::NAME,
    Row::NAME,
];
