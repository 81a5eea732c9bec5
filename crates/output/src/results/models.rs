//! `models/*.json`: trained parameters and learned models, one file for each method, grid point and tracker;
//! one for all trackers (`*`) if a model was learned from all of them. The file of a learned model has the
//! cut value of its grid point as `threshold`: grid points that share a model (the lengths L of AVU) differ
//! in it.

use super::ResultsError;
use super::frame_measures::EVERY_TRACKER;
use super::json::write_json;
use std::path::Path;
use trackfail_engine::Outcome;
use trackfail_engine::execute::train::{Content, Model};

/// Name of the folder of models.
pub const FOLDER: &str = "models";

/// Writes one file for each model. The files are for people and `detect --model`; reports read the manifest
/// instead.
///
/// # Errors
/// When a file cannot be written.
pub(super) fn write(folder: &Path, outcome: &Outcome<'_>) -> Result<(), ResultsError> {
    for (k, model) in together(&outcome.models).iter().enumerate() {
        let tracker = if model.tracker == EVERY_TRACKER { "all" } else { &model.tracker };
        let method = match model.params.as_str() {
            "" => slug(&model.method),
            point => format!("{}-{}", slug(&model.method), slug(point)),
        };
        let name = format!("{:03}-{method}-{}.json", k + 1, slug(tracker));
        write_json(&folder.join(FOLDER).join(name), model)?;
    }
    Ok(())
}

/// Models, those shared by several trackers only once.
fn together(models: &[Model]) -> Vec<Model> {
    let of_method = |a: &Model, b: &Model| a.method == b.method && a.params == b.params;
    // What was chosen for one tracker alone may be equal to what was chosen for another one.
    let is_learned = |m: &Model| matches!(m.content, Content::Learned { .. });
    let mut together: Vec<Model> = Vec::new();
    for model in models {
        let same = |known: &&mut Model| {
            of_method(known, model) && is_learned(model) && known.content == model.content
        };
        match together.iter_mut().find(same) {
            Some(known) => known.tracker = EVERY_TRACKER.to_string(),
            None => together.push(model.clone()),
        }
    }
    together
}

/// Name as part of a file name. The number before it distinguishes names that become equal.
fn slug(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    name.chars().take(40).map(safe).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn model(method: &str, tracker: &str, bias: f64) -> Model {
        Model {
            method: method.into(),
            params: String::new(),
            tracker: tracker.into(),
            runs: 1,
            suite: "s".into(),
            tuned_on_test: false,
            sequences: Vec::new(),
            content: Content::Learned { model: json!({ "bias": bias }), threshold: None },
        }
    }

    #[test]
    fn a_model_of_all_trackers_is_one_file() {
        let models = [model("a", "x", 1.0), model("a", "y", 1.0), model("b", "x", 1.0), model("b", "y", 2.0)];
        let names: Vec<(String, String)> =
            together(&models).into_iter().map(|m| (m.method, m.tracker)).collect();
        let expected = [("a", "*"), ("b", "x"), ("b", "y")];
        assert_eq!(names, expected.map(|(method, tracker)| (method.to_string(), tracker.to_string())));
    }
}
