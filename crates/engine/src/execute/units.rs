//! Units of work: jobs on one sequence that run in one pass.

use crate::error::RunError;
use crate::plan::{ExperimentPlan, Shard};
use crate::store::Store;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Work on one sequence: indices of the suite, the sequence and the jobs.
pub type Unit = (usize, usize, Vec<usize>);

/// Units of a run or of a shard: each sequence with its jobs. Long sequences come first, so that no core
/// works on one alone at the end.
pub fn units(plan: &ExperimentPlan<'_>, shard: Option<Shard>) -> Vec<Unit> {
    let frames = |unit: &Unit| plan.suites[unit.0].sequences[unit.1].sequence.len() as u64;
    let mut pieces: Vec<Unit> = Vec::new();
    for (suite, planned) in plan.suites.iter().enumerate() {
        let jobs: Vec<usize> = (0..plan.jobs.len()).filter(|job| plan.wants(suite, *job)).collect();
        // Signals that read the tracks of other trackers need all jobs of a sequence in one place.
        let size = if shard.is_none() || plan.reads_companions() { jobs.len() } else { 1 };
        for sequence in 0..planned.sequences.len() {
            pieces.extend(jobs.chunks(size.max(1)).map(|jobs| (suite, sequence, jobs.to_vec())));
        }
    }
    if let Some(shard) = shard {
        let costs: Vec<u64> = pieces.iter().map(|unit| frames(unit) * unit.2.len() as u64).collect();
        let mut is_mine = shard.of(&costs).into_iter();
        pieces.retain(|_| is_mine.next().unwrap_or(false));
    }
    let mut units: Vec<Unit> = Vec::new();
    for (suite, sequence, jobs) in pieces {
        match units.last_mut() {
            Some(last) if (last.0, last.1) == (suite, sequence) => last.2.extend(jobs),
            _ => units.push((suite, sequence, jobs)),
        }
    }
    units.sort_by_key(|unit| std::cmp::Reverse(frames(unit)));
    units
}

/// Number of frames in the sequences with tracks or signals that the store lacks.
pub fn frames_to_do(plan: &ExperimentPlan<'_>, store: &Store, force: bool, units: &[Unit]) -> u64 {
    let of_unit = |(suite, sequence, jobs): &Unit| {
        let planned = &plan.suites[*suite].sequences[*sequence];
        let is_needed = |j: usize| force || !plan.is_cached(store, planned, j);
        let to_do = jobs.iter().any(|j| planned.tracks[*j].is_ok() && is_needed(*j));
        if to_do { planned.sequence.len() as u64 } else { 0 }
    };
    units.par_iter().map(of_unit).sum()
}

/// Results of `work` on each unit, in order. Each thread of the current pool takes one unit after the other.
/// When none is left, it helps with the units of other threads.
///
/// Units are not in the queue of the pool, so a thread that waits within one unit cannot begin another. Hence
/// at most one sequence per thread is in memory.
///
/// # Errors
/// An error of `work`. Units that have not begun by then are skipped.
pub fn for_units<T: Send>(
    units: &[Unit],
    work: impl Fn(&Unit) -> Result<T, RunError> + Sync,
) -> Result<Vec<T>, RunError> {
    let next = AtomicUsize::new(0);
    let done = rayon::broadcast(|_| {
        let take = || {
            let k = next.fetch_add(1, Ordering::Relaxed);
            Some((k, units.get(k)?))
        };
        let done = std::iter::from_fn(take).map(|(k, unit)| work(unit).map(|done| (k, done)));
        let done: Result<Vec<(usize, T)>, RunError> = done.collect();
        if done.is_err() {
            next.store(units.len(), Ordering::Relaxed);
        }
        done
    });
    let done = done.into_iter().collect::<Result<Vec<_>, RunError>>()?;
    let mut done: Vec<(usize, T)> = done.into_iter().flatten().collect();
    done.sort_unstable_by_key(|(k, _)| *k);
    Ok(done.into_iter().map(|(_, done)| done).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// Runs `work` as a step of many units, on three threads.
    fn run(work: impl Fn(usize) -> Result<usize, RunError> + Sync) -> Result<Vec<usize>, RunError> {
        let units: Vec<Unit> = (0..30).map(|k| (0, k, Vec::new())).collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        pool.install(|| for_units(&units, |(_, k, _)| work(*k)))
    }

    #[test]
    fn no_more_units_have_begun_than_there_are_threads() {
        let begun = AtomicUsize::new(0);
        let done = run(|k| {
            assert!(begun.fetch_add(1, Ordering::SeqCst) < 3);
            let wait = |n: &u64| std::thread::sleep(Duration::from_micros(*n * 50));
            [1, 9, 2, 7].par_iter().with_max_len(1).for_each(wait);
            begun.fetch_sub(1, Ordering::SeqCst);
            Ok(k)
        });
        assert_eq!(done.unwrap(), (0..30).collect::<Vec<_>>());
    }

    #[test]
    fn an_error_ends_the_work() {
        let begun = AtomicUsize::new(0);
        let done = run(|k| {
            begun.fetch_add(1, Ordering::SeqCst);
            std::thread::sleep(Duration::from_millis(5));
            if k == 4 { Err(RunError::Interrupted) } else { Ok(k) }
        });
        assert!(matches!(done, Err(RunError::Interrupted)));
        assert!(begun.into_inner() < 20);
    }
}
