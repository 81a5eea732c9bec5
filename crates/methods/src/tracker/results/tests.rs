//! Property tests of the alignment of frames, and of all readers on damaged texts.

use super::*;
use crate::tracker::testing;
use proptest::prelude::*;
use std::path::Path;

fn numbering(first: u32, last: u32) -> Numbering {
    Numbering { first, official: (first, last) }
}

#[test]
fn david_and_tiger1_are_counted_both_ways() {
    for (official, counted, firsts) in [
        ((300, 770), &[(300, 770), (1, 471), (300, 500), (1, 201)][..], Some(300)),
        ((300, 770), &[(24, 471)], Some(323)),
        ((300, 770), &[(1, 770), (310, 400)], None),
        ((6, 354), &[(6, 354), (1, 349)], Some(6)),
        ((6, 354), &[(18, 349)], Some(23)),
        ((6, 354), &[(6, 300)], None),
        ((1, 252), &[(1, 252)], Some(1)),
        ((1, 252), &[(0, 252)], None),
        ((0, 9), &[(1, 10), (0, 9)], Some(0)),
        ((9, 5), &[(1, 1)], None),
    ] {
        let found = counted.iter().map(|counted| align(*counted, numbering(official.0, official.1)).ok());
        assert!(found.clone().all(|first| first == firsts), "{official:?}: {:?}", found.collect::<Vec<_>>());
    }
}

/// A valid text in each format.
const VALID: [&[u8]; 6] = [
    b"\n0.998765\n\n0.25\n",
    b"1\r\n9,0,1,1\r\n2\n0\n1\n0,0,0,5,6,5,6,0\n",
    b"x,y,w,h\r\n5,-2,10,2.5\r\n1e2\t1E-2\t1\t1\n7 8 9 10",
    b"2,3,5.00,6.00,7.50,8.25,1,-1,-1,-1\n4,3,6.00,6.00,7.50,8.25,-1,-1,-1,-1\n",
    b"vid1,obj0,2,true,0.75,0.25,0.5,0.5,0.75\r\nvid1,obj0,3,false,-1.5,,,,\r\n",
    br#"[{"startFrame":1,"endFrame":2,"resType":"rect","res":[[1,1,4,4],[2.5,1,4,4]]},
        {"startFrame":2,"endFrame":2,"resType":"ivtAff","tmplsize":[32,32],"res":[[27,179,1.3,0,0,0.8]]}]"#,
];

/// Gives the bytes to all readers, for a sequence of this number of frames. What a reader accepts must have
/// one value per frame.
fn read_as_everything(bytes: &[u8], frames: usize) {
    let (path, sequence) = (Path::new("a.txt"), testing::rendered("S", frames));
    if let Ok(values) = confidence::parse(path, bytes, frames) {
        assert_eq!(values.len(), frames);
        assert!(values.iter().flatten().all(|v| v.is_finite()));
    }
    if let Ok(boxes) = parse_boxes(path, bytes, Base::One) {
        assert!(!boxes.is_empty() && boxes.iter().all(|r| r.area() > 0.0));
    }
    let rows = || rows::read(path, bytes);
    let vot = rows().and_then(|rows| vot::parse(path, rows, &sequence.truth, Base::Zero, None));
    let boxes = rows().and_then(|rows| otb_text::parse(path, rows, &sequence, Base::One));
    // A frame without a box is lawful, but not the first one.
    let is_boxes = boxes.as_ref().is_ok_and(|boxes| boxes.regions[0].is_ok());
    if let Ok(states) = vot {
        assert!(states.len() == frames && !is_boxes, "no file is of both formats");
    }
    let mot = rows().and_then(|rows| mot::parse(path, rows, &sequence, Base::One, None));
    for boxes in [boxes, mot, oxuva::parse(path, bytes, &sequence)].into_iter().flatten() {
        assert_eq!(boxes.regions.len(), frames);
        assert!([0, frames].contains(&boxes.confidence.len()));
    }
    for run in 0..3 {
        if let Ok(boxes) = otb_json::parse(path, bytes, run, sequence.numbering, Base::One) {
            assert!(boxes.first >= 1 && (1..=frames).contains(&boxes.regions.len()));
        }
    }
}

proptest! {
    #[test]
    fn an_aligned_result_lies_in_the_official_range(
        first in 0..400_u32, span in 1..500_u32, start in 0..900_u32, count in 1..900_u32,
    ) {
        let n = numbering(first, first + span - 1);
        // Half of the cases end where real results end.
        let start = if start % 2 == 0 { (first + span).saturating_sub(count) } else { start };
        if let Ok(at) = align((start, start + count - 1), n) {
            prop_assert!(at >= n.official.0 && at + count - 1 <= n.official.1);
        }
    }

    #[test]
    fn any_texts_are_read_or_refused(
        bytes in prop_oneof![
            prop::sample::select(VALID.to_vec()).prop_flat_map(trackfail_testing::damaged),
            prop::collection::vec(any::<u8>(), 0..300),
            "(1\n)?([0-3]\n|[0-3.,\t\r ]{0,20}\n){0,7}".prop_map(String::into_bytes),
        ],
        frames in 1..8_usize,
    ) {
        read_as_everything(&bytes, frames);
    }

    #[test]
    fn any_segments_are_read_or_refused(
        start in any::<u32>(), end in any::<u32>(), rows in "(\\[[-0-9.e,]{0,12}\\],?){0,5}", kind in "rect|ivtAff",
    ) {
        for (start, end) in [(start, end), (1, 5)] {
            let text = format!(
                r#"[{{"startFrame":{start},"endFrame":{end},"resType":"{kind}","tmplsize":[32,32],"res":[{rows}]}}]"#
            );
            read_as_everything(text.as_bytes(), 5);
        }
    }
}
