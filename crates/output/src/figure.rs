//! Figures: plain data in, SVG text or PNG bytes out; no files, no knowledge of methods.
//!
//! Every figure is a [`Plot`]: it is laid out once, in points, as a scene of lines, texts and pictures, and the scene is
//! drawn as SVG and as a bitmap. Both outputs therefore show the same, and the same data gives the same bytes. A figure
//! is [`WIDTH`] points wide unless it has more than four columns; at the width of a page its smallest text is about 8 pt.
//!
//! Colors are those of Okabe and Ito (Color Universal Design, 2008), which people with any of the
//! common color deficiencies can tell apart; line styles and markers differ as well.
//!
//! Files in the order in which they use each other: error, style, font, scene, raster, draw, axes, heading, legend,
//! panel; then one for each figure: strip, curve, ranks, states; and annotated, which draws on video frames.

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
mod ranks;
mod raster;
mod scene;
mod states;
mod strip;
mod style;

pub use annotated::{AnnotatedBox, annotate};
pub use axes::Range;
pub use curve::{Curve, Curves};
pub use dots::{Dot, DotPanel, Dots};
pub use draw::Plot;
pub use error::FigureError;
pub use panel::{FrameAxis, Panel, Series, Threshold, spans_where};
pub use ranks::{Ranking, Ranks};
pub use states::{Arrow, States};
pub use strip::{BoxStyle, LOST, Still, Strip};
pub use style::{Color, Dash, Style, WIDTH};

#[cfg(test)]
mod tests;
