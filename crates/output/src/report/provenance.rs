//! Where the numbers of a report come from: files, versions, parameters and digests.

use crate::results::Results;
use crate::results::manifest::MethodRecord;
use crate::table::suites::targets_note;
use trackfail_dataset::synthetic;

/// The protocol of the experiment, and those of methods with another one.
fn protocols(results: &Results) -> String {
    let mut text = results.manifest.protocol.clone();
    let own = results.experiment.methods.iter().filter(|m| m.protocol.name != results.manifest.protocol);
    for method in own {
        text.push_str(&format!("; {} for {}", method.protocol.name, method.name));
    }
    text
}

/// Names and values: first those that are short and concern everyone, last the digests of all sequences.
pub fn provenance(results: &Results) -> Vec<(String, String)> {
    let manifest = &results.manifest;
    let named = |(what, value): (&str, &String)| (what.to_string(), value.clone());
    let (protocols, seed) = (protocols(results), manifest.seed.to_string());
    let head = [
        ("experiment file, SHA-256", &manifest.spec_digest),
        ("protocol", &protocols),
        ("seed", &seed),
        ("trackfail", &manifest.version),
    ];
    let mut all: Vec<(String, String)> = head.into_iter().map(named).collect();
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
    for (k, m) in manifest.methods.iter().enumerate() {
        // A grid is shown by its first point, because all its points would fill pages.
        if manifest.methods[..k].iter().all(|earlier| earlier.name != m.name) {
            all.push((format!("method {}", m.name), method(m)));
        }
    }
    all.extend(manifest.models.iter().map(|(name, text)| (format!("learned by {name}"), text.clone())));
    for (suite, sequences) in &manifest.digests {
        all.extend(sequences.iter().map(|(name, digest)| (format!("{suite}/{name}"), digest.clone())));
    }
    all
}

/// A method with its parameters and what was trained.
fn method(m: &MethodRecord) -> String {
    let part = |(kind, version, params): &(String, u32, serde_json::Value)| {
        format!("{kind} version {version} {params}")
    };
    let mut value = m.signal.as_ref().map_or(String::new(), |s| format!("signal {}; ", part(s)));
    value.push_str(&format!("detector {}", part(&m.detector)));
    if !m.params.is_empty() {
        value.push_str(&format!(" (first of the grid: {})", m.params));
    }
    if let Some((key, suite)) = &m.trained {
        value.push_str(&format!("; `{key}` trained on {suite}"));
        let values: Vec<String> =
            m.thresholds.iter().map(|(tracker, v)| format!("{v} for {tracker}")).collect();
        value.push_str(if values.is_empty() { "" } else { ": " });
        value.push_str(&values.join(", "));
    }
    value
}
