use super::*;
use proptest::prelude::*;
use trackfail_core::region::Rect;

fn folder(first: u32, frames: u32, truth: &[u8]) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let img = dir.path().join("img");
    std::fs::create_dir(&img).unwrap();
    for n in first..first + frames {
        std::fs::write(img.join(format!("{n:04}.jpg")), b"").unwrap();
    }
    std::fs::write(dir.path().join("groundtruth_rect.txt"), truth).unwrap();
    dir
}

fn whole(dir: &tempfile::TempDir) -> Result<Sequence, DatasetError> {
    load(dir.path(), &Entry::default())
}

fn rect(x: f64, y: f64, w: f64, h: f64) -> Option<Region> {
    Some(Region::Rect(Rect::new(x, y, w, h)))
}

#[test]
fn counts_from_one_in_the_file_and_from_zero_in_memory() {
    let dir = folder(1, 3, b"\xEF\xBB\xBF1,1,10,20\r\n-4\t7\t1.5\t2\r\n3 4, 5 6");
    let s = whole(&dir).unwrap();
    assert_eq!(s.truth, [rect(0.0, 0.0, 10.0, 20.0), rect(-5.0, 6.0, 1.5, 2.0), rect(2.0, 3.0, 5.0, 6.0)]);
    assert_eq!(s.numbering, Numbering { first: 1, official: (1, 3) });
}

#[test]
fn not_annotated_is_none() {
    let s = whole(&folder(1, 3, b"1,1,2,2\n0,0,0,0\nNaN,NaN,NaN,NaN\n")).unwrap();
    assert_eq!(s.truth, [rect(0.0, 0.0, 2.0, 2.0), None, None]);
}

#[test]
fn faults_name_file_and_line() {
    for (bad, line) in [
        (&b"1,1,2,2\n1,1,0,2"[..], 2),
        (b"1,1,2,-2\n1,1,2,2", 1),
        (b"1,1,2,2\n1,1,2", 2),
        (b"1,1,2,2,3\n1,1,2,2", 1),
        (b"1,1,2,2\n\xFF\xFE", 2),
        (b"1,1,2,2\n1,1,inf,2", 2),
        (b"1,1,2,2\n1,1,nan,2", 2),
        (b"1,1,2,2\n\n1,1,2,2", 2),
        (b"x,y,w,h\n1,1,2,2", 1),
    ] {
        match whole(&folder(1, 2, bad)) {
            Err(DatasetError::Line { path, line: n, .. }) => {
                assert!(path.ends_with("groundtruth_rect.txt"));
                assert_eq!(n, line, "{}", String::from_utf8_lossy(bad));
            }
            other => panic!("{:?}", other.map(|s| s.truth)),
        }
    }
    for empty in [&b""[..], b"\n\r\n", b"\xEF\xBB\xBF"] {
        assert!(whole(&folder(1, 1, empty)).unwrap_err().to_string().contains("empty"));
    }
}

#[test]
fn the_first_line_is_the_first_official_frame() {
    let dir = folder(3, 4, b"1,1,3,1\n1,1,4,1\n1,1,5,1\n1,1,6,1\n1,1,7,1\n");
    let s = whole(&dir).unwrap();
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
    assert!(load(dir.path(), &outside).unwrap_err().to_string().contains("frame 2 is missing"));
}

#[test]
fn a_short_ground_truth_is_an_error() {
    let error = whole(&folder(1, 3, b"1,1,2,2\n1,1,2,2\n")).unwrap_err().to_string();
    assert!(error.contains("2 lines") && error.contains("1 to 3"), "{error}");
}

#[test]
fn targets_attributes_and_plain_folders() {
    let dir = folder(1, 1, b"1,1,2,2");
    std::fs::write(dir.path().join("groundtruth_rect.2.txt"), "1,1,7,7").unwrap();
    std::fs::write(dir.path().join("attributes.txt"), "occlusion, blur\nblur\n").unwrap();
    let options = Entry { name: "Two-2".into(), target: Some(2), ..Entry::default() };
    let s = load(dir.path(), &options).unwrap();
    assert_eq!((s.name.as_str(), &s.truth[0]), ("Two-2", &rect(0.0, 0.0, 7.0, 7.0)));
    assert_eq!(s.attributes, ["blur", "occlusion"]);
    std::fs::write(dir.path().join("attributes.txt"), "blur\nocclusion, =cmd|A0\n").unwrap();
    let error = load(dir.path(), &options).unwrap_err().to_string();
    assert!(error.contains("attributes.txt, line 2: `=cmd|A0`: an attribute is plain text"), "{error}");

    let plain = tempfile::tempdir().unwrap();
    ["a.png", "b.png"].iter().for_each(|n| std::fs::write(plain.path().join(n), b"").unwrap());
    assert!(matches!(whole(&plain), Err(DatasetError::Io { .. })));
    // Whatever else lies there does not matter.
    std::fs::write(plain.path().join("groundtruth_rect.txt"), "1,2").unwrap();
    std::fs::write(plain.path().join("attributes.txt"), b"\xFF").unwrap();
    let s = load_frames(plain.path(), "plain".into(), None).unwrap();
    assert_eq!((s.len(), s.truth, s.numbering.official), (2, vec![None, None], (1, 2)));
}

// In the order of their bytes, as a computer sorts, `img (10)` is the second file.
#[test]
fn a_number_in_brackets_is_the_frame() {
    let dir = tempfile::tempdir().unwrap();
    let frame = |t: u32| dir.path().join(format!("img ({t}).png"));
    (1..=12).for_each(|t| std::fs::write(frame(t), b"").unwrap());
    let lines: String = (1..=12).map(|t| format!("{t},1,2,2\n")).collect();
    std::fs::write(dir.path().join("groundtruth_rect.txt"), lines).unwrap();
    let s = whole(&dir).unwrap();
    let Frames::Files(files) = &s.frames else { panic!("files") };
    assert!(files.iter().eq(&(1..=12).map(frame).collect::<Vec<_>>()));
    assert_eq!(s.truth[9], rect(9.0, 0.0, 2.0, 2.0));
    std::fs::remove_file(frame(7)).unwrap();
    assert!(whole(&dir).unwrap_err().to_string().contains("frame 7 is missing"));
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

proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = whole(&folder(1, 2, &bytes));
    }

    #[test]
    fn any_numbers_are_read_or_refused(text in "[0-9NainF.,;\t\r\n -]{0,60}") {
        if let Ok(s) = whole(&folder(1, 2, text.as_bytes())) {
            prop_assert_eq!(s.truth.len(), 2);
            prop_assert!(s.truth.iter().flatten().all(|r| r.area() > 0.0));
        }
    }
}
