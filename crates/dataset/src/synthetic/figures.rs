//! Figures that only the surveillance suites have: heads, shoulders, cars from above, plain walls.

use super::motion::sin_cos;
use super::noise::{Color, ellipse, mix, octaves, pick, shade, smoothstep, unit};

const SHIRTS: [u32; 8] = [0x344680, 0xA43432, 0xD6D4CE, 0x38383E, 0x3C6C52, 0x7C548C, 0x5C84B0, 0xC4A048];
const SKIN: [u32; 4] = [0xE2B294, 0xCC9674, 0x9C6A4C, 0xECC2A6];
const HAIR: [u32; 5] = [0x2E221C, 0x623E22, 0xB69258, 0x201E20, 0x96928E];
const PAINT: [u32; 9] =
    [0xAC2224, 0x264892, 0xD4D4D2, 0x2C2E32, 0x2E7054, 0xD4B03A, 0x848A92, 0x6C243A, 0x508CB6];
const STONE: [u32; 4] = [0x96948E, 0x7C7872, 0xACA08A, 0x70767E];

/// A head on the vertical axis; `turn` in cycles: 0 looks at the camera, 1/4 to its right, 1/2 away.
///
/// The box is a sphere pressed into an ellipse. A place on the sphere, turned back, is hair on the back and
/// above the hair line, else skin with eyes, nose and mouth. So skin gives way to hair as the head turns.
pub fn head(look: u32, turn: f64, u: f64, v: f64) -> Option<Color> {
    let (skin, hair) = (pick(&SKIN, look, 1, 0), pick(&HAIR, look, 2, 0));
    let (x, y) = ((u - 0.5) / 0.485, (v - 0.5) / 0.49);
    let rest = 1.0 - x * x - y * y;
    // A chin: the lower half is narrower.
    if rest < 0.0 || x.abs() > 1.0 - 0.45 * y.max(0.0) * y.max(0.0) {
        return None;
    }
    let depth = rest.sqrt();
    let (s, c) = sin_cos(turn);
    let (side, front) = (c * x - s * depth, s * x + c * depth);
    let light = 0.74 + 0.34 * depth - 0.16 * x - 0.1 * y;
    let strand = 0.68 + 0.5 * octaves(look ^ 5, side * 16.0, y * 5.0, 3);
    let line = -0.42 + 0.25 * side * side;
    let long = unit(look, 3, 0) < 0.4;
    let near = |cx: f64, cy: f64, rx: f64, ry: f64| front > 0.0 && ellipse(side, y, cx, cy, rx, ry) < 1.0;
    let eye = if side < 0.0 { -0.36 } else { 0.36 };
    Some(match () {
        _ if y < line || front < 0.08 && (y < 0.45 || long) => shade(hair, strand * (0.5 + 0.6 * light)),
        _ if near(eye, -0.08, 0.075, 0.07) => [46.0, 36.0, 32.0],
        _ if near(eye, -0.08, 0.16, 0.075) => shade([232.0, 228.0, 222.0], light),
        _ if near(eye, -0.25, 0.2, 0.05) => shade(hair, 0.8),
        _ if near(0.0, 0.28, 0.13, 0.07) => shade(skin, 0.7 * light),
        _ if near(0.0, 0.56, 0.27, 0.075) => shade([182.0, 90.0, 86.0], light),
        _ if front > 0.0 && unit(look, 4, 0) < 0.25 && y > 0.4 => shade(mix(skin, hair, 0.6), light),
        _ => shade(skin, light * (0.95 + 0.1 * octaves(look ^ 7, side * 12.0, y * 12.0, 2))),
    })
}

/// The body below a head, from the neck to the knees. Mostly only the shoulders are in view.
pub fn shoulders(look: u32, u: f64, v: f64) -> Option<Color> {
    let (skin, shirt) = (pick(&SKIN, look, 1, 0), pick(&SHIRTS, look, 5, 0));
    let out = (u - 0.5).abs();
    let slope = 0.045 + 0.1 * out * out + 0.38 * (out - 0.36).max(0.0);
    let legs = v > 0.56;
    let half = if legs { 0.34 } else { 0.49 };
    let fold = 0.72 + 0.36 * octaves(look ^ 11, u * 7.0, v * 17.0, 3) - 0.35 * (u - 0.5);
    let arm = (out - 0.34).abs() < 0.012 && v > 0.14;
    let tone = if arm { 0.7 * fold } else { fold };
    Some(match () {
        _ if v < 0.07 && out < 0.11 => shade(skin, 0.72 - 0.3 * (u - 0.5)),
        _ if v < slope || out > half => return None,
        _ if legs => {
            let gap = out < 0.03 && v > 0.64;
            shade(shade(pick(&SHIRTS, look, 6, 0), 0.6), if gap { 0.5 * fold } else { fold })
        }
        _ if v < slope + 0.024 && out < 0.2 => shade(mix(shirt, [240.0; 3], 0.5), tone),
        _ => shade(shirt, tone),
    })
}

/// A car from above, its bonnet to the right; about twice as long as wide.
pub fn roof(look: u32, u: f64, v: f64) -> Option<Color> {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let (a2, b2) = (a * a, b * b);
    let paint = pick(&PAINT, look, 1, 0);
    let gloss = 0.86 + 0.2 * (1.0 - v) + 0.12 * octaves(look ^ 3, u * 6.0, v * 4.0, 2);
    let side = b.abs();
    let glass = mix([34.0, 42.0, 52.0], [126.0, 142.0, 154.0], smoothstep(0.4, 0.7, u + 0.3 * v - 0.4));
    let (rear, wind) = (0.12 + 0.05 * side, 0.66 - 0.06 * side);
    let panes = (0.24..0.62).contains(&u) && (0.74..0.86).contains(&side);
    Some(match () {
        _ if a2 * a2 * a2 + b2 * b2 * b2 > 0.98 => return None,
        _ if (rear..rear + 0.09).contains(&u) && side < 0.74 => glass,
        _ if (wind..wind + 0.12).contains(&u) && side < 0.8 => glass,
        _ if panes && (u - 0.44).abs() < 0.02 => shade(paint, 0.7),
        _ if panes => glass,
        _ if u > 0.95 && side > 0.5 => [244.0, 238.0, 206.0],
        _ if u < 0.04 && side > 0.5 => [176.0, 34.0, 30.0],
        _ if (u - 0.79).abs() < 0.006 || side > 0.93 => shade(paint, gloss * 0.6),
        _ if (0.2..0.64).contains(&u) && side < 0.74 => shade(paint, gloss * 1.12),
        _ => shade(paint, gloss * 0.96),
    })
}

/// A plain wall, kiosk or bridge deck: slabs of one color with stains.
pub fn wall(look: u32, u: f64, v: f64, aspect: f64) -> Option<Color> {
    let stain = 0.78 + 0.4 * octaves(look ^ 3, u * 5.0 * aspect, v * 5.0, 4);
    let tone = match () {
        _ if !(0.03..0.97).contains(&v) => 1.15,
        _ if (u * aspect * 3.0).rem_euclid(1.0) < 0.03 || (v * 3.0).rem_euclid(1.0) < 0.04 => 0.75,
        _ => 1.0,
    };
    Some(shade(pick(&STONE, look, 1, 0), stain * tone))
}
