//! `trackfail schema`: the JSON Schema of experiment files.

use super::{Failure, output};
use crate::spec;

/// Text of the schema as a file.
///
/// # Errors
/// None is expected, since the schema is valid JSON.
pub fn text() -> Result<String, Failure> {
    Ok(serde_json::to_string_pretty(&spec::schema::schema()).map_err(Failure::io)? + "\n")
}

/// Runs the verb.
///
/// # Errors
/// When stdout cannot be written to.
pub fn run() -> Result<(), Failure> {
    output::write(&text()?)
}
