//! Memory of trackers and signals as bytes, with which a stream that was interrupted goes on.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// A value as bytes; numbers keep all their bits.
pub fn to_bytes(value: &impl Serialize) -> Option<Vec<u8>> {
    postcard::to_stdvec(value).ok()
}

/// The value of [`to_bytes`]; `None` for bytes of something else.
pub fn from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::take_from_bytes(bytes).ok().and_then(|(value, rest)| rest.is_empty().then_some(value))
}
