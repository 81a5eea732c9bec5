//! Numerics without files: seeds, filters, time series models, distributions and their fits,
//! particles, comparisons of methods.

pub mod accumulation;
pub mod arma;
pub mod distribution;
pub mod fourier;
pub mod gamma_mixture;
pub mod incremental_pca;
pub mod kolmogorov;
pub mod lasso;
pub mod paired;
pub mod particles;
pub mod pooled;
pub mod ranks;
pub mod seed;
pub mod special;

/// Bytes as lower-case hexadecimal digits, two a byte.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
