//! Draws a scene with plotters' SVG and bitmap backends.
//!
//! plotters' coordinates are integer pixels, so both are drawn [`FINE`] times as large: the view box shrinks the SVG, and
//! averaging blocks of pixels shrinks the PNG. Stills are not drawn with plotters, whose SVG backend makes a rectangle of
//! every pixel: the SVG embeds them as PNG, and the bitmap starts with them. Texts and lines of the bitmap are drawn here
//! too: plotters' ab_glyph text drops the side bearings of the letters, and its wide lines leave holes where a noisy
//! curve crosses itself.

use super::error::FigureError;
use super::font;
use super::scene::{Anchor, Area, Item, Picture, Point, Scene, Stroke, dashes};
use ::image::imageops::{FilterType, resize};
use ::image::{ExtendedColorType, ImageEncoder, RgbImage, codecs::png};
use base64::prelude::{BASE64_STANDARD, Engine};
use plotters::coord::Shift;
use plotters::prelude::{
    BitMapBackend, Circle, DrawingArea, DrawingBackend, IntoDrawingArea, IntoFont, PathElement, Polygon,
    RGBColor, Rectangle, SVGBackend, ShapeStyle, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, TextStyle};
use std::fmt::Write;

/// A figure: something that is laid out as a scene, and drawn from it.
pub trait Plot {
    /// Lays the figure out.
    ///
    /// # Errors
    /// See [`FigureError`].
    #[doc(hidden)]
    fn scene(&self) -> Result<Scene, FigureError>;

    /// The figure as SVG.
    ///
    /// # Errors
    /// See [`FigureError`].
    fn to_svg(&self) -> Result<String, FigureError> {
        svg(&self.scene()?)
    }

    /// The figure as a PNG file, two pixels a point.
    ///
    /// # Errors
    /// See [`FigureError`].
    fn to_png(&self) -> Result<Vec<u8>, FigureError> {
        png(&self.scene()?)
    }
}

/// Device pixels per point while drawing.
const FINE: f64 = 4.0;
/// Device pixels along each side of a pixel of the PNG.
const SHRINK: usize = 2;
/// Maximum length of a side in points.
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
    Ok(((scene.width.ceil() * FINE) as u32, (scene.height.ceil() * FINE) as u32))
}

fn fill(rgb: [u8; 3]) -> ShapeStyle {
    ShapeStyle { color: RGBColor(rgb[0], rgb[1], rgb[2]).into(), filled: true, stroke_width: 0 }
}

/// Draws a filled shape, the same way for both backends.
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
        scene.width.ceil(),
        scene.height.ceil(),
        escape(&scene.title),
    );
    for picture in &scene.pictures {
        let (x0, y0) = device((picture.area.x, picture.area.y));
        let (x1, y1) = device((picture.area.right(), picture.area.bottom()));
        let data = BASE64_STANDARD.encode(png_of(&reduced(picture))?);
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

/// Text as XML character data.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Draws the scene as a PNG file of two pixels a point.
pub fn png(scene: &Scene) -> Result<Vec<u8>, FigureError> {
    let (w, h) = device_size(scene)?;
    let mut canvas = Canvas { w: w as usize, h: h as usize, rgb: vec![255; 3 * w as usize * h as usize] };
    for picture in &scene.pictures {
        canvas.blit(picture);
    }
    for item in &scene.items {
        match item {
            Item::Line { points, stroke } => {
                for run in dashes(points, stroke.dash.pattern()) {
                    canvas.line(&run, stroke);
                }
            }
            Item::Text { text, at, size, anchor, upwards, rgb } => {
                let length = font::width(text, size * FINE);
                let back = match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => length / 2.0,
                    Anchor::End => length,
                }
                .round() as i32;
                let (x, y) = device(*at);
                font::rasterize(text, size * FINE, |u, v, coverage| {
                    let (u, v) = if *upwards { (v, back - u) } else { (u - back, v) };
                    canvas.dot(x + u, y + v, *rgb, f64::from(coverage));
                });
            }
            other => {
                let page = BitMapBackend::with_buffer(&mut canvas.rgb, (w, h)).into_drawing_area();
                shape(&page, other)?;
                page.present().map_err(failed)?;
            }
        }
    }
    png_of(&canvas.shrunk())
}

fn png_of(image: &RgbImage) -> Result<Vec<u8>, FigureError> {
    let mut out = Vec::new();
    png::PngEncoder::new_with_quality(&mut out, png::CompressionType::Default, png::FilterType::Adaptive)
        .write_image(image.as_raw(), image.width(), image.height(), ExtendedColorType::Rgb8)
        .map_err(failed)?;
    Ok(out)
}

fn pixels(picture: &Picture) -> Option<RgbImage> {
    let frame = &picture.frame;
    RgbImage::from_raw(frame.width() as u32, frame.height() as u32, frame.bytes().to_vec())
}

/// The still as it is embedded: at most three of its pixels a point; more would only cost bytes.
fn reduced(picture: &Picture) -> RgbImage {
    let Some(image) = pixels(picture) else { return RgbImage::new(1, 1) };
    let (w, h) = ((picture.area.w * 3.0).ceil() as u32, (picture.area.h * 3.0).ceil() as u32);
    if image.width() <= w || image.height() <= h {
        return image;
    }
    resize(&image, w, h, FilterType::Triangle)
}

struct Canvas {
    w: usize,
    h: usize,
    rgb: Vec<u8>,
}

impl Canvas {
    fn dot(&mut self, x: i32, y: i32, rgb: [u8; 3], coverage: f64) {
        if x < 0 || y < 0 || x as usize >= self.w || y as usize >= self.h {
            return;
        }
        let at = 3 * (y as usize * self.w + x as usize);
        for (old, new) in self.rgb[at..at + 3].iter_mut().zip(rgb) {
            *old = (f64::from(*old) + coverage * (f64::from(new) - f64::from(*old))).round() as u8;
        }
    }

    fn blit(&mut self, picture: &Picture) {
        let Area { x, y, .. } = picture.area;
        let (x0, y0) = device((x, y));
        let (x1, y1) = device((picture.area.right(), picture.area.bottom()));
        let Some(image) = pixels(picture) else { return };
        let image = resize(&image, (x1 - x0).max(1) as u32, (y1 - y0).max(1) as u32, FilterType::Triangle);
        for (u, v, pixel) in image.enumerate_pixels() {
            self.dot(x0 + u as i32, y0 + v as i32, pixel.0, 1.0);
        }
    }

    /// Draws every segment as the set of points at most half the width away, which makes joins and caps round.
    fn line(&mut self, points: &[Point], stroke: &Stroke) {
        let radius = stroke.width * FINE / 2.0;
        let at = |p: Point| (p.0 * FINE, p.1 * FINE);
        for pair in points.windows(2) {
            let ((ax, ay), (bx, by)) = (at(pair[0]), at(pair[1]));
            let (dx, dy) = (bx - ax, by - ay);
            let square = dx * dx + dy * dy;
            let reach = radius + 1.0;
            for y in (ay.min(by) - reach).floor() as i32..=(ay.max(by) + reach).ceil() as i32 {
                for x in (ax.min(bx) - reach).floor() as i32..=(ax.max(bx) + reach).ceil() as i32 {
                    let (px, py) = (f64::from(x) + 0.5 - ax, f64::from(y) + 0.5 - ay);
                    let t = if square > 0.0 { ((px * dx + py * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
                    let away = (px - t * dx).hypot(py - t * dy);
                    let coverage = (radius + 0.5 - away).clamp(0.0, 1.0);
                    if coverage > 0.0 {
                        self.dot(x, y, stroke.rgb, coverage);
                    }
                }
            }
        }
    }

    /// The canvas with each block of pixels averaged to one.
    fn shrunk(&self) -> RgbImage {
        let (w, h) = (self.w / SHRINK, self.h / SHRINK);
        RgbImage::from_fn(w as u32, h as u32, |x, y| {
            let mut sum = [0_u32; 3];
            for v in 0..SHRINK {
                for u in 0..SHRINK {
                    let at = 3 * ((y as usize * SHRINK + v) * self.w + x as usize * SHRINK + u);
                    for (s, p) in sum.iter_mut().zip(&self.rgb[at..at + 3]) {
                        *s += u32::from(*p);
                    }
                }
            }
            let n = (SHRINK * SHRINK) as u32;
            ::image::Rgb(sum.map(|s| ((s + n / 2) / n) as u8))
        })
    }
}
