//! `machine`: the conditions of a tracker that ARTE follows, drawn from its own table of transitions.

use super::drawer::{DrawError, Drawer, Drawing, Scope};
use crate::figure::{Arrow, States};
use trackfail_methods::detector::Condition;
use trackfail_methods::detector::track_quality::machine::{Action, TRANSITIONS, Transition};

/// The entry of this kind.
pub const DRAWER: Drawer = Drawer { word: "machine", shows_tracks: false, draw };

fn draw(_: &Scope<'_>) -> Result<Drawing, DrawError> {
    Ok(Drawing::of(machine()))
}

fn machine() -> States {
    let states = [Condition::LockedOn, Condition::LockingIn, Condition::Scanning];
    let place = |c: Condition| states.iter().position(|s| *s == c).unwrap_or(0);
    let arrow = |row: &Transition| {
        let done = (row.then != Action::Nothing).then(|| format!("{}: {}", row.on.name(), row.then.name()));
        Arrow { from: place(row.from), to: place(row.to), label: vec![done.unwrap_or(row.on.name().into())] }
    };
    States {
        title: String::new(),
        note: "of the events of a frame the first in the table's order counts".into(),
        states: states.map(|c| c.name().to_string()).into(),
        arrows: TRANSITIONS.iter().map(arrow).collect(),
    }
}
