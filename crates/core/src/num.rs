//! Numerics: seeds, transforms, time series models, distributions and their fits, particles, sparse codes,
//! comparisons of methods.

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

/// Bytes as lowercase hexadecimal digits, two per byte.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
