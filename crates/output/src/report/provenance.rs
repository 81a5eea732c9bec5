//! Where the numbers of a report come from: files, versions, parameters and digests.

use crate::results::Results;
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
    let mut all = vec![
        ("experiment file, SHA-256".to_string(), manifest.spec_digest.clone()),
        ("protocol".to_string(), protocols(results)),
        ("seed".to_string(), manifest.seed.to_string()),
        ("trackfail".to_string(), manifest.version.clone()),
    ];
    for (suite, sequences) in &manifest.digests {
        let mut value = if *suite == manifest.suite.name {
            targets_note(manifest.suite.present.len(), manifest.suite.wanted)
        } else {
            targets_note(sequences.len(), sequences.len())
        };
        if synthetic::is_rendered(suite) {
            value.push_str("; synthetic: rendered by the program, no real video");
        }
        all.push((format!("suite {suite}"), value));
    }
    for t in &manifest.trackers {
        let runs = format!("runs {}, {} to learn from", t.runs, t.training_runs);
        let value = format!("{} version {}, {}, {runs}", t.kind, t.version, t.params);
        all.push((format!("tracker {}", t.label), value));
    }
    // A grid is shown by its first point, because all its points would fill pages.
    let mut named: Vec<&str> = Vec::new();
    for m in &manifest.methods {
        if named.contains(&m.name.as_str()) {
            continue;
        }
        named.push(&m.name);
        let part = |(kind, version, params): &(String, u32, serde_json::Value)| {
            format!("{kind} version {version} {params}")
        };
        let mut value = m.signal.as_ref().map_or(String::new(), |s| format!("signal {}; ", part(s)));
        value.push_str(&format!("detector {}", part(&m.detector)));
        if !m.params.is_empty() {
            value.push_str(&format!(" (first of the grid: {})", m.params));
        }
        if let Some((key, suite)) = &m.trained {
            let values: Vec<String> =
                m.thresholds.iter().map(|(tracker, v)| format!("{v} for {tracker}")).collect();
            value.push_str(&format!("; `{key}` trained on {suite}"));
            if !values.is_empty() {
                value.push_str(&format!(": {}", values.join(", ")));
            }
        }
        all.push((format!("method {}", m.name), value));
    }
    for (name, text) in &manifest.models {
        all.push((format!("learned by {name}"), text.clone()));
    }
    for (suite, sequences) in &manifest.digests {
        for (name, digest) in sequences {
            all.push((format!("{suite}/{name}"), digest.clone()));
        }
    }
    all
}
