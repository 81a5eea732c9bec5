//! Axes: ranges, ticks, and the frame around a panel.

use super::error::FigureError;
use super::font;
use super::page::{Area, Page, Point};
use super::style::{INK, SMALL, SOFT, Style};
use plotters::style::text_anchor::HPos;

/// Length of a tick mark, in units.
const TICK: f64 = 3.5;
/// Largest absolute value that is drawn. Larger values would overflow the arithmetic of ranges.
const MAX_VALUE: f64 = 1e100;
/// Distance between the ends of a range and the frame, in units.
const ROOM: f64 = 5.0;
/// Distance between two lines of a row's name, in units.
pub const NAME_LINE: f64 = 12.0;

/// Lower and upper end of an axis.
pub type Ends = (f64, f64);

/// Values that an axis shows.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Range {
    /// All finite values; both ends are ticks.
    #[default]
    Auto,
    /// All finite values and 0 as the lower end; both ends are ticks.
    FromZero,
    /// Values between these two; lines are clipped there.
    Fixed(f64, f64),
}

/// An axis of a panel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// Name of the axis; may be empty.
    pub label: String,
    /// Range of values.
    pub range: Range,
    /// True for a logarithmic axis, on which points at 0 and below are gaps.
    pub log: bool,
    /// True if ticks are at whole numbers only.
    pub whole: bool,
    /// Names shown instead of some numbers; empty to show the numbers.
    pub names: Vec<(f64, String)>,
}

impl Axis {
    /// Creates a linear axis.
    pub fn new(label: &str, range: Range) -> Self {
        Self { label: label.to_string(), range, ..Self::default() }
    }

    /// Axis of a sequence's frames: number of the first frame, and number of frames.
    pub fn frames(first: u32, count: usize) -> Self {
        let first = f64::from(first);
        let range = match count {
            1 => Range::Fixed(first - 0.5, first + 0.5),
            _ => Range::Fixed(first, first + count as f64 - 1.0),
        };
        Self { whole: true, ..Self::new("frame", range) }
    }

    /// True if a value has a place on the axis.
    pub(super) fn shows(&self, value: f64) -> bool {
        value.abs() <= MAX_VALUE && (!self.log || value > 0.0)
    }

    /// Lower and upper end of the axis for these values, with about `max` ticks.
    ///
    /// # Errors
    /// [`FigureError::Range`] for a fixed range whose ends are not finite, not in order, or not above 0 where `log`.
    pub(super) fn ends(&self, values: &[f64], max: usize) -> Result<Ends, FigureError> {
        if let Range::Fixed(from, to) = self.range {
            let good = self.shows(from) && self.shows(to) && from < to;
            return if good { Ok((from, to)) } else { Err(FigureError::Range(from, to)) };
        }
        let (mut lo, mut hi) = values
            .iter()
            .filter(|v| self.shows(**v))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        if lo > hi {
            (lo, hi) = if self.log { (0.1, 1.0) } else { (0.0, 1.0) };
        }
        if self.range == Range::FromZero && !self.log {
            (lo, hi) = (lo.min(0.0), hi.max(0.0));
        }
        // Ends so near to each other have one place.
        if hi - lo <= lo.abs() * 1e-12 || (!self.log && hi < 1e-300 && lo > -1e-300) {
            let room = if lo.abs() < 1e-300 && !self.log { 1.0 } else { lo.abs() * 0.2 };
            (lo, hi) = (lo - room, hi + room);
        }
        Ok(self.enclosed((lo, hi), max))
    }

    /// Nearest ticks that enclose a range, so that the highest value can be read off. A logarithmic axis of
    /// at least a decade ends at powers of ten.
    fn enclosed(&self, (lo, hi): Ends, max: usize) -> Ends {
        if self.log && (hi / lo).log10() >= 1.0 {
            let power = |v: f64| 10.0_f64.powf(v);
            let (below, above) = (power((lo.log10() + 1e-9).floor()), power((hi.log10() - 1e-9).ceil()));
            let good = below > 0.0 && self.shows(above);
            return if good { (below.min(lo), above.max(hi)) } else { (lo, hi) };
        }
        let (mut from, mut to) = (lo, hi);
        // The wider range may have wider steps, whose ticks lie farther out again.
        for _ in 0..3 {
            let step = linear_step(from, to, max);
            let (below, above) = ((lo / step + 1e-6).floor() * step, (hi / step - 1e-6).ceil() * step);
            if !step.is_normal() || !self.shows(below) || !self.shows(above) {
                return (lo, hi);
            }
            if (below, above) == (from, to) {
                break;
            }
            (from, to) = (below, above);
        }
        (from.min(lo), to.max(hi))
    }

    /// Ticks with their labels, about `max` or fewer.
    pub(super) fn ticks(&self, (lo, hi): Ends, max: usize) -> Vec<(f64, String)> {
        if !self.names.is_empty() {
            return self.names.clone();
        }
        let ticks = if self.log { log_ticks(lo, hi, max) } else { linear_ticks(lo, hi, max) };
        if !self.whole {
            return ticks;
        }
        let whole = ticks.iter().map(|t| t.0.round());
        let mut whole: Vec<f64> = whole.filter(|v| ticks.iter().any(|t| (t.0 - v).abs() < 1e-6)).collect();
        whole.dedup();
        whole.into_iter().map(|v| (v, format!("{v:.0}"))).collect()
    }
}

/// Map from values of an axis to places on the page.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    /// Lower and upper end of the axis.
    pub ends: Ends,
    from: f64,
    to: f64,
    log: bool,
}

impl Scale {
    /// Maps the ends of an axis to places slightly inside `from` and `to`.
    pub fn new(axis: &Axis, ends: Ends, (from, to): (f64, f64)) -> Self {
        let room = if to < from { -ROOM } else { ROOM };
        Self { ends, from: from + room, to: to - room, log: axis.log }
    }

    /// Place of a value. Values far outside stay near the page, so that clipping is exact.
    pub fn place(&self, v: f64) -> f64 {
        let (lo, hi) = self.ends;
        let share = if self.log {
            (v.max(1e-300).ln() - lo.ln()) / (hi.ln() - lo.ln())
        } else {
            (v - lo) / (hi - lo)
        };
        self.from + share.clamp(-1e4, 1e4) * (self.to - self.from)
    }
}

/// Area of a panel on the page, with the scales of its axes.
pub struct Place {
    pub area: Area,
    pub x: Scale,
    pub y: Scale,
}

impl Place {
    pub fn of(&self, p: (f64, f64)) -> Point {
        (self.x.place(p.0), self.y.place(p.1))
    }
}

/// Distance of ticks for `lo..=hi`: 1, 2 or 5 times a power of ten.
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
pub fn linear_ticks(lo: f64, hi: f64, max: usize) -> Vec<(f64, String)> {
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

/// Powers of ten inside `lo..=hi`, and 2 and 5 times these if there is room.
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

/// Label of a tick, with just the digits that distinguish it from neighbors `step` away.
fn number(v: f64, step: f64) -> String {
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

/// Ticks of a panel's axes, each with a flag that is true if its labels are shown.
pub struct Ticks {
    pub x: Vec<(f64, String)>,
    pub y: Vec<(f64, Vec<String>)>,
    pub labels: (bool, bool),
}

/// Draws the frame of a panel with ticks. Labels are on the left and below.
pub fn frame(page: &mut Page, Place { area, x, y }: &Place, ticks: &Ticks) {
    let style = Style::solid(SOFT, 0.8);
    let (l, t, r, b) = (area.x, area.y, area.right(), area.bottom());
    page.line(vec![(l, t), (l, b), (r, b)], style);
    let inside = |at: f64, from: f64, to: f64| (from - 0.01..=to + 0.01).contains(&at);
    for (value, lines) in &ticks.y {
        let at = y.place(*value);
        if inside(at, t, b) {
            page.line(vec![(l - TICK, at), (l, at)], style);
            for (k, line) in lines.iter().enumerate().filter(|_| ticks.labels.1) {
                let at = at + NAME_LINE * (k as f64 - (lines.len() - 1) as f64 / 2.0);
                page.text(line, (l - TICK - 3.0, at), SMALL, HPos::Right, INK);
            }
        }
    }
    let mut free = f64::NEG_INFINITY;
    for (value, text) in &ticks.x {
        let (at, half) = (x.place(*value), font::width(text, SMALL) / 2.0);
        if inside(at, l, r) {
            page.line(vec![(at, b), (at, b + TICK)], style);
            if ticks.labels.0 && at - half >= free {
                let at = at.min(page.width - half - 1.0);
                page.text(text, (at, b + TICK + 8.5), SMALL, HPos::Center, INK);
                free = at + half + 5.0;
            }
        }
    }
}

/// Most ticks of the horizontal and the vertical axis in a panel of this size.
pub fn max_ticks((w, h): (f64, f64)) -> (usize, usize) {
    (((w / 44.0) as usize).clamp(3, 12), ((h / 26.0) as usize).clamp(2, 8))
}

/// Polyline without points that make no visible difference: of the points within a quarter unit across, only
/// the first, lowest, highest and last are kept.
pub fn thinned(points: &[Point]) -> Vec<Point> {
    let column = |p: &Point| (p.0 * 4.0).floor();
    let kept = |chunk: &[Point]| -> Vec<Point> {
        let by_height = |a: &usize, b: &usize| chunk[*a].1.total_cmp(&chunk[*b].1);
        let all = || 0..chunk.len();
        let lowest_and_highest = all().min_by(by_height).into_iter().chain(all().max_by(by_height));
        let mut keep: Vec<usize> = lowest_and_highest.chain([0, chunk.len() - 1]).collect();
        keep.sort_unstable();
        keep.dedup();
        if chunk.len() <= 4 { chunk.to_vec() } else { keep.into_iter().map(|i| chunk[i]).collect() }
    };
    points.chunk_by(|a, b| column(a) == column(b)).flat_map(kept).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn labels_by_hand() {
        let labels = |lo: f64, hi: f64, max: usize| -> Vec<String> {
            linear_ticks(lo, hi, max).into_iter().map(|t| t.1).collect()
        };
        assert_eq!(labels(0.0, 1.0, 5), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(0.003, 0.009, 6), ["0.003", "0.004", "0.005", "0.006", "0.007", "0.008", "0.009"]);
        assert_eq!(labels(-20.0, 20.0, 4), ["−20", "−10", "0", "10", "20"]);
        assert_eq!(labels(300.0, 770.0, 5), ["300", "400", "500", "600", "700"]);
        assert_eq!(labels(0.0, 3e-8, 3), ["0", "1e−8", "2e−8", "3e−8"]);
        assert_eq!(labels(0.0, 4e6, 4), ["0", "1e6", "2e6", "3e6", "4e6"]);
        let log: Vec<String> = log_ticks(0.001, 1.0, 5).into_iter().map(|t| t.1).collect();
        assert_eq!(log, ["0.001", "0.01", "0.1", "1"]);
    }

    #[test]
    fn ranges() {
        let of = |range: Range, values: &[f64]| Axis::new("", range).ends(values, 5);
        assert_eq!(of(Range::Auto, &[2.0, f64::NAN, 5.0, f64::INFINITY]), Ok((2.0, 5.0)));
        assert_eq!(of(Range::FromZero, &[2.0, 5.0]), Ok((0.0, 5.0)));
        // Ticks enclose the data.
        assert_eq!(of(Range::Auto, &[0.12, 0.385]), Ok((0.1, 0.4)));
        assert_eq!(of(Range::FromZero, &[0.385]), Ok((0.0, 0.4)));
        assert_eq!(of(Range::Auto, &[-4.5, 2.0]), Ok((-6.0, 2.0)));
        assert_eq!(of(Range::Auto, &[]), Ok((0.0, 1.0)));
        assert_eq!(of(Range::Fixed(1.0, 1.0), &[]), Err(FigureError::Range(1.0, 1.0)));
        let log = |range: Range, values: &[f64]| Axis { log: true, ..Axis::new("", range) }.ends(values, 5);
        assert_eq!(log(Range::Auto, &[0.02, 3.0]), Ok((0.01, 10.0)));
        assert_eq!(log(Range::Auto, &[-1.0, 0.0, 3.0, 4.0]), Ok((3.0, 4.0)));
        assert!(log(Range::Fixed(0.0, 1.0), &[]).is_err());
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
            let scale = Scale::new(&Axis::default(), (-10.0, 10.0), (200.0, 100.0));
            prop_assert_eq!(a < b, scale.place(a) > scale.place(b));
            prop_assert!((105.0 - 1e-9..=195.0 + 1e-9).contains(&scale.place(a)));
        }
    }
}
