//! Helpers of the tests of programs and result files.

use super::RunContext;
use super::process::{Program, Programs, Protocol, Regions, Role};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trackfail_core::image::Frame;
use trackfail_core::region::{Rect, Region};
use trackfail_core::sequence::SequenceInfo;
use trackfail_dataset::{Frames, Numbering, Render, Sequence};

/// A program of signals or detectors: a shell script in a folder.
pub fn script(role: Role, folder: &Path, text: &str) -> Program {
    std::fs::write(folder.join("script.sh"), text).unwrap();
    Program {
        role,
        name: "mine".into(),
        command: ["sh", "script.sh"].map(String::from).into(),
        folder: folder.to_path_buf(),
        protocol: Protocol::Json,
        version: "7".into(),
        start_timeout: Duration::from_secs(20),
        answer_timeout: Duration::from_secs(20),
        regions: Regions::Rectangle,
        confidence: None,
        deterministic: false,
        environment: [("EXTRA".to_string(), "more".to_string())].into(),
        digest: vec![],
    }
}

/// A file of one program.
pub fn programs(program: &Program) -> Programs {
    Programs { file: "plugins.toml".into(), list: vec![Arc::new(program.clone())] }
}

/// Whether a process of this number ends within a while.
pub fn is_gone(pid: &str) -> bool {
    let end = Instant::now() + Duration::from_secs(20);
    while Instant::now() < end {
        let shown =
            std::process::Command::new("ps").args(["-o", "stat=", "-p", pid.trim()]).output().unwrap();
        let state = String::from_utf8_lossy(&shown.stdout).trim().to_string();
        if state.is_empty() || state.starts_with('Z') {
            return true;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    false
}

/// Frames of 320 x 240 pixels, each with other colors.
pub struct Ramp;

impl Render for Ramp {
    fn render(&self, t: usize) -> Frame {
        Frame::from_fn(320, 240, |x, y| [x as u8, y as u8, t as u8])
    }

    fn size(&self) -> (usize, usize) {
        (320, 240)
    }
}

/// Frames of [`Ramp`], counted from 1, with the same box in each.
pub fn rendered(name: &str, frames: usize) -> Sequence {
    Sequence {
        name: name.into(),
        numbering: Numbering { first: 1, official: (1, frames as u32) },
        truth: vec![Some(Region::Rect(Rect::new(9.0, 9.0, 9.0, 9.0))); frames],
        attributes: vec![],
        frame_attributes: vec![],
        digest: "0".into(),
        frames: Frames::Rendered(Arc::new(Ramp), frames),
    }
}

/// A context of run 0 that starts in the first frame and has no data root.
pub fn context(sequence: &dyn SequenceInfo, seed: u64) -> RunContext<'_> {
    RunContext { sequence, start_frame: 0, run: 0, seed, data_roots: &[] }
}
