use super::*;
use Event::{LargeDecrease, LargeIncrease, SmallDecrease, WaitingOver};
use proptest::prelude::*;

fn events(list: &[Event]) -> Events {
    list.iter().fold(Events::default(), |events, event| events.with(*event, true))
}

/// One frame of a script: the events and the answer of a check, then the expected row of the table, success
/// and reference.
type Frame<'a> = (&'a [Event], bool, Option<usize>, bool, usize);

/// Plays a script with frames from 0 and returns the rows that were applied.
fn play(limit: usize, script: &[Frame<'_>]) -> Vec<usize> {
    let mut machine = Machine::new(limit, 1);
    let mut used = Vec::new();
    for (t, (happens, accepted, row, successful, reference)) in script.iter().enumerate() {
        let mut asked = None;
        let before = machine.reference();
        let taken = machine.step(t, events(happens), |reference| {
            asked = Some(reference);
            *accepted
        });
        assert_eq!(taken, row.map(|k| &TRANSITIONS[k]), "frame {t}");
        let checks = taken.is_some_and(|r| r.then == Action::Check);
        assert_eq!(asked, checks.then_some(before), "frame {t}");
        assert_eq!((machine.successful(), machine.reference()), (*successful, *reference), "frame {t}");
        if let Some(taken) = taken {
            assert_eq!(machine.condition(), taken.to, "frame {t}");
        }
        used.extend(row);
    }
    used
}

#[test]
fn every_row_does_what_it_says_and_every_row_is_used() {
    let mut used = play(
        3,
        &[
            // Falls mean nothing to a tracker that is locked on.
            (&[LargeDecrease, SmallDecrease], true, None, true, 0),
            (&[LargeIncrease], true, Some(0), false, 0),
            (&[LargeIncrease, LargeDecrease, SmallDecrease], true, Some(1), false, 0),
            (&[], true, None, false, 0),
            (&[LargeDecrease, SmallDecrease], true, Some(2), true, 0),
            (&[], true, None, true, 0),
            // Lost again: frame 5 is the reference now.
            (&[LargeIncrease], true, Some(0), false, 5),
            (&[SmallDecrease], true, Some(3), false, 5),
            (&[SmallDecrease], true, None, false, 5),
            (&[LargeIncrease, LargeDecrease], true, Some(4), false, 5),
            // A distractor: rejected, and neither the reference nor the status changes with the next rise.
            (&[LargeDecrease], false, Some(2), false, 5),
            (&[], true, None, false, 5),
            (&[LargeIncrease], true, Some(0), false, 5),
            (&[SmallDecrease], true, Some(3), false, 5),
            (&[LargeDecrease], true, Some(5), true, 5),
        ],
    );
    used.extend(play(
        3,
        &[
            (&[], true, None, true, 0),
            (&[LargeIncrease], true, Some(0), false, 0),
            (&[SmallDecrease], true, Some(3), false, 0),
            (&[SmallDecrease], true, None, false, 0),
            // A rise ends the waiting; it begins anew.
            (&[LargeIncrease], true, Some(4), false, 0),
            (&[SmallDecrease], true, Some(3), false, 0),
            (&[], true, None, false, 0),
            (&[], true, None, false, 0),
            (&[], false, Some(6), false, 0),
            (&[LargeIncrease], true, Some(0), false, 0),
            (&[SmallDecrease], true, Some(3), false, 0),
            (&[], true, None, false, 0),
            (&[], true, None, false, 0),
            // The waiting is over, but a rise comes before it.
            (&[LargeIncrease], true, Some(4), false, 0),
            (&[SmallDecrease], true, Some(3), false, 0),
            (&[], true, None, false, 0),
            (&[], true, None, false, 0),
            // A fall comes before it, too.
            (&[LargeDecrease], true, Some(5), true, 0),
        ],
    ));
    // A rise in the first frame has no frame before.
    used.extend(play(
        1,
        &[(&[LargeIncrease], true, Some(0), false, 0), (&[LargeDecrease], true, Some(2), true, 0)],
    ));
    assert!((0..TRANSITIONS.len()).all(|k| used.contains(&k)), "{used:?}");
}

#[test]
fn rows_are_distinct_and_in_words() {
    for (k, row) in TRANSITIONS.iter().enumerate() {
        let same = |other: &&Transition| (other.from, other.on) == (row.from, row.on);
        assert_eq!(TRANSITIONS.iter().filter(same).count(), 1, "{row:?} can never be taken");
        // Whatever loses the track leaves LOCKED-ON, and whatever enters it checks.
        assert_eq!(row.then == Action::Lose, row.from == LockedOn, "row {k}");
        assert_eq!(row.then == Action::Check, row.to == LockedOn, "row {k}");
    }
    let words: Vec<[&str; 4]> =
        TRANSITIONS.iter().map(|r| [r.from.name(), r.on.name(), r.to.name(), r.then.name()]).collect();
    assert_eq!(words[0], ["locked-on", "large increase", "scanning", "track lost"]);
    assert_eq!(words[3], ["scanning", "small decrease", "locking-in", "nothing"]);
    assert_eq!(words[5], ["locking-in", "large decrease", "locked-on", "recovery check"]);
    assert_eq!(words[6][1], "waiting over");
}

#[test]
fn events_are_a_set() {
    let all = [LargeIncrease, LargeDecrease, SmallDecrease, WaitingOver];
    for mask in 0..16_usize {
        let in_mask = |k: usize| mask >> k & 1 == 1;
        let set = (0..4).fold(Events::default(), |set, k| set.with(all[k], in_mask(k)));
        assert!((0..4).all(|k| set.contains(all[k]) == in_mask(k)));
        assert!(all.iter().all(|e| set.with(*e, false) == set && set.with(*e, true).contains(*e)));
    }
}

proptest! {
    #[test]
    fn a_track_is_lost_before_it_is_checked(
        script in prop::collection::vec((0..8_u8, any::<bool>()), 0..80), limit in 1..6_usize,
    ) {
        let mut machine = Machine::new(limit, 1);
        let mut lost = None;
        for (t, (mask, accepted)) in script.iter().enumerate() {
            let was_successful = machine.successful();
            let mut checked = None;
            let row = machine.step(t, Events(*mask), |reference| {
                checked = Some(reference);
                *accepted
            });
            if was_successful && row.is_some_and(|r| r.then == Action::Lose) {
                lost = Some(t);
            }
            if let Some(reference) = checked {
                // Only an unsuccessful track is checked, against the frame before its loss.
                prop_assert!(!was_successful);
                prop_assert_eq!(Some(reference), lost.map(|t: usize| t.saturating_sub(1)));
                prop_assert_eq!(machine.successful(), *accepted);
            } else if was_successful {
                prop_assert_eq!(machine.successful(), lost != Some(t));
            } else {
                prop_assert!(!machine.successful());
            }
            // Whoever looks for a target has lost one.
            prop_assert!(machine.condition() == LockedOn || !machine.successful());
        }
    }
}
