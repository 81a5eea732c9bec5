//! Figures as files in several formats.

use super::error::{FigureError, failed};
use super::font;
use super::layout::Figure;
use super::page::{Page, Shape, strokes, whole, whole_width};
use super::render::{encode, pdf, png, tree};
use super::still::reduced;
use super::style::{COLUMN, Color as Ink, FINE, PER_INCH, WIDTH};
use base64::prelude::{BASE64_STANDARD, Engine};
use plotters::prelude::{Color, DrawingBackend, IntoFont, RGBColor, SVGBackend, ShapeStyle};
use plotters::style::text_anchor::{Pos, VPos};
use plotters::style::{FontTransform, TextStyle};
use std::fmt::Write;

/// A figure in all its formats.
#[derive(Debug, Clone, PartialEq)]
pub struct Files {
    /// SVG text.
    pub svg: String,
    /// SVG text of the figure at the width of a column, for two-column papers and narrow screens; empty if it
    /// does not fit.
    pub narrow: String,
    /// PDF bytes of the figure at the width of a column; empty if it does not fit.
    pub narrow_pdf: Vec<u8>,
    /// PNG bytes.
    pub png: Vec<u8>,
    /// PDF bytes.
    pub pdf: Vec<u8>,
}

/// Longest side of a figure, in units.
const MAX_SIDE: f64 = 8000.0;

impl Figure {
    /// Draws the figure in all its formats at a width in units; [`WIDTH`] is the text width of a page.
    ///
    /// # Errors
    /// See [`FigureError`].
    pub fn draw(&self, width: f64) -> Result<Files, FigureError> {
        let (page, svg) = self.laid_out(width)?;
        // What finds no room in a column is scrolled on a narrow screen, and has no files of that width.
        let in_column = || {
            let (page, narrow) = self.laid_out(COLUMN)?;
            let narrow_pdf = pdf(&page, &tree(&narrow)?)?;
            Ok::<_, FigureError>((narrow, narrow_pdf))
        };
        let (narrow, narrow_pdf) = in_column().unwrap_or_default();
        let tree = tree(&svg)?;
        Ok(Files { png: png(&page, &tree)?, pdf: pdf(&page, &tree)?, svg, narrow, narrow_pdf })
    }

    /// Draws the figure as SVG at the text width of a page.
    ///
    /// # Errors
    /// See [`FigureError`].
    pub fn to_svg(&self) -> Result<String, FigureError> {
        self.laid_out(WIDTH).map(|(_, svg)| svg)
    }

    /// Draws the figure as PNG with 206 pixels per inch, at the text width of a page.
    ///
    /// # Errors
    /// See [`FigureError`].
    pub fn to_png(&self) -> Result<Vec<u8>, FigureError> {
        let (page, svg) = self.laid_out(WIDTH)?;
        png(&page, &tree(&svg)?)
    }

    /// Draws the figure as a PDF of one page, at the text width of a page.
    ///
    /// # Errors
    /// See [`FigureError`].
    pub fn to_pdf(&self) -> Result<Vec<u8>, FigureError> {
        let (page, svg) = self.laid_out(WIDTH)?;
        pdf(&page, &tree(&svg)?)
    }

    /// The page at a width in units, and its SVG.
    fn laid_out(&self, width: f64) -> Result<(Page, String), FigureError> {
        let page = self.page(width)?;
        if page.width > MAX_SIDE || page.height > MAX_SIDE {
            let (width, height) = (page.width.ceil() as u32, page.height.ceil() as u32);
            return Err(FigureError::TooLarge { width, height, limit: MAX_SIDE as u32 });
        }
        let svg = svg(&page)?;
        Ok((page, svg))
    }
}

/// Draws the page as one SVG element. Video frames are embedded as PNG, since plotters would draw a rectangle
/// for each pixel.
pub fn svg(page: &Page) -> Result<String, FigureError> {
    let size = format!("width=\"{}\" height=\"{}\" ", inches(page.width), inches(page.height.ceil()));
    let (w, h) = fine_size(page);
    let mut under = format!("<rect width=\"{w}\" height=\"{h}\" fill=\"#FFFFFF\"/>\n");
    for (area, frame) in &page.frames {
        let [(x0, y0), (x1, y1)] =
            [(area.x, area.y), (area.right(), area.bottom())].map(|p| whole(&[p], FINE)[0]);
        let data = BASE64_STANDARD.encode(encode(&reduced(area, frame))?);
        // Writing to a string cannot fail.
        let _ = writeln!(
            under,
            "<image x=\"{x0}\" y=\"{y0}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
             href=\"data:image/png;base64,{data}\"/>",
            x1 - x0,
            y1 - y0,
        );
    }
    document(page, &size, &under)
}

/// Width and height of the view box.
fn fine_size(page: &Page) -> (u32, u32) {
    ((page.width * FINE).round() as u32, (page.height.ceil() * FINE) as u32)
}

/// Draws the shapes of a page over other elements, in an element with these attributes. It has no ids, so that
/// several can share an HTML page.
///
/// Coordinates of plotters are integers, so the view box has [`FINE`] of them per unit.
pub fn document(page: &Page, attributes: &str, under: &str) -> Result<String, FigureError> {
    let (w, h) = fine_size(page);
    let mut body = String::new();
    draw(SVGBackend::with_string(&mut body, (w, h)), &page.shapes)?;
    // plotters' outer element is replaced by one with these attributes, a title and what lies under the shapes.
    let inner = body.split_once('>').and_then(|(_, b)| b.rsplit_once("</svg>")).map_or("", |(b, _)| b);
    // What is opaque need not say so; texts have their quotes escaped, so only attributes match.
    let inner = inner.replace(" opacity=\"1\"", "");
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" {attributes}viewBox=\"0 0 {w} {h}\" role=\"img\">\n\
         <title>{}</title>\n{under}<g stroke-linejoin=\"round\" stroke-linecap=\"round\">{inner}</g>\n</svg>\n",
        escape(&page.title),
    ))
}

/// Ratio of a text's size in plotters to its em.
const EM: f64 = 1.24;

/// Draws shapes with plotters.
fn draw(mut backend: SVGBackend<'_>, shapes: &[Shape]) -> Result<(), FigureError> {
    let rgb = |color: &Ink| RGBColor(color.0[0], color.0[1], color.0[2]);
    for shape in shapes {
        match shape {
            Shape::Line { points, style } => {
                let stroke = ShapeStyle::from(rgb(&style.color)).stroke_width(whole_width(style, FINE));
                for run in strokes(points, style.dash, FINE) {
                    backend.draw_path(run, &stroke).map_err(failed)?;
                }
            }
            Shape::Fill { corners, color, opacity } => {
                let style = rgb(color).mix(*opacity);
                backend.fill_polygon(whole(corners, FINE), &style).map_err(failed)?;
            }
            Shape::Text { text, at, size, anchor, upwards, color } => {
                let turn = if *upwards { FontTransform::Rotate270 } else { FontTransform::None };
                let ink = rgb(color);
                let style = TextStyle::from((font::FAMILY, size * FINE * EM).into_font().transform(turn))
                    .color(&ink)
                    .pos(Pos::new(*anchor, VPos::Center));
                backend.draw_text(text, &style, whole(&[*at], FINE)[0]).map_err(failed)?;
            }
        }
    }
    backend.present().map_err(failed)
}

/// A length in inches, as text for SVG.
fn inches(units: f64) -> String {
    let text = format!("{:.3}", units / PER_INCH);
    format!("{}in", text.trim_end_matches('0').trim_end_matches('.'))
}

/// Escapes text for XML character data.
fn escape(text: &str) -> String {
    font::clean(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
