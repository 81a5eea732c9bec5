//! Figures: plain data in; SVG text, PNG and PDF bytes out; no files, no knowledge of methods.
//!
//! A [`Figure`] is made of [`Panel`]s, and these of [`Mark`]s. The figure is laid out once: as a page of
//! stills with lines, filled shapes and texts over them, in units of 0.7 pt. SVG (by plotters) is
//! drawn from this page, and bitmap and PDF from the SVG, so all formats show the same, and the same data gives the same bytes.
//! A figure is [`WIDTH`] or [`COLUMN`] wide (7 or 3.3 inches in print); its smallest text is 7.7 pt in print.
//! Text that is too long is broken into lines, never cut.
//!
//! Colors are those of Okabe and Ito (Color Universal Design, 2008), which people with any of the common
//! color deficiencies can tell apart; markers differ as well. Ordered values have the colors of viridis.
//!
//! Files in the order in which they use each other: error, style, font, page, axis, legend, diagram, radar, panel,
//! still, layout, render, output; and dots, which makes a figure of named rows, and annotated, which draws on video frames.

mod annotated;
mod axis;
mod diagram;
mod dots;
mod error;
mod font;
mod layout;
mod legend;
mod output;
mod page;
mod panel;
mod radar;
mod render;
mod still;
mod style;

pub use annotated::{AnnotatedBox, annotate};
pub use axis::{Axis, Range};
pub use dots::{Dot, DotPanel, Dots};
pub use error::FigureError;
pub use layout::{Figure, Form};
pub use legend::{Entry, Marker, Symbol};
pub use output::Files;
pub use panel::{Mark, Panel};
pub use radar::{Polygon, Radar};
pub use still::{BoxStyle, Still, box_legend};
pub use style::{COLUMN, Color, Dash, PER_INCH, Style, WIDTH};

#[cfg(test)]
mod tests;
