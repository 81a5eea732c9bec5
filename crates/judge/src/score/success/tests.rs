use super::*;
use crate::score::testing::trajectory;
use crate::tracker::Status;
use proptest::prelude::*;
use trackfail_testing::assert_near;

/// Checks the two numbers of a curve.
#[track_caller]
fn near(curves: &Curves, auc: f64, precision: f64, what: impl std::fmt::Display) {
    assert_near([curves.auc(), curves.precision_at_20()], [auc, precision], 1e-12, what);
}

fn square(x: f64) -> Rect {
    Rect::new(x, 100.0, 40.0, 40.0)
}

fn rules(name: &str) -> &'static Rules {
    RULES.iter().find(|r| r.name == name).unwrap()
}

/// Curves of a track in which frames without a box have the status `without`.
fn of_track(rules: &Rules, boxes: &[Option<Rect>], truth: &[Option<Rect>], without: Status) -> Curves {
    let mut last = square(0.0);
    let region = |b: &Option<Rect>| {
        last = b.unwrap_or(last);
        Region::Rect(last)
    };
    let regions: Vec<Region> = boxes.iter().map(region).collect();
    let status: Vec<Status> =
        boxes.iter().map(|b| if b.is_some() { Status::Tracked } else { without }).collect();
    let truth: Vec<Option<Region>> = truth.iter().map(|t| t.map(Region::Rect)).collect();
    rules.curves(&trajectory(&regions, &status, &truth))
}

/// A thousand frames with boxes 40 pixels wide that drift after frame 600 by whole pixels `d`. Their overlap
/// is `(40 - d) / (40 + d)`.
fn drifting() -> (Vec<Option<Rect>>, Vec<Option<Rect>>) {
    let shift = |t: usize| match t {
        0 => 10.0,
        1..=574 => 8.0,
        575..=596 => 7.0,
        699 => 36.0,
        _ => 200.0,
    };
    let truth = |t: usize| if (706..750).contains(&t) { 98.0 } else { 100.0 };
    let boxes = (0..1000).map(|t| Some(square(100.0 + shift(t)))).collect();
    (boxes, (0..1000).map(|t| Some(square(truth(t)))).collect())
}

// AUC and P@20 of the OTB formula, pysot-toolkit and got10k-toolkit for the same thousand boxes (drift after
// 600; a fifth of the frames annotated as 0,0,0,0 or NaN; 50 frames reported as NaN or 0,0,0,0), as measured
// with these programs.
#[test]
fn the_same_boxes_score_as_the_three_programs_say() {
    let (boxes, truth) = drifting();
    let without = |list: &[Option<Rect>], from: usize, to: usize| {
        let mut list = list.to_vec();
        list[from..to].fill(None);
        list
    };
    let absent = without(&truth, 750, 950);
    let lost = without(&boxes, 700, 750);
    let clean = [("0.3994", "0.5970"), ("0.3990", "0.5970"), ("0.3994", "0.5970")];
    let unannotated = [("0.3994", "0.7970"), ("0.3990", "0.7970"), ("0.3994", "0.5970")];
    let silent = [("0.4021", "0.5970"), ("0.3990", "0.5970"), ("0.3994", "0.5970")];
    for (boxes, truth, expected) in
        [(&boxes, &truth, clean), (&boxes, &absent, unannotated), (&lost, &truth, silent)]
    {
        for (rules, (auc, precision)) in RULES.iter().zip(expected) {
            let curves = of_track(rules, boxes, truth, Status::Absent);
            assert_eq!(format!("{:.4}", curves.auc()), auc, "{}", rules.name);
            assert_eq!(format!("{:.4}", curves.precision_at_20()), precision, "{}", rules.name);
        }
    }
}

// python3 with got10k 0.1.3: from got10k.experiments import ExperimentOTB; e = object.__new__(ExperimentOTB)
//   e.nbins_iou, e.nbins_ce = 21, 51; b = np.array([[10, 20, 30, 40], [14, 21, 28, 44], [60, 20, 30, 40.]])
//   g = np.array([[10, 20, 30, 40], [10, 22, 30, 40], [35, 25, 20, 60.]]); i, c = e._calc_metrics(b, g)
//   s, p = e._calc_curves(i, c); s.mean(), p[20], p[4]
#[test]
fn curves_are_those_of_got10k() {
    let of = |rows: [[f64; 4]; 3]| rows.map(|r| Some(Rect::new(r[0], r[1], r[2], r[3])));
    let boxes = of([[10.0, 20.0, 30.0, 40.0], [14.0, 21.0, 28.0, 44.0], [60.0, 20.0, 30.0, 40.0]]);
    let truth = of([[10.0, 20.0, 30.0, 40.0], [10.0, 22.0, 30.0, 40.0], [35.0, 25.0, 20.0, 60.0]]);
    let curves = RULES[2].of_boxes(&boxes, &truth);
    near(&curves, 5.0 / 9.0, 2.0 / 3.0, "got10k");
    assert_eq!(curves.precision[4], 2.0 / 3.0);
    let empty = Curves { success: vec![0.0; OVERLAPS], precision: vec![0.0; ERRORS] };
    assert_eq!(Curves::mean([&curves, &empty, &empty].map(|c| (1.0, c))).unwrap().precision[4], 2.0 / 9.0);
    // Of 100 frames and 50.
    let pooled = Curves::mean([(100.0, &curves), (50.0, &empty)]).unwrap();
    assert!((pooled.precision[4] - 4.0 / 9.0).abs() < 1e-12);
    assert_eq!(Curves::mean([]), None);
    assert_eq!(iou(&Rect::new(1.0, 1.0, 0.0, 0.0), &Rect::new(1.0, 1.0, 0.0, 0.0)), 0.0);
}

// python3 with NumPy: numpy.arange(0, 1.05, .05) is above i / 20 for these i. MATLAB's `0:0.05:1` is symmetric.
#[test]
fn thresholds_are_those_of_the_languages() {
    let above = |language: Language| -> Vec<usize> {
        (0..OVERLAPS).filter(|i| language.overlap_threshold(*i) > overlap_threshold(*i)).collect()
    };
    assert_eq!(above(Language::Python), [3, 6, 7, 12, 14, 17, 19]);
    assert_eq!(above(Language::Matlab), [3, 6, 7]);
    // An overlap of .6 and a bit counts in one of them.
    let counts = |language: Language| language.overlaps_below(0.600_000_000_000_000_1);
    assert_eq!((counts(Language::Matlab), counts(Language::Python)), (13, 12));
}

// By hand: 1-based numbers are positive from the first pixel on.
#[test]
fn the_first_pixel_counts_and_what_is_left_of_it_does_not() {
    let of = |annotated: Annotated, w: f64| {
        [(0.0, 0.0), (-1.0, 0.0), (0.0, -1.0)]
            .map(|(x, y)| annotated.includes(&Rect::new(x - w / 2.0, y - w / 2.0, w, w)))
    };
    assert_eq!(of(Annotated::Corner, 0.0), [true, false, false]);
    assert_eq!(of(Annotated::Center, 1.0), [true, false, false]);
}

// A target at the left border, x = 0 in OTB's pixels: not annotated for the OTB formula, whose rule asks for
// x > 0, and annotated for the others.
#[test]
fn a_target_that_touches_the_border() {
    let boxes = [50.0, -1.0].map(|x| Some(square(x)));
    let of = |k: usize| RULES[k].of_boxes(&boxes, &boxes);
    // In the first frame 20 of 21 thresholds are below an overlap of 1.
    assert_eq!((of(0).success[0], of(0).precision[0]), (0.5, 1.0));
    assert_eq!((of(1).success[0], of(2).success[0]), (1.0, 1.0));
    assert!((of(1).auc() - 20.0 / 21.0).abs() < 1e-12);
}

/// Forty boxes of 24 x 18 pixels, like the target of the tests below, that move by whole pixels per frame.
fn moving(right: f64, down: f64) -> Vec<Option<Rect>> {
    let at = |t: f64| Rect::new(20.0 + right * t, 30.0 + down * t, 24.0, 18.0);
    (0..40).map(|t| Some(at(f64::from(t)))).collect()
}

// Boxes of 0,0,0,0 in frames 2 to 40 of a target at 21,31 that stands still, and in frames 11 to 15 of one that moves by 2, 1.
// python3 with got10k 0.1.3, as in `curves_are_those_of_got10k`, b[0] = g[0]; the equations of STVIR/pysot
// (toolkit/utils/statistics.py), pysot-toolkit (pysot/utils/statistics.py) and LaSOT's toolkit (utils/calc_seq_err_robust.m,
// utils/eval_tracker.m; the OTB toolkit's are the same without absent frames) in NumPy 2. NaN boxes give the same numbers.
#[test]
fn frames_without_a_box_are_what_the_programs_take_them_for() {
    let (still, moved) = (moving(0.0, 0.0), moving(2.0, 1.0));
    let (mut given_up, mut gap) = (still.clone(), moved.clone());
    given_up[1..].fill(None);
    gap[10..15].fill(None);
    let miss = [(1.0 / 42.0, 0.025), (5.0 / 6.0, 0.875)];
    let stays = [(20.0 / 21.0, 1.0), (751.0 / 840.0, 1.0)];
    for (names, without_box) in [("got10k pysot pysot-toolkit", miss), ("otb-matlab lasot", stays)] {
        for (name, k) in names.split(' ').flat_map(|name| [(name, 0), (name, 1)]) {
            let (boxes, truth) = [(&given_up, &still), (&gap, &moved)][k];
            // Frames that a reset protocol failed in or skipped have no box either. A box that is repeated is an answer, by
            // every rule that of the box that stands.
            for without in [Status::Absent, Status::Skipped, Status::Failed, Status::Repeated] {
                let curves = of_track(rules(&format!("{name}/1")), boxes, truth, without);
                let (auc, precision) = if without == Status::Repeated { stays[k] } else { without_box[k] };
                near(&curves, auc, precision, format!("{name} {without:?}"));
            }
        }
    }
}

// The equations as above. The target's left side is at x = 0 of the file in the second half of the frames, its center above 0.
// Boxes that are exact, and boxes that are 100 pixels off, but for the truth that three programs put in the first frame.
#[test]
fn truths_at_the_border_count_by_some_rules() {
    let mut truth = moving(2.0, 1.0);
    for t in truth[20..].iter_mut().flatten() {
        t.x = -1.0;
    }
    let off: Vec<Option<Rect>> = truth.iter().map(|t| t.map(|t| t.shifted(100.0, 0.0))).collect();
    let all = 20.0 / 21.0;
    for (name, exact, precision, off_auc, off_precision) in [
        ("got10k/1", all, 1.0, all / 40.0, 0.025),
        ("pysot/1", all, 1.0, 0.0, 0.0),
        ("pysot-toolkit/1", all / 2.0, 1.0, 0.0, 0.0),
        ("lasot/1", all / 2.0, 1.0, all / 40.0, 0.525),
        ("otb-matlab/1", all / 2.0, 1.0, all / 40.0, 0.525),
    ] {
        near(&rules(name).of_boxes(&truth, &truth), exact, precision, name);
        near(&rules(name).of_boxes(&off, &truth), off_auc, off_precision, name);
    }
}

// The equations as above: absent in frames 31 to 38, boxes 6 pixels off from frame 6 on, none from frame 36 on. The last box
// is still near the target when it is back in frames 39 and 40.
#[test]
fn frames_without_target_are_in_lasot_s_length_alone() {
    let (mut truth, mut boxes) = (moving(2.0, 1.0), moving(2.0, 1.0));
    boxes[5..].iter_mut().flatten().for_each(|b| b.x += 6.0);
    boxes[35..].fill(None);
    truth[30..38].fill(None);
    for (name, auc, precision) in [
        ("lasot/1", 0.501_190_476_190_476_3, 0.8),
        ("got10k/1", 0.476_190_476_190_476_17, 0.75),
        ("pysot/1", 0.476_190_476_190_476_17, 0.95),
        ("pysot-toolkit/1", 0.476_190_476_190_476_17, 0.95),
    ] {
        near(&of_track(rules(name), &boxes, &truth, Status::Absent), auc, precision, name);
    }
}

#[test]
fn a_later_start_is_scored_from_there() {
    let regions = vec![Region::Rect(square(10.0)); 4];
    let truth = [Some(200.0), Some(10.0), None, Some(10.0)].map(|x| x.map(|x| Region::Rect(square(x))));
    let status = [Status::Waiting, Status::Initialized, Status::Tracked, Status::Skipped];
    let trajectory = trajectory(&regions, &status, &truth);
    // Three frames: one hit, one without annotation, one without box, which OTB fills with the last one.
    let success = |k: usize| RULES[k].curves(&trajectory).success[0];
    assert_eq!((success(0), success(2)), (2.0 / 3.0, 1.0 / 3.0));
    assert_eq!(RULES[0].curves(&trajectory).precision_at_20(), 1.0);
}

proptest! {
    #[test]
    fn curves_are_monotone_and_means_lie_between(
        a in prop::collection::vec((0.0..200.0, 5.0..60.0, prop::bool::ANY), 1..30),
        b in prop::collection::vec((0.0..200.0, 5.0..60.0, prop::bool::ANY), 1..30),
    ) {
        let of = |v: &[(f64, f64, bool)]| -> Vec<Option<Rect>> {
            v.iter().map(|(x, w, there)| there.then(|| Rect::new(*x, 9.0, *w, 30.0))).collect()
        };
        let n = a.len().min(b.len());
        for rules in RULES {
            let one = rules.of_boxes(&of(&a)[..n], &of(&b)[..n]);
            prop_assert!(one.success.is_sorted_by(|x, y| x >= y));
            prop_assert!(one.precision.is_sorted());
            prop_assert!(one.success.iter().chain(&one.precision).all(|v| (0.0..=1.0).contains(v)));
            let other = rules.of_boxes(&of(&b)[..n], &of(&b)[..n]);
            let mean = Curves::mean([&one, &other].map(|c| (1.0, c))).unwrap().auc();
            prop_assert!((mean - (one.auc() + other.auc()) / 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn thresholds_below_a_value_are_counted(value in -0.1..1.1_f64, i in 0..OVERLAPS, e in 0..70_u32) {
        let errors = |v: f64| (0..ERRORS).filter(|e| v > *e as f64).count();
        for language in [Language::Matlab, Language::Python] {
            let overlaps = |v: f64| (0..OVERLAPS).filter(|i| v > language.overlap_threshold(*i)).count();
            let edge = language.overlap_threshold(i);
            for v in [value, edge, edge.next_up(), edge.next_down(), -1.0, 1.0] {
                prop_assert_eq!(language.overlaps_below(v), overlaps(v), "{}", v);
            }
            prop_assert_eq!(language.overlaps_below(f64::NAN), 0);
        }
        let edge = f64::from(e);
        for v in [60.0 * value, edge, edge.next_up(), edge.next_down(), f64::INFINITY] {
            prop_assert_eq!(errors_below(v), errors(v), "{}", v);
        }
        prop_assert_eq!(errors_below(f64::NAN), ERRORS);
    }
}
