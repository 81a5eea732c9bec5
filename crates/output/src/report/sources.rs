//! Origin of a report's numbers, warnings about them, and numbers for the text of a paper.

use super::claims::{ClaimCounts, Finding};
use super::figures::lines::distinct;
use super::sentences::say;
use crate::results::manifest::MethodRecord;
use crate::results::{Manifest, Results, grouped};
use crate::table::macros::Fact;
use crate::table::number::four_digits;
use crate::table::suites::targets_note;
use serde_json::{Value, json};
use trackfail_dataset::synthetic;
use trackfail_methods::detector::fused;

/// Names and values of the origins: short and general ones first, digests of all sequences last.
pub fn provenance(results: &Results) -> Vec<(String, String)> {
    let manifest = &results.manifest;
    let mut protocols = manifest.protocol.clone();
    for method in results.experiment.methods.iter().filter(|m| m.protocol.name != manifest.protocol) {
        protocols.push_str(&format!("; {} for {}", method.protocol.name, method.name));
    }
    let head = [
        ("experiment file, SHA-256", manifest.spec_digest.clone()),
        ("protocol", protocols),
        ("seed", manifest.seed.to_string()),
        ("trackfail", manifest.version.clone()),
    ];
    let mut all: Vec<(String, String)> = head.map(|(what, value)| (what.to_string(), value)).into();
    all.extend(results.beside.iter().map(|beside| ("beside".to_string(), beside.source.clone())));
    for (suite, sequences) in &manifest.digests {
        let (present, wanted) = match *suite == manifest.suite.name {
            true => (manifest.suite.present.len(), manifest.suite.wanted),
            false => (sequences.len(), sequences.len()),
        };
        let rendered = "; synthetic: rendered by the program, no real video";
        let rendered = if synthetic::is_rendered(suite) { rendered } else { "" };
        all.push((format!("suite {suite}"), targets_note(present, wanted) + rendered));
    }
    all.extend(manifest.trackers.iter().map(|t| {
        let runs = format!("runs {}, {} to learn from", t.runs, t.training_runs);
        (format!("tracker {}", t.label), format!("{} version {}, {}, {runs}", t.kind, t.version, t.params))
    }));
    // A grid is shown by its first point, because all its points would fill pages.
    let methods = grouped(&manifest.methods, |m| m.name.as_str());
    all.extend(methods.into_iter().map(|(name, points)| (format!("method {name}"), method(points[0]))));
    all.extend(manifest.models.iter().map(|(name, text)| (format!("learned by {name}"), text.clone())));
    for (suite, sequences) in &manifest.digests {
        all.extend(sequences.iter().map(|(name, digest)| (format!("{suite}/{name}"), digest.clone())));
    }
    all
}

/// A method with its parameters, and what was trained.
fn method(m: &MethodRecord) -> String {
    let part = |(kind, version, params): &(String, u32, Value)| format!("{kind} version {version} {params}");
    let thresholds = m.thresholds.iter().map(|(tracker, v)| format!("{v} for {tracker}"));
    let about = json!({
        "signal": m.signal.as_ref().map(part),
        "detector": part(&m.detector),
        "params": m.params,
        "trained": m.trained,
        "thresholds": thresholds.collect::<Vec<String>>(),
    });
    say("method", about)
}

/// Warnings about methods whose built-in model was learned from sequences that are tested here. Sequences are
/// compared by name, as models contain only names. Rendered sequences are excluded, since they share names
/// with real ones.
pub fn learned_on_test(manifest: &Manifest) -> Vec<String> {
    let present = &manifest.suite.present;
    let tested = |method: &MethodRecord| -> Vec<String> {
        let (kind, _, params) = &method.detector;
        let model = params.get("model").and_then(Value::as_str).filter(|_| *kind == fused::ENTRY.kind);
        let learned = model.and_then(fused::learned_from).unwrap_or_default();
        present.iter().map(|(name, _)| name).filter(|name| learned.contains(name)).cloned().collect()
    };
    let mut groups = grouped(&manifest.methods, tested);
    groups.retain(|(tested, _)| !tested.is_empty() && !synthetic::is_rendered(&manifest.suite.name));
    groups.sort_by(|a, b| a.0.cmp(&b.0));
    let sentence = |(tested, methods): (Vec<String>, Vec<&MethodRecord>)| {
        let names = distinct(methods.iter().map(|method| &method.name));
        say("learned on test", json!({ "methods": names, "tested": tested.len(), "present": present.len() }))
    };
    groups.into_iter().map(sentence).collect()
}

/// Numbers for the text of a paper: of targets, of frames, of claims by outcome (without checks of the
/// arithmetic), and numbers of analyses for each tracker.
pub fn facts(results: &Results, claims: &[Finding]) -> Vec<Fact> {
    let fact =
        |parts: &[&str], shown: String| Fact { parts: parts.iter().map(|p| (*p).into()).collect(), shown };
    let suite = &results.manifest.suite;
    let frames: usize = suite.present.iter().map(|(_, frames)| frames).sum();
    let of_paper: Vec<&Finding> = claims.iter().filter(|c| !c.is_check).collect();
    let counts = ClaimCounts::of(of_paper.iter().map(|c| c.outcome));
    let mut facts = vec![
        fact(&["targets", "present"], suite.present.len().to_string()),
        fact(&["targets", "wanted"], suite.wanted.to_string()),
        fact(&["frames"], frames.to_string()),
        fact(&["claims", "all"], of_paper.len().to_string()),
        fact(&["claims", "hold"], counts.hold.to_string()),
        fact(&["claims", "undecided"], counts.undecided.to_string()),
        fact(&["claims", "do not hold"], counts.do_not_hold.to_string()),
        fact(&["claims", "cannot be tested"], counts.cannot_be_tested.to_string()),
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

#[cfg(test)]
mod tests {
    use super::*;

    const MANIFEST: &str = include_str!("../../../../results/quickstart/manifest.json");

    #[test]
    fn a_model_of_the_program_is_warned_of_on_its_own_sequences() {
        let warnings = |suite: &str, params: Value| {
            let mut manifest: Value = serde_json::from_str(MANIFEST).unwrap();
            manifest["methods"][0]["name"] = "Fused boxes".into();
            manifest["methods"][0]["detector"] = json!(["fused", 2, params]);
            manifest["suite"]["present"] = json!([["Woman", 597], ["Mine", 20]]);
            manifest["suite"]["name"] = suite.into();
            learned_on_test(&serde_json::from_value::<Manifest>(manifest).unwrap())
        };
        let expected = "Fused boxes: the model comes with the program and was learned from sequences named as 1 of the 2 \
                        tested ones. Where these are the same videos, the numbers are too good.";
        assert_eq!(warnings("otb-100", json!({ "model": "boxes" })), [expected]);
        assert!(warnings("synthetic-otb", json!({ "model": "boxes" })).is_empty(), "a rendered suite");
        assert!(warnings("otb-100", json!({ "train": "others" })).is_empty());
    }
}
