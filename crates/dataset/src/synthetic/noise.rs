//! Hashes of places, value noise made of them, colors and ellipses.

/// A color, red, green and blue in 0..=255.
pub type Color = [f64; 3];

/// Hash of a seed and a place to 32 well mixed bits (finaliser of MurmurHash3).
pub fn hash(seed: u32, x: i32, y: i32) -> u32 {
    let mut h =
        seed ^ (x as u32).wrapping_mul(0x9E37_79B1) ^ (y as u32).wrapping_mul(0x85EB_CA77).rotate_left(15);
    h ^= h >> 16;
    h = h.wrapping_mul(0x85EB_CA6B);
    h ^= h >> 13;
    h = h.wrapping_mul(0xC2B2_AE35);
    h ^ (h >> 16)
}

/// A number in `[0, 1)` for a seed and a place.
pub fn unit(seed: u32, x: i32, y: i32) -> f64 {
    f64::from(hash(seed, x, y)) / 4_294_967_296.0
}

/// Value noise in `[0, 1)`: random values on the integer lattice, smoothly interpolated.
pub fn value(seed: u32, x: f64, y: f64) -> f64 {
    let (i, j) = (x.floor(), y.floor());
    let ease = |s: f64| s * s * (3.0 - 2.0 * s);
    let (fx, fy) = (ease(x - i), ease(y - j));
    let (i, j) = (i as i32, j as i32);
    let top = lerp(unit(seed, i, j), unit(seed, i + 1, j), fx);
    let bottom = lerp(unit(seed, i, j + 1), unit(seed, i + 1, j + 1), fx);
    lerp(top, bottom, fy)
}

/// Sum of octaves of value noise, each of twice the frequency and half the weight, in `[0, 1)`.
pub fn octaves(seed: u32, x: f64, y: f64, count: u32) -> f64 {
    let (mut sum, mut weight, mut total, mut scale) = (0.0, 1.0, 0.0, 1.0);
    for k in 0..count {
        sum += weight * value(seed.wrapping_add(k.wrapping_mul(0x51ED_270B)), x * scale, y * scale);
        total += weight;
        weight *= 0.5;
        scale *= 2.0;
    }
    sum / total
}

/// Linear interpolation: `a` at `s = 0`, `b` at `s = 1`.
pub fn lerp(a: f64, b: f64, s: f64) -> f64 {
    a + (b - a) * s
}

/// Smooth step: 0 below `a`, 1 above `b`.
pub fn smoothstep(a: f64, b: f64, x: f64) -> f64 {
    let s = ((x - a) / (b - a)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// Mixes two colors: `a` at `s = 0`, `b` at `s = 1`.
pub fn mix(a: Color, b: Color, s: f64) -> Color {
    [lerp(a[0], b[0], s), lerp(a[1], b[1], s), lerp(a[2], b[2], s)]
}

/// Multiplies the channels of a color by `factor`.
pub fn shade(c: Color, factor: f64) -> Color {
    c.map(|v| v * factor)
}

/// Picks one of a palette of colors `0xRRGGBB` by the hash of a place.
pub fn pick(palette: &[u32], seed: u32, x: i32, y: i32) -> Color {
    let [_, red, green, blue] = palette[hash(seed, x, y) as usize % palette.len()].to_be_bytes();
    [red, green, blue].map(f64::from)
}

/// Distance from the center of an ellipse, in units in which its border is at 1.
pub fn ellipse(x: f64, y: f64, cx: f64, cy: f64, rx: f64, ry: f64) -> f64 {
    let (a, b) = ((x - cx) / rx, (y - cy) / ry);
    (a * a + b * b).sqrt()
}

/// Rounds a channel to a byte.
pub fn byte(v: f64) -> u8 {
    v.clamp(0.0, 255.0).round() as u8
}
