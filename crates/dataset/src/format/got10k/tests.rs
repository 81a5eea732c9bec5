use super::*;
use proptest::prelude::*;
use trackfail_core::region::{Rect, Region};

const META: &str = "[METAINFO]\nurl: http://x/y\nanno_fps: 10Hz\nobject_class: Jet Ski\nmotion_class: sliding\n\
                    root_class: Artifact\nresolution: (64, 48)\n";

fn folder(frames: u32, files: &[(&str, &str)]) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    for n in 1..=frames {
        let path = dir.path().join(format!("{n:08}.jpg"));
        ::image::RgbImage::new(64, 48).save(path).unwrap();
    }
    for (name, text) in files {
        std::fs::write(dir.path().join(name), text).unwrap();
    }
    dir
}

const FIVE: [(&str, &str); 5] = [
    (
        "groundtruth.txt",
        "10.0000,8.0000,20.0000,10.0000\n12.0000,8.0000,20.0000,10.0000\n14.5000,9.0000,20.0000,10.0000\n\
         0.0000,0.0000,0.0000,0.0000\n20.0000,10.0000,16.0000,12.5000\n",
    ),
    ("absence.label", "0\n0\n0\n1\n0\n"),
    ("cover.label", "8\n8\n3\n0\n6\n"),
    ("cut_by_image.label", "0\n0\n0\n0\n1\n"),
    ("meta_info.ini", META),
];

fn five(changes: &[(&str, &str)]) -> Result<Sequence, DatasetError> {
    load(folder(5, &[&FIVE[..], changes].concat()).path(), &Entry { name: "x".into(), ..Entry::default() })
}

fn rect(x: f64, y: f64, w: f64, h: f64) -> Option<Region> {
    Some(Region::Rect(Rect::new(x, y, w, h)))
}

#[test]
fn truth_labels_and_meta() {
    let dir = folder(5, &FIVE);
    let s = load(dir.path(), &Entry { name: "x".into(), ..Entry::default() }).unwrap();
    assert_eq!(s.truth[0], rect(9.0, 7.0, 20.0, 10.0));
    assert_eq!(s.truth[3], None);
    assert_eq!((s.number(0), s.numbering.official, s.size().unwrap()), (1, (1, 5), (64, 48)));
    let flags = |ones: &[usize]| (0..5).map(|t| ones.contains(&t)).collect::<Vec<bool>>();
    let want = [
        ("absence", flags(&[3])),
        ("cut_by_image", flags(&[4])),
        ("heavy-occlusion", flags(&[2])),
        ("occlusion", flags(&[2, 4])),
    ];
    assert_eq!(s.frame_attributes, want.map(|(name, flags)| (name.to_owned(), flags)));
    let all = ["absence", "class-jet-ski", "cut_by_image", "heavy-occlusion", "motion-sliding", "occlusion"];
    assert_eq!(s.attributes, all);
}

// python3 (got10k 0.1.3, on the files of FIVE as d/val/GOT-10k_Val_000001 and the results below):
//   p = ExperimentGOT10k('d', 'val', 'results', 'reports').report(['T'])
//   p['T']['overall']['ao'], p['T']['overall']['sr']     0.6602849143610013 0.8333333333333334
//   rect_iou(boxes[1:], anno[1:], bound=(64, 48))        [1.0, 0.8181818181818182, 0.0, 0.5810276679841897]
//                                                        [0.5625, 0.0, 0.0, 1.0]
#[test]
fn overlaps_are_those_of_the_got10k_toolkit() {
    let runs = [
        "10.000,8.000,20.000,10.000\n12.000,8.000,20.000,10.000\n16.500,9.000,20.000,10.000\n\
         18.000,9.000,20.000,10.000\n22.000,12.000,16.000,12.500\n",
        "10.000,8.000,20.000,10.000\n14.000,10.000,20.000,10.000\n40.000,30.000,5.000,5.000\n\
         18.000,9.000,20.000,10.000\n20.000,10.000,16.000,12.500\n",
    ];
    let s = five(&[]).unwrap();
    let mut overlaps = Vec::new();
    for text in runs {
        let boxes = (FORMAT.parse_truth)(Path::new("run.txt"), text.as_bytes()).unwrap();
        // The toolkit leaves out the first frame and those of which nothing is visible.
        for (b, truth) in boxes.iter().zip(&s.truth).skip(1) {
            let (Some(b), Some(truth)) = (b, truth) else { continue };
            let shared = b.intersection(truth);
            overlaps.push(shared / (b.area() + truth.area() - shared));
        }
    }
    let want = [1.0, 0.8181818181818182, 0.5810276679841897, 0.5625, 0.0, 1.0];
    assert_eq!(overlaps.len(), want.len());
    for (got, want) in overlaps.iter().zip(want) {
        assert!((got - want).abs() < 1e-12, "{got} {want}");
    }
    let mean = overlaps.iter().sum::<f64>() / 6.0;
    assert!((mean - 0.6602849143610013).abs() < 1e-12, "{mean}");
    let above = overlaps.iter().filter(|o| **o > 0.5).count();
    assert_eq!(above, 5, "5 of 6 are 0.8333333333333334");
}

#[test]
fn absent_is_what_either_label_or_the_box_says() {
    let truths = |changes: &[(&str, &str)]| {
        five(changes).unwrap().truth.iter().map(Option::is_some).collect::<Vec<bool>>()
    };
    assert_eq!(truths(&[("absence.label", "0\n1\n0\n0\n0")]), [true, false, true, false, true]);
    assert_eq!(truths(&[("cover.label", "8\n8\n0\n8\n8")]), [true, true, false, false, true]);
    // What stands in a frame without target is no box and need not look like one.
    let box_of_absent = "1,1,2,2\n1,1,2,2\n1,1,2,2\n7,7,0,-1\n1,1,2,2";
    assert_eq!(truths(&[("groundtruth.txt", box_of_absent)]), [true, true, true, false, true]);
    let nan = "1,1,2,2\n1,1,2,2\nNaN,NaN,NaN,NaN\n1,1,2,2\n1,1,2,2";
    assert_eq!(truths(&[("groundtruth.txt", nan)]), [true, true, false, false, true]);
}

#[test]
fn files_beside_the_truth_may_be_missing() {
    let s =
        load(folder(2, &[("groundtruth.txt", "1,1,2,2\r\n1 1\t3 2\r\n")]).path(), &Entry::default()).unwrap();
    assert!(s.attributes.is_empty() && s.frame_attributes.is_empty());
    assert_eq!(s.truth[1], rect(0.0, 0.0, 3.0, 2.0));
}

#[test]
fn faults_name_file_and_line_or_both_counts() {
    for (file, text, words) in [
        (
            "groundtruth.txt",
            "1,1,2,2\n1,1,2\n1,1,2,2\n1,1,2,2\n1,1,2,2",
            ["groundtruth.txt, line 2", "3 numbers"],
        ),
        ("groundtruth.txt", "1,1,2,2\n1,1,2,2\n1,1,0,2\n1,1,2,2\n1,1,2,2", ["groundtruth.txt, line 3", ""]),
        ("groundtruth.txt", "1,1,2,2\n1,1,inf,2\n1,1,1,2\n1,1,2,2\n1,1,2,2", ["groundtruth.txt, line 2", ""]),
        ("groundtruth.txt", "1,1,2,2\n\n1,1,2,2", ["groundtruth.txt, line 2", "empty line"]),
        ("groundtruth.txt", "", ["groundtruth.txt", "empty"]),
        ("absence.label", "0\n0\n0\n1\n", ["absence.label", "4 labels for 5"]),
        ("absence.label", "0\n0\n0\n2\n0", ["absence.label, line 4", "`2`"]),
        ("cover.label", "8\n8\n9\n0\n6", ["cover.label, line 3", "`9`"]),
        ("cover.label", "8\n8\n8\n0\n6\n8", ["cover.label", "6 labels for 5"]),
        ("cut_by_image.label", "", ["cut_by_image.label", "0 labels for 5"]),
        ("meta_info.ini", "[METAINFO]\nurl", ["meta_info.ini, line 2", "key: value"]),
    ] {
        let error = five(&[(file, text)]).unwrap_err().to_string();
        assert!(words.iter().all(|w| error.contains(w)), "{file}, {text:?}: {error}");
    }
    let count = |frames, lines: usize| {
        let text = "1,1,2,2\n".repeat(lines);
        load(folder(frames, &[("groundtruth.txt", &text)]).path(), &Entry::default()).unwrap_err().to_string()
    };
    assert!(count(3, 2).contains("3 images, but 2 lines"), "{}", count(3, 2));
    assert!(count(2, 3).contains("2 images, but 3 lines"));
    assert!(count(9, 1).contains("9 images, but 1 lines") && count(9, 1).contains("test set"));
    let gap = folder(3, &[("groundtruth.txt", "1,1,2,2\n1,1,2,2\n1,1,2,2")]);
    std::fs::rename(gap.path().join("00000002.jpg"), gap.path().join("00000004.jpg")).unwrap();
    assert!(load(gap.path(), &Entry::default()).unwrap_err().to_string().contains("frame 2 is missing"));
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300), file in 0..5_usize) {
        let dir = folder(1, &[("groundtruth.txt", "1,2,3,4")]);
        std::fs::write(dir.path().join(FIVE[file].0), &bytes).unwrap();
        let _ = load(dir.path(), &Entry::default());
    }
}
