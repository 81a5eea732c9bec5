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

/// Rounds a `value` of less than 2^51 to the nearest integer, halves to even. Others give an arbitrary integer.
///
/// Loops over this function compile to vector operations on all processors. Loops over a cast do not, because
/// of its range checks.
#[inline(always)]
pub fn integer(value: f64) -> i64 {
    // Numbers from 2^52 on are whole, so that the low bits of this sum count from its first term.
    const SHIFT: f64 = (3_u64 << 51) as f64;
    (value + SHIFT).to_bits().wrapping_sub(SHIFT.to_bits()) as i64
}

/// A number for people: `0.5`, `1e-300`. Plain digits, unless they take more than 17 characters and the form
/// with an exponent is shorter.
pub fn readable(number: impl std::fmt::Display) -> String {
    let plain = number.to_string();
    if plain.len() <= 17 {
        return plain;
    }
    let short = plain.parse::<f64>().map(|value| format!("{value:e}"));
    short.ok().filter(|short| short.len() < plain.len()).unwrap_or(plain)
}

/// A number with a fixed number of decimals: `0.500`; with an exponent, `1.000e300`, if the plain form takes
/// more than 17 characters.
pub fn fixed(value: f64, decimals: usize) -> String {
    let plain = format!("{value:.decimals$}");
    if plain.len() <= 17 { plain } else { format!("{value:.decimals$e}") }
}

/// Bytes as lowercase hexadecimal digits, two per byte.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn long_numbers_have_an_exponent() {
        for (number, text) in [
            (0.5, "0.5"),
            (1e-300, "1e-300"),
            (-1e300, "-1e300"),
            (1e-9, "0.000000001"),
            (0.12345678901234568, "0.12345678901234568"),
            (123456789.0, "123456789"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(readable(number), text);
            assert!(text.parse::<f64>().unwrap() == number);
        }
        assert_eq!(readable("a text that is no number at all"), "a text that is no number at all");
        assert_eq!(readable(u64::MAX), "18446744073709551615");
        let shown = [0.5, -1e308, 1e-300, 123456789.0].map(|value| fixed(value, 3));
        assert_eq!(shown, ["0.500", "-1.000e308", "0.000", "123456789.000"]);
    }

    proptest! {
        #[test]
        fn whole_numbers_become_their_integers(v in -(1_i64 << 51) + 1..1_i64 << 51) {
            prop_assert_eq!(integer(v as f64), v);
        }
    }
}
