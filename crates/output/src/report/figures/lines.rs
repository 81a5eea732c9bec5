//! Figures made of curves.

use super::drawer::Drawing;
use crate::figure::{Curve, Curves, Range, Style};

/// Points of a curve under its name.
pub type NamedCurve = (String, Vec<(f64, f64)>);

/// The curves as a drawing, or `reason` where none of them has a value.
pub fn drawing(curves: Curves, reason: String) -> Drawing {
    if curves.series.iter().flat_map(|c| &c.points).all(|p| p.1.is_nan()) {
        return Drawing::NoData(reason);
    }
    Drawing::of(curves)
}

/// Curves by name on linear axes, the vertical one from 0.
pub fn plain(note: &str, x: &str, y: &str, curves: Vec<NamedCurve>) -> Curves {
    let curve = |(i, (name, points))| Curve { name, points, style: Style::nth(i) };
    Curves {
        title: String::new(),
        note: note.to_string(),
        x_label: x.to_string(),
        y_label: y.to_string(),
        x_log: false,
        y_log: false,
        x_range: Range::Auto,
        y_range: Range::FromZero,
        square: false,
        series: curves.into_iter().enumerate().map(curve).collect(),
        marks: Vec::new(),
    }
}
