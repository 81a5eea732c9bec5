//! Folds of the test suite, for parameters and models that are made on other sequences and other trackers.
//!
//! A video is one unit, however many targets of it a suite has: names that differ in their case, in signs, or in the
//! number of the target alone (`Jogging-1`, `jogging.2`) are one video. The videos, in an order that the seed of the
//! experiment draws, are dealt out to at most [`FOLDS`] folds. What is made for a sequence and a tracker learns from the
//! sequences of the other folds on the other trackers.

use std::collections::BTreeMap;
use trackfail_core::num::seed;

/// Largest number of folds; with fewer videos, each is a fold.
pub const FOLDS: usize = 10;

/// The video that a sequence is of.
pub fn video(sequence: &str) -> String {
    let target = |tail: &str| (1..=2).contains(&tail.len()) && tail.bytes().all(|b| b.is_ascii_digit());
    let head = match sequence.rsplit_once(['-', '_', '.']) {
        Some((head, tail)) if target(tail) && !head.is_empty() => head,
        _ => sequence,
    };
    head.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}

/// The fold of each sequence, from 0.
pub fn folds(sequences: &[&str], experiment_seed: u64) -> Vec<usize> {
    let videos: Vec<String> = sequences.iter().map(|name| video(name)).collect();
    let drawn = |video: &str| (seed::seed(experiment_seed, &["fold", video]), video.to_string());
    let order: BTreeMap<(u64, String), ()> = videos.iter().map(|video| (drawn(video), ())).collect();
    let places: BTreeMap<&str, usize> =
        order.keys().enumerate().map(|(place, (_, video))| (video.as_str(), place % FOLDS)).collect();
    videos.iter().filter_map(|video| places.get(video.as_str()).copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn targets_of_a_video_share_a_fold() {
        let names =
            ["Jogging-1", "jogging.2", "Jogging_1", "Skating2-1", "Skating2-2", "Skating1", "car9", "Car-9x"];
        let videos: Vec<String> = names.iter().map(|name| video(name)).collect();
        assert_eq!(
            videos,
            ["jogging", "jogging", "jogging", "skating2", "skating2", "skating1", "car9", "car9x"]
        );
        let folds = folds(&names, 1);
        assert_eq!((folds[0], folds[3]), (folds[1], folds[4]));
        assert_eq!(folds[0], folds[2]);
    }

    proptest! {
        #[test]
        fn folds_are_of_equal_size_and_do_not_depend_on_the_order(count in 1..40_usize, turn in 0..40_usize, seed in any::<u64>()) {
            let names: Vec<String> = (0..count).map(|k| format!("video{}", 1000 + k)).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let all = folds(&names, seed);
            let size = |fold: usize| all.iter().filter(|f| **f == fold).count();
            let sizes: Vec<usize> = (0..FOLDS.min(count)).map(size).collect();
            prop_assert_eq!(sizes.iter().sum::<usize>(), count);
            prop_assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1);
            let mut turned = names.clone();
            turned.rotate_left(turn % count);
            let mut back = folds(&turned, seed);
            back.rotate_right(turn % count);
            prop_assert_eq!(back, all);
        }
    }
}
