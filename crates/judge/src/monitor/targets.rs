//! Targets of a stream, each with its own monitor, and their state as bytes.
//!
//! The state of a stream without ids is that of its [`Monitor`]. With ids, it is a line with the number of
//! the format, the SHA-256 digest of the rest, the index of the next line, the options, and the id and state
//! of each target. Format 2 adds the options.

use super::saved::{sealed, unsealed};
use super::{Monitor, MonitorError, Options};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Most targets at once.
pub const MAX_TARGETS: usize = 256;

pub(super) const NAME: &[u8] = b"trackfail-monitors ";
const FORMAT: &[u8] = b"2";

/// Id of a target, as given in the lines.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Id {
    /// A number.
    Number(i64),
    /// A text.
    Text(String),
}

/// Monitors of a stream, by target.
pub struct Targets {
    options: Options,
    /// Monitors by id. The key `None` is the target of lines without an id, which exists from the start.
    monitors: BTreeMap<Option<Id>, Monitor>,
    /// Index of the next line.
    index: u64,
}

#[derive(Serialize, Deserialize)]
struct Memory {
    index: u64,
    options: Options,
    targets: Vec<(Option<Saved>, Vec<u8>)>,
}

/// An id in saved form.
#[derive(Serialize, Deserialize)]
struct Saved(#[serde(with = "Tagged")] Id);

/// Form of a saved id, whose tag makes numbers and texts distinguishable.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Id")]
enum Tagged {
    Number(i64),
    Text(String),
}

impl Targets {
    /// Creates a stream before its first line.
    ///
    /// # Errors
    /// The errors of [`Monitor::new`].
    pub fn new(options: Options) -> Result<Self, MonitorError> {
        let monitors = [(None, Monitor::new(&options)?)].into();
        Ok(Self { options, monitors, index: 0 })
    }

    /// Restores a stream from a saved state. Options that are not given are those of the state.
    ///
    /// # Errors
    /// The errors of [`Monitor::resume`].
    pub fn resume(options: Options, saved: &[u8]) -> Result<Self, MonitorError> {
        let Some(memory) = unsealed::<Memory>(saved, NAME, FORMAT)? else {
            let monitor = Monitor::resume(&options, saved)?;
            let (index, options) = (monitor.index(), monitor.options());
            return Ok(Self { options, monitors: [(None, monitor)].into(), index });
        };
        let saved = memory.options;
        let options = Options {
            method: options.method.or(saved.method),
            budget: options.budget.or(saved.budget),
            inputs: options.inputs.or(saved.inputs),
            base: options.base.or(saved.base),
        };
        let of = |(id, saved): (Option<Saved>, Vec<u8>)| {
            Ok((id.map(|Saved(id)| id), Monitor::resume(&options, &saved)?))
        };
        let count = memory.targets.len();
        let monitors: BTreeMap<_, _> =
            memory.targets.into_iter().map(of).collect::<Result<_, MonitorError>>()?;
        // No id twice, and no more than could have come.
        if monitors.len() != count || monitors.keys().flatten().count() > MAX_TARGETS {
            return Err(MonitorError::Damaged);
        }
        Ok(Self { options, monitors, index: memory.index })
    }

    /// Saves the state for [`Targets::resume`].
    ///
    /// # Errors
    /// The errors of [`Monitor::save`].
    pub fn save(&self) -> Result<Vec<u8>, MonitorError> {
        if let (Some(monitor), 1) = (self.monitors.get(&None), self.monitors.len())
            && monitor.index() == self.index
        {
            return monitor.save();
        }
        let of = |(id, monitor): (&Option<Id>, &Monitor)| Ok((id.clone().map(Saved), monitor.save()?));
        let targets = self.monitors.iter().map(of).collect::<Result<_, MonitorError>>()?;
        sealed(NAME, FORMAT, &Memory { index: self.index, options: self.options.clone(), targets })
    }

    /// Method name for lines without an id; `None` until it is chosen.
    pub fn method(&self) -> Option<&str> {
        self.monitors.get(&None).and_then(Monitor::method)
    }

    /// Returns the index of the next line and counts the line.
    pub fn count(&mut self) -> u64 {
        let index = self.index;
        self.index = self.index.saturating_add(1);
        index
    }

    /// Index of the next line, from 0.
    pub fn index(&self) -> u64 {
        self.index
    }

    /// Monitor of a target; a new one for a new id. `None` if there are too many targets.
    ///
    /// # Errors
    /// The errors of [`Monitor::new`].
    pub fn of(&mut self, id: Option<&Id>) -> Result<Option<&mut Monitor>, MonitorError> {
        let id = id.cloned();
        // The target without an id is there even where all have one.
        let is_full = self.monitors.keys().flatten().count() >= MAX_TARGETS;
        if !self.monitors.contains_key(&id) {
            if is_full && id.is_some() {
                return Ok(None);
            }
            self.monitors.insert(id.clone(), Monitor::new(&self.options)?);
        }
        Ok(self.monitors.get_mut(&id))
    }

    /// Forgets a target. Returns `false` if there is no target with this id.
    pub fn end(&mut self, id: Option<&Id>) -> bool {
        self.monitors.remove(&id.cloned()).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Update;
    use crate::region::{Rect, Region};

    fn of(method: &str) -> Options {
        Options { method: Some(method.into()), ..Options::default() }
    }

    fn push(targets: &mut Targets, id: Option<Id>, x: f64) -> Option<f64> {
        targets.count();
        let region = Region::Rect(Rect::new(x, 20.0, 16.0, 14.0));
        let monitor = targets.of(id.as_ref()).unwrap()?;
        let update = Update { region: Some(&region), ..Update::default() };
        monitor.update(&update).unwrap().probability
    }

    #[test]
    fn targets_are_judged_apart_also_after_an_interruption() {
        let ids = [Some(Id::Number(7)), Some(Id::Text("7".into())), None];
        let options = || of("Fused boxes");
        let place = |k: usize, t: usize| t as f64 + if t > 12 { 40.0 * k as f64 } else { 0.0 };
        let alone = |k: usize| {
            let mut targets = Targets::new(options()).unwrap();
            (0..20).map(|t| push(&mut targets, None, place(k, t))).collect::<Vec<_>>()
        };
        let mut targets = Targets::new(options()).unwrap();
        let mut all = vec![Vec::new(); 3];
        for t in 0..20 {
            for (k, id) in ids.iter().cloned().enumerate() {
                all[k].push(push(&mut targets, id, place(k, t)));
            }
            targets = Targets::resume(options(), &targets.save().unwrap()).unwrap();
            assert_eq!(targets.index(), 3 * t as u64 + 3);
        }
        assert_eq!(all, [alone(0), alone(1), alone(2)]);
        let saved = targets.save().unwrap();
        let memory: Memory = unsealed(&saved, NAME, FORMAT).unwrap().unwrap();
        let again = |ids: &[i64]| {
            let (_, monitor) = &memory.targets[0];
            let targets = ids.iter().map(|id| (Some(Saved(Id::Number(*id))), monitor.clone())).collect();
            let forged = Memory { options: options(), index: 0, targets };
            Targets::resume(options(), &sealed(NAME, FORMAT, &forged).unwrap()).is_ok()
        };
        let many: Vec<i64> = (0..=MAX_TARGETS as i64).collect();
        assert_eq!([&[7, 8][..], &[7, 7], &many].map(again), [true, false, false]);
        let older = Targets::resume(options(), b"trackfail-monitors 1\nx").map(|_| ());
        assert!(matches!(older, Err(MonitorError::OtherFormat(format)) if format == "1"));
        for at in [21, 40, saved.len() - 1] {
            assert!(Targets::resume(options(), &saved[..at]).is_err(), "{at}");
        }
    }

    // A new target after an interruption, whether others are there or not, and after one that ended.
    #[test]
    fn options_that_are_not_given_are_those_of_the_state() {
        let options = Options { base: Some(1), ..of("Displacement") };
        let id = |number| Some(Id::Number(number));
        for before in [vec![], vec![None], vec![id(1)], vec![None, id(1)]] {
            let mut targets = Targets::new(options.clone()).unwrap();
            for target in &before {
                push(&mut targets, target.clone(), 5.0);
            }
            targets.end(id(1).as_ref());
            let mut resumed = Targets::resume(Options::default(), &targets.save().unwrap()).unwrap();
            for target in [id(2), id(1), None] {
                push(&mut resumed, target.clone(), 5.0);
                let monitor = resumed.of(target.as_ref()).unwrap().unwrap();
                assert_eq!(
                    (monitor.method(), monitor.base()),
                    (Some("Displacement"), 1),
                    "{before:?} {target:?}"
                );
            }
        }
        // A method that was only recommended may still change.
        let mut free = Targets::new(Options::default()).unwrap();
        push(&mut free, None, 5.0);
        let mut resumed = Targets::resume(Options::default(), &free.save().unwrap()).unwrap();
        assert_eq!(resumed.of(id(2).as_ref()).unwrap().unwrap().method(), None);
    }

    #[test]
    fn there_is_room_for_256_targets_at_once() {
        let mut targets = Targets::new(of("Scale")).unwrap();
        let has_room = |targets: &mut Targets, id: i64| targets.of(Some(&Id::Number(id))).unwrap().is_some();
        assert!((0..MAX_TARGETS as i64).all(|id| has_room(&mut targets, id)));
        assert_eq!([-1, 3].map(|id| has_room(&mut targets, id)), [false, true]);
        assert!(targets.of(None).unwrap().is_some());
        assert!(targets.end(Some(&Id::Number(3))) && !targets.end(Some(&Id::Number(3))));
        assert!(has_room(&mut targets, -1));
    }
}
