//! `frame_measures.csv`: measures of scores and alarms by frame, pooled over sequences and runs.

use super::cells::{Done, done, grouped};
use super::files::Measured;
use super::measures::Measure;
use super::rows::{Column, Field, Rows, TableError, group, integer, real, ungroup};
use polars::prelude::{Column as Values, DataFrame};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;
use trackfail_core::direction::Direction;
use trackfail_core::num::seed;
use trackfail_engine::spec::Experiment;
use trackfail_engine::store::StoreError;
use trackfail_engine::{Cell, Outcome};
use trackfail_methods::score::FrameMeasures;
use trackfail_methods::score::frames::list::FRAME_METRICS;
use trackfail_methods::score::frames::measures::{Sampled, of_scores, with_alarms};
use trackfail_methods::score::frames::{Method, ScoredTrack};
use trackfail_methods::score::restarts;

/// Columns of the counts and measures, each measure with its bounds after it.
pub(crate) static MEASURES: LazyLock<Vec<Column>> = LazyLock::new(|| {
    let mut columns = ["good_frames", "lost_frames", "losses"].map(integer).to_vec();
    for measure in FRAME_METRICS {
        let name = measure.metric.name();
        let mut all = vec![real(name)];
        if measure.bounds.is_some() {
            all.extend(["low", "high"].map(|end| real(format!("{name}_{end}").leak())));
        }
        columns.extend(all.into_iter().map(|column| Column { recent: measure.is_recent, ..column }));
    }
    columns
});

impl<'a> Field<'a> for FrameMeasures {
    fn write(columns: &[Column], values: Vec<Self>) -> Vec<Values> {
        group(columns, &values, |measures, k| measures.get(columns[k].name))
    }

    fn read(columns: &[Column], frame: &'a DataFrame) -> Result<Vec<Self>, TableError> {
        ungroup(columns, frame, |numbers| {
            let mut measures = Self::default();
            columns.iter().zip(numbers).for_each(|(column, number)| measures.set(column.name, *number));
            measures
        })
    }
}

/// Label that stands for all trackers together.
pub const EVERY_TRACKER: &str = "*";

/// Meaning of a method's scores at a grid point.
pub fn reading(experiment: &Experiment, method: &str, params: &str) -> Method {
    let mine = experiment.methods.iter().filter(|m| m.name == method).flat_map(|m| &m.variants);
    let variant = mine.into_iter().find(|v| v.params() == params);
    let facts = variant.map(|variant| variant.detector.example.detector.facts());
    let read = facts.map(|f| Method { direction: f.direction, is_probability: f.gives_probability });
    read.unwrap_or(Method { direction: Direction::LowerIsBetter, is_probability: false })
}

/// Measures of a tracker and a method at a grid point.
pub(super) struct Row<'a> {
    /// Label of the tracker, or of a pool of trackers (see [`pools`]).
    pub tracker: String,
    /// One of the cells of the row.
    pub first: &'a Cell,
    /// Measures over all cells of the row.
    pub measures: FrameMeasures,
    /// Measures in bootstrap samples; only for all trackers together.
    pub sampled: Sampled,
    /// Indices of sequence and job of each track.
    pub tracks: Vec<(usize, usize)>,
}

/// Measures of all grid points of a method on a tracker. Points with the same scores share the measures that
/// depend on scores alone.
fn of_method<'a>(
    experiment: &Experiment,
    outcome: &'a Outcome<'_>,
    (tracker, cells): (&str, &[&'a Cell]),
) -> Result<Vec<Row<'a>>, StoreError> {
    let mut rows = Vec::new();
    let mut last: Option<(Vec<Done<'_>>, FrameMeasures, Sampled)> = None;
    for (params, cells) in grouped(cells.iter().copied(), |cell| &cell.params) {
        let first = cells[0];
        let done = done(outcome, cells)?;
        let tracks: Vec<(usize, usize)> = done.iter().map(|one| (one.cell.sequence, one.cell.job)).collect();
        // Sequences without a result are not drawn in bootstrap samples.
        let sequences: BTreeSet<usize> = tracks.iter().map(|(sequence, _)| *sequence).collect();
        let sequences: Vec<usize> = sequences.into_iter().collect();
        let alarms: Vec<_> =
            done.iter().map(|one| restarts::counted_alarms(&one.judged.pieces, &one.output.alarm)).collect();
        let parts = || {
            done.iter().zip(&alarms).flat_map(|(one, alarm)| {
                let parts = restarts::parts(&one.judged.pieces, &one.track.error).into_iter();
                parts.map(move |part| (one, alarm, part))
            })
        };
        let scored = parts().map(|(one, alarm, part)| ScoredTrack {
            sequence: sequences.partition_point(|sequence| *sequence < one.cell.sequence),
            error: &one.track.error[part.clone()],
            score: &one.output.score[part.clone()],
            alarm: &alarm[part],
        });
        let scored: Vec<ScoredTrack<'_>> = scored.collect();
        let same = last.as_ref().filter(|(before, ..)| {
            let before = before.iter().map(|one| (&one.output.score, &one.output.alarm_score));
            before.eq(done.iter().map(|one| (&one.output.score, &one.output.alarm_score)))
        });
        let (scores, sampled) = match same {
            Some((_, measures, sampled)) => (*measures, sampled.clone()),
            None => {
                let seed = seed::seed(experiment.seed, &["frame measures", tracker]);
                let compared: Vec<&[f64]> =
                    parts().map(|(one, _, part)| &one.output.compared()[part]).collect();
                let differs = done.iter().any(|one| one.output.alarm_score.is_some());
                let reading = reading(experiment, &first.method, params);
                of_scores(&scored, differs.then_some(&compared[..]), reading, Some(seed))
            }
        };
        let measures = with_alarms(scores, &scored);
        let kept = if tracker == EVERY_TRACKER { sampled.clone() } else { Sampled::default() };
        rows.push(Row { tracker: tracker.to_string(), first, measures, sampled: kept, tracks });
        last = Some((done, scores, sampled));
    }
    Ok(rows)
}

/// Cells of a method by pool: all trackers, each family of trackers, each source of videos if there are
/// several, and combinations.
fn pools<'a>(
    experiment: &Experiment,
    outcome: &Outcome<'_>,
    cells: &[&'a Cell],
) -> Vec<(String, Vec<&'a Cell>)> {
    let sources: Vec<&String> = outcome.test().sequences.iter().map(|s| &s.sequence.origin.source).collect();
    let several = sources.iter().any(|source| *source != sources[0]);
    let mut pools: BTreeMap<String, Vec<&Cell>> = BTreeMap::new();
    for cell in cells {
        let source = sources.get(cell.sequence).filter(|_| several);
        let source = source.map_or(String::new(), |source| format!(" on {source}"));
        let tracker = experiment.trackers.iter().find(|tracker| tracker.label == cell.tracker);
        let family = tracker.and_then(|tracker| tracker.family.as_ref());
        let family = family.map_or(String::new(), |family| format!(" {family}"));
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

/// Measures of all trackers and methods with each grid point.
///
/// # Errors
/// When a detector output can no longer be read from the store.
pub(super) fn measure<'a>(
    experiment: &Experiment,
    outcome: &'a Outcome<'_>,
) -> Result<Vec<Row<'a>>, StoreError> {
    let methods = grouped(&outcome.cells, |cell| (&cell.tracker, &cell.method));
    let mut groups: Vec<(String, Vec<&Cell>)> =
        methods.into_iter().map(|((tracker, _), cells)| (tracker.clone(), cells)).collect();
    if experiment.leaderboard {
        let methods = grouped(&outcome.cells, |cell| &cell.method);
        groups.extend(methods.into_iter().flat_map(|(_, cells)| pools(experiment, outcome, &cells)));
    }
    let rows = groups.par_iter().map(|(tracker, cells)| of_method(experiment, outcome, (tracker, cells)));
    let rows = rows.collect::<Result<Vec<_>, StoreError>>()?;
    Ok(rows.into_iter().flatten().collect())
}

/// Measures by tracker, method and grid point.
pub type ByMethod = BTreeMap<[String; 3], FrameMeasures>;

/// Reads the file.
///
/// # Errors
/// When the columns are not those of the file, or a number is damaged.
pub fn read(bytes: Vec<u8>) -> Result<ByMethod, TableError> {
    let frame = Measured::read(bytes)?;
    let names = |row: &Measured<'_>| <[&str; 3]>::from(row.of).map(str::to_string);
    Ok(Measured::rows(&frame)?.into_iter().map(|row| (names(&row), row.measures)).collect())
}

/// Adds measures to the pooled numbers of the same tracker, method and grid point.
pub fn attach(by_method: &ByMethod, measures: &mut [Measure]) {
    for m in measures {
        let key = [&m.tracker, &m.method, &m.params].map(String::clone);
        m.pooled.frames = by_method.get(&key).copied();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::measure;
    use trackfail_methods::score::metric::Source;
    use trackfail_methods::score::{METRICS, Metric};

    #[test]
    fn every_metric_of_frames_has_a_column_and_every_column_a_field() {
        for metric in METRICS.iter().filter(|m| m.source == Source::Frames) {
            assert!(MEASURES.iter().any(|column| column.name == metric.name()), "{metric:?}");
        }
        for (k, column) in MEASURES.iter().enumerate() {
            let mut measures = FrameMeasures::default();
            measures.set(column.name, Some(k as f64));
            for other in MEASURES.iter() {
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
        let header: Vec<&str> = Measured::columns().iter().map(|c| c.name).collect();
        let empty = ",".repeat(header.len() - 8);
        let text = format!("{}\ns,t,b,x=1,9,3,1,0.25{empty}\ns,t,a,,9,3,1,{empty}\n", header.join(","));
        let mut measures = [("a", ""), ("b", "x=1"), ("b", "x=2")].map(|(m, params)| measure("t", m, params));
        attach(&read(text.clone().into_bytes()).unwrap(), &mut measures);
        let frames = measures.map(|m| m.pooled.frames.map(|f| (f.get("losses"), f.get("auroc"))));
        assert_eq!(frames, [Some((Some(1.0), None)), Some((Some(1.0), Some(0.25))), None]);
        assert!(read(text.replace("0.25", "x").into_bytes()).is_err());
    }
}
