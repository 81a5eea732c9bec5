//! Axes: ranges, ticks, and the frame around a plot.

use super::error::FigureError;
use super::font;
use super::scene::{Anchor, Area, Point, Scene, Stroke};
use super::style::{Dash, INK, SMALL, SOFT};

/// Length of a tick mark, in units.
const TICK: f64 = 3.5;
/// Maximum absolute value that is drawn; larger ones would overflow the arithmetic of ranges.
const MAX_VALUE: f64 = 1e100;

/// Which values an axis shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// All finite values; the ends are ticks.
    Auto,
    /// From 0, and all finite values; the ends are ticks.
    FromZero,
    /// Between these two; lines are cut off outside.
    Fixed(f64, f64),
}

impl Range {
    /// Lower and upper end for the values on an axis of about `max` ticks; `log` axes take only values above 0.
    ///
    /// # Errors
    /// [`FigureError::Range`] for a fixed range whose ends are not finite, not in order, or not above 0 where `log`.
    pub fn resolve(
        self,
        values: impl Iterator<Item = f64>,
        log: bool,
        max: usize,
    ) -> Result<(f64, f64), FigureError> {
        let (mut lo, mut hi) = values
            .filter(|v| usable(*v) && (!log || *v > 0.0))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        if lo > hi {
            (lo, hi) = if log { (0.1, 1.0) } else { (0.0, 1.0) };
        }
        match self {
            Self::Fixed(from, to) => {
                let good = usable(from) && usable(to) && from < to && (!log || from > 0.0);
                return if good { Ok((from, to)) } else { Err(FigureError::Range { from, to }) };
            }
            Self::FromZero if !log => (lo, hi) = (lo.min(0.0), hi.max(0.0)),
            Self::FromZero | Self::Auto => {}
        }
        if lo == hi {
            let room = if lo == 0.0 { 1.0 } else { lo.abs() * 0.2 };
            (lo, hi) = (lo - room, hi + room);
        }
        Ok(enclosed(lo, hi, log, max))
    }
}

/// The nearest ticks that enclose a range, so that what is highest can be read off; a logarithmic axis of a decade and
/// more ends at powers of ten.
fn enclosed(lo: f64, hi: f64, log: bool, max: usize) -> (f64, f64) {
    if log && (hi / lo).log10() >= 1.0 {
        let power = |v: f64| 10.0_f64.powf(v);
        let (below, above) = (power((lo.log10() + 1e-9).floor()), power((hi.log10() - 1e-9).ceil()));
        return if below > 0.0 && usable(above) { (below.min(lo), above.max(hi)) } else { (lo, hi) };
    }
    let (mut from, mut to) = (lo, hi);
    // The wider range may have wider steps, whose ticks lie farther out again.
    for _ in 0..3 {
        let step = linear_step(from, to, max);
        let (below, above) = ((lo / step + 1e-6).floor() * step, (hi / step - 1e-6).ceil() * step);
        if !step.is_normal() || !usable(below) || !usable(above) || (log && below <= 0.0) {
            return (lo, hi);
        }
        if (below, above) == (from, to) {
            break;
        }
        (from, to) = (below, above);
    }
    (from.min(lo), to.max(hi))
}

/// Whether a value can be drawn.
pub fn usable(v: f64) -> bool {
    v.abs() <= MAX_VALUE
}

/// A map from values to places on the page.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    lo: f64,
    hi: f64,
    from: f64,
    to: f64,
    log: bool,
    whole: bool,
}

impl Axis {
    /// Maps `lo..=hi` to the places `from..=to`, `room` points inside at both ends.
    pub fn new((lo, hi): (f64, f64), (from, to): (f64, f64), room: f64, log: bool) -> Self {
        let room = if to < from { -room } else { room };
        Self { lo, hi, from: from + room, to: to - room, log, whole: false }
    }

    /// The same axis with ticks at whole numbers only: frames.
    pub fn whole(self) -> Self {
        Self { whole: true, ..self }
    }

    /// Lower and upper end.
    pub fn ends(&self) -> (f64, f64) {
        (self.lo, self.hi)
    }

    /// The place of a value. Values far outside stay near the page, so that clipping is exact.
    pub fn place(&self, v: f64) -> f64 {
        let share = if self.log {
            (v.max(1e-300).ln() - self.lo.ln()) / (self.hi.ln() - self.lo.ln())
        } else {
            (v - self.lo) / (self.hi - self.lo)
        };
        self.from + share.clamp(-1e4, 1e4) * (self.to - self.from)
    }

    /// Ticks with their labels, about `max` at most.
    pub fn ticks(&self, max: usize) -> Vec<(f64, String)> {
        if self.log {
            return log_ticks(self.lo, self.hi, max);
        }
        let ticks = linear_ticks(self.lo, self.hi, max);
        if !self.whole {
            return ticks;
        }
        let whole =
            ticks.iter().map(|t| t.0.round()).filter(|v| ticks.iter().any(|t| (t.0 - v).abs() < 1e-6));
        let mut whole: Vec<f64> = whole.collect();
        whole.dedup();
        whole.into_iter().map(|v| (v, format!("{v:.0}"))).collect()
    }
}

/// The distance of ticks for `lo..=hi`: 1, 2 or 5 times a power of ten.
fn linear_step(lo: f64, hi: f64, max: usize) -> f64 {
    let raw = (hi - lo) / max.max(1) as f64;
    let power = 10.0_f64.powf(raw.log10().floor());
    let steps = [10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1].map(|m| m * power);
    // The largest step that is not too dense, or a smaller one where that leaves fewer than two ticks.
    let inside = |step: f64| (hi / step + 1e-6).floor() - (lo / step - 1e-6).ceil() + 1.0;
    let coarse = steps.iter().rposition(|s| *s >= raw * 0.999_999).unwrap_or(0);
    steps[coarse..].iter().copied().find(|s| inside(*s) >= 2.0).unwrap_or(power * 0.1)
}

/// Multiples of 1, 2 or 5 times a power of ten inside `lo..=hi`.
fn linear_ticks(lo: f64, hi: f64, max: usize) -> Vec<(f64, String)> {
    let step = linear_step(lo, hi, max);
    let slack = step * 1e-6;
    let first = (lo / step - 1e-6).ceil();
    // A range as narrow as neighboring floats has one tick, at its lower end.
    if !first.is_finite() || lo + step == lo {
        return vec![(lo, number(lo, lo.abs()))];
    }
    (0..=max + 4)
        .map(|k| (first + k as f64) * step)
        .filter(|v| *v <= hi + slack)
        .map(|v| (v, number(v, step)))
        .collect()
}

/// Powers of ten inside `lo..=hi`, with 2 and 5 times them where there is room.
fn log_ticks(lo: f64, hi: f64, max: usize) -> Vec<(f64, String)> {
    let decades = (hi / lo).log10();
    if decades < 1.0 {
        return linear_ticks(lo, hi, max);
    }
    let every = (decades / max.max(1) as f64).ceil().max(1.0) as i32;
    let parts: &[f64] = if decades * 3.0 <= max as f64 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let (first, last) = (lo.log10().floor() as i32, hi.log10().ceil() as i32);
    (first..=last)
        .filter(|d| d.rem_euclid(every) == 0)
        .flat_map(|d| parts.iter().map(move |m| m * 10.0_f64.powi(d)))
        .filter(|v| (lo * 0.999_999..=hi * 1.000_001).contains(v))
        .map(|v| (v, number(v, v)))
        .collect()
}

/// A tick's label with just the digits that distinguish it from its neighbors `step` away.
pub fn number(v: f64, step: f64) -> String {
    let v = if v.abs() < step.abs() * 1e-6 { 0.0 } else { v };
    let size = v.abs().max(step.abs());
    let digits = if step > 0.0 { -(step * 1.000_001).log10().floor() } else { 0.0 };
    let text = if v == 0.0 && (size >= 1e6 || digits > 6.0) {
        "0".to_owned()
    } else if size >= 1e6 || digits > 6.0 {
        let significant = (v.abs().log10().floor() + digits).clamp(0.0, 9.0) as usize;
        format!("{v:.significant$e}")
    } else {
        format!("{v:.*}", digits.clamp(0.0, 6.0) as usize)
    };
    text.replace('-', "\u{2212}")
}

/// Width of the widest label.
pub fn label_width(ticks: &[(f64, String)]) -> f64 {
    ticks.iter().map(|t| font::width(&t.1, SMALL)).fold(0.0, f64::max)
}

/// Which labels a frame has beside its ticks.
#[derive(Debug, Clone, Copy)]
pub struct Labelled {
    /// Below it.
    pub x: bool,
    /// On its left.
    pub y: bool,
}

/// Draws the frame of a plot with ticks; labels stand left and below.
pub fn frame(scene: &mut Scene, area: &Area, x: &Axis, y: &Axis, labels: Labelled) {
    let rows = y.ticks(max_ticks_y(area.h));
    frame_of_rows(scene, area, x, y, &rows, labels);
}

/// The same with given ticks on the vertical axis, such as the names of rows.
pub fn frame_of_rows(
    scene: &mut Scene,
    area: &Area,
    x: &Axis,
    y: &Axis,
    rows: &[(f64, String)],
    labels: Labelled,
) {
    let stroke = Stroke { rgb: SOFT, width: 0.8, dash: Dash::Solid };
    let (l, t, r, b) = (area.x, area.y, area.right(), area.bottom());
    scene.line(vec![(l, t), (l, b), (r, b)], stroke);
    let inside = |at: f64, from: f64, to: f64| (from - 0.01..=to + 0.01).contains(&at);
    for (v, text) in rows {
        let at = y.place(*v);
        if inside(at, t, b) {
            scene.line(vec![(l - TICK, at), (l, at)], stroke);
            if labels.y {
                scene.text(text, (l - TICK - 3.0, at), SMALL, Anchor::End, INK);
            }
        }
    }
    let ticks = x.ticks(max_ticks_x(area.w));
    let mut free = f64::NEG_INFINITY;
    for (v, text) in &ticks {
        let at = x.place(*v);
        if !inside(at, l, r) {
            continue;
        }
        scene.line(vec![(at, b), (at, b + TICK)], stroke);
        let half = font::width(text, SMALL) / 2.0;
        if labels.x && at - half >= free {
            let at = at.min(scene.width - half - 1.0);
            scene.text(text, (at, b + TICK + 8.5), SMALL, Anchor::Middle, INK);
            free = at + half + 5.0;
        }
    }
}

/// Number of ticks a vertical axis of this length takes.
pub fn max_ticks_y(length: f64) -> usize {
    ((length / 26.0) as usize).clamp(2, 8)
}

/// Number of ticks a horizontal axis of this length takes.
pub fn max_ticks_x(length: f64) -> usize {
    ((length / 44.0) as usize).clamp(4, 12)
}

/// A polyline without the points that cannot be seen: of those within a quarter unit across, the first, lowest, highest
/// and last are kept.
pub fn thinned(points: &[Point]) -> Vec<Point> {
    let column = |p: &Point| (p.0 * 4.0).floor();
    let mut out: Vec<Point> = Vec::new();
    for chunk in points.chunk_by(|a, b| column(a) == column(b)) {
        if chunk.len() <= 4 {
            out.extend_from_slice(chunk);
            continue;
        }
        let last = chunk.len() - 1;
        let by_height = |a: &usize, b: &usize| chunk[*a].1.total_cmp(&chunk[*b].1);
        let low = (0..=last).min_by(by_height).unwrap_or(0);
        let high = (0..=last).max_by(by_height).unwrap_or(0);
        let mut keep = vec![0, low, high, last];
        keep.sort_unstable();
        keep.dedup();
        out.extend(keep.into_iter().map(|i| chunk[i]));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(lo: f64, hi: f64, max: usize) -> Vec<String> {
        linear_ticks(lo, hi, max).into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn labels_by_hand() {
        assert_eq!(labels(0.0, 1.0, 5), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(0.003, 0.009, 6), ["0.003", "0.004", "0.005", "0.006", "0.007", "0.008", "0.009"]);
        assert_eq!(labels(-20.0, 20.0, 4), ["−20", "−10", "0", "10", "20"]);
        assert_eq!(labels(300.0, 770.0, 5), ["300", "400", "500", "600", "700"]);
        assert_eq!(labels(0.0, 3e-8, 3), ["0", "1e−8", "2e−8", "3e−8"]);
        assert_eq!(labels(0.0, 4e6, 4), ["0", "1e6", "2e6", "3e6", "4e6"]);
        let log: Vec<String> = log_ticks(0.001, 1.0, 5).into_iter().map(|t| t.1).collect();
        assert_eq!(
            log,
            ["0.001", "0.010", "0.100", "1.000"]
                .map(|s| s.trim_end_matches('0'))
                .map(|s| { if s == "1." { "1" } else { s } })
        );
    }

    #[test]
    fn ranges() {
        let of = |r: Range, v: &[f64]| r.resolve(v.iter().copied(), false, 5);
        assert_eq!(of(Range::Auto, &[2.0, f64::NAN, 5.0, f64::INFINITY]), Ok((2.0, 5.0)));
        assert_eq!(of(Range::FromZero, &[2.0, 5.0]), Ok((0.0, 5.0)));
        // Ticks enclose the data.
        assert_eq!(of(Range::Auto, &[0.12, 0.385]), Ok((0.1, 0.4)));
        assert_eq!(of(Range::FromZero, &[0.385]), Ok((0.0, 0.4)));
        assert_eq!(of(Range::Auto, &[-4.5, 2.0]), Ok((-6.0, 2.0)));
        assert_eq!(Range::Auto.resolve([0.02, 3.0].into_iter(), true, 5), Ok((0.01, 10.0)));
        assert_eq!(of(Range::Auto, &[]), Ok((0.0, 1.0)));
        assert_eq!(of(Range::Fixed(1.0, 1.0), &[]), Err(FigureError::Range { from: 1.0, to: 1.0 }));
        assert_eq!(Range::Auto.resolve([-1.0, 0.0, 3.0, 4.0].into_iter(), true, 5), Ok((3.0, 4.0)));
        assert!(Range::Fixed(0.0, 1.0).resolve([].into_iter(), true, 5).is_err());
    }

    #[test]
    fn thinning_keeps_the_peaks() {
        let points: Vec<Point> =
            (0..10_000).map(|i| (f64::from(i) / 1000.0, if i == 4321 { 9.0 } else { 0.0 })).collect();
        let thin = thinned(&points);
        assert!(thin.len() < 200);
        assert!(thin.contains(&points[4321]));
        assert_eq!((thin.first(), thin.last()), (points.first(), points.last()));
    }

    proptest! {
        #[test]
        fn ticks_lie_inside_and_differ(a in -1e9..1e9_f64, span in -12.0..12.0_f64, max in 2..10_usize) {
            let (lo, hi) = (a, a + 10.0_f64.powf(span));
            prop_assume!(hi - lo > a.abs() * 1e-7);
            let ticks = linear_ticks(lo, hi, max);
            prop_assert!((2..=max + 4).contains(&ticks.len()), "{lo} {hi} {ticks:?}");
            for t in &ticks {
                prop_assert!(t.0 >= lo - (hi - lo) * 1e-5 && t.0 <= hi + (hi - lo) * 1e-5);
            }
            for pair in ticks.windows(2) {
                prop_assert!(pair[0].0 < pair[1].0);
                prop_assert_ne!(&pair[0].1, &pair[1].1);
            }
        }

        #[test]
        fn places_keep_order(a in -10.0..10.0_f64, b in -10.0..10.0_f64) {
            let axis = Axis::new((-10.0, 10.0), (200.0, 100.0), 2.0, false);
            prop_assert_eq!(a < b, axis.place(a) > axis.place(b));
            prop_assert!((102.0 - 1e-9..=198.0 + 1e-9).contains(&axis.place(a)));
        }
    }
}
