//! Numerics without files: seeds, filters, time series models.

pub mod arma;
pub mod seed;

/// Bytes as lower-case hexadecimal digits, two a byte.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
