//! Figures: plain data in, SVG text or PNG bytes out; no files, no knowledge of methods.
//!
//! Every kind of figure lays itself out once, in points, as a list of lines, texts and pictures; that
//! list is then played to plotters' SVG or bitmap backend. Both outputs therefore show the same, and
//! the same data gives the same bytes. A figure is [`WIDTH`] points wide unless it has more than four
//! columns; at the width of a page its smallest text is about 8 pt.
//!
//! Colors are those of Okabe and Ito (Color Universal Design, 2008), which people with any of the
//! common color deficiencies can tell apart; line styles and markers differ as well.

mod axes;
mod curve;
mod draw;
mod error;
mod font;
mod heading;
mod legend;
mod panel;
mod ranks;
mod scene;
mod states;
mod strip;
mod style;

pub use axes::Range;
pub use curve::{Curve, Curves};
pub use draw::Plot;
pub use error::FigureError;
pub use panel::{FrameAxis, Panel, Series, Threshold, spans_where};
pub use ranks::{Ranking, Ranks};
pub use states::{Arrow, States};
pub use strip::{BoxStyle, Still, Strip};
pub use style::{Color, Dash, Style, WIDTH};

#[cfg(test)]
mod tests;
