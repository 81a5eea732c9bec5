//! Video frames above the panels of a figure, with boxes.

use super::font;
use super::legend::{AROUND_BOX, BOX, Entry, Symbol};
use super::page::{Area, LINE, Page};
use super::style::{Color, Dash, INK, MARGIN, SMALL, Style};
use ::image::imageops::FilterType;
use ::image::{DynamicImage, RgbImage};
use plotters::style::text_anchor::HPos;
use trackfail_core::image::Frame;
use trackfail_core::region::Region;

/// Kind of a box on a still: its line, and its name in the legend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxStyle {
    line: Style,
    name: &'static str,
}

impl BoxStyle {
    /// The background region B_t, red.
    pub const BACKGROUND: Self =
        Self { line: Style::solid(Color([0xFF, 0x4B, 0x1F]), BOX), name: "background region" };
    /// The tracker's state, yellow.
    pub const STATE: Self = Self { line: Style::solid(Color::YELLOW, BOX), name: "tracker" };
    /// The ground truth, green and dashed.
    pub const TRUTH: Self = Self {
        line: Style { color: Color([0x00, 0xD0, 0x8A]), dash: Dash::DASHED, width: BOX },
        name: "ground truth",
    };
}

/// A video frame shown above the panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Still {
    /// Number of the frame in the dataset.
    pub number: u32,
    /// Pixels of the frame.
    pub pixels: Frame,
    /// Boxes in pixels of the frame, clipped at its border.
    pub boxes: Vec<(Region, BoxStyle)>,
    /// Text after the frame number; may be empty.
    pub caption: String,
}

/// Least width of a still, in units.
const LEAST: f64 = 140.0;
const GAP: f64 = 6.0;

/// Legend of the boxes on stills.
pub fn box_legend(stills: &[Still]) -> Vec<Entry> {
    let has = |style: &BoxStyle| stills.iter().flat_map(|s| &s.boxes).any(|b| b.1 == *style);
    let entry = |style: BoxStyle| Entry::new(Symbol::Outline(style.line), style.name);
    [BoxStyle::BACKGROUND, BoxStyle::STATE, BoxStyle::TRUTH].into_iter().filter(has).map(entry).collect()
}

/// Draws stills below `y`, five per row, or two in a narrow figure. Returns the height at which the page is
/// free below them.
pub fn draw_stills(page: &mut Page, stills: &[Still], mut y: f64) -> f64 {
    let most = ((page.width / LEAST) as usize).max(1);
    let a_row = stills.len().max(3).min(most);
    let w = (page.width - 2.0 * MARGIN - GAP * (a_row - 1) as f64) / a_row as f64;
    for row in stills.chunks(a_row) {
        // Frames taller than wide are kept to the height of a square.
        let size = |still: &Still| {
            let aspect = still.pixels.height() as f64 / still.pixels.width() as f64;
            if aspect > 1.0 { (w / aspect, w) } else { (w, w * aspect) }
        };
        let tallest = row.iter().map(|s| size(s).1).fold(0.0, f64::max);
        let mut bottom = y + tallest;
        for (i, still) in row.iter().enumerate() {
            let (sw, sh) = size(still);
            let middle = MARGIN + i as f64 * (w + GAP) + w / 2.0;
            draw_still(page, still, Area { x: middle - sw / 2.0, y: y + tallest - sh, w: sw, h: sh });
            let text = match still.caption.trim() {
                "" => format!("frame {}", still.number),
                caption => format!("frame {}: {caption}", still.number),
            };
            let lines = font::wrap(&text, SMALL, w);
            bottom = bottom.max(page.lines(&lines, (middle, y + tallest + 2.0), SMALL, HPos::Center, INK));
        }
        y = bottom + LINE / 2.0;
    }
    y
}

fn draw_still(page: &mut Page, still: &Still, area: Area) {
    let (sx, sy) = (area.w / still.pixels.width() as f64, area.h / still.pixels.height() as f64);
    for (region, style) in &still.boxes {
        let corners = region.corners().iter().map(|c| (area.x + c.0 * sx, area.y + c.1 * sy)).collect();
        page.outline(corners, &area, style.line, AROUND_BOX);
    }
    page.frames.push((area, still.pixels.clone()));
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
    if image.width() <= w || image.height() <= h {
        return image;
    }
    DynamicImage::ImageRgb8(image).resize_exact(w, h, FilterType::Triangle).into_rgb8()
}
