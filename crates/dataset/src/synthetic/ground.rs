//! Backgrounds: one large picture per sequence, over which the camera scrolls.

use super::noise::{Color, byte, hash, lerp, mix, octaves, pick, shade, smoothstep, unit, value};
use serde::Deserialize;

/// Background of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ground {
    /// Houses, a pavement and a road.
    Street,
    /// A meadow with a hedge and a path.
    Meadow,
    /// A brick wall over a pavement.
    Bricks,
    /// A room with wallpaper, shelves, a picture and a desk.
    Room,
    /// Water with waves and foam.
    Water,
    /// A paved square seen from above.
    Plaza,
    /// A road of four lanes seen from above.
    Road,
    /// A hall with shop windows and a tiled floor.
    Hall,
}

/// A painted background; pixel `(0, 0)` is the world's `(left, top)`.
pub struct Picture {
    left: i64,
    top: i64,
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

impl Picture {
    /// Paints `width` x `height` pixels of the world from `(left, top)`. Heights in the scenery are fractions
    /// of `scale`, the height of the frame.
    pub fn paint(
        ground: Ground,
        seed: u32,
        left: i64,
        top: i64,
        width: usize,
        height: usize,
        scale: f64,
    ) -> Self {
        let mut rgb = Vec::with_capacity(3 * width * height);
        for j in 0..height {
            for i in 0..width {
                let x = (left + i as i64) as f64 + 0.5;
                let y = (top + j as i64) as f64 + 0.5;
                let c = match ground {
                    Ground::Street => street(seed, x, y, scale),
                    Ground::Meadow => meadow(seed, x, y, scale),
                    Ground::Bricks => bricks(seed, x, y, scale),
                    Ground::Room => room(seed, x, y, scale),
                    Ground::Water => water(seed, x, y),
                    Ground::Plaza => plaza(seed, x, y),
                    Ground::Road => road(seed, x, y, scale),
                    Ground::Hall => hall(seed, x, y, scale),
                };
                rgb.extend(c.map(byte));
            }
        }
        Self { left, top, width, height, rgb }
    }

    /// Writes the view from world place `(x, y)`, the left top corner of the frame to 1/256 pixel, into
    /// `out`, `width` pixels per row. Beyond the picture its border is repeated.
    pub fn view(&self, x: f64, y: f64, width: usize, out: &mut [u8]) {
        let fixed = |v: f64| (v * 256.0).round() as i64;
        let room = |len: usize, need: usize| len.saturating_sub(need + 1) as i64 * 256;
        let height = out.len() / (3 * width);
        let fx = fixed(x - self.left as f64).clamp(0, room(self.width, width));
        let fy = fixed(y - self.top as f64).clamp(0, room(self.height, height));
        let (ix, iy) = ((fx >> 8) as usize, (fy >> 8) as usize);
        let (wx, wy) = ((fx & 255) as u32, (fy & 255) as u32);
        for (j, row) in out.chunks_exact_mut(3 * width).enumerate() {
            let start = 3 * ((iy + j) * self.width + ix);
            let a = &self.rgb[start..start + 3 * width + 3];
            let b = &self.rgb[start + 3 * self.width..start + 3 * self.width + 3 * width + 3];
            if wx == 0 && wy == 0 {
                row.copy_from_slice(&a[..3 * width]);
                continue;
            }
            for (i, o) in row.iter_mut().enumerate() {
                let top = u32::from(a[i]) * (256 - wx) + u32::from(a[i + 3]) * wx;
                let bottom = u32::from(b[i]) * (256 - wx) + u32::from(b[i + 3]) * wx;
                *o = ((top * (256 - wy) + bottom * wy + 32_768) >> 16) as u8;
            }
        }
    }
}

const PLASTER: [u32; 6] = [0xC4B08C, 0xAA6E54, 0xBCBCB4, 0x968E7A, 0xCEC4A0, 0x847876];
const SPINES: [u32; 7] = [0x962828, 0x284678, 0x3C6446, 0xC8AA5A, 0x5A3C64, 0xBEBEBA, 0x3C3C42];

fn street(seed: u32, x: f64, y: f64, scale: f64) -> Color {
    let v = y / scale;
    let grain = octaves(seed ^ 1, x / 3.0, y / 3.0, 2) - 0.5;
    if v < 0.55 {
        // Houses, 70 to 120 pixels wide, with a roof line of their own.
        let cell = (x / 95.0 + 0.25 * value(seed ^ 2, x / 300.0, 0.0)).floor() as i32;
        let roof = 0.02 + 0.14 * unit(seed ^ 3, cell, 0);
        let (wx, wy) = (x / 23.0, (v - roof) * scale / 27.0);
        let (wi, wj) = (wx.floor(), wy.floor());
        let (fu, fv) = (wx - wi, wy - wj);
        let window = (0.25..0.75).contains(&fu) && (0.25..0.8).contains(&fv);
        let frame = (fu - 0.5).abs() > 0.21 || (fu - 0.5).abs() < 0.025 || !(0.3..0.75).contains(&fv);
        return match () {
            _ if v < roof => {
                let cloud = octaves(seed ^ 4, x / 80.0, y / 30.0, 4);
                mix([140.0, 170.0, 205.0], [232.0, 234.0, 236.0], smoothstep(0.35, 0.75, cloud))
            }
            _ if window && frame => [224.0, 220.0, 210.0],
            _ if window => {
                let lit = unit(seed ^ 7, wi as i32, wj as i32);
                mix([40.0, 50.0, 64.0], [150.0, 160.0, 168.0], lit * (1.2 - fv))
            }
            _ => {
                let stain = octaves(seed ^ 5, x / 24.0, y / 40.0, 4);
                let plaster = shade(pick(&PLASTER, seed ^ 6, cell, 1), 0.72 + 0.5 * stain);
                shade(plaster, 1.0 + 0.25 * grain)
            }
        };
    }
    if v < 0.64 {
        // Pavement slabs and kerb.
        let joint = (x / 22.0).fract().abs() < 0.06 || (y / 9.0).fract().abs() < 0.1;
        let slab = shade([158.0, 154.0, 148.0], 0.85 + 0.3 * octaves(seed ^ 8, x / 12.0, y / 12.0, 4));
        return match () {
            _ if v > 0.628 => shade(slab, 1.2),
            _ if joint => shade(slab, 0.78),
            _ => shade(slab, 1.0 + 0.3 * grain),
        };
    }
    let tar = octaves(seed ^ 9, x / 40.0, y / 18.0, 4);
    let line = (0.795..0.812).contains(&v) && (x / 56.0).rem_euclid(1.0) < 0.55;
    let patch = smoothstep(0.6, 0.66, octaves(seed ^ 10, x / 70.0, y / 25.0, 2));
    let asphalt = shade([98.0, 98.0, 102.0], 0.72 + 0.5 * tar - 0.2 * patch + 0.5 * grain);
    if line { mix(asphalt, [226.0, 224.0, 214.0], 0.85) } else { asphalt }
}

fn meadow(seed: u32, x: f64, y: f64, scale: f64) -> Color {
    let v = y / scale;
    let hedge = 0.24 + 0.08 * octaves(seed ^ 1, x / 36.0, 0.0, 3);
    let leaves = octaves(seed ^ 2, x / 9.0, y / 8.0, 4);
    if v < hedge {
        let tree = octaves(seed ^ 3, x / 34.0, y / 34.0, 3);
        let dark = mix([26.0, 48.0, 22.0], [96.0, 128.0, 58.0], smoothstep(0.2, 0.8, leaves));
        return shade(dark, 0.6 + 0.8 * tree);
    }
    let tuft = octaves(seed ^ 4, x / 2.5, y / 7.0, 2);
    let field = octaves(seed ^ 5, x / 60.0, y / 28.0, 4);
    let grass = mix([70.0, 104.0, 40.0], [150.0, 170.0, 84.0], smoothstep(0.25, 0.75, field));
    let grass = shade(grass, 0.7 + 0.6 * tuft);
    let middle = 0.66 + 0.06 * value(seed ^ 6, x / 90.0, 0.0);
    let path = 1.0 - smoothstep(0.045, 0.06, (v - middle).abs() + 0.02 * leaves);
    let gravel = shade([186.0, 166.0, 130.0], 0.75 + 0.5 * octaves(seed ^ 7, x / 4.0, y / 4.0, 3));
    let flower = hash(seed ^ 8, (x / 3.0).floor() as i32, (y / 3.0).floor() as i32).is_multiple_of(130);
    if flower && path < 0.5 { [232.0, 226.0, 150.0] } else { mix(grass, gravel, path) }
}

fn bricks(seed: u32, x: f64, y: f64, scale: f64) -> Color {
    let v = y / scale;
    let grain = octaves(seed ^ 1, x / 3.0, y / 3.0, 3);
    if v > 0.84 {
        let joint = (x / 30.0).rem_euclid(1.0) < 0.04;
        return shade([140.0, 138.0, 132.0], (0.7 + 0.6 * grain) * if joint { 0.7 } else { 1.0 });
    }
    let row = (y / 9.0).floor();
    let along = x / 21.0 + 0.5 * row.rem_euclid(2.0);
    let (fu, fv) = (along - along.floor(), y / 9.0 - row);
    let weather = octaves(seed ^ 2, x / 55.0, y / 45.0, 4);
    // A poster here and there gives the wall places of its own.
    let (bay, pu) = ((x / 140.0).floor() as i32, (x / 140.0).rem_euclid(1.0));
    match () {
        _ if fu < 0.07 || fv < 0.15 => shade([160.0, 132.0, 112.0], 0.6 + 0.4 * grain + 0.3 * weather),
        _ if unit(seed ^ 4, bay, 0) < 0.6 && (0.3..0.62).contains(&pu) && (0.2..0.6).contains(&v) => {
            let letter = unit(seed ^ 6, (x / 4.0).floor() as i32, (y / 6.0).floor() as i32) < 0.6;
            let text = v > 0.3 && (y / 6.0).rem_euclid(1.0) < 0.5 && letter;
            shade(pick(&PLASTER, seed ^ 5, bay, 3), if text { 0.6 } else { 0.9 + 0.25 * grain })
        }
        _ => {
            let own = unit(seed ^ 3, along.floor() as i32, row as i32);
            let brick = mix([140.0, 74.0, 54.0], [172.0, 100.0, 72.0], own);
            shade(brick, 0.6 + 0.4 * grain + 0.4 * weather)
        }
    }
}

fn room(seed: u32, x: f64, y: f64, scale: f64) -> Color {
    let v = y / scale;
    let grain = octaves(seed ^ 1, x / 4.0, y / 4.0, 2);
    if v > 0.82 {
        // Desk with wood grain and papers.
        let (sheet, su) = ((x / 64.0).floor() as i32, x / 64.0 - (x / 64.0).floor());
        let paper = unit(seed ^ 3, sheet, 0) < 0.5 && (0.2..0.7).contains(&su) && (0.87..0.95).contains(&v);
        return match () {
            _ if paper && (y / 4.0).rem_euclid(1.0) < 0.35 => shade([226.0, 224.0, 216.0], 0.75),
            _ if paper => [226.0, 224.0, 216.0],
            _ => shade([150.0, 104.0, 62.0], 0.65 + 0.7 * octaves(seed ^ 2, x / 70.0, y / 5.0, 4)),
        };
    }
    let (bay, bu) = ((x / 150.0).floor() as i32, x / 150.0 - (x / 150.0).floor());
    let has_shelf = !hash(seed ^ 5, bay, 0).is_multiple_of(3);
    if has_shelf && (0.1..0.62).contains(&bu) && (0.08..0.74).contains(&v) {
        // A shelf: boards and book spines.
        let shelf = ((v - 0.08) / 0.165).floor();
        let sv = (v - 0.08) / 0.165 - shelf;
        let book = (x / 7.0).floor();
        let bx = x / 7.0 - book;
        let own = unit(seed ^ 7, book as i32, shelf as i32);
        let label = (0.55..0.68).contains(&sv) && (0.2..0.8).contains(&bx) && own > 0.4;
        return match () {
            _ if sv > 0.88 || !(0.115..0.605).contains(&bu) => {
                shade([104.0, 70.0, 44.0], 0.7 + 0.6 * octaves(seed ^ 6, x / 30.0, y / 3.0, 3))
            }
            _ if sv < 0.1 + 0.35 * own => shade([54.0, 42.0, 34.0], 0.7 + 0.5 * grain),
            _ => {
                let spine = pick(&SPINES, seed ^ 8, book as i32, shelf as i32);
                let round = 1.05 - 1.3 * (bx - 0.5) * (bx - 0.5);
                shade(if label { [224.0, 212.0, 170.0] } else { spine }, round * (0.8 + 0.3 * grain))
            }
        };
    }
    let has_picture = hash(seed ^ 9, bay, 0).is_multiple_of(2);
    if has_picture && (0.7..0.93).contains(&bu) && (0.16..0.5).contains(&v) {
        let edge = !(0.72..0.91).contains(&bu) || !(0.19..0.47).contains(&v);
        let land = octaves(seed ^ 10, x / 12.0, y / 7.0, 4);
        let picture = mix([70.0, 100.0, 130.0], [200.0, 180.0, 110.0], smoothstep(0.3, 0.7, land + v - 0.33));
        return if edge { [78.0, 54.0, 34.0] } else { picture };
    }
    let paper = octaves(seed ^ 4, x / 90.0, y / 70.0, 3);
    let stripe = if (x / 11.0).rem_euclid(1.0) < 0.5 { 0.94 } else { 1.02 };
    shade([196.0, 186.0, 166.0], (0.75 + 0.4 * paper) * stripe * (0.94 + 0.12 * grain))
}

fn water(seed: u32, x: f64, y: f64) -> Color {
    let bend = 14.0 * octaves(seed ^ 1, x / 60.0, y / 24.0, 3);
    let swell = octaves(seed ^ 2, (x + bend) / 70.0, (y + bend) / 14.0, 4);
    let ripple = octaves(seed ^ 3, (x + bend) / 13.0, (y + bend) / 4.0, 3);
    let base =
        mix([30.0, 66.0, 88.0], [104.0, 150.0, 164.0], smoothstep(0.2, 0.8, lerp(swell, ripple, 0.35)));
    let crest = smoothstep(0.6, 0.72, swell) * smoothstep(0.4, 0.65, ripple);
    mix(base, [228.0, 236.0, 236.0], 0.85 * crest)
}

fn plaza(seed: u32, x: f64, y: f64) -> Color {
    let row = (y / 17.0).floor();
    let along = x / 27.0 + unit(seed ^ 1, row as i32, 0);
    let (fu, fv) = (along - along.floor(), y / 17.0 - row);
    let grain = octaves(seed ^ 2, x / 4.0, y / 4.0, 3);
    let worn = octaves(seed ^ 3, x / 60.0, y / 60.0, 4);
    if fu < 0.05 || fv < 0.08 {
        return shade([112.0, 106.0, 98.0], 0.7 + 0.5 * grain);
    }
    let own = unit(seed ^ 4, along.floor() as i32, row as i32);
    let stone = mix([146.0, 138.0, 128.0], [176.0, 164.0, 146.0], own);
    let leaf = octaves(seed ^ 5, x / 5.0, y / 5.0, 2) + 0.25 * (worn - 0.5);
    let stone = shade(stone, 0.62 + 0.35 * grain + 0.35 * worn);
    mix(stone, [150.0, 96.0, 40.0], 0.8 * smoothstep(0.72, 0.78, leaf))
}

/// Four lanes from above between pavements and lawn.
fn road(seed: u32, x: f64, y: f64, scale: f64) -> Color {
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
fn hall(seed: u32, x: f64, y: f64, scale: f64) -> Color {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_pixel_views_are_crops() {
        let p = Picture::paint(Ground::Street, 5, -7, -3, 40, 30, 24.0);
        let mut out = vec![0; 3 * 12 * 8];
        p.view(-2.0, 4.0, 12, &mut out);
        for (j, row) in out.chunks_exact(36).enumerate() {
            let start = 3 * ((j + 7) * 40 + 5);
            assert_eq!(row, &p.rgb[start..start + 36]);
        }
    }

    #[test]
    fn half_way_is_the_mean() {
        let p = Picture { left: 0, top: 0, width: 3, height: 2, rgb: (0..18).map(|v| v * 10).collect() };
        let mut out = vec![0; 3];
        p.view(0.5, 0.0, 1, &mut out);
        assert_eq!(out, [15, 25, 35]);
    }
}
