//! Writers of result files in the formats of evaluation programs, for other programs and
//! [`super::super::replay`]. A number that is written and read again has the same bits.

use super::Base;
use crate::region::Region;
use crate::tracker::Status;
use std::fmt::Write as _;

/// `x,y,w,h` or the corners `x1,y1,...`, joined by commas.
fn numbers(region: &Region) -> String {
    let values = match region {
        Region::Rect(r) => vec![r.x, r.y, r.w, r.h],
        Region::Polygon(corners) => corners.iter().flat_map(|c| [c.0, c.1]).collect(),
    };
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

/// A run of the VOT reset protocol: marks 1 (start), 2 (failure), 0 (skipped), and regions, 0-based.
pub fn vot(regions: &[Region], status: &[Status]) -> String {
    let mut text = String::new();
    for (region, status) in regions.iter().zip(status) {
        let _ = match status {
            Status::Initialized => writeln!(text, "1"),
            Status::Failed => writeln!(text, "2"),
            Status::Skipped | Status::Waiting | Status::Absent => writeln!(text, "0"),
            Status::Tracked => writeln!(text, "{}", numbers(region)),
        };
    }
    text
}

/// A pass over a sequence in the format of OTB: one region per line, 1-based.
pub fn otb(regions: &[Region]) -> String {
    regions.iter().map(|region| numbers(&Base::One.from_zero(region)) + "\n").collect()
}

/// The rectangles of regions, one `x,y,w,h` per line.
pub fn boxes(regions: &[Region], base: Base) -> String {
    let rect = |region: &Region| base.from_zero(&Region::Rect(region.rect()));
    regions.iter().map(|region| numbers(&rect(region)) + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::Rect;
    use crate::tracker::results::{otb_text, vot as read};
    use proptest::prelude::*;

    #[test]
    fn marks_and_regions() {
        let square = Region::Rect(Rect::new(0.1, -2.0, 3.0, 4.5));
        let turned = Region::Polygon(vec![(0.0, 0.0), (4.0, 1.0), (3.0, 5.0)]);
        use Status::{Failed, Initialized, Skipped, Tracked};
        let regions = [square.clone(), turned, square.clone(), square.clone(), square.clone()];
        let text = vot(&regions, &[Initialized, Tracked, Failed, Skipped, Tracked]);
        assert_eq!(text, "1\n0,0,4,1,3,5\n2\n0\n0.1,-2,3,4.5\n");
        assert_eq!(otb(std::slice::from_ref(&square)), "1.1,-1,3,4.5\n");
        assert_eq!(boxes(std::slice::from_ref(&square), Base::One), "1.1,-1,3,4.5\n");
        assert_eq!(boxes(&[square], Base::Zero), "0.1,-2,3,4.5\n");
    }

    proptest! {
        #[test]
        fn written_results_are_read_back(
            boxes in prop::collection::vec((-99.0..99.0, -99.0..99.0, 0.5..99.0, 0.5..99.0), 2..20),
        ) {
            let regions: Vec<Region> =
                boxes.iter().map(|b| Region::Rect(Rect::new(b.0, b.1, b.2, b.3))).collect();
            let mut status = vec![Status::Tracked; regions.len()];
            status[0] = Status::Initialized;
            let truth: Vec<_> = regions.iter().cloned().map(Some).collect();
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a_001.txt");
            std::fs::write(&path, vot(&regions, &status)).unwrap();
            let back = read::read(&path, &truth).unwrap();
            prop_assert_eq!(back.iter().map(|s| s.region.clone()).collect::<Vec<_>>(), regions.clone());
            prop_assert_eq!(back.iter().map(|s| s.status).collect::<Vec<_>>(), status);
            std::fs::write(&path, otb(&regions)).unwrap();
            let back = otb_text::read_boxes(&path, Base::One).unwrap();
            for (back, region) in back.iter().zip(&regions) {
                // One is added and taken away again.
                prop_assert_eq!(back, &region.shifted(1.0, 1.0).shifted(-1.0, -1.0));
            }
        }
    }
}
