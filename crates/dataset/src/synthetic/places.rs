//! Places that only the surveillance suites have: a road from above and a station's hall.

use super::noise::{Color, mix, octaves, pick, shade, smoothstep, unit};

/// Four lanes from above between pavements and lawn.
pub fn road(seed: u32, x: f64, y: f64, scale: f64) -> Color {
    let v = y / scale;
    let grain = octaves(seed ^ 1, x / 3.0, y / 3.0, 2) - 0.5;
    let out = (v - 0.5).abs();
    if out < 0.3 {
        let tar = octaves(seed ^ 2, x / 60.0, y / 14.0, 4);
        let patch = smoothstep(0.62, 0.66, octaves(seed ^ 3, x / 80.0, y / 30.0, 2));
        let track = 0.06 * smoothstep(0.35, 0.7, octaves(seed ^ 4, x / 300.0, y / 5.0, 2));
        let asphalt = shade([104.0, 104.0, 108.0], 0.76 + 0.4 * tar - 0.14 * patch + track + 0.4 * grain);
        let middle = (0.004..0.011).contains(&out);
        let dashes = (out - 0.15).abs() < 0.005 && (x / 46.0).rem_euclid(1.0) < 0.5;
        let border = (out - 0.285).abs() < 0.004;
        let paint = middle || dashes || border;
        return if paint { mix(asphalt, [224.0, 222.0, 212.0], 0.8) } else { asphalt };
    }
    if out < 0.38 {
        let joint = (x / 20.0).rem_euclid(1.0) < 0.06 || (y / 9.0).rem_euclid(1.0) < 0.1;
        let worn = 0.82 + 0.32 * octaves(seed ^ 5, x / 14.0, y / 14.0, 4) + 0.3 * grain;
        let slab = if joint { 0.8 } else { 1.0 };
        return shade([160.0, 154.0, 146.0], worn * if out < 0.31 { 1.15 } else { slab });
    }
    let field = octaves(seed ^ 6, x / 50.0, y / 40.0, 4);
    let grass = mix([66.0, 98.0, 42.0], [136.0, 154.0, 80.0], smoothstep(0.25, 0.75, field));
    shade(grass, 0.72 + 0.5 * octaves(seed ^ 7, x / 3.0, y / 4.0, 2))
}

/// A hall with shop windows along its far wall and a floor of polished tiles.
pub fn hall(seed: u32, x: f64, y: f64, scale: f64) -> Color {
    const SIGNS: [u32; 5] = [0x963C38, 0x3C5C84, 0xC4AC60, 0x4C7054, 0x464248];
    let v = y / scale;
    let grain = octaves(seed ^ 1, x / 3.0, y / 3.0, 2) - 0.5;
    if v < 0.38 {
        let shop = (x / 118.0).floor();
        let su = x / 118.0 - shop;
        let sign = pick(&SIGNS, seed ^ 2, shop as i32, 0);
        let letter = (0.055..0.1).contains(&v) && unit(seed ^ 4, (x / 7.0).floor() as i32, 1) < 0.6;
        return match () {
            _ if !(0.07..0.93).contains(&su) || !(0.04..=0.35).contains(&v) => {
                let stain = octaves(seed ^ 3, x / 30.0, y / 30.0, 3);
                shade([186.0, 178.0, 164.0], 0.74 + 0.36 * stain + 0.2 * grain)
            }
            _ if letter => [232.0, 228.0, 216.0],
            _ if v < 0.12 => shade(sign, 0.9 + 0.2 * grain),
            _ if (su - 0.5).abs() < 0.02 => [92.0, 92.0, 96.0],
            _ => {
                let goods = octaves(seed ^ 5, x / 10.0, y / 13.0, 3);
                let inside = mix([52.0, 50.0, 54.0], [206.0, 186.0, 150.0], smoothstep(0.35, 0.75, goods));
                mix(inside, sign, 0.25)
            }
        };
    }
    // Tiles grow towards the camera; a gloss below the windows.
    let depth = (v - 0.2) / 0.8;
    let (tu, tv) = ((x - 160.0) / (38.0 * depth) + 40.0, 7.0 / depth);
    let (i, j) = (tu.floor(), tv.floor());
    let joint = tu - i < 0.045 || tv - j < 0.05;
    let own = unit(seed ^ 6, i as i32, j as i32);
    let worn = octaves(seed ^ 7, x / 50.0, y / 24.0, 4);
    let tile = mix([158.0, 152.0, 144.0], [186.0, 180.0, 168.0], own);
    let gloss = 0.16 * smoothstep(0.6, 0.4, v) * octaves(seed ^ 8, x / 24.0, y / 90.0, 2);
    shade(tile, (0.72 + 0.4 * worn + gloss + 0.2 * grain) * if joint { 0.82 } else { 1.0 })
}
