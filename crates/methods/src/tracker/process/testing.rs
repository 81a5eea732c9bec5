//! Programs of the tests: shell scripts, good ones and bad ones, in folders of their own.

use super::{Bind, Program, Programs, Protocol, Regions, Role};
use crate::detector::{self, Detector, DetectorOutput, Input};
use crate::signal::{self, Observation, Signal};
use crate::tracker::testing::{context, ramp, rendered};
use crate::tracker::{self, Response, RunContext, StartResult, Status, TrackerConfig, TrackerState};
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;
use trackfail_core::plugin::{Configured, Entry};
use trackfail_core::region::{Rect, Region};
use trackfail_dataset::{Numbering, Sequence};

/// Frames of the sequence, and the number of its first.
pub const FRAMES: usize = 4;
const FIRST: u32 = 11;

/// Role of a program, and the protocol that it speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Lines,
    Trax,
    Signal,
    Detector,
}

impl Kind {
    pub const ALL: [Self; 4] = [Self::Lines, Self::Trax, Self::Signal, Self::Detector];

    /// The word by which scripts and tables know it.
    pub fn word(self) -> String {
        format!("{self:?}").to_lowercase()
    }
}

pub fn rect() -> Region {
    Region::Rect(Rect::new(2.0, 3.5, 4.0, 5.0))
}

/// A sequence whose frames have no files.
pub fn sequence() -> Sequence {
    let numbering = Numbering { first: FIRST, official: (FIRST, FIRST + FRAMES as u32 - 1) };
    Sequence { numbering, truth: vec![Some(rect()); FRAMES], ..rendered("Ramp", FRAMES) }
}

/// A program, and what it leaves in its folder.
pub struct Script {
    kind: Kind,
    pub folder: TempDir,
    pub program: Program,
}

impl Script {
    /// A program that may use what `answers.sh` has.
    pub fn new(kind: Kind, text: &str) -> Self {
        let (role, protocol) = match kind {
            Kind::Lines => (Role::Tracker, Protocol::Lines),
            Kind::Trax => (Role::Tracker, Protocol::Trax),
            Kind::Signal => (Role::Signal, Protocol::Json),
            Kind::Detector => (Role::Detector, Protocol::Json),
        };
        let text = format!("KIND={}\n{}\n{text}\n", kind.word(), include_str!("testing/answers.sh"));
        let folder = trackfail_testing::folder([("script.sh", text)]);
        let program = Program {
            role,
            name: "mine".into(),
            command: ["sh", "script.sh"].map(String::from).into(),
            folder: folder.path().to_path_buf(),
            protocol,
            version: "7".into(),
            start_timeout: Duration::from_secs(20),
            answer_timeout: Duration::from_secs(20),
            regions: Regions::Rectangle,
            confidence: None,
            deterministic: false,
            environment: [("EXTRA".to_string(), "more".to_string())].into(),
            digest: vec![],
        };
        Self { kind, folder, program }
    }

    /// Makes its time limits short.
    pub fn hurry(&mut self) {
        self.program.start_timeout = Duration::from_millis(1100);
        self.program.answer_timeout = Duration::from_millis(1000);
    }

    /// A file that it has written.
    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The file of programs.
    pub fn programs(&self) -> Programs {
        Programs { file: "plugins.toml".into(), list: vec![Arc::new(self.program.clone())] }
    }

    /// Plugin that runs the script, with `more` parameters.
    pub fn bound<T: Bind + ?Sized + 'static>(&self, entry: &Entry<T>, more: &str) -> Configured<T> {
        let mut plugin = entry.build_from_text(&format!("{{ program = \"mine\"{more} }}")).unwrap();
        T::bind(&mut plugin, &self.programs()).unwrap();
        plugin
    }

    pub fn tracker(&self) -> Configured<dyn TrackerConfig> {
        self.bound(&tracker::process::ENTRY, "")
    }

    /// Starts a tracker in a frame of a sequence.
    pub fn start(&self, sequence: &Sequence, start_frame: usize, region: &Region) -> StartResult {
        let context = RunContext { sequence, start_frame, run: 4, seed: 99, data_roots: &[] };
        self.tracker().start(&context, &sequence.frame(start_frame).unwrap(), region)
    }

    /// The first frames of a tracker, or the fault.
    pub fn track(&self, frames: usize) -> Result<Vec<TrackerState>, String> {
        let (mut tracker, first) = self.start(&sequence(), 0, &rect()).map_err(|e| e.to_string())?;
        let mut states = vec![first];
        for t in 1..frames {
            let frame = ramp(t);
            states.push(tracker.update(&frame).map_err(|fault| {
                trackfail_testing::assert_says(tracker.update(&frame).unwrap_err(), "it has ended");
                fault.to_string()
            })?);
        }
        Ok(states)
    }

    /// The numbers in its answers to all frames, or the fault.
    pub fn play(&self) -> Result<Vec<f64>, String> {
        match self.kind {
            Kind::Lines | Kind::Trax => {
                Ok(self.track(FRAMES)?.iter().map(|state| state.region.rect().x).collect())
            }
            Kind::Signal => values(&*self.bound(&signal::process::ENTRY, "")),
            Kind::Detector => {
                let output = detect(&*self.bound(&detector::process::ENTRY, ""), &[]);
                let Some(fault) = output.failure else { return Ok(output.score) };
                assert!(output.score.is_empty() && output.alarm.is_empty(), "labels beside a fault");
                Err(fault)
            }
        }
    }

    /// Fails unless a fault is told in these words, at the frame of an index if there is one.
    #[track_caller]
    pub fn fails(&self, index: Option<usize>, words: &str) {
        let (kind, fault) = (self.kind, self.play().expect_err(words));
        let place = match (index, kind) {
            (None, _) => "mine: frame ".to_string(),
            (Some(index), Kind::Detector) => format!("mine: frame of index {index}: "),
            (Some(index), _) => format!("mine: frame {} of Ramp: ", FIRST as usize + index),
        };
        assert!(fault.starts_with(&place), "{kind:?}: `{place}` does not begin: {fault}");
        assert!(fault.contains(words), "{kind:?}: `{words}` is not in: {fault}");
        assert!(fault.chars().count() < 600 && !fault.contains(char::is_control), "{fault}");
    }

    /// True if it has ended with the process that it started, or both do within a while.
    pub fn is_gone(&self) -> bool {
        ["child", "grandchild"].iter().all(|name| trackfail_testing::is_gone(self.read(name).trim()))
    }
}

/// A tracker's state that a signal sees.
fn state(t: usize) -> TrackerState {
    let region = match t {
        2 => Region::Polygon(vec![(1.0, 1.0), (5.0, 2.0), (4.0, 6.0), (0.0, 5.0)]),
        _ => Region::Rect(Rect::new(t as f64, 2.5, 3.0, 4.0)),
    };
    let mut state = TrackerState::new(region, if t == 3 { Status::Absent } else { Status::Failed });
    state.confidence = (t > 0).then_some(0.125 * t as f64);
    state.response = Some(Response { peak: 0.5, ..Response::default() });
    state
}

/// The values of a signal, or the fault.
pub fn values(signal: &dyn Signal) -> Result<Vec<f64>, String> {
    let sequence = sequence();
    let mut session = signal.start(&context(&sequence, 0)).map_err(|e| e.to_string())?;
    let mut values = Vec::new();
    for t in 0..FRAMES {
        let (frame, state) = (sequence.frame(t).unwrap(), state(t));
        let found = session.push(&Observation::new(&frame, &state));
        values.extend(found.map_err(|fault| {
            let later = session.push(&Observation::new(&frame, &state)).unwrap_err();
            trackfail_testing::assert_says(later, "it has ended");
            fault.to_string()
        })?);
    }
    Ok(values)
}

/// The output of a detector.
pub fn detect(detector: &dyn Detector, more: &[&[f64]]) -> DetectorOutput {
    let error = [f64::NAN; FRAMES];
    detector.detect(&Input { signal: &[0.5, -1.0, 2.0, 4.0], error: &error, seed: 99, reverse: None, more })
}
