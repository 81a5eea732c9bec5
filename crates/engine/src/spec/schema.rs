//! The JSON Schema of experiment files, generated from the types that read them.

use super::wire;
use crate::plugin::Entry;
use serde_json::{Value, json};

/// The schema, with the parameters of every tracker, signal, detector and analysis.
pub fn schema() -> Value {
    let mut root = schemars::schema_for!(wire::Experiment).to_value();
    let signals = plugins("kind", crate::signal::SIGNALS);
    let detectors = plugins("kind", crate::detector::DETECTORS);
    let analyses = plugins("kind", crate::analysis::ANALYSES);
    let trackers = plugins("name", crate::tracker::TRACKERS);
    if let Some(definitions) = root.get_mut("$defs").and_then(Value::as_object_mut) {
        definitions.insert("Signal".into(), signals);
        definitions.insert("Detector".into(), detectors);
        if let Some(method) = definitions.get_mut("Method").and_then(|m| m.get_mut("properties")) {
            method["signal"] = json!({ "$ref": "#/$defs/Signal" });
            method["detector"] = json!({ "$ref": "#/$defs/Detector" });
        }
        definitions.insert("Compute".into(), analyses);
        if let Some(analysis) = definitions.get_mut("Analysis").and_then(|a| a.get_mut("properties")) {
            analysis["signal"] = json!({ "$ref": "#/$defs/Signal" });
            analysis["compute"] = json!({ "$ref": "#/$defs/Compute" });
        }
        if let Some(tracker) = definitions.get_mut("Tracker").and_then(Value::as_object_mut) {
            tracker.insert("anyOf".into(), trackers["anyOf"].clone());
        }
    }
    root
}

/// One alternative a kind: its parameters, and the word that chooses it.
fn plugins<T: ?Sized>(key: &str, list: &'static [Entry<T>]) -> Value {
    let alternatives: Vec<Value> = list
        .iter()
        .map(|entry| {
            let mut schema = (entry.schema)().to_value();
            if let Some(object) = schema.as_object_mut() {
                object.remove("$schema");
                object.remove("title");
                object.insert("description".into(), entry.summary.into());
                // Trackers have keys of their own beside the parameters, and any number of a detector
                // may be a table that says how to train it; the program itself is stricter.
                object.remove("additionalProperties");
                object.remove("required");
                let properties = object.entry("properties").or_insert_with(|| json!({}));
                properties[key] = json!({ "const": entry.kind });
                object.insert("required".into(), json!([key]));
            }
            schema
        })
        .collect();
    json!({ "anyOf": alternatives })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `UPDATE=1 cargo test` writes the file anew.
    #[test]
    fn the_committed_schema_is_the_generated_one() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/schema.json");
        let generated = serde_json::to_string_pretty(&schema()).unwrap() + "\n";
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(path, &generated).unwrap();
        }
        let committed = std::fs::read_to_string(path).unwrap_or_default();
        assert_eq!(committed, generated, "experiments/schema.json is old; run UPDATE=1 cargo test schema");
    }
}
