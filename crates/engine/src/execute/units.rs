//! Units of work: the jobs of one sequence that run in one pass.

use super::context::Options;
use crate::plan::{ExperimentPlan, Shard};
use crate::store::Store;
use rayon::prelude::*;

/// Work on one sequence: indices of the suite, the sequence and the jobs.
pub type Unit = (usize, usize, Vec<usize>);

/// Every sequence with its jobs, or with those of a shard. The longest sequences come first, so that no core works on
/// a long one alone in the end.
pub fn units(plan: &ExperimentPlan<'_>, shard: Option<Shard>) -> Vec<Unit> {
    let sequences = plan.suites.iter().enumerate();
    let all: Vec<(usize, usize, usize)> = sequences
        .flat_map(|(suite, s)| (0..s.sequences.len()).map(move |sequence| (suite, sequence)))
        .flat_map(|(suite, sequence)| (0..plan.jobs.len()).map(move |job| (suite, sequence, job)))
        .filter(|(suite, _, job)| plan.wants(*suite, *job))
        .collect();
    let frames = |(suite, sequence, _): &(usize, usize, usize)| {
        plan.suites[*suite].sequences[*sequence].sequence.len() as u64
    };
    // Signals that read the tracks of other trackers need all jobs of a sequence in one place.
    let pieces: Vec<&[(usize, usize, usize)]> = if plan.reads_companions() {
        all.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).collect()
    } else {
        all.chunks(1).collect()
    };
    let cost = |piece: &&[(usize, usize, usize)]| piece.iter().map(frames).sum();
    let mine = shard.map(|shard| shard.of(&pieces.iter().map(cost).collect::<Vec<u64>>()));
    let mut units: Vec<Unit> = Vec::new();
    for (k, piece) in pieces.into_iter().enumerate() {
        if mine.as_ref().is_some_and(|mine| !mine[k]) {
            continue;
        }
        for &(suite, sequence, job) in piece {
            match units.last_mut() {
                Some((s, q, jobs)) if (*s, *q) == (suite, sequence) => jobs.push(job),
                _ => units.push((suite, sequence, vec![job])),
            }
        }
    }
    units.sort_by_key(|(suite, sequence, _)| std::cmp::Reverse(frames(&(*suite, *sequence, 0))));
    units
}

/// Number of frames in the sequences with tracks or signals that the store lacks.
pub fn frames_to_do(plan: &ExperimentPlan<'_>, store: &Store, options: &Options, units: &[Unit]) -> u64 {
    let of_unit = |(suite, sequence, jobs): &Unit| {
        let planned = &plan.suites[*suite].sequences[*sequence];
        let is_needed = |j: usize| options.force || !plan.is_cached(store, *suite, planned, j);
        let to_do = jobs.iter().any(|j| planned.tracks[*j].is_ok() && is_needed(*j));
        if to_do { planned.sequence.len() as u64 } else { 0 }
    };
    units.par_iter().map(of_unit).sum()
}
