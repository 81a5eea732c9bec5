//! Takes a number of a table apart into the sequences it comes from, from results alone.
//!
//! Measures are computed from counts that are summed over sequences, so a sequence has no share of its own in a ratio.
//! Its contribution is the change of the measure without it: `m - m(without it)`, which for a count is the sequence's
//! count.

pub mod listing;
mod origins;
pub mod select;

pub use origins::{CellOrigin, TableOrigins, origins};

use super::trace::{self, Trace};
use crate::results::frame_measures::reading;
use crate::results::{CellScore, method_label};
use crate::results::{Results, ResultsError};
use crate::table::layout::CellRef;
use std::collections::BTreeMap;
use trackfail_methods::score::frames::{self, ScoredTrack};
use trackfail_methods::score::metric::Source;
use trackfail_methods::score::pooled::{median_delay, normalized_mean_std};
use trackfail_methods::score::restarts;
use trackfail_methods::score::{Counts, Metric, Pooled, Protocol, TrackScore};

/// How a metric comes about, with the counts filled in, in a line.
fn formula(metric: Metric, counts: Counts, protocol: Option<&Protocol>) -> String {
    metric.filled(&Pooled { counts, chance: protocol.map(|p| p.chance), ..Pooled::default() })
}

/// A number of a table and its parts.
pub struct Explained {
    /// Which it is.
    pub spot: CellRef,
    /// The number as the table has it.
    pub value: Option<f64>,
    /// Counts over all sequences and runs.
    pub counts: Counts,
    /// How the number comes about, with the counts filled in.
    pub formula: String,
    /// The protocol that counts.
    pub protocol: Option<&'static Protocol>,
    /// The sequences, those that move the number most first.
    pub parts: Vec<Part>,
    /// Cells behind the number without a result: sequence, run and reason.
    pub failed: Vec<(String, u32, String)>,
}

/// The part of a sequence in a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// The sequence.
    pub sequence: String,
    /// Number of runs on it.
    pub runs: usize,
    /// Counts on it.
    pub counts: Counts,
    /// The measure on this sequence alone.
    pub alone: Option<f64>,
    /// The measure on all the others.
    pub without: Option<f64>,
    /// The measure on all sequences minus that on the others.
    pub moves: Option<f64>,
}

/// The share of one sequence in a pooled number.
#[derive(Default)]
struct SequenceShare {
    runs: usize,
    counts: Counts,
    /// Tracks, with the errors of frames that do not count unknown.
    tracks: Vec<Trace>,
    /// Scores of the frames that count, of each track.
    scores: Vec<Vec<f64>>,
    delays: Vec<i64>,
}

impl SequenceShare {
    fn add(&mut self, mut track: Trace, protocol: Option<&Protocol>) {
        self.delays.extend(protocol.map(|p| track.judge(p)).iter().flat_map(TrackScore::delays));
        let pieces = protocol.map(|p| p.restarts.apart(&track.pieces)).unwrap_or_default();
        self.scores.push(restarts::counted(pieces, &track.score).into_owned());
        track.error = restarts::counted_errors(pieces, &track.error).into_owned();
        self.tracks.push(track);
    }
}

/// Explains one number; `scores` are those of [`Results::scores`].
///
/// # Errors
/// When the frames are needed and cannot be read.
pub fn explain(results: &Results, scores: &[CellScore], spot: &CellRef) -> Result<Explained, ResultsError> {
    let label = method_label(&spot.method, &spot.params);
    let mut shares: BTreeMap<String, SequenceShare> = BTreeMap::new();
    let mine =
        |s: &&CellScore| s.tracker == spot.tracker && s.method == spot.method && s.params == spot.params;
    let attributes = &results.manifest.suite.attributes;
    let concerned = |sequence: &str| {
        let own = attributes.get(sequence);
        spot.attribute.as_ref().is_none_or(|a| own.is_some_and(|own| own.contains(a)))
    };
    for score in scores.iter().filter(mine).filter(|s| concerned(&s.sequence)) {
        let part = shares.entry(score.sequence.clone()).or_default();
        part.runs += 1;
        part.counts = [part.counts, score.counts].into_iter().sum();
    }
    let protocol = results.experiment.protocol_of(&spot.method);
    if matches!(spot.metric.source(), Source::Scores | Source::Delays | Source::Frames) {
        for track in trace::read(results, &spot.tracker, &label, None)? {
            if let Some(share) = shares.get_mut(&track.sequence) {
                share.add(track, protocol);
            }
        }
    }
    let measure = results
        .measures
        .iter()
        .find(|m| m.tracker == spot.tracker && m.method == spot.method && m.params == spot.params);
    let method = reading(&results.experiment, &spot.method, &spot.params);
    let pooled = |shares: &[&SequenceShare]| pooled(shares, protocol, method, spot.metric);
    let all: Vec<&SequenceShare> = shares.values().collect();
    let value = match spot.attribute {
        None => measure.and_then(|m| m.value(spot.metric)),
        Some(_) => pooled(&all),
    };
    let part = |(k, (sequence, part)): (usize, (&String, &SequenceShare))| {
        let others: Vec<&SequenceShare> =
            all.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, g)| *g).collect();
        let without = pooled(&others);
        Part {
            sequence: sequence.clone(),
            runs: part.runs,
            counts: part.counts,
            alone: pooled(&[part]),
            without,
            moves: value.zip(without).map(|(all, others)| all - others),
        }
    };
    let mut parts: Vec<Part> = shares.iter().enumerate().map(part).collect();
    let weight = |p: &Part| {
        let counted = p.counts.tp + p.counts.fp + p.counts.fn_;
        (p.moves.map_or(f64::INFINITY, f64::abs), counted)
    };
    // A sequence without which there is no number moves it most. The sort is stable: equal ones stay in order of name.
    parts.sort_by(|a, b| {
        let (a, b) = (weight(a), weight(b));
        b.0.total_cmp(&a.0).then(b.1.cmp(&a.1))
    });
    let failed = results.manifest.cells_failed.iter();
    let failed = failed.filter(|c| c.tracker == spot.tracker && c.method == label && concerned(&c.sequence));
    let counts = all.iter().map(|g| g.counts).sum();
    Ok(Explained {
        spot: spot.clone(),
        value,
        counts,
        formula: formula(spot.metric, counts, protocol),
        protocol,
        parts,
        failed: failed.map(|c| (c.sequence.clone(), c.run, c.reason.clone())).collect(),
    })
}

/// A metric of some sequences together.
fn pooled(
    shares: &[&SequenceShare],
    protocol: Option<&Protocol>,
    method: frames::Method,
    metric: Metric,
) -> Option<f64> {
    // Results do not say which sequence a run backwards belongs to.
    if shares.is_empty() || metric.source() == Source::Effort {
        return None;
    }
    let counts = shares.iter().map(|g| g.counts).sum();
    let score = normalized_mean_std(shares.iter().flat_map(|g| &g.scores));
    let delay = median_delay(shares.iter().flat_map(|g| g.delays.iter().copied()).collect());
    let frames = metric.is_of_frames().then(|| {
        let compared: Vec<&[f64]> = shares.iter().flat_map(|s| &s.tracks).map(Trace::compared).collect();
        let differs = shares.iter().flat_map(|s| &s.tracks).any(|trace| !trace.alarm_score.is_empty());
        frames::measure(&tracks(shares), differs.then_some(&compared[..]), method, None)
    });
    let chance = protocol.map(|p| p.chance);
    metric.value(&Pooled { counts, score, delay, chance, frames, ..Pooled::default() })
}

/// The tracks of some sequences.
fn tracks<'a>(shares: &[&'a SequenceShare]) -> Vec<ScoredTrack<'a>> {
    let of_sequence = |(sequence, share): (usize, &&'a SequenceShare)| {
        let track =
            move |t: &'a Trace| ScoredTrack { sequence, error: &t.error, score: &t.score, alarm: &t.alarm };
        share.tracks.iter().map(track)
    };
    shares.iter().enumerate().flat_map(of_sequence).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_core::direction::Direction;

    // By hand: F of (2, 1, 0) and (0, 1, 2) together is 4 / (4 + 2 + 2); F of the first alone 4 / 5.
    #[test]
    fn pools_counts_and_never_ratios() {
        let given =
            |tp, fp, fn_| SequenceShare { counts: Counts { tp, fp, fn_, tn: 9 }, ..SequenceShare::default() };
        let (a, b) = (given(2, 1, 0), given(0, 1, 2));
        let method = frames::Method { direction: Direction::LowerIsBetter, is_probability: false };
        let of = |shares: &[&SequenceShare], metric| pooled(shares, None, method, metric);
        assert_eq!(of(&[&a, &b], Metric::F_SCORE), Some(0.5));
        assert_eq!(of(&[&a], Metric::F_SCORE), Some(0.8));
        assert_eq!(of(&[], Metric::F_SCORE), None);
        assert_eq!(of(&[&a], Metric::REVERSE_RUNS), None);
    }
}
