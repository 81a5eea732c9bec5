//! Writers of result files in the formats of evaluation programs. Other programs and [`super::super::replay`]
//! read these files. A number is the same bit for bit after it is written and read.

use super::Base;
use crate::tracker::Status;
use crate::tracker::trax::numbers;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use trackfail_core::region::Region;

/// Line of a frame in which the tracker says that the target is absent. The VOT toolkit and OTB's evaluation
/// read it as a frame without a region, `replay` as absence if its `without_area` says so.
const ABSENT: &str = "nan,nan,nan,nan";

/// A run of the VOT reset protocol: marks 1 (start), 2 (failure) and 0 (skipped), and 0-based regions.
pub fn vot(regions: &[Region], status: &[Status]) -> String {
    let mut text = String::new();
    for (region, status) in regions.iter().zip(status) {
        let _ = match status {
            Status::Initialized => writeln!(text, "1"),
            Status::Failed => writeln!(text, "2"),
            Status::Skipped | Status::Waiting => writeln!(text, "0"),
            Status::Absent => writeln!(text, "{ABSENT}"),
            Status::Tracked | Status::Repeated => writeln!(text, "{}", numbers(region)),
        };
    }
    text
}

/// A pass over a sequence in the format of OTB: one 1-based box per line, always four numbers. A polygon is
/// written as its upright bounding box.
pub fn otb(regions: &[Region], status: &[Status]) -> String {
    boxes(regions, status, Base::One)
}

/// Upright rectangles of regions, one `x,y,w,h` per line.
pub fn boxes(regions: &[Region], status: &[Status], base: Base) -> String {
    let line = |(region, status): (&Region, &Status)| match status {
        Status::Absent => format!("{ABSENT}\n"),
        _ => numbers(&base.from_zero(&Region::Rect(region.rect()))) + "\n",
    };
    regions.iter().zip(status).map(line).collect()
}

/// The confidence of each frame, as the VOT toolkit writes a property: one line per frame, empty where there
/// is none.
pub fn confidence(values: &[Option<f64>]) -> String {
    values.iter().map(|value| value.map(|v| v.to_string()).unwrap_or_default() + "\n").collect()
}

/// Path of the file with the confidence that belongs to a file of boxes.
pub fn confidence_path(boxes: &Path) -> PathBuf {
    let stem = boxes.file_stem().unwrap_or_default().to_string_lossy();
    boxes.with_file_name(format!("{stem}_confidence.value"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::{RunContext, TrackerState, replay, testing};
    use proptest::prelude::*;
    use trackfail_core::region::Rect;
    use trackfail_dataset::Sequence;
    use trackfail_testing::put;

    #[test]
    fn marks_and_regions() {
        let square = Region::Rect(Rect::new(0.1, -2.0, 3.0, 4.5));
        let turned = Region::Polygon(vec![(0.0, 0.0), (4.0, 1.0), (3.0, 5.0)]);
        use Status::{Failed, Initialized, Skipped, Tracked};
        let mixed = [square.clone(), turned.clone()];
        assert_eq!(otb(&mixed, &[Initialized, Tracked]), "1.1,-1,3,4.5\n1,1,4,5\n");
        let regions = [square.clone(), turned, square.clone(), square.clone(), square.clone()];
        let text = vot(&regions, &[Initialized, Tracked, Failed, Skipped, Tracked]);
        assert_eq!(text, "1\n0,0,4,1,3,5\n2\n0\n0.1,-2,3,4.5\n");
        let (twice, status) = ([square.clone(), square], [Tracked, Status::Absent]);
        assert_eq!(otb(&twice, &status), "1.1,-1,3,4.5\nnan,nan,nan,nan\n");
        assert_eq!(vot(&twice, &status), "0.1,-2,3,4.5\nnan,nan,nan,nan\n");
        assert_eq!(boxes(&twice, &status, Base::One), "1.1,-1,3,4.5\nnan,nan,nan,nan\n");
        assert_eq!(boxes(&twice, &status, Base::Zero), "0.1,-2,3,4.5\nnan,nan,nan,nan\n");
        assert_eq!(vot(&mixed, &[Initialized, Status::Repeated]), "1\n0,0,4,1,3,5\n");
        assert_eq!(confidence(&[None, Some(0.1), Some(-2.0)]), "\n0.1\n-2\n");
        assert_eq!(confidence_path(Path::new("a/S.1.txt")), Path::new("a/S.1_confidence.value"));
    }

    type Frame = ((f64, f64, f64, f64), bool, Option<f64>);

    /// Random frames: box, whether the target is there, and confidence; the target is there in the first
    /// frame.
    fn track() -> impl Strategy<Value = Vec<Frame>> {
        let number = -99.0..99.0_f64;
        let size = 0.5..99.0_f64;
        let region = (number.clone(), number, size.clone(), size);
        let frame = (region, prop::bool::weighted(0.8), prop::option::of(-1e3..1e3_f64));
        prop::collection::vec(frame, 2..20).prop_map(|mut frames| {
            frames[0].1 = true;
            frames
        })
    }

    proptest! {
        #[test]
        fn written_tracks_are_read_back(frames in track(), folder in 0..2_usize) {
            let mut states: Vec<TrackerState> = Vec::new();
            for (t, &((x, y, w, h), there, confidence)) in frames.iter().enumerate() {
                let region = Region::Rect(Rect::new(x, y, w, h));
                let mut state = match (t, there) {
                    (0, _) => TrackerState::initialized(region),
                    (_, true) => TrackerState::tracked(region),
                    _ => TrackerState::new(states[t - 1].region.clone(), Status::Absent),
                };
                state.confidence = confidence;
                states.push(state);
            }
            let regions: Vec<Region> = states.iter().map(|s| s.region.clone()).collect();
            let status: Vec<Status> = states.iter().map(|s| s.status).collect();
            let values: Vec<Option<f64>> = states.iter().map(|s| s.confidence).collect();
            let root = tempfile::tempdir().unwrap();
            let file = ["results/a/S.txt", "results/a/S/S_001.txt"][folder];
            let path = put(root.path(), file, &[otb(&regions, &status), vot(&regions, &status)][folder]);
            let confident = values.iter().any(Option::is_some);
            if confident {
                std::fs::write(confidence_path(&path), confidence(&values)).unwrap();
            }
            let replay = replay::ENTRY.build_from_text("{ results = \"a\", without_area = \"absent\" }").unwrap();
            let truth = regions.iter().cloned().map(Some).collect();
            let sequence = Sequence { truth, ..testing::rendered("S", states.len()) };
            let roots = [root.path().to_path_buf()];
            let context = RunContext { data_roots: &roots, ..testing::context(&sequence, 0) };
            prop_assert_eq!(replay.gives_confidence(&context), confident);
            let pixel = trackfail_core::image::Frame::new(1, 1, vec![0; 3]);
            let (mut tracker, first) = replay.start(&context, &pixel, &regions[0]).unwrap();
            let mut back = vec![first];
            back.extend((1..states.len()).map(|_| tracker.update(&pixel).unwrap()));
            if folder == 0 {
                // One is added and taken away again.
                states.iter_mut().for_each(|s| s.region = s.region.shifted(1.0, 1.0).shifted(-1.0, -1.0));
            }
            prop_assert_eq!(back, states);
        }
    }
}
