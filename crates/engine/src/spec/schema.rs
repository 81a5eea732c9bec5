//! JSON Schema of experiment files, generated from the types that read them.

use super::extend::KINDS;
use super::figure::{FIGURE_KINDS, FigureKind};
use super::wire;
use schemars::SchemaGenerator;
use serde_json::{Map, Value, json};
use std::sync::LazyLock;
use trackfail_core::plugin::Entry;
use trackfail_methods::analysis::ANALYSES;
use trackfail_methods::detector::DETECTORS;
use trackfail_methods::signal::SIGNALS;
use trackfail_methods::tracker::TRACKERS;

/// Named parts of the schema, referred to as `#/$defs/NAME`.
type Definitions = Map<String, Value>;

/// Schema of complete experiments, with all required keys.
pub(super) static OF_WHOLE_FILES: LazyLock<Value> = LazyLock::new(of_whole_files);

/// Schema of the keys that only shorten a file; none is required.
pub(super) static OF_SHORTCUTS: LazyLock<Value> = LazyLock::new(|| {
    let mut schema = OF_WHOLE_FILES.clone();
    remove(&mut schema, &["required"]);
    schema
});

/// Schema of experiment files, with the parameters of all trackers, signals, detectors and analyses.
pub fn schema() -> Value {
    let mut schema = OF_WHOLE_FILES.clone();
    // A file that extends another gives only what tells its items from others, and what differs.
    for (_, definition, names) in KINDS {
        schema["$defs"][definition]["required"] = json!(names);
    }
    let trackers = json!([{ "required": ["tracker"] }, { "required": ["tracker-group"] }]);
    schema["required"] = json!(["schema", "name"]);
    schema["anyOf"] =
        json!([{ "required": ["extends"] }, { "required": ["title", "suites"], "anyOf": trackers }]);
    schema
}

fn of_whole_files() -> Value {
    let mut generator = SchemaGenerator::default();
    let _ = generator.subschema_for::<wire::Train>();
    let _ = generator.subschema_for::<wire::Shortcuts>();
    let mut root = generator.into_root_schema_for::<wire::Experiment>().to_value();
    let mut definitions = take_definitions(&mut root);
    let shortcuts = definitions.remove("Shortcuts").unwrap_or_default()["properties"].take();
    merge(&mut root["properties"], shortcuts);
    for (name, kinds) in [
        ("Signal", plugins(&mut definitions, "signal", SIGNALS)),
        ("Detector", plugins(&mut definitions, "detector", DETECTORS)),
        ("Compute", plugins(&mut definitions, "analysis", ANALYSES)),
    ] {
        definitions.insert(name.into(), json!({ "anyOf": kinds }));
    }
    let change = "Parameters that a reading changes, of the signal or detector that it is like.";
    let change = json!({ "description": change, "type": "object", "not": { "required": ["kind"] } });
    definitions.insert("Change".into(), change);
    // Trackers have their own keys and the parameters of their kind on one level. A change of the base's tracker gives its
    // label and what differs.
    let own = definitions["Tracker"]["properties"].clone();
    let mut kinds = plugins(&mut definitions, "tracker", TRACKERS);
    kinds.push(json!({ "not": { "required": ["name"] }, "additionalProperties": true }));
    merge(&mut definitions["Tracker"], json!({ "anyOf": kinds, "unevaluatedProperties": false }));
    // The group may give the kind, and a member the parameters, or the other way round.
    let member =
        json!({ "type": "object", "description": "A tracker of a group.", "properties": own.clone() });
    definitions.insert("TrackerMember".into(), member);
    let mut method = definitions["Method"]["properties"].clone();
    remove(&mut method, &["name"]);
    merge(&mut definitions["TrackerGroup"]["properties"], own);
    merge(&mut definitions["MethodGroup"]["properties"], method);
    root["$defs"] = Value::Object(definitions);
    remove_null(&mut root);
    root
}

/// Schema of a method's signals: one signal, or a list.
pub(super) fn signals() -> Value {
    json!([of("Signal"), { "type": "array", "items": of("Signal"), "minItems": 1 }])
}

/// For each kind of figure, the keys that it does not read.
pub(super) fn unread_keys() -> Vec<Value> {
    let rule = |kind: &FigureKind| {
        let unread: Definitions = kind.unread().map(|key| (key.to_string(), json!(false))).collect();
        json!({
            "if": { "required": ["kind"], "properties": { "kind": { "const": kind.word } } },
            "then": { "properties": unread },
        })
    };
    FIGURE_KINDS.iter().map(rule).collect()
}

fn take_definitions(schema: &mut Value) -> Definitions {
    let definitions = schema.as_object_mut().and_then(|object| object.remove("$defs")).unwrap_or_default();
    serde_json::from_value(definitions).unwrap_or_default()
}

/// Removes keys of an object.
pub(super) fn remove(schema: &mut Value, keys: &[&str]) {
    if let Some(object) = schema.as_object_mut() {
        keys.iter().for_each(|key| drop(object.remove(*key)));
    }
}

/// Adds the keys of `more` to an object.
fn merge(schema: &mut Value, more: Value) {
    if let (Some(schema), Value::Object(mut more)) = (schema.as_object_mut(), more) {
        schema.append(&mut more);
    }
}

/// Reference to a definition.
pub(super) fn of(name: &str) -> Value {
    json!({ "$ref": format!("#/$defs/{name}") })
}

/// Adds a definition for each plugin of a list, and returns the references to them.
fn plugins<T: ?Sized>(definitions: &mut Definitions, what: &str, list: &'static [Entry<T>]) -> Vec<Value> {
    let define = |entry: &Entry<T>| {
        let name = format!("{what}-{}", entry.kind);
        let mut schema = (entry.schema)().to_value();
        for (part, mut definition) in take_definitions(&mut schema) {
            rename_references(&mut definition, &name);
            definitions.insert(format!("{name}-{part}"), definition);
        }
        rename_references(&mut schema, &name);
        remove(&mut schema, &["$schema", "title"]);
        schema["description"] = entry.summary.into();
        if schema.get("properties").is_none() {
            schema["properties"] = json!({});
        }
        if what == "detector" {
            schema["properties"].as_object_mut().into_iter().flatten().for_each(|(_, value)| trained(value));
        }
        let key = if what == "tracker" { "name" } else { "kind" };
        schema["properties"][key] = json!({ "const": entry.kind });
        // Parameters may be left to a grid, a group or a base.
        schema["required"] = json!([key]);
        // A tracker has keys of its own beside its parameters.
        if what == "tracker" {
            remove(&mut schema, &["additionalProperties"]);
        }
        definitions.insert(name.clone(), schema);
        of(&name)
    };
    list.iter().map(define).collect()
}

/// Allows a numeric parameter of a detector to be trained.
fn trained(parameter: &mut Value) {
    let types = match &parameter["type"] {
        Value::Array(types) => types.clone(),
        one => vec![one.clone()],
    };
    if !types.contains(&json!("number")) {
        return;
    }
    let description = parameter["description"].take();
    let mut number = parameter.take();
    remove(&mut number, &["description"]);
    *parameter = json!({ "description": description, "anyOf": [number, of("Train")] });
}

/// Changes a plugin's references to those definitions that carry the plugin's name.
fn rename_references(schema: &mut Value, plugin: &str) {
    match schema {
        Value::Object(object) => {
            for (key, value) in object {
                match value.as_str().and_then(|target| target.strip_prefix("#/$defs/")) {
                    Some(part) if key == "$ref" => *value = of(&format!("{plugin}-{part}"))["$ref"].take(),
                    _ => rename_references(value, plugin),
                }
            }
        }
        Value::Array(list) => list.iter_mut().for_each(|value| rename_references(value, plugin)),
        _ => {}
    }
}

/// Removes null from a schema, since TOML has no null.
pub(super) fn remove_null(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            object.retain(|key, value| !(value.is_null() && key != "const"));
            if let Some(types) = object.get_mut("type")
                && let Some(list) = types.as_array_mut()
            {
                list.retain(|word| word != "null");
                if let [one] = list.as_slice() {
                    *types = one.clone();
                }
            }
            if let Some(choices) = object.get_mut("anyOf").and_then(Value::as_array_mut) {
                choices.retain(|choice| choice != &json!({ "type": "null" }));
                if let [Value::Object(one)] = choices.as_mut_slice() {
                    let mut one = std::mem::take(one);
                    object.remove("anyOf");
                    // A parameter's own description says more than that of its type.
                    one.retain(|key, _| !object.contains_key(key));
                    object.append(&mut one);
                }
            }
            object.values_mut().for_each(remove_null);
        }
        Value::Array(list) => list.iter_mut().for_each(remove_null),
        _ => {}
    }
}

#[cfg(test)]
mod tests;
