//! Sizes, colors and line styles that all figures share.

use plotters::style::RGBColor;
use plotters::style::colors::colormaps::ViridisRGB;

/// Width of a figure at the text width of a page (7 inches), in units.
pub const WIDTH: f64 = 720.0;
/// Units per inch; a unit is 0.7 pt.
pub const PER_INCH: f64 = WIDTH / 7.0;
/// Width of a figure in one of two columns (3.3 inches), in units.
pub const COLUMN: f64 = 3.3 * PER_INCH;
/// Integer coordinates per unit in drawings.
pub const FINE: f64 = 4.0;
/// Margin around the page, in units.
pub const MARGIN: f64 = 8.0;
/// Size of tick labels, captions and legends, in units: 7.7 pt in print.
pub const SMALL: f64 = 11.0;
/// Size of axis names and headings, in units: 8.4 pt in print.
pub const MEDIUM: f64 = 12.0;
/// Size of a figure's title, in units: 9.8 pt in print.
pub const LARGE: f64 = 14.0;
/// Black for text.
pub const INK: Color = Color([0x1A; 3]);
/// Gray for axes and notes.
pub const SOFT: Color = Color([0x59; 3]);
/// Shade of the frames where the target is lost.
pub const SHADE: Color = Color([0xE3; 3]);
/// Dark color of the lines under boxes on stills, which keeps the boxes visible on bright pixels.
pub const CASING: Color = Color([0x20; 3]);

/// Red, green and blue, 0 to 255: a color of the palette of Okabe and Ito (2008), or of a map of ordered values. The palette's
/// yellow is not used for lines on white.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Color(pub [u8; 3]);

impl Color {
    /// Blue, the first color of series.
    pub const BLUE: Self = Self([0x00, 0x72, 0xB2]);
    /// A red that color-blind readers can tell from green.
    pub const VERMILION: Self = Self([0xD5, 0x5E, 0x00]);
    /// Bluish green.
    pub const GREEN: Self = Self([0x00, 0x9E, 0x73]);
    /// Reddish purple.
    pub const PURPLE: Self = Self([0xCC, 0x79, 0xA7]);
    /// Orange.
    pub const ORANGE: Self = Self([0xE6, 0x9F, 0x00]);
    /// Sky blue.
    pub const SKY: Self = Self([0x56, 0xB4, 0xE9]);
    /// Yellow, for dark ground only.
    pub const YELLOW: Self = Self([0xF0, 0xE4, 0x42]);
    /// Black.
    pub const BLACK: Self = Self([0x00, 0x00, 0x00]);
    /// Gray, for marks in the background.
    pub const GRAY: Self = Self([0x6E, 0x6E, 0x6E]);

    /// The `i`-th of `n` colors for ordered values: those of viridis (van der Walt, Smith, 2015), from dark
    /// to light, without the end that is too light for lines on white.
    pub fn ordered(i: usize, n: usize) -> Self {
        let share = if n > 1 { i as f64 / (n - 1) as f64 } else { 0.0 };
        let RGBColor(r, g, b) = ViridisRGB::get_color(0.85 * share);
        Self([r, g, b])
    }

    /// A color that is readable on dark ground: the color itself, or a lighter one.
    pub(super) fn bright(self) -> Self {
        match self {
            Self::VERMILION => Self([0xFF, 0x9D, 0x66]),
            Self::GREEN => Self([0x4F, 0xD3, 0xA8]),
            Self::BLUE => Self::SKY,
            Self::BLACK | Self::GRAY => Self([0xD4, 0xD4, 0xD0]),
            other => other,
        }
    }
}

/// Dashes of a line: alternating lengths of strokes and gaps in units; empty for a solid line. Round caps add the line's width
/// to each stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dash(pub(super) &'static [f64]);

impl Dash {
    /// Unbroken.
    pub const SOLID: Self = Self(&[]);
    /// Dashes of 5 units.
    pub const DASHED: Self = Self(&[4.0, 3.5]);
    /// Dots.
    pub const DOTTED: Self = Self(&[0.3, 2.9]);
    /// Dashes and dots in turn.
    pub const DASH_DOT: Self = Self(&[5.0, 3.2, 0.3, 3.2]);

    /// The `i`-th line style. Styles repeat after four.
    pub fn nth(i: usize) -> Self {
        [Self::SOLID, Self::DASHED, Self::DASH_DOT, Self::DOTTED][i % 4]
    }
}

/// Color and line style of a series or another line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    /// Color of line and markers.
    pub color: Color,
    /// Line style.
    pub dash: Dash,
    /// Width in units.
    pub width: f64,
}

impl Style {
    /// A line of the usual width.
    pub fn new(color: Color, dash: Dash) -> Self {
        Self { color, dash, width: 1.4 }
    }

    /// An unbroken line.
    pub const fn solid(color: Color, width: f64) -> Self {
        Self { color, dash: Dash::SOLID, width }
    }

    /// Style of the `i`-th of several equal series: a new color each, with dashes from the eighth on. The
    /// first 28 styles differ.
    pub fn nth(i: usize) -> Self {
        const COLORS: [Color; 7] = [
            Color::BLUE,
            Color::VERMILION,
            Color::GREEN,
            Color::PURPLE,
            Color::ORANGE,
            Color::BLACK,
            Color::SKY,
        ];
        Self::new(COLORS[i % COLORS.len()], Dash::nth(i / COLORS.len()))
    }

    /// Style of the `i`-th of several series that may coincide: a new color and new dashes each.
    pub fn dashed(i: usize) -> Self {
        Self { dash: Dash::nth(i), ..Self::nth(i) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Values of matplotlib 3.10: matplotlib.colormaps["viridis"](0.0), (0.425) and (0.85), in 255ths; plotters has nine
    // colors of the map and mixes those between.
    #[test]
    fn ordered_colors_are_those_of_viridis() {
        let near = |color: Color, expected: [u8; 3]| {
            let rgb = color.0;
            assert!(rgb.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 10), "{rgb:?} {expected:?}");
        };
        near(Color::ordered(0, 3), [68, 1, 84]);
        near(Color::ordered(1, 3), [38, 130, 142]);
        near(Color::ordered(2, 3), [165, 219, 54]);
        assert_eq!(Color::ordered(0, 1), Color::ordered(0, 5));
    }

    #[test]
    fn the_first_28_styles_differ() {
        let styles: Vec<Style> = (0..28).map(Style::nth).collect();
        for (i, a) in styles.iter().enumerate() {
            assert!(styles[..i].iter().all(|b| a != b), "style {i}");
        }
    }
}
