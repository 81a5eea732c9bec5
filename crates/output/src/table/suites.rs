//! Suites in words: numbers of present targets, and the suites of an analysis.

use trackfail_engine::execute::analyse::Analysed;

/// Text like `12 of 21 targets`, or `20 targets` if all are present.
pub fn targets_note(present: usize, wanted: usize) -> String {
    let targets = if wanted == 1 { "target" } else { "targets" };
    if present == wanted { format!("{wanted} {targets}") } else { format!("{present} of {wanted} {targets}") }
}

/// Its suites, each once: `synthetic-d1 (18 targets), longterm (9 targets)`; `d1 (the 17 of 18 targets that all trackers
/// here have)` where trackers are compared on those.
pub fn suites_note(analysed: &Analysed) -> String {
    let mut notes: Vec<String> = Vec::new();
    for (k, (name, targets)) in analysed.suites.iter().enumerate() {
        let there = analysed.shares.get(k).map_or(*targets, |(_, there)| *there);
        let note = match targets_note(*targets, there) {
            all if *targets == there => format!("{name} ({all})"),
            some => format!("{name} (the {some} that all trackers here have)"),
        };
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    notes.join(", ")
}

/// Tracker of an analysis. If trackers are compared on common targets, with the number of its targets: `PF
/// (17 of 18 targets)`.
pub fn tracker_note(analysed: &Analysed) -> String {
    let shares: Vec<String> =
        analysed.shares.iter().map(|(own, there)| format!("{own} of {there}")).collect();
    match shares.as_slice() {
        [] => analysed.tracker.clone(),
        shares => format!("{} ({} targets)", analysed.tracker, shares.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // A suite that an analysis learns on and is tested on is named once.
    #[test]
    fn a_suite_is_named_once() {
        let suites = |list: &[(&str, usize)]| Analysed {
            tracker: "PF".into(),
            suites: list.iter().map(|(name, n)| ((*name).to_string(), *n)).collect(),
            ..Analysed::default()
        };
        assert_eq!(suites_note(&suites(&[("d1", 18), ("d1", 18)])), "d1 (18 targets)");
        assert_eq!(suites_note(&suites(&[("d1", 18), ("car9", 1)])), "d1 (18 targets), car9 (1 target)");
        let part = Analysed { shares: vec![(17, 18)], ..suites(&[("d1", 16)]) };
        assert_eq!(suites_note(&part), "d1 (the 16 of 18 targets that all trackers here have)");
        assert_eq!(tracker_note(&part), "PF (17 of 18 targets)");
        assert_eq!(tracker_note(&suites(&[("d1", 18)])), "PF");
    }
}
