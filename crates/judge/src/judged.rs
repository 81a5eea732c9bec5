//! What a method says of every frame of a track.

use crate::detector::labels::TargetState;
use crate::detector::{Detector, DetectorOutput, StateOfTarget, changes, lost};
use crate::direction::Direction;
use std::ops::Range;

/// Judgement of one target by a method; every list has a value for each frame.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedMethod {
    /// Its name.
    pub name: String,
    /// Level that the score is compared with, of methods that have one.
    pub threshold: Option<f64>,
    /// Scores that speak for a good track.
    pub direction: Direction,
    /// Whether its score is the probability of a loss.
    pub is_probability: bool,
    /// Score; `None` before the first box and after the last one.
    pub score: Vec<Option<f64>>,
    /// Whether there is an alarm.
    pub label: Vec<bool>,
    /// Change of the label: +1, -1, 0.
    pub changes: Vec<i32>,
    /// State.
    pub states: Vec<TargetState>,
}

impl JudgedMethod {
    /// The output of a detector on a track that begins at `start`; `present` says for each frame of the video whether the
    /// tracker gives a box.
    pub fn new(
        name: &str,
        detector: &dyn Detector,
        output: &DetectorOutput,
        start: usize,
        present: &[bool],
    ) -> Self {
        let frames = output.alarm.len();
        let has_box = |t: usize| present.get(start + t) == Some(&true);
        let (lost, raised) =
            (lost(&output.alarm, detector.frames_to_recover()), raised(detector, output, has_box));
        let mut state = StateOfTarget::default();
        let probability = |t: usize| if detector.gives_probability() { output.score[t] } else { f64::NAN };
        let during: Vec<TargetState> =
            (0..frames).map(|t| state.push(has_box(t), lost[t], raised[t], probability(t))).collect();
        let label: Vec<bool> =
            (0..frames).map(|t| output.alarm[t] && during[t] != TargetState::Tracking).collect();
        let changes = match &output.changes {
            Some(found) if label == output.alarm => found.clone(),
            _ => changes(&label),
        };
        // Index in the output of each frame of the video.
        let at = || (0..present.len()).map(move |t| t.checked_sub(start));
        let outside = |present: &bool| if *present { TargetState::Tracking } else { TargetState::Absent };
        let state = |(at, present): (Option<usize>, &bool)| {
            at.and_then(|at| during.get(at)).copied().unwrap_or_else(|| outside(present))
        };
        Self {
            name: name.to_string(),
            threshold: detector.threshold(),
            direction: detector.score_direction(),
            is_probability: detector.gives_probability(),
            score: at().map(|at| output.score.get(at?).copied()).collect(),
            label: at().map(|at| at.and_then(|at| label.get(at)) == Some(&true)).collect(),
            changes: at().map(|at| at.and_then(|at| changes.get(at)).copied().unwrap_or(0)).collect(),
            states: at().zip(present).map(state).collect(),
        }
    }

    /// Whether a score is at or beyond the threshold, on the side of the alarms; `None` without a score or a threshold.
    pub fn is_beyond(&self, t: usize) -> Option<bool> {
        let score = self.score.get(t).copied().flatten()?;
        Some(badness(self.direction, score) >= badness(self.direction, self.threshold?))
    }

    /// The runs of frames of one state, in order.
    pub fn stretches(&self) -> impl Iterator<Item = (TargetState, Range<usize>)> + '_ {
        let mut at = 0;
        self.states.chunk_by(|a, b| a == b).filter_map(move |run| {
            let from = at;
            at += run.len();
            run.first().map(|state| (*state, from..at))
        })
    }

    /// The runs of frames in which the target is lost.
    pub fn losses(&self) -> Vec<Range<usize>> {
        self.stretches().filter(|(state, _)| *state == TargetState::Lost).map(|(_, run)| run).collect()
    }
}

/// A score turned so that high ones speak for a loss.
pub fn badness(direction: Direction, score: f64) -> f64 {
    if direction == Direction::HigherIsBetter { -score } else { score }
}

/// Whether each frame raises an alarm by itself, and does not only hold one of the frames before.
///
/// Each frame of a detector that alarms in single frames does. An alarm that lasts is raised where it begins; where it is
/// on from an absence, also by a score beyond the threshold, or, where scores are sums over earlier frames, beyond that of the
/// absence's last frame.
fn raised(detector: &dyn Detector, output: &DetectorOutput, has_box: impl Fn(usize) -> bool) -> Vec<bool> {
    if detector.frames_to_recover() > 1 {
        return output.alarm.clone();
    }
    let has_memory = !(detector.scores_signal() || detector.gives_probability());
    let bad = |score: f64| badness(detector.score_direction(), score);
    let mut absent = None;
    let mut before = false;
    let raises = |(t, (alarm, score)): (usize, (&bool, &f64))| {
        let beyond = match (has_memory, absent, detector.threshold()) {
            (true, Some(absent), _) => bad(*score) > bad(absent),
            (false, _, Some(threshold)) => bad(*score) >= bad(threshold),
            _ => false,
        };
        let begins = !std::mem::replace(&mut before, *alarm);
        if !has_box(t) {
            absent = Some(*score);
        }
        *alarm && (begins || beyond)
    };
    output.alarm.iter().zip(&output.score).enumerate().map(raises).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A detector whose alarm begins where the signal is below 0.3 and goes on until another rule ends it.
    struct Holding;

    impl Detector for Holding {
        fn threshold(&self) -> Option<f64> {
            Some(0.3)
        }

        fn score_direction(&self) -> Direction {
            Direction::HigherIsBetter
        }

        fn scores_signal(&self) -> bool {
            true
        }

        fn frames_to_recover(&self) -> usize {
            1
        }

        fn detect(&self, _: &crate::detector::Input<'_>) -> DetectorOutput {
            DetectorOutput::default()
        }
    }

    /// The judgement of a detector of the list.
    fn judged(text: &str, kind: &str, score: &[f64], alarm: &str, boxes: &str) -> (String, String) {
        let entry = crate::plugin::find(crate::detector::DETECTORS, kind).unwrap();
        judged_by(&*entry.build_from_text(text).unwrap(), score, alarm, boxes)
    }

    /// The judgement of an output on a track that has a box where `boxes` has a `b`, in states of one letter, with its labels.
    fn judged_by(detector: &dyn Detector, score: &[f64], alarm: &str, boxes: &str) -> (String, String) {
        let alarm = alarm.chars().map(|c| c == '!').collect();
        let output = DetectorOutput { score: score.to_vec(), alarm, ..DetectorOutput::default() };
        let present: Vec<bool> = boxes.chars().map(|c| c == 'b').collect();
        let method = JudgedMethod::new("M", detector, &output, 0, &present);
        let mut sum = 0;
        for (change, label) in method.changes.iter().zip(&method.label) {
            sum += change;
            assert_eq!(sum, i32::from(*label), "changes are those of the labels");
        }
        let states = method.states.iter().filter_map(|state| state.word().chars().next()).collect();
        (states, method.label.iter().map(|label| if *label { '!' } else { '.' }).collect())
    }

    // By hand; the alarms are what each detector gives for these scores.
    #[test]
    fn an_alarm_from_an_absence_ends_with_it() {
        let own = |states: &str, labels: &str| (states.to_string(), labels.to_string());
        // Above its threshold it only holds the alarm; below it raises it again.
        let held = [0.9, 0.9, 0.1, 0.1, 0.5, 0.5, 0.8, 0.9];
        let of = |score: &[f64], alarm: &str| judged_by(&Holding, score, alarm, "bb--bbbb");
        assert_eq!(of(&held, "..!!!!.."), own("ttaatttt", "..!!...."));
        let again = [0.9, 0.9, 0.1, 0.1, 0.5, 0.2, 0.5, 0.9];
        assert_eq!(of(&again, "..!!!!!."), own("ttaatllt", "..!!.!!."));
        // Sums over earlier frames hold what they were in the absence; they speak for a loss where they grow beyond that.
        let text = "{ above = 5.0, start = 2 }";
        let sums = |score: &[f64]| judged(text, "cusum", score, "..!!!!!!", "bb--bbbb");
        assert_eq!(sums(&[0.0, 0.0, 6.0, 40.0, 39.0, 38.0, 39.5, 37.0]), own("ttaatttt", "..!!...."));
        assert_eq!(sums(&[0.0, 0.0, 6.0, 40.0, 41.0, 38.0, 39.5, 37.0]), own("ttaallll", "..!!!!!!"));
        // Each alarm of a detector of single frames stands for itself.
        let level = |score: &[f64], alarm| judged("{ below = 0.3 }", "level", score, alarm, "bb--bbbb");
        assert_eq!(level(&[0.9, 0.9, 0.1, 0.1, 0.5, 0.5, 0.8, 0.9], "..!!...."), own("ttaatttt", "..!!...."));
        assert_eq!(level(&[0.9, 0.9, 0.1, 0.1, 0.1, 0.5, 0.8, 0.9], "..!!!..."), own("ttaallll", "..!!!..."));
        // A loss from before the absence goes on after it.
        assert_eq!(level(&[0.9, 0.1, 0.1, 0.5, 0.5, 0.5, 0.8, 0.9], ".!!....."), own("tlaallll", ".!!....."));
    }
}
