//! `analyses.json`: what the experiment's analyses found out, one entry for each analysis and tracker.

use super::ResultsError;
use super::json::{from_json, to_dense_json};
use std::path::Path;
use trackfail_engine::execute::analyse::Analysed;

/// The file; experiments without an analysis, and those where every analysis failed, have none.
pub const FILE: &str = "analyses.json";

/// Writes the file, none where there is nothing to write.
///
/// # Errors
/// When a finding cannot be JSON.
pub(super) fn write(folder: &Path, analyses: &[Analysed]) -> Result<Option<Vec<u8>>, ResultsError> {
    let bytes = (!analyses.is_empty()).then(|| to_dense_json(&folder.join(FILE), &analyses));
    bytes.transpose()
}

/// Reads the file.
///
/// # Errors
/// When the bytes are not JSON of findings.
pub(super) fn read(folder: &Path, bytes: &[u8]) -> Result<Vec<Analysed>, ResultsError> {
    from_json(&folder.join(FILE), bytes)
}
