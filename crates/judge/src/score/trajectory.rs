//! Regions of a tracker over a sequence with the ground truth, the input of tracking protocols.

use crate::region::Region;
use crate::tracker::Status;

/// Treatment of a frame in which the tracker has no box. All rules that score trackers choose one;
/// `docs/metrics.md` lists the choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Missing {
    /// The frame has no region, and so neither overlap nor center.
    Miss,
    /// The last region of the tracker is used.
    LastBox,
}

/// One track with its ground truth. Each list has one entry per frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct Trajectory<'a> {
    /// Name of the sequence.
    pub sequence: &'a str,
    /// Repetition of the tracker, from 0.
    pub run: u32,
    /// Region of the tracker in each frame.
    pub regions: &'a [Region],
    /// Status of the tracker in each frame.
    pub status: &'a [Status],
    /// Ground truth; `None` where the target is not annotated.
    pub truth: &'a [Option<Region>],
    /// Confidence of the tracker in each frame, if the analysis reads it; else empty.
    pub confidence: &'a [Option<f64>],
    /// Width and height of the frames in pixels; `None` without frames.
    pub frame: Option<(usize, usize)>,
    /// Attributes of the sequence.
    pub attributes: &'a [String],
    /// Attributes of the frames, by name.
    pub frame_attributes: &'a [(String, Vec<bool>)],
}

impl<'a> Trajectory<'a> {
    /// Index of the frame in which the tracker starts.
    pub fn start(&self) -> usize {
        self.status.iter().position(|s| *s != Status::Waiting).unwrap_or(0)
    }

    /// Region that each frame counts as having; `None` if it counts as having none. If the frame [has a
    /// box](Status::has_box) it is that box, else it follows from the rule. Frames before the start have
    /// none.
    pub fn counted(&self, missing: Missing) -> Vec<Option<&'a Region>> {
        let mut last = None;
        let one = |(region, status): (&'a Region, &Status)| {
            let own = status.has_box().then_some(region);
            last = own.or(last);
            if missing == Missing::LastBox { last } else { own }
        };
        self.regions.iter().zip(self.status).map(one).collect()
    }
}

/// Mean of numbers; `None` without numbers.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0_usize), |(s, n), v| (s + v, n + 1));
    (count > 0).then(|| sum / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::{square, trajectory};
    use Status::{Absent, Failed, Initialized, Repeated, Skipped, Tracked, Waiting};

    /// Index of the frame whose region each frame counts as having.
    fn counted(status: &[Status], missing: Missing) -> Vec<Option<usize>> {
        let regions: Vec<Region> = (0..status.len()).map(|t| square(t as f64)).collect();
        let counted = trajectory(&regions, status, &[]).counted(missing);
        counted.into_iter().map(|r| r.map(|r| r.rect().x as usize)).collect()
    }

    // The table of docs/metrics.md: a repeated box is an answer, all others without a box are what the rule says.
    #[test]
    fn statuses_by_hand() {
        let status = [Waiting, Initialized, Tracked, Absent, Repeated, Failed, Skipped, Tracked];
        let (miss, last) = (counted(&status, Missing::Miss), counted(&status, Missing::LastBox));
        assert_eq!(miss, [None, Some(1), Some(2), None, Some(4), None, None, Some(7)]);
        assert_eq!(last, [None, Some(1), Some(2), Some(2), Some(4), Some(4), Some(4), Some(7)]);
    }
}
