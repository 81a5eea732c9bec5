//! Numerics without files: seeds, filters, time series models.

pub mod arma;
pub mod seed;
