//! Folds of the test suite, for parameters and models that are trained on other sequences and other trackers.
//!
//! A video is one unit, however many of its targets a suite has; names that differ only in case or punctuation
//! are one video (`Face-Occ1`, `faceocc1`). The videos are shuffled by the seed of the experiment and dealt
//! out to at most [`FOLDS`] folds. A parameter or model for a sequence and a tracker is trained on the
//! sequences of the other folds and on the other trackers.
//!
//! With `folds = "source"` each source of videos is a fold. Its parameters and models are trained on the
//! other sources, on all trackers.

use crate::spec::FoldsBy;
use std::collections::{BTreeMap, BTreeSet};
use trackfail_core::num::seed;
use trackfail_dataset::suite::Origin;

/// Most folds. With fewer videos, each video is a fold.
pub const FOLDS: usize = 10;

/// Name of a video, normalized for comparison; unchanged if nothing would be left of it.
pub fn video(name: &str) -> String {
    let kept: String = name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect();
    if kept.is_empty() { name.to_string() } else { kept }
}

/// Fold of each sequence, from 0, given their origins.
pub fn folds(by: FoldsBy, origins: &[&Origin], experiment_seed: u64) -> Vec<usize> {
    match by {
        FoldsBy::Video => {
            let videos: Vec<&str> = origins.iter().map(|origin| origin.video.as_str()).collect();
            of_videos(&videos, experiment_seed)
        }
        FoldsBy::Source => of_sources(origins),
    }
}

/// Folds by source. Sources are numbered in the order of the sequences; a video in several sources belongs to
/// the fold of the first.
fn of_sources(origins: &[&Origin]) -> Vec<usize> {
    let mut source_of: BTreeMap<&str, &str> = BTreeMap::new();
    let mut sources: Vec<&str> = Vec::new();
    for origin in origins {
        let source = *source_of.entry(&origin.video).or_insert(&origin.source);
        if !sources.contains(&source) {
            sources.push(source);
        }
    }
    let fold = |origin: &&Origin| sources.iter().position(|s| *s == source_of[origin.video.as_str()]);
    origins.iter().filter_map(fold).collect()
}

fn of_videos(videos: &[&str], experiment_seed: u64) -> Vec<usize> {
    let drawn = |video: &&str| seed::seed(experiment_seed, &["fold", *video]);
    let order: BTreeSet<(u64, &str)> = videos.iter().map(|video| (drawn(video), *video)).collect();
    let places: BTreeMap<&str, usize> =
        order.into_iter().enumerate().map(|(place, (_, video))| (video, place % FOLDS)).collect();
    videos.iter().map(|video| places[video]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn targets_of_a_video_share_a_fold() {
        let videos = ["Jogging", "jogging.", "Car-9x", "clip_01", "行人-1", "--"].map(video);
        assert_eq!(videos, ["jogging", "jogging", "car9x", "clip01", "行人1", "--"]);
        let folds = of_videos(&videos.each_ref().map(String::as_str), 1);
        assert_eq!(folds[0], folds[1]);
    }

    #[test]
    fn a_source_is_a_fold_and_a_video_of_two_belongs_to_the_first() {
        let origin = |(source, video): &(&str, &str)| Origin {
            video: video.to_string(),
            source: source.to_string(),
            ..Origin::default()
        };
        let all = [("otb", "bolt"), ("vot", "ball"), ("otb", "girl"), ("vot", "bolt"), ("tlp", "bike")];
        let origins: Vec<Origin> = all.iter().map(origin).collect();
        let folds = folds(FoldsBy::Source, &origins.iter().collect::<Vec<_>>(), 1);
        assert_eq!(folds, [0, 1, 0, 0, 2]);
    }

    proptest! {
        #[test]
        fn folds_are_of_equal_size_and_do_not_depend_on_the_order(count in 1..40_usize, turn in 0..40_usize, seed in any::<u64>()) {
            let names: Vec<String> = (0..count).map(|k| format!("video{}", 1000 + k)).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let all = of_videos(&names, seed);
            let size = |fold: usize| all.iter().filter(|f| **f == fold).count();
            let sizes: Vec<usize> = (0..FOLDS.min(count)).map(size).collect();
            prop_assert_eq!(sizes.iter().sum::<usize>(), count);
            prop_assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1);
            let mut turned = names.clone();
            turned.rotate_left(turn % count);
            let mut back = of_videos(&turned, seed);
            back.rotate_right(turn % count);
            prop_assert_eq!(back, all);
        }
    }
}
