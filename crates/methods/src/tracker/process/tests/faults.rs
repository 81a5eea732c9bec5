//! Faults of programs and the words for them, of trackers, signals and detectors alike.

use super::*;
use crate::tracker::process::testing::detect;
use std::time::{Duration, Instant};

/// Programs of one kind, as the table has them.
fn check(kind: Kind) {
    for row in include_str!("faults.txt").lines().filter(|row| !row.is_empty() && !row.starts_with('#')) {
        let (program, words) = row.split_once(" => ").expect(row);
        let [who, frame, text] = program.splitn(3, ' ').collect::<Vec<_>>()[..] else { panic!("{row}") };
        assert!(["all", "text"].contains(&who) || Kind::ALL.iter().any(|k| k.word() == who), "nobody: {row}");
        let index = (frame != "-").then(|| frame.parse().expect(row));
        if who != "all" && who != kind.word() && (who != "text" || kind == Kind::Trax) {
            continue;
        }
        let (mut script, forks, begin) = (Script::new(kind, text), text.starts_with("fork"), Instant::now());
        if words == "no fault" {
            assert_eq!(script.play().expect(row).len(), FRAMES, "{kind:?}: {row}");
        } else {
            if forks {
                script.hurry();
            }
            script.fails(index, words);
        }
        assert!(!forks || script.is_gone(), "{kind:?}: {row}");
        assert!(begin.elapsed() < Duration::from_secs(60), "{kind:?}: {row}: {:?}", begin.elapsed());
    }
}

// Most of the time is spent on waiting for programs.
#[test]
fn faults_are_told_and_nothing_is_left() {
    std::thread::scope(|scope| {
        for kind in Kind::ALL {
            scope.spawn(move || check(kind));
        }
    });
}

#[test]
fn before_the_last_frame_there_is_no_last_answer() {
    for kind in [Kind::Lines, Kind::Trax] {
        for end in ["exit 3", "kill -s SEGV $$"] {
            let script = Script::new(kind, &format!("begin; answer; {end}"));
            assert_eq!(script.track(FRAMES - 1).unwrap().len(), FRAMES - 1, "{kind:?}: {end}");
        }
    }
}

#[test]
fn a_line_too_much_is_told_at_the_next_frame() {
    for kind in [Kind::Lines, Kind::Trax] {
        let script = Script::new(kind, "first \"$(say; say)\"; sleep 1000");
        let (mut tracker, _) = script.start(&sequence(), 0, &rect()).unwrap();
        // Time for the second one.
        std::thread::sleep(Duration::from_millis(300));
        let fault = tracker.update(&ramp(1)).unwrap_err();
        assert_says(fault, "frame 12 of Ramp: it answered without being asked");
    }
}

#[test]
fn a_command_that_cannot_be_started_is_told() {
    for kind in Kind::ALL {
        for command in ["no-such-program-at-all", "./not/here", "./script.sh"] {
            let mut script = Script::new(kind, "");
            script.program.command = vec![command.into()];
            script.fails(Some(0), "cannot start `");
            script.fails(Some(0), command.trim_start_matches('.'));
        }
    }
}

#[test]
fn programs_are_those_of_the_file_and_of_the_role() {
    let script = Script::new(Kind::Detector, "");
    let refused = |role, name| script.programs().find(role, name).unwrap_err();
    let error = refused(Role::Detector, "mime");
    assert_eq!(error.message, "plugins.toml: unknown program `mime`; did you mean `mine`?");
    assert_eq!(error.key, Some("program"));
    assert_says(refused(Role::Signal, "mine").message, "plugins.toml names no signal");
    let nowhere = Programs::default().find(Role::Tracker, "mine").unwrap_err();
    assert_says(nowhere.message, "there is no plugins.toml here");
    // Nothing is run that has not been bound to a program.
    let (text, unbound) = ("{ program = \"mine\" }", "the program mine is not known here");
    let sequence = sequence();
    let context = context(&sequence, 0);
    let tracker = ENTRY.build_from_text(text).unwrap().start(&context, &ramp(0), &rect());
    assert!(matches!(tracker, Err(TrackerError::Missing(told)) if told == unbound));
    let signal = crate::signal::process::ENTRY.build_from_text(text).unwrap().start(&context);
    assert!(matches!(signal, Err(TrackerError::Missing(told)) if told == unbound));
    let detector = crate::detector::process::ENTRY.build_from_text(text).unwrap();
    assert_eq!(detect(&*detector, &[]).failure.as_deref(), Some(unbound));
}
