//! Figures that only the surveillance suites have: heads, shoulders, cars from above, plain walls.

use super::motion::sin_cos;
use super::noise::{Color, mix, octaves, pick, shade, smoothstep, unit};

const SHIRTS: [Color; 8] = [
    [52.0, 70.0, 128.0],
    [164.0, 52.0, 50.0],
    [214.0, 212.0, 206.0],
    [56.0, 56.0, 62.0],
    [60.0, 108.0, 82.0],
    [124.0, 84.0, 140.0],
    [92.0, 132.0, 176.0],
    [196.0, 160.0, 72.0],
];
const SKIN: [Color; 4] =
    [[226.0, 178.0, 148.0], [204.0, 150.0, 116.0], [156.0, 106.0, 76.0], [236.0, 194.0, 166.0]];
const HAIR: [Color; 5] =
    [[46.0, 34.0, 28.0], [98.0, 62.0, 34.0], [182.0, 146.0, 88.0], [32.0, 30.0, 32.0], [150.0, 146.0, 142.0]];
const PAINT: [Color; 9] = [
    [172.0, 34.0, 36.0],
    [38.0, 72.0, 146.0],
    [212.0, 212.0, 210.0],
    [44.0, 46.0, 50.0],
    [46.0, 112.0, 84.0],
    [212.0, 176.0, 58.0],
    [132.0, 138.0, 146.0],
    [108.0, 36.0, 58.0],
    [80.0, 140.0, 182.0],
];

/// A head on the vertical axis; `turn` in cycles: 0 looks at the camera, 1/4 to its right, 1/2 away.
///
/// The box is a sphere pressed into an ellipse. A place on it, turned back, says what is there: hair on
/// the back and above the hair line, else skin with eyes, nose and mouth. So skin gives way to hair as
/// the head turns.
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
    if y < line || front < 0.08 && (y < 0.45 || long) {
        return Some(shade(hair, strand * (0.5 + 0.6 * light)));
    }
    let near = |cx: f64, cy: f64, rx: f64, ry: f64| {
        let (a, b) = ((side - cx) / rx, (y - cy) / ry);
        a * a + b * b < 1.0
    };
    if front > 0.0 {
        for eye in [-0.36, 0.36] {
            if near(eye, -0.08, 0.075, 0.07) {
                return Some([46.0, 36.0, 32.0]);
            }
            if near(eye, -0.08, 0.16, 0.075) {
                return Some(shade([232.0, 228.0, 222.0], light));
            }
            if near(eye, -0.25, 0.2, 0.05) {
                return Some(shade(hair, 0.8));
            }
        }
        if near(0.0, 0.28, 0.13, 0.07) {
            return Some(shade(skin, 0.7 * light));
        }
        if near(0.0, 0.56, 0.27, 0.075) {
            return Some(shade([182.0, 90.0, 86.0], light));
        }
        if unit(look, 4, 0) < 0.25 && y > 0.4 {
            return Some(shade(mix(skin, hair, 0.6), light));
        }
    }
    Some(shade(skin, light * (0.95 + 0.1 * octaves(look ^ 7, side * 12.0, y * 12.0, 2))))
}

/// The body below a head, from the neck to the knees; mostly the shoulders are in view.
pub fn shoulders(look: u32, u: f64, v: f64) -> Option<Color> {
    let (skin, shirt) = (pick(&SKIN, look, 1, 0), pick(&SHIRTS, look, 5, 0));
    let out = (u - 0.5).abs();
    if v < 0.07 && out < 0.11 {
        return Some(shade(skin, 0.72 - 0.3 * (u - 0.5)));
    }
    let slope = 0.045 + 0.1 * out * out + 0.38 * (out - 0.36).max(0.0);
    let legs = v > 0.56;
    if v < slope || out > if legs { 0.34 } else { 0.49 } {
        return None;
    }
    let fold = 0.72 + 0.36 * octaves(look ^ 11, u * 7.0, v * 17.0, 3) - 0.35 * (u - 0.5);
    if legs {
        let gap = out < 0.03 && v > 0.64;
        return Some(shade(shade(pick(&SHIRTS, look, 6, 0), 0.6), if gap { 0.5 * fold } else { fold }));
    }
    let collar = v < slope + 0.024 && out < 0.2;
    let arm = (out - 0.34).abs() < 0.012 && v > 0.14;
    let tone = if arm { 0.7 * fold } else { fold };
    Some(shade(if collar { mix(shirt, [240.0; 3], 0.5) } else { shirt }, tone))
}

/// A car from above, its bonnet to the right; about twice as long as wide.
pub fn roof(look: u32, u: f64, v: f64) -> Option<Color> {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let (a2, b2) = (a * a, b * b);
    if a2 * a2 * a2 + b2 * b2 * b2 > 0.98 {
        return None;
    }
    let paint = pick(&PAINT, look, 1, 0);
    let gloss = 0.86 + 0.2 * (1.0 - v) + 0.12 * octaves(look ^ 3, u * 6.0, v * 4.0, 2);
    let side = b.abs();
    let glass = mix([34.0, 42.0, 52.0], [126.0, 142.0, 154.0], smoothstep(0.4, 0.7, u + 0.3 * v - 0.4));
    let (rear, wind) = (0.12 + 0.05 * side, 0.66 - 0.06 * side);
    if (rear..rear + 0.09).contains(&u) && side < 0.74 || (wind..wind + 0.12).contains(&u) && side < 0.8 {
        return Some(glass);
    }
    if (0.24..0.62).contains(&u) && (0.74..0.86).contains(&side) {
        let post = (u - 0.44).abs() < 0.02;
        return Some(if post { shade(paint, 0.7) } else { glass });
    }
    if u > 0.95 && side > 0.5 {
        return Some([244.0, 238.0, 206.0]);
    }
    if u < 0.04 && side > 0.5 {
        return Some([176.0, 34.0, 30.0]);
    }
    let cabin = (0.2..0.64).contains(&u) && side < 0.74;
    let seam = (u - 0.79).abs() < 0.006 || side > 0.93;
    let lit = if cabin { 1.12 } else { 0.96 };
    Some(shade(paint, gloss * if seam { 0.6 } else { lit }))
}

/// A plain wall, kiosk or bridge deck: slabs of one color with stains.
pub fn wall(look: u32, u: f64, v: f64, aspect: f64) -> Option<Color> {
    const STONE: [Color; 4] =
        [[150.0, 148.0, 142.0], [124.0, 120.0, 114.0], [172.0, 160.0, 138.0], [112.0, 118.0, 126.0]];
    let stain = 0.78 + 0.4 * octaves(look ^ 3, u * 5.0 * aspect, v * 5.0, 4);
    let joint = (u * aspect * 3.0).rem_euclid(1.0) < 0.03 || (v * 3.0).rem_euclid(1.0) < 0.04;
    let edge = !(0.03..0.97).contains(&v);
    let tone = if edge {
        1.15
    } else if joint {
        0.75
    } else {
        1.0
    };
    Some(shade(pick(&STONE, look, 1, 0), stain * tone))
}
