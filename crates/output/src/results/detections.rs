//! Output of `trackfail detect`: the result of each method in each frame of a user's track.

pub use trackfail_judge::judged::{JudgedMethod, badness};
pub use trackfail_methods::detector::labels::TargetState;

use super::bytes::to_csv;
use super::files::Judgement;
use super::rows::{Rows, TableError};

/// Results of the methods on one target.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedTrack {
    /// Number of the target; `None` if the file has only one.
    pub target: Option<i64>,
    /// Number of the first frame.
    pub first: u32,
    /// Methods; the first one gives the verdict shown to the user.
    pub methods: Vec<JudgedMethod>,
}

impl JudgedTrack {
    /// Number of frame `t` (0-based).
    pub fn number(&self, t: usize) -> u64 {
        u64::from(self.first) + t as u64
    }
}

/// CSV of all frames of all tracks.
///
/// # Errors
/// When polars refuses.
pub fn csv(tracks: &[&JudgedTrack]) -> Result<Vec<u8>, TableError> {
    let methods = tracks.iter().flat_map(|track| track.methods.iter().map(move |method| (track, method)));
    let rows = methods.flat_map(|(track, method)| {
        (0..method.states.len()).map(move |t| Judgement {
            frame: track.number(t) as i64,
            method: &method.name,
            score: method.score[t],
            label: i32::from(method.label[t]),
            change: method.changes[t],
            state: method.states[t].word(),
            target: track.target,
        })
    });
    let mut frame = Judgement::frame("", rows)?;
    if tracks.iter().all(|track| track.target.is_none()) {
        frame.drop_in_place("target")?;
    }
    to_csv(frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_methods::detector::DetectorOutput;
    use trackfail_methods::detector::level::ENTRY;

    /// Frames 1 to 6 of a track that begins in frame 2, with alarms in frames 3 and 6.
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
        let rows = "1,level,,0,0,absent\n2,level,0.9,0,0,tracking\n3,level,0.1,1,1,lost\n\
                    4,level,0.75,0,-1,absent\n5,level,0.25,1,1,lost\n6,level,,0,0,absent\n";
        let header = "frame,method,score,label,change,state";
        assert_eq!(text(None), format!("{header}\n{rows}"));
        assert!(text(Some(7)).starts_with(&format!("{header},target\n1,level,,0,0,absent,7\n")));
        let method = &track(None).methods[0];
        assert_eq!(method.losses(), [2..3, 4..5]);
        assert_eq!(method.stretches().count(), 6);
        assert!(!method.is_probability);
    }
}
