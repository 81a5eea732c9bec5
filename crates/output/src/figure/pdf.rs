//! Draws a page as PDF at the width of the figure in print. Only the glyphs that are used are embedded; texts
//! can be searched and copied. The bytes depend on the page alone, without dates or random names.

use super::error::{FigureError, failed};
use super::font;
use super::page::{BAND, Page, Shape, share_before, strokes, whole, whole_width};
use super::raster::reduced;
use super::style::{Color, FINE, PER_INCH};
use ::image::RgbImage;
use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{CidFontType, FontFlags, LineCapStyle, LineJoinStyle, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use subsetter::GlyphRemapper;

/// PDF points per unit.
const POINT: f64 = 72.0 / PER_INCH;
/// Level of compression, 0 to 10.
const LEVEL: u8 = 6;

const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const INFO: Ref = Ref::new(5);
const FONT: Ref = Ref::new(6);
const CID_FONT: Ref = Ref::new(7);
const DESCRIPTOR: Ref = Ref::new(8);
const TO_UNICODE: Ref = Ref::new(9);
const FONT_FILE: Ref = Ref::new(10);
const SEE_THROUGH: Ref = Ref::new(11);
/// Object number of the first video frame.
const FIRST_FRAME: i32 = 12;

const IDENTITY: SystemInfo<'static> =
    SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

/// Glyphs used on a page: renumbered in order of first use, each with its character.
#[derive(Default)]
struct Letters {
    numbers: GlyphRemapper,
    characters: BTreeMap<u16, char>,
}

impl Letters {
    fn encoded(&mut self, text: &str) -> Vec<u8> {
        let mut bytes = Vec::new();
        for c in text.chars() {
            let number = self.numbers.remap(font::glyph(c));
            self.characters.entry(number).or_insert(c);
            bytes.extend(number.to_be_bytes());
        }
        bytes
    }
}

fn shares(color: Color) -> [f32; 3] {
    color.0.map(|c| f32::from(c) / 255.0)
}

/// Starts a path through points.
fn path(content: &mut Content, points: &[(i32, i32)]) {
    for (k, (x, y)) in points.iter().enumerate() {
        let draw = if k == 0 { Content::move_to } else { Content::line_to };
        draw(content, *x as f32, *y as f32);
    }
}

/// Draws a shape in coordinates of [`FINE`] per unit.
fn write_shape(content: &mut Content, letters: &mut Letters, shape: &Shape) {
    match shape {
        Shape::Line { points, style } => {
            let [r, g, b] = shares(style.color);
            let width = whole_width(style, FINE) as f32;
            for run in strokes(points, style.dash, FINE) {
                content.set_stroke_rgb(r, g, b).set_line_width(width);
                path(content, &run);
                content.stroke();
            }
        }
        Shape::Fill { corners, color, opacity } => {
            let [r, g, b] = shares(*color);
            content.save_state();
            if *opacity < 1.0 {
                content.set_parameters(Name(b"B"));
            }
            content.set_fill_rgb(r, g, b);
            path(content, &whole(corners, FINE));
            content.fill_nonzero().restore_state();
        }
        Shape::Text { text, at, size, anchor, upwards, color } => {
            let (size, at) = (size * FINE, whole(&[*at], FINE)[0]);
            let (x, y) = (f64::from(at.0), f64::from(at.1));
            let (back, base) = (font::width(text, size) * share_before(*anchor), font::HALF_EX * size);
            // Letters stand on their heads on a sheet, whose y points down.
            let matrix = if *upwards {
                [0.0, -1.0, -1.0, 0.0, (x + base) as f32, (y + back) as f32]
            } else {
                [1.0, 0.0, 0.0, -1.0, (x - back) as f32, (y + base) as f32]
            };
            let [r, g, b] = shares(*color);
            let letters = letters.encoded(text);
            content.set_fill_rgb(r, g, b);
            content.begin_text().set_font(Name(b"F"), size as f32);
            content.set_text_matrix(matrix).show(Str(&letters)).end_text();
        }
    }
}

/// Draws the page.
///
/// # Errors
/// [`FigureError::Draw`] if the font cannot be reduced to the used glyphs.
pub fn pdf(page: &Page) -> Result<Vec<u8>, FigureError> {
    // As wide and high as in inches to three places, without the noise of narrow numbers.
    let points = |units: f64| ((units * POINT * 1000.0).round() / 1000.0) as f32;
    let (width, height) = (points(page.width), points(page.height.ceil()));
    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let name = |k: usize| format!("P{k}");
    let number = |k: usize| Ref::new(FIRST_FRAME + k as i32);
    let mut leaf = pdf.page(PAGE);
    leaf.parent(PAGES).media_box(Rect::new(0.0, 0.0, width, height)).contents(CONTENT);
    let mut resources = leaf.resources();
    resources.fonts().pair(Name(b"F"), FONT);
    resources.ext_g_states().pair(Name(b"B"), SEE_THROUGH);
    if !page.frames.is_empty() {
        let mut frames = resources.x_objects();
        for k in 0..page.frames.len() {
            frames.pair(Name(name(k).as_bytes()), number(k));
        }
    }
    resources.finish();
    leaf.finish();
    pdf.ext_graphics(SEE_THROUGH).non_stroking_alpha(BAND as f32);
    if !page.title.trim().is_empty() {
        pdf.document_info(INFO).title(TextStr(&page.title));
    }

    let mut content = Content::new();
    // From the sheet's lower left corner to the page's upper left one.
    let scale = (POINT / FINE) as f32;
    content.transform([scale, 0.0, 0.0, -scale, 0.0, height]);
    content.set_line_cap(LineCapStyle::RoundCap).set_line_join(LineJoinStyle::RoundJoin);
    for (k, (area, frame)) in page.frames.iter().enumerate() {
        let [x, bottom, w, h] = [area.x, area.bottom(), area.w, area.h].map(|v| (v * FINE) as f32);
        content.save_state();
        content.transform([w, 0.0, 0.0, -h, x, bottom]);
        content.x_object(Name(name(k).as_bytes()));
        content.restore_state();
        write_image(&mut pdf, number(k), &reduced(area, frame));
    }
    let mut letters = Letters::default();
    page.shapes.iter().for_each(|shape| write_shape(&mut content, &mut letters, shape));
    let content = compress_to_vec_zlib(&content.finish(), LEVEL);
    pdf.stream(CONTENT, &content).filter(Filter::FlateDecode);
    write_font(&mut pdf, &letters)?;
    Ok(pdf.finish())
}

fn write_image(pdf: &mut Pdf, id: Ref, image: &RgbImage) {
    let bytes = compress_to_vec_zlib(image.as_raw(), LEVEL);
    let mut object = pdf.image_xobject(id, &bytes);
    object.filter(Filter::FlateDecode);
    object.width(image.width() as i32).height(image.height() as i32);
    object.color_space().device_rgb();
    object.bits_per_component(8).interpolate(true);
}

/// Tag of six capital letters that identifies this subset of the font.
fn tag(letters: &Letters) -> String {
    let mut digest = Sha256::new();
    for glyph in letters.numbers.remapped_gids() {
        digest.update(glyph.to_be_bytes());
    }
    digest.finalize().iter().take(6).map(|byte| char::from(b'A' + byte % 26)).collect()
}

fn write_font(pdf: &mut Pdf, letters: &Letters) -> Result<(), FigureError> {
    let file = subsetter::subset(font::BYTES, 0, &letters.numbers).map_err(failed)?;
    let name = format!("{}+DejaVuSans", tag(letters));
    let name = Name(name.as_bytes());
    pdf.type0_font(FONT)
        .base_font(name)
        .encoding_predefined(Name(b"Identity-H"))
        .descendant_font(CID_FONT)
        .to_unicode(TO_UNICODE);
    let mut cid = pdf.cid_font(CID_FONT);
    cid.subtype(CidFontType::Type2).base_font(name).system_info(IDENTITY).font_descriptor(DESCRIPTOR);
    cid.default_width(0.0).cid_to_gid_map_predefined(Name(b"Identity"));
    let widths = letters.numbers.remapped_gids().map(|glyph| font::glyph_width(glyph, 1000.0) as f32);
    cid.widths().consecutive(0, widths);
    cid.finish();
    // Measures of the font's table `head` and `hhea`, in thousandths of an em.
    pdf.font_descriptor(DESCRIPTOR)
        .name(name)
        .flags(FontFlags::SYMBOLIC)
        .bbox(Rect::new(-1021.0, -463.0, 1794.0, 1233.0))
        .italic_angle(0.0)
        .ascent(928.0)
        .descent(-236.0)
        .cap_height(729.0)
        .stem_v(80.0)
        .font_file2(FONT_FILE);
    let mut map = UnicodeCmap::<u16>::new(Name(b"Letters"), IDENTITY);
    letters
        .characters
        .iter()
        .filter(|(number, _)| **number > 0)
        .for_each(|(number, c)| map.pair(*number, *c));
    let map = map.finish();
    pdf.cmap(TO_UNICODE, &map);
    let packed = compress_to_vec_zlib(&file, LEVEL);
    let mut stream = pdf.stream(FONT_FILE, &packed);
    stream.filter(Filter::FlateDecode);
    stream.pair(Name(b"Length1"), file.len() as i32);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::style::{COLUMN, INK, Style};
    use super::*;
    use plotters::style::text_anchor::HPos;

    fn page() -> Page {
        let mut page = Page::new("Wörter (1)", COLUMN);
        page.height = 40.0;
        page.line(vec![(1.0, 2.0), (30.0, 4.0)], Style::solid(INK, 1.0));
        page.disc((9.0, 9.0), 3.0, INK);
        page.band(vec![(0.0, 1.0), (9.0, 2.0), (9.0, 6.0), (0.0, 5.0)], INK);
        page.text("yₜ (F₁) 漢", (20.0, 20.0), 11.0, HPos::Right, INK);
        page.lines_upwards(vec!["up".into()], (20.0, 20.0), 11.0, INK);
        page
    }

    #[test]
    fn a_file_is_as_wide_as_the_figure_in_print_and_small_and_the_same_each_time() {
        let bytes = pdf(&page()).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(bytes.starts_with(b"%PDF-1.7") && bytes.trim_ascii_end().ends_with(b"%%EOF"));
        // 3.3 inches of 72 points, 40 units of 0.7.
        assert!(text.contains("/MediaBox [0 0 237.6") && text.contains(" 28]"), "{text}");
        assert!(text.contains("+DejaVuSans") && text.contains("/FontFile2"));
        assert!(!text.contains("/CreationDate") && !text.contains("/ID"));
        assert_eq!(bytes, pdf(&page()).unwrap());
        assert!(bytes.len() < 20_000, "{}", bytes.len());
        assert!(pdf(&Page::new("", 10.0)).is_ok());
    }

    #[test]
    fn letters_are_numbered_in_the_order_in_which_they_come() {
        let mut letters = Letters::default();
        // What the font does not have is its empty box.
        assert_eq!(letters.encoded("yₜy漢"), [0, 1, 0, 2, 0, 1, 0, 0]);
        let first: Vec<char> = letters.characters.iter().filter(|c| *c.0 > 0).map(|c| *c.1).collect();
        assert_eq!(first, ['y', 'ₜ']);
    }
}
