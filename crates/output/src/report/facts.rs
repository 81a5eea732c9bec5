//! Numbers for the running text of a paper, as LaTeX macros.

use super::claims::{ClaimOutcome, Finding};
use crate::results::Results;
use crate::table::macros::Fact;
use crate::table::number::four_digits;

/// Numbers of targets, of frames, of claims by outcome without the checks of the arithmetic, and the numbers that analyses found for each tracker.
pub fn facts(results: &Results, claims: &[Finding]) -> Vec<Fact> {
    let fact =
        |parts: &[&str], shown: String| Fact { parts: parts.iter().map(|p| (*p).into()).collect(), shown };
    let suite = &results.manifest.suite;
    let frames: usize = suite.present.iter().map(|(_, frames)| frames).sum();
    let of_paper = || claims.iter().filter(|c| !c.is_check);
    let with = |outcome| of_paper().filter(|c| c.outcome == outcome).count().to_string();
    let mut facts = vec![
        fact(&["targets", "present"], suite.present.len().to_string()),
        fact(&["targets", "wanted"], suite.wanted.to_string()),
        fact(&["frames"], frames.to_string()),
        fact(&["claims", "all"], of_paper().count().to_string()),
        fact(&["claims", "hold"], with(ClaimOutcome::Holds)),
        fact(&["claims", "undecided"], with(ClaimOutcome::Undecided)),
        fact(&["claims", "do not hold"], with(ClaimOutcome::DoesNotHold)),
        fact(&["claims", "cannot be tested"], with(ClaimOutcome::CannotBeTested)),
    ];
    for analysed in &results.analyses {
        for (name, value) in &analysed.findings.numbers {
            let found = fact(&[&analysed.analysis, &analysed.tracker, name], four_digits(*value));
            // As in claims, a name stands for the first number that has it.
            if facts.iter().all(|known| known.parts != found.parts) {
                facts.push(found);
            }
        }
    }
    facts
}
