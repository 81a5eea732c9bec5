//! Figures as files: SVG, drawn with plotters, and with it PNG and PDF.
//!
//! plotters' coordinates are integers, so the SVG is drawn [`FINE`] times as large, and its view box shrinks it. Stills
//! are not drawn with plotters, which makes a rectangle of every pixel, but embedded as PNG.

use super::error::FigureError;
use super::font;
use super::pdf;
use super::raster;
use super::scene::{Anchor, BAND, Item, Point, Scene, dashes};
use super::style::{COLUMN, PER_INCH, WIDTH};
use ::image::codecs::png;
use base64::prelude::{BASE64_STANDARD, Engine};
use plotters::coord::Shift;
use plotters::prelude::{
    Circle, Color, DrawingArea, DrawingBackend, IntoDrawingArea, IntoFont, PathElement, Polygon, RGBColor,
    Rectangle, SVGBackend, ShapeStyle, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, TextStyle};
use std::fmt::Write;

/// A figure: something that is laid out as a scene, and drawn from it.
pub trait Plot {
    /// Lays the figure out in a width, in units; [`WIDTH`] is that of a page's text.
    ///
    /// # Errors
    /// See [`FigureError`].
    #[doc(hidden)]
    fn scene(&self, width: f64) -> Result<Scene, FigureError>;

    /// The figure in all its formats, as wide as it is asked for.
    ///
    /// # Errors
    /// See [`FigureError`].
    fn draw(&self, width: f64) -> Result<Files, FigureError> {
        let scene = self.scene(width)?;
        device_size(&scene)?;
        // What finds no room in a column is scrolled on a narrow screen, and has no files of that width.
        let in_column = || {
            let scene = self.scene(COLUMN)?;
            device_size(&scene)?;
            Ok::<_, FigureError>((svg(&scene)?, pdf::pdf(&scene)?))
        };
        let (narrow, narrow_pdf) = in_column().unwrap_or_default();
        Ok(Files { svg: svg(&scene)?, narrow, narrow_pdf, png: raster::png(&scene)?, pdf: pdf::pdf(&scene)? })
    }

    /// The figure as SVG, as wide as a page's text.
    ///
    /// # Errors
    /// See [`FigureError`].
    fn to_svg(&self) -> Result<String, FigureError> {
        svg(&self.scene(WIDTH)?)
    }

    /// The figure as a PNG file of 206 pixels an inch, as wide as a page's text.
    ///
    /// # Errors
    /// See [`FigureError`].
    fn to_png(&self) -> Result<Vec<u8>, FigureError> {
        let scene = self.scene(WIDTH)?;
        device_size(&scene)?;
        raster::png(&scene)
    }

    /// The figure as a PDF file of one page, as wide as a page's text.
    ///
    /// # Errors
    /// See [`FigureError`].
    fn to_pdf(&self) -> Result<Vec<u8>, FigureError> {
        let scene = self.scene(WIDTH)?;
        device_size(&scene)?;
        pdf::pdf(&scene)
    }
}

/// A figure in all its formats.
#[derive(Debug, Clone, PartialEq)]
pub struct Files {
    /// SVG text.
    pub svg: String,
    /// SVG text of the figure as wide as a column, for papers of two columns and narrow screens; empty where it does not fit one.
    pub narrow: String,
    /// PDF bytes of the same; empty where it does not fit.
    pub narrow_pdf: Vec<u8>,
    /// PNG bytes.
    pub png: Vec<u8>,
    /// PDF bytes.
    pub pdf: Vec<u8>,
}

/// Units of the SVG's view box per unit of the scene.
const FINE: f64 = 4.0;
/// Maximum length of a side in units.
const MAX_SIDE: f64 = 8000.0;

fn failed(e: impl std::fmt::Display) -> FigureError {
    FigureError::Draw(e.to_string())
}

fn device(p: Point) -> (i32, i32) {
    ((p.0 * FINE).round() as i32, (p.1 * FINE).round() as i32)
}

fn device_size(scene: &Scene) -> Result<(u32, u32), FigureError> {
    if scene.width > MAX_SIDE || scene.height > MAX_SIDE {
        let (width, height) = (scene.width.ceil() as u32, scene.height.ceil() as u32);
        return Err(FigureError::TooLarge { width, height, limit: MAX_SIDE as u32 });
    }
    Ok(((scene.width * FINE).round() as u32, (scene.height.ceil() * FINE) as u32))
}

fn fill(rgb: [u8; 3]) -> ShapeStyle {
    ShapeStyle { color: RGBColor(rgb[0], rgb[1], rgb[2]).into(), filled: true, stroke_width: 0 }
}

/// Draws a filled shape.
fn shape<DB: DrawingBackend>(page: &DrawingArea<DB, Shift>, item: &Item) -> Result<(), FigureError> {
    match item {
        Item::Rect { area, rgb } => {
            let corners = [device((area.x, area.y)), device((area.right(), area.bottom()))];
            page.draw(&Rectangle::new(corners, fill(*rgb))).map_err(failed)
        }
        Item::Polygon { corners, rgb } => {
            let corners: Vec<_> = corners.iter().map(|&p| device(p)).collect();
            page.draw(&Polygon::new(corners, fill(*rgb))).map_err(failed)
        }
        Item::Circle { center, radius, rgb } => page
            .draw(&Circle::new(device(*center), (radius * FINE).round() as i32, fill(*rgb)))
            .map_err(failed),
        Item::Band { upper, lower, rgb: [r, g, b] } => {
            let corners: Vec<_> = upper.iter().chain(lower.iter().rev()).map(|&p| device(p)).collect();
            let style = ShapeStyle::from(RGBColor(*r, *g, *b).mix(BAND)).filled();
            page.draw(&Polygon::new(corners, style)).map_err(failed)
        }
        Item::Line { .. } | Item::Text { .. } => Ok(()),
    }
}

/// Draws the scene as one SVG element without any id, so that several can share a page.
pub fn svg(scene: &Scene) -> Result<String, FigureError> {
    let (w, h) = device_size(scene)?;
    let mut body = String::new();
    {
        let page = SVGBackend::with_string(&mut body, (w, h)).into_drawing_area();
        for item in &scene.items {
            match item {
                Item::Line { points, stroke } => {
                    let [r, g, b] = stroke.rgb;
                    let width = (stroke.width * FINE).round().max(1.0) as u32;
                    let style =
                        ShapeStyle { color: RGBColor(r, g, b).into(), filled: false, stroke_width: width };
                    for run in dashes(points, stroke.dash.pattern()) {
                        let mut run: Vec<_> = run.into_iter().map(device).collect();
                        run.dedup();
                        if run.len() == 1 {
                            run.push(run[0]);
                        }
                        page.draw(&PathElement::new(run, style)).map_err(failed)?;
                    }
                }
                Item::Text { text, at, size, anchor, upwards, rgb } => {
                    let horizontal = match anchor {
                        Anchor::Start => HPos::Left,
                        Anchor::Middle => HPos::Center,
                        Anchor::End => HPos::Right,
                    };
                    let turn = if *upwards { FontTransform::Rotate270 } else { FontTransform::None };
                    let color = RGBColor(rgb[0], rgb[1], rgb[2]);
                    // plotters writes size / 1.24 as the em.
                    let style =
                        TextStyle::from((font::FAMILY, size * FINE * 1.24).into_font().transform(turn))
                            .color(&color)
                            .pos(Pos::new(horizontal, VPos::Center));
                    page.draw(&Text::new(text.as_str(), device(*at), style)).map_err(failed)?;
                }
                other => shape(&page, other)?,
            }
        }
        page.present().map_err(failed)?;
    }
    // plotters' outer element is replaced by one with the scene's size, title and pictures.
    let inner = body.split_once('>').and_then(|(_, b)| b.rsplit_once("</svg>")).map_or("", |(b, _)| b);
    // Everything is opaque; texts have their quotes escaped, so only attributes match.
    let inner = inner.replace(" opacity=\"1\"", "");
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {w} {h}\" role=\"img\">\n\
         <title>{}</title>\n<rect width=\"{w}\" height=\"{h}\" fill=\"#FFFFFF\"/>\n",
        inches(scene.width),
        inches(scene.height.ceil()),
        escape(&scene.title),
    );
    for picture in &scene.pictures {
        let (x0, y0) = device((picture.area.x, picture.area.y));
        let (x1, y1) = device((picture.area.right(), picture.area.bottom()));
        let image = raster::reduced(picture);
        let (compression, filter) = (png::CompressionType::Default, png::FilterType::Adaptive);
        let data = raster::encode(image.as_raw(), image.dimensions(), compression, filter)?;
        let data = BASE64_STANDARD.encode(data);
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

/// A length in inches, as SVG has it.
fn inches(units: f64) -> String {
    let text = format!("{:.3}", units / PER_INCH);
    format!("{}in", text.trim_end_matches('0').trim_end_matches('.'))
}

/// Text as XML character data.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
