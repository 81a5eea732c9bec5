//! Figures: plain data in, SVG text or PNG bytes out; no files, no knowledge of methods.
//!
//! Every kind of figure lays itself out once, in points, as a list of lines, texts and pictures; that
//! list is then played to plotters' SVG or bitmap backend. Both outputs therefore show the same, and
//! the same data gives the same bytes. A figure is [`WIDTH`] points wide unless it has more than four
//! columns; at the width of a page its smallest text is about 8 pt.
//!
//! Colours are those of Okabe and Ito (Color Universal Design, 2008), which people with any of the
//! common colour deficiencies can tell apart; line styles and markers differ as well.

mod axes;
mod curve;
mod draw;
mod font;
mod legend;
mod panel;
mod ranks;
mod scene;
mod states;
mod strip;
mod style;

pub use axes::Range;
pub use curve::{Curve, Curves};
pub use panel::{FrameAxis, Panel, Series, Threshold, spans_where};
pub use ranks::{Ranking, Ranks};
pub use states::{Arrow, States};
pub use strip::{BoxStyle, Still, Strip};
pub use style::{Colour, Dash, Style};

/// Width of a figure with up to four columns, in points (CSS pixels).
pub const WIDTH: f64 = 720.0;

/// Why there is no figure.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FigureError {
    /// No panel, no row, no frame to draw.
    #[error("the figure has nothing to draw: {0}")]
    Empty(&'static str),
    /// A series is not as long as its frame axis.
    #[error("series `{series}` has {got} values for {expected} frames")]
    Length {
        /// Name of the series.
        series: String,
        /// Number of its values.
        got: usize,
        /// Number of frames of the panel.
        expected: usize,
    },
    /// A fixed range whose ends are not finite, not in order, or not above 0 on a logarithmic axis.
    #[error("{from} to {to} is no range for an axis")]
    Range {
        /// Lower end.
        from: f64,
        /// Upper end.
        to: f64,
    },
    /// More rows or columns than a picture can hold.
    #[error("the figure would be {width} x {height} points; at most {limit} in either direction are drawn")]
    TooLarge {
        /// Width in points.
        width: u32,
        /// Height in points.
        height: u32,
        /// Limit in points.
        limit: u32,
    },
    /// The drawing backend or the PNG encoder refused.
    #[error("the figure could not be drawn: {0}")]
    Draw(String),
}

#[cfg(test)]
mod tests;
