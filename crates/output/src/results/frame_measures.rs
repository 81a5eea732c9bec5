//! `frame_measures.csv`: measures of scores and alarms frame by frame, pooled over sequences and runs.

use super::cells::{grouped, some_text};
use super::column::{Column, METHOD, PARAMS, SUITE, TRACKER, TableFile};
use super::frame::TableError;
use super::measures::Measure;
use polars::prelude::DataFrame;
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
use trackfail_methods::score::frames::list::{Bounds, FRAME_METRICS, FrameMetric};
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

/// Columns that say which row it is, and those of its counts.
const HEAD: [Column; 7] = [
    SUITE,
    Column {
        meaning: "Label of the tracker; in experiments of the leaderboard also `*` for all of them, `* FAMILY` for those of a \
                  family, `* on SOURCE` for all on a source of videos, `* FAMILY on SOURCE`",
        ..TRACKER
    },
    METHOD,
    PARAMS,
    GOOD_FRAMES,
    LOST_FRAMES,
    LOSSES,
];

/// Number of columns.
const COLUMNS: usize = {
    let (mut count, mut k) = (HEAD.len() + FRAME_METRICS.len(), 0);
    while k < FRAME_METRICS.len() {
        count += if FRAME_METRICS[k].bounds.is_some() { 2 } else { 0 };
        k += 1;
    }
    count
};

/// All columns: those of the list of measures, each with its bounds behind it.
const ALL: [Column; COLUMNS] = {
    let mut all = [SUITE; COLUMNS];
    let (mut n, mut k) = (0, 0);
    while n < HEAD.len() {
        all[n] = HEAD[n];
        n += 1;
    }
    while k < FRAME_METRICS.len() {
        let FrameMetric { name, unit, meaning, is_recent, bounds, .. } = FRAME_METRICS[k];
        all[n] = Column::real(name, unit, meaning).empty(NOT_KNOWN);
        all[n].recent = is_recent;
        n += 1;
        if let Some(Bounds { names: [low, high], .. }) = bounds {
            all[n] = Column::real(low, unit, "Lower bound of the measure before it").empty(NO_INTERVAL);
            all[n + 1] = Column::real(high, unit, "Upper bound of the same").empty(NO_INTERVAL);
            all[n].recent = is_recent;
            all[n + 1].recent = is_recent;
            n += 2;
        }
        k += 1;
    }
    all
};

/// The file.
pub const FILE: TableFile = TableFile {
    name: "frame_measures.csv",
    about: "One row for each tracker and method (with its grid point), as in measures.csv: how well the method's score and \
            its alarms tell lost frames from good ones, frame by frame, all frames together. Bounds are those of a 95 % \
            bootstrap interval over sequences. Runs of earlier versions have no such file.",
    columns: &ALL,
};

/// Columns that say which row it is.
const KEYS: usize = 4;

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
    /// Label of the tracker or of a pool, see [`pools`].
    pub tracker: String,
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
    (tracker, cells): (&str, &[&'a Cell]),
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
        let tracks_of: Vec<_> = judged.zip(&outputs).filter_map(track).collect();
        let names: Vec<(usize, usize)> = tracks_of.iter().map(|(name, ..)| *name).collect();
        // Sequences without a result are not drawn in bootstrap samples.
        let sequences: BTreeSet<usize> = names.iter().map(|(sequence, _)| *sequence).collect();
        let sequences: Vec<usize> = sequences.into_iter().collect();
        let tracks: Vec<ScoredTrack<'_>> = tracks_of
            .iter()
            .map(|((sequence, _), error, output)| ScoredTrack {
                sequence: sequences.partition_point(|s| s < sequence),
                error,
                score: &output.score,
                alarm: &output.alarm,
            })
            .collect();
        let same = |(before, ..): &&(Vec<Arc<DetectorOutput>>, FrameMeasures, Sampled)| {
            let equal = |(a, b): (&Arc<DetectorOutput>, &Arc<DetectorOutput>)| {
                a.score == b.score && a.alarm_score == b.alarm_score
            };
            before.len() == outputs.len() && before.iter().zip(&outputs).all(equal)
        };
        let (scores, sampled) = match last.take().as_ref().filter(same) {
            Some((_, measures, sampled)) => (*measures, sampled.clone()),
            None => {
                let seed = seed::seed(experiment.seed, &["frame measures", tracker]);
                let compared: Vec<&[f64]> = tracks_of.iter().map(|(.., output)| output.compared()).collect();
                let differs = tracks_of.iter().any(|(.., output)| output.alarm_score.is_some());
                let reading = reading(experiment, &first.method, &first.params);
                of_scores(&tracks, differs.then_some(&compared[..]), reading, Some(seed))
            }
        };
        let measures = with_alarms(scores, &tracks);
        let kept = if tracker == EVERY_TRACKER { sampled.clone() } else { Sampled::default() };
        rows.push(Row { tracker: tracker.to_string(), first, measures, sampled: kept, tracks: names });
        last = Some((outputs, scores, sampled));
    }
    Ok(rows)
}

/// Cells of a method by pool: those of all trackers, of each family of trackers, on each source of videos where there
/// are several, and of both.
fn pools<'a>(
    experiment: &Experiment,
    outcome: &Outcome<'_>,
    cells: &[&'a Cell],
) -> Vec<(String, Vec<&'a Cell>)> {
    let family = |cell: &Cell| {
        let tracker = experiment.trackers.iter().find(|tracker| tracker.label == cell.tracker);
        tracker.and_then(|tracker| tracker.family.as_deref())
    };
    let several = outcome.sources.iter().any(|source| Some(source) != outcome.sources.first());
    let mut pools: BTreeMap<String, Vec<&Cell>> = BTreeMap::new();
    for cell in cells {
        let source = outcome.sources.get(cell.sequence).filter(|_| several);
        let source = source.map_or(String::new(), |source| format!(" on {source}"));
        let family = family(cell).map_or(String::new(), |family| format!(" {family}"));
        let names = [String::new(), family.clone(), source.clone(), format!("{family}{source}")];
        for name in names.into_iter().collect::<BTreeSet<_>>() {
            pools.entry(format!("{EVERY_TRACKER}{name}")).or_default().push(cell);
        }
    }
    // A family on one of its sources is no pool of its own where the family, or the source, has no other tracks.
    let sizes: BTreeMap<String, usize> =
        pools.iter().map(|(name, cells)| (name.clone(), cells.len())).collect();
    let is_larger = |whole: &str, part: usize| sizes.get(whole).is_none_or(|size| *size > part);
    pools.retain(|name, cells| match name.rsplit_once(" on ") {
        Some((family, source)) if family != EVERY_TRACKER => {
            is_larger(family, cells.len()) && is_larger(&format!("{EVERY_TRACKER} on {source}"), cells.len())
        }
        _ => true,
    });
    pools.into_iter().collect()
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
    let mut groups: Vec<(String, Vec<&Cell>)> =
        methods.into_iter().filter_map(|cells| Some((cells.first()?.tracker.clone(), cells))).collect();
    if experiment.leaderboard {
        let methods = grouped(outcome.cells.iter(), |cell| &cell.method);
        groups.extend(methods.into_iter().flat_map(|cells| pools(experiment, outcome, &cells)));
    }
    let rows = groups
        .par_iter()
        .map(|(tracker, cells)| of_method(experiment, outcome, (tracker, cells)))
        .collect::<Result<Vec<_>, StoreError>>()?;
    Ok(rows.into_iter().flatten().collect())
}

/// The rows of the file.
///
/// # Errors
/// When polars refuses.
pub(super) fn frame(suite: &str, rows: &[Row<'_>]) -> Result<DataFrame, TableError> {
    let text = |f: fn(&Cell) -> &str| rows.iter().map(|row| f(row.first)).collect::<Vec<_>>();
    let mut columns = vec![
        SUITE.of(vec![suite; rows.len()]),
        TRACKER.of(rows.iter().map(|row| row.tracker.as_str()).collect::<Vec<_>>()),
        METHOD.of(text(|c| &c.method)),
        PARAMS.of(rows.iter().map(|row| some_text(&row.first.params)).collect::<Vec<_>>()),
    ];
    for column in &FILE.columns[KEYS..] {
        columns.push(column.of_metric(rows.iter().map(|row| row.measures.get(column.name))));
    }
    FILE.frame(columns)
}

/// Measures by tracker, method and grid point.
pub type ByMethod = BTreeMap<[String; 3], FrameMeasures>;

/// Reads the file.
///
/// # Errors
/// When the columns are not those of the file, or a number is damaged.
pub fn read(bytes: Vec<u8>) -> Result<ByMethod, TableError> {
    let rows = FILE.read(bytes)?;
    let (tracker, method, params) = (rows.texts(&TRACKER)?, rows.texts(&METHOD)?, rows.texts(&PARAMS)?);
    let mut read = vec![FrameMeasures::default(); rows.len()];
    for column in &FILE.columns[KEYS..] {
        for (row, number) in read.iter_mut().zip(rows.numbers(column)?) {
            row.set(column.name, number);
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
            measures.set(column.name, Some(k as f64));
            for other in &FILE.columns[KEYS..] {
                let value = measures.get(other.name);
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
        let frames = measures.map(|m| m.pooled.frames.map(|f| (f.losses, f.get("auroc"))));
        assert_eq!(frames, [Some((Some(1.0), None)), Some((Some(1.0), Some(0.25))), None]);
        assert!(read(text.replace("0.25", "x").into_bytes()).is_err());
    }
}
