use super::*;
use crate::judge::{FrameOf, Track, judge};
use crate::method::{self, Method};
use crate::region::Rect;
use proptest::prelude::*;
use std::ops::Range;
use trackfail_testing::assert_says;

/// Frame `t`: a patterned square on a pattern, and the region of the square, which jumps in frame 12.
fn scene(t: usize) -> (Frame, Region) {
    let x = if t < 12 { 10 + t } else { 40 };
    let frame = Frame::from_fn(80, 60, |u, v| {
        let inside = (x..x + 16).contains(&u) && (20..34).contains(&v);
        let (u, v) = if inside { (9 * (u - x), 17 * v) } else { (3 * u, 2 * v + u) };
        [u as u8, v as u8, (u * v % 251) as u8]
    });
    (frame, Region::Rect(Rect::new(x as f64, 20.0, 16.0, 14.0)))
}

fn method(name: &str) -> Options {
    Options { method: Some(name.into()), ..Options::default() }
}

fn monitor(name: &str) -> Monitor {
    Monitor::new(&method(name)).unwrap()
}

/// Data of a frame with a box alone.
fn boxes(region: &Region) -> Update<'_> {
    Update { region: Some(region), ..Update::default() }
}

fn refusal(refused: Result<Monitor, MonitorError>) -> String {
    refused.err().unwrap().to_string()
}

/// Answers to a stream whose boxes stay at the first place from frame 12 on; one box is missing.
fn answers(monitor: &mut Monitor, frames: Range<usize>) -> Vec<Answer> {
    stream(monitor, frames, &[5], None)
}

/// Answers to the same stream with `absent` frames without a box, whose tracker starts again in frame `restart`.
fn stream(
    monitor: &mut Monitor,
    frames: Range<usize>,
    absent: &[usize],
    restart: Option<usize>,
) -> Vec<Answer> {
    let answer = |t: usize| {
        let (frame, companion) = scene(t);
        let region = (!absent.contains(&t)).then(|| scene(t.min(11)).1);
        let update = Update {
            frame: Some(&frame),
            region: region.as_ref(),
            confidence: (!t.is_multiple_of(4)).then_some(1.0 / (1.0 + t as f64)),
            companions: &[companion],
            restart: restart == Some(t),
        };
        monitor.update(&update).unwrap()
    };
    frames.map(answer).collect()
}

/// These answers, so many frames later.
fn later(answers: &[Answer], by: u64) -> Vec<Answer> {
    answers.iter().map(|answer| Answer { index: answer.index + by, ..answer.clone() }).collect()
}

fn states(answers: &[Answer]) -> String {
    answers.iter().map(|a| format!("{:?}", a.state).chars().next().unwrap()).collect()
}

#[test]
fn a_companion_that_leaves_raises_the_alarm() {
    let all = answers(&mut monitor("Companions"), 0..16);
    assert_eq!(states(&all), "TTTTTATTTTTTLLLL");
    let text = r#"{"index":12,"probability":null,"state":"lost","reasons":["value 0.000 is below 0.01"]}"#;
    assert_eq!(serde_json::to_string(&all[12]).unwrap(), text);
}

/// Answers of `Companions` to boxes that are present or not, each with a companion on the last box or far
/// from it. The signal is 1 or 0; 0 is an alarm.
fn agreements(frames: &[(bool, bool)]) -> Vec<Answer> {
    let mut monitor = monitor("Companions");
    let (here, far) = (Rect::new(10.0, 20.0, 16.0, 14.0), Rect::new(60.0, 20.0, 16.0, 14.0));
    let answer = |(has_box, agrees): &(bool, bool)| {
        let region = has_box.then_some(Region::Rect(here));
        let companions = [Region::Rect(if *agrees { here } else { far })];
        let update = Update { region: region.as_ref(), companions: &companions, ..Update::default() };
        monitor.update(&update).unwrap()
    };
    frames.iter().map(answer).collect()
}

#[test]
fn an_alarm_raised_while_the_target_is_absent_ends_with_the_absence() {
    // `+` is a box with its companion, `!` one without, `a` no box and a companion, `x` neither.
    for (text, want) in [
        ("+++xxx+++", "TTTAAATTT"),
        ("+++xxx!++", "TTTAAALLL"),
        ("++!xxx+++", "TTLAAALLL"),
        ("+x+x+ax+!", "TATATAATL"),
        // Ten frames in a row without an alarm confirm a recovery, those of an absence among them.
        ("!aaaaaaaaaax++", "LAAAAAAAAAAATT"),
        ("!aaaaaaaa++", "LAAAAAAAALT"),
    ] {
        let frame = |c: char| ("+!".contains(c), "+a".contains(c));
        assert_eq!(states(&agreements(&text.chars().map(frame).collect::<Vec<_>>())), want, "{text}");
    }
}

#[test]
fn the_first_frame_with_a_region_chooses_the_method_and_a_budget_one_that_takes_it() {
    let (frame, region) = scene(0);
    let others = [region.clone()];
    for bits in 0..8 {
        let [frames, companions, confidence] = [1, 2, 4].map(|bit| bits & bit > 0);
        let inputs = Inputs { frames, companions, confidence };
        let update = Update {
            frame: frames.then_some(&frame),
            confidence: confidence.then_some(0.5),
            companions: if companions { &others } else { &[] },
            ..boxes(&region)
        };
        let with = |budget, inputs| Monitor::new(&Options { budget, inputs, ..Options::default() });
        for budget in [None, Some(2.0)] {
            let want = method::recommended(inputs, budget);
            let mut monitor = with(budget, None).unwrap();
            let first = monitor.update(&Update { region: None, ..update }).unwrap();
            assert_eq!((first.state, first.probability, monitor.method()), (TargetState::Absent, None, None));
            let state = monitor.update(&update).unwrap().state;
            assert!(budget.is_none() || state == TargetState::Tracking, "{inputs:?}");
            assert_eq!(monitor.method(), Some(want), "{inputs:?} {budget:?}");
            assert_eq!(with(budget, Some(inputs)).unwrap().method(), Some(want), "{inputs:?} {budget:?}");
        }
        // What one of the methods refuses, the start refuses without knowing which it will be.
        for refused in [0.0, -1.0, f64::NAN, 1e9].map(Some) {
            assert!(with(refused, Some(inputs)).is_err() && with(refused, None).is_err(), "{refused:?}");
        }
    }
}

#[test]
fn inputs_that_go_missing_are_no_error_and_no_alarm() {
    let needs = [
        ("Companions", Some("other trackers' boxes")),
        ("Watchdog", Some("frames")),
        ("Confidence", Some("the tracker's confidence")),
        ("First colors", Some("frames")),
        ("Displacement", None),
    ];
    for (name, need) in needs {
        let mut monitor = monitor(name);
        assert_eq!(states(&answers(&mut monitor, 0..4)), "TTTT", "{name}");
        for _ in 0..3 {
            let answer = monitor.update(&boxes(&scene(4).1)).unwrap();
            assert_eq!((answer.state, answer.reasons.len()), (TargetState::Tracking, 0), "{name}");
            let note = need.map(|need| format!("nothing to judge by: the method needs {need}"));
            assert_eq!(answer.note, note, "{name}");
        }
    }
}

// A tracker that its user starts again is judged as by a new monitor.
#[test]
fn after_a_restart_nothing_from_before_counts() {
    for name in super::chosen::able() {
        let mut whole = monitor(name);
        answers(&mut whole, 0..16);
        let want = later(&answers(&mut monitor(name), 3..16), 16);
        assert_eq!(stream(&mut whole, 3..16, &[5], Some(3)), want, "{name}");
    }
    // Before there is a box again, there is nothing to judge.
    let mut monitor = monitor("Displacement");
    answers(&mut monitor, 0..4);
    let answer = monitor.update(&Update { restart: true, ..Update::default() }).unwrap();
    assert_eq!((answer.state, answer.index), (TargetState::Absent, 4));
}

#[test]
fn frames_that_come_later_change_the_method_unless_it_is_named() {
    let (frame, region) = scene(0);
    let blind = boxes(&region);
    let seen = Update { frame: Some(&frame), ..blind };
    let best = method::recommended(Inputs { frames: true, ..Inputs::default() }, None);
    let told = format!("frames have come: {best} from here on");
    for is_saved in [false, true] {
        let mut monitor = Monitor::new(&Options::default()).unwrap();
        let note = monitor.update(&blind).unwrap().note;
        let name = monitor.method().unwrap().to_string();
        assert_eq!(note, Some(format!("without frames: {name}, until frames come")));
        assert_eq!(monitor.update(&blind).unwrap().note, None);
        if is_saved {
            monitor = Monitor::resume(&Options::default(), &monitor.save().unwrap()).unwrap();
        }
        assert!(monitor.reads_frames());
        assert_eq!(monitor.update(&seen).unwrap().note.as_deref(), Some(told.as_str()));
        assert_eq!(monitor.method(), Some(best));
        assert_eq!(monitor.update(&seen).unwrap().note, None);
    }
    for options in [method("Fused boxes"), Options { inputs: Some(Inputs::default()), ..Options::default() }]
    {
        let mut monitor = Monitor::new(&options).unwrap();
        assert_eq!(monitor.update(&blind).unwrap().note, None);
        let mut monitor = Monitor::resume(&Options::default(), &monitor.save().unwrap()).unwrap();
        assert_eq!(monitor.update(&seen).unwrap().note, None);
        assert_eq!(monitor.method(), Some("Fused boxes"));
    }
}

#[test]
fn what_is_hardly_lost_has_no_reasons() {
    let mut monitor = monitor("Fused boxes");
    let answer = |t: i32| {
        let x = 10.0 + 3.0 * f64::from(t).sin() + 60.0 * f64::from(t / 30);
        monitor.update(&boxes(&Region::Rect(Rect::new(x, 20.0, 16.0, 14.0)))).unwrap()
    };
    let all: Vec<Answer> = (0..40).map(answer).collect();
    let is_told = |answer: &Answer| !answer.reasons.is_empty();
    assert!(all.iter().filter(|answer| is_told(answer)).all(|answer| answer.probability >= Some(0.1)));
    assert!(all.iter().any(is_told) && all.iter().any(|answer| !is_told(answer)), "{all:?}");
}

#[test]
fn broken_frames_count_and_change_nothing_else() {
    let want = answers(&mut monitor("Watchdog"), 0..16);
    let mut broken = monitor("Watchdog");
    assert_eq!(answers(&mut broken, 0..8), want[..8]);
    let (frame, region) = scene(8);
    let small = Frame::new(8, 8, vec![0; 192]);
    let flat = Region::Rect(Rect::new(1.0, 1.0, 0.0, 4.0));
    let line = Region::Polygon(vec![(0.0, 0.0), (1.0, 1.0)]);
    for (frame, region, words) in [
        (&small, &region, "the frame has 8x8 pixels, those before had 80x60"),
        (&frame, &flat, "box: "),
        (&frame, &line, "box: "),
    ] {
        let error = broken.update(&Update { frame: Some(frame), ..boxes(region) }).unwrap_err();
        assert!(error.to_string().starts_with(words), "{error}");
    }
    broken.skip();
    assert_eq!(answers(&mut broken, 8..16), later(&want[8..], 4));
    // A box without numbers is none.
    assert_eq!(broken.update(&boxes(&Region::nowhere())).unwrap().state, TargetState::Absent);
}

#[test]
fn a_fault_of_a_signal_is_told_beside_the_answer() {
    let mut monitor = monitor("Confidence");
    let (_, region) = scene(0);
    let mut update =
        |confidence: f64| monitor.update(&Update { confidence: Some(confidence), ..boxes(&region) }).unwrap();
    assert_eq!(update(1.0).note, None);
    let answer = update(-1.0);
    assert_says(answer.note.unwrap(), "the mean of the early confidence is -1");
    assert_eq!(answer.state, TargetState::Tracking);
}

#[test]
fn methods_that_cannot_monitor_are_refused() {
    let budget = Options { budget: Some(2.0), ..method("Displacement") };
    for (options, words) in [
        (method("Watchdgo"), "unknown method `Watchdgo`; did you mean `Watchdog`?"),
        (method("AVU"), "method `AVU` is trained for each experiment; methods that can monitor: DTEF, NAIVE"),
        (method("PSR"), "needs more of a tracker"),
        (budget, "method `Displacement` takes no budget of false alarms"),
    ] {
        assert_says(refusal(Monitor::new(&options)), words);
    }
}

#[test]
fn a_state_says_what_is_wrong_with_it() {
    let mut monitor = monitor("Watchdog");
    answers(&mut monitor, 0..3);
    let saved = monitor.save().unwrap();
    let refused = |bytes: &[u8]| refusal(Monitor::resume(&Options::default(), bytes));
    assert_eq!(refused(b""), "not a state of `trackfail monitor`");
    assert_eq!(refused(b"{\"index\": 4}"), "not a state of `trackfail monitor`");
    assert_says(refused(b"trackfail-monitor 1\nx"), "format 1");
    let other_method = refusal(Monitor::resume(&method("Companions"), &saved));
    assert_eq!(other_method, "the state is one of method `Watchdog`, not of `Companions`");
    for at in [19, 25, 60, saved.len() / 2, saved.len() - 1] {
        let mut other = saved.clone();
        other[at.max(20)] ^= 4;
        assert_eq!([refused(&saved[..at]), refused(&other)], ["the state is damaged"; 2], "{at}");
    }
}

#[test]
fn a_state_goes_on_under_its_own_options_alone() {
    let frames = Inputs { frames: true, ..Inputs::default() };
    let begun = Options { budget: Some(2.0), inputs: Some(frames), base: Some(1), ..Options::default() };
    let mut monitor = Monitor::new(&begun).unwrap();
    let empty = monitor.save().unwrap();
    answers(&mut monitor, 0..3);
    let saved = monitor.save().unwrap();
    // What is not given is that of the state.
    for options in [&begun, &Options::default()] {
        let again = Monitor::resume(options, &saved).unwrap();
        assert_eq!((again.base(), again.save().unwrap()), (1, saved.clone()));
    }
    let inputs = Some(Inputs { confidence: true, ..frames });
    let base = Options { base: Some(0), ..begun.clone() };
    let named = self::monitor("Watchdog").save().unwrap();
    let from_1 = "boxes that count pixels from 1, not from 0";
    for (options, state, words) in [
        (base.clone(), &saved, from_1),
        (base, &empty, from_1),
        (Options { inputs, ..begun.clone() }, &saved, "for boxes, frames, not for boxes, frames, confidence"),
        (Options { budget: Some(3.0), ..begun }, &saved, "with a budget of 2, not with a budget of 3"),
        (
            Options { inputs, ..Options::default() },
            &named,
            "for no inputs in particular, not for boxes, frames, confidence",
        ),
    ] {
        assert_says(refusal(Monitor::resume(&options, state)), words);
    }

    // Before the first box nothing is chosen, and what was given at the start is kept.
    let start = Options { budget: Some(2.0), base: Some(1), ..Options::default() };
    let kept = Monitor::new(&start).unwrap().save().unwrap();
    let again = Monitor::resume(&Options::default(), &kept).unwrap();
    assert_eq!((again.base(), again.save().unwrap()), (1, kept.clone()));
    let other = Options { budget: Some(3.0), base: Some(0), ..Options::default() };
    let resumed = Monitor::resume(&other, &kept).unwrap();
    assert_eq!(resumed.save().unwrap(), Monitor::new(&other).unwrap().save().unwrap());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn interrupted_anywhere_it_gives_the_same_answers(
        first in 0_usize..25, second in 0_usize..25, absent in prop::collection::vec(0_usize..25, 0..12),
    ) {
        for name in super::chosen::able() {
            let mut whole = monitor(name);
            let want = stream(&mut whole, 0..25, &absent, None);
            let (mut parts, mut got) = (monitor(name), Vec::new());
            for part in [0..first.min(second), first.min(second)..first.max(second), first.max(second)..25] {
                parts = Monitor::resume(&method(name), &parts.save().unwrap()).unwrap();
                got.extend(stream(&mut parts, part, &absent, None));
            }
            prop_assert_eq!(&got, &want, "{}", name);
            prop_assert_eq!(parts.save().unwrap(), whole.save().unwrap(), "{}", name);
        }
    }

    // The law: of whole tracks, judged side by side, and live, also from a restart on, a method says the same.
    #[test]
    fn live_and_of_the_whole_the_states_are_the_same(
        frames in prop::collection::vec((any::<bool>(), prop::bool::weighted(0.8), prop::bool::weighted(0.7)), 8..24),
        restart in 1_usize..8,
    ) {
        let of = |t: usize| scene(t % 20);
        let pictures = |from: usize| move |t: usize| Ok(std::sync::Arc::new(of(from + t).0));
        let region = |t: usize, stays: bool| Some(of(if stays { 3 } else { t }).1);
        let boxes: Vec<Option<Region>> = frames
            .iter()
            .enumerate()
            .map(|(t, (stays, has_box, _))| region(t, *stays).filter(|_| *has_box || t == 0 || t == restart))
            .collect();
        let other: Vec<Option<Region>> = (0..frames.len()).map(|t| region(t, false)).collect();
        let confidence: Vec<Option<f64>> =
            frames.iter().enumerate().map(|(t, frame)| frame.2.then_some(1.0 / (1.0 + t as f64))).collect();
        for name in super::chosen::able() {
            let methods = [Method::named(name, None).unwrap()];
            let whole = |from: usize, with_other: bool| {
                let companions = [&other[from..]];
                let track = |regions| Track { regions, confidence: &confidence[from..], companions: &companions };
                let tracks = [track(&boxes[from..]), track(&other[from..])];
                let pictures = pictures(from);
                let tracks = &tracks[..1 + usize::from(with_other)];
                judge(&methods, tracks, Some(&pictures as FrameOf<'_>), &|| false).unwrap().remove(0).remove(0)
            };
            let first = whole(0, true);
            // Other tracks beside it change nothing.
            prop_assert_eq!(&first, &whole(0, false), "{}", name);
            let second = whole(restart, true);
            let mut monitor = monitor(name);
            // A track ends with its last box for those who know the whole.
            let end = boxes.iter().rposition(Option::is_some).unwrap();
            for again in [false, true] {
                for t in 0..=end {
                    let update = Update {
                        frame: Some(&of(t).0),
                        region: boxes[t].as_ref(),
                        confidence: confidence[t],
                        companions: std::slice::from_ref(other[t].as_ref().unwrap()),
                        restart: again && t == restart,
                    };
                    let answer = monitor.update(&update).unwrap();
                    if !again {
                        prop_assert_eq!(answer.state, first.states[t], "{} {}", name, t);
                    } else if t >= restart {
                        prop_assert_eq!(answer.state, second.states[t - restart], "{} {}", name, t);
                    }
                }
            }
        }
    }
}

/// The state has the same length after a few tiny frames and after many times more.
#[test]
fn memory_does_not_grow_with_the_stream() {
    for name in super::chosen::able() {
        let mut monitor = monitor(name);
        let mut length = |frames: usize| {
            for t in 0..frames {
                let (frame, region) = scene(t % 12);
                let companions = std::slice::from_ref(&region);
                let (frame, confidence) = (Some(&frame), Some(0.5));
                monitor.update(&Update { frame, confidence, companions, ..boxes(&region) }).unwrap();
            }
            monitor.save().unwrap().len()
        };
        // The longest memory of a detector has 100 values; texts of numbers differ in length.
        let (early, late) = (length(120), length(600));
        // `conformal-forecast` remembers the last 100,000 scores, 16 bytes each.
        let scores = if name == "Conformal DTEF" { 600 * 16 } else { 0 };
        let most = early + early / 20 + scores;
        assert!(late <= most, "{name}: {early} bytes after 120 frames, {late} after 720");
    }
}
