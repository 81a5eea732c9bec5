//! Bitmaps with smooth lines and letters. (The bitmap backend of plotters draws lines as polygons with hard
//! corners, and misplaces letters slightly.)

use super::error::{FigureError, failed};
use super::font;
use super::page::{Area, Page, Shape, share_before, strokes, whole, whole_width};
use super::style::{Color, FINE, PER_INCH};
use ::image::imageops::{self, FilterType};
use ::image::{DynamicImage, Rgb, RgbImage};
use trackfail_core::image::Frame;

/// Draws shapes on an image with `scale` pixels per unit.
pub fn paint(image: &mut RgbImage, shapes: &[Shape], scale: f64) {
    for shape in shapes {
        match shape {
            Shape::Line { points, style } => {
                let radius = f64::from(whole_width(style, scale)) / 2.0;
                for run in strokes(points, style.dash, scale) {
                    run.windows(2).for_each(|ends| segment(image, ends[0], ends[1], radius, style.color));
                }
            }
            Shape::Fill { corners, color, opacity } => fill(image, &whole(corners, scale), *color, *opacity),
            Shape::Text { text, at, size, anchor, upwards, color } => {
                let (size, (x, y)) = (size * scale, whole(&[*at], scale)[0]);
                let back = (font::width(text, size) * share_before(*anchor)).round() as i32;
                font::rasterize(text, size, |u, v, coverage| {
                    let at = if *upwards { (x + v, y + back - u) } else { (x + u - back, y + v) };
                    dot(image, at, *color, f64::from(coverage));
                });
            }
        }
    }
}

fn dot(image: &mut RgbImage, (x, y): (i32, i32), color: Color, coverage: f64) {
    let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
    let Some(pixel) = image.get_pixel_mut_checked(x, y) else { return };
    for (old, new) in pixel.0.iter_mut().zip(color.0) {
        let before = f64::from(*old);
        *old = (before + (f64::from(new) - before) * coverage).round() as u8;
    }
}

/// Part of the range `from..=to` that lies in an image with this side.
fn seen(from: i32, to: i32, side: u32) -> std::ops::Range<i32> {
    from.max(0)..to.min(i32::try_from(side).unwrap_or(i32::MAX))
}

/// Draws all points within `radius` of the segment from `a` to `b`: a line with round ends.
fn segment(image: &mut RgbImage, a: (i32, i32), b: (i32, i32), radius: f64, color: Color) {
    let reach = radius.ceil() as i32 + 1;
    let range = |a: i32, b: i32, side: u32| {
        seen(a.min(b).saturating_sub(reach), a.max(b).saturating_add(reach), side)
    };
    let ((ax, ay), (bx, by)) = ((f64::from(a.0), f64::from(a.1)), (f64::from(b.0), f64::from(b.1)));
    let (dx, dy) = (bx - ax, by - ay);
    let square = dx * dx + dy * dy;
    for y in range(a.1, b.1, image.height()) {
        for x in range(a.0, b.0, image.width()) {
            let (px, py) = (f64::from(x) + 0.5 - ax, f64::from(y) + 0.5 - ay);
            let t = if square > 0.0 { ((px * dx + py * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
            let (ex, ey) = (px - t * dx, py - t * dy);
            let away = (ex * ex + ey * ey).sqrt();
            let covered = (radius + 0.5 - away).min(1.0);
            if covered > 0.0 {
                dot(image, (x, y), color, covered);
            }
        }
    }
}

/// Fills the pixels whose centers lie inside a polygon, by the even-odd rule.
fn fill(image: &mut RgbImage, corners: &[(i32, i32)], color: Color, opacity: f64) {
    let heights = || corners.iter().map(|c| c.1);
    for row in seen(heights().min().unwrap_or(0), heights().max().unwrap_or(0), image.height()) {
        let y = f64::from(row) + 0.5;
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        let crossing = |(a, b): (&(i32, i32), &(i32, i32))| {
            let [a, b] = [a, b].map(|p| (f64::from(p.0), f64::from(p.1)));
            (a.0 + (y - a.1) / (b.1 - a.1) * (b.0 - a.0)).round() as i32
        };
        let mut ends: Vec<i32> = edges.filter(|(a, b)| (a.1 > row) != (b.1 > row)).map(crossing).collect();
        ends.sort_unstable();
        for span in ends.chunks_exact(2) {
            for x in seen(span[0], span[1], image.width()) {
                dot(image, (x, row), color, opacity);
            }
        }
    }
}

/// The page as a PNG file with two pixels per unit (206 per inch): drawn at twice the size, then reduced.
pub fn png(page: &Page) -> Result<Vec<u8>, FigureError> {
    let side = |units: f64| (units.ceil() * FINE) as u32;
    let (width, height) = (side(page.width), side(page.height));
    let mut image = RgbImage::from_pixel(width, height, Rgb([255; 3]));
    for (area, frame) in &page.frames {
        let [from, to] = [(area.x, area.y), (area.right(), area.bottom())].map(|p| whole(&[p], FINE)[0]);
        let side = |from: i32, to: i32| u32::try_from(to - from).unwrap_or(1).max(1);
        let size = (side(from.0, to.0), side(from.1, to.1));
        imageops::replace(&mut image, &resized(pixels(frame), size), from.0.into(), from.1.into());
    }
    paint(&mut image, &page.shapes, FINE);
    encode(&DynamicImage::ImageRgb8(image).thumbnail_exact(width / 2, height / 2).into_rgb8())
}

/// Encodes an image as PNG with its pixels per meter, so that programs show a figure at its print size.
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

/// Converts a frame to an image; to a single pixel if its size does not match its bytes.
pub fn pixels(frame: &Frame) -> RgbImage {
    let (width, height) = (frame.width() as u32, frame.height() as u32);
    RgbImage::from_raw(width, height, frame.bytes().to_vec()).unwrap_or_else(|| RgbImage::new(1, 1))
}

/// A frame reduced for embedding in an area: at most three of its pixels per unit. More would not be visible.
pub fn reduced(area: &Area, frame: &Frame) -> RgbImage {
    let image = pixels(frame);
    let (w, h) = ((area.w * 3.0).ceil() as u32, (area.h * 3.0).ceil() as u32);
    if image.width() <= w || image.height() <= h { image } else { resized(image, (w, h)) }
}

#[cfg(test)]
mod tests {
    use super::super::page::Point;
    use super::super::style::Style;
    use super::*;
    use std::f64::consts::PI;

    const BLACK: Color = Color::BLACK;

    /// Total darkness, in square units, that a black shape adds to a page of 40 units.
    fn darkness(add: impl Fn(&mut Page)) -> f64 {
        let mut page = Page::new("", 40.0);
        add(&mut page);
        let mut image = RgbImage::from_pixel(160, 160, Rgb([255; 3]));
        paint(&mut image, &page.shapes, FINE);
        image.as_raw().iter().map(|v| f64::from(255 - v)).sum::<f64>() / 765.0 / FINE / FINE
    }

    #[test]
    fn shapes_cover_their_area() {
        let near = |add: &dyn Fn(&mut Page), area: f64, within: f64| {
            let dark = darkness(add);
            assert!((dark - area).abs() < within, "{dark} {area}");
        };
        near(&|page: &mut Page| page.fill(vec![(4.0, 3.0), (16.0, 5.0), (9.0, 15.0)], BLACK), 67.0, 1.0);
        near(&|page: &mut Page| page.disc((9.3, 8.8), 4.0, BLACK), 16.0 * PI, 0.5);
        // A line with two round ends, and one that runs back over itself.
        let line = |points: &[Point], page: &mut Page| page.line(points.into(), Style::solid(BLACK, 1.5));
        let (from, to) = ((3.0, 5.0), (15.0, 10.0));
        let area = 13.0 * 1.5 + PI * 0.75 * 0.75;
        near(&|page: &mut Page| line(&[from, to], page), area, 0.5);
        near(&|page: &mut Page| line(&[from, to, from], page), area, 2.5);
    }
}
