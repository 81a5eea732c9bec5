//! A soft assignment of colors to the basic color terms: ten numbers per color.
//!
//! ```text
//! p_k = exp(-|Lab - Lab_k|^2 / (2 s^2)) / sum_j exp(-|Lab - Lab_j|^2 / (2 s^2))        k = 0..11, s = 20
//! n_k = p_k - 1/11,  k = 0..10
//! ```
//!
//! The eleven terms of Berlin and Kay (black, blue, brown, green, orange, pink, purple, red, white, yellow, gray) each
//! have one typical sRGB color, [`TERMS`]; distances are Euclidean in CIE L*a*b* (D65). As the `p_k` sum to 1, the last
//! one, gray, is left out; values are in `[-1/11, 10/11]`.
//!
//! This replaces the color names of van de Weijer et al. ("Learning color names for real-world applications",
//! TIP 18(7), 2009) in the ten-dimensional form of Danelljan et al. (CVPR 2014), a table learned from images
//! that is not part of this project. Colors are quantized as there: 32 levels per channel, at the middle of
//! each.

use std::sync::OnceLock;

/// Number of values per color.
pub const NAMES: usize = 10;
/// Standard deviation `s` of the assignment, in units of L*a*b*.
const SPREAD: f64 = 20.0;
/// Number of quantized levels per channel.
const LEVELS: usize = 32;
/// The typical color of each term, sRGB.
pub const TERMS: [[f64; 3]; NAMES + 1] = [
    [0.0, 0.0, 0.0],
    [30.0, 60.0, 200.0],
    [120.0, 70.0, 25.0],
    [40.0, 150.0, 45.0],
    [255.0, 140.0, 0.0],
    [255.0, 150.0, 190.0],
    [130.0, 40.0, 160.0],
    [205.0, 25.0, 25.0],
    [255.0, 255.0, 255.0],
    [250.0, 230.0, 40.0],
    [128.0, 128.0, 128.0],
];

/// L*a*b* (D65) of an sRGB color, each channel from 0 to 255.
pub fn lab(rgb: [f64; 3]) -> [f64; 3] {
    let [r, g, b] = rgb.map(|v| {
        let v = v / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    });
    let white = [0.950_47, 1.0, 1.088_83];
    let [x, y, z] = [
        0.412_456_4 * r + 0.357_576_1 * g + 0.180_437_5 * b,
        0.212_672_9 * r + 0.715_152_2 * g + 0.072_175 * b,
        0.019_333_9 * r + 0.119_192 * g + 0.950_304_1 * b,
    ];
    let f = |v: f64| {
        if v > 216.0 / 24_389.0 { v.cbrt() } else { (24_389.0 / 27.0 * v + 16.0) / 116.0 }
    };
    let [x, y, z] = [f(x / white[0]), f(y / white[1]), f(z / white[2])];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn assign(color: [f64; 3], terms: &[[f64; 3]; NAMES + 1]) -> [f64; NAMES] {
    let weights = terms.map(|term| {
        let square: f64 = term.iter().zip(color).map(|(a, b)| (a - b).powi(2)).sum();
        (-0.5 * square / (SPREAD * SPREAD)).exp()
    });
    // No color is so far from all terms that all weights underflow: the farthest, pure green, is at 62 units.
    let sum: f64 = weights.iter().sum();
    std::array::from_fn(|k| weights[k] / sum - 1.0 / (NAMES + 1) as f64)
}

/// Table with ten values for each quantized color.
pub struct ColorNames(Vec<[f32; NAMES]>);

impl ColorNames {
    /// Returns the table. The first call computes it.
    pub fn table() -> &'static Self {
        static TABLE: OnceLock<ColorNames> = OnceLock::new();
        TABLE.get_or_init(|| {
            let level = |i: usize| (256 / LEVELS * (i % LEVELS)) as f64 + (256 / LEVELS - 1) as f64 / 2.0;
            let color = |i: usize| [level(i), level(i / LEVELS), level(i / LEVELS / LEVELS)];
            let terms = TERMS.map(lab);
            let numbers = |i: usize| assign(lab(color(i)), &terms).map(|v| v as f32);
            Self((0..LEVELS * LEVELS * LEVELS).map(numbers).collect())
        })
    }

    /// The values of a color, each channel from 0 to 255 (others are clamped).
    pub fn of(&self, rgb: [f32; 3]) -> &[f32; NAMES] {
        let [r, g, b] = rgb.map(|v| (v as usize).min(255) / (256 / LEVELS));
        &self.0[r + LEVELS * (g + LEVELS * b)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_testing::assert_near;

    /// Ten values of a color, without quantization.
    fn names(rgb: [f64; 3]) -> [f64; NAMES] {
        assign(lab(rgb), &TERMS.map(lab))
    }

    #[test]
    fn lab_of_known_colors() {
        let near = |rgb: [f64; 3], want: [f64; 3]| assert_near(lab(rgb), want, 0.02, "");
        near([0.0; 3], [0.0; 3]);
        near([255.0; 3], [100.0, 0.0, 0.0]);
        // Published values of the sRGB primaries (D65).
        near([255.0, 0.0, 0.0], [53.24, 80.09, 67.20]);
        near([0.0, 255.0, 0.0], [87.74, -86.18, 83.18]);
        near([0.0, 0.0, 255.0], [32.30, 79.19, -107.86]);
    }

    #[test]
    fn typical_colors_are_their_terms() {
        for (k, term) in TERMS.iter().enumerate() {
            let n = names(*term);
            let gray = 1.0 - n.iter().map(|v| v + 1.0 / 11.0).sum::<f64>();
            let p: Vec<f64> = n.iter().map(|v| v + 1.0 / 11.0).chain([gray]).collect();
            assert!(p[k] > 0.7, "{k}: {p:?}");
        }
    }

    #[test]
    fn the_table_has_the_numbers_of_the_middles() {
        let table = ColorNames::table();
        for rgb in [[0.0, 0.0, 0.0], [255.0, 128.0, 7.9], [100.0, 200.5, 999.0]] {
            let middle = rgb.map(|v: f32| f64::from((v as u32).min(255) / 8 * 8) + 3.5);
            for (a, b) in table.of(rgb).iter().zip(names(middle)) {
                assert!((f64::from(*a) - b).abs() < 1e-6);
                assert!((-0.0910..0.9100).contains(a));
            }
        }
    }
}
