//! Experiments and judged methods of the tests.

use crate::results::detections::{JudgedMethod, TargetState};
use trackfail_core::direction::Direction;
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::read::parse;

/// An experiment of these lines behind its name.
pub fn parsed(lines: &str) -> Experiment {
    parse("a.toml", &format!("schema = 1\nname = \"a\"\ntitle = \"a\"\n{lines}")).unwrap()
}

/// Items of a kind, each given by its keys with semicolons between them.
pub fn items(kind: &str, items: &[&str]) -> String {
    items.iter().map(|keys| format!("[[{kind}]]\n{}\n", keys.replace("; ", "\n"))).collect()
}

/// An experiment with one tracker and these methods, each a name and further lines, and what stands below them.
pub fn experiment(paper: &str, methods: &[(&str, &str)], below: &str) -> Experiment {
    let method = |(name, lines): &(&str, &str)| format!("[[method]]\nname = \"{name}\"\n{lines}\n");
    let methods: String = methods.iter().map(method).collect();
    parsed(&format!(
        "{paper}\nprotocol = \"khalid2016/1\"\nseed = 1\n[suites]\ntest = \"synthetic-otb\"\n\
         train = \"synthetic-vot\"\n[[tracker]]\nname = \"ncc\"\n{methods}{below}"
    ))
}

/// The verdict of a method on frames in these states, with a probability of a loss for each.
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
        label: states.iter().map(|s| *s == TargetState::Lost).collect(),
        changes: vec![0; states.len()],
        states,
    }
}
