//! Figures as files in several formats.

use super::error::{FigureError, failed};
use super::font;
use super::layout::Figure;
use super::page::{Page, Shape, strokes, whole, whole_width};
use super::pdf::pdf;
use super::raster::{encode, png, reduced};
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
        let page = self.checked(width)?;
        // What finds no room in a column is scrolled on a narrow screen, and has no files of that width.
        let in_column = || {
            let page = self.checked(COLUMN)?;
            Ok::<_, FigureError>((svg(&page)?, pdf(&page)?))
        };
        let (narrow, narrow_pdf) = in_column().unwrap_or_default();
        Ok(Files { svg: svg(&page)?, narrow, narrow_pdf, png: png(&page)?, pdf: pdf(&page)? })
    }

    /// Draws the figure as SVG at the text width of a page.
    ///
    /// # Errors
    /// See [`FigureError`].
    pub fn to_svg(&self) -> Result<String, FigureError> {
        svg(&self.checked(WIDTH)?)
    }

    /// Draws the figure as PNG with 206 pixels per inch, at the text width of a page.
    ///
    /// # Errors
    /// See [`FigureError`].
    pub fn to_png(&self) -> Result<Vec<u8>, FigureError> {
        png(&self.checked(WIDTH)?)
    }

    /// Draws the figure as a PDF of one page, at the text width of a page.
    ///
    /// # Errors
    /// See [`FigureError`].
    pub fn to_pdf(&self) -> Result<Vec<u8>, FigureError> {
        pdf(&self.checked(WIDTH)?)
    }

    fn checked(&self, width: f64) -> Result<Page, FigureError> {
        let page = self.page(width)?;
        if page.width > MAX_SIDE || page.height > MAX_SIDE {
            let (width, height) = (page.width.ceil() as u32, page.height.ceil() as u32);
            return Err(FigureError::TooLarge { width, height, limit: MAX_SIDE as u32 });
        }
        Ok(page)
    }
}

/// Draws the page as one SVG element. It has no ids, so that several can share an HTML page.
///
/// Coordinates of plotters are integers, so the view box has [`FINE`] of them per unit. Video frames are
/// embedded as PNG, since plotters would draw a rectangle for each pixel.
fn svg(page: &Page) -> Result<String, FigureError> {
    let (w, h) = ((page.width * FINE).round() as u32, (page.height.ceil() * FINE) as u32);
    let mut body = String::new();
    draw(SVGBackend::with_string(&mut body, (w, h)), &page.shapes)?;
    // plotters' outer element is replaced by one with the page's size, title and frames.
    let inner = body.split_once('>').and_then(|(_, b)| b.rsplit_once("</svg>")).map_or("", |(b, _)| b);
    // What is opaque need not say so; texts have their quotes escaped, so only attributes match.
    let inner = inner.replace(" opacity=\"1\"", "");
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {w} {h}\" role=\"img\">\n\
         <title>{}</title>\n<rect width=\"{w}\" height=\"{h}\" fill=\"#FFFFFF\"/>\n",
        inches(page.width),
        inches(page.height.ceil()),
        escape(&page.title),
    );
    for (area, frame) in &page.frames {
        let [(x0, y0), (x1, y1)] =
            [(area.x, area.y), (area.right(), area.bottom())].map(|p| whole(&[p], FINE)[0]);
        let data = BASE64_STANDARD.encode(encode(&reduced(area, frame))?);
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "<image x=\"{x0}\" y=\"{y0}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
             href=\"data:image/png;base64,{data}\"/>",
            x1 - x0,
            y1 - y0,
        );
    }
    let _ = write!(out, "<g stroke-linejoin=\"round\" stroke-linecap=\"round\">{inner}</g>\n</svg>\n");
    Ok(out)
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
