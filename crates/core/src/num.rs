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
pub mod summary;

/// The integer that `value` is: whole, and of less than 2^51 either way; other values give any integer.
///
/// Loops over it become vector operations on every processor. Those over a cast do not, for its bounds.
#[inline(always)]
pub fn integer(value: f64) -> i64 {
    // Numbers from 2^52 on are whole, so that the low bits of this sum count from its first term.
    const SHIFT: f64 = (3_u64 << 51) as f64;
    (value + SHIFT).to_bits().wrapping_sub(SHIFT.to_bits()) as i64
}

/// Bytes as lowercase hexadecimal digits, two per byte.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn whole_numbers_become_their_integers(v in -(1_i64 << 51) + 1..1_i64 << 51) {
            prop_assert_eq!(integer(v as f64), v);
        }
    }
}
