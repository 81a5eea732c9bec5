//! Track quality without ground truth: the condition of a tracker, and whether its track can be trusted
//! (SanMiguel, Cavallaro and Martinez, IEEE TIP 21(5), 2012; SanMiguel and Cavallaro, CVIU 131, 2015,
//! section 6). What `arte` and `arte-star` have in common.

use serde::{Deserialize, Serialize};

/// The condition of a tracker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Condition {
    /// It follows something: its target or, while the track is unsuccessful, something else.
    LockedOn,
    /// Its hypotheses draw together.
    LockingIn,
    /// Its hypotheses are spread; it looks for its target.
    Scanning,
}

/// A try to find out, by running backwards, whether the tracker has recovered.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// The frame in which it was made, from 0.
    pub frame: usize,
    /// The frame that was run back to, the last one before the track was lost.
    pub reference: usize,
    /// Tracking error there between both ways, in `[0, 1]`; `None` where nothing was run.
    pub error: Option<f64>,
    /// Whether the track is taken to be successful again.
    pub accepted: bool,
}

/// How a detector came to its labels.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// The condition in each frame.
    pub condition: Vec<Condition>,
    /// The checks, in order of frames.
    pub checks: Vec<Check>,
}

impl Quality {
    /// Frames that the tracker was run backwards, over all checks.
    pub fn reverse_frames(&self) -> usize {
        self.checks.iter().filter(|c| c.error.is_some()).map(|c| c.frame - c.reference).sum()
    }
}
