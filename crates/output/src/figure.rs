//! Figures: plain data in; SVG text, PNG and PDF bytes out; no files, no knowledge of methods.
//!
//! Every figure is a [`Plot`]: it is laid out once, in units of 0.7 pt, as a scene of lines, texts and pictures, and the
//! scene is drawn as SVG, as a bitmap and as PDF. All outputs therefore show the same, and the same data gives the same
//! bytes. A figure is [`WIDTH`] or [`COLUMN`] wide, 7 or 3.3 inches in print, and its smallest text there 7.7 pt.
//!
//! Colors are those of Okabe and Ito (Color Universal Design, 2008), which people with any of the
//! common color deficiencies can tell apart; markers differ as well. Values in order have the colors of viridis.
//!
//! Files in the order in which they use each other: error, style, font, scene, raster, pdf, draw, sign, axes, heading,
//! legend, panel; then one for each figure: strip, curve, dots, ranks, states; and annotated, which draws on video frames.

mod annotated;
mod axes;
mod curve;
mod dots;
mod draw;
mod error;
mod font;
mod heading;
mod legend;
mod panel;
mod pdf;
mod ranks;
mod raster;
mod scene;
mod sign;
mod states;
mod strip;
mod style;

pub use annotated::{AnnotatedBox, annotate};
pub use axes::Range;
pub use curve::{Curve, CurveAxis, Curves, Facet};
pub use dots::{Dot, DotPanel, Dots};
pub use draw::{Files, Plot};
pub use error::FigureError;
pub use legend::{Entry, Marker, Symbol};
pub use panel::{FrameAxis, Panel, Series, Threshold, spans_where};
pub use ranks::{Ranking, Ranks};
pub use sign::Sign;
pub use states::{Arrow, States};
pub use strip::{BoxStyle, LOST, Still, Strip};
pub use style::{COLUMN, Color, Dash, Edge, PER_INCH, Style, WIDTH};

#[cfg(test)]
mod tests;
