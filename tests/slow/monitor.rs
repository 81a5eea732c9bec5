//! A day of `trackfail monitor`: its memory does not grow.

use crate::tools::live::Live;
use crate::tools::{Place, memory};
use std::io::{BufRead, BufWriter, Write};
use std::sync::mpsc::channel;

/// KiB by which the program grows between `early` lines and `all` of them.
fn growth(method: &str, early: usize, all: usize, line: fn(usize) -> String) -> u64 {
    let place = Place::new();
    let mut live = Live::start(&place, method);
    let (mut input, id) = (BufWriter::new(live.input.take().unwrap()), live.child.id());
    // The input stays open until the memory is measured.
    let (done, measured) = channel::<()>();
    let writer = std::thread::spawn(move || {
        (0..all).for_each(|t| writeln!(input, "{}", line(t)).unwrap());
        input.flush().unwrap();
        measured.recv().unwrap_err();
    });
    let mut answers = (&mut live.answers).lines();
    let mut last = String::new();
    let mut read = |count: usize| {
        (0..count).for_each(|_| last = answers.next().unwrap().unwrap());
        (memory(id, "VmRSS:"), last.clone())
    };
    let (before, _) = read(early);
    let (after, last) = read(all - early);
    assert!(last.starts_with(&format!("{{\"index\":{},\"probability\":", all - 1)), "{last}");
    drop(done);
    writer.join().unwrap();
    assert_eq!(live.end(), 0);
    after.saturating_sub(before)
}

// 24 hours of boxes at 30 frames a second, where a number that is kept of each frame would be 20 MiB; then frames of 24 x 20
// pixels with another pattern each and a target that moves, where it would be 312 and 1406 KiB. A deep watchdog takes some
// milliseconds a line.
#[test]
fn a_day_of_boxes_and_hours_of_frames_leave_nothing_behind() {
    use base64::Engine as _;
    let boxes =
        |t: usize| format!("{{\"box\": [{}, {}, 40, 30], \"confidence\": 0.{}}}", t % 500, t % 77, 1 + t % 9);
    let frames = |t: usize| {
        let pixels: Vec<u8> = (0..480).map(|k| ((k % 24 + t % 9) * (k / 24) * 11 % 251) as u8).collect();
        let data = base64::engine::general_purpose::STANDARD.encode(pixels);
        let raw = format!("{{\"width\": 24, \"height\": 20, \"format\": \"gray\", \"data\": \"{data}\"}}");
        let rest = format!("\"box\": [{}, 6, 9, 8], \"companions\": [[4, 5, 9, 8]]", 2 + t % 9);
        format!("{{\"frame\": {{\"raw\": {raw}}}, {rest}}}")
    };
    for (method, line, early, all, most) in [
        ("", boxes as fn(usize) -> String, 100_000, 24 * 3600 * 30, 1024),
        ("", frames, 5_000, 45_000, 256),
        ("--method Watchdog", frames, 20_000, 200_000, 512),
    ] {
        let grown = growth(method, early, all, line);
        assert!(grown < most, "{method}: {grown} KiB");
    }
}
