use super::*;
use proptest::prelude::*;

/// Plays frames of events and answers of a check, looks that each row does what it says, and returns the rows.
fn play(locking_in_limit: usize, reference_lag: usize, script: &[(Events, bool)]) -> Vec<Option<usize>> {
    let mut machine = Machine::new(Rules { locking_in_limit, reference_lag, ..Rules::default() });
    let (mut is_lost, mut reference) = (false, 0);
    let mut rows = Vec::new();
    for (t, (events, accepted)) in script.iter().enumerate() {
        let mut checked = None;
        let place = machine.step(t, *events, |reference| {
            checked = Some(reference);
            *accepted
        });
        let row = place.map(|place| TRANSITIONS[place]);
        let then = row.map(|row| row.then);
        // Only an unsuccessful track is checked, against the frame before its loss.
        assert_eq!(checked, (then == Some(Action::Check)).then_some(reference), "frame {t}");
        assert!(checked.is_none() || is_lost, "frame {t}");
        match then {
            Some(Action::Lose) if !is_lost => (is_lost, reference) = (true, t.saturating_sub(reference_lag)),
            Some(Action::Check) => is_lost = !accepted,
            _ => {}
        }
        assert_eq!((machine.successful, machine.reference), (!is_lost, reference), "frame {t}");
        assert!(row.is_none_or(|row| row.to == machine.condition), "frame {t}");
        // Whoever looks for a target has lost one.
        assert!(machine.condition == LockedOn || is_lost, "frame {t}");
        rows.push(place);
    }
    rows
}

/// Plays a script in words, one a frame: `R` is a large increase, `F` a large and `f` a small decrease, `!` a check that
/// is rejected. Of the rows `-` is none.
fn rows(limit: usize, script: &str) -> String {
    let frame = |word: &str| (['R', 'F', 'f'].map(|letter| word.contains(letter)), !word.contains('!'));
    let script: Vec<(Events, bool)> = script.split(' ').map(frame).collect();
    play(limit, 1, &script).iter().map(|row| row.map_or("-".to_string(), |row| row.to_string())).collect()
}

#[test]
fn every_row_by_hand() {
    // Falls mean nothing to a tracker that is locked on. It is lost, rises further and falls: found.
    assert_eq!(rows(3, "Ff R RFf . Ff ."), "-01-2-");
    // Lost, locking in until a rise, then on a distractor: rejected, and lost again from there.
    assert_eq!(rows(3, "R f f RF F! . R f F"), "03-42-035");
    // The waiting begins anew after a rise, and is over after three frames.
    assert_eq!(rows(3, ". R f f R f . . ! R f ."), "-03-43--603-");
    // A rise in the frame in which the waiting is over comes before it, and so does a fall.
    assert_eq!(rows(3, "R f . . R f . . F"), "03--43--5");
    assert_eq!(rows(1, "R F"), "02");
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

proptest! {
    #[test]
    fn any_script_is_played_by_the_rows(
        script in prop::collection::vec(any::<(Events, bool)>(), 0..80), limit in 1..6_usize, lag in 1..4_usize,
    ) {
        play(limit, lag, &script);
    }
}
