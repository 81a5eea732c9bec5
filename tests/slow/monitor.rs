//! A day of `trackfail monitor`: its memory does not grow.

use crate::tools::memory;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::process::{Command, Stdio};
use std::sync::mpsc::channel;

/// KiB by which the program grows between `early` lines and `all` of them.
fn growth(method: &[&str], early: usize, all: usize, line: fn(usize) -> String) -> u64 {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
    command.arg("monitor").args(method).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let mut input = BufWriter::new(child.stdin.take().unwrap());
    // The input stays open until the memory is measured.
    let (done, measured) = channel::<()>();
    let writer = std::thread::spawn(move || {
        (0..all).for_each(|t| writeln!(input, "{}", line(t)).unwrap());
        input.flush().unwrap();
        measured.recv().unwrap_err();
    });
    let mut answers = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut last = String::new();
    let mut read = |count: usize| {
        (0..count).for_each(|_| last = answers.next().unwrap().unwrap());
        (memory(child.id(), "VmRSS:"), last.clone())
    };
    let (before, _) = read(early);
    let (after, last) = read(all - early);
    assert!(last.starts_with(&format!("{{\"index\":{},\"probability\":", all - 1)), "{last}");
    drop(done);
    writer.join().unwrap();
    assert!(child.wait().unwrap().success());
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
    let watchdog = ["--method", "Watchdog"];
    for (method, line, early, all, most) in [
        (&[][..], boxes as fn(usize) -> String, 100_000, 24 * 3600 * 30, 1024),
        (&[], frames, 5_000, 45_000, 256),
        (&watchdog, frames, 20_000, 200_000, 512),
    ] {
        let grown = growth(method, early, all, line);
        assert!(grown < most, "{method:?}: {grown} KiB");
    }
}
