//! Division of the target into fragments.

/// A fragment: left, top, right and bottom edge in pixels from the center of the target.
pub type Fragment = [f64; 4];

/// The fragments of a target of `w` by `h` pixels, at least one, all inside it: the two families of FragTrack, flat
/// strips of about a tenth of the height and half the width, and upright ones.
pub fn fragments(w: f64, h: f64) -> Vec<Fragment> {
    let upright = strips(h, w).into_iter().map(|[l, t, r, b]| [t, l, b, r]);
    strips(w, h).into_iter().chain(upright).collect()
}

/// Flat strips of FragTrack: half height `max(1, floor(0.05 h + 0.5))`, half width `max(1, floor(0.25 w))`.
/// Centers are a strip's height apart, from the top; there are two side by side, at `floor(w / 4)` from the
/// middle.
fn strips(w: f64, h: f64) -> Vec<Fragment> {
    let (half_w, half_h) = ((0.25 * w).floor().max(1.0), (0.05 * h + 0.5).floor().max(1.0));
    // Centers that keep the strip inside; of a target smaller than the strip, its middle.
    let (reach_x, reach_y) = ((w / 2.0 - half_w).max(0.0), (h / 2.0 - half_h).max(0.0));
    let dx = (w / 4.0).floor().min(reach_x);
    // At most 20 by the half height above, but for rounding.
    let levels = (reach_y / half_h).floor().min(64.0) as u32 + 1;
    let across = |x: f64| x.clamp(-w / 2.0, w / 2.0);
    let down = |y: f64| y.clamp(-h / 2.0, h / 2.0);
    let mut all = Vec::new();
    for level in 0..levels {
        let y = f64::from(level) * 2.0 * half_h - reach_y;
        for x in [-dx, dx] {
            all.push([across(x - half_w), down(y - half_h), across(x + half_w), down(y + half_h)]);
        }
    }
    all
}
