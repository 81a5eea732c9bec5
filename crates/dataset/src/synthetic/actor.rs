//! Actors that move in a scene: people, faces, cars, motorcycles, balls, fish, and things to hide behind.
//!
//! Each actor is a function from a place in its box (`u` to the right, `v` downwards, 0 to 1) to a color. It
//! is a list of layers; the first that covers the place is seen.

use super::figures;
use super::motion::sin_cos;
use super::noise::{Color, ellipse, mix, octaves, pick, shade, smoothstep, unit};
use serde::Deserialize;

/// Kind of a drawn object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A walking person, twice to three times as high as wide.
    Person,
    /// A face; its pose is the yaw, -1 (left) to 1 (right).
    Face,
    /// A car from the side, about twice as wide as high.
    Car,
    /// A car from behind.
    Rear,
    /// A rider on a motorcycle, from the side.
    Rider,
    /// A ball with panels.
    Ball,
    /// A fish from the side, about twice as wide as high.
    Fish,
    /// A magazine: an opaque upright card.
    Card,
    /// A tree trunk or pillar.
    Post,
    /// A bush.
    Bush,
    /// A lorry's or hoarding's flat side.
    Hoarding,
    /// A head that turns about itself; its pose is the turn in cycles, 0 towards the camera.
    Head,
    /// Shoulders and body below a head.
    Shoulders,
    /// A car from above, about twice as long as wide.
    Roof,
    /// A plain wall or bridge deck.
    Wall,
}

impl Kind {
    /// Number of pictures that the range of poses is divided into.
    pub fn phases(self) -> usize {
        match self {
            Self::Person | Self::Fish => 8,
            Self::Face => 9,
            Self::Head => 24,
            _ => 1,
        }
    }

    /// Index of the picture that shows a pose: the phase of the stride (in cycles) for walkers and swimmers,
    /// the yaw for faces.
    pub fn phase_of(self, pose: f64) -> usize {
        if self == Self::Face {
            return ((pose.clamp(-1.0, 1.0) + 1.0) * 4.0).round() as usize;
        }
        let phases = self.phases();
        ((pose - pose.floor()) * phases as f64) as usize % phases
    }

    /// Color at `(u, v)` of the individual `look` in phase `phase`; `aspect` is width over height. `None`
    /// where it is transparent.
    pub fn paint(self, look: u32, phase: usize, aspect: f64, u: f64, v: f64) -> Option<Color> {
        let part = |whole: f64| phase as f64 / whole;
        match self {
            Self::Person => person(look, part(8.0), (u - 0.5) * aspect, v, aspect),
            Self::Face => face(look, part(4.0) - 1.0, u, v),
            Self::Car => car(look, u, v, aspect),
            Self::Rear => rear(look, u, v),
            Self::Rider => rider(look, u, v, aspect),
            Self::Ball => ball(look, u, v),
            Self::Fish => fish(look, part(8.0), u, v),
            Self::Card => card(look, u, v),
            Self::Post => post(look, u, v),
            Self::Bush => bush(look, u, v, aspect),
            Self::Hoarding => hoarding(look, u, v, aspect),
            Self::Head => figures::head(look, part(24.0), u, v),
            Self::Shoulders => figures::shoulders(look, u, v),
            Self::Roof => figures::roof(look, u, v),
            Self::Wall => figures::wall(look, u, v, aspect),
        }
    }
}

const CLOTHES: [u32; 10] =
    [0xB4282C, 0x243C78, 0xE2DED2, 0x286046, 0xD6A032, 0x343238, 0x784682, 0x5A82AA, 0x96785A, 0xCD6E78];
const SKIN: [u32; 4] = [0xE0B496, 0xC49472, 0x946446, 0xECC4A8];
const HAIR: [u32; 4] = [0x2C201A, 0x604024, 0xB4945A, 0x1E1C1E];
const PAINT: [u32; 7] = [0xAA2224, 0x284A8C, 0xCECECC, 0x32363A, 0x366E54, 0xC8A43C, 0x80868E];

/// Distance of `(x, y)` to the segment from `a` to `b`.
fn segment(x: f64, y: f64, a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let s = (((x - a.0) * dx + (y - a.1) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    let (ex, ey) = (x - a.0 - s * dx, y - a.1 - s * dy);
    (ex * ex + ey * ey).sqrt()
}

fn person(look: u32, phase: f64, x: f64, v: f64, aspect: f64) -> Option<Color> {
    const SHOE: Color = [36.0, 30.0, 28.0];
    let half = aspect / 2.0;
    let (skin, hair) = (pick(&SKIN, look, 1, 0), pick(&HAIR, look, 2, 0));
    let (shirt, trousers) = (pick(&CLOTHES, look, 3, 0), shade(pick(&CLOTHES, look, 4, 0), 0.6));
    let second = pick(&CLOTHES, look, 5, 0);
    let light = 1.0 - 0.5 * x / half;
    let cloth = 0.8 + 0.4 * octaves(look ^ 9, x * 40.0, v * 26.0, 3);
    let swing = sin_cos(phase).0;
    let stripes = unit(look, 6, 0) < 0.5 && (v * 22.0).rem_euclid(1.0) < 0.45 && v > 0.22;
    let bag = unit(look, 7, 0) < 0.6 && x < -0.03 && (0.22..0.4).contains(&v);
    let trunk = (0.17..0.54).contains(&v) && x.abs() < 0.09 + 0.035 * smoothstep(0.16, 0.22, v);
    let arm = |s: f64| segment(x, v, (0.0, 0.22), (s * half * 0.7, 0.5));
    let leg = |s: f64, dark: f64| {
        let foot = s * half * 0.66;
        let shoe = v > 0.945 && v < 0.985 && x > foot - 0.04 && x < foot + 0.07;
        let inside = segment(x, v, (0.0, 0.52), (foot, 0.955)) < 0.056 - 0.016 * smoothstep(0.6, 0.9, v);
        let color = if v > 0.93 { SHOE } else { trousers };
        if inside { Some(shade(color, light * dark * cloth)) } else { shoe.then_some(SHOE) }
    };
    // The arm and leg on this side lie over the body, those on the far side behind it.
    let legs = || leg(-swing, 1.0).or_else(|| leg(swing, 0.72));
    let far_arm =
        || (arm(-swing) < 0.032).then(|| shade(if v > 0.44 { skin } else { shirt }, 0.6 * light * cloth));
    Some(match () {
        _ if ellipse(x, v, 0.015, 0.085, 0.066, 0.077) < 1.0 => {
            let hairy = v < 0.06 || x < -0.02;
            shade(if hairy { hair } else { skin }, 0.85 * light + 0.1)
        }
        _ if x.abs() < 0.03 && (0.14..0.2).contains(&v) => shade(skin, 0.8),
        _ if arm(swing) < 0.034 => shade(if v > 0.44 { skin } else { shade(shirt, 0.82) }, light * cloth),
        _ if trunk && bag => shade(shade(second, 0.7), light * cloth),
        _ if trunk => shade(if stripes { second } else { shirt }, light * cloth),
        _ => return legs().or_else(far_arm),
    })
}

fn face(look: u32, yaw: f64, u: f64, v: f64) -> Option<Color> {
    let (skin, hair) = (pick(&SKIN, look, 1, 0), pick(&HAIR, look, 2, 0));
    let strand = 0.7 + 0.6 * octaves(look ^ 5, u * 30.0, v * 6.0, 3);
    if ellipse(u, v, 0.5, 0.55, 0.41, 0.44) > 1.0 {
        let cap = ellipse(u, v, 0.5, 0.46, 0.5, 0.46) < 1.0 && v < 0.74;
        return cap.then(|| shade(hair, strand));
    }
    // The features slide over the head as it turns, and the far side is squeezed.
    let middle = 0.5 + 0.16 * yaw;
    let glasses = unit(look, 8, 0) < 0.4;
    let eye = |side: f64| {
        let squeeze = 1.0 - 0.35 * (side * yaw).max(0.0);
        let (x, rx) = (middle + side * 0.18 * squeeze, 0.085 * squeeze);
        let shine = ellipse(u, v, x - 0.015, 0.478, 0.013, 0.011) < 1.0;
        let near = |y: f64, rx: f64, ry: f64| ellipse(u, v, x, y, rx, ry);
        Some(match () {
            _ if near(0.49, rx * 0.5, 0.036) < 1.0 && shine => [250.0; 3],
            _ if near(0.49, rx * 0.5, 0.036) < 1.0 => [44.0, 34.0, 30.0],
            _ if near(0.49, rx, 0.036) < 1.0 => [236.0, 232.0, 226.0],
            _ if near(0.425, rx * 1.25, 0.022) < 1.0 => shade(hair, 0.8),
            _ if glasses && (near(0.495, rx * 1.5, 0.078) - 1.0).abs() < 0.14 => [50.0, 44.0, 48.0],
            _ => return None,
        })
    };
    let light = 1.12 - 0.4 * u - 0.35 * yaw * (u - 0.5) - 0.12 * v;
    let pores = 0.95 + 0.1 * octaves(look ^ 7, u * 40.0, v * 40.0, 2);
    let nose = middle + 0.05 * yaw;
    let fringe = 0.3 - 0.06 * (u - middle).abs() + 0.03 * octaves(look ^ 6, u * 14.0, 0.0, 2);
    let mouth = ellipse(u, v, middle, 0.775, 0.135, 0.034) < 1.0;
    Some(match eye(-1.0).or_else(|| eye(1.0)) {
        _ if v < fringe => shade(hair, strand * 1.1),
        Some(part) => part,
        None if ellipse(u, v, nose, 0.645, 0.062, 0.026) < 1.0 => shade(skin, 0.72 * light),
        None if (0.5..0.65).contains(&v) && (u - nose - 0.02).abs() < 0.018 => shade(skin, 0.86 * light),
        None if mouth && (v - 0.775).abs() < 0.009 => [96.0, 40.0, 40.0],
        None if mouth => [186.0, 92.0, 88.0],
        None if unit(look, 9, 0) < 0.35 && v > 0.7 => shade(mix(skin, hair, 0.55), light * pores),
        None => {
            let cheek = 1.0 - smoothstep(0.3, 1.0, ellipse(u, v, middle + 0.2, 0.66, 0.1, 0.08));
            shade(mix(skin, [226.0, 130.0, 116.0], 0.3 * cheek), light * pores)
        }
    })
}

fn wheel(x: f64, y: f64, cx: f64, cy: f64, r: f64, cycles: f64) -> Option<Color> {
    let d = ellipse(x, y, cx, cy, r, r);
    // Spokes without arctangent: the sign of products of the two coordinates.
    let (a, b) = ((x - cx) / r, (y - cy) / r);
    let (s, c) = sin_cos(cycles);
    let (p, q) = (c * a + s * b, c * b - s * a);
    Some(match () {
        _ if d > 1.0 => return None,
        _ if d > 0.62 => [30.0, 30.0, 32.0],
        _ if p.abs() < 0.1 || q.abs() < 0.1 || d < 0.16 => [200.0, 200.0, 204.0],
        _ => [92.0, 92.0, 98.0],
    })
}

fn car(look: u32, u: f64, v: f64, aspect: f64) -> Option<Color> {
    let paint = pick(&PAINT, look, 1, 0);
    let x = u * aspect;
    let axles = [0.21 * aspect, 0.79 * aspect];
    let gloss = 0.8 + 0.35 * (1.0 - v) + 0.12 * octaves(look ^ 3, u * 9.0, v * 5.0, 3);
    // The cabin leans in towards the roof.
    let lean = 0.11 * (0.48 - v) / 0.42;
    let cabin = (0.06..0.5).contains(&v) && u > 0.2 + lean && u < 0.8 - 1.5 * lean;
    let post = (u - 0.5).abs() < 0.014 || u < 0.235 + lean || u > 0.765 - 1.5 * lean || v < 0.12;
    let nose = 0.04 * smoothstep(0.6, 0.44, v);
    let body = (0.44..0.84).contains(&v) && u > 0.015 + nose && u < 0.985 - 2.0 * nose;
    let door = (u - 0.5).abs() < 0.006 || (u - 0.3).abs() < 0.006 || (u - 0.7).abs() < 0.006;
    let handle = (v - 0.55).abs() < 0.015 && ((u - 0.45).abs() < 0.025 || (u - 0.65).abs() < 0.025);
    let stripe = unit(look, 2, 0) < 0.5 && (0.66..0.72).contains(&v);
    let side = if stripe { [230.0, 228.0, 220.0] } else { paint };
    Some(match axles.into_iter().find_map(|axle| wheel(x, v, axle, 0.8, 0.18, 0.06)) {
        Some(wheel) => wheel,
        None if cabin && !post && v < 0.46 => {
            let glare = smoothstep(0.45, 0.6, octaves(look ^ 4, u * 6.0 + v * 3.0, v * 2.0, 2));
            let head = ellipse(u, v, 0.4, 0.36, 0.035, 0.1) < 1.0;
            let glass = mix([44.0, 56.0, 66.0], [170.0, 186.0, 196.0], glare);
            if head { [90.0, 66.0, 54.0] } else { glass }
        }
        None if cabin => shade(paint, gloss),
        None if !body => return None,
        None if v > 0.8 || axles.iter().any(|&axle| ellipse(x, v, axle, 0.8, 0.22, 0.22) < 1.0) => {
            [28.0, 28.0, 30.0]
        }
        None if u > 0.93 && (0.52..0.62).contains(&v) => [250.0, 240.0, 190.0],
        None if u < 0.06 && (0.5..0.62).contains(&v) => [190.0, 30.0, 26.0],
        None if door => shade(side, 0.5),
        None if handle => shade(side, 0.35),
        None => shade(side, gloss * 0.95),
    })
}

fn rear(look: u32, u: f64, v: f64) -> Option<Color> {
    let paint = pick(&PAINT, look, 1, 0);
    let out = (u - 0.5).abs();
    let gloss = 0.78 + 0.3 * (1.0 - v) + 0.14 * octaves(look ^ 3, u * 6.0, v * 6.0, 3);
    let half = if v < 0.46 { 0.3 + 0.16 * smoothstep(0.02, 0.46, v) } else { 0.49 };
    let lamp = (0.48..0.6).contains(&v) && (0.36..0.47).contains(&out);
    let plate = (0.6..0.7).contains(&v) && out < 0.15;
    let letter = unit(look ^ 5, (u * 34.0).floor() as i32, 0) < 0.5 && (0.62..0.68).contains(&v);
    Some(match () {
        _ if v > 0.86 && (0.3..0.46).contains(&out) && v < 0.99 => [26.0, 26.0, 28.0],
        _ if v > 0.86 || out > half || v < 0.02 => return None,
        _ if (0.09..0.4).contains(&v) && out < half - 0.06 => {
            let glare = smoothstep(0.4, 0.62, octaves(look ^ 4, u * 4.0 + v * 3.0, v * 3.0, 2));
            let rest = ellipse(u, v, 0.36, 0.36, 0.07, 0.12).min(ellipse(u, v, 0.64, 0.36, 0.07, 0.12)) < 1.0;
            let glass = mix([36.0, 44.0, 54.0], [150.0, 168.0, 184.0], glare);
            if rest { [34.0, 32.0, 32.0] } else { glass }
        }
        _ if lamp && v < 0.54 => [206.0, 36.0, 30.0],
        _ if lamp => [236.0, 150.0, 60.0],
        _ if plate && letter => [40.0, 40.0, 46.0],
        _ if plate => [232.0, 230.0, 216.0],
        _ if v > 0.74 => shade([60.0, 60.0, 64.0], gloss),
        _ => shade(paint, if (v - 0.46).abs() < 0.012 { 0.55 } else { gloss }),
    })
}

fn rider(look: u32, u: f64, v: f64, aspect: f64) -> Option<Color> {
    let x = u * aspect;
    let at = |a: f64| a * aspect;
    let (paint, suit) = (pick(&PAINT, look, 1, 0), pick(&CLOTHES, look, 2, 0));
    let cloth = 0.8 + 0.4 * octaves(look ^ 3, u * 12.0, v * 12.0, 3);
    let limb = |a: (f64, f64), b: (f64, f64)| segment(x, v, (at(a.0), a.1), (at(b.0), b.1));
    let arm = limb((0.53, 0.28), (0.74, 0.44)) < 0.045;
    let thigh = limb((0.4, 0.52), (0.56, 0.62)) < 0.06;
    let tank = limb((0.3, 0.6), (0.66, 0.58)) < 0.07 || limb((0.66, 0.55), (0.76, 0.44)) < 0.05;
    let frame = limb((0.19, 0.79), (0.5, 0.74)) < 0.035 || limb((0.72, 0.5), (0.81, 0.79)) < 0.025;
    Some(match [0.19, 0.81].into_iter().find_map(|axle| wheel(x, v, at(axle), 0.79, 0.2, 0.1)) {
        _ if ellipse(x, v, at(0.56), 0.12, 0.105, 0.11) < 1.0 => {
            let visor = u > 0.58 && (0.09..0.16).contains(&v);
            if visor { [30.0, 34.0, 44.0] } else { shade(paint, 1.25 - v) }
        }
        _ if arm || thigh => shade(suit, 0.8 * cloth),
        _ if limb((0.56, 0.62), (0.48, 0.82)) < 0.05 => shade(suit, 0.62 * cloth),
        _ if limb((0.52, 0.26), (0.4, 0.5)) < 0.1 => {
            let number = ellipse(u, v, 0.45, 0.38, 0.05, 0.06) < 1.0;
            if number { [240.0; 3] } else { shade(suit, cloth) }
        }
        Some(wheel) => wheel,
        None if tank => shade(paint, 1.3 - v + 0.2 * cloth),
        None if frame => [150.0, 150.0, 156.0],
        None if ellipse(x, v, at(0.5), 0.74, 0.16, 0.1) < 1.0 => shade([84.0, 84.0, 90.0], cloth),
        None => return None,
    })
}

fn ball(look: u32, u: f64, v: f64) -> Option<Color> {
    let d = ellipse(u, v, 0.5, 0.5, 0.495, 0.495);
    let (a, b) = ((u - 0.5) * 2.0, (v - 0.5) * 2.0);
    let light = 1.1 - 0.45 * d * d - 0.2 * (a + b);
    let bulge = 1.0 + 0.5 * d * d;
    let (p, q) = (a * bulge + 0.35, b * bulge - 0.2);
    let seam = (p * 2.0).rem_euclid(1.0) < 0.1 || (q * 2.0).rem_euclid(1.0) < 0.1;
    let odd = ((p * 2.0).floor() + (q * 2.0).floor()).rem_euclid(2.0) > 0.5;
    let color = match () {
        _ if d > 1.0 => return None,
        _ if seam => [30.0, 28.0, 30.0],
        _ if odd => pick(&CLOTHES, look, 1, 0),
        _ => pick(&CLOTHES, look, 2, 1),
    };
    Some(shade(color, light * (0.9 + 0.2 * octaves(look ^ 3, u * 20.0, v * 20.0, 2))))
}

fn fish(look: u32, phase: f64, u: f64, v: f64) -> Option<Color> {
    let (base, stripe) = (pick(&CLOTHES, look, 1, 0), pick(&CLOTHES, look, 2, 1));
    // The body bends more towards the tail, which is on the left.
    let bend = 0.13 * (1.0 - u) * (1.0 - u) * sin_cos(phase + 0.4 * u).0;
    let w = v - bend;
    let body = ellipse(u, w, 0.58, 0.5, 0.41, 0.33) < 1.0;
    let tail = u < 0.26 && (w - 0.5).abs() < 0.1 + 1.35 * (0.26 - u).min(0.22);
    let fin = (0.4..0.68).contains(&u) && (0.04..0.3).contains(&w) && w > 0.04 + 0.9 * (u - 0.52).abs();
    let eye = body && ellipse(u, w, 0.85, 0.44, 0.035, 0.07) < 1.0;
    let light = 1.3 - 0.65 * w;
    let bars = (u * 6.0 + 0.4 * w).rem_euclid(1.0) < 0.4;
    Some(match () {
        _ if !(body || tail || fin) => return None,
        _ if eye && ellipse(u, w, 0.855, 0.44, 0.017, 0.035) < 1.0 => [20.0; 3],
        _ if eye => [240.0; 3],
        _ => {
            let gill = body && (ellipse(u, w, 0.86, 0.5, 0.14, 0.3) - 1.0).abs() < 0.07 && u < 0.8;
            let scales = 0.85 + 0.3 * octaves(look ^ 3, u * 26.0, w * 13.0, 2);
            shade(if bars || !body { stripe } else { base }, light * scales * if gill { 0.55 } else { 1.0 })
        }
    })
}

fn card(look: u32, u: f64, v: f64) -> Option<Color> {
    let (paper, ink) = (pick(&PAINT, look, 1, 0), pick(&CLOTHES, look, 2, 0));
    let grain = 0.85 + 0.3 * octaves(look ^ 3, u * 12.0, v * 12.0, 3);
    let letter = (0.06..0.19).contains(&v) && unit(look ^ 4, (u * 14.0).floor() as i32, 0) < 0.6;
    let line = (v * 24.0).rem_euclid(1.0) < 0.4 && unit(look ^ 6, (u * 24.0) as i32, (v * 24.0) as i32) < 0.7;
    Some(match () {
        _ if v < 0.24 => shade(if letter { [240.0; 3] } else { ink }, grain),
        _ if (0.1..0.62).contains(&u) && (0.32..0.76).contains(&v) => {
            let land = octaves(look ^ 5, u * 7.0, v * 7.0, 4);
            mix([40.0, 60.0, 50.0], [230.0, 200.0, 150.0], smoothstep(0.3, 0.7, land))
        }
        _ => shade(paper, grain * if line { 0.4 } else { 1.05 }),
    })
}

fn post(look: u32, u: f64, v: f64) -> Option<Color> {
    let bark = octaves(look, u * 5.0, v * 18.0, 4);
    let side = 1.0 - 2.2 * (u - 0.42) * (u - 0.42);
    let knot = smoothstep(0.7, 0.8, octaves(look ^ 2, u * 3.0, v * 9.0, 2));
    let base = if unit(look, 1, 0) < 0.5 { [118.0, 92.0, 66.0] } else { [150.0, 150.0, 146.0] };
    Some(shade(base, side * (0.55 + 0.8 * bark) * (1.0 - 0.5 * knot)))
}

fn bush(look: u32, u: f64, v: f64, aspect: f64) -> Option<Color> {
    let rough = 0.35 * (octaves(look, u * 7.0 * aspect, v * 7.0, 3) - 0.5);
    let leaf = octaves(look ^ 2, u * 26.0 * aspect, v * 26.0, 3);
    let clump = octaves(look ^ 3, u * 6.0 * aspect, v * 6.0, 3);
    let green = mix([22.0, 50.0, 20.0], [120.0, 150.0, 66.0], smoothstep(0.25, 0.8, leaf));
    let inside = ellipse(u, v, 0.5, 0.56, 0.48, 0.5) + rough <= 0.98;
    inside.then(|| shade(green, 0.45 + 1.0 * clump))
}

fn hoarding(look: u32, u: f64, v: f64, aspect: f64) -> Option<Color> {
    let (base, ink) = (pick(&PAINT, look, 1, 0), pick(&CLOTHES, look, 2, 0));
    let dirt = 0.75 + 0.4 * octaves(look ^ 3, u * 6.0 * aspect, v * 8.0, 4);
    let rib = (u * aspect * 9.0).rem_euclid(1.0) < 0.12 || !(0.04..0.96).contains(&v);
    let letter = (0.3..0.56).contains(&v)
        && unit(look ^ 4, (u * aspect * 5.0).floor() as i32, (v * 11.0).floor() as i32) < 0.6;
    Some(shade(if letter { ink } else { base }, dirt * if rib { 0.6 } else { 1.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_are_in_range() {
        for kind in [Kind::Person, Kind::Face, Kind::Fish, Kind::Head, Kind::Card] {
            for k in -40..40 {
                assert!(kind.phase_of(f64::from(k) / 7.0) < kind.phases());
            }
        }
        assert_eq!([-1.0, 0.0, 1.0].map(|way| Kind::Face.phase_of(way)), [0, 4, 8]);
    }
}
