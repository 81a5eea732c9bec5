//! Properties that all signals of the list must have.

mod facts_tests;

use super::testing::build;
use super::{Observation, SIGNALS, Session, Signal, testing};
use crate::image::Frame;
use crate::plugin::{Entry, find};
use crate::region::{Rect, Region};
use crate::tracker::{Moments, Response, TrackerState};
use proptest::prelude::*;
use sha2::{Digest, Sha256};

fn frame(width: usize, height: usize, seed: u64, t: usize) -> Frame {
    Frame::from_fn(width, height, |x, y| pixel(x as i64, y as i64, seed, t))
}

fn pixel(x: i64, y: i64, seed: u64, t: usize) -> [u8; 3] {
    std::array::from_fn(|c| {
        let key = (x + 1000) as u64 * 7919 + (y + 1000) as u64 * 104_729 + c as u64 * 1_299_709 + seed * 31;
        let noise = (key.wrapping_mul(6_364_136_223_846_793_005) >> 58) as i64;
        ((3 * x + 2 * y + 60 * c as i64 + 5 * t as i64 + seed as i64).rem_euclid(180) + noise) as u8
    })
}

/// Moments in frame `t` of a posterior with five components: no spread in the first frame, then varying
/// spread with correlations.
fn moments(t: usize) -> Moments {
    let s = t as f64;
    let deviations =
        [3.0 + s, 2.0 + 0.5 * s, 0.5, 0.4 + 0.1 * (s % 3.0), 0.05].map(|d| if t == 0 { 0.0 } else { d });
    let correlation = |i: usize, j: usize| if i == j { 1.0 } else { 0.3 / (1.0 + i.abs_diff(j) as f64) };
    let covariance =
        (0..25).map(|n| deviations[n / 5] * deviations[n % 5] * correlation(n / 5, n % 5)).collect();
    let mean = vec![20.0 + s, 15.0 - s, 7.0, 5.5, 0.1];
    let (effective_samples, samples, entropy) = (200.0 - 9.0 * s, 400.0, 0.9 - 0.04 * s);
    let weights = Moments { effective_samples, samples, entropy, likelihood: 0.5, ..Moments::default() };
    Moments { mean, covariance, ..weights }
}

/// Numbers of a response map whose peak sinks and rises while the rest gets noisier.
fn response(t: usize) -> Response {
    let s = t as f64;
    Response {
        peak: 0.9 - 0.1 * (s % 4.0),
        second_peak: 0.2 + 0.03 * s,
        lowest: -0.1,
        mean: 0.08,
        deviation: 0.11 + 0.01 * s,
        sidelobe_mean: 0.05,
        sidelobe_deviation: 0.04 + 0.005 * s,
        narrow_sidelobe_mean: 0.06,
        narrow_sidelobe_deviation: 0.07 + 0.005 * s,
    }
}

fn state(region: Region, t: usize) -> TrackerState {
    let (posterior, response) = (Some(moments(t)), Some(response(t)));
    let confidence = Some(9.0 - 0.5 * t as f64);
    TrackerState { posterior, response, confidence, ..TrackerState::tracked(region) }
}

fn run(signal: &dyn Signal, frames: &[Frame], boxes: &[Rect]) -> Vec<f64> {
    let states: Vec<_> = boxes.iter().enumerate().map(|(t, r)| state(Region::Rect(*r), t)).collect();
    testing::values(signal, frames, &states)
}

/// Eight frames and a box that moves, grows and leaves.
fn track() -> (Vec<Frame>, Vec<Rect>) {
    let boxes = (0..8).map(f64::from).map(|t| Rect::new(5.2 + 7.3 * t, 9.0 - t, 14.0 + t, 11.0));
    ((0..8).map(|t| frame(56, 40, 1, t)).collect(), boxes.collect())
}

fn within(entry: &Entry<dyn Signal>, signal: &dyn Signal, values: &[f64]) {
    let (low, high) = signal.facts().bounds;
    assert!(values.iter().all(|v| v.is_finite() && (low..=high).contains(v)), "{}: {values:?}", entry.kind);
}

#[test]
fn the_list_and_its_ranges_are_lawful() {
    crate::range_tests::check(SIGNALS);
    trackfail_testing::check_pins("range signal", crate::range_tests::pins(SIGNALS));
}

/// The example of a signal has its defaults; every parameter is documented and has a type that is checked.
#[test]
fn parameters_have_defaults_types_and_words() {
    for entry in SIGNALS {
        let params = entry.build_from_text("{}").unwrap().params();
        assert_eq!(entry.build_from_text(entry.example).unwrap().params(), params, "{}", entry.kind);
        let documented = (entry.schema)().get("properties").map_or(0, |p| p.as_object().unwrap().len());
        assert!(documented >= params.as_object().unwrap().len(), "{}", entry.kind);
        for key in params.as_object().unwrap().keys() {
            assert!(entry.build_from_text(&format!("{{ {key} = [] }}")).is_err(), "{} {key}", entry.kind);
        }
    }
}

/// Parameters that are shown only where they differ from their defaults are part of what is shown then.
#[test]
fn readings_are_shown_and_read_back() {
    for (kind, text) in [
        ("region-covariance", "{ colors = \"hsv\" }"),
        ("region-covariance", "{ parts = \"halves\" }"),
        ("region-covariance", "{ size_history = 2 }"),
        ("rgb-histogram", "{ channels = \"separate\" }"),
        ("rgb-histogram", "{ size_history = 2 }"),
        ("rgb-lbp-histogram", "{ size_history = 2 }"),
    ] {
        let shown = build(kind, text).params();
        assert_ne!(shown, build(kind, "{}").params(), "{kind} {text}");
        let entry = crate::plugin::find(SIGNALS, kind).unwrap();
        let again = (entry.build)(crate::plugin::RawParams::Json(&shown)).unwrap();
        assert_eq!(again.params(), shown, "{kind} {text}");
    }
}

#[test]
fn values_are_deterministic_finite_and_bounded() {
    let (frames, boxes) = track();
    for entry in SIGNALS {
        let signal = entry.build_from_text("{}").unwrap();
        let values = run(signal.as_ref(), &frames, &boxes);
        assert_eq!(values, run(signal.as_ref(), &frames, &boxes), "{}", entry.kind);
        within(entry, signal.as_ref(), &values);
        // Online: what comes later changes nothing.
        assert_eq!(run(signal.as_ref(), &frames[..3], &boxes[..3]), values[..3], "{}", entry.kind);
        assert!(values.iter().any(|v| *v != values[0]), "{} is constant", entry.kind);
    }
}

#[test]
fn odd_boxes_and_frames_are_survived() {
    let boxes = [
        Rect::new(20.0, 20.0, 1.0, 1.0),
        Rect::new(3.0, 3.0, 0.0, 0.2),
        Rect::new(-500.0, -500.0, 20.0, 20.0),
        Rect::new(500.0, 10.0, 7.0, 300.0),
        Rect::new(-100.0, -100.0, 900.0, 900.0),
        Rect::new(1e300, -1e300, 1e300, 2.0),
        Rect::new(f64::NAN, f64::INFINITY, f64::NAN, 3.0),
        Rect::new(20.0, 20.0, 9.0, 9.0),
    ];
    for entry in SIGNALS {
        let signal = entry.build_from_text("{}").unwrap();
        let frames: Vec<Frame> = (0..boxes.len()).map(|t| frame(56, 40, 2, t)).collect();
        within(entry, signal.as_ref(), &run(signal.as_ref(), &frames, &boxes));
        // One frame, of one pixel, and frames whose size changes.
        let tiny = [frame(1, 1, 3, 0), frame(5, 3, 3, 1), frame(1, 40, 3, 2)];
        within(entry, signal.as_ref(), &run(signal.as_ref(), &tiny[..1], &boxes));
        within(entry, signal.as_ref(), &run(signal.as_ref(), &tiny, &boxes));
        let turned = Region::Polygon(vec![(20.0, 10.0), (30.0, 20.0), (20.0, 30.0), (10.0, 20.0)]);
        let value = testing::values(signal.as_ref(), &frames[..1], &[state(turned, 0)]);
        within(entry, signal.as_ref(), &value);
    }
}

#[test]
fn outputs_are_those_of_the_version() {
    let (frames, boxes) = track();
    let pin = |entry: &Entry<dyn Signal>| {
        let values = run(entry.build_from_text("{}").unwrap().as_ref(), &frames, &boxes);
        // At nine digits.
        let text: String = values.iter().map(|v| format!("{v:.8e}\n")).collect();
        let digest: String = Sha256::digest(&text).iter().take(8).map(|b| format!("{b:02x}")).collect();
        format!("{} {} {digest}", entry.kind, entry.version)
    };
    trackfail_testing::check_pins("output signal", SIGNALS.iter().map(pin));
    let traits = |(kind, text): (&str, &str)| {
        let signal = build(kind, text);
        let (facts, params) = (signal.facts(), signal.params());
        format!("{kind} {text} {} values of {:?}, {:?}: {params}", facts.width, facts.reads, facts.direction)
    };
    let all = SIGNALS.iter().map(|entry| (entry.kind, "{}")).chain(SAVED);
    trackfail_testing::check_pins("traits signal", all.map(traits));
}

/// Signals that can be interrupted, in all their forms of memory.
const SAVED: [(&str, &str); 29] = [
    ("deep-verification", "{}"),
    ("deep-verification", "{ v2 = [\"overlap\"], both = [\"against\"], here = [\"inside\"] }"),
    ("watchdog-agreement", "{}"),
    ("watchdog-agreement", "{ version = \"v3\", values = [\"overlap\", \"score\", \"distance\"] }"),
    ("box-motion", "{ measure = \"displacement\" }"),
    ("box-motion", "{ measure = \"acceleration\" }"),
    ("box-motion", "{ measure = \"border\" }"),
    ("companion-overlap", "{}"),
    ("companion-overlap", "{ companions = [{ tracker = \"kcf\" }] }"),
    (
        "companion-overlap",
        "{ companions = [{ tracker = \"kcf\", restart_after = 1, restart_margin = 0.0 }] }",
    ),
    (
        "companion-overlap",
        "{ companions = [{ tracker = \"kcf\", params = { preset = \"vot\" }, restart_after = 0 }] }",
    ),
    ("confidence", "{ scale = \"ratio\", early = 4 }"),
    ("distribution-field", "{ history = 3 }"),
    ("forward-backward", "{ measure = \"residual\" }"),
    ("object-color", "{ object = \"first\", bins = 4 }"),
    ("object-color", "{ object = \"slow\", bins = 4 }"),
    ("region-covariance", "{}"),
    ("region-covariance", "{ size_history = 2, parts = \"halves\" }"),
    ("response-peak", "{ measure = \"quality\" }"),
    ("rgb-histogram", "{ reference = \"first\" }"),
    ("rgb-lbp-histogram", "{ reference = \"previous\" }"),
    ("rgb-histogram", "{ channels = \"separate\", size_history = 2 }"),
    ("rgb-lbp-histogram", "{ size_history = 2 }"),
    ("template-correlation", "{ reference = \"first\" }"),
    ("template-correlation", "{ reference = \"previous\" }"),
    ("template-correlation", "{ reference = \"slow\" }"),
    ("uncertainty", "{}"),
    ("uncertainty-change", "{ window = 3, settling = 2 }"),
    ("uncertainty-change", "{ window = 2 }"),
];

/// Values in the frames from `from` on, of a session that has seen the frames before.
fn go_on(session: &mut dyn Session, frames: &[Frame], boxes: &[Rect], from: usize) -> Vec<u64> {
    let other = Region::Rect(Rect::new(9.0, 7.0, 15.0, 12.0));
    let push = |(t, (frame, r)): (usize, (&Frame, &Rect))| {
        let state = state(Region::Rect(*r), t);
        let values = session.push(&Observation { frame, state: &state, companions: &[&other] });
        values.unwrap_or_default().into_iter().map(f64::to_bits)
    };
    frames.iter().zip(boxes).enumerate().skip(from).flat_map(push).collect()
}

#[test]
fn interrupted_sessions_go_on_as_if_nothing_had_happened() {
    let (frames, boxes) = track();
    for (kind, params) in SAVED {
        let signal = build(kind, params);
        let whole = go_on(&mut *testing::start(&*signal), &frames, &boxes, 0);
        for cut in 0..frames.len() {
            let mut first = testing::start(&*signal);
            let before = go_on(&mut *first, &frames[..cut], &boxes, 0);
            let saved = first.save().unwrap_or_else(|| panic!("{kind} {params} cannot be saved"));
            let mut second = testing::start(&*signal);
            assert!(second.restore(&saved), "{kind} {params}, after {cut} frames");
            assert_eq!(second.save(), Some(saved), "{kind} {params}");
            let after = go_on(&mut *second, &frames, &boxes, cut);
            assert_eq!([before, after].concat(), whole, "{kind} {params}, cut after {cut} frames");
        }
    }
}

#[test]
fn memory_that_is_cut_short_or_of_another_signal_is_refused() {
    let (frames, boxes) = track();
    for (kind, params) in SAVED {
        let signal = build(kind, params);
        let mut session = testing::start(&*signal);
        go_on(&mut *session, &frames, &boxes, 0);
        let saved = session.save().unwrap();
        // Sixty places in a long one are enough.
        for length in (0..saved.len()).step_by(saved.len().div_ceil(60)) {
            assert!(!testing::start(&*signal).restore(&saved[..length]), "{kind} {params}: {length} bytes");
        }
        assert!(!testing::start(&*signal).restore(&[&saved[..], &[0]].concat()), "{kind} {params}");
    }
    let mut session = testing::start(&*build("rgb-histogram", "{ reference = \"first\" }"));
    go_on(&mut *session, &frames, &boxes, 0);
    let saved = session.save().unwrap();
    for (kind, params) in [
        ("rgb-histogram", "{ bins = 4 }"),
        ("rgb-lbp-histogram", "{}"),
        ("template-correlation", "{}"),
        ("region-covariance", "{}"),
    ] {
        assert!(!testing::start(&*build(kind, params)).restore(&saved), "{kind} {params}");
    }
}

/// Compares the values on two scenes, one of which is a transformation of the other.
fn same(kind: &str, params: &str, a: (&[Frame], &[Rect]), b: (&[Frame], &[Rect]), tolerance: f64) {
    let signal = build(kind, params);
    let (a, b) = (run(signal.as_ref(), a.0, a.1), run(signal.as_ref(), b.0, b.1));
    for (x, y) in a.iter().zip(&b) {
        assert!((x - y).abs() <= tolerance, "{kind} {params}: {a:?} {b:?}");
    }
}

fn map(frame: &Frame, f: impl Fn(usize, usize) -> [u8; 3]) -> Frame {
    Frame::from_fn(frame.width(), frame.height(), f)
}

/// Tracks of even integer boxes with a constant integer displacement, inside a 64 x 48 frame. All windows lie
/// on whole pixels, and `(w + h) / 4` is even, too.
fn whole_boxes() -> impl Strategy<Value = Vec<Rect>> {
    (1..8_u8, 1..3_u8, -2..3_i8, -2..3_i8, 16..22_u8, 12..18_u8).prop_map(|(a, b, dx, dy, x, y)| {
        let w = 2 * a;
        let h = 8 * (b + a / 4) - w;
        let [w, h, x, y, dx, dy] = [w.into(), h.into(), x.into(), y.into(), f64::from(dx), dy.into()];
        (0..4).map(|t| Rect::new(x + dx * f64::from(t), y + dy * f64::from(t), w, h)).collect()
    })
}

/// Signals whose value may change in a mirror image: pyramids keep every second pixel from the left top, and
/// a network was trained on unmirrored images.
const BY_SIDE: [&str; 3] = ["deep-verification", "forward-backward", "watchdog-agreement"];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn values_stay_in_bounds(
        seed in 0..1000_u64,
        boxes in proptest::collection::vec((-30.0..60.0, -30.0..50.0, 0.5..40.0, 0.5..40.0), 1..5),
    ) {
        let boxes: Vec<Rect> = boxes.iter().map(|&(x, y, w, h)| Rect::new(x, y, w, h)).collect();
        let mut frames: Vec<Frame> = (0..boxes.len()).map(|t| frame(41, 33, seed, t)).collect();
        if seed % 2 == 0 {
            frames[0] = map(&frames[0], |_, _| [seed as u8; 3]);
        }
        for entry in SIGNALS {
            let signal = entry.build_from_text("{}").unwrap();
            within(entry, signal.as_ref(), &run(signal.as_ref(), &frames, &boxes));
        }
    }

    #[test]
    fn nothing_moves_nothing_changes(seed in 0..1000_u64, x in 0.0..30.0, y in 0.0..20.0, w in 1.0..25.0) {
        let frames = [frame(64, 48, seed, 0), frame(64, 48, seed, 0)];
        let boxes = [Rect::new(x, y, w, 14.0); 2];
        for (kind, same) in [("region-covariance", 0.0), ("rgb-histogram", 1.0), ("rgb-lbp-histogram", 1.0)] {
            for reference in ["{}", "{ reference = \"first\" }"] {
                let Ok(signal) = find(SIGNALS, kind).unwrap().build_from_text(reference) else { continue };
                prop_assert_eq!(run(signal.as_ref(), &frames, &boxes), vec![same; 2], "{}", kind);
            }
        }
        let values = run(build("box-motion", "{}").as_ref(), &frames, &boxes);
        prop_assert_eq!(values, vec![0.0; 2]);
        let values = run(build("template-correlation", "{}").as_ref(), &frames, &boxes);
        prop_assert!(values.iter().all(|v| (v - 1.0).abs() < 1e-12), "{:?}", values);
        // Where every window shows the same, the target looks exactly like what surrounds it.
        let flat = map(&frames[0], |_, _| [seed as u8, 7, 255]);
        for border in ["uniform", "zero", "replicate"] {
            let signal = build("distribution-field", &format!("{{ border = \"{border}\" }}"));
            prop_assert_eq!(run(signal.as_ref(), std::slice::from_ref(&flat), &boxes), vec![0.0]);
        }
        // Columns that repeat with the shift of the windows (4 for 16 x 16 pixels) are the same, too.
        let tiles = map(&frames[0], |x, y| pixel((x % 4) as i64, (y % 4) as i64, seed, 0));
        let signal = build("distribution-field", "{}");
        let square = [Rect::new(x.round() + 4.0, y.round() + 4.0, 16.0, 16.0)];
        prop_assert_eq!(run(signal.as_ref(), &[tiles], &square), vec![0.0]);
    }

    #[test]
    fn no_damage_makes_a_session_panic(
        which in 0..SAVED.len(), at in any::<prop::sample::Index>(), bytes in prop::collection::vec(any::<u8>(), 1..9),
    ) {
        let (frames, boxes) = track();
        let (kind, params) = SAVED[which];
        let signal = build(kind, params);
        let mut session = testing::start(&*signal);
        go_on(&mut *session, &frames[..4], &boxes, 0);
        let mut saved = session.save().unwrap();
        let at = at.index(saved.len());
        saved.splice(at..saved.len().min(at + bytes.len()), bytes);
        let mut damaged = testing::start(&*signal);
        if damaged.restore(&saved) {
            go_on(&mut *damaged, &frames, &boxes, 4);
        }
    }

    #[test]
    fn swapping_red_and_blue_changes_nothing(seed in 0..1000_u64, boxes in whole_boxes()) {
        let frames: Vec<Frame> = (0..4).map(|t| frame(64, 48, seed, t)).collect();
        let swap = |f: &Frame| map(f, |x, y| { let [r, g, b] = f.pixel(x, y); [b, g, r] });
        let swapped: Vec<Frame> = frames.iter().map(swap).collect();
        for kind in ["distribution-field", "region-covariance", "rgb-histogram"] {
            same(kind, "{}", (&frames, &boxes), (&swapped, &boxes), 1e-10);
        }
    }

    #[test]
    fn moving_scene_and_boxes_changes_nothing(
        seed in 0..1000_u64, boxes in whole_boxes(), dx in 0..20_i64, dy in 0..20_i64,
    ) {
        let frames: Vec<Frame> = (0..4).map(|t| frame(90, 80, seed, t)).collect();
        let moved: Vec<Frame> = (0..4)
            .map(|t| Frame::from_fn(90, 80, |x, y| pixel(x as i64 - dx, y as i64 - dy, seed, t)))
            .collect();
        let boxes: Vec<Rect> = boxes.iter().map(|r| r.shifted(5.0, 4.0)).collect();
        let shifted: Vec<Rect> = boxes.iter().map(|r| r.shifted(dx as f64, dy as f64)).collect();
        // What a watchdog looks at reaches beyond the frame.
        let reaches = ["deep-verification", "watchdog-agreement"];
        for entry in SIGNALS.iter().filter(|entry| !reaches.contains(&entry.kind)) {
            // So that no window reaches the border of the frame.
            let params = if entry.kind == "forward-backward" { "{ reach = 0.25 }" } else { "{}" };
            same(entry.kind, params, (&frames, &boxes), (&moved, &shifted), 1e-10);
        }
    }

    #[test]
    fn mirroring_scene_and_boxes_changes_nothing(seed in 0..1000_u64, boxes in whole_boxes()) {
        let frames: Vec<Frame> = (0..4).map(|t| frame(64, 48, seed, t)).collect();
        let across: Vec<Frame> = frames.iter().map(|f| map(f, |x, y| f.pixel(63 - x, y))).collect();
        let down: Vec<Frame> = frames.iter().map(|f| map(f, |x, y| f.pixel(x, 47 - y))).collect();
        let left: Vec<Rect> = boxes.iter().map(|r| Rect::new(64.0 - r.x - r.w, r.y, r.w, r.h)).collect();
        let up: Vec<Rect> = boxes.iter().map(|r| Rect::new(r.x, 48.0 - r.y - r.h, r.w, r.h)).collect();
        for entry in SIGNALS.iter().filter(|entry| !BY_SIDE.contains(&entry.kind)) {
            // y_t is computed in single precision, and sums rows from the top.
            let tolerance = if entry.kind == "distribution-field" { 1e-8 } else { 1e-10 };
            same(entry.kind, "{}", (&frames, &boxes), (&across, &left), tolerance);
            same(entry.kind, "{}", (&frames, &boxes), (&down, &up), tolerance);
        }
        for params in ["{ border = \"replicate\" }", "{ regions = \"sides\" }", "{ support_u = 21, history = 1 }"] {
            same("distribution-field", params, (&frames, &boxes), (&across, &left), 1e-8);
        }
        same("object-color", "{ object = \"slow\", bins = 4 }", (&frames, &boxes), (&down, &up), 1e-10);
    }

    #[test]
    fn transposing_swaps_the_two_sigmas(seed in 0..1000_u64, boxes in whole_boxes()) {
        let frames: Vec<Frame> = (0..4).map(|t| frame(50, 50, seed, t)).collect();
        let turned: Vec<Frame> = frames.iter().map(|f| map(f, |x, y| f.pixel(y, x))).collect();
        let flipped: Vec<Rect> = boxes.iter().map(|r| Rect::new(r.y, r.x, r.h, r.w)).collect();
        let one = build("distribution-field", "{ sigma_u = 0.8, sigma_v = 3.0, support_u = 5, support_v = 17 }");
        let two = build("distribution-field", "{ sigma_u = 3.0, sigma_v = 0.8, support_u = 17, support_v = 5 }");
        let (a, b) = (run(one.as_ref(), &frames, &boxes), run(two.as_ref(), &turned, &flipped));
        for (x, y) in a.iter().zip(&b) {
            prop_assert!((x - y).abs() < 1e-6 * x.abs(), "{:?} {:?}", a, b);
        }
    }
}
