//! `models/*.json`: what was trained or learned, one file for each method and tracker.

use super::ResultsError;
use super::json::to_json;
use crate::engine::Outcome;
use crate::engine::store;
use std::path::Path;

/// The folder of the models.
pub const FOLDER: &str = "models";

/// Writes a file for each model. Nothing but people and `detect --model` reads them: what reports show of a model
/// is in the manifest.
///
/// # Errors
/// When a file cannot be written.
pub(super) fn write(folder: &Path, outcome: &Outcome<'_>) -> Result<(), ResultsError> {
    for (k, model) in outcome.models.iter().enumerate() {
        let name = format!("{:03}-{}-{}.json", k + 1, slug(&model.method), slug(&model.tracker));
        let path = folder.join(FOLDER).join(name);
        store::write(&path, &to_json(&path, model)?)?;
    }
    Ok(())
}

/// A name as part of a file name; the number before it keeps different names apart.
fn slug(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    name.chars().take(40).map(safe).collect()
}
