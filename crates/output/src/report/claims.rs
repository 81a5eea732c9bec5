//! Tests the claims of an experiment on our numbers.
//!
//! Each claim has two outcomes for each tracker. The outcome of the plain numbers decides if a required claim
//! is met. The outcome with their uncertainty (`judge`) is shown in reports.

mod judge;
mod sampled;

use super::sentences::say;
use crate::results::Results;
use crate::sampling::{LEVEL, Units};
use crate::table::layout::is_anchor;
use crate::table::number::{Style, four_digits};
use judge::{Compared, judge};
use sampled::Samples;
use serde::{Deserialize, Serialize};
use serde_json::json;
use trackfail_engine::spec::Tracker;
use trackfail_engine::spec::claim::{Claim, Quantity};

/// A claim with the outcome of its test, as the page shows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The conclusion in words.
    pub text: String,
    /// The predicate over our numbers; may be empty.
    pub predicate: String,
    /// True if the run fails when the claim does not hold.
    pub required: bool,
    /// True for claims about anchors alone, which check the arithmetic rather than a paper.
    pub is_check: bool,
    /// True if the plain numbers meet the claim for all trackers.
    pub is_met: bool,
    /// The outcome over all trackers.
    pub outcome: ClaimOutcome,
    /// Number of trackers by outcome: `holds for 2, undecided for 1`; empty for a single tracker.
    pub counts: String,
    /// One line for each tracker: the outcome with its numbers, or why the claim cannot be tested.
    pub details: Vec<String>,
    /// Results for all trackers.
    pub tested: Vec<Tested>,
}

/// Result of testing a claim for one tracker.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tested {
    /// Label of the tracker; empty for a claim that names its trackers.
    pub tracker: String,
    /// Outcome with the uncertainty of the numbers.
    pub outcome: ClaimOutcome,
    /// True if the plain numbers meet the claim.
    pub is_met: bool,
    /// True if the claim also fails at the level that is corrected for the number of trackers (Bonferroni).
    pub fails_beyond_chance: bool,
    /// Numbers behind the outcome, one line for each comparison, or why the claim cannot be tested.
    pub lines: Vec<String>,
}

/// Outcome over all trackers. A claim holds if it holds for each of them. It does not hold if it holds for
/// none and fails for one even after correction for the number of trackers. Otherwise it is undecided.
/// Trackers for which it cannot be tested are left out.
fn overall(tested: &[Tested]) -> ClaimOutcome {
    let testable = || tested.iter().filter(|t| t.outcome != ClaimOutcome::CannotBeTested);
    let holds = |t: &Tested| t.outcome == ClaimOutcome::Holds;
    if testable().count() == 0 {
        ClaimOutcome::CannotBeTested
    } else if testable().all(holds) {
        ClaimOutcome::Holds
    } else if !tested.iter().any(holds) && tested.iter().any(|t| t.fails_beyond_chance) {
        ClaimOutcome::DoesNotHold
    } else {
        ClaimOutcome::Undecided
    }
}

/// Tests all claims; a claim that names no tracker is tested for each.
pub fn test(results: &Results, units: &Units) -> Vec<Finding> {
    let samples = Samples::new(results, units);
    results.experiment.claims.iter().map(|claim| test_one(results, &samples, claim)).collect()
}

fn test_one(results: &Results, samples: &Samples<'_>, claim: &Claim) -> Finding {
    let experiment = &results.experiment;
    let references = claim.expression.references();
    // Only trackers of this run, on which every method and analysis of the claim is run.
    let concerns = |t: &&Tracker| {
        let is_own = results.is_own(&t.label);
        is_own
            && references.iter().filter(|r| r.tracker.is_none()).all(|r| match &r.quantity {
                Quantity::Metric(_, method) => {
                    experiment.methods.iter().any(|m| m.name == *method && m.runs_on(&t.label))
                }
                Quantity::Finding(made) => {
                    experiment.analyses.iter().any(|a| a.name == made.analysis && a.runs_on(&t.label))
                }
            })
    };
    let each: Vec<&str> = match references.iter().any(|r| r.tracker.is_none()) {
        true => experiment.trackers.iter().filter(concerns).map(|t| t.label.as_str()).collect(),
        false => vec![""],
    };
    let mut tested: Vec<Tested> =
        each.iter().map(|tracker| test_for(samples, claim, tracker, each.len())).collect();
    if tested.is_empty() {
        let lines = vec!["no tracker has all of its methods".to_string()];
        let (tracker, outcome) = (String::new(), ClaimOutcome::CannotBeTested);
        tested.push(Tested { tracker, outcome, is_met: false, fails_beyond_chance: false, lines });
    }
    let is_of_anchor = |q: &Quantity| matches!(q, Quantity::Metric(_, name) if is_anchor(experiment, name));
    let words = |outcome: ClaimOutcome| {
        let n = tested.iter().filter(|t| t.outcome == outcome).count();
        (tested.len() > 1 && n > 0).then(|| format!("{} for {n}", outcome.words()))
    };
    let words: Vec<String> = ClaimOutcome::ALL.into_iter().filter_map(words).collect();
    let detail = |Tested { tracker, outcome, lines, .. }: &Tested| {
        let who = if tracker.is_empty() { String::new() } else { format!("{tracker}: ") };
        format!("{who}{}: {}", outcome.words(), lines.join("; "))
    };
    Finding {
        text: claim.text.clone(),
        predicate: claim.predicate.clone(),
        required: claim.required,
        is_check: references.iter().all(|r| is_of_anchor(&r.quantity)),
        is_met: tested.iter().all(|t| t.is_met),
        outcome: overall(&tested),
        counts: words.join(", "),
        details: tested.iter().map(detail).collect(),
        tested,
    }
}

/// Tests a claim for one of `trackers` trackers.
fn test_for(samples: &Samples<'_>, claim: &Claim, tracker: &str, trackers: usize) -> Tested {
    let judged = |level| judge(claim, tracker, level, &|r| samples.measured(r));
    let fails = |outcome| outcome == ClaimOutcome::DoesNotHold;
    let corrected = 1.0 - (1.0 - LEVEL) / trackers as f64;
    let (outcome, is_met, lines) = match judged(LEVEL) {
        Ok(found) => {
            let lines = found.compared.iter().map(|c| line(claim, c)).collect();
            (found.outcome, found.is_met, lines)
        }
        Err(reason) => (ClaimOutcome::CannotBeTested, false, vec![reason]),
    };
    let fails_beyond_chance = fails(outcome) && judged(corrected).is_ok_and(|found| fails(found.outcome));
    Tested { tracker: tracker.to_string(), outcome, is_met, fails_beyond_chance, lines }
}

/// Describes a comparison in one line: `recall[DTEF] > recall[RAW]: 0.714 and 0.667, +0.047 (-0.020 to
/// +0.110), undecided`.
fn line(claim: &Claim, c: &Compared) -> String {
    // Whole numbers where all are counts; else three decimals, or four digits of what is small or large.
    let is_count = |q: &Quantity| matches!(q, Quantity::Metric(metric, _) if metric.is_count());
    let references = claim.expression.references();
    let counts = references.iter().all(|r| is_count(&r.quantity));
    let of_analysis = references.iter().any(|r| matches!(r.quantity, Quantity::Finding(_)));
    let shown = |v: f64| match (counts, of_analysis) {
        (true, _) if v == v.trunc() => Style::COUNT.format(v),
        (_, true) => four_digits(v),
        _ => Style::DEFAULT.format(v),
    };
    let signed = |v: f64| {
        let text = shown(v);
        if v > 0.0 && text.bytes().any(|b| (b'1'..=b'9').contains(&b)) { format!("+{text}") } else { text }
    };
    let [a, b] = c.values;
    let interval = match c.bounds {
        _ if c.is_taken_as_is => " (taken as it is, without an interval)".to_string(),
        Some((low, high)) if low == high => String::new(),
        Some((low, high)) => format!(" ({} to {})", signed(low), signed(high)),
        None => " (too few sequences, or samples with a value, for an interval)".to_string(),
    };
    let (left, right, outcome) = (&c.left, &c.right, c.outcome.words());
    format!("{left} {right}: {} and {}, {}{interval}, {outcome}", shown(a), shown(b), signed(a - b))
}

/// Outcome of a page's claims in one sentence, which quotes the first claim; `None` without claims of a
/// paper.
pub fn verdict(claims: &[Finding]) -> Option<String> {
    let of_paper: Vec<&Finding> = claims.iter().filter(|c| !c.is_check).collect();
    let first = of_paper.first()?;
    let words = ClaimCounts::of(of_paper.iter().map(|c| c.outcome)).words();
    let (outcome, text) = (first.outcome.words(), first.text.trim_end_matches('.'));
    let about = json!({ "all": of_paper.len(), "words": words, "outcome": outcome, "text": text });
    Some(say("claims verdict", about))
}

/// Numbers of claims by outcome.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClaimCounts {
    /// Claims that hold.
    pub hold: u64,
    /// Claims that the sequences cannot decide; 0 in summaries before format 2.
    #[serde(default)]
    pub undecided: u64,
    /// Claims that do not hold.
    pub do_not_hold: u64,
    /// Claims whose data or numbers are missing.
    pub cannot_be_tested: u64,
}

impl ClaimCounts {
    /// Counts the outcomes.
    pub fn of(outcomes: impl IntoIterator<Item = ClaimOutcome>) -> Self {
        let all: Vec<ClaimOutcome> = outcomes.into_iter().collect();
        let [hold, undecided, do_not_hold, cannot_be_tested] =
            ClaimOutcome::ALL.map(|outcome| all.iter().filter(|o| **o == outcome).count() as u64);
        Self { hold, undecided, do_not_hold, cannot_be_tested }
    }

    /// Text like `2 hold, 1 undecided, 3 do not hold`, with untestable claims if there are any; empty without
    /// claims.
    pub fn words(self) -> String {
        if self == Self::default() { String::new() } else { say("claims", self) }
    }
}

/// The outcome of a claim; the better ones come first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClaimOutcome {
    /// The claim holds in our numbers.
    Holds,
    /// The sequences cannot decide the claim.
    Undecided,
    /// The claim does not hold in our numbers.
    DoesNotHold,
    /// Data or numbers are missing.
    CannotBeTested,
}

impl ClaimOutcome {
    /// All outcomes, in the order of reports.
    pub const ALL: [Self; 4] = [Self::Holds, Self::Undecided, Self::DoesNotHold, Self::CannotBeTested];

    /// The outcome in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Undecided => "undecided",
            Self::DoesNotHold => "does not hold",
            Self::CannotBeTested => "cannot be tested",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_tracker_of_many_decides_only_beyond_chance() {
        let overall = |outcomes: &[(ClaimOutcome, bool)]| {
            let tested = |&(outcome, fails_beyond_chance): &(ClaimOutcome, bool)| {
                let (tracker, lines) = (String::new(), Vec::new());
                Tested { tracker, outcome, is_met: false, fails_beyond_chance, lines }
            };
            overall(&outcomes.iter().map(tested).collect::<Vec<_>>())
        };
        let (holds, open) = ((ClaimOutcome::Holds, false), (ClaimOutcome::Undecided, false));
        let (untestable, fails) = ((ClaimOutcome::CannotBeTested, false), ClaimOutcome::DoesNotHold);
        assert_eq!(overall(&[holds, holds]), ClaimOutcome::Holds);
        assert_eq!(overall(&[open, (fails, true)]), ClaimOutcome::DoesNotHold);
        assert_eq!(overall(&[open, (fails, false)]), ClaimOutcome::Undecided);
        assert_eq!(overall(&[holds, (fails, true)]), ClaimOutcome::Undecided);
        assert_eq!(overall(&[untestable, (fails, true)]), ClaimOutcome::DoesNotHold);
        assert_eq!(overall(&[untestable]), ClaimOutcome::CannotBeTested);
    }
}
