//! Traces a number of a table to the sequences that it comes from, from results alone.
//!
//! Measures are computed from counts summed over sequences, so a single sequence has no share in a ratio. Its
//! contribution is defined as `m - m(without the sequence)`; for a count this is the sequence's count.

mod links;
pub mod listing;
pub mod select;

pub use links::link;

use super::trace::{self, Trace};
use crate::results::frame_measures::reading;
use crate::results::{CellScore, Results, ResultsError};
use crate::table::layout::Origin;
use std::collections::BTreeMap;
use std::ops::Range;
use trackfail_methods::score::frames::{self, ScoredTrack};
use trackfail_methods::score::metric::Source;
use trackfail_methods::score::pooled::{median_delay, normalized_mean_std};
use trackfail_methods::score::restarts;
use trackfail_methods::score::{Counts, Metric, Pooled, Protocol, TrackScore};

/// Formula of a metric with the counts filled in, in one line.
fn formula(metric: Metric, counts: Counts, protocol: Option<&Protocol>) -> String {
    metric.filled(&Pooled { counts, chance: protocol.map(|p| p.chance), ..Pooled::default() })
}

/// A number of a table with the contributions of sequences.
pub struct Explained {
    /// Place of the number: table, tracker, method and metric.
    pub of: Origin,
    /// The number as in the table.
    pub value: Option<f64>,
    /// Formula of the number with the counts filled in.
    pub formula: String,
    /// Protocol by which the number is counted.
    pub protocol: Option<&'static Protocol>,
    /// Contributions of the sequences, the largest first.
    pub parts: Vec<Part>,
    /// Cells without a result that the number lacks: sequence, run and reason.
    pub failed: Vec<(String, u32, String)>,
}

/// Contribution of one sequence to a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Name of the sequence.
    pub sequence: String,
    /// Number of runs on the sequence.
    pub runs: usize,
    /// Counts on the sequence.
    pub counts: Counts,
    /// The measure on this sequence alone.
    pub alone: Option<f64>,
    /// The measure on all other sequences.
    pub without: Option<f64>,
    /// Contribution: the measure on all sequences minus that on the others.
    pub moves: Option<f64>,
}

/// Data of one sequence behind a pooled number.
#[derive(Default)]
struct SequenceShare {
    runs: usize,
    counts: Counts,
    /// Tracks, with the parts of each that count, and without the alarms that do not.
    tracks: Vec<(Trace, Vec<Range<usize>>)>,
    /// Scores of the frames that count, for each track.
    scores: Vec<Vec<f64>>,
    delays: Vec<i64>,
}

impl SequenceShare {
    fn add(&mut self, mut trace: Trace, protocol: Option<&Protocol>) {
        self.delays.extend(protocol.map(|p| trace.judge(p)).iter().flat_map(TrackScore::delays));
        let pieces = protocol.map(|p| p.restarts.apart(&trace.track.pieces)).unwrap_or_default();
        self.scores.push(restarts::counted(pieces, &trace.method.score).into_owned());
        let parts = restarts::parts(pieces, &trace.track.error);
        trace.method.alarm = restarts::counted_alarms(pieces, &trace.method.alarm).into_owned();
        self.tracks.push((trace, parts));
    }
}

/// Traces a number to sequences; `scores` come from [`Results::scores`].
///
/// # Errors
/// When the frames are needed and cannot be read.
pub fn explain(results: &Results, scores: &[CellScore], of: &Origin) -> Result<Explained, ResultsError> {
    let mut shares: BTreeMap<String, SequenceShare> = BTreeMap::new();
    let attributes = &results.manifest.suite.attributes;
    let concerns = |sequence: &str| {
        let own = attributes.get(sequence);
        of.attribute.as_ref().is_none_or(|a| own.is_some_and(|own| own.contains(a)))
    };
    let is_mine = |tracker: &str, method: &str, params: &str| {
        (tracker, method, params) == (of.tracker.as_str(), of.method.as_str(), of.params.as_str())
    };
    for score in scores.iter().filter(|s| is_mine(&s.tracker, &s.method, &s.params) && concerns(&s.sequence))
    {
        let part = shares.entry(score.sequence.clone()).or_default();
        part.runs += 1;
        part.counts = [part.counts, score.counts].into_iter().sum();
    }
    let protocol = results.experiment.protocol_of(&of.method);
    if matches!(of.metric.source, Source::Scores | Source::Delays | Source::Frames) {
        for trace in trace::read(results, &of.tracker, &of.label(), None)? {
            if let Some(share) = shares.get_mut(&trace.track.sequence) {
                share.add(trace, protocol);
            }
        }
    }
    let method = reading(&results.experiment, &of.method, &of.params);
    let pooled = |shares: &[&SequenceShare]| pooled(shares, protocol, method, of.metric);
    let all: Vec<&SequenceShare> = shares.values().collect();
    let value = match of.attribute {
        None => {
            let measure = results.measures.iter().find(|m| is_mine(&m.tracker, &m.method, &m.params));
            measure.and_then(|m| m.value(of.metric))
        }
        Some(_) => pooled(&all),
    };
    let part = |(k, (sequence, part)): (usize, (&String, &SequenceShare))| {
        let without = pooled(&[&all[..k], &all[k + 1..]].concat());
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
    // A sequence without which there is no number moves it most. The sort is stable: equal ones stay in order of name.
    let moves = |p: &Part| p.moves.map_or(f64::INFINITY, f64::abs);
    let counted = |p: &Part| p.counts.tp + p.counts.fp + p.counts.fn_;
    parts.sort_by(|a, b| moves(b).total_cmp(&moves(a)).then(counted(b).cmp(&counted(a))));
    let label = of.label();
    let failed = results.cells_failed();
    let failed = failed.filter(|c| c.tracker == of.tracker && c.method == label && concerns(&c.sequence));
    Ok(Explained {
        of: of.clone(),
        value,
        formula: formula(of.metric, of.counts, protocol),
        protocol,
        parts,
        failed: failed.map(|c| (c.sequence.clone(), c.run, c.reason.clone())).collect(),
    })
}

/// A metric pooled over some sequences.
fn pooled(
    shares: &[&SequenceShare],
    protocol: Option<&Protocol>,
    method: frames::Method,
    metric: Metric,
) -> Option<f64> {
    // Results do not say which sequence a run backwards belongs to.
    if shares.is_empty() || metric.source == Source::Effort {
        return None;
    }
    let counts = shares.iter().map(|g| g.counts).sum();
    let score = normalized_mean_std(shares.iter().flat_map(|g| &g.scores));
    let delay = median_delay(shares.iter().flat_map(|g| g.delays.iter().copied()).collect());
    let frames = metric.is_of_frames().then(|| {
        let (mut tracks, mut compared, mut differs) = (Vec::new(), Vec::new(), false);
        for (sequence, share) in shares.iter().enumerate() {
            for (Trace { track, method }, parts) in &share.tracks {
                for part in parts {
                    let (score, alarm) = (&method.score[part.clone()], &method.alarm[part.clone()]);
                    tracks.push(ScoredTrack { sequence, error: &track.error[part.clone()], score, alarm });
                    compared.push(&method.compared()[part.clone()]);
                    differs |= !method.alarm_score.is_empty();
                }
            }
        }
        frames::measure(&tracks, differs.then_some(&compared[..]), method, None)
    });
    let chance = protocol.map(|p| p.chance);
    metric.value(&Pooled { counts, score, delay, chance, frames, ..Pooled::default() })
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
