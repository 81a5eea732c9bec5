//! The output of `trackfail detect`: what every method says of every frame of a user's track.

pub use crate::detector::labels::TargetState;

use super::column::{Column, FRAME, METHOD, TableFile};
use super::frame::{TableError, to_csv};
use super::frames::{CHANGE, LABEL, SCORE};
use crate::detector::{Detector, DetectorOutput, StateOfTarget, changes, lost};
use crate::direction::Direction;
use std::ops::Range;

/// The CSV on stdout.
pub const FILE: TableFile = TableFile {
    name: "stdout of `trackfail detect`",
    about: "One row for each frame and method, method by method.",
    columns: &[NUMBER, METHOD, SCORE_OF_TRACK, LABEL, CHANGE, STATE],
};

/// The CSV on stdout for a file of several targets.
pub const FILE_OF_TARGETS: TableFile = TableFile {
    name: "stdout of `trackfail detect` for boxes with numbers of targets",
    about: "One row for each frame, method and target, target by target.",
    columns: &[NUMBER, METHOD, SCORE_OF_TRACK, LABEL, CHANGE, STATE, TARGET],
};

const NUMBER: Column = Column { meaning: "Number of the frame, as its file has it", ..FRAME };

const SCORE_OF_TRACK: Column = SCORE.empty("the track has not begun yet, or is over");

const STATE: Column = Column::text(
    "state",
    "`absent` where the tracker gives no box; else `lost` from an alarm on, until the recovery is confirmed: in the frame \
     without an alarm itself for methods whose alarm lasts as long as the loss, in the tenth frame in a row without one for \
     the others, and where the score is a probability, after ten frames in a row below one half; else `tracking`. An alarm that is raised while the target is absent ends with the absence",
);

const TARGET: Column = Column::integer("target", "", "Number of the target, as the file of boxes has it");

/// One target, as the methods judge it.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedTrack {
    /// Its number, in a file of several targets.
    pub target: Option<i64>,
    /// Number of the first frame.
    pub first: u32,
    /// The methods, the one that the user is told of first.
    pub methods: Vec<JudgedMethod>,
}

impl JudgedTrack {
    /// Number of frame `t`, which counts from 0.
    pub fn number(&self, t: usize) -> u64 {
        u64::from(self.first) + t as u64
    }
}

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

/// The CSV of all frames of all tracks.
///
/// # Errors
/// When polars refuses.
pub fn csv(tracks: &[&JudgedTrack]) -> Result<Vec<u8>, TableError> {
    let (mut number, mut name, mut score) = (Vec::new(), Vec::new(), Vec::new());
    let (mut label, mut change, mut state, mut target) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (track, method) in tracks.iter().flat_map(|track| track.methods.iter().map(move |m| (track, m))) {
        let frames = method.states.len();
        number.extend((0..frames).map(|t| track.number(t) as i64));
        name.extend(std::iter::repeat_n(method.name.as_str(), frames));
        score.extend_from_slice(&method.score);
        label.extend(method.label.iter().map(|alarm| i32::from(*alarm)));
        change.extend_from_slice(&method.changes);
        state.extend(method.states.iter().map(|state| state.word()));
        target.extend(track.target.map(|id| vec![id; frames]).unwrap_or_default());
    }
    let keys = [NUMBER.of(number), METHOD.of(name), SCORE_OF_TRACK.of(score)];
    let mut columns: Vec<_> = keys.into();
    columns.extend([LABEL.of(label), CHANGE.of(change), STATE.of(state)]);
    if tracks.iter().any(|track| track.target.is_some()) {
        columns.push(TARGET.of(target));
        return to_csv(FILE_OF_TARGETS.frame(columns)?);
    }
    to_csv(FILE.frame(columns)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::level::ENTRY;

    /// The judgement of an output on a track that has a box where `boxes` has a `b`, in states of one letter, with its labels.
    fn judged(text: &str, detector: &str, score: &[f64], alarm: &str, boxes: &str) -> (String, String) {
        let entry = crate::plugin::find(crate::detector::DETECTORS, detector).unwrap();
        let detector = entry.build_from_text(text).unwrap();
        let alarm = alarm.chars().map(|c| c == '!').collect();
        let output = DetectorOutput { score: score.to_vec(), alarm, ..DetectorOutput::default() };
        let present: Vec<bool> = boxes.chars().map(|c| c == 'b').collect();
        let method = JudgedMethod::new("M", &*detector, &output, 0, &present);
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
        // Between its levels hysteresis only holds the alarm; below the lower one it raises it again.
        let text = "{ below = 0.3, found = 0.7 }";
        let held = [0.9, 0.9, 0.1, 0.1, 0.5, 0.5, 0.8, 0.9];
        let of = |score: &[f64], alarm: &str| judged(text, "hysteresis", score, alarm, "bb--bbbb");
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

    /// Frames 1 to 6 of a track that begins in the second, with alarms in the third and sixth.
    fn track(target: Option<i64>) -> JudgedTrack {
        let detector = ENTRY.build_from_text("{ below = 0.5 }").unwrap();
        let output = DetectorOutput {
            score: vec![0.9, 0.1, 0.75, 0.25],
            alarm: vec![false, true, false, true],
            ..DetectorOutput::default()
        };
        let present = [false, true, true, false, true, false];
        let method = JudgedMethod::new("level", &*detector, &output, 1, &present);
        JudgedTrack { target, first: 1, methods: vec![method] }
    }

    #[test]
    fn rows_by_hand() {
        let text = |target| String::from_utf8(csv(&[&track(target)]).unwrap()).unwrap();
        assert_eq!(
            text(None),
            "frame,method,score,label,change,state\n1,level,,0,0,absent\n2,level,0.9,0,0,tracking\n\
             3,level,0.1,1,1,lost\n4,level,0.75,0,-1,absent\n5,level,0.25,1,1,lost\n6,level,,0,0,absent\n"
        );
        assert!(
            text(Some(7))
                .starts_with("frame,method,score,label,change,state,target\n1,level,,0,0,absent,7\n")
        );
        let method = &track(None).methods[0];
        assert_eq!(method.losses(), [2..3, 4..5]);
        assert_eq!(method.stretches().count(), 6);
        assert!(!method.is_probability);
    }
}
