use super::super::tests::{changed, place, read, rect};
use super::*;
use trackfail_testing::assert_near;

#[test]
fn truth_labels_and_meta() {
    let dir = changed("got10k", &[]);
    ::image::RgbImage::new(64, 48).save(dir.path().join("00000001.jpg")).unwrap();
    let s = read("got10k", &dir).unwrap();
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

// python3 (got10k 0.1.3, on the files of the sample as d/val/GOT-10k_Val_000001 and the results below):
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
    let s = read("got10k", &changed("got10k", &[])).unwrap();
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
    assert_near(&overlaps, want, 1e-12, "");
    assert_near([overlaps.iter().sum::<f64>() / 6.0], [0.6602849143610013], 1e-12, "mean");
}

#[test]
fn absent_is_what_either_label_or_the_box_says() {
    let truths = |changes: &[(&str, &str)]| {
        let s = read("got10k", &changed("got10k", changes)).unwrap();
        s.truth.iter().map(Option::is_some).collect::<Vec<bool>>()
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
    let truth = [("groundtruth.txt", "1,1,2,2\r\n1 1\t3 2\r\n")];
    let s = read("got10k", &place("got10k", 1..=2, &truth)).unwrap();
    assert!(s.attributes.is_empty() && s.frame_attributes.is_empty());
    assert_eq!(s.truth[1], rect(0.0, 0.0, 3.0, 2.0));
}
