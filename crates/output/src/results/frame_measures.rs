//! `frame_measures.csv`: measures of scores and alarms frame by frame, pooled over sequences and runs.

use super::cells::{grouped, some_text};
use super::column::{Column, METHOD, PARAMS, SUITE, TRACKER, TableFile};
use super::frame::{TableError, to_csv};
use super::measures::Measure;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use trackfail_core::direction::Direction;
use trackfail_core::num::seed;
use trackfail_engine::execute::judge::Judged;
use trackfail_engine::spec::Experiment;
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::detector::DetectorOutput;
use trackfail_methods::score::FrameMeasures;
use trackfail_methods::score::frames::measures::{Sampled, of_scores, with_alarms};
use trackfail_methods::score::frames::{Method, ScoredTrack};
use trackfail_methods::score::restarts;

const NOT_KNOWN: &str = "it has no value, such as that of a suite without a loss";
const NO_INTERVAL: &str = "there is no value, or there are fewer than three sequences";

const GOOD_FRAMES: Column =
    Column::integer("good_frames", "frames", "Annotated frames that are not lost").empty(NOT_KNOWN);
const LOST_FRAMES: Column =
    Column::integer("lost_frames", "frames", "Frames without overlap").empty(NOT_KNOWN);
const LOSSES: Column =
    Column::integer("losses", "", "Ranges of lost frames after a frame that is not lost").empty(NOT_KNOWN);

const fn value(name: &'static str, unit: &'static str, meaning: &'static str) -> Column {
    Column::real(name, unit, meaning).empty(NOT_KNOWN)
}

const fn bound(name: &'static str, unit: &'static str, meaning: &'static str) -> Column {
    Column::real(name, unit, meaning).empty(NO_INTERVAL)
}

/// The file.
pub const FILE: TableFile = TableFile {
    name: "frame_measures.csv",
    about: "One row for each tracker and method (with its grid point), as in measures.csv: how well the method's score and \
            its alarms tell lost frames from good ones, frame by frame, all frames together. Bounds are those of a 95 % \
            bootstrap interval over sequences. Runs of earlier versions have no such file.",
    columns: &[
        SUITE,
        Column {
            meaning: "Label of the tracker; `*` for all of them, in experiments of the leaderboard",
            ..TRACKER
        },
        METHOD,
        PARAMS,
        GOOD_FRAMES,
        LOST_FRAMES,
        LOSSES,
        value("auroc", "", "Area under the ROC curve; lost: overlap 0, good: all others"),
        bound("auroc_low", "", "Lower bound of `auroc`"),
        bound("auroc_high", "", "Upper bound of `auroc`"),
        value("auprc", "", "Average precision; lost: overlap 0"),
        bound("auprc_low", "", "Lower bound of `auprc`"),
        bound("auprc_high", "", "Upper bound of `auprc`"),
        value("auroc_clear", "", "As `auroc`; lost: overlap (IoU) below 0.1, good: from 0.5 on"),
        bound("auroc_clear_low", "", "Lower bound of `auroc_clear`"),
        bound("auroc_clear_high", "", "Upper bound of `auroc_clear`"),
        value("auprc_clear", "", "As `auprc`; lost: overlap (IoU) below 0.1, good: from 0.5 on"),
        value(
            "false_alarms_at_half",
            "per 1000 good frames",
            "False alarms at the threshold that half of the losses reach within 15 frames",
        ),
        bound("false_alarms_at_half_low", "per 1000 good frames", "Lower bound of `false_alarms_at_half`"),
        bound("false_alarms_at_half_high", "per 1000 good frames", "Upper bound of `false_alarms_at_half`"),
        value("delay_at_half", "frames", "Mean delay of the losses found at that threshold"),
        value("arl0_at_half", "frames", "Good frames for each run of false alarms at that threshold"),
        value(
            "found_at_2",
            "",
            "Share of the losses found within 15 frames, where at most 2 of 1000 good frames alarm",
        )
        .recent(),
        value(
            "found_at_5",
            "",
            "Share of the losses found within 15 frames, where at most 5 of 1000 good frames alarm",
        )
        .recent(),
        bound("found_at_5_low", "", "Lower bound of `found_at_5`").recent(),
        bound("found_at_5_high", "", "Upper bound of `found_at_5`").recent(),
        value("aurc", "", "Area under the risk-coverage curve"),
        value("augrc", "", "Area under the generalized risk-coverage curve"),
        value("ece", "", "Expected calibration error, of scores that are probabilities"),
        value("range_precision", "", "Range-based precision of the method's alarms"),
        value("range_recall", "", "Range-based recall of the method's alarms"),
        value("range_f", "", "F1 of `range_precision` and `range_recall`"),
        value("nab", "", "NAB score of the method's alarms, standard profile"),
    ],
};

/// Columns that say which row it is.
const KEYS: usize = 4;

/// The field of a column.
fn field<'m>(measures: &'m mut FrameMeasures, column: &str) -> Option<&'m mut Option<f64>> {
    let m = measures;
    Some(match column {
        "good_frames" => &mut m.good_frames,
        "lost_frames" => &mut m.lost_frames,
        "losses" => &mut m.losses,
        "auroc" => &mut m.auroc,
        "auroc_low" => &mut m.auroc_low,
        "auroc_high" => &mut m.auroc_high,
        "auprc" => &mut m.auprc,
        "auprc_low" => &mut m.auprc_low,
        "auprc_high" => &mut m.auprc_high,
        "auroc_clear" => &mut m.auroc_clear,
        "auroc_clear_low" => &mut m.auroc_clear_low,
        "auroc_clear_high" => &mut m.auroc_clear_high,
        "auprc_clear" => &mut m.auprc_clear,
        "false_alarms_at_half" => &mut m.false_alarms_at_half,
        "false_alarms_at_half_low" => &mut m.false_alarms_at_half_low,
        "false_alarms_at_half_high" => &mut m.false_alarms_at_half_high,
        "delay_at_half" => &mut m.delay_at_half,
        "arl0_at_half" => &mut m.arl0_at_half,
        "found_at_2" => &mut m.found_at_2,
        "found_at_5" => &mut m.found_at_5,
        "found_at_5_low" => &mut m.found_at_5_low,
        "found_at_5_high" => &mut m.found_at_5_high,
        "aurc" => &mut m.aurc,
        "augrc" => &mut m.augrc,
        "ece" => &mut m.ece,
        "range_precision" => &mut m.range_precision,
        "range_recall" => &mut m.range_recall,
        "range_f" => &mut m.range_f,
        "nab" => &mut m.nab,
        _ => return None,
    })
}

/// The label that stands for all trackers together.
pub const EVERY_TRACKER: &str = "*";

/// How the scores of a method at a grid point are to be read.
pub fn reading(experiment: &Experiment, method: &str, params: &str) -> Method {
    let mine = experiment.methods.iter().filter(|m| m.name == method).flat_map(|m| &m.variants);
    let Some(variant) = mine.into_iter().find(|v| v.params() == params) else {
        return Method { direction: Direction::LowerIsBetter, is_probability: false };
    };
    let detector = &variant.detector.example().detector;
    let signal = variant.signal.as_ref().filter(|_| detector.scores_signal());
    let agrees = |s: &dyn trackfail_methods::signal::Signal| {
        s.is_probability() && s.direction() == detector.score_direction()
    };
    Method {
        direction: detector.score_direction(),
        is_probability: detector.gives_probability() || signal.is_some_and(|s| agrees(&*s.signal)),
    }
}

/// A tracker with a grid point of a method, and its measures.
pub(super) struct Row<'a> {
    /// Label of the tracker, or [`EVERY_TRACKER`].
    pub tracker: &'a str,
    /// One of its cells.
    pub first: &'a Cell,
    /// The measures.
    pub measures: FrameMeasures,
    /// The measures in bootstrap samples, of all trackers together.
    pub sampled: Sampled,
    /// Sequence and job of the tracks.
    pub tracks: Vec<(usize, usize)>,
}

/// The measures of all grid points of a tracker and method. Points whose scores are the same share what scores alone
/// determine.
fn of_method<'a>(
    experiment: &Experiment,
    outcome: &Outcome<'_>,
    (tracker, cells): (&'a str, &[&'a Cell]),
) -> Result<Vec<Row<'a>>, StoreError> {
    let mut rows = Vec::new();
    let mut last: Option<(Vec<Arc<DetectorOutput>>, FrameMeasures, Sampled)> = None;
    for cells in grouped(cells.iter().copied(), |cell| &cell.params) {
        let Some(first) = cells.first() else { continue };
        let judged = cells.iter().filter_map(|cell| Some((*cell, cell.result.as_ref().ok()?)));
        let outputs = judged.clone().map(|(cell, judged)| outcome.detector_output(cell, judged));
        let outputs = outputs.collect::<Result<Vec<_>, StoreError>>()?;
        let track = |((cell, judged), output): ((&Cell, &Judged), &'_ Arc<DetectorOutput>)| {
            let track = outcome.tracks.get(cell.sequence)?.get(cell.job)?.as_ref().ok()?;
            let error = restarts::counted_errors(&judged.pieces, &track.error);
            Some(((cell.sequence, cell.job), error, output.clone()))
        };
        let tracks: Vec<_> = judged.zip(&outputs).filter_map(track).collect();
        let names: Vec<(usize, usize)> = tracks.iter().map(|(name, ..)| *name).collect();
        // Sequences without a result are not drawn in bootstrap samples.
        let sequences: BTreeSet<usize> = names.iter().map(|(sequence, _)| *sequence).collect();
        let sequences: Vec<usize> = sequences.into_iter().collect();
        let tracks: Vec<ScoredTrack<'_>> = tracks
            .iter()
            .map(|((sequence, _), error, output)| ScoredTrack {
                sequence: sequences.partition_point(|s| s < sequence),
                error,
                score: &output.score,
                alarm: &output.alarm,
            })
            .collect();
        let same = |(before, ..): &&(Vec<Arc<DetectorOutput>>, FrameMeasures, Sampled)| {
            before.len() == outputs.len() && before.iter().zip(&outputs).all(|(a, b)| a.score == b.score)
        };
        let (scores, sampled) = match last.take().as_ref().filter(same) {
            Some((_, measures, sampled)) => (*measures, sampled.clone()),
            None => {
                let seed = seed::seed(experiment.seed, &["frame measures", tracker]);
                of_scores(&tracks, reading(experiment, &first.method, &first.params), Some(seed))
            }
        };
        let measures = with_alarms(scores, &tracks);
        let kept = if tracker == EVERY_TRACKER { sampled.clone() } else { Sampled::default() };
        rows.push(Row { tracker, first, measures, sampled: kept, tracks: names });
        last = Some((outputs, scores, sampled));
    }
    Ok(rows)
}

/// The measures of every tracker and method with each of its grid points.
///
/// # Errors
/// When a detection cannot be read from the store any more.
pub(super) fn measure<'a>(
    experiment: &Experiment,
    outcome: &'a Outcome<'_>,
) -> Result<Vec<Row<'a>>, StoreError> {
    let methods = grouped(outcome.cells.iter(), |cell| (&cell.tracker, &cell.method));
    let mut groups: Vec<(&str, Vec<&Cell>)> =
        methods.into_iter().filter_map(|cells| Some((cells.first()?.tracker.as_str(), cells))).collect();
    if experiment.leaderboard {
        let methods = grouped(outcome.cells.iter(), |cell| &cell.method);
        groups.extend(methods.into_iter().map(|cells| (EVERY_TRACKER, cells)));
    }
    let rows = groups
        .par_iter()
        .map(|(tracker, cells)| of_method(experiment, outcome, (tracker, cells)))
        .collect::<Result<Vec<_>, StoreError>>()?;
    Ok(rows.into_iter().flatten().collect())
}

/// Writes the file.
///
/// # Errors
/// When polars refuses.
pub(super) fn write(suite: &str, rows: &[Row<'_>]) -> Result<Vec<u8>, TableError> {
    let text = |f: fn(&Cell) -> &str| rows.iter().map(|row| f(row.first)).collect::<Vec<_>>();
    let mut columns = vec![
        SUITE.of(vec![suite; rows.len()]),
        TRACKER.of(rows.iter().map(|row| row.tracker).collect::<Vec<_>>()),
        METHOD.of(text(|c| &c.method)),
        PARAMS.of(rows.iter().map(|row| some_text(&row.first.params)).collect::<Vec<_>>()),
    ];
    for column in &FILE.columns[KEYS..] {
        columns
            .push(column.of_metric(rows.iter().map(|row| *field(&mut row.measures.clone(), column.name)?)));
    }
    to_csv(FILE.frame(columns)?)
}

/// Measures by tracker, method and grid point.
pub type ByMethod = BTreeMap<[String; 3], FrameMeasures>;

/// Reads the file.
///
/// # Errors
/// When the columns are not those of the file, or a number is damaged.
pub fn read(bytes: Vec<u8>) -> Result<ByMethod, TableError> {
    let rows = FILE.read_csv(bytes)?;
    let (tracker, method, params) = (rows.texts(&TRACKER)?, rows.texts(&METHOD)?, rows.texts(&PARAMS)?);
    let mut read = vec![FrameMeasures::default(); rows.len()];
    for column in &FILE.columns[KEYS..] {
        for (row, number) in read.iter_mut().zip(rows.numbers(column)?) {
            if let Some(field) = field(row, column.name) {
                *field = number;
            }
        }
    }
    let key = |i: usize| [tracker[i], method[i], params[i]].map(str::to_string);
    Ok(read.into_iter().enumerate().map(|(i, measures)| (key(i), measures)).collect())
}

/// Puts measures to the pooled numbers of the same tracker, method and grid point.
pub fn attach(by_method: &ByMethod, measures: &mut [Measure]) {
    for m in measures {
        let key = [&m.tracker, &m.method, &m.params].map(String::clone);
        m.pooled.frames = by_method.get(&key).copied();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_methods::score::metric::Source;
    use trackfail_methods::score::{METRICS, Metric};

    #[test]
    fn every_metric_of_frames_has_a_column_and_every_column_a_field() {
        for metric in METRICS.iter().filter(|m| m.source() == Source::Frames) {
            let column = FILE.columns.iter().find(|c| c.name == metric.name());
            assert!(column.is_some_and(|c| c.unit == metric.unit()), "{metric:?}");
        }
        for (k, column) in FILE.columns[KEYS..].iter().enumerate() {
            let mut measures = FrameMeasures::default();
            *field(&mut measures, column.name).unwrap() = Some(k as f64);
            for other in &FILE.columns[KEYS..] {
                let value = *field(&mut measures, other.name).unwrap();
                assert_eq!(value, (other == column).then_some(k as f64), "{}", column.name);
            }
            let metric = Metric::from_name(column.name);
            let pooled = trackfail_methods::score::Pooled { frames: Some(measures), ..Default::default() };
            assert!(metric.is_none_or(|m| m.value(&pooled) == Some(k as f64)), "{}", column.name);
        }
    }

    #[test]
    fn rows_go_to_the_methods_they_are_about() {
        let header: Vec<&str> = FILE.columns.iter().map(|c| c.name).collect();
        let empty = ",".repeat(header.len() - 8);
        let text = format!("{}\ns,t,b,x=1,9,3,1,0.25{empty}\ns,t,a,,9,3,1,{empty}\n", header.join(","));
        let measure = |method: &str, params: &str| Measure {
            tracker: "t".into(),
            method: method.into(),
            params: params.into(),
            attribute: None,
            pooled: trackfail_methods::score::Pooled::default(),
            done: 1,
            failed: 0,
            not_there: 0,
        };
        let mut measures = [measure("a", ""), measure("b", "x=1"), measure("b", "x=2")];
        attach(&read(text.clone().into_bytes()).unwrap(), &mut measures);
        let frames = measures.map(|m| m.pooled.frames.map(|f| (f.losses, f.auroc)));
        assert_eq!(frames, [Some((Some(1.0), None)), Some((Some(1.0), Some(0.25))), None]);
        assert!(read(text.replace("0.25", "x").into_bytes()).is_err());
    }
}
