//! Lines that `trackfail monitor` does not take, and what they cost.

#[cfg(target_os = "linux")]
use crate::live::Live;
use crate::live::{answers, jumping, lines, monitor};
use crate::tools::Place;
#[cfg(target_os = "linux")]
use crate::tools::memory;
use serde_json::json;

// serde reads a list of the values of an object in their order, too.
#[test]
fn a_list_is_no_line() {
    let place = Place::new();
    let boxes = jumping(4, 9);
    let broken = [json!([null, [1, 2, 3, 4], 0.5, null]), json!([]), json!([boxes[0]])];
    let input = lines(boxes[..2].iter().chain(&broken).chain(&boxes[2..]));
    let answers = answers(&monitor(&place, "--method Displacement", &input).ends(0).out);
    assert_eq!(answers.len(), 7);
    for (n, answer) in answers.iter().enumerate() {
        assert_eq!(answer["index"], n);
        let error = answer["error"].as_str().unwrap_or_default();
        let is_list = error.contains("invalid type: sequence, expected an object");
        assert_eq!(is_list, (2..5).contains(&n), "{answer}");
    }
    let raw = json!({"frame": {"raw": [1, 1, "bgr", "AAAA", null]}, "box": [0, 0, 1, 1]});
    monitor(&place, "--method Watchdog", &lines([&raw])).says("expected an object");
}

#[test]
fn a_wrong_box_is_that_of_its_target() {
    let input = lines([&json!({"id": 7, "box": "none"}), &json!({"id": 7, "box": [1, 2, 30, 30]})]);
    let answers = answers(&monitor(&Place::new(), "--method Displacement", &input).ends(0).out);
    assert!(answers.len() == 2 && answers.iter().all(|answer| answer["id"] == 7), "{answers:?}");
    assert!(answers[0]["error"].as_str().unwrap().starts_with("box: invalid type"), "{answers:?}");
    assert_eq!(answers[1]["state"], "tracking");
}

#[test]
fn an_error_quotes_no_more_than_a_part_of_a_line() {
    let key = "k".repeat(500_000);
    let input = format!("{{\"{key}\": 1}}\n{{\"confidence\": \"{key}\"}}\n{{\"frame\": \"{key}\"}}\n");
    let ran = monitor(&Place::new(), "--method Watchdog", &input).ends(0);
    assert_eq!(ran.out.lines().count(), 3);
    for line in ran.out.lines() {
        assert!(line.contains("\"error\":\"") && line.len() < 1200, "{line:.300}");
    }
}

// Numbers and `null` take eight times the memory of their text, and lists twice that while they grow: a line of 180 MB took
// 2.95 GB. Now it is the line, with room to grow, and perhaps a second one.
#[cfg(target_os = "linux")]
#[test]
fn a_long_line_takes_few_times_its_size() {
    const BYTES: usize = 6 << 20;
    let ones = "1,".repeat(BYTES / 2) + "1";
    let raw = r#"{"raw": {"width": 1, "height": 1, "format": "gray", "data": "AA=="}}"#;
    let long = [
        format!("{{\"box\": [{ones}]}}"),
        format!("{{\"frame\": {raw}, \"box\": [{ones}]}}"),
        format!("{{\"frame\": {raw}, \"companions\": [[{ones}]]}}"),
        format!("{{\"frame\": {raw}, \"companions\": [{ones}]}}"),
        format!("{{\"frame\": \"{ones}\"}}"),
    ];
    let place = Place::new();
    let mut live = Live::start(&place, "--method Displacement");
    assert_eq!(live.ask(&json!({"box": [1, 1, 20, 20]}))["state"], "tracking");
    let peak = |live: &Live| memory(live.child.id(), "VmHWM:");
    let before = peak(&live);
    for (n, line) in long.iter().enumerate() {
        let answer = live.ask_text(line);
        assert_eq!(answer["index"], n + 1);
        let error = answer["error"].as_str().unwrap_or_default();
        assert!(error.contains("the line is longer than 1 MiB"), "{answer:.300}");
    }
    let grown = peak(&live) - before;
    assert!(grown < 5 * BYTES as u64 / 1024, "{grown} KiB");
    // The stream goes on.
    assert_eq!(live.ask(&json!({"box": [2, 1, 20, 20]}))["state"], "tracking");
    assert_eq!(live.end(), 0);
}
