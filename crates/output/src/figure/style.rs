//! Sizes, colors and line styles that all figures share.

/// Width of a figure with up to four columns, in points (CSS pixels).
pub const WIDTH: f64 = 720.0;
/// Margin around the page, in points.
pub const MARGIN: f64 = 8.0;
/// Size of tick labels, captions and legends, in points.
pub const SMALL: f64 = 11.0;
/// Size of axis names and headings, in points.
pub const MEDIUM: f64 = 12.0;
/// Size of a figure's title, in points.
pub const LARGE: f64 = 14.0;
/// Black for text.
pub const INK: [u8; 3] = [0x1A, 0x1A, 0x1A];
/// Gray for axes and notes.
pub const SOFT: [u8; 3] = [0x59, 0x59, 0x59];
/// Dark line under the boxes on stills, so that they show on bright pixels too.
pub const CASING: [u8; 3] = [0x20, 0x20, 0x20];

/// The palette of Okabe and Ito (2008), without its yellow for lines on white.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Color {
    /// `#0072B2`
    Blue,
    /// `#D55E00`, a red that color-blind readers can tell from green.
    Vermilion,
    /// `#009E73`
    Green,
    /// `#CC79A7`
    Purple,
    /// `#E69F00`
    Orange,
    /// `#56B4E9`
    Sky,
    /// `#F0E442`, for dark ground only.
    Yellow,
    /// `#000000`
    Black,
    /// `#6E6E6E`, for marks in the background.
    Gray,
}

impl Color {
    /// Red, green and blue.
    pub(super) fn rgb(self) -> [u8; 3] {
        match self {
            Self::Blue => [0x00, 0x72, 0xB2],
            Self::Vermilion => [0xD5, 0x5E, 0x00],
            Self::Green => [0x00, 0x9E, 0x73],
            Self::Purple => [0xCC, 0x79, 0xA7],
            Self::Orange => [0xE6, 0x9F, 0x00],
            Self::Sky => [0x56, 0xB4, 0xE9],
            Self::Yellow => [0xF0, 0xE4, 0x42],
            Self::Black => [0x00, 0x00, 0x00],
            Self::Gray => [0x6E, 0x6E, 0x6E],
        }
    }
}

impl Color {
    /// The color, or a lighter one where it would be hard to read on a dark ground.
    pub(super) fn bright(self) -> [u8; 3] {
        match self {
            Self::Vermilion => [0xFF, 0x9D, 0x66],
            Self::Green => [0x4F, 0xD3, 0xA8],
            Self::Blue => Self::Sky.rgb(),
            Self::Black | Self::Gray => [0xD4, 0xD4, 0xD0],
            other => other.rgb(),
        }
    }
}

/// Dashes of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// Unbroken.
    Solid,
    /// Dashes of 5 points.
    Dashed,
    /// Dots.
    Dotted,
    /// A dash, a dot.
    DashDot,
}

impl Dash {
    /// Alternating lengths of strokes and gaps in points; empty for an unbroken line. Round caps add the line's width to
    /// every stroke.
    pub(super) fn pattern(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[4.0, 3.5],
            Self::Dotted => &[0.3, 2.9],
            Self::DashDot => &[5.0, 3.2, 0.3, 3.2],
        }
    }
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    /// Color of line and markers.
    pub color: Color,
    /// Line style.
    pub dash: Dash,
    /// Width in points.
    pub width: f64,
}

impl Style {
    /// A line of usual width.
    pub fn new(color: Color, dash: Dash) -> Self {
        Self { color, dash, width: 1.4 }
    }

    /// Style of the `i`-th of several equal series; the first 28 differ.
    pub fn nth(i: usize) -> Self {
        const COLORS: [Color; 7] = [
            Color::Blue,
            Color::Vermilion,
            Color::Green,
            Color::Purple,
            Color::Orange,
            Color::Black,
            Color::Sky,
        ];
        const DASHES: [Dash; 4] = [Dash::Solid, Dash::Dashed, Dash::DashDot, Dash::Dotted];
        // 7 and 4 have no common divisor, so the pairs repeat only after 28.
        Self::new(COLORS[i % COLORS.len()], DASHES[i % DASHES.len()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_28_styles_differ() {
        let styles: Vec<Style> = (0..28).map(Style::nth).collect();
        for (i, a) in styles.iter().enumerate() {
            assert!(styles[..i].iter().all(|b| a != b), "style {i}");
        }
    }
}
