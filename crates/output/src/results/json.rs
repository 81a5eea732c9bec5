//! JSON files of a results folder.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;
use trackfail_engine::store::{self, StoreError};

/// Serializes a value as indented JSON with a final newline; `path` is for messages.
///
/// # Errors
/// When the value cannot be serialized.
pub fn to_json<T: Serialize>(path: &Path, value: &T) -> Result<Vec<u8>, StoreError> {
    ended(path, serde_json::to_vec_pretty(value))
}

/// Serializes a value as JSON in one line with a final newline; `path` is for messages.
///
/// # Errors
/// When the value cannot be serialized.
pub(super) fn to_dense_json<T: Serialize>(path: &Path, value: &T) -> Result<Vec<u8>, StoreError> {
    ended(path, serde_json::to_vec(value))
}

/// Writes a value as indented JSON.
pub(super) fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), StoreError> {
    store::write(path, &to_json(path, value)?)
}

fn ended(path: &Path, bytes: serde_json::Result<Vec<u8>>) -> Result<Vec<u8>, StoreError> {
    let mut bytes = bytes.map_err(|e| StoreError::new(path, e))?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// Parses a value from JSON; `path` is for messages.
///
/// # Errors
/// When the bytes are not JSON of this type.
pub(super) fn from_json<T: DeserializeOwned>(path: &Path, bytes: &[u8]) -> Result<T, StoreError> {
    serde_json::from_slice(bytes).map_err(|e| StoreError::new(path, e))
}
