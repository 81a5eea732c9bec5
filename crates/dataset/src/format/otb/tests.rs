use super::super::tests::{place, read, rect};
use super::*;
use trackfail_testing::{assert_says, put};

fn folder(images: std::ops::RangeInclusive<u32>, truth: &str) -> tempfile::TempDir {
    place("otb", images, &[("groundtruth_rect.txt", truth)])
}

#[test]
fn counts_from_one_in_the_file_and_from_zero_in_memory() {
    let text = "\u{feff}1,1,10,20\r\n-4\t7\t1.5\t2\r\n3 4, 5 6\n0,0,0,0\nNaN,NaN,NaN,NaN\n";
    let s = read("otb", &folder(1..=5, text)).unwrap();
    let boxes = [rect(0.0, 0.0, 10.0, 20.0), rect(-5.0, 6.0, 1.5, 2.0), rect(2.0, 3.0, 5.0, 6.0)];
    assert_eq!(s.truth[..3], boxes);
    assert_eq!(s.truth[3..], [None, None], "what is not annotated is none");
    assert_eq!(s.numbering, Numbering { first: 1, official: (1, 5) });
}

#[test]
fn the_first_line_is_the_first_official_frame() {
    let dir = folder(3..=6, "1,1,3,1\n1,1,4,1\n1,1,5,1\n1,1,6,1\n1,1,7,1\n");
    let s = read("otb", &dir).unwrap();
    assert_eq!((s.numbering.first, s.numbering.official), (3, (3, 7)));
    assert_eq!(s.truth[1], rect(0.0, 0.0, 4.0, 1.0));
    let cut = Entry { range: Some((4, 5)), official: Some((3, 7)), ..Entry::default() };
    let s = load(dir.path(), &cut).unwrap();
    assert_eq!((s.len(), s.number(0)), (2, 4));
    assert_eq!(s.truth[0], rect(0.0, 0.0, 4.0, 1.0));
    // Five lines for official frames 3..=5: counted from 1.
    let other = Entry { range: Some((4, 5)), official: Some((3, 5)), ..Entry::default() };
    assert_eq!(load(dir.path(), &other).unwrap().truth[0], rect(0.0, 0.0, 6.0, 1.0));
    let outside = Entry { range: Some((2, 4)), ..Entry::default() };
    assert_says(load(dir.path(), &outside).unwrap_err(), "frame 2 is missing");
}

#[test]
fn targets_attributes_and_plain_folders() {
    let dir = folder(1..=1, "1,1,2,2");
    put(dir.path(), "groundtruth_rect.2.txt", "1,1,7,7");
    put(dir.path(), "attributes.txt", "occlusion, blur\nblur\n");
    let options = Entry { name: "Two-2".into(), target: Some(2), ..Entry::default() };
    let s = load(dir.path(), &options).unwrap();
    assert_eq!((s.name.as_str(), &s.truth[0]), ("Two-2", &rect(0.0, 0.0, 7.0, 7.0)));
    assert_eq!(s.attributes, ["blur", "occlusion"]);

    let plain = trackfail_testing::folder([("a.png", ""), ("b.png", "")]);
    assert!(matches!(read("otb", &plain), Err(DatasetError::Io { .. })));
    // Whatever else lies there does not matter.
    put(plain.path(), "groundtruth_rect.txt", "1,2");
    put(plain.path(), "attributes.txt", b"\xFF");
    let s = load_frames(plain.path(), "plain".into(), None).unwrap();
    assert_eq!((s.len(), s.truth, s.numbering.official), (2, vec![None, None], (1, 2)));
}

#[test]
fn boxes_are_read_without_frames() {
    // Six lines for the official frames 3 to 6: the file starts at frame 1.
    let dir =
        trackfail_testing::folder([("Tiger1.txt", "1,1,5,5\n2,1,5,5\n3,1,5,5\n4,1,5,5\n0,0,0,0\n6,1,5,5\n")]);
    let file = dir.path().join("Tiger1.txt");
    let part = Entry { official: Some((3, 6)), range: Some((4, 6)), ..Entry::default() };
    let sequence = load_boxes(&file, &part).unwrap();
    assert_eq!((sequence.name.as_str(), sequence.numbering.first), ("Tiger1", 4));
    assert_eq!(sequence.truth, [rect(3.0, 0.0, 5.0, 5.0), None, rect(5.0, 0.0, 5.0, 5.0)]);
    assert!(!sequence.has_frames());
    assert_says(sequence.frame(0).unwrap_err(), "has no frames");
    assert_eq!(sequence.digest().unwrap(), sequence.digest_anew().unwrap());
    let short = Entry { official: Some((1, 7)), ..Entry::default() };
    assert_says(load_boxes(&file, &short).unwrap_err(), "do not cover");
}

// Values read off groundtruth_rect.txt and OTB2013.json (an independent copy of the annotation).
#[trackfail_testing::needs(real_data)]
#[test]
fn real_sequences() {
    let root = trackfail_testing::real_data();
    let david = load(&root.join("otb/David"), &Entry::default()).unwrap();
    assert_eq!((david.len(), david.numbering.official), (201, (300, 770)));
    assert_eq!(david.truth[0], rect(128.0, 79.0, 64.0, 78.0));
    let frame = david.frame(200).unwrap();
    assert_eq!((frame.width(), frame.height()), (320, 240));
    let second = Entry { target: Some(2), ..Entry::default() };
    let jogging = load(&root.join("otb/Jogging"), &second).unwrap();
    assert_eq!((jogging.len(), &jogging.truth[0]), (307, &rect(179.0, 78.0, 37.0, 114.0)));
    let woman = load(&root.join("otb/Woman"), &Entry::default()).unwrap();
    assert_eq!((woman.len(), woman.numbering.official), (150, (1, 597)));
}
