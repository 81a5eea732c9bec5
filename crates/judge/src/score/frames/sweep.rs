//! Frames of all tracks sorted by score, the most suspicious first.

use super::truth::{Rule, ScoredTrack};

/// An annotated frame.
#[derive(Debug, Clone, Copy)]
struct Judged {
    /// Score, of which both zeros are one.
    score: f64,
    sequence: u32,
    /// By each [`Rule`], in their order, true if the frame is lost; `None` if it is left out.
    lost: [Option<bool>; 2],
    /// Index of the track, and of the frame in it.
    place: (u32, u32),
}

/// Annotated frames of all tracks, by descending score.
#[derive(Debug, Clone)]
pub struct Sorted {
    frames: Vec<Judged>,
    sequences: usize,
}

impl Sorted {
    /// Sorts the annotated frames of tracks. Frames of equal score are in any order, on which no measure
    /// depends.
    pub fn new(tracks: &[ScoredTrack<'_>]) -> Self {
        let of_track = |(k, track): (usize, &ScoredTrack<'_>)| {
            let sequence = track.sequence as u32;
            let frame = move |(t, (e, s)): (usize, (&f64, &f64))| {
                let place = (k as u32, t as u32);
                let lost = [Rule::NoOverlap, Rule::Clear].map(|rule| rule.judge(*e));
                (!e.is_nan()).then(|| Judged { score: s + 0.0, sequence, lost, place })
            };
            track.error.iter().zip(track.score).enumerate().filter_map(frame).collect::<Vec<_>>()
        };
        let mut frames: Vec<Judged> = tracks.iter().enumerate().flat_map(of_track).collect();
        frames.sort_unstable_by(|a, b| b.score.total_cmp(&a.score));
        Self { frames, sequences: tracks.iter().map(|t| t.sequence + 1).max().unwrap_or(0) }
    }

    /// Frames that are lost or good by a rule.
    pub fn sweep(&self, rule: Rule) -> Sweep {
        self.sweep_by(|frame| frame.lost[rule as usize])
    }

    /// Frames for which `lost` has a value. It has one list per track, with one entry per frame.
    pub fn sweep_of(&self, lost: &[Vec<Option<bool>>]) -> Sweep {
        self.sweep_by(|frame| lost[frame.place.0 as usize][frame.place.1 as usize])
    }

    fn sweep_by(&self, lost: impl Fn(&Judged) -> Option<bool>) -> Sweep {
        let mut sweep = Sweep {
            frames: Vec::with_capacity(self.frames.len()),
            lost: vec![0; self.sequences],
            good: vec![0; self.sequences],
        };
        for frame in &self.frames {
            let Some(lost) = lost(frame) else { continue };
            sweep.frames.push(Swept { score: frame.score, sequence: frame.sequence, lost });
            let counts = if lost { &mut sweep.lost } else { &mut sweep.good };
            counts[frame.sequence as usize] += 1;
        }
        sweep
    }
}

/// A frame of a [`Sweep`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swept {
    /// Score of the frame.
    pub score: f64,
    /// Index of the sequence.
    pub sequence: u32,
    /// True if the frame is lost, false if it is good.
    pub lost: bool,
}

/// Lost and good frames by descending score.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// Frames by descending score.
    pub frames: Vec<Swept>,
    /// Number of lost frames, by sequence.
    pub lost: Vec<u64>,
    /// Number of good frames, by sequence.
    pub good: Vec<u64>,
}

impl Sweep {
    /// Groups of frames with equal scores, by descending score.
    pub fn ties(&self) -> impl DoubleEndedIterator<Item = &[Swept]> {
        self.frames.chunk_by(|a, b| a.score == b.score)
    }

    /// Numbers of lost and of good frames.
    pub fn totals(&self) -> (u64, u64) {
        (self.lost.iter().sum(), self.good.iter().sum())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::score::testing::value;
    use proptest::prelude::*;
    use serde_json::Value;

    /// Sweep over frames of one sequence, given by score and true for lost frames.
    pub fn sweep(frames: &[(f64, bool)]) -> Sweep {
        sweep_of(&[frames.to_vec()])
    }

    /// Sweep over several sequences.
    pub fn sweep_of(sequences: &[Vec<(f64, bool)>]) -> Sweep {
        let error = |frames: &Vec<(f64, bool)>| frames.iter().map(|f| f64::from(f.1)).collect::<Vec<_>>();
        let score = |frames: &Vec<(f64, bool)>| frames.iter().map(|f| f.0).collect::<Vec<_>>();
        let split: Vec<_> = sequences.iter().map(|frames| (error(frames), score(frames))).collect();
        let mut tracks = Vec::new();
        for (sequence, (error, score)) in split.iter().enumerate() {
            tracks.push(ScoredTrack { sequence, error, score, alarm: &[] });
        }
        Sorted::new(&tracks).sweep(Rule::NoOverlap)
    }

    /// The frames of a case of the reference programs.
    pub fn scored(case: &Value) -> Vec<(f64, bool)> {
        let (score, lost): (Vec<f64>, Vec<u8>) = (value(case, "score"), value(case, "lost"));
        score.into_iter().zip(lost.iter().map(|l| *l == 1)).collect()
    }

    /// Frames with scores that tie often.
    pub fn frames() -> impl Strategy<Value = Vec<(f64, bool)>> {
        prop::collection::vec(((-4..5_i32).prop_map(|s| f64::from(s) / 2.0), any::<bool>()), 0..60)
    }

    #[test]
    fn frames_come_by_score_and_end_their_ties() {
        let swept = sweep(&[(0.0, false), (2.0, true), (-0.0, true), (-3.0, false), (f64::MAX, false)]);
        let scores: Vec<f64> = swept.frames.iter().map(|f| f.score).collect();
        assert_eq!(scores, [f64::MAX, 2.0, 0.0, 0.0, -3.0]);
        assert_eq!(swept.ties().map(<[Swept]>::len).collect::<Vec<_>>(), [1, 1, 2, 1]);
        assert_eq!(swept.totals(), (2, 3));
    }

    #[test]
    fn frames_that_are_left_out_do_not_hold_ties_together() {
        // The errors are IoUs of 0, 0.33, 1.
        let (error, score) = ([1.0, 0.5, 0.0, f64::NAN], [3.0, 2.0, 1.0, 2.5]);
        let sorted = Sorted::new(&[ScoredTrack { sequence: 1, error: &error, score: &score, alarm: &[] }]);
        let clear = sorted.sweep(Rule::Clear);
        let frames: Vec<(f64, bool)> = clear.frames.iter().map(|f| (f.score, f.lost)).collect();
        assert_eq!(frames, [(3.0, true), (1.0, false)]);
        assert_eq!((sorted.sweep(Rule::NoOverlap).totals(), clear.good), ((1, 2), vec![0, 1]));
    }
}
