//! The files with columns of a results folder, each declared once, and what `trackfail detect` prints.
//!
//! To add a column, add a field here, and its value where the rows are filled.

use super::cells::TrackName;
use super::frame_measures::MEASURES;
use super::frame_pairs::Difference;
use super::rows::{Column, File, Kind, Rows, rows};
use trackfail_methods::score::{Counts, FrameMeasures};

const fn text(name: &'static str, meaning: &'static str) -> Column {
    Column::new(Kind::Text, name, meaning)
}

pub(super) const fn integer(name: &'static str, meaning: &'static str) -> Column {
    Column::new(Kind::Integer, name, meaning)
}

const fn small(name: &'static str, meaning: &'static str) -> Column {
    Column::new(Kind::Small, name, meaning)
}

pub(super) const fn real(name: &'static str, meaning: &'static str) -> Column {
    Column::new(Kind::Real, name, meaning)
}

const SUITE: Column = text("suite", "Name of the suite");
const SEQUENCE: Column = text("sequence", "Name of the sequence");
const TRACKER: Column = text("tracker", "Label of the tracker in the experiment");
const TRACKER_OR_POOL: Column = TRACKER.means(
    "Label of the tracker; in experiments of the leaderboard also `*` for all of them, `* FAMILY` for those of a family, \
     `* on SOURCE` for all on a source of videos, `* FAMILY on SOURCE`",
);
const RUN: Column = integer("run", "Repetition of the tracker, from 0");
const FRAME: Column = integer("frame", "Number of the frame, as the sequence numbers its frames");
const METHOD: Column = text("method", "Name of the method");
const PARAMS: Column =
    text("params", "Point of the method's grid: `horizon=5;window=20`").empty("the method has no grid");
const SCORE: Column = real("score", "The detector's score: most compare it with their threshold");
const LABEL: Column = small("label", "1 in frames in which the method alarms, 0 elsewhere");
const CHANGE: Column = small("change", "1 where the label becomes 1, -1 where it becomes 0, 0 elsewhere");

const NO_RESULT: &str = "there is no result";
const NO_RATIO: &str = "there is no result, or the denominator is 0";
const NO_SCORES: &str = "no sequence has scores that differ";
const NOT_ANNOTATED: &str = "the target is not annotated";
const NO_DIFFERENCE: &str = "one of the two has no value";
pub(super) const NO_INTERVAL: &str = "there is no value, or there are fewer than three sequences";
const NONE: &str = "there is none";

/// Columns of the counts, and of ratios of these.
const COUNTS: [Column; 10] = [
    integer("tp", "True positives: detections that match an event").empty(NO_RESULT),
    integer("fp", "False positives: detections that match no event").empty(NO_RESULT),
    integer("fn", "False negatives: events that no detection matches").empty(NO_RESULT),
    integer("tn", "True negatives: frames that are rightly silent").unit("frames").empty(NO_RESULT),
    integer("events", "Events of the ground truth: TP + FN").empty(NO_RESULT),
    integer("detections", "Detections of the method: TP + FP").empty(NO_RESULT),
    real("precision", "TP / (TP + FP)").empty(NO_RATIO),
    real("recall", "TP / (TP + FN)").empty(NO_RATIO),
    real("f_score", "2 TP / (2 TP + FP + FN)").empty(NO_RATIO),
    real("fpr", "False positive rate: FP / (FP + TN)").empty(NO_RATIO),
];

const CORNER_1: &str =
    "Horizontal place of the first corner; a box begins with its upper left one, then goes clockwise";

const fn corner(name: &'static str, meaning: &'static str) -> Column {
    real(name, meaning).unit("pixels").empty(NOT_ANNOTATED)
}

const CORNERS: [Column; 8] = [
    corner("x1", CORNER_1),
    corner("y1", "Vertical place of the first corner"),
    corner("x2", "Horizontal place of the second corner"),
    corner("y2", "Vertical place of the second corner"),
    corner("x3", "Horizontal place of the third corner"),
    corner("y3", "Vertical place of the third corner"),
    corner("x4", "Horizontal place of the fourth corner"),
    corner("y4", "Vertical place of the fourth corner"),
];

rows! {
    /// Counts of a cell, or of all cells of a run of a tracker.
    pub(super) struct Score<'a> in "scores.csv",
    "One row for each cell (a method on one run of a tracker over a sequence), sorted by its names, and one with sequence `*` \
     for each run of a tracker with a method, pooled over its sequences.", [SUITE] {
        track: TrackName<'a> = [SEQUENCE.means("Name of the sequence; `*` for all of them"), TRACKER, RUN],
        method: &'a str = [METHOD],
        params: &'a str = [PARAMS],
        counts: Option<Counts> = COUNTS,
        status: String = [text(
            "status",
            "`ok`, or the reason why there is no result (`missing: ...`, `failed: ...`, `not run: ...`) or only a part of it \
             (`partial: 3 of 4`)",
        )],
    } []

    /// Pooled numbers of a tracker and a method with its grid point.
    pub(super) struct MeasureRow<'a> in "measures.csv",
    "One row for each tracker and method (with its grid point), pooled over sequences and runs: ratios are those of the \
     summed counts.", [SUITE] {
        of: (&'a str, &'a str, &'a str) = [TRACKER, METHOD, PARAMS],
        done: i64 = [integer("done", "Cells that have a result").unit("cells")],
        failed: i64 = [integer(
            "failed",
            "Cells that failed, or whose data is missing although their sequence is there",
        ).unit("cells")],
        counts: Option<Counts> = COUNTS,
        score: Option<[f64; 2]> = [
            real("score_mean", "Mean of the scores of all frames, each sequence's scaled to 0..1").empty(NO_SCORES),
            real("score_std", "Standard deviation of the same scaled scores").empty(NO_SCORES),
        ],
        reverse_runs: Option<i64> =
            [integer("reverse_runs", "Runs of the tracker backwards in time").empty(NO_RESULT).recent()],
        reverse_frames: Option<i64> = [
            integer("reverse_frames", "Frames of all runs backwards").unit("frames").empty(NO_RESULT).recent()
        ],
        delay: Option<f64> = [
            real("delay_median", "Median delay from an event to the detection that matches it")
                .unit("frames")
                .empty("no detection matches an event")
                .recent()
        ],
    } []

    /// Measures by frame of a tracker (or of several together) and a method with its grid point.
    pub(super) struct Measured<'a> in "frame_measures.csv",
    "One row for each tracker and method (with its grid point), as in measures.csv: how well the method's score and its \
     alarms tell lost frames from good ones, frame by frame, all frames together. Bounds are those of a 95 % bootstrap \
     interval over sequences. Runs of earlier versions have no such file.", [SUITE] {
        of: (&'a str, &'a str, &'a str) = [TRACKER_OR_POOL, METHOD, PARAMS],
        measures: FrameMeasures = MEASURES,
    } []

    /// Difference between two methods.
    pub struct Pair in "frame_pairs.csv",
    "One row for each two methods with results on the same tracks, all trackers together, in experiments of the leaderboard: \
     differences of measures of frame_measures.csv, the first method less the other. Bounds are those of a 95 % bootstrap \
     interval over sequences, with the same sequences for both. Runs of earlier versions have no such file.", [SUITE] {
        /// Name of the method.
        method: String = [METHOD],
        /// Name of the method that it is compared with.
        other: String = [text("other", "Name of the method that it is compared with")],
        /// Number of tracks that both methods were run on.
        tracks: i64 = [integer("tracks", "Number of the tracks that both were run on")],
        /// Difference of AUROC.
        auroc: Difference = [
            real("auroc_difference", "Difference of `auroc`").empty(NO_DIFFERENCE),
            real("auroc_difference_low", "Lower bound of `auroc_difference`").empty(NO_INTERVAL),
            real("auroc_difference_high", "Upper bound of `auroc_difference`").empty(NO_INTERVAL),
        ],
        /// Difference of the share of losses found at 5 false alarms per 1000 good frames.
        found_at_5: Difference = [
            real("found_at_5_difference", "Difference of `found_at_5`").empty(NO_DIFFERENCE),
            real("found_at_5_difference_low", "Lower bound of `found_at_5_difference`").empty(NO_INTERVAL),
            real("found_at_5_difference_high", "Upper bound of `found_at_5_difference`").empty(NO_INTERVAL),
        ],
    } []

    /// A frame of a cell.
    pub(super) struct Frame<'a> in "frames.parquet",
    "One row for each frame of every cell that has a result, cells sorted by their names.", [SUITE] {
        track: TrackName<'a> = [SEQUENCE, TRACKER, RUN],
        frame: i64 = [FRAME],
        x: f64 = [real("x", "Left edge of the tracker's box").unit("pixels")],
        y: f64 = [real("y", "Upper edge of the tracker's box").unit("pixels")],
        w: f64 = [real("w", "Width of the tracker's box").unit("pixels")],
        h: f64 = [real("h", "Height of the tracker's box").unit("pixels")],
        error: Option<f64> = [
            real("error", "Error O_t of the box: 1 - Dice overlap with the ground truth").empty("it is not known")
        ],
        method: &'a str =
            [METHOD.means("Name of the method, with its grid point: `DTEF[horizon=5;window=20]`")],
        score: f64 = [SCORE],
        alarm_score: Option<f64> = [
            real("alarm_score", "The number that the detector compares with its threshold")
                .empty("it is the score")
                .recent()
        ],
        label: i32 = [LABEL],
        change: i32 = [CHANGE],
    } []

    /// A frame of a cell whose method reads a signal.
    pub(super) struct Signal<'a> in "signals.parquet",
    "One row for each frame of every cell that has a result, of methods that read a signal. Cells that differ in the point of \
     a method's grid alone share their rows where all of them read the same signal and none makes a forecast.", [SUITE] {
        track: TrackName<'a> = [SEQUENCE, TRACKER, RUN],
        frame: i64 = [FRAME],
        method: &'a str = [METHOD],
        params: &'a str = [PARAMS.empty("the method has no grid, or the row is that of all its points").recent()],
        signal: f64 = [real("signal", "Value of the method's signal")],
        forecast: Option<f64> = [
            real("forecast", "What the detector expected the signal to be, made before it saw the frame")
                .empty("the detector has no forecast there")
        ],
    } []

    /// The ground truth of a frame.
    pub(super) struct Target<'a> in "truth.parquet",
    "One row for each frame of every sequence, sequences sorted by name: the corners of the ground truth.", [SUITE] {
        sequence: &'a str = [SEQUENCE],
        frame: i64 = [FRAME],
        corners: Option<[f64; 8]> = CORNERS,
    } []

    /// Condition of the tracker in a frame, according to a method.
    pub(super) struct ConditionRow<'a> in "conditions.parquet",
    "One row for each frame of every cell of a method that follows the tracker's condition. Only experiments with such a \
     method have the file.", [SUITE] {
        track: TrackName<'a> = [SEQUENCE, TRACKER, RUN],
        frame: i64 = [FRAME],
        method: &'a str = [METHOD],
        params: &'a str = [PARAMS.recent()],
        condition: f64 =
            [real("condition", "Condition of the tracker: 1 locked on, 0.5 locking in, 0 scanning")],
    } []

    /// A check of a track by a reverse run.
    pub(super) struct CheckRow<'a> in "checks.csv",
    "One row for each time a method checked a track by running the tracker backwards, cells sorted by their names. Only \
     experiments with a method that follows the tracker's condition have the file.", [SUITE] {
        track: TrackName<'a> = [SEQUENCE, TRACKER, RUN],
        method: &'a str = [METHOD],
        params: &'a str = [PARAMS],
        frame: i64 = [FRAME.means("Number of the frame in which the check was made")],
        reference: i64 = [integer("reference", "Number of the earlier frame that the tracker was run back to")],
        error: Option<f64> = [
            real("error", "1 - Dice overlap of the forward and the backward box in that frame")
                .empty("the tracker was not run")
        ],
        accepted: i32 = [small("accepted", "1 where the track counts as successful again, 0 elsewhere")],
    } []

    /// A part of a track that was scored separately.
    pub(super) struct Piece<'a> in "pieces.csv",
    "One row for each piece of a track under a protocol in which a restart of the tracker begins a new track, such as \
     khalid2016/2. Frames between two pieces were skipped and count for nothing. Tracks without restarts have no row.",
    [SUITE] {
        track: TrackName<'a> = [SEQUENCE, TRACKER, RUN],
        first: i64 = [integer("first", "Number of the piece's first frame")],
        last: i64 = [integer("last", "Number of the piece's last frame")],
    } []

    /// A published number beside that of a reading, or the discrepancy of a reading.
    pub struct Row in "readings.csv",
    "One row for each reading of a method on a reading of a tracker and each published statistic, and one with the statistic \
     `discrepancy`. Bounds are those of a bootstrap interval over sequences. Only experiments in which a method or a tracker \
     is `like` another have the file.", [SUITE] {
        /// Label of the tracker.
        tracker: String = [TRACKER],
        /// Name of the method.
        method: String = [METHOD],
        /// Label of the tracker of which this one is a reading.
        of_tracker: String = [text("of_tracker", "Tracker that this one is a reading of, or itself")],
        /// Name of the method of which this one is a reading.
        of_method: String = [text("of_method", "Method that this one is a reading of, or itself")],
        /// Name of the metric, or `discrepancy`.
        statistic: String = [text("statistic", "Name of the metric, or `discrepancy`")],
        /// The published number.
        published: Option<f64> = [real("published", "The published number").empty(NONE)],
        /// Our number.
        ours: Option<f64> = [real("ours", "Our number").empty(NONE)],
        /// Our number minus the published one.
        difference: Option<f64> = [real("difference", "Ours less published").empty(NONE)],
        /// Bounds of our number.
        bounds: Option<[f64; 2]> = [
            real("low", "Lower bound of `ours`, 95 %").empty(NONE),
            real("high", "Upper bound of `ours`, 95 %").empty(NONE),
        ],
        /// Unit of the difference.
        scale: Option<f64> = [real("scale", "The unit e_s of the difference in the discrepancy").empty(NONE)],
        /// Share of bootstrap samples in which the reading has the smallest discrepancy.
        first: Option<f64> = [
            real("first", "Share of bootstrap samples in which the discrepancy is the smallest")
                .empty("the row is not about the discrepancy, or there are fewer than three sequences")
        ],
    } []

    /// One cell of a table.
    pub struct TableRow<'a> in "tables/<table>.csv, tables/<table>.parquet",
    "One row for each cell of a table of the experiment, as CSV and as Parquet.", [] {
        /// Name of the group; may be empty.
        group: &'a str = [
            text("group", "Name of the rows' group: a tracker, an attribute, or what the rows are of")
                .empty("the table has one group only")
        ],
        /// Tracker whose published numbers stand beside ours.
        published_tracker: Option<&'a str> = [
            text("published_tracker", "Tracker whose published numbers stand beside ours")
                .empty("nothing is published")
        ],
        /// Label of the row; may be empty.
        row: &'a str = [text("row", "Label of the row: a metric, method or grid value").empty("it has none")],
        /// Heading of the column; may be empty.
        column: &'a str = [text("column", "Heading of the column").empty("it has none")],
        /// Our number.
        ours: Option<f64> = [real("ours", "Our number with all its digits").empty(NONE)],
        /// The published number as printed.
        published: Option<&'a str> = [text("published", "The published number as printed").empty(NONE)],
        /// Our number minus the published one, as printed.
        difference: Option<&'a str> = [
            text("difference", "Ours minus published, both rounded as printed").empty("one of them is missing")
        ],
    } [text("data", "What all numbers rest on: `12 of 21 targets`")]

    /// Score, label, change and state of a frame of a user's track, by one method.
    pub(super) struct Judgement<'a> in "stdout of `trackfail detect` for boxes with numbers of targets",
    "One row for each frame, method and target, target by target.", [] {
        frame: i64 = [FRAME.means("Number of the frame, as its file has it")],
        method: &'a str = [METHOD],
        score: Option<f64> = [SCORE.empty("the track has not begun yet, or is over")],
        label: i32 = [LABEL],
        change: i32 = [CHANGE],
        state: &'a str = [text(
            "state",
            "`absent` where the tracker gives no box; else `lost` from an alarm on, until the recovery is confirmed: in the \
             frame without an alarm itself for methods whose alarm lasts as long as the loss, in the tenth frame in a row \
             without one for the others, and where the score is a probability, after ten frames in a row below one half; else \
             `tracking`. An alarm that is raised while the target is absent ends with the absence",
        )],
        target: Option<i64> = [integer("target", "Number of the target, as the file of boxes has it")],
    } []
}

/// Files that runs write, in the order of the documentation.
pub(super) fn of_folder() -> [File; 11] {
    [
        Score::file(),
        MeasureRow::file(),
        Measured::file(),
        Pair::file(),
        Frame::file(),
        Signal::file(),
        Target::file(),
        ConditionRow::file(),
        CheckRow::file(),
        Piece::file(),
        Row::file(),
    ]
}
