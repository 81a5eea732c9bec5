//! `machine`: the conditions of a tracker in ARTE, drawn from ARTE's table of transitions.

use super::Scope;
use crate::figure::{Axis, Figure, Form, Mark, Panel, Range};
use crate::report::page::ReportError;
use trackfail_methods::detector::Condition;
use trackfail_methods::detector::track_quality::machine::{Action, TRANSITIONS, Transition};

/// Conditions in clockwise order from the top.
const STATES: [Condition; 3] = [Condition::LockedOn, Condition::LockingIn, Condition::Scanning];

/// Draws the diagram. Transitions between the same conditions in the same direction share an arrow.
pub(super) fn draw(_: &Scope<'_>) -> Result<(Figure, String), ReportError> {
    let state = |condition: Condition| {
        let k = STATES.iter().position(|s| *s == condition).unwrap_or(0);
        let angle = std::f64::consts::TAU * k as f64 / STATES.len() as f64;
        ((0.5 + 0.31 * angle.sin(), 0.42 + 0.4 * angle.cos()), condition.name().to_string())
    };
    let word = |row: &Transition| match row.then {
        Action::Nothing => row.on.name().to_string(),
        then => format!("{}: {}", row.on.name(), then.name()),
    };
    let is_way = |row: &Transition, from: Condition, to: Condition| (row.from, row.to) == (from, to);
    let mut marks: Vec<Mark> = STATES.map(state).map(|(at, name)| Mark::Node(at, name)).into();
    for from in STATES {
        for to in STATES {
            let way = TRANSITIONS.iter().filter(|row| is_way(row, from, to));
            let label: Vec<String> = way.map(word).collect();
            let is_pair = from != to && TRANSITIONS.iter().any(|row| is_way(row, to, from));
            if !label.is_empty() {
                marks.push(Mark::Arrow { from: state(from), to: state(to), label, is_pair });
            }
        }
    }
    let whole = || Axis::new("", Range::Fixed(0.0, 1.0));
    let figure = Figure {
        note: "of the events of a frame the first in the table's order counts".to_string(),
        form: Form::Diagram,
        rows: vec![vec![Panel { x: whole(), y: whole(), marks, ..Panel::default() }]],
        ..Figure::default()
    };
    Ok((figure, String::new()))
}
