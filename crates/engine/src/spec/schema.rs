//! The JSON Schema of experiment files, generated from the types that read them.

use super::figure::{FIGURE_KINDS, FigureKey};
use super::limits::{LISTS, MAX_PARTS};
use super::method::can_be_maximised;
use super::read::{MAX_RUNS, SCHEMA};
use super::wire;
use serde_json::{Map, Value, json};
use std::sync::LazyLock;
use trackfail_core::plugin::Entry;
use trackfail_methods::score::{Metric, PROTOCOLS};
use trackfail_methods::tracker::protocol::RunProtocol;

/// Named parts of the schema, which others refer to as `#/$defs/NAME`.
type Definitions = Map<String, Value>;

/// The schema of experiments that need no other file, which have all that an experiment must have.
pub(super) static OF_WHOLE_FILES: LazyLock<Value> = LazyLock::new(|| describe(true));

/// The schema, with the parameters of every tracker, signal, detector and analysis.
pub fn schema() -> Value {
    describe(false)
}

/// The schema of all files, or of those alone that need no other.
fn describe(whole: bool) -> Value {
    let mut root = schemars::schema_for!(wire::Experiment).to_value();
    let mut definitions = take_definitions(&mut root);
    add_shortcuts(&mut root, &mut definitions);
    if !whole {
        require_what_differs(&mut root, &mut definitions);
    }
    let mut train = schemars::schema_for!(wire::Train).to_value();
    definitions.append(&mut take_definitions(&mut train));
    remove(&mut train, &["$schema", "title"]);
    definitions.insert("Train".into(), train);
    let signals = plugins(&mut definitions, "signal", trackfail_methods::signal::SIGNALS);
    let detectors = plugins(&mut definitions, "detector", trackfail_methods::detector::DETECTORS);
    let analyses = plugins(&mut definitions, "analysis", trackfail_methods::analysis::ANALYSES);
    let trackers = plugins(&mut definitions, "tracker", trackfail_methods::tracker::TRACKERS);
    definitions.insert("Signal".into(), signals);
    definitions.insert("Detector".into(), detectors);
    definitions.insert("Compute".into(), analyses);
    definitions.insert(
        "Change".into(),
        json!({
            "description": "Parameters that a reading changes, of the signal or detector that it is like.",
            "type": "object",
            "not": { "required": ["kind"] },
        }),
    );
    let analysis = &mut definitions["Analysis"]["properties"];
    analysis["signal"] = json!({ "$ref": "#/$defs/Signal" });
    analysis["compute"] = json!({ "$ref": "#/$defs/Compute" });
    describe_methods(&mut definitions);
    describe_trackers(&mut definitions, trackers);
    describe_figures(&mut definitions["Figure"]);
    describe_words(&mut root, &mut definitions);
    describe_limits(&mut root, &mut definitions);
    root["$defs"] = Value::Object(definitions);
    remove_null(&mut root);
    root
}

fn take_definitions(schema: &mut Value) -> Definitions {
    match schema.as_object_mut().and_then(|object| object.remove("$defs")) {
        Some(Value::Object(definitions)) => definitions,
        _ => Definitions::new(),
    }
}

fn remove(schema: &mut Value, keys: &[&str]) {
    if let Some(object) = schema.as_object_mut() {
        keys.iter().for_each(|key| drop(object.remove(*key)));
    }
}

/// One reference.
fn of(name: &str) -> Value {
    json!({ "$ref": format!("#/$defs/{name}") })
}

/// Signals and detectors of methods, and the keys that a group of methods shares.
fn describe_methods(definitions: &mut Definitions) {
    let whole = json!({ "anyOf": [of("Signal"), { "type": "array", "items": of("Signal"), "minItems": 1 }] });
    let changed = json!({ "anyOf": [of("Signal"), whole["anyOf"][1], of("Change")] });
    let method = &mut definitions["Method"];
    method["properties"]["signal"]["anyOf"] = changed["anyOf"].clone();
    method["properties"]["detector"]["anyOf"] = json!([of("Detector"), of("Change")]);
    method["properties"]["grid"]["additionalProperties"] =
        json!({ "type": "array", "items": { "type": "number" }, "minItems": 1 });
    for key in ["signal", "detector"] {
        remove(&mut method["properties"][key], &["type", "additionalProperties"]);
    }
    // Only what is like another method can leave `kind` to that one.
    method["if"] = json!({ "not": { "required": ["like"] } });
    method["then"] = json!({ "properties": { "signal": whole, "detector": of("Detector") } });
    let shared = method["properties"].clone();
    let group = &mut definitions["MethodGroup"];
    for (key, value) in shared.as_object().into_iter().flatten().filter(|(key, _)| *key != "name") {
        group["properties"][key] = value.clone();
    }
    group["additionalProperties"] = json!(false);
    let members =
        json!({ "type": "array", "minItems": 1, "items": { "anyOf": [{ "type": "string" }, of("Method")] } });
    merge(&mut group["properties"]["methods"], members);
}

/// Trackers have their own keys and the parameters of their kind on one level.
fn describe_trackers(definitions: &mut Definitions, kinds: Value) {
    let mut kinds = kinds["anyOf"].clone();
    let names: Vec<&str> = trackfail_methods::tracker::TRACKERS.iter().map(|entry| entry.kind).collect();
    let tracker = &mut definitions["Tracker"];
    tracker["properties"]["name"]["enum"] = json!(names);
    let own = tracker["properties"].clone();
    if let Some(kinds) = kinds.as_array_mut() {
        // A change of the base's tracker gives its label and what differs.
        kinds.push(json!({ "not": { "required": ["name"] }, "additionalProperties": true }));
    }
    tracker["anyOf"] = kinds;
    tracker["unevaluatedProperties"] = json!(false);
    // The group may give the kind, and a member the parameters, or the other way round.
    let member = json!({ "type": "object", "description": "A tracker of a group.", "properties": own });
    definitions.insert("TrackerMember".into(), member);
    let members = json!({ "type": "array", "minItems": 1, "items": { "anyOf": [{ "type": "string" }, of("TrackerMember")] } });
    let group = &mut definitions["TrackerGroup"];
    for (key, value) in own.as_object().into_iter().flatten() {
        group["properties"][key] = value.clone();
    }
    merge(&mut group["properties"]["trackers"], members);
}

/// Sets keys of an object.
fn merge(schema: &mut Value, more: Value) {
    if let (Some(schema), Value::Object(mut more)) = (schema.as_object_mut(), more) {
        schema.append(&mut more);
    }
}

/// Figures: the kinds, and for each kind the keys that it does not read.
fn describe_figures(figure: &mut Value) {
    let kinds: Vec<String> =
        FIGURE_KINDS.iter().map(|kind| format!("`{}` ({})", kind.word, kind.summary)).collect();
    let words: Vec<&str> = FIGURE_KINDS.iter().map(|kind| kind.word).collect();
    figure["properties"]["kind"]["description"] = json!(format!("{}.", kinds.join("; ")));
    figure["properties"]["kind"]["enum"] = json!(words);
    let rules = FIGURE_KINDS.iter().map(|kind| {
        let unread = FigureKey::ALL.iter().filter(|key| !kind.reads_word(key.word()));
        let unread: Definitions = unread.map(|key| (key.word().to_string(), json!(false))).collect();
        json!({
            "if": { "required": ["kind"], "properties": { "kind": { "const": kind.word } } },
            "then": { "properties": unread },
        })
    });
    figure["allOf"] = rules.collect();
}

/// The closed lists of words, and the ranges of numbers, that the types do not say.
fn describe_words(root: &mut Value, definitions: &mut Definitions) {
    let protocols: Vec<&str> = PROTOCOLS.iter().map(|protocol| protocol.name).collect();
    let metrics: Vec<&str> = Metric::names().collect();
    let best: Vec<&str> =
        Metric::names().filter(|n| Metric::from_name(n).as_ref().is_some_and(can_be_maximised)).collect();
    root["properties"]["schema"] = json!({ "description": "Version of this format.", "const": SCHEMA });
    root["properties"]["name"]["pattern"] = json!("^[a-z0-9_-]{1,64}(/[a-z0-9_-]{1,64})*$");
    root["properties"]["protocol"]["enum"] = json!(protocols);
    root["properties"]["suites"]["additionalProperties"]["type"] = json!("string");
    for part in ["Method", "MethodGroup"] {
        definitions[part]["properties"]["protocol"]["enum"] = json!(protocols);
    }
    for part in ["Tracker", "TrackerGroup", "TrackerMember"] {
        let keys = &mut definitions[part]["properties"];
        keys["protocol"]["enum"] = RunProtocol::ALL.iter().map(|protocol| protocol.name()).collect();
        for key in ["runs", "training_runs"] {
            merge(&mut keys[key], json!({ "minimum": 1, "maximum": MAX_RUNS }));
        }
    }
    definitions["Train"]["properties"]["maximise"]["enum"] = json!(best);
    definitions["Table"]["properties"]["rank"]["enum"] = json!(metrics);
    definitions["Table"]["properties"]["metric"]["enum"] = json!(metrics);
    definitions["Figure"]["properties"]["metric"]["enum"] = json!(metrics);
    definitions["Grid"]["oneOf"] = json!([
        { "required": ["from", "to", "step"], "properties": { "values": false, "quantiles": false } },
        { "required": ["values"], "properties": { "from": false, "to": false, "step": false, "quantiles": false } },
        { "required": ["quantiles"], "properties": { "from": false, "to": false, "step": false, "values": false } },
    ]);
}

/// How long lists may be.
fn describe_limits(root: &mut Value, definitions: &mut Definitions) {
    for (part, key, most) in LISTS {
        let whole = if part.is_empty() { &mut *root } else { &mut definitions[part] };
        let list = &mut whole["properties"][key];
        let keyword = if list["type"] == "object" { "maxProperties" } else { "maxItems" };
        list[keyword] = json!(most);
    }
    definitions["Figure"]["properties"]["panels"]["items"]["maxItems"] = json!(MAX_PARTS);
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

/// Adds the keys that make a file shorter.
fn add_shortcuts(root: &mut Value, definitions: &mut Definitions) {
    let mut shortcuts = schemars::schema_for!(wire::Shortcuts).to_value();
    definitions.append(&mut take_definitions(&mut shortcuts));
    merge(&mut root["properties"], shortcuts["properties"].take());
}

/// Requires of a file only what every file must have.
fn require_what_differs(root: &mut Value, definitions: &mut Definitions) {
    root["required"] = json!(["schema", "name"]);
    let trackers = json!([{ "required": ["tracker"] }, { "required": ["tracker-group"] }]);
    root["anyOf"] =
        json!([{ "required": ["extends"] }, { "required": ["title", "suites"], "anyOf": trackers }]);
    for (definition, required) in NAMES {
        definitions[definition]["required"] = json!(required);
    }
}

/// Defines the plugins of a list, each by itself, and gives the choice between them.
fn plugins<T: ?Sized>(definitions: &mut Definitions, what: &str, list: &'static [Entry<T>]) -> Value {
    let alternatives = list.iter().map(|entry| {
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
    });
    let alternatives: Vec<Value> = alternatives.collect();
    json!({ "anyOf": alternatives })
}

/// Lets a number of a detector be trained instead of given.
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

/// Lets a plugin's references point to the definitions that have the plugin's name.
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

/// Removes null, which TOML has not.
fn remove_null(schema: &mut Value) {
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
