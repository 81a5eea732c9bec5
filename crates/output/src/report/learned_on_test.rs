//! Methods whose model comes with the program and was learned from sequences that are tested.

use crate::results::Manifest;
use std::collections::BTreeMap;
use trackfail_dataset::synthetic;
use trackfail_methods::detector::fused;

/// A sentence for all methods that share the same sequences. Sequences are compared by their names, which is all that a model
/// says of them; rendered ones, which share names with real ones, are no real video.
pub fn warnings(manifest: &Manifest) -> Vec<String> {
    if synthetic::is_rendered(&manifest.suite.name) {
        return Vec::new();
    }
    let mut methods: BTreeMap<Vec<String>, Vec<&str>> = BTreeMap::new();
    for method in &manifest.methods {
        let (kind, _, params) = &method.detector;
        let model = params.get("model").and_then(serde_json::Value::as_str);
        let Some(learned) = model.filter(|_| *kind == fused::ENTRY.kind).and_then(fused::learned_from) else {
            continue;
        };
        let names = manifest.suite.present.iter().map(|(name, _)| name);
        let tested: Vec<String> = names.filter(|name| learned.contains(name)).cloned().collect();
        let of_these = methods.entry(tested).or_default();
        if !of_these.contains(&method.name.as_str()) {
            of_these.push(&method.name);
        }
    }
    let sentence = |(tested, methods): (Vec<String>, Vec<&str>)| {
        format!(
            "{}: the model comes with the program and was learned from sequences named as {} of the {} tested ones. \
             Where these are the same videos, the numbers are too good.",
            methods.join(", "),
            tested.len(),
            manifest.suite.present.len(),
        )
    };
    methods.into_iter().filter(|(tested, _)| !tested.is_empty()).map(sentence).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MANIFEST: &str = include_str!("../../../../results/quickstart/manifest.json");

    #[test]
    fn a_model_of_the_program_is_warned_of_on_its_own_sequences() {
        let mut manifest: serde_json::Value = serde_json::from_str(MANIFEST).unwrap();
        let method = &mut manifest["methods"][0];
        method["name"] = "Fused boxes".into();
        method["detector"] = serde_json::json!(["fused", 2, { "model": "boxes" }]);
        manifest["suite"]["present"] = serde_json::json!([["Woman", 597], ["Mine", 20]]);
        let read =
            |manifest: &serde_json::Value| serde_json::from_value::<Manifest>(manifest.clone()).unwrap();
        assert!(warnings(&read(&manifest)).is_empty(), "a rendered suite");
        manifest["suite"]["name"] = "otb-100".into();
        let found = warnings(&read(&manifest));
        assert_eq!(found.len(), 1);
        assert!(
            found[0].starts_with("Fused boxes: ") && found[0].contains("named as 1 of the 2 tested"),
            "{found:?}"
        );
        manifest["methods"][0]["detector"] = serde_json::json!(["fused", 2, { "train": "others" }]);
        assert!(warnings(&read(&manifest)).is_empty());
    }
}
