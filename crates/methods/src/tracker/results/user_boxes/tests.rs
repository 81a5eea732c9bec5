use super::*;
use proptest::prelude::*;

fn read(text: &str, options: &Options) -> Result<UserBoxes, DatasetError> {
    parse(Path::new("a.txt"), text.as_bytes(), options)
}

fn rect(x: f64, y: f64, w: f64, h: f64) -> Option<Region> {
    Some(Region::Rect(Rect::new(x, y, w, h)))
}

fn only(boxes: UserBoxes) -> Vec<Option<Region>> {
    assert_eq!((boxes.targets.len(), boxes.targets[0].id), (1, None));
    boxes.targets[0].regions.clone()
}

const SIZE: Options =
    Options { format: None, base: None, absent: false, frames: None, size: Some((200, 100)) };

#[test]
fn one_box_in_every_format() {
    let want = vec![rect(10.0, 20.0, 40.0, 30.0)];
    for (text, format) in [
        ("11,21,40,30", BoxFormat::Xywh),
        ("x1,y1,x2,y2\n11,21,51,51", BoxFormat::Xyxy),
        ("xmin ymin xmax ymax\n11 21 51 51\n", BoxFormat::Xyxy),
        ("X;Y;Width;Height\r\n11;21;40;30\r\n", BoxFormat::Xywh),
        ("10,20,40,30\n", BoxFormat::Vot),
        ("0.15 0.35 0.2 0.3", BoxFormat::Yolo),
        ("7 0.15 0.35 0.2 0.3", BoxFormat::Yolo),
        ("7 0.15 0.35 0.2 0.3 0.99", BoxFormat::Yolo),
    ] {
        let found = read(text, &SIZE).unwrap();
        if format != BoxFormat::Vot {
            assert_eq!(found.format, format, "{text}");
        }
        let named = Options { format: Some(format), ..SIZE };
        let named = only(read(text, &named).unwrap());
        let near = |a: &Option<Region>, b: &Option<Region>| {
            let (a, b) = (a.as_ref().unwrap().bounds(), b.as_ref().unwrap().bounds());
            [a.x - b.x, a.y - b.y, a.w - b.w, a.h - b.h].iter().all(|d| d.abs() < 1e-9)
        };
        assert!(near(&named[0], &want[0]), "{text}: {named:?}");
    }
    let zero = Options { base: Some(Base::Zero), ..SIZE };
    assert_eq!(only(read("10,20,40,30", &zero).unwrap()), want);
    let corners = "10.5,20,50,20,50,50,10,50.5";
    let found = read(corners, &SIZE).unwrap();
    assert_eq!(found.format, BoxFormat::Vot);
    assert!(matches!(&only(found)[0], Some(Region::Polygon(p)) if p[2] == (50.0, 50.0)));
}

#[test]
fn a_format_in_doubt_is_asked_for() {
    for (text, words) in [
        ("1,1,10,20,30,20,30,40", "8 numbers may be a row of MOTChallenge or a polygon"),
        ("1,1,10,20,30,40", "6 numbers may be"),
        ("1,2,3,4,5", "5 numbers fits no format"),
        ("1,2", "2 numbers fits no format"),
        ("1,2,3,4,5,6,7,8,9,10,11", "11 numbers fits no format"),
    ] {
        let message = read(text, &Options::default()).unwrap_err().to_string();
        assert!(message.contains(words) && message.starts_with("a.txt, line 1: "), "{message}");
    }
    let mot = Options { format: Some(BoxFormat::Mot), ..Options::default() };
    assert_eq!(read("1,1,10,20,30,40", &mot).unwrap().targets[0].id, Some(1));
    let vot = Options { format: Some(BoxFormat::Vot), ..Options::default() };
    assert_eq!(read("1,1,10,1,10,20", &vot).unwrap().targets[0].id, None);
}

#[test]
fn targets_of_motchallenge() {
    let text = "2,7,11,21,40,30,1,-1,-1,-1\n1,7,11,21,40,30,1,-1,-1,-1\n3,-4,1,1,5,5,0.5,-1,-1,-1\n";
    let boxes = read(text, &SIZE).unwrap();
    assert_eq!((boxes.format, boxes.frames), (BoxFormat::Mot, 3));
    let ids: Vec<_> = boxes.targets.iter().map(|t| t.id).collect();
    assert_eq!(ids, [Some(-4), Some(7)]);
    assert_eq!(boxes.targets[0].regions, [None, None, rect(0.0, 0.0, 5.0, 5.0)]);
    let seven = rect(10.0, 20.0, 40.0, 30.0);
    assert_eq!(boxes.targets[1].regions, [seven.clone(), seven, None]);
    let five = Options { frames: Some(5), ..SIZE };
    assert_eq!(read(text, &five).unwrap().targets[0].regions.len(), 5);
    let two = Options { frames: Some(2), ..SIZE };
    let message = read(text, &two).unwrap_err().to_string();
    assert!(message.contains("line 3: frame 3, but there are 2 frames"), "{message}");
    for (text, words) in [
        ("1,1,1,1,5,5,1\n1,1,2,2,5,5,1\n", "line 2: a second row of target 1 in frame 1"),
        ("0,1,1,1,5,5,1\n", "line 1: frame (from 1 on)"),
        ("1.5,1,1,1,5,5,1\n", "line 1: frame (from 1 on)"),
        ("1,1,1,1,5,5,1\n1,2,3\n", "line 2: 3 columns"),
        ("1,1,1,1,5,5,1\n\n2,1,1,1,5,5,1\n", "line 2: 0 columns"),
        ("999999999,1,1,1,5,5,1\n", "1 targets in 999999999 frames; at most 5000000"),
    ] {
        let message = read(text, &Options::default()).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn absence_is_an_error_unless_it_is_expected() {
    let absent = Options { absent: true, frames: Some(6), ..SIZE };
    let text = "\n11,21,40,30\nnan,nan,nan,nan\nNaN\n0,0,0,0\n500,21,40,30\n";
    let regions = only(read(text, &absent).unwrap());
    assert_eq!(regions, [None, rect(10.0, 20.0, 40.0, 30.0), None, None, None, None]);
    // Empty lines at the end are frames only where so many are needed.
    for (frames, lines) in [(Some(3), 3), (Some(9), 1), (None, 1)] {
        let absent = Options { frames, ..absent };
        assert_eq!(read("11,21,40,30\n\n\n\n", &absent).unwrap().frames, lines);
    }
    for (text, line) in [
        ("11,21,40,30\n\n11,21,40,30", 2),
        ("11,21,40,30\nnan,nan,nan,nan", 2),
        ("11,21,40,30\n11,21,nan,30", 2),
        ("11,21,0,30", 1),
        ("11,21,40,30\n202,21,40,30", 2),
        ("11,21,40,30\n-40,21,40,30", 2),
    ] {
        match read(text, &SIZE).unwrap_err() {
            DatasetError::Line { line: n, message, .. } => {
                assert!(n == line && message.contains("--absent"), "{text}: {n} {message}");
            }
            other => panic!("{text}: {other}"),
        }
    }
    let message = read("11,21,40,30\n202,21,40,30", &SIZE).unwrap_err().to_string();
    assert!(message.contains("202,21,40,30") && message.contains("200x100"), "{message}");
    // Never absent, whatever is expected.
    for text in ["11,21,inf,30", "11,21,40", "11,21,40,x", "1e16,1,1,1"] {
        assert!(read(&format!("11,21,40,30\n{text}"), &absent).is_err(), "{text}");
    }
    assert!(read("nan,nan,nan,nan\n", &absent).unwrap_err().to_string().contains("no frame has a box"));
    // Marks of the VOT protocol are frames without a box by their format.
    let marks =
        read("1\n10,20,40,30\n2\n0\n1\n10,20,40,30\n", &Options { format: Some(BoxFormat::Vot), ..SIZE });
    let regions = only(marks.unwrap());
    assert_eq!(
        regions.iter().map(Option::is_some).collect::<Vec<_>>(),
        [false, true, false, false, false, true]
    );
}

#[test]
fn shares_need_the_size_of_the_frames() {
    let yolo = Options { format: Some(BoxFormat::Yolo), ..Options::default() };
    assert!(read("0 0.5 0.5 0.1 0.1", &yolo).unwrap_err().to_string().contains("give --frames"));
    let sized = Options { size: Some((200, 100)), ..yolo };
    assert!(read("11,21,40,30", &sized).unwrap_err().to_string().contains("are these pixels"));
    assert!(
        read("0 0.5 0.5 0.1 0.1 1 7", &sized).unwrap_err().to_string().contains("no box of the format yolo")
    );
}

const VALID: &[u8] = b"x,y,w,h\r\n5,2,10,2.5\r\n\r\n1e2\t1E-2\t1\t1\nnan nan nan nan\n7 8 9 10";

proptest! {
    #[test]
    fn damaged_boxes_are_read_or_refused(bytes in trackfail_testing::damaged(VALID), format in 0..6_usize, absent: bool) {
        let format = BoxFormat::NAMED.get(format).map(|(format, _)| *format);
        let options = Options { format, absent, ..SIZE };
        if let Ok(boxes) = parse(Path::new("a.txt"), &bytes, &options) {
            for target in &boxes.targets {
                prop_assert_eq!(target.regions.len(), boxes.frames);
                prop_assert!(target.regions.iter().flatten().all(|r| r.area() > 0.0 && !is_outside(r, (200, 100))));
            }
        }
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300), absent: bool) {
        let _ = parse(Path::new("a.txt"), &bytes, &Options { absent, ..Options::default() });
    }
}
