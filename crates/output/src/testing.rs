//! Helpers for tests: experiments, judged methods, and parts of results.

use crate::results::detections::{JudgedMethod, TargetState};
use crate::results::{FailedCell, Measure};
use trackfail_core::direction::Direction;
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::read::parse;

/// Parses an experiment of these lines, with a name before them.
pub fn parsed(lines: &str) -> Experiment {
    parse("a.toml", &format!("schema = 1\nname = \"a\"\ntitle = \"a\"\n{lines}")).unwrap()
}

/// Writes items of a kind. The keys of each item are separated by semicolons.
pub fn items(kind: &str, items: &[&str]) -> String {
    items.iter().map(|keys| format!("[[{kind}]]\n{}\n", keys.replace("; ", "\n"))).collect()
}

/// Experiment with one tracker and these methods (names and further lines), followed by the text `below`.
pub fn experiment(paper: &str, methods: &[(&str, &str)], below: &str) -> Experiment {
    let method = |(name, lines): &(&str, &str)| format!("[[method]]\nname = \"{name}\"\n{lines}\n");
    let methods: String = methods.iter().map(method).collect();
    parsed(&format!(
        "{paper}\nprotocol = \"khalid2016/1\"\nseed = 1\n[suites]\ntest = \"synthetic-otb\"\n\
         train = \"synthetic-vot\"\n[[tracker]]\nname = \"ncc\"\n{methods}{below}"
    ))
}

/// A manifest of the first format.
pub const MANIFEST: &[u8] = br#"{"format":1,"experiment":"a","spec_digest":"00","version":"0.1.0",
    "protocol":"khalid2016/1","seed":1,"suite":{"name":"s","wanted":1,"present":[["q",9]],"missing":[]},
    "digests":{"s":[["q","00"]]},"trackers":[],"methods":[],"cells_done":1,"cells_failed":[],"rules":{},
    "differing":[],"files":{"measures.csv":"00"}}"#;

/// Cell of the first run without a result.
pub fn failed_cell(sequence: &str, tracker: &str, method: &str, missing: bool, reason: &str) -> FailedCell {
    let [sequence, tracker, method, reason] = [sequence, tracker, method, reason].map(str::to_string);
    FailedCell { sequence, tracker, run: 0, method, missing, reason }
}

/// Numbers of a method on a tracker, from one cell.
pub fn measure(tracker: &str, method: &str, params: &str) -> Measure {
    let [tracker, method, params] = [tracker, method, params].map(String::from);
    Measure { tracker, method, params, done: 1, ..Measure::default() }
}

/// Result of a method on frames with these states and probabilities of a loss.
pub fn judged_method(
    name: &str,
    states: Vec<TargetState>,
    score: Vec<Option<f64>>,
    threshold: Option<f64>,
) -> JudgedMethod {
    JudgedMethod {
        name: name.into(),
        threshold,
        direction: Direction::LowerIsBetter,
        is_probability: true,
        score,
        alarm_score: None,
        label: states.iter().map(|s| *s == TargetState::Lost).collect(),
        changes: vec![0; states.len()],
        states,
    }
}
