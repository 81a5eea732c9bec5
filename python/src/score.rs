//! Protocols and measures over lists of numbers.

use crate::region::{origin, track};
use crate::{refused, threads};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use std::ops::Range;
use trackfail_judge::detector;
use trackfail_judge::direction::Direction;
use trackfail_judge::plugin::unknown;
use trackfail_judge::region::Region;
use trackfail_judge::score::frames::alarms::Losses;
use trackfail_judge::score::frames::list::{FRAME_METRICS, Of};
use trackfail_judge::score::frames::measures::{of_scores, with_alarms};
use trackfail_judge::score::frames::sweep::Sorted;
use trackfail_judge::score::frames::truth::Rule;
use trackfail_judge::score::frames::{Method, ScoredTrack};
use trackfail_judge::score::pooled::median_delay;
use trackfail_judge::score::{METRICS, PROTOCOLS, Pooled, overlap, protocol as protocol_of};

/// Names and values.
type Numbers = Vec<(String, Option<f64>)>;

/// The tracking error of each frame, NaN where there is no truth.
#[pyfunction]
pub fn errors<'py>(
    py: Python<'py>,
    boxes: &Bound<'py, PyAny>,
    truth: &Bound<'py, PyAny>,
    base: i64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let base = f64::from(origin(base)?);
    let (boxes, truth) = (track(boxes, "boxes", base)?, track(truth, "truth", base)?);
    if boxes.len() != truth.len() {
        return Err(refused(format!("boxes has {} frames, truth {}", boxes.len(), truth.len())));
    }
    let error = |(tracked, truth): (&Option<Region>, &Option<Region>)| match (tracked, truth) {
        (_, None) => f64::NAN,
        (Some(tracked), Some(truth)) => overlap::error(tracked, truth),
        (None, Some(_)) => 1.0,
    };
    let errors: Vec<f64> = boxes.iter().zip(&truth).map(error).collect();
    Ok(errors.into_pyarray(py))
}

/// Names of the protocols.
#[pyfunction]
pub fn protocols() -> Vec<&'static str> {
    PROTOCOLS.iter().map(|protocol| protocol.name).collect()
}

/// Counts (TP, FP, FN, TN), events, detections, matches, and the numbers that are made of them.
type Scored = ((u64, u64, u64, u64), Vec<usize>, Vec<usize>, Vec<(usize, usize)>, Numbers);

/// The score of labels on one track by a protocol; without changes those between the labels count. Pieces, of which each
/// has its first frame and the one after its last, are those that restarts of the tracker begin.
#[pyfunction]
pub fn score(
    labels: Vec<bool>,
    error: Vec<f64>,
    changes: Option<Vec<i32>>,
    pieces: Vec<(usize, usize)>,
    protocol: &str,
) -> PyResult<Scored> {
    let found = protocol_of(protocol).ok_or_else(|| refused(unknown("protocol", protocol, protocols())))?;
    let changes = changes.unwrap_or_else(|| detector::changes(&labels));
    let pieces: Vec<Range<usize>> = pieces.into_iter().map(|(start, end)| start..end).collect();
    let judged = found.judge(&error, &labels, &changes, &pieces);
    let pooled = Pooled {
        counts: judged.counts,
        chance: Some(found.chance),
        delay: median_delay(judged.delays().collect()),
        ..Pooled::default()
    };
    let of_counts = METRICS.iter().filter(|metric| metric.is_of_counts());
    let numbers = of_counts.map(|metric| (metric.name().to_string(), metric.value(&pooled))).collect();
    let counts = (judged.counts.tp, judged.counts.fp, judged.counts.fn_, judged.counts.tn);
    Ok((counts, judged.events, judged.detections, judged.matches, numbers))
}

/// Tracks of one sequence, without alarms.
fn tracks<'a>(error: &'a [Vec<f64>], scores: &'a [Vec<f64>]) -> Vec<ScoredTrack<'a>> {
    let all = error.iter().zip(scores);
    all.map(|(error, score)| ScoredTrack { sequence: 0, error, score, alarm: &[] }).collect()
}

/// Measures frame by frame, pooled over tracks; those of alarms only with labels, intervals only with a seed. `compared` has
/// what is compared with a threshold, if that is not the scores; `sequence` the index of each track's sequence.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn frame_measures(
    py: Python<'_>,
    error: Vec<Vec<f64>>,
    scores: Vec<Vec<f64>>,
    compared: Option<Vec<Vec<f64>>>,
    labels: Option<Vec<Vec<bool>>>,
    sequence: Vec<usize>,
    high_is_good: bool,
    is_probability: bool,
    seed: Option<u64>,
) -> PyResult<Numbers> {
    let direction = if high_is_good { Direction::HigherIsBetter } else { Direction::LowerIsBetter };
    let method = Method { direction, is_probability };
    let measures = threads::work(py, || {
        let mut tracks = tracks(&error, &scores);
        tracks.iter_mut().zip(&sequence).for_each(|(track, sequence)| track.sequence = *sequence);
        tracks.iter_mut().zip(labels.iter().flatten()).for_each(|(track, alarm)| track.alarm = alarm);
        let compared: Option<Vec<&[f64]>> =
            compared.as_ref().map(|of| of.iter().map(Vec::as_slice).collect());
        let (measures, _) = of_scores(&tracks, compared.as_deref(), method, seed);
        if labels.is_some() { with_alarms(measures, &tracks) } else { measures }
    })?;
    let known = FRAME_METRICS.iter().filter(|metric| labels.is_some() || matches!(metric.of, Of::Scores(_)));
    let columns = known.flat_map(|metric| {
        let name = metric.metric.name();
        let bounds = metric.bounds.filter(|_| seed.is_some());
        let bounds = bounds.map(|_| [format!("{name}_low"), format!("{name}_high")]);
        std::iter::once(name.to_string()).chain(bounds.into_iter().flatten())
    });
    let counts = ["good_frames", "lost_frames", "losses"].map(str::to_string);
    let all = counts.into_iter().chain(columns);
    let of = |name: String| {
        let value = measures.get(&name);
        (name, value)
    };
    Ok(all.map(of).collect())
}

/// Share of the losses that are found within a budget of false alarms per 1000 good frames.
#[pyfunction]
pub fn found_at(
    py: Python<'_>,
    error: Vec<Vec<f64>>,
    scores: Vec<Vec<f64>>,
    budget: f64,
    high_is_good: bool,
) -> PyResult<Option<f64>> {
    let sign = if high_is_good { -1.0 } else { 1.0 };
    let turned: Vec<Vec<f64>> =
        scores.into_iter().map(|scores| scores.into_iter().map(|score| sign * score).collect()).collect();
    threads::work(py, || {
        let tracks = tracks(&error, &turned);
        Losses::new(&tracks, &Sorted::new(&tracks).sweep(Rule::NoOverlap)).found(budget)
    })
}
