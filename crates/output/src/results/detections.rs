//! The output of `trackfail detect`: what every method says of every frame of a user's track.

pub use trackfail_judge::judged::{JudgedMethod, badness};
pub use trackfail_methods::detector::labels::TargetState;

use super::column::{Column, FRAME, METHOD, TableFile};
use super::frame::{TableError, to_csv};
use super::frames::{CHANGE, LABEL, SCORE};

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
    use trackfail_methods::detector::DetectorOutput;
    use trackfail_methods::detector::level::ENTRY;

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
