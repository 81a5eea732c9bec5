//! Bitmaps: a backend of plotters whose lines, disks and letters are smooth. (Those of plotters' own bitmap backend are
//! polygons with hard corners at the joins, and its letters stand a little beside their places.) Other shapes are left to the
//! rasteriser of plotters.

use super::error::FigureError;
use super::font;
use super::page::{Area, EM, Page, Point, draw, failed, share_before};
use super::style::{FINE, PER_INCH};
use ::image::imageops::{self, FilterType};
use ::image::{DynamicImage, Rgb, RgbImage};
use plotters::prelude::{DrawingBackend, IntoDrawingArea};
use plotters::style::FontTransform;
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind};
use std::convert::Infallible;
use trackfail_core::image::Frame;

/// Pixels that are drawn on.
pub struct Canvas<'a>(pub &'a mut RgbImage);

impl Canvas<'_> {
    fn dot(&mut self, x: i32, y: i32, color: BackendColor, coverage: f64) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
        let Some(pixel) = self.0.get_pixel_mut_checked(x, y) else { return };
        let (r, g, b) = color.rgb;
        for (old, new) in pixel.0.iter_mut().zip([r, g, b]) {
            let old_part = f64::from(*old);
            *old = (old_part + (f64::from(new) - old_part) * color.alpha * coverage).round() as u8;
        }
    }

    /// Draws all that is at most `radius` from the segment between two points: a line with round ends.
    fn segment(&mut self, a: BackendCoord, b: BackendCoord, radius: f64, color: BackendColor) {
        let reach = radius.ceil() as i32 + 1;
        let range = |a: i32, b: i32, side: u32| {
            let side = i32::try_from(side).unwrap_or(i32::MAX);
            a.min(b).saturating_sub(reach).max(0)..a.max(b).saturating_add(reach).min(side)
        };
        let ((ax, ay), (bx, by)) = ((f64::from(a.0), f64::from(a.1)), (f64::from(b.0), f64::from(b.1)));
        let (dx, dy) = (bx - ax, by - ay);
        let square = dx * dx + dy * dy;
        for y in range(a.1, b.1, self.0.height()) {
            for x in range(a.0, b.0, self.0.width()) {
                let (px, py) = (f64::from(x) + 0.5 - ax, f64::from(y) + 0.5 - ay);
                let t = if square > 0.0 { ((px * dx + py * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
                let (ex, ey) = (px - t * dx, py - t * dy);
                let away = (ex * ex + ey * ey).sqrt();
                let covered = (radius + 0.5 - away).min(1.0);
                if covered > 0.0 {
                    self.dot(x, y, color, covered);
                }
            }
        }
    }
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl DrawingBackend for Canvas<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.0.dimensions()
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Drawn {
        self.dot(x, y, color, 1.0);
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        let points: Vec<BackendCoord> = path.into_iter().collect();
        for pair in points.windows(2) {
            self.segment(pair[0], pair[1], f64::from(style.stroke_width()) / 2.0, style.color());
        }
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        _: bool,
    ) -> Drawn {
        self.segment(center, center, f64::from(radius), style.color());
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Drawn {
        let size = style.size() / EM;
        let back = (font::width(text, size) * share_before(style.anchor().h_pos)).round() as i32;
        let upwards = matches!(style.transform(), FontTransform::Rotate270);
        font::rasterize(text, size, |u, v, coverage| {
            let (u, v) = if upwards { (x + v, y + back - u) } else { (x + u - back, y + v) };
            self.dot(u, v, style.color(), f64::from(coverage));
        });
        Ok(())
    }
}

/// The page as a PNG file of two pixels a unit, 206 an inch: drawn twice as large, and reduced.
pub fn png(page: &Page) -> Result<Vec<u8>, FigureError> {
    let whole = |units: f64| (units.ceil() * FINE) as u32;
    let (width, height) = (whole(page.width), whole(page.height));
    let mut image = RgbImage::from_pixel(width, height, Rgb([255; 3]));
    for (area, frame) in &page.frames {
        let place = |p: Point| ((p.0 * FINE).round() as i64, (p.1 * FINE).round() as i64);
        let (from, to) = (place((area.x, area.y)), place((area.right(), area.bottom())));
        let side = |from: i64, to: i64| u32::try_from(to - from).unwrap_or(1).max(1);
        let size = (side(from.0, to.0), side(from.1, to.1));
        imageops::replace(&mut image, &resized(pixels(frame), size), from.0, from.1);
    }
    draw(&Canvas(&mut image).into_drawing_area(), &page.shapes, FINE)?;
    encode(&DynamicImage::ImageRgb8(image).thumbnail_exact(width / 2, height / 2).into_rgb8())
}

/// An image as a PNG file that says how many of its pixels a meter has, so that programs show a figure in its width in print.
pub fn encode(image: &RgbImage) -> Result<Vec<u8>, FigureError> {
    let mut out = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut out, image.width(), image.height());
    encoder.set_color(::png::ColorType::Rgb);
    encoder.set_depth(::png::BitDepth::Eight);
    let density = (FINE / 2.0 * PER_INCH / 0.0254).round() as u32;
    let unit = ::png::Unit::Meter;
    encoder.set_pixel_dims(Some(::png::PixelDimensions { xppu: density, yppu: density, unit }));
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(image.as_raw()).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(out)
}

fn resized(image: RgbImage, (width, height): (u32, u32)) -> RgbImage {
    DynamicImage::ImageRgb8(image).resize_exact(width, height, FilterType::Triangle).into_rgb8()
}

/// A frame as an image; one pixel where its size does not fit its bytes.
pub fn pixels(frame: &Frame) -> RgbImage {
    let (width, height) = (frame.width() as u32, frame.height() as u32);
    RgbImage::from_raw(width, height, frame.bytes().to_vec()).unwrap_or_else(|| RgbImage::new(1, 1))
}

/// A frame as it is embedded in an area: at most three of its pixels a unit; more would only cost bytes.
pub fn reduced(area: &Area, frame: &Frame) -> RgbImage {
    let image = pixels(frame);
    let (w, h) = ((area.w * 3.0).ceil() as u32, (area.h * 3.0).ceil() as u32);
    if image.width() <= w || image.height() <= h { image } else { resized(image, (w, h)) }
}

#[cfg(test)]
mod tests {
    use super::super::page::{Shape, Stroke};
    use super::super::style::Dash;
    use super::*;

    /// How dark a black shape makes a page of 40 units, in square units.
    fn darkness(shape: Shape) -> f64 {
        let mut image = RgbImage::from_pixel(160, 160, Rgb([255; 3]));
        draw(&Canvas(&mut image).into_drawing_area(), &[shape], FINE).expect("a drawing");
        image.as_raw().iter().map(|v| f64::from(255 - v)).sum::<f64>() / 765.0 / FINE / FINE
    }

    fn line(points: Vec<Point>, width: f64) -> Shape {
        Shape::Line { points, stroke: Stroke { rgb: [0; 3], width, dash: Dash::Solid } }
    }

    #[test]
    fn shapes_cover_their_area() {
        let near = |shape: Shape, area: f64, within: f64| {
            let dark = darkness(shape);
            assert!((dark - area).abs() < within, "{dark} {area}");
        };
        let corners = vec![(4.0, 3.0), (16.0, 5.0), (9.0, 15.0)];
        near(Shape::Fill { corners, rgb: [0; 3], opacity: 1.0 }, 67.0, 6.0);
        near(Shape::Disc { center: (9.3, 8.8), radius: 4.0, rgb: [0; 3] }, 16.0 * std::f64::consts::PI, 0.5);
        // A line with two round ends, and one that runs back over itself.
        let ends = std::f64::consts::PI * 0.75 * 0.75;
        near(line(vec![(3.0, 5.0), (15.0, 10.0)], 1.5), 13.0 * 1.5 + ends, 0.5);
        near(line(vec![(3.0, 5.0), (15.0, 10.0), (3.0, 5.0)], 1.5), 13.0 * 1.5 + ends, 2.5);
    }
}
