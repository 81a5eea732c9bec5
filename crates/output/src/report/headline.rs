//! Parts of what stands at the head of a page: the best ones in a sentence, and all of them as dots with intervals.

use crate::figure::{Dot, DotPanel, Dots};
use crate::table::number::Style;

/// Most rows of the figure.
pub const MAX_ROWS: usize = 16;

/// A number with its bounds: `0.31 (95 %: 0.22 to 0.41)`.
pub fn estimate(style: Style, value: f64, bounds: Option<(f64, f64)>) -> String {
    let bounds =
        bounds.map(|(low, high)| format!(" (95 %: {} to {})", style.format(low), style.format(high)));
    style.format(value) + &bounds.unwrap_or_default()
}

/// Bounds of a difference: `-0.020 to +0.110`.
pub fn signed_bounds(style: Style, (low, high): (f64, f64)) -> String {
    format!("{} to {}", style.format_signed(low), style.format_signed(high))
}

/// Says whether a lead with such bounds is more than chance.
pub fn by_chance(bounds: Option<(f64, f64)>) -> &'static str {
    if is_beyond_chance(bounds) {
        "more than chance"
    } else {
        "which these sequences cannot tell from chance"
    }
}

/// Whether all of the interval of a lead is on its side.
pub fn is_beyond_chance(bounds: Option<(f64, f64)>) -> bool {
    bounds.is_some_and(|(low, _)| low > 0.0)
}

/// The figure of a measure: panels by name, each with the dots of all rows.
pub fn dots(measure: &str, way: &str, rows: Vec<String>, panels: Vec<(String, Vec<Option<Dot>>)>) -> Dots {
    let panel = |(label, values)| DotPanel { label, mark: None, values };
    Dots {
        title: String::new(),
        note: format!("{measure}, {way} is better, with 95 % intervals over sequences"),
        rows,
        panels: panels.into_iter().map(panel).collect(),
        shared_axis: true,
    }
}
