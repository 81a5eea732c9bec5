//! Result of a method on a track, frame by frame.

use crate::detector::labels::TargetState;
use crate::detector::{Detector, DetectorOutput, Facts, StateOfTarget, changes, lost};
use crate::direction::Direction;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Result of a method on one target. Each list has a value for each frame.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedMethod {
    /// Name of the method.
    pub name: String,
    /// Threshold on the score; `None` if the method has no fixed one.
    pub threshold: Option<f64>,
    /// Direction in which scores are good.
    pub direction: Direction,
    /// True if the score is the probability of a loss.
    pub is_probability: bool,
    /// Score; `None` before the first box and after the last one.
    pub score: Vec<Option<f64>>,
    /// Number that is compared with the threshold, for methods that compare another one than the score.
    pub alarm_score: Option<Vec<Option<f64>>>,
    /// True in frames with an alarm.
    pub label: Vec<bool>,
    /// Change of the label: +1, -1, 0.
    pub changes: Vec<i32>,
    /// State of the target in each frame.
    pub states: Vec<TargetState>,
}

impl JudgedMethod {
    /// Converts the output of a detector on a track that begins in frame `start`. `present` is true for each
    /// frame of the video in which the tracker gives a box.
    pub fn new(
        name: &str,
        detector: &dyn Detector,
        output: &DetectorOutput,
        start: usize,
        present: &[bool],
    ) -> Self {
        let frames = output.alarm.len();
        let has_box = |t: usize| present.get(start + t) == Some(&true);
        let facts = detector.facts();
        let lost = lost(&output.alarm, facts.frames_to_recover);
        let (mut raising, mut state) = (Raising::default(), StateOfTarget::default());
        let of_frame = |t: usize| {
            let raised = raising.push(&facts, has_box(t), output.alarm[t], output.compared()[t]);
            let probability = if facts.gives_probability { output.score[t] } else { f64::NAN };
            state.push(has_box(t), lost[t], raised, probability)
        };
        let during: Vec<TargetState> = (0..frames).map(of_frame).collect();
        let label: Vec<bool> =
            (0..frames).map(|t| output.alarm[t] && during[t] != TargetState::Tracking).collect();
        let changes = changes(&label);
        // Index in the output of each frame of the video.
        let at = || (0..present.len()).map(move |t| t.checked_sub(start));
        let outside = |present: &bool| if *present { TargetState::Tracking } else { TargetState::Absent };
        let state = |(at, present): (Option<usize>, &bool)| {
            at.and_then(|at| during.get(at)).copied().unwrap_or_else(|| outside(present))
        };
        let over = |scores: &[f64]| -> Vec<Option<f64>> { at().map(|at| scores.get(at?).copied()).collect() };
        Self {
            name: name.to_string(),
            threshold: facts.threshold,
            direction: facts.direction,
            is_probability: facts.gives_probability,
            score: over(&output.score),
            alarm_score: output.alarm_score.as_deref().map(over),
            label: at().map(|at| at.and_then(|at| label.get(at)) == Some(&true)).collect(),
            changes: at().map(|at| at.and_then(|at| changes.get(at)).copied().unwrap_or(0)).collect(),
            states: at().zip(present).map(state).collect(),
        }
    }

    /// True if the score is at or beyond the threshold, on the side of alarms; `None` without a score or a
    /// threshold.
    pub fn is_beyond(&self, t: usize) -> Option<bool> {
        let score = self.score.get(t).copied().flatten()?;
        Some(badness(self.direction, score) >= badness(self.direction, self.threshold?))
    }

    /// Runs of frames with the same state, in order.
    pub fn stretches(&self) -> impl Iterator<Item = (TargetState, Range<usize>)> + '_ {
        let mut at = 0;
        self.states.chunk_by(|a, b| a == b).filter_map(move |run| {
            let from = at;
            at += run.len();
            run.first().map(|state| (*state, from..at))
        })
    }

    /// Runs of frames in which the target is lost.
    pub fn losses(&self) -> Vec<Range<usize>> {
        self.stretches().filter(|(state, _)| *state == TargetState::Lost).map(|(_, run)| run).collect()
    }
}

/// Score with a sign such that high values speak for a loss.
pub fn badness(direction: Direction, score: f64) -> f64 {
    if direction == Direction::HigherIsBetter { -score } else { score }
}

/// Memory for telling whether a frame raises an alarm itself, instead of holding one of an earlier frame.
///
/// Detectors of single-frame alarms raise one in each alarm frame. An alarm that lasts, as all of detectors with
/// probabilities do, is raised where it begins. If it began during an absence, it is also raised later by a value beyond the threshold. Values
/// that are sums over earlier frames must exceed that of the last frame of the absence instead.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Raising {
    /// True if the frame before had an alarm.
    before: bool,
    /// Value in the last frame without a box.
    absent: Option<f64>,
}

impl Raising {
    /// True if the next frame raises an alarm. `has_box` is true if the tracker has a box there, `compared` is the
    /// value that is compared with the threshold; NaN in a frame that could not be judged, which changes nothing.
    pub fn push(&mut self, facts: &Facts, has_box: bool, alarm: bool, compared: f64) -> bool {
        let is_lasting = facts.frames_to_recover == 1 || facts.gives_probability;
        if !is_lasting || compared.is_nan() {
            return alarm;
        }
        let has_memory = !(facts.scores_signal || facts.gives_probability);
        let bad = |value: f64| badness(facts.direction, value);
        let beyond = match (has_memory, self.absent, facts.threshold) {
            (true, Some(absent), _) => bad(compared) > bad(absent),
            (false, _, Some(threshold)) => bad(compared) >= bad(threshold),
            _ => false,
        };
        let begins = !std::mem::replace(&mut self.before, alarm);
        if !has_box {
            self.absent = Some(compared);
        }
        alarm && (begins || beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A detector whose alarm begins when the signal is below 0.3 and lasts until another rule ends it.
    struct Holding;

    impl Detector for Holding {
        fn facts(&self) -> Facts {
            let (threshold, direction) = (Some(0.3), Direction::HigherIsBetter);
            Facts { threshold, direction, scores_signal: true, frames_to_recover: 1, ..Facts::default() }
        }

        fn detect(&self, _: &crate::detector::Input<'_>) -> DetectorOutput {
            DetectorOutput::default()
        }
    }

    /// States (one letter each) and labels of an output on a track that has a box where `boxes` has a `b`.
    fn judged(detector: &dyn Detector, score: &[f64], alarm: &str, boxes: &str) -> String {
        let alarm = alarm.chars().map(|c| c == '!').collect();
        let output = DetectorOutput { score: score.to_vec(), alarm, ..DetectorOutput::default() };
        let present: Vec<bool> = boxes.chars().map(|c| c == 'b').collect();
        let method = JudgedMethod::new("M", detector, &output, 0, &present);
        assert_eq!(method.changes, changes(&method.label));
        let states: String = method.states.iter().filter_map(|state| state.word().chars().next()).collect();
        let labels: String = method.label.iter().map(|label| if *label { '!' } else { '.' }).collect();
        format!("{states} {labels}")
    }

    // By hand; the alarms are what each detector gives for these scores.
    #[test]
    fn an_alarm_from_an_absence_ends_with_it() {
        let build = |kind: &str, text: &str| {
            crate::plugin::find(crate::detector::DETECTORS, kind).unwrap().build_from_text(text).unwrap()
        };
        let holding: &dyn Detector = &Holding;
        let agreement = build("agreement", "{ threshold = 0.9 }");
        let (sums, level) = (build("cusum", "{ above = 5.0, start = 2 }"), build("level", "{ below = 0.3 }"));
        for (detector, score, alarm, want) in [
            // Above its threshold it only holds the alarm; below it raises it again.
            (holding, [0.9, 0.9, 0.1, 0.1, 0.5, 0.5, 0.8, 0.9], "..!!!!..", "ttaatttt ..!!...."),
            (holding, [0.9, 0.9, 0.1, 0.1, 0.5, 0.2, 0.5, 0.9], "..!!!!!.", "ttaatllt ..!!.!!."),
            (&*agreement, [0.1, 0.1, 0.95, 0.95, 0.5, 0.5, 0.95, 0.5], "..!!!!!!", "ttaattll ..!!..!!"),
            // Sums over earlier frames hold what they were in the absence; they speak for a loss where they grow beyond that.
            (&*sums, [0.0, 0.0, 6.0, 40.0, 39.0, 38.0, 39.5, 37.0], "..!!!!!!", "ttaatttt ..!!...."),
            (&*sums, [0.0, 0.0, 6.0, 40.0, 41.0, 38.0, 39.5, 37.0], "..!!!!!!", "ttaallll ..!!!!!!"),
            // Each alarm of a detector of single frames stands for itself.
            (&*level, [0.9, 0.9, 0.1, 0.1, 0.5, 0.5, 0.8, 0.9], "..!!....", "ttaatttt ..!!...."),
            (&*level, [0.9, 0.9, 0.1, 0.1, 0.1, 0.5, 0.8, 0.9], "..!!!...", "ttaallll ..!!!..."),
            // A loss from before the absence goes on after it.
            (&*level, [0.9, 0.1, 0.1, 0.5, 0.5, 0.5, 0.8, 0.9], ".!!.....", "tlaallll .!!....."),
        ] {
            assert_eq!(judged(detector, &score, alarm, "bb--bbbb"), want, "{score:?}");
        }
    }
}
