//! A video frame with boxes and a line of text drawn on its pixels.

use super::font;
use super::output::document;
use super::page::{Area, Page, Point};
use super::render::{PIXELS, paint, tree};
use super::still::pixels;
use super::style::{CASING, Color, Dash, Style};
use plotters::style::text_anchor::HPos;
use trackfail_core::image::Frame;
use trackfail_core::region::Region;

/// A box to be drawn on a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct AnnotatedBox {
    /// Place of the box in pixels of the frame. Parts outside the frame are cut off.
    pub region: Region,
    /// Color of line and label.
    pub color: Color,
    /// Line style of the box.
    pub dash: Dash,
    /// Text above the box; may be empty.
    pub label: String,
}

/// Height of a line of text, as a share of the frame's height.
const TEXT: f64 = 1.0 / 24.0;
/// Least height of the text, in pixels.
const SMALLEST_TEXT: f64 = 11.0;
/// Least width of a line, in pixels.
const THINNEST_LINE: f64 = 3.0;

/// Draws boxes on a copy of the frame, and text in the upper left corner, in as many lines as needed.
pub fn annotate(frame: &Frame, boxes: &[AnnotatedBox], text: &str, color: Color) -> Frame {
    let (w, h) = (frame.width() as f64 / PIXELS, frame.height() as f64 / PIXELS);
    let area = Area { x: 0.0, y: 0.0, w, h };
    let size = (h * TEXT).max(SMALLEST_TEXT / PIXELS);
    let width = (size / 6.0).max(THINNEST_LINE / PIXELS);
    let mut page = Page { height: h, ..Page::new("", w) };
    for (k, line) in font::wrap(text, size, w - size).iter().enumerate() {
        plate(&mut page, line, (0.0, 1.5 * size * k as f64), size, color);
    }
    for AnnotatedBox { region, color, dash, label } in boxes {
        let corners: Vec<Point> = region.corners().iter().map(|c| (c.0 / PIXELS, c.1 / PIXELS)).collect();
        let least = |side: fn(&Point) -> f64| corners.iter().map(side).fold(f64::INFINITY, f64::min);
        let (left, top) = (least(|c| c.0).max(0.0), least(|c| c.1).max(1.5 * size) - 1.5 * size);
        if page.outline(corners, &area, Style { color: *color, dash: *dash, width }, 2.0 * width) {
            plate(&mut page, label, (left, top), size, *color);
        }
    }
    let drawn = document(&page, "", "").and_then(|svg| paint(pixels(frame), &page, &tree(&svg)?));
    let image = drawn.expect("what is drawn here is SVG, and a frame has pixels");
    Frame::new(frame.width(), frame.height(), image.into_raw())
}

/// Draws text on a dark ground, with the upper left corner at a point.
fn plate(page: &mut Page, text: &str, (x, y): Point, size: f64, color: Color) {
    if text.is_empty() {
        return;
    }
    let text = font::clean(text);
    let area = Area { x, y, w: font::width(&text, size) + size, h: 1.5 * size };
    page.fill(area.corners(), CASING);
    page.text(&text, (x + size / 2.0, y + 0.75 * size), size, HPos::Left, color.bright());
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_core::region::Rect;

    fn gray() -> Frame {
        Frame::from_fn(121, 81, |_, _| [128; 3])
    }

    fn at(x: f64, y: f64) -> AnnotatedBox {
        let region = Region::Rect(Rect::new(x, y, 30.0, 20.0));
        AnnotatedBox { region, color: Color::VERMILION, dash: Dash::SOLID, label: String::new() }
    }

    #[test]
    fn a_box_is_where_its_region_is() {
        let drawn = annotate(&gray(), &[at(40.0, 30.0)], "", Color::GREEN);
        assert_eq!((drawn.width(), drawn.height()), (121, 81));
        for (x, y) in [(40, 40), (55, 30), (70, 40), (55, 50)] {
            let near = [(0, 0), (1, 0), (0, 1)].map(|(i, j)| drawn.pixel(x - i, y - j));
            assert!(near.contains(&Color::VERMILION.0), "{x} {y} {near:?}");
        }
        for (x, y) in [(55, 40), (20, 40), (90, 40), (55, 15), (55, 70)] {
            assert_eq!(drawn.pixel(x, y), [128; 3], "{x} {y}");
        }
    }

    #[test]
    fn text_stands_in_the_corner_and_boxes_may_leave_the_frame() {
        let plain = annotate(&gray(), &[], "", Color::GREEN);
        assert_eq!(plain, gray());
        let text = annotate(&gray(), &[], "frame 52, lost", Color::SKY);
        assert_eq!(text.pixel(1, 1), CASING.0);
        assert_eq!(text.pixel(60, 60), [128; 3]);
        let nowhere = Region::Rect(Rect::new(f64::NAN, 0.0, 1.0, 1.0));
        let far = [at(-500.0, 10.0), at(1e9, 1e9), AnnotatedBox { region: nowhere, ..at(0.0, 0.0) }];
        assert_eq!(annotate(&gray(), &far, "", Color::GREEN), gray());
        assert_ne!(annotate(&gray(), &[at(-10.0, -10.0)], "", Color::GREEN), gray());
    }
}
