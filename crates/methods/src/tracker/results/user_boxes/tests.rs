use super::*;
use proptest::prelude::*;
use trackfail_testing::{assert_near, assert_says};

fn read(text: &str, options: &Options) -> Result<UserBoxes, UserBoxesError> {
    parse(Path::new("a.txt"), text.as_bytes(), options)
}

fn rect(x: f64, y: f64, w: f64, h: f64) -> Option<Region> {
    Some(Region::Rect(Rect::new(x, y, w, h)))
}

/// The regions of the only target.
fn only(text: &str, options: &Options) -> Vec<Option<Region>> {
    let boxes = read(text, options).unwrap();
    assert_eq!((boxes.targets.len(), boxes.targets[0].id), (1, None));
    boxes.targets[0].regions.clone()
}

/// Options for frames of this size.
fn sized() -> Options {
    Options { size: Some((200, 100)), ..Options::default() }
}

fn named(format: &str) -> Option<BoxFormat> {
    Some(BoxFormat::read(format).unwrap())
}

/// Formats that a file may have, as text for the option; one if there is no doubt.
fn formats(text: &str, options: &Options) -> Vec<String> {
    match read(text, options) {
        Ok(boxes) => vec![boxes.format.option()],
        Err(UserBoxesError::Doubt { candidates, .. }) => {
            candidates.iter().map(|c| c.format.option()).collect()
        }
        Err(e) => panic!("{text}: {e}"),
    }
}

#[test]
fn one_box_in_every_format() {
    let want = vec![rect(10.0, 20.0, 40.0, 30.0)];
    for (text, format) in [
        ("11,21,40,30", "xywh"),
        ("x1,y1,x2,y2\n11,21,51,51", "xyxy"),
        ("xmin ymin xmax ymax\n11 21 51 51\n", "xyxy"),
        ("X;Y;Width;Height\r\n11;21;40;30\r\n", "xywh"),
        ("10,20,40,30\n", "vot"),
        ("0.15 0.35 0.2 0.3", "yolo"),
        ("7 0.15 0.35 0.2 0.3", "yolo"),
        ("7 0.15 0.35 0.2 0.3 0.99", "yolo"),
        ("7 0.15 0.35 0.2 0.3 0.99 2", "yolo"),
    ] {
        let found = read(text, &sized()).unwrap();
        if format != "vot" {
            assert_eq!(found.format.option(), format, "{text}");
        }
        let found = only(text, &Options { format: named(format), ..sized() });
        let found = found[0].as_ref().unwrap().bounds();
        assert_near([found.x, found.y, found.w, found.h], [10.0, 20.0, 40.0, 30.0], 1e-9, text);
    }
    let zero = Options { base: Some(Base::Zero), ..sized() };
    assert_eq!(only("10,20,40,30", &zero), want);
    let corners = "10.5,20,50,20,50,50,10,50.5";
    assert_eq!(formats(corners, &sized()), ["vot"]);
    assert!(matches!(&only(corners, &sized())[0], Some(Region::Polygon(p)) if p[2] == (50.0, 50.0)));
}

/// A target of 24 x 18 pixels that moves to the right and down through a frame of 160 x 120 pixels: index of
/// the frame, and left, top, width, height.
fn track() -> impl Iterator<Item = (usize, [f64; 4])> {
    (0..30).map(|t| (t, [21.0 + (4 * t) as f64, 31.0 + t as f64, 24.0, 18.0]))
}

fn lines(line: impl Fn(usize, [f64; 4]) -> String) -> String {
    track().map(|(t, b)| line(t, b) + "\n").collect()
}

/// Options for the frames of the track.
fn of_track() -> Options {
    Options { size: Some((160, 120)), frames: Some(30), ..Options::default() }
}

// Layouts that trackers and detectors write, and the format of each: ultralytics' `track(save_txt)`, boxmot, ByteTrack,
// MOTChallenge, tables.
#[test]
fn a_layout_is_known_by_its_numbers() {
    type Line = fn(usize, [f64; 4]) -> String;
    let cases: [(&str, Line); 14] = [
        ("xywh", |_, [x, y, w, h]| format!("{x},{y},{w},{h}")),
        ("xyxy", |_, [x, y, w, h]| format!("{x},{y},{},{}", x + w, y + h)),
        ("x1,y1,x2,y2,confidence,class", |_, [x, y, w, h]| {
            format!("{} {} {} {} 0.87 0", x - 0.88, y - 0.5, x - 0.88 + w, y - 0.5 + h)
        }),
        ("x,y,w,h,confidence,class", |_, [x, y, w, h]| format!("{},{y},{w},{h},0.9,1", x + 0.5)),
        ("x,y,w,h,confidence", |t, [x, y, w, h]| format!("{x},{y},{w},{h},0.{}", t + 10)),
        ("mot", |t, [x, y, w, h]| format!("{t},1,{x},{y},{w},{h},1,-1,-1,-1")),
        ("mot", |t, [x, y, w, h]| format!("{},1,{x},{y},{w},{h},1", t + 1)),
        ("mot", |t, [x, y, w, h]| format!("{},1,{x},{y},{w},{h},1,1", t + 1)),
        ("frame,id,x1,y1,x2,y2,confidence", |t, [x, y, w, h]| {
            format!("{},4,{x},{y},{},{},0.75", t + 1, x + w, y + h)
        }),
        ("frame,x,y,w,h", |t, [x, y, w, h]| format!("{},{x},{y},{w},{h}", t + 1)),
        ("frame,x,y,w,h", |t, [x, y, w, h]| format!("{t},{x},{y},{w},{h}")),
        ("x1,y1,x2,y2,class,confidence,other", |_, [x, y, w, h]| {
            format!("{x} {y} {} {} 3 0.5 0", x + w, y + h)
        }),
        ("frame,cx,cy,w,h", |t, [x, y, w, h]| {
            format!("{} {} {} {} {}", t + 1, (x + 11.0) / 160.0, (y + 8.0) / 120.0, w / 160.0, h / 120.0)
        }),
        ("yolo", |_, [x, y, w, h]| {
            format!("0 {} {} {} {} 2", (x + 11.0) / 160.0, (y + 8.0) / 120.0, w / 160.0, h / 120.0)
        }),
    ];
    for (format, line) in cases {
        let text = lines(line);
        assert_eq!(formats(&text, &of_track()), [format], "{text}");
    }
    // 4 numbers that all leave the frame as left, top, width, height.
    assert_eq!(formats(&"100,70,150,110\n".repeat(9), &of_track()), ["xyxy"]);
    // As steady as such boxes would be, and in the frame: nothing speaks against the custom.
    assert_eq!(formats(&"1,1,9,9\n".repeat(9), &of_track()), ["xywh"]);
    // Corners of a small target in the upper left, which are whole boxes in the frame as well.
    let small: String = (0..9).map(|t| format!("{t},{t},{},{}\n", 20 + t, 20 + t)).collect();
    assert_eq!(formats(&small, &of_track()), ["xywh", "xyxy"]);
    assert_eq!(formats(&small, &Options::default()), ["xywh", "xyxy"]);
}

#[test]
fn a_format_in_doubt_is_asked_for_with_all_that_fit() {
    // Rounded corners of a target that moves by a pixel now and then: as sizes they vary as the target's place does.
    let rounded = |t: usize| {
        let (x, y) = (60.0 + 2.0 * (t as f64 / 9.0).sin(), 20.0 + 2.0 * (t as f64 / 7.0).cos());
        [x, y, x + 30.4, y + 18.6].map(|v: f64| v.round().to_string()).join(",") + "\n"
    };
    let rounded: String = (0..90).map(rounded).collect();
    assert_eq!(formats(&rounded, &of_track()), ["xywh", "xyxy"]);
    // Boxes of a target that comes nearer do not.
    let grows = |t: usize| format!("{},{},{},{}\n", 30 - t / 12, 25 - t / 12, 50 + t / 6, 40 + t / 6);
    assert_eq!(formats(&(0..90).map(grows).collect::<String>(), &of_track()), ["xywh"]);

    let any = Options::default();
    assert_eq!(formats("1,1,30,1,30,40,1,40", &any), ["mot", "vot"]);
    let six = formats("1,1,10,20,30,40", &any);
    assert!(six.contains(&"frame,id,x1,y1,x2,y2".to_string()) && six.len() > 1, "{six:?}");
    let error = read("1,1,30,1,30,40,1,40", &any).unwrap_err().to_string();
    assert_eq!(
        error,
        "a.txt: the numbers may be frame,id,x,y,w,h (the first box is 30 wide and 40 high at 30,1) or corners of \
         polygons (the first box is 29 wide and 39 high at 1,1)"
    );
    for (text, numbers) in [("1,2", 2), ("20.5,3,90,7,1.5,88", 6), ("1,2,3,4,5,6,7,8,9,10,11", 11)] {
        let message = read(text, &any).unwrap_err().to_string();
        assert!(message.starts_with("a.txt, line 1: "), "{message}");
        assert_says(message, format!("{numbers} numbers fits no format"));
    }
    for (format, text, id) in [("mot", "1,1,10,20,30,40", Some(1)), ("vot", "1,1,10,1,10,20", None)] {
        let options = Options { format: named(format), ..Options::default() };
        assert_eq!(read(text, &options).unwrap().targets[0].id, id);
    }
}

#[test]
fn a_header_names_the_columns() {
    let one = rect(10.0, 20.0, 40.0, 30.0);
    for text in [
        "frame;BBox_Left;BBox_Top;BBox_Width;BBox_Height\n1;11;21;40;30",
        "x_center,y_center,width,height\n31,36,40,30",
        "ymin,xmin,ymax,xmax\n21,11,51,51",
        "y,x,h,w\n21,11,30,40",
        "# x y w h\n11 21 40 30",
        ",x,y,w,h\n0,11,21,40,30",
        "\tx\ty\tw\th\n0\t11\t21\t40\t30",
        "frame\tname\tx\ty\tw\th\n1\t\t11\t21\t40\t30",
        "frame\tx\ty\tw\th\t\r\n1\t11\t21\t40\t30\t\r\n",
        "1.1e1\t2.1e1\t40\t30\t",
        "label,file,x1,y1,x2,y2\ntraffic light,img 1.png,11,21,51,51",
        // Those of the object detection of TensorFlow: `width` and `height` are the image's.
        "filename,width,height,class,xmin,ymin,xmax,ymax\n1.jpg,200,100,car,11,21,51,51",
        "score\tTop\tLeft\tBottom\tRight\n0.5\t21\t11\t51\t51",
        "xmin,ymin,xmax,ymax\n0.05,0.2,0.25,0.5",
    ] {
        assert_eq!(only(text, &sized()), std::slice::from_ref(&one), "{text}");
    }
    let text = "track_id,frame,x,y,w,h\n7,0,11,21,40,30\n8,1,11,21,40,30\n7,2,11,21,40,30\n";
    let boxes = read(text, &sized()).unwrap();
    assert_eq!((boxes.first, boxes.frames, boxes.targets.len()), (Some(0), 3, 2));
    assert_eq!(boxes.targets[0].regions, [one.clone(), None, one.clone()]);
    assert_eq!(read("x1,y1,x2,y2,x3,y3\n1,1,9,1,1,9", &sized()).unwrap().format, BoxFormat::Vot);
    // Of shares, `x` and `y` may be those of the center.
    assert_eq!(formats("x,y,w,h\n0.3,0.3,0.2,0.2", &sized()), ["x,y,w,h", "cx,cy,w,h"]);
    assert_eq!(formats("x,y,w,h\n0.95,0.5,0.2,0.2\n0.97,0.5,0.2,0.2", &sized()), ["cx,cy,w,h"]);
    // An empty box is one without numbers, but half of one is a fault.
    let absent = Options { absent: true, ..sized() };
    let regions = only("x,y,w,h,name\n11,21,40,30,car\n,,,,car\n", &absent);
    assert_eq!(regions, [one.clone(), None]);
    assert!(read("x,y,w,h\n11,21,40,30\n11,21,40,\n", &absent).is_err());
    let refused = [
        ("a,b,c,d\n1,2,3,4", "`a,b,c,d` names no whole box"),
        ("x,y,w\n1,2,3", "names no whole box"),
        ("x,left,y,w,h\n1,2,3,4,5", "two columns for one thing"),
        ("frame,x1,y1,x2,y2,x3,y3\n1,2,3,4,5,6,7", "more than two corners"),
        ("x,y,w,h\n1,2,3,4,5", "line 2: 5 numbers, which are no box"),
    ];
    assert_refused(&sized(), &refused);
    // Whoever names the format is obeyed, and a header beats the format of another file.
    let given = Options { format: named("x,y,x2,y2"), ..sized() };
    assert_eq!(only("a,b,c,d\n11,21,51,51", &given), std::slice::from_ref(&one));
    let usual = Options { usual: named("xywh"), ..sized() };
    assert_eq!(only("x1,y1,x2,y2\n11,21,51,51", &usual), [one]);
}

#[test]
fn words_for_columns_are_checked() {
    for (text, option) in [
        ("xyxy", "xyxy"),
        ("left,top,right,bottom", "x1,y1,x2,y2"),
        ("Frame, ID, x, y, w, h", "frame,id,x,y,w,h"),
        ("x1,y1,x2,y2,x3,y3,x4,y4", "vot"),
        ("other,cx,cy,w,h,conf", "other,cx,cy,w,h,confidence"),
    ] {
        assert_eq!(BoxFormat::read(text).unwrap().option(), option);
    }
    for (text, words) in [
        ("xyxw", "did you mean `xyxy`?"),
        ("frmae,x,y,w,h", "did you mean `frame`?"),
        ("x,y", "names no whole box"),
        ("", "unknown format or column ``"),
    ] {
        assert_says(BoxFormat::read(text).unwrap_err(), words);
    }
}

// vot-toolkit 0.9.0, write_trajectory_binary: struct.pack("<hI", 1, len(data)), then "<Bffff" a rectangle.
#[test]
fn bytes_of_the_vot_toolkit_have_a_remedy() {
    let bytes =
        b"\x01\x00\x01\x00\x00\x00\x01\x00\x00\x80\x3f\x00\x00\x80\x3f\x00\x00\x80\x3f\x00\x00\x80\x3f";
    let message = parse(Path::new("a_001.bin"), bytes, &sized()).unwrap_err().to_string();
    assert!(message.starts_with("a_001.bin: ") && message.contains("write_trajectory"), "{message}");
}

#[test]
fn targets_of_motchallenge() {
    let text = "2,7,11,21,40,30,1,-1,-1,-1\n1,7,11,21,40,30,1,-1,-1,-1\n3,-4,1,1,5,5,0.5,-1,-1,-1\n";
    let boxes = read(text, &sized()).unwrap();
    assert_eq!((boxes.format, boxes.first, boxes.frames), (BoxFormat::mot(), Some(1), 3));
    let ids: Vec<_> = boxes.targets.iter().map(|t| t.id).collect();
    assert_eq!(ids, [Some(-4), Some(7)]);
    let seven = || rect(10.0, 20.0, 40.0, 30.0);
    assert_eq!(boxes.targets[0].regions, [None, None, rect(0.0, 0.0, 5.0, 5.0)]);
    assert_eq!(boxes.targets[1].regions, [seven(), seven(), None]);
    let of_frames = |frames| Options { frames: Some(frames), ..sized() };
    assert_eq!(read(text, &of_frames(5)).unwrap().targets[0].regions.len(), 5);
    assert_refused(&of_frames(2), &[(text, "line 3: frame 3, but there are 2 frames")]);
    // Frames count from 0 where there is one of that number.
    let zero = read("0,7,11,21,40,30,1\n2,7,11,21,40,30,1\n", &sized()).unwrap();
    assert_eq!((zero.first, &zero.targets[0].regions[..]), (Some(0), &[seven(), None, seven()][..]));
    // Numbers that fit those of the files alone are theirs; those that fit both count from 1, with a warning.
    let of_files = Options { number: Some(11), ..of_frames(3) };
    let eleven = read("11,7,11,21,40,30,1\n13,7,11,21,40,30,1\n", &of_files).unwrap();
    assert_eq!((eleven.first, &eleven.targets[0].regions[..]), (Some(11), &[seven(), None, seven()][..]));
    let both = Options { number: Some(2), ..of_frames(3) };
    for (text, regions, is_in_doubt) in [
        ("2,7,11,21,40,30,1\n3,7,11,21,40,30,1\n", [None, seven(), seven()], true),
        ("1,7,11,21,40,30,1\n3,7,11,21,40,30,1\n", [seven(), None, seven()], false),
    ] {
        let boxes = read(text, &both).unwrap();
        assert_eq!((boxes.first, &boxes.targets[0].regions[..]), (Some(1), &regions[..]));
        let notes = boxes.notes("a.txt", &both);
        assert_eq!(notes.iter().any(|note| note.contains("whose file has number 2")), is_in_doubt);
    }
    // A file of the same kind counts alike, whether it has the first frame or not.
    let first = |first| Options { first: Some(first), ..of_frames(3) };
    let later = "1,7,11,21,40,30,1\n2,7,11,21,40,30,1\n";
    assert_eq!(read(later, &first(0)).unwrap().targets[0].regions, [None, seven(), seven()]);
    assert_eq!(read(later, &first(1)).unwrap().targets[0].regions, [seven(), seven(), None]);
    // Its own numbers may tell.
    assert_eq!(read("0,7,11,21,40,30,1\n", &first(1)).unwrap().first, Some(0));
    assert_eq!(read("1,7,11,21,40,30,1\n3,7,11,21,40,30,1\n", &first(0)).unwrap().first, Some(1));
    let beyond = "line 2: frame 3, but there are 3 frames, counted from 0";
    assert_refused(&of_frames(3), &[("0,7,11,21,40,30,1\n3,7,11,21,40,30,1\n", beyond)]);
    let refused = [
        ("1,1,1,1,5,5,1\n1,1,2,2,5,5,1\n", "line 2: a second row of target 1 in frame 1"),
        ("-1,1,1,1,5,5,1\n", "line 1: frame (from 0 or 1 on)"),
        ("1.5,1,1,1,5,5,1\n", "line 1: frame (from 0 or 1 on)"),
        ("1,1,1,1,5,5,1\n1,2,3\n", "line 2: 3 columns"),
        ("1,1,1,1,5,5,1\n\n2,1,1,1,5,5,1\n", "line 2: 0 columns"),
        ("999999999,1,1,1,5,5,1\n", "1 targets in 999999999 frames; at most 5000000"),
    ];
    assert_refused(&Options::default(), &refused);
}

#[test]
fn absence_is_an_error_unless_it_is_expected() {
    let absent = Options { absent: true, frames: Some(6), ..sized() };
    let text = "\n11,21,40,30\nnan,nan,nan,nan\nNaN\n0,0,0,0\n500,21,40,30\n";
    let regions = only(text, &absent);
    assert_eq!(regions, [None, rect(10.0, 20.0, 40.0, 30.0), None, None, None, None]);
    // Empty lines at the end are frames only where so many are needed.
    for (frames, lines) in [(Some(3), 3), (Some(9), 1), (None, 1)] {
        let absent = Options { frames, ..absent.clone() };
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
        match read(text, &sized()).unwrap_err() {
            UserBoxesError::Data(DatasetError::Line { line: n, message, .. }) => {
                assert!(n == line && message.contains("--absent"), "{text}: {n} {message}");
            }
            other => panic!("{text}: {other}"),
        }
    }
    let outside = "11,21,40,30\n202,21,40,30";
    assert_refused(&sized(), &[(outside, "202,21,40,30"), (outside, "200x100")]);
    // Never absent, whatever is expected.
    for text in ["11,21,inf,30", "11,21,40", "11,21,40,x", "1e16,1,1,1"] {
        assert!(read(&format!("11,21,40,30\n{text}"), &absent).is_err(), "{text}");
    }
    assert_refused(&absent, &[("nan,nan,nan,nan\n", "no frame has a box")]);
    // Of several targets only some may have none.
    let of_any = Options { frames: None, ..absent };
    let of_two = read("1,1,11,21,40,30,1\n1,2,500,21,40,30,1\n", &of_any).unwrap();
    assert_eq!(of_two.targets[1].regions, [None]);
    let empty = read("frame\tx\ty\tw\th\n1\t11\t21\t40\t30\n2\t\t\t\t\n", &of_any);
    assert_eq!(empty.unwrap().targets[0].regions, [rect(10.0, 20.0, 40.0, 30.0), None]);
    // A mark of -1 says nothing of the others.
    let mark = "-1,-1,-1,-1\n";
    for (text, format) in
        [("11,21,140,70\n12,22,140,70\n", "xywh"), ("0.1,0.3,0.2,0.4\n0.1,0.3,0.2,0.4\n", "yolo")]
    {
        let boxes = read(&format!("{text}{mark}"), &of_any).unwrap();
        assert_eq!((boxes.format.option().as_str(), &boxes.targets[0].regions[2]), (format, &None));
    }
    let shares = format!("x1,y1,x2,y2\n0.05,0.2,0.25,0.5\n{mark}");
    assert_eq!(only(&shares, &of_any), [rect(10.0, 20.0, 40.0, 30.0), None]);
    // Marks of the VOT protocol are frames without a box by their format.
    let marks = "1\n10,20,40,30\n2\n0\n1\n10,20,40,30\n";
    let regions = only(marks, &Options { format: Some(BoxFormat::Vot), ..sized() });
    assert!(regions.iter().map(Option::is_some).eq([false, true, false, false, false, true]));
}

#[test]
fn shares_need_the_size_of_the_frames() {
    let yolo = Options { format: Some(BoxFormat::Yolo), ..Options::default() };
    assert_refused(&Options::default(), &[("x1,y1,x2,y2\n0.1,0.1,0.5,0.5", "give --frames")]);
    assert_refused(&yolo, &[("0 0.5 0.5 0.1 0.1", "give --frames")]);
    let sized = Options { size: Some((200, 100)), ..yolo.clone() };
    let refused =
        [("11,21,40,30", "are these pixels"), ("0 0.5 0.5 0.1 0.1 1 7 7", "no box of the format yolo")];
    assert_refused(&sized, &refused);
}

/// Fails unless each text is refused with its words.
fn assert_refused(options: &Options, cases: &[(&str, &str)]) {
    for (text, words) in cases {
        assert_says(read(text, options).unwrap_err(), words);
    }
}

const VALID: &[u8] = b"x,y,w,h\r\n5,2,10,2.5\r\n\r\n1e2\t1E-2\t1\t1\nnan nan nan nan\n7 8 9 10";

proptest! {
    #[test]
    fn any_boxes_are_read_or_refused(
        bytes in prop_oneof![trackfail_testing::damaged(VALID), prop::collection::vec(any::<u8>(), 0..300)],
        format in 0..6_usize, absent: bool, is_sized: bool,
    ) {
        let format = NAMED.get(format).and_then(|name| named(name));
        let options = Options { format, absent, size: sized().size.filter(|_| is_sized), ..sized() };
        if let Ok(boxes) = parse(Path::new("a.txt"), &bytes, &options) {
            for target in &boxes.targets {
                prop_assert_eq!(target.regions.len(), boxes.frames);
                let is_box = |r: &Region| r.area() > 0.0 && !(is_sized && is_outside(r, (200, 100)));
                prop_assert!(target.regions.iter().flatten().all(is_box));
            }
        }
    }

    // Written with a header, in any order of columns, boxes are read as they are.
    #[test]
    fn a_header_gives_back_what_was_written(
        boxes in prop::collection::vec((0.0..90.0, 0.0..40.0, 0.5..90.0, 0.5..50.0), 1..9),
        kind in 0..3_usize,
        order in Just([0_usize, 1, 2, 3, 4, 5]).prop_shuffle(),
        separator in prop::sample::select(vec![",", ";", "\t"]),
        upper: bool,
    ) {
        let words = [["x", "y", "w", "h"], ["xmin", "y1", "right", "y_max"], ["cx", "y_center", "width", "bb_height"]][kind];
        let words = [words[0], words[1], words[2], words[3], "frame_id", "note"];
        let row = |cells: [String; 6]| order.map(|k| cells[k].clone()).join(separator) + "\n";
        let mut text = row(words.map(|word| if upper { word.to_uppercase() } else { word.to_string() }));
        for (t, (x, y, w, h)) in boxes.iter().enumerate() {
            let [a, b, c, d] = [[*x, *y, *w, *h], [*x, *y, x + w, y + h], [x + w / 2.0, y + h / 2.0, *w, *h]][kind];
            let [a, b, c, d] = [a, b, c, d].map(|v: f64| v.to_string());
            text += &row([a, b, c, d, t.to_string(), "a b".to_string()]);
        }
        let options = Options { base: Some(Base::Zero), ..sized() };
        // Boxes below a pixel are those of shares.
        prop_assume!(boxes.iter().any(|b| b.0.max(b.1).max(b.2).max(b.3) > 1.5));
        let found = only(&text, &options);
        prop_assert_eq!(found.len(), boxes.len());
        for (region, (x, y, w, h)) in found.iter().zip(&boxes) {
            let r = region.as_ref().unwrap().bounds();
            assert_near([r.x, r.y, r.w, r.h], [*x, *y, *w, *h], 1e-9, &text);
        }
    }
}
