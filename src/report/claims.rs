//! What our numbers say of an experiment's claims.

use super::results::Results;
use crate::spec::claim::{Claim, Reference, Verdict};
use crate::table::layout;

/// A claim with what our numbers say of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The conclusion in words.
    pub text: String,
    /// The predicate.
    pub predicate: String,
    /// Whether a run must meet it.
    pub required: bool,
    /// One for each tracker, or a single one for a claim that names its trackers.
    pub tested: Vec<Tested>,
}

/// A claim tested for one tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct Tested {
    /// Tracker; empty for a claim that names its trackers.
    pub tracker: String,
    /// What our numbers say.
    pub verdict: Verdict,
    /// The numbers behind it, as written in the predicate.
    pub numbers: Vec<(String, Option<f64>)>,
}

impl Finding {
    /// Whether it holds for every tracker.
    pub fn holds(&self) -> bool {
        self.tested.iter().all(|t| t.verdict == Verdict::Holds)
    }
}

/// Tests every claim, for each tracker where it names none.
pub fn test(results: &Results) -> Vec<Finding> {
    results.experiment.claims.iter().map(|claim| test_one(results, claim)).collect()
}

fn test_one(results: &Results, claim: &Claim) -> Finding {
    let value = |r: &Reference| {
        layout::lookup(&results.measures, r.tracker.as_deref()?, &r.method, &r.point, r.metric)
    };
    let trackers: Vec<&str> = results.experiment.trackers.iter().map(|t| t.label.as_str()).collect();
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
    Finding {
        text: claim.text.clone(),
        predicate: claim.predicate.clone(),
        required: claim.required,
        tested: tested.collect(),
    }
}
