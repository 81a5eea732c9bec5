//! The camera's sensor: gain and noise, applied to every value as the last step of a frame.

use super::noise::hash;

/// The gain 1 in fixed-point numbers.
const ONE: i32 = 256;

/// Multiplies the columns of `rgb` by `gains` (256 is 1) and adds noise of at most `noise` (0 to 100) gray
/// levels. The noise has a triangular distribution around 0 and comes from a hash of `seed` and the place.
pub fn expose(rgb: &mut [u8], gains: &[i32], noise: f64, seed: u32) {
    let width = gains.len();
    if width == 0 {
        return;
    }
    // Sums of two bytes are triangular on -255..=255.
    let strength = (noise.clamp(0.0, 100.0) * 4096.0 / 255.0).round() as i32;
    let mut levels = [0_i16; 511];
    for (sum, level) in (-255..).zip(&mut levels) {
        *level = ((sum * strength + 2048) >> 12) as i16;
    }
    let plain = gains.iter().all(|&gain| gain == ONE);
    let gains: Vec<i32> = gains.iter().flat_map(|&gain| [gain; 3]).collect();
    let mut places = vec![0_u32; width];
    let mut added = vec![0_i16; 3 * width];
    for (j, row) in rgb.chunks_exact_mut(3 * width).enumerate() {
        let row_seed = hash(seed, j as i32, 5);
        for (i, place) in places.iter_mut().enumerate() {
            let mut h = row_seed ^ (i as u32).wrapping_mul(0x9E37_79B1);
            h = (h ^ (h >> 15)).wrapping_mul(0x85EB_CA6B);
            h = (h ^ (h >> 13)).wrapping_mul(0xC2B2_AE35);
            *place = h ^ (h >> 16);
        }
        for (added, place) in added.chunks_exact_mut(3).zip(&places) {
            let [a, b, c, d] = place.to_le_bytes().map(usize::from);
            // One by one: an array would go over the stack, and wait there.
            added[0] = levels[a + b];
            added[1] = levels[b + c];
            added[2] = levels[c + d];
        }
        // Three loops without branches instead of one: each is done many values at a time.
        if plain {
            for (value, noise) in row.iter_mut().zip(&added) {
                *value = i16::from(*value).saturating_add(*noise).clamp(0, 255) as u8;
            }
        } else {
            for ((value, noise), gain) in row.iter_mut().zip(&added).zip(&gains) {
                let lit = (i32::from(*value) * gain + ONE / 2) >> 8;
                *value = (lit + i32::from(*noise)).clamp(0, 255) as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gray image (128) exposed with the same gain in all columns.
    fn exposed(gain: i32, noise: f64) -> Vec<u8> {
        let mut rgb = vec![128; 3 * 300 * 100];
        expose(&mut rgb, &[gain; 300], noise, 7);
        rgb
    }

    // A sum of two uniform bytes less 255 has deviation sqrt((256^2 - 1) / 6) = 104.5; rounding to whole
    // levels adds a twelfth to the variance.
    #[test]
    fn noise_has_the_deviation_of_two_bytes() {
        let values: Vec<f64> = exposed(ONE, 20.0).into_iter().map(f64::from).collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
        let expected = (104.5_f64 * 20.0 / 255.0).powi(2) + 1.0 / 12.0;
        assert!((mean - 128.0).abs() < 0.2, "{mean}");
        assert!((variance / expected - 1.0).abs() < 0.03, "{variance} {expected}");
        assert!(values.iter().all(|v| (v - 128.0).abs() <= 20.0));
    }

    #[test]
    fn gain_scales_and_one_leaves_alone() {
        assert!(exposed(ONE, 0.0).iter().all(|&v| v == 128));
        assert!(exposed(ONE / 2, 0.0).iter().all(|&v| v == 64));
        assert!(exposed(8 * ONE, 0.0).iter().all(|&v| v == 255));
        // One column that is dimmed takes the other way through, with the same result elsewhere.
        let (mut one, mut other) = (vec![90; 3 * 40], vec![90; 3 * 40]);
        let mut gains = [ONE; 40];
        expose(&mut one, &gains, 30.0, 3);
        gains[39] = 0;
        expose(&mut other, &gains, 30.0, 3);
        assert_eq!(one[..117], other[..117]);
        assert_ne!(one[117..], other[117..]);
    }
}
