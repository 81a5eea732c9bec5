//! Whether kept results can stand beside those of an experiment.
//!
//! Kinds, versions and runs of results are those of their manifest. Their parameters are those of their experiment file as
//! this version reads it: parameters that exist no more, which did not move the numbers, make no difference.

use super::{MARK, Taken};
use crate::results::manifest::{self, Manifest, MethodRecord};
use crate::results::{Results, ResultsError};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use trackfail_engine::spec::method::{Candidates, Method, Training, Variant};
use trackfail_engine::spec::{Experiment, FoldsBy, OTHERS, TEST};

/// Name of something that must be the same, its value in the experiment, and its value in the kept results.
type Fact = (String, String, String);
/// Kind, version and parameters.
type Plugin = (String, u32, Value);
/// Names and digests of sequences, by suite.
type Digests = BTreeMap<String, Vec<(String, String)>>;

/// Checks that kept results can stand beside those of an experiment, whose suites have these `digests`. `run` is its manifest
/// once it was run, which another version may have done.
///
/// # Errors
/// Everything in which the two differ, with what each of them has; of a suite that methods learn from, the first sequence.
pub fn check(
    experiment: &Experiment,
    run: Option<&Manifest>,
    digests: &Digests,
    kept: &Results,
) -> Result<(), ResultsError> {
    let there = &kept.manifest;
    let taken = Taken::of(experiment, &kept.experiment);
    let protocol = experiment.protocol.map_or("", |protocol| protocol.name).to_string();
    let mut facts = vec![
        ("the protocol".to_string(), protocol, there.protocol.clone()),
        ("the seed".to_string(), experiment.seed.to_string(), there.seed.to_string()),
        ("the suite".to_string(), experiment.suites[TEST].clone(), there.suite.name.clone()),
    ];
    let own = by_name(digests, &experiment.suites[TEST]);
    let known = by_name(&there.digests, &there.suite.name);
    // A sequence that cannot be read fails by itself.
    for (name, digest) in own.iter().filter(|(_, digest)| !digest.is_empty()) {
        if let Some(kept) = known.get(name) {
            facts.push((format!("sequence {name}"), (*digest).clone(), (*kept).clone()));
        }
    }
    facts.extend(of_trackers(experiment, run, kept));
    let common = taken.iter().filter(|taken| !taken.marks_methods).flat_map(|taken| &taken.methods);
    let common: Vec<&String> = common.collect();
    facts.extend(common.iter().flat_map(|name| of_method(name, experiment, run, kept)));
    let suites = learned_from(experiment, &common).into_iter();
    facts.extend(suites.filter_map(|suite| of_learned(suite, digests, &there.digests)));
    let differ = facts.into_iter().filter(differs);
    let mut differences: Vec<String> =
        differ.map(|(what, own, kept)| format!("{what} is {own} here and {kept} there")).collect();
    if !own.keys().any(|name| known.contains_key(name)) {
        differences.push("they have no sequence in common".to_string());
    }
    if taken.is_none() {
        differences.push("they have no tracker and no method in common".to_string());
    }
    let labels = experiment.trackers.iter().map(|tracker| &tracker.label);
    let names = experiment.methods.iter().map(|method| &method.name).chain(labels);
    let clash = names.filter(|name| name.ends_with(MARK));
    differences.extend(clash.map(|name| format!("the name `{name}` is that of a kept one")));
    if differences.is_empty() {
        return Ok(());
    }
    let (own, kept, differences) = (&experiment.name, &there.experiment, differences.join("; "));
    Err(ResultsError::Unfit(format!("{own} cannot stand beside {kept}: {differences}")))
}

fn differs((_, own, kept): &Fact) -> bool {
    own != kept
}

/// Digests of the sequences of a suite.
fn by_name<'d>(digests: &'d Digests, suite: &str) -> BTreeMap<&'d String, &'d String> {
    digests.get(suite).into_iter().flatten().map(|of| (&of.0, &of.1)).collect()
}

/// The suites that methods of these names learn from, but for others of the test suite.
fn learned_from<'e>(experiment: &'e Experiment, names: &[&String]) -> BTreeSet<&'e String> {
    let methods = experiment.methods.iter().filter(|method| names.contains(&&method.name));
    let roles = methods.flat_map(|method| &method.variants).filter_map(|variant| variant.detector.role());
    roles.filter(|role| *role != OTHERS).filter_map(|role| experiment.suite_of(role)).collect()
}

/// The first sequence of a suite that methods learn from that has other data, or that one of the two does not have.
fn of_learned(suite: &str, own: &Digests, kept: &Digests) -> Option<Fact> {
    let (own, kept) = (by_name(own, suite), by_name(kept, suite));
    let word = |digest: Option<&&String>| digest.map_or("absent", |digest| digest.as_str()).to_string();
    let names = own.keys().chain(kept.keys());
    let facts = names.map(|name| (name, word(own.get(name)), word(kept.get(name))));
    let mut facts = facts.map(|(name, own, kept)| (format!("sequence {name} of {suite}"), own, kept));
    facts.find(differs)
}

fn words((kind, version, params): &Plugin) -> String {
    format!("{kind} version {version} {params}")
}

/// Parameters of results as they are `read` now. What a program tells of itself, which `own` has too, is in the manifest
/// alone, as it was `written`.
fn as_run(mut read: Value, written: &Value, own: &Value) -> Value {
    let told = written.as_object().into_iter().flatten().filter(|(key, _)| own.get(key.as_str()).is_some());
    if let Some(read) = read.as_object_mut() {
        for (key, value) in told {
            read.entry(key).or_insert_with(|| value.clone());
        }
    }
    read
}

/// The trackers of one label.
fn of_trackers(experiment: &Experiment, run: Option<&Manifest>, kept: &Results) -> Vec<Fact> {
    let with_runs = |plugin: &Plugin, runs: u32| format!("{}, {}", words(plugin), manifest::runs(runs));
    let mut facts = Vec::new();
    for own in &experiment.trackers {
        let record = kept.manifest.trackers.iter().find(|record| record.label == own.label);
        let read = kept.experiment.trackers.iter().find(|tracker| tracker.label == own.label);
        let Some((record, read)) = record.zip(read) else { continue };
        let run = run.and_then(|run| run.trackers.iter().find(|record| record.label == own.label));
        let (version, runs) = run.map_or((own.version, own.runs), |run| (run.version, run.runs));
        let plugin = (own.kind.to_string(), version, own.setup.params());
        let params = as_run(read.setup.params(), &record.params, &plugin.2);
        let kept = (record.kind.clone(), record.version, params);
        let what = format!("tracker {}", own.label);
        facts.push((what, with_runs(&plugin, runs), with_runs(&kept, record.runs)));
    }
    facts
}

/// Everything of the methods of one name that their numbers depend on: of the points of a grid, the first at which they differ.
fn of_method(name: &str, experiment: &Experiment, run: Option<&Manifest>, kept: &Results) -> Vec<Fact> {
    let named = |method: &&Method| method.name == name;
    let own = experiment.methods.iter().find(named);
    let Some((own, there)) = own.zip(kept.experiment.methods.iter().find(named)) else { return Vec::new() };
    let points = |method: &Method| method.variants.iter().map(Variant::params).collect::<Vec<_>>().join(", ");
    let fact = |what: &str, own: String, kept: String| (format!("{what} of method {name}"), own, kept);
    let mut facts = vec![
        fact("the protocol", own.protocol.name.to_string(), there.protocol.name.to_string()),
        fact("the grid", points(own), points(there)),
    ];
    let at_point = |(own, there): (&Variant, &Variant)| {
        let record = run.and_then(|run| record_of(run, name, own));
        let run_here = plugins(own, record, &[]);
        let run_there = plugins(there, record_of(&kept.manifest, name, there), &run_here);
        let signals = |all: &[Plugin]| all[1..].iter().map(words).collect::<Vec<_>>().join(" and ");
        [
            fact("the signal", signals(&run_here), signals(&run_there)),
            fact("the detector", words(&run_here[0]), words(&run_there[0])),
            fact("the training", training(own, experiment), training(there, &kept.experiment)),
        ]
    };
    let both = own.variants.iter().zip(&there.variants);
    facts.extend(both.map(at_point).find(|facts| facts.iter().any(differs)).into_iter().flatten());
    facts
}

fn record_of<'m>(manifest: &'m Manifest, method: &str, variant: &Variant) -> Option<&'m MethodRecord> {
    let params = variant.params();
    manifest.methods.iter().find(|record| record.name == method && record.params == params)
}

/// The detector of a variant and then its signals, [as they were run](as_run), beside those of `own`.
fn plugins(variant: &Variant, record: Option<&MethodRecord>, own: &[Plugin]) -> Vec<Plugin> {
    let fixed = &variant.detector.example;
    let mut all = vec![(fixed.kind.to_string(), fixed.version, fixed.detector.params())];
    all.extend(variant.signals.iter().map(|s| (s.kind.to_string(), s.version, s.signal.params())));
    // The manifest has the first signal alone.
    let recorded = [record.map(|record| &record.detector), record.and_then(|record| record.signal.as_ref())];
    for (k, (plugin, recorded)) in all.iter_mut().zip(recorded).enumerate() {
        let Some((kind, version, written)) = recorded else { continue };
        let params = own.get(k).map_or(&Value::Null, |own| &own.2);
        *plugin = (kind.clone(), *version, as_run(plugin.2.clone(), written, params));
    }
    all
}

/// Training of a variant in words: the parameter or model, the suite, and the choice among candidates.
fn training(variant: &Variant, experiment: &Experiment) -> String {
    let Some(role) = variant.detector.role() else { return "none".to_string() };
    let suite = experiment.suite_of(role).map_or(role, String::as_str);
    let suite = match (role, experiment.folds) {
        (OTHERS, FoldsBy::Video) => format!("others of {suite} by video"),
        (OTHERS, FoldsBy::Source) => format!("others of {suite} by source"),
        _ => suite.to_string(),
    };
    let Some(Training { key, maximise, candidates, .. }) = &variant.detector.training else {
        return format!("a model of {suite}");
    };
    let candidates = match candidates {
        Candidates::Listed(list) => {
            list.iter().map(|(value, _)| value.to_string()).collect::<Vec<_>>().join(", ")
        }
        Candidates::Quantiles { count, .. } => format!("{count} quantiles"),
    };
    format!("`{key}` on {suite}, by {} among {candidates}", maximise.name())
}
