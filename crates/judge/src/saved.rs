//! States of trackers and signals as bytes, so that an interrupted stream can be resumed.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Serializes a value; numbers keep all their bits.
pub fn to_bytes(value: &impl Serialize) -> Option<Vec<u8>> {
    postcard::to_stdvec(value).ok()
}

/// Deserializes a value of [`to_bytes`]; `None` if the bytes are of another type.
pub fn from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::take_from_bytes(bytes).ok().and_then(|(value, rest)| rest.is_empty().then_some(value))
}
