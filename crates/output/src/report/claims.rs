//! Tests the claims of an experiment on our numbers.

use crate::engine::execute::analyse::Analysed;
use crate::results::Results;
use crate::spec::Tracker;
use crate::spec::claim::{Claim, ClaimVerdict, Quantity, Reference};
use crate::table::layout;
use serde::Serialize;

/// A claim, tested on our numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The conclusion in words.
    pub text: String,
    /// The predicate.
    pub predicate: String,
    /// Whether the run fails where it does not hold.
    pub required: bool,
    /// One for each tracker, or a single one for a claim that names its trackers.
    pub tested: Vec<Tested>,
}

/// A claim tested for one tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct Tested {
    /// Tracker; empty for a claim that names its trackers.
    pub tracker: String,
    /// The verdict of our numbers.
    pub verdict: ClaimVerdict,
    /// The numbers behind it, as written in the predicate.
    pub numbers: Vec<(String, Option<f64>)>,
}

impl Finding {
    /// Whether it holds for every tracker.
    pub fn holds(&self) -> bool {
        self.tested.iter().all(|t| t.verdict == ClaimVerdict::Holds)
    }

    /// The outcome over all trackers: the claim does not hold where it fails for one of them.
    pub fn overall(&self) -> ClaimOutcome {
        let fails = self.tested.iter().any(|t| t.verdict == ClaimVerdict::Fails);
        match (fails, self.holds()) {
            (true, _) => ClaimOutcome::DoesNotHold,
            (false, true) => ClaimOutcome::Holds,
            (false, false) => ClaimOutcome::CannotBeTested,
        }
    }
}

/// Tests every claim, for each tracker where it names none.
pub fn test(results: &Results) -> Vec<Finding> {
    results.experiment.claims.iter().map(|claim| test_one(results, claim)).collect()
}

fn test_one(results: &Results, claim: &Claim) -> Finding {
    let value = |r: &Reference| {
        let tracker = r.tracker.as_deref()?;
        match &r.quantity {
            Quantity::Metric(metric, method) => {
                layout::lookup(&results.measures, tracker, method, &r.point, *metric)
            }
            Quantity::Finding(made) => {
                let mine = |a: &&Analysed| a.analysis == made.analysis && a.tracker == tracker;
                results.analyses.iter().find(mine)?.findings.number(&made.part)
            }
        }
    };
    // Only trackers on which every method and analysis of the claim is run.
    let concerns = |t: &&Tracker| {
        claim.references().iter().all(|r| match &r.quantity {
            Quantity::Metric(_, method) => {
                results.experiment.methods.iter().any(|m| m.name == *method && m.runs_on(&t.label))
            }
            Quantity::Finding(made) => {
                results.experiment.analyses.iter().any(|a| a.name == made.analysis && a.runs_on(&t.label))
            }
        })
    };
    let trackers = results.experiment.trackers.iter().filter(concerns);
    let trackers: Vec<&str> = trackers.map(|t| t.label.as_str()).collect();
    let each: Vec<&str> = if claim.is_per_tracker() { trackers } else { vec![""] };
    let tested = each.iter().map(|tracker| {
        let numbers = claim.references().into_iter().map(|r| {
            let mut bound = r.clone();
            bound.tracker.get_or_insert_with(|| tracker.to_string());
            (r.to_string(), value(&bound))
        });
        let (tracker, verdict) = (tracker.to_string(), claim.test(tracker, &value));
        Tested { tracker, verdict, numbers: numbers.collect() }
    });
    let mut tested: Vec<Tested> = tested.collect();
    if tested.is_empty() {
        let verdict = ClaimVerdict::Untestable("no tracker has all of its methods".to_string());
        tested.push(Tested { tracker: String::new(), verdict, numbers: Vec::new() });
    }
    Finding { text: claim.text.clone(), predicate: claim.predicate.clone(), required: claim.required, tested }
}

/// A verdict in words.
pub fn verdict_words(verdict: &ClaimVerdict) -> &'static str {
    outcome(verdict).words()
}

fn outcome(verdict: &ClaimVerdict) -> ClaimOutcome {
    match verdict {
        ClaimVerdict::Holds => ClaimOutcome::Holds,
        ClaimVerdict::Fails => ClaimOutcome::DoesNotHold,
        ClaimVerdict::Untestable(_) => ClaimOutcome::CannotBeTested,
    }
}

/// A claim as the page shows it.
pub fn view(finding: &Finding) -> ClaimView {
    let holds = finding.tested.iter().filter(|t| t.verdict == ClaimVerdict::Holds).count();
    let verdict = finding.overall();
    let headline = if finding.tested.len() > 1 {
        format!("holds for {holds} of {} trackers", finding.tested.len())
    } else {
        verdict.words().to_string()
    };
    let detail = |Tested { tracker, verdict, numbers }: &Tested| {
        let shown = match verdict {
            ClaimVerdict::Untestable(reason) => reason.clone(),
            _ => {
                let numbers = numbers.iter().map(|(name, value)| match value {
                    Some(v) => format!("{name} = {v:.4}"),
                    None => format!("{name} has no value"),
                });
                numbers.collect::<Vec<_>>().join(", ")
            }
        };
        let who = if tracker.is_empty() { String::new() } else { format!("{tracker}: ") };
        format!("{who}{}: {shown}", outcome(verdict).words())
    };
    ClaimView {
        text: finding.text.clone(),
        verdict,
        headline,
        predicate: finding.predicate.clone(),
        details: finding.tested.iter().map(detail).collect(),
    }
}

/// A claim as the page shows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClaimView {
    /// The statement.
    pub text: String,
    /// The outcome over all trackers.
    pub verdict: ClaimOutcome,
    /// The outcome in words: `holds for 2 of 4 trackers`.
    pub headline: String,
    /// The predicate over our numbers; may be empty.
    pub predicate: String,
    /// One line for each tracker: the verdict and the numbers behind it.
    pub details: Vec<String>,
}

/// The outcome of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClaimOutcome {
    /// It holds in our numbers.
    Holds,
    /// It does not.
    DoesNotHold,
    /// Data or numbers are missing.
    CannotBeTested,
}

impl ClaimOutcome {
    /// The outcome in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::DoesNotHold => "does not hold",
            Self::CannotBeTested => "cannot be tested",
        }
    }
}
