//! Draws a scene as a bitmap of two pixels a unit: 206 pixels an inch.
//!
//! The coverage of a pixel is exact for shapes with edges along the axes, and the clamped distance to the edge for
//! others. A line is one shape, so that its color is not laid on twice where its segments meet.

use super::error::FigureError;
use super::font;
use super::scene::{Anchor, Area, BAND, Item, Picture, Point, Scene, Stroke, dashes};
use super::style::PER_INCH;
use ::image::imageops::{FilterType, resize};
use ::image::{ExtendedColorType, ImageEncoder, RgbImage, codecs::png};
use trackfail_core::image::Frame;

/// Pixels per unit.
const SCALE: f64 = 2.0;

/// Draws the scene, whose size has been checked, as a PNG file.
pub fn png(scene: &Scene) -> Result<Vec<u8>, FigureError> {
    let side = |points: f64| (points.ceil() * SCALE) as usize;
    let mut canvas = Canvas::new(side(scene.width), side(scene.height));
    for picture in &scene.pictures {
        canvas.picture(picture);
    }
    for item in &scene.items {
        canvas.item(item);
    }
    let size = (canvas.w as u32, canvas.h as u32);
    let mut png = encode(&canvas.rgb, size, png::CompressionType::Fast, png::FilterType::Up)?;
    // Behind the signature and the header, which has a fixed length.
    png.splice(33..33, density());
    Ok(png)
}

/// The chunk of a PNG that says how many pixels a meter has, so that programs show the figure in its width in print.
fn density() -> Vec<u8> {
    let per_meter = (SCALE * PER_INCH / 0.0254).round() as u32;
    let mut chunk = b"pHYs".to_vec();
    chunk.extend(per_meter.to_be_bytes());
    chunk.extend(per_meter.to_be_bytes());
    chunk.push(1);
    let bit = |sum: u32, _| if sum & 1 == 1 { (sum >> 1) ^ 0xEDB8_8320 } else { sum >> 1 };
    let check = !chunk.iter().fold(u32::MAX, |sum, byte| (0..8).fold(sum ^ u32::from(*byte), bit));
    let length = chunk.len() as u32 - 4;
    length.to_be_bytes().into_iter().chain(chunk).chain(check.to_be_bytes()).collect()
}

/// Draws items over a frame, two of whose pixels are a point.
pub fn over(frame: &Frame, items: &[Item]) -> Frame {
    let (w, h) = (frame.width(), frame.height());
    let mut canvas = Canvas { rgb: frame.bytes().to_vec(), ..Canvas::sized(w, h) };
    for item in items {
        canvas.item(item);
    }
    Frame::new(w, h, canvas.rgb)
}

/// Pixels of a width and height, row by row, as a PNG file.
pub fn encode(
    rgb: &[u8],
    (width, height): (u32, u32),
    compression: png::CompressionType,
    filter: png::FilterType,
) -> Result<Vec<u8>, FigureError> {
    let mut out = Vec::new();
    png::PngEncoder::new_with_quality(&mut out, compression, filter)
        .write_image(rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(|e| FigureError::Draw(e.to_string()))?;
    Ok(out)
}

struct Canvas {
    w: usize,
    h: usize,
    rgb: Vec<u8>,
    /// Coverage of the pixels of the line that is being drawn.
    mask: Vec<f32>,
}

/// Pixels from, and up to but without.
#[derive(Debug, Clone, Copy)]
struct Pixels {
    x: (usize, usize),
    y: (usize, usize),
}

fn scaled(p: Point) -> Point {
    (p.0 * SCALE, p.1 * SCALE)
}

/// Share of the pixel from `at` to `at + 1` that lies between two places.
fn share(at: usize, from: f64, to: f64) -> f64 {
    let at = at as f64;
    (to.min(at + 1.0) - from.max(at)).max(0.0)
}

impl Canvas {
    fn new(w: usize, h: usize) -> Self {
        Self { rgb: vec![255; 3 * w * h], ..Self::sized(w, h) }
    }

    /// A canvas without pixels yet.
    fn sized(w: usize, h: usize) -> Self {
        Self { w, h, rgb: Vec::new(), mask: Vec::new() }
    }

    /// The pixels of the canvas that a box touches.
    fn touched(&self, x: (f64, f64), y: (f64, f64)) -> Pixels {
        // Casts saturate, so what is far outside comes to lie on the edge.
        let within = |(from, to): (f64, f64), side: usize| {
            let to = (to.ceil() as usize).min(side);
            ((from.floor() as usize).min(to), to)
        };
        Pixels { x: within(x, self.w), y: within(y, self.h) }
    }

    fn dot(&mut self, x: usize, y: usize, rgb: [u8; 3], coverage: f64) {
        let share = (coverage * 255.0).round() as u32;
        let at = 3 * (y * self.w + x);
        for (old, new) in self.rgb[at..at + 3].iter_mut().zip(rgb) {
            *old = ((u32::from(*old) * (255 - share) + u32::from(new) * share + 127) / 255) as u8;
        }
    }

    /// Colors the pixels by what `coverage` says of their centers.
    fn fill(&mut self, pixels: Pixels, rgb: [u8; 3], coverage: impl Fn(usize, usize) -> f64) {
        for y in pixels.y.0..pixels.y.1 {
            for x in pixels.x.0..pixels.x.1 {
                let coverage = coverage(x, y);
                if coverage > 0.0 {
                    self.dot(x, y, rgb, coverage.min(1.0));
                }
            }
        }
    }

    fn item(&mut self, item: &Item) {
        match item {
            Item::Line { points, stroke } => {
                for run in dashes(points, stroke.dash.pattern()) {
                    self.line(&run, stroke);
                }
            }
            Item::Rect { area, rgb } => self.rect(area, *rgb),
            Item::Polygon { corners, rgb } => self.polygon(corners, *rgb, 1.0),
            Item::Circle { center, radius, rgb } => {
                let ((x, y), radius) = (scaled(*center), radius * SCALE);
                let reach = radius + 1.0;
                let pixels = self.touched((x - reach, x + reach), (y - reach, y + reach));
                self.fill(pixels, *rgb, |u, v| {
                    let (dx, dy) = (u as f64 + 0.5 - x, v as f64 + 0.5 - y);
                    radius + 0.5 - (dx * dx + dy * dy).sqrt()
                });
            }
            Item::Band { upper, lower, rgb } => {
                for (above, below) in upper.windows(2).zip(lower.windows(2)) {
                    self.polygon(&[above[0], above[1], below[1], below[0]], *rgb, BAND);
                }
            }
            Item::Text { text, at, size, anchor, upwards, rgb } => {
                let (x, y) = scaled(*at);
                let length = font::width(text, size * SCALE);
                let back = match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => length / 2.0,
                    Anchor::End => length,
                };
                let (x, y, back) = (x.round() as i64, y.round() as i64, back.round() as i64);
                font::rasterize(text, size * SCALE, |u, v, coverage| {
                    let (u, v) = (i64::from(u), i64::from(v));
                    let (u, v) = if *upwards { (x + v, y + back - u) } else { (x + u - back, y + v) };
                    if (0..self.w as i64).contains(&u) && (0..self.h as i64).contains(&v) {
                        self.dot(u as usize, v as usize, *rgb, f64::from(coverage));
                    }
                });
            }
        }
    }

    fn rect(&mut self, area: &Area, rgb: [u8; 3]) {
        let ((left, top), (right, bottom)) =
            (scaled((area.x, area.y)), scaled((area.right(), area.bottom())));
        let pixels = self.touched((left, right), (top, bottom));
        self.fill(pixels, rgb, |x, y| share(x, left, right) * share(y, top, bottom));
    }

    /// A convex polygon of an opacity from 0 to 1.
    fn polygon(&mut self, corners: &[Point], rgb: [u8; 3], opacity: f64) {
        let corners: Vec<Point> = corners.iter().map(|&p| scaled(p)).collect();
        let next = |k: usize| corners[(k + 1) % corners.len()];
        let doubled: f64 = corners.iter().enumerate().map(|(k, a)| a.0 * next(k).1 - next(k).0 * a.1).sum();
        // For each edge the unit vector that points outwards, and how far out the edge is.
        let edge = |(k, a): (usize, &Point)| {
            let (dx, dy) = (next(k).0 - a.0, next(k).1 - a.1);
            let length = (dx * dx + dy * dy).sqrt().max(f64::MIN_POSITIVE) * doubled.signum();
            let (nx, ny) = (dy / length, -dx / length);
            (nx, ny, nx * a.0 + ny * a.1)
        };
        let edges: Vec<_> = corners.iter().enumerate().map(edge).collect();
        let bounds = |of: fn(&Point) -> f64| {
            let all = corners.iter().map(of);
            (all.clone().fold(f64::INFINITY, f64::min) - 1.0, all.fold(f64::NEG_INFINITY, f64::max) + 1.0)
        };
        let pixels = self.touched(bounds(|p| p.0), bounds(|p| p.1));
        self.fill(pixels, rgb, |x, y| {
            let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
            let outside = edges.iter().map(|(nx, ny, d)| nx * x + ny * y - d);
            opacity * (0.5 - outside.fold(f64::NEG_INFINITY, f64::max)).min(1.0)
        });
    }

    /// A line with round joins and ends: all points at most half its width from one of its segments.
    fn line(&mut self, points: &[Point], stroke: &Stroke) {
        let points: Vec<Point> = points.iter().map(|&p| scaled(p)).collect();
        let radius = stroke.width * SCALE / 2.0;
        let reach = radius + 1.0;
        let bounds = |points: &[Point]| {
            let start = ((f64::INFINITY, f64::NEG_INFINITY), (f64::INFINITY, f64::NEG_INFINITY));
            let (x, y) = points
                .iter()
                .fold(start, |(x, y), p| ((x.0.min(p.0), x.1.max(p.0)), (y.0.min(p.1), y.1.max(p.1))));
            ((x.0 - reach, x.1 + reach), (y.0 - reach, y.1 + reach))
        };
        let (x, y) = bounds(&points);
        let all = self.touched(x, y);
        let width = all.x.1 - all.x.0;
        let mut mask = std::mem::take(&mut self.mask);
        mask.clear();
        mask.resize(width * (all.y.1 - all.y.0), 0.0);
        for pair in points.windows(2) {
            let (x, y) = bounds(pair);
            let pixels = self.touched(x, y);
            for v in pixels.y.0..pixels.y.1 {
                let row = (v - all.y.0) * width;
                let span = segment_in_row(pair, v, reach, pixels.x);
                for u in span.0..span.1 {
                    let covered = covered(distance(pair, (u as f64 + 0.5, v as f64 + 0.5)), radius);
                    let most = &mut mask[row + u - all.x.0];
                    *most = most.max(covered as f32);
                }
            }
        }
        self.fill(all, stroke.rgb, |x, y| f64::from(mask[(y - all.y.0) * width + x - all.x.0]));
        self.mask = mask;
    }

    fn picture(&mut self, picture: &Picture) {
        let Area { x, y, .. } = picture.area;
        let ((x0, y0), (x1, y1)) = (scaled((x, y)), scaled((picture.area.right(), picture.area.bottom())));
        let (x0, y0, x1, y1) = (x0.round(), y0.round(), x1.round(), y1.round());
        let Some(image) = pixels(picture) else { return };
        let image =
            resize(&image, (x1 - x0).max(1.0) as u32, (y1 - y0).max(1.0) as u32, FilterType::Triangle);
        let all = self.touched((x0, x1), (y0, y1));
        for y in all.y.0..all.y.1 {
            for x in all.x.0..all.x.1 {
                let pixel = image.get_pixel((x as f64 - x0) as u32, (y as f64 - y0) as u32).0;
                self.dot(x, y, pixel, 1.0);
            }
        }
    }
}

/// The still as an image; none where its size does not fit its bytes.
pub fn pixels(picture: &Picture) -> Option<RgbImage> {
    let frame = &picture.frame;
    RgbImage::from_raw(frame.width() as u32, frame.height() as u32, frame.bytes().to_vec())
}

/// The still as it is embedded: at most three of its pixels a unit; more would only cost bytes.
pub fn reduced(picture: &Picture) -> RgbImage {
    let Some(image) = pixels(picture) else { return RgbImage::new(1, 1) };
    let (w, h) = ((picture.area.w * 3.0).ceil() as u32, (picture.area.h * 3.0).ceil() as u32);
    if image.width() <= w || image.height() <= h {
        return image;
    }
    resize(&image, w, h, FilterType::Triangle)
}

/// Distance of a point from the segment between two others.
fn distance(pair: &[Point], p: Point) -> f64 {
    let (a, b) = (pair[0], pair[1]);
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (px, py) = (p.0 - a.0, p.1 - a.1);
    let square = dx * dx + dy * dy;
    let t = if square > 0.0 { ((px * dx + py * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
    let (ex, ey) = (px - t * dx, py - t * dy);
    (ex * ex + ey * ey).sqrt()
}

/// Share of a pixel whose center is so far from the middle of a line.
fn covered(away: f64, radius: f64) -> f64 {
    ((away + 0.5).min(radius) - (away - 0.5).max(-radius)).max(0.0)
}

/// The pixels of row `v` that can be at most `reach` from a segment, among those of a range.
fn segment_in_row(pair: &[Point], v: usize, reach: f64, (from, to): (usize, usize)) -> (usize, usize) {
    let (a, b) = (pair[0], pair[1]);
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    // In a flat segment the whole range is near; elsewhere only what the band about the segment has of the row.
    if dy.abs() < 1.0 {
        return (from, to);
    }
    let slope = dx / dy;
    let middle = a.0 + (v as f64 + 0.5 - a.1) * slope;
    let half = reach * (1.0 + slope * slope).sqrt() + 1.0;
    let low = ((middle - half).floor().max(0.0) as usize).clamp(from, to);
    let high = ((middle + half).ceil().max(0.0) as usize).clamp(low, to);
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::super::style::Dash;
    use super::*;
    use proptest::prelude::*;

    /// How dark a black item makes the canvas, in pixels.
    fn darkness(w: usize, h: usize, item: &Item) -> f64 {
        let mut canvas = Canvas::new(w, h);
        canvas.item(item);
        canvas.rgb.iter().map(|v| f64::from(255 - v)).sum::<f64>() / 765.0
    }

    fn line(points: Vec<Point>, width: f64) -> Item {
        Item::Line { points, stroke: Stroke { rgb: [0; 3], width, dash: Dash::Solid } }
    }

    // Four pixels a square point.
    #[test]
    fn shapes_cover_their_area() {
        let area = Area { x: 3.1, y: 2.3, w: 0.2, h: 7.7 };
        let near = |item: &Item, area: f64, within: f64| {
            let dark = darkness(40, 40, item) / 4.0;
            assert!((dark - area).abs() < within, "{dark} {area}");
        };
        near(&Item::Rect { area, rgb: [0; 3] }, 0.2 * 7.7, 0.02);
        let corners = vec![(4.0, 3.0), (16.0, 5.0), (9.0, 15.0)];
        let turned: Vec<Point> = corners.iter().rev().copied().collect();
        near(&Item::Polygon { corners, rgb: [0; 3] }, 67.0, 0.5);
        near(&Item::Polygon { corners: turned, rgb: [0; 3] }, 67.0, 0.5);
        let circle = Item::Circle { center: (9.3, 8.8), radius: 4.0, rgb: [0; 3] };
        near(&circle, 16.0 * std::f64::consts::PI, 0.2);
        // A line with two round ends, and one that runs back over itself.
        let ends = std::f64::consts::PI * 0.7 * 0.7;
        near(&line(vec![(3.0, 5.0), (15.0, 10.0)], 1.4), 13.0 * 1.4 + ends, 0.3);
        near(&line(vec![(3.0, 5.0), (15.0, 10.0), (3.0, 5.0)], 1.4), 13.0 * 1.4 + ends, 0.3);
        near(&line(vec![(4.0, 5.0), (14.0, 5.0)], 0.3), 10.0 * 0.3, 0.25);
    }

    #[test]
    fn what_lies_outside_is_not_drawn() {
        for far in [-1e300, -100.0, 100.0, 1e300] {
            let area = Area { x: far, y: 2.0, w: 3.0, h: 3.0 };
            assert_eq!(darkness(20, 20, &Item::Rect { area, rgb: [0; 3] }), 0.0);
            let circle = Item::Circle { center: (far, far), radius: 2.0, rgb: [0; 3] };
            assert_eq!(darkness(20, 20, &circle), 0.0);
            assert_eq!(darkness(20, 20, &line(vec![(far, far), (far, 3.0)], 1.0)), 0.0);
        }
    }

    proptest! {
        #[test]
        fn rows_of_a_segment_hold_all_that_is_near(
            a in (0.0..60.0_f64, 0.0..60.0_f64), b in (0.0..60.0_f64, 0.0..60.0_f64), reach in 0.5..6.0_f64,
        ) {
            for v in 0..60 {
                let (from, to) = segment_in_row(&[a, b], v, reach, (0, 60));
                for u in (0..60).filter(|u| !(from..to).contains(u)) {
                    let away = distance(&[a, b], (u as f64 + 0.5, v as f64 + 0.5));
                    prop_assert!(away > reach, "{u} {v} {away}");
                }
            }
        }
    }
}
