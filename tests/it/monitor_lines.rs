//! Lines that `trackfail monitor` does not take, and what they cost.

#[cfg(target_os = "linux")]
use crate::live::Live;
use crate::live::{jumping, lines, monitor};
use serde_json::{Value, json};

// serde reads a list of the values of an object in their order, too.
#[test]
fn a_list_is_no_line() {
    let boxes = jumping(4, 9);
    let broken = [json!([null, [1, 2, 3, 4], 0.5, null]), json!([]), json!([boxes[0]])];
    let input = [lines(boxes[..2].to_vec()), lines(broken.to_vec()), lines(boxes[2..].to_vec())].concat();
    let (code, out, _) = monitor(&["--method", "Displacement"], &input);
    let answers: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((code, answers.len()), (0, 7));
    for (n, answer) in answers.iter().enumerate() {
        assert_eq!(answer["index"], n);
        let error = answer["error"].as_str().unwrap_or_default();
        assert_eq!(
            error.contains("invalid type: sequence, expected an object"),
            (2..5).contains(&n),
            "{answer}"
        );
    }
    let raw = json!({"frame": {"raw": [1, 1, "bgr", "AAAA", null]}, "box": [0, 0, 1, 1]});
    assert!(monitor(&["--method", "Watchdog"], &lines([raw])).1.contains("expected an object"));
}

#[test]
fn a_wrong_box_is_that_of_its_target() {
    let input = lines([json!({"id": 7, "box": "none"}), json!({"id": 7, "box": [1, 2, 30, 30]})]);
    let (code, out, _) = monitor(&["--method", "Displacement"], &input);
    let answers: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(code == 0 && answers.len() == 2 && answers.iter().all(|answer| answer["id"] == 7), "{out}");
    assert!(answers[0]["error"].as_str().unwrap().starts_with("box: invalid type"), "{out}");
    assert_eq!(answers[1]["state"], "tracking");
}

#[test]
fn an_error_quotes_no_more_than_a_part_of_a_line() {
    let key = "k".repeat(500_000);
    let input = format!("{{\"{key}\": 1}}\n{{\"confidence\": \"{key}\"}}\n{{\"frame\": \"{key}\"}}\n");
    let (code, out, _) = monitor(&["--method", "Watchdog"], &input);
    assert_eq!((code, out.lines().count()), (0, 3));
    for line in out.lines() {
        assert!(line.contains("\"error\":\"") && line.len() < 1200, "{line:.300}");
    }
}

/// The most memory that a process has had, in KiB.
#[cfg(target_os = "linux")]
fn peak(id: u32) -> usize {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
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
    let mut live = Live::start(&["--method", "Displacement"]);
    assert_eq!(live.ask(&json!({"box": [1, 1, 20, 20]}))["state"], "tracking");
    let before = peak(live.child.id());
    for (n, line) in long.iter().enumerate() {
        let answer = live.ask_text(line);
        assert_eq!(answer["index"], n + 1);
        let error = answer["error"].as_str().unwrap_or_default();
        assert!(error.contains("the line is longer than 1 MiB"), "{answer:.300}");
    }
    let grown = peak(live.child.id()) - before;
    assert!(grown < 5 * BYTES / 1024, "{grown} KiB");
    // The stream goes on.
    assert_eq!(live.ask(&json!({"box": [2, 1, 20, 20]}))["state"], "tracking");
    assert_eq!(live.end(), 0);
}
