//! The schema is valid, and refuses what the program refuses.

use super::schema;
use crate::spec::check::tests::SPEC;
use crate::spec::{builtin, parse};
use crate::testing::changed;
use jsonschema::Validator;

/// Fails if `experiments/schema.json` is not up to date; `UPDATE=1 cargo test` writes it.
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

/// Empty list of faults.
const NOTHING: [String; 0] = [];

/// Validator of the schema. Creating it looks up all references.
fn validator() -> Validator {
    jsonschema::draft202012::new(&schema()).unwrap()
}

/// Errors that the schema finds in the text of an experiment.
fn faults(validator: &Validator, text: &str) -> Vec<String> {
    let value: serde_json::Value = toml::from_str(text).unwrap();
    validator.iter_errors(&value).map(|e| format!("{}: {e}", e.instance_path())).collect()
}

#[test]
fn it_is_a_schema_of_2020_12_with_no_loose_reference() {
    let schema = schema();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    jsonschema::draft202012::meta::validate(&schema).unwrap();
    let text = schema.to_string();
    let targets: Vec<&str> =
        text.split(r#""$ref":""#).skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert!(targets.len() > 100, "{}", targets.len());
    for target in targets {
        let place = target.strip_prefix('#').unwrap_or_else(|| panic!("{target}"));
        assert!(schema.pointer(place).is_some(), "{target}");
    }
}

#[test]
fn every_shipped_experiment_is_valid_as_it_is_and_written_out() {
    let validator = validator();
    for (name, text) in builtin::EXPERIMENTS {
        assert_eq!(faults(&validator, text), NOTHING, "{name}");
        let whole = parse(name, text).unwrap().source;
        assert_eq!(faults(&validator, &whole), NOTHING, "{name}, written out");
    }
}

#[test]
fn every_shipped_experiment_names_the_schema() {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments"));
    for (name, text) in builtin::EXPERIMENTS {
        let path = text.lines().next().and_then(|line| line.strip_prefix("#:schema "));
        let path = path.unwrap_or_else(|| panic!("{name} begins with no #:schema line"));
        let beside = folder.join(name).parent().unwrap().join(path);
        assert!(beside.canonicalize().unwrap().ends_with("experiments/schema.json"), "{name}: {path}");
    }
}

/// Items that an experiment may have, too.
const MORE: &str = r#"
[[tracker-group]]
name = "still"
trackers = [{ label = "a" }, { label = "b" }]

[[method]]
name = "trained"
signal = { kind = "rgb-histogram" }
detector = { kind = "level", below = { train = "test", maximise = "f_score", grid = { from = 0.1, to = 0.9, step = 0.1 } } }

[[method]]
name = "reading"
like = "trained"
signal = { bins = 8 }

[[method-group]]
methods = ["RAW", { name = "oracle", detector = { kind = "oracle" } }]

[[figure]]
name = "f"
kind = "delay"
"#;

/// Mutations: a text of [`SPEC`] with [`MORE`] and its replacement.
const MUTATIONS: [(&str, &str); 24] = [
    ("title", "tittle"),
    ("schema = 1", "schema = 2"),
    ("name = \"mine/try\"\n", ""),
    ("mine/try", "../try"),
    ("khalid2016/1", "khalid2016/9"),
    ("protocol", "seed = \"seven\"\nprotocol"),
    ("protocol", "seed = -1\nprotocol"),
    ("test = \"synthetic-vot\"", "test = 3"),
    ("\"ncc\"", "\"nccc\""),
    ("runs = 2", "serach = 1.5"),
    ("runs = 2", "search = \"wide\""),
    ("runs = 2", "runs = 0"),
    ("\"rgb-histogram\"", "\"rgb-histogramm\""),
    ("kind = \"level\", below", "kind = \"level\", bellow"),
    ("kind = \"level\", ", ""),
    ("maximise = \"f_score\"", "maximise = \"fpr\""),
    ("maximise = \"f_score\", ", ""),
    ("from = 0.1, ", ""),
    ("step = 0.1", "step = 0.1, quantiles = 9"),
    ("kind = \"oracle\"", "kind = \"oracle\", below = 1"),
    ("methods = [\"RAW\"", "method = [\"RAW\""),
    ("kind = \"delay\"", "kind = \"delays\""),
    ("kind = \"delay\"", "kind = \"delay\"\nstills = 3"),
    ("holds = ", "hold = "),
];

#[test]
fn what_the_program_refuses_is_not_valid() {
    let validator = validator();
    let whole = format!("{SPEC}{MORE}");
    assert_eq!(faults(&validator, &whole), NOTHING);
    assert_eq!(parse("try.toml", &whole).map(|_| ()).map_err(|e| e.to_string()), Ok(()));
    for (from, to) in MUTATIONS {
        let text = changed(&whole, from, to);
        assert!(parse("try.toml", &text).is_err(), "{from} -> {to}");
        assert_ne!(faults(&validator, &text), NOTHING, "{from} -> {to}");
    }
}
