use super::*;
use proptest::prelude::*;

fn square(x: f64) -> Rect {
    Rect::new(x, 100.0, 40.0, 40.0)
}

/// A thousand frames, drift after 600, of boxes 40 pixels wide that are shifted sideways by whole pixels `d`:
/// their overlap is `(40 - d) / (40 + d)`.
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
            let curves = rules.of_boxes(boxes, truth);
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
    assert!((curves.auc() - 0.555_555_555_555_555_6).abs() < 1e-12);
    assert_eq!((curves.precision_at_20(), curves.precision[4]), (2.0 / 3.0, 2.0 / 3.0));
}

// A target at the left border, x = 0 in OTB's pixels: not annotated for the OTB formula, whose rule asks for
// x > 0, and annotated for the others.
#[test]
fn a_target_that_touches_the_border() {
    let truth = [Some(square(50.0)), Some(Rect::new(-1.0, 100.0, 40.0, 40.0))];
    let boxes = [Some(square(50.0)), Some(Rect::new(-1.0, 100.0, 40.0, 40.0))];
    let of = |k: usize| RULES[k].of_boxes(&boxes, &truth);
    // In the first frame 20 of 21 thresholds are below an overlap of 1.
    assert_eq!((of(0).success[0], of(0).precision[0]), (0.5, 1.0));
    assert_eq!((of(1).success[0], of(2).success[0]), (1.0, 1.0));
    assert!((of(1).auc() - 20.0 / 21.0).abs() < 1e-12);
}

#[test]
fn a_later_start_is_scored_from_there() {
    let regions = vec![Region::Rect(square(10.0)); 4];
    let truth =
        vec![Some(Region::Rect(square(200.0))), Some(regions[0].clone()), None, Some(regions[0].clone())];
    let status = [Status::Waiting, Status::Initialized, Status::Tracked, Status::Skipped];
    let trajectory = Trajectory {
        sequence: "a",
        run: 0,
        regions: &regions,
        status: &status,
        truth: &truth,
        frame: Some((640, 480)),
        attributes: &[],
        frame_attributes: &[],
    };
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
            let mean = Curves::mean([&one, &other]).unwrap().auc();
            prop_assert!((mean - (one.auc() + other.auc()) / 2.0).abs() < 1e-12);
        }
    }
}

proptest! {
    #[test]
    fn thresholds_below_a_value_are_counted(value in -0.1..1.1_f64, i in 0..OVERLAPS, e in 0..70_u32) {
        let overlaps = |v: f64| (0..OVERLAPS).filter(|i| v > overlap_threshold(*i)).count();
        let errors = |v: f64| (0..ERRORS).filter(|e| v > *e as f64).count();
        let edge = overlap_threshold(i);
        for v in [value, edge, edge.next_up(), edge.next_down(), -1.0, 1.0] {
            prop_assert_eq!(overlaps_below(v), overlaps(v), "{}", v);
        }
        let edge = f64::from(e);
        for v in [60.0 * value, edge, edge.next_up(), edge.next_down(), f64::INFINITY] {
            prop_assert_eq!(errors_below(v), errors(v), "{}", v);
        }
        prop_assert_eq!((overlaps_below(f64::NAN), errors_below(f64::NAN)), (0, ERRORS));
    }
}
