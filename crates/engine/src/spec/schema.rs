//! The JSON Schema of experiment files, generated from the types that read them.

use super::figure::FIGURE_KINDS;
use super::wire;
use crate::plugin::Entry;
use serde_json::{Value, json};

/// The schema, with the parameters of every tracker, signal, detector and analysis.
pub fn schema() -> Value {
    let mut root = schemars::schema_for!(wire::Experiment).to_value();
    add_shortcuts(&mut root);
    let signals = plugins("kind", crate::signal::SIGNALS);
    let detectors = plugins("kind", crate::detector::DETECTORS);
    let analyses = plugins("kind", crate::analysis::ANALYSES);
    let trackers = plugins("name", crate::tracker::TRACKERS);
    if let Some(definitions) = root.get_mut("$defs").and_then(Value::as_object_mut) {
        definitions.insert("Signal".into(), signals);
        definitions.insert("Detector".into(), detectors);
        if let Some(method) = definitions.get_mut("Method").and_then(|m| m.get_mut("properties")) {
            let one = json!({ "$ref": "#/$defs/Signal" });
            method["signal"] = json!({ "anyOf": [one, { "type": "array", "items": one }] });
            method["detector"] = json!({ "$ref": "#/$defs/Detector" });
        }
        definitions.insert("Compute".into(), analyses);
        if let Some(analysis) = definitions.get_mut("Analysis").and_then(|a| a.get_mut("properties")) {
            analysis["signal"] = json!({ "$ref": "#/$defs/Signal" });
            analysis["compute"] = json!({ "$ref": "#/$defs/Compute" });
        }
        if let Some(tracker) = definitions.get_mut("Tracker").and_then(Value::as_object_mut) {
            let mut kinds = trackers["anyOf"].clone();
            if let Some(kinds) = kinds.as_array_mut() {
                // A change of the base's tracker gives only its label.
                kinds.push(json!({ "not": { "required": ["name"] } }));
            }
            tracker.insert("anyOf".into(), kinds);
        }
    }
    describe_figure_kinds(&mut root);
    root
}

/// Writes the list of figure kinds below the key that takes one.
fn describe_figure_kinds(root: &mut Value) {
    let kinds: Vec<String> =
        FIGURE_KINDS.iter().map(|kind| format!("`{}` ({})", kind.word, kind.summary)).collect();
    root["$defs"]["Figure"]["properties"]["kind"]["description"] = json!(format!("{}.", kinds.join("; ")));
}

/// Keys of an item that tell it from the others; an experiment that extends another gives only these and what differs.
const NAMES: [(&str, &[&str]); 7] = [
    ("Tracker", &[]),
    ("Method", &["name"]),
    ("Analysis", &["name"]),
    ("Table", &["name"]),
    ("Figure", &["name"]),
    ("Published", &["table", "tracker", "row"]),
    ("Claim", &["text"]),
];

/// Adds the keys that make a file shorter, and requires of it only what every file must have.
fn add_shortcuts(root: &mut Value) {
    let mut shortcuts = schemars::schema_for!(wire::Shortcuts).to_value();
    for part in ["properties", "$defs"] {
        if let (Some(known), Some(more)) = (
            root.get_mut(part).and_then(Value::as_object_mut),
            shortcuts.get_mut(part).and_then(Value::as_object_mut),
        ) {
            known.append(more);
        }
    }
    root["required"] = json!(["schema", "name"]);
    root["anyOf"] = json!([{ "required": ["extends"] }, { "required": ["title", "suites"] }]);
    for (definition, required) in NAMES {
        root["$defs"][definition]["required"] = json!(required);
    }
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
