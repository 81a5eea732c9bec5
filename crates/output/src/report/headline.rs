//! Parts of what stands at the head of a page: the best ones in a sentence, and all of them as dots with intervals.

use crate::figure::{Color, Dot, DotPanel, Dots};
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

/// A panel of the figure: its name, and the dot and the published value of each row.
pub type Panel = (String, Vec<(Option<Dot>, Option<f64>)>);

/// The figure of a measure: panels by name, each with the dots of all rows, which have a name and a color.
pub fn dots(measure: &str, way: &str, rows: Vec<(String, Color)>, panels: Vec<Panel>) -> Dots {
    let panel = |(label, values): Panel| {
        let (values, published) = values.into_iter().unzip();
        DotPanel { label, mark: None, published, values }
    };
    let panels: Vec<DotPanel> = panels.into_iter().map(panel).collect();
    let is_printed = panels.iter().flat_map(|p| &p.published).any(Option::is_some);
    let printed = if is_printed { "; a diamond is the published value" } else { "" };
    let (rows, colors) = rows.into_iter().unzip();
    Dots {
        title: String::new(),
        note: format!("{measure}, {way} is better, with 95 % intervals over sequences{printed}"),
        rows,
        panels,
        shared_axis: true,
        colors,
        chance: None,
    }
}

/// A label of a method at a point of its grid as sentences and figures have it: `AVU (length 20)` of `AVU[length=20]`.
pub fn spoken(name: &str, label: &str) -> String {
    let point = label.strip_prefix(name).and_then(|rest| rest.strip_prefix('[')?.strip_suffix(']'));
    match point {
        Some(point) => format!("{name} ({})", point.replace('=', " ").replace(';', ", ")),
        None => label.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_of_a_grid_is_in_words() {
        assert_eq!(spoken("NAIVE", "NAIVE[horizon=5;threshold=0.004]"), "NAIVE (horizon 5, threshold 0.004)");
        assert_eq!((spoken("CovF", "CovF"), spoken("a[b]", "a[b]")), ("CovF".into(), "a[b]".into()));
    }

    #[test]
    fn a_published_value_has_a_sign_and_a_word() {
        let dot = Some(Dot { value: 0.1, bounds: None });
        let rows = || vec![("DTEF".to_string(), Color::Blue)];
        let with = dots("F1 score", "larger", rows(), vec![("SP".into(), vec![(dot, Some(0.191))])]);
        assert!(with.note.ends_with("; a diamond is the published value"));
        assert_eq!((with.panels[0].published[0], with.colors[0]), (Some(0.191), Color::Blue));
        let without = dots("F1 score", "larger", rows(), vec![("SP".into(), vec![(dot, None)])]);
        assert!(without.note.ends_with("over sequences"));
    }
}
