//! Demands of an experiment: its suites, its variants with their signals, and the tracks that it needs on each suite.

use super::Job;
use crate::spec::method::{Method, SignalChoice, Variant};
use crate::spec::{Experiment, OTHERS, TEST};

/// Tracks of a tracker that are needed on a suite, and the signal that is read from them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Demand<'a> {
    pub suite: &'a str,
    pub tracker: usize,
    pub runs: u32,
    pub signal: Option<usize>,
}

impl Demand<'_> {
    pub fn is_for(&self, suite: &str, job: Job) -> bool {
        self.suite == suite && self.tracker == job.tracker && job.run < self.runs
    }
}

/// All demands of an experiment, without repetitions: the test suite for all trackers, and the suites that
/// methods learn from or analyses read. `of_variants` has the signals of each variant.
pub(super) fn demands<'a>(
    experiment: &'a Experiment,
    signals: &[SignalChoice],
    of_variants: &[Vec<usize>],
) -> Vec<Demand<'a>> {
    let test = experiment.suites[TEST].as_str();
    let mut all: Vec<Demand<'a>> = Vec::new();
    for (tracker, t) in experiment.trackers.iter().enumerate() {
        let mut add = |suite: &'a str, runs: u32, signal: Option<usize>| {
            let demand = Demand { suite, tracker, runs, signal };
            if !all.contains(&demand) {
                all.push(demand);
            }
        };
        add(test, t.runs, None);
        for ((method, variant), signals) in variants(experiment).zip(of_variants) {
            let suite = variant.detector.role().and_then(|role| experiment.suite_of(role));
            let none = signals.is_empty().then_some(None);
            let signals = signals.iter().copied().map(Some).chain(none);
            for signal in signals.filter(|_| method.runs_on(&t.label)) {
                add(test, t.runs, signal);
                if let Some(suite) = suite {
                    add(suite, t.training_runs, signal);
                }
            }
        }
        for analysis in experiment.analyses.iter().filter(|analysis| analysis.runs_on(&t.label)) {
            let signal = analysis.signal.as_ref().and_then(|signal| signal_index(signals, signal));
            for (place, role) in analysis.roles.iter().enumerate() {
                if let Some(suite) = experiment.suites.get(role) {
                    add(suite, analysis.runs(place, t), signal);
                }
            }
        }
    }
    all
}

/// Distinct signals of an experiment, in order of first use.
pub fn distinct_signals(experiment: &Experiment) -> Vec<SignalChoice> {
    let mut distinct: Vec<SignalChoice> = Vec::new();
    let of_methods = variants(experiment).flat_map(|(_, variant)| &variant.signals);
    for choice in of_methods.chain(experiment.analyses.iter().filter_map(|a| a.signal.as_ref())) {
        if signal_index(&distinct, choice).is_none() {
            distinct.push(choice.clone());
        }
    }
    distinct
}

/// Index of a signal among the distinct ones.
pub fn signal_index(distinct: &[SignalChoice], choice: &SignalChoice) -> Option<usize> {
    let is_it = |d: &SignalChoice| {
        d.kind == choice.kind && d.restarts == choice.restarts && d.signal.params() == choice.signal.params()
    };
    distinct.iter().position(is_it)
}

/// All variants of all methods, in the experiment's order.
pub fn variants(experiment: &Experiment) -> impl Iterator<Item = (&Method, &Variant)> {
    experiment.methods.iter().flat_map(|m| m.variants.iter().map(move |v| (m, v)))
}

/// Roles of the suites that an experiment needs: the test suite, training suites, and suites of analyses.
pub fn needed_roles(experiment: &Experiment) -> Vec<&str> {
    let mut roles = vec![TEST];
    let trained = variants(experiment).filter_map(|(_, variant)| variant.detector.role());
    let analysed = experiment.analyses.iter().flat_map(|a| a.roles.iter().map(String::as_str));
    for role in trained.chain(analysed) {
        if role != OTHERS && !roles.contains(&role) {
            roles.push(role);
        }
    }
    roles
}
