//! Suites in words: how many of their targets are there, and those of an analysis.

use crate::engine::execute::analyse::Analysed;

/// `12 of 21 targets`, as every table and figure says; `20 targets` when all are there.
pub fn targets_note(present: usize, wanted: usize) -> String {
    let targets = if wanted == 1 { "target" } else { "targets" };
    if present == wanted { format!("{wanted} {targets}") } else { format!("{present} of {wanted} {targets}") }
}

/// Its suites, each once: `synthetic-d1 (18 targets), vot-longterm-car9 (1 target)`.
pub fn suites_note(analysed: &Analysed) -> String {
    let mut notes: Vec<String> = Vec::new();
    for (name, targets) in &analysed.suites {
        let note = format!("{name} ({})", targets_note(*targets, *targets));
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    notes.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    // A suite that an analysis learns on and is tested on is named once.
    #[test]
    fn a_suite_is_named_once() {
        let suites = |list: &[(&str, usize)]| Analysed {
            analysis: "a".into(),
            tracker: "PF".into(),
            runs: 1,
            suites: list.iter().map(|(name, n)| ((*name).to_string(), *n)).collect(),
            findings: crate::analysis::Findings::default(),
        };
        assert_eq!(suites_note(&suites(&[("d1", 18), ("d1", 18)])), "d1 (18 targets)");
        assert_eq!(suites_note(&suites(&[("d1", 18), ("car9", 1)])), "d1 (18 targets), car9 (1 target)");
    }
}
