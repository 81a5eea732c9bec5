//! Tracks and regions that the tests of many scores have.

use super::Counts;
use crate::region::{Rect, Region};
use crate::score::trajectory::Trajectory;
use crate::tracker::Status;
use proptest::prelude::*;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// True from the first frame of each pair up to the second, which it is not in.
pub fn set(frames: usize, on: &[[usize; 2]]) -> Vec<bool> {
    (0..frames).map(|t| on.iter().any(|[from, to]| (*from..*to).contains(&t))).collect()
}

/// Errors of a track that is lost in such frames.
pub fn error(frames: usize, lost: &[[usize; 2]]) -> Vec<f64> {
    set(frames, lost).iter().map(|lost| if *lost { 1.0 } else { 0.3 }).collect()
}

/// Counts in the order of their names.
pub fn counts(tp: u64, fp: u64, fn_: u64, tn: u64) -> Counts {
    Counts { tp, fp, fn_, tn }
}

/// A box.
pub fn rect(x: f64, y: f64, w: f64, h: f64) -> Region {
    Region::Rect(Rect::new(x, y, w, h))
}

/// A square of ten pixels.
pub fn square(x: f64) -> Region {
    rect(x, 0.0, 10.0, 10.0)
}

/// One run of a tracker, without anything else that is known of the sequence.
pub fn trajectory<'a>(
    regions: &'a [Region],
    status: &'a [Status],
    truth: &'a [Option<Region>],
) -> Trajectory<'a> {
    Trajectory { sequence: "a", regions, status, truth, ..Trajectory::default() }
}

/// Errors, alarms and changes of a track in runs, so that there are quiet stretches as well. Changes come with the runs,
/// whatever the alarms are.
pub fn track() -> impl Strategy<Value = (Vec<f64>, Vec<bool>, Vec<i32>)> {
    let error = prop_oneof![8 => Just(1.0), 8 => Just(0.2), 3 => Just(f64::NAN)];
    let change = prop_oneof![6 => Just(0), 1 => Just(1), 1 => Just(-1)];
    let run = (error, any::<bool>(), change, prop_oneof![1..3_usize, 1..25_usize]);
    prop::collection::vec(run, 0..25).prop_map(|runs| {
        let error = runs.iter().flat_map(|run| vec![run.0; run.3]).collect();
        let alarm = runs.iter().flat_map(|run| vec![run.1; run.3]).collect();
        let first_of_run = |run: &(f64, bool, i32, usize)| [vec![run.2], vec![0; run.3 - 1]].concat();
        (error, alarm, runs.iter().flat_map(first_of_run).collect())
    })
}

/// One letter a frame: start, tracked, failed, skipped, waiting, absent.
pub fn status(letters: &str) -> Vec<Status> {
    let of = |letter| match letter {
        'i' => Status::Initialized,
        'f' => Status::Failed,
        's' => Status::Skipped,
        'w' => Status::Waiting,
        'a' => Status::Absent,
        _ => Status::Tracked,
    };
    letters.chars().map(of).collect()
}

/// A part of the values of the reference programs, made by `tests/oracles/frames.py`.
pub fn oracle<T: DeserializeOwned>(part: &str) -> T {
    value(&serde_json::from_str(include_str!("../../../../tests/oracles/frames.json")).unwrap(), part)
}

/// A value of a case by its name.
pub fn value<T: DeserializeOwned>(case: &Value, name: &str) -> T {
    serde_json::from_value(case[name].clone()).unwrap_or_else(|e| panic!("{name}: {e}"))
}
