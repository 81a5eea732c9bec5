//! Draws a scene as a PDF of one page, as wide as the figure is in print, with the letters that it uses of the embedded
//! font. Texts can be searched and copied. The bytes depend on the scene alone: no date, no random name.

use super::error::FigureError;
use super::font;
use super::raster::reduced;
use super::scene::{Anchor, Area, BAND, Item, Picture, Point, Scene, Stroke};
use super::style::PER_INCH;
use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{CidFontType, FontFlags, LineCapStyle, LineJoinStyle, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use subsetter::GlyphRemapper;

/// Points per unit of a scene.
const POINTS: f32 = (72.0 / PER_INCH) as f32;
/// Level of compression.
const LEVEL: u8 = 6;
/// Distance of the control points of a quarter of a circle from its ends, as a share of the radius.
const QUARTER: f32 = 0.552_284_8;

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
/// Pictures have the numbers from here on.
const FIRST_PICTURE: i32 = 12;

const IDENTITY: SystemInfo<'static> =
    SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

fn failed(e: impl std::fmt::Display) -> FigureError {
    FigureError::Draw(e.to_string())
}

/// The letters of a scene: glyphs of the font, numbered anew, with the characters that they stand for.
#[derive(Default)]
struct Letters {
    numbers: GlyphRemapper,
    characters: BTreeMap<u16, char>,
}

impl Letters {
    fn of(scene: &Scene) -> Self {
        let mut letters = Self::default();
        for item in &scene.items {
            let Item::Text { text, .. } = item else { continue };
            for c in text.chars() {
                let number = letters.numbers.remap(font::glyph(c));
                letters.characters.entry(number).or_insert(c);
            }
        }
        letters
    }

    fn encoded(&self, text: &str) -> Vec<u8> {
        let number = |c| self.numbers.get(font::glyph(c)).unwrap_or(0);
        text.chars().flat_map(|c| number(c).to_be_bytes()).collect()
    }
}

/// Draws the scene.
///
/// # Errors
/// [`FigureError::Draw`] when the font cannot be cut down to its letters.
pub fn pdf(scene: &Scene) -> Result<Vec<u8>, FigureError> {
    // As wide and high as in inches to three places, without the noise of narrow numbers.
    let points = |units: f64| ((units * 72.0 / PER_INCH * 1000.0).round() / 1000.0) as f32;
    let (width, height) = (points(scene.width), points(scene.height.ceil()));
    let letters = Letters::of(scene);
    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let name = |k: usize| format!("P{k}");
    let mut page = pdf.page(PAGE);
    page.parent(PAGES).media_box(Rect::new(0.0, 0.0, width, height)).contents(CONTENT);
    let mut resources = page.resources();
    resources.fonts().pair(Name(b"F"), FONT);
    resources.ext_g_states().pair(Name(b"B"), SEE_THROUGH);
    if !scene.pictures.is_empty() {
        let mut pictures = resources.x_objects();
        for k in 0..scene.pictures.len() {
            pictures.pair(Name(name(k).as_bytes()), Ref::new(FIRST_PICTURE + k as i32));
        }
    }
    resources.finish();
    page.finish();
    pdf.ext_graphics(SEE_THROUGH).non_stroking_alpha(BAND as f32);
    if !scene.title.trim().is_empty() {
        pdf.document_info(INFO).title(TextStr(&scene.title));
    }
    write_font(&mut pdf, &letters)?;

    let mut content = Content::new();
    // From the page's lower left corner to the scene's upper left one.
    content.transform([POINTS, 0.0, 0.0, -POINTS, 0.0, height]);
    content.set_line_cap(LineCapStyle::RoundCap).set_line_join(LineJoinStyle::RoundJoin);
    for (k, picture) in scene.pictures.iter().enumerate() {
        let Area { x, w, h, .. } = picture.area;
        let bottom = picture.area.bottom() as f32;
        content.save_state();
        content.transform([w as f32, 0.0, 0.0, -h as f32, x as f32, bottom]);
        content.x_object(Name(name(k).as_bytes()));
        content.restore_state();
        write_picture(&mut pdf, Ref::new(FIRST_PICTURE + k as i32), picture);
    }
    for item in &scene.items {
        draw(&mut content, item, &letters);
    }
    let content = compress_to_vec_zlib(&content.finish(), LEVEL);
    pdf.stream(CONTENT, &content).filter(Filter::FlateDecode);
    Ok(pdf.finish())
}

fn place((x, y): Point) -> (f32, f32) {
    (x as f32, y as f32)
}

fn share(rgb: [u8; 3]) -> [f32; 3] {
    rgb.map(|c| f32::from(c) / 255.0)
}

/// Begins a path through points.
fn path<'p>(content: &mut Content, points: impl IntoIterator<Item = &'p Point>) {
    for (k, point) in points.into_iter().enumerate() {
        let (x, y) = place(*point);
        if k == 0 {
            content.move_to(x, y)
        } else {
            content.line_to(x, y)
        };
    }
}

fn fill_color(content: &mut Content, rgb: [u8; 3]) {
    let [r, g, b] = share(rgb);
    content.set_fill_rgb(r, g, b);
}

fn draw(content: &mut Content, item: &Item, letters: &Letters) {
    match item {
        Item::Line { points, stroke: Stroke { rgb, width, dash } } => {
            let [r, g, b] = share(*rgb);
            content.set_stroke_rgb(r, g, b).set_line_width(*width as f32);
            content.set_dash_pattern(dash.pattern().iter().map(|length| *length as f32), 0.0);
            path(content, points);
            content.stroke();
        }
        Item::Rect { area, rgb } => {
            fill_color(content, *rgb);
            content.rect(area.x as f32, area.y as f32, area.w as f32, area.h as f32).fill_nonzero();
        }
        Item::Polygon { corners, rgb } => {
            fill_color(content, *rgb);
            path(content, corners);
            content.fill_nonzero();
        }
        Item::Band { upper, lower, rgb } => {
            content.save_state().set_parameters(Name(b"B"));
            fill_color(content, *rgb);
            path(content, upper.iter().chain(lower.iter().rev()));
            content.fill_nonzero().restore_state();
        }
        Item::Circle { center, radius, rgb } => {
            let ((x, y), r) = (place(*center), *radius as f32);
            let q = r * QUARTER;
            fill_color(content, *rgb);
            content.move_to(x + r, y);
            content.cubic_to(x + r, y + q, x + q, y + r, x, y + r);
            content.cubic_to(x - q, y + r, x - r, y + q, x - r, y);
            content.cubic_to(x - r, y - q, x - q, y - r, x, y - r);
            content.cubic_to(x + q, y - r, x + r, y - q, x + r, y);
            content.fill_nonzero();
        }
        Item::Text { text, at, size, anchor, upwards, rgb } => {
            let length = font::width(text, *size);
            let back = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => length / 2.0,
                Anchor::End => length,
            };
            let base = font::HALF_EX * size;
            fill_color(content, *rgb);
            content.begin_text().set_font(Name(b"F"), *size as f32);
            // Letters stand on their heads in a scene, whose y points down.
            let matrix = if *upwards {
                let (x, y) = place((at.0 + base, at.1 + back));
                [0.0, -1.0, -1.0, 0.0, x, y]
            } else {
                let (x, y) = place((at.0 - back, at.1 + base));
                [1.0, 0.0, 0.0, -1.0, x, y]
            };
            content.set_text_matrix(matrix).show(Str(&letters.encoded(text))).end_text();
        }
    }
}

fn write_picture(pdf: &mut Pdf, id: Ref, picture: &Picture) {
    let image = reduced(picture);
    let bytes = compress_to_vec_zlib(image.as_raw(), LEVEL);
    let mut object = pdf.image_xobject(id, &bytes);
    object.filter(Filter::FlateDecode);
    object.width(image.width() as i32).height(image.height() as i32);
    object.color_space().device_rgb();
    object.bits_per_component(8).interpolate(true);
}

/// Six capital letters that name these letters of the font.
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
    use super::*;
    use crate::figure::style::{COLUMN, Dash, INK};

    fn scene() -> Scene {
        let mut scene = Scene::new("Wörter (1)", COLUMN);
        scene.height = 40.0;
        scene.line(vec![(1.0, 2.0), (30.0, 4.0)], Stroke { rgb: INK, width: 1.0, dash: Dash::Dashed });
        scene.items.push(Item::Circle { center: (9.0, 9.0), radius: 3.0, rgb: INK });
        let (upper, lower) = (vec![(0.0, 1.0), (9.0, 2.0)], vec![(0.0, 5.0), (9.0, 6.0)]);
        scene.items.push(Item::Band { upper, lower, rgb: INK });
        scene.text("yₜ (F₁) 漢", (20.0, 20.0), 11.0, Anchor::End, INK);
        scene.text_upwards("up", (20.0, 20.0), 11.0, INK);
        scene
    }

    #[test]
    fn the_page_is_as_wide_as_the_figure_in_print() {
        let bytes = pdf(&scene()).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(bytes.starts_with(b"%PDF-1.7") && bytes.trim_ascii_end().ends_with(b"%%EOF"));
        // 3.3 inches of 72 points, 40 units of 0.7.
        assert!(text.contains("/MediaBox [0 0 237.6") && text.contains(" 28]"), "{text}");
        assert!(text.contains("+DejaVuSans") && text.contains("/FontFile2"));
        assert!(!text.contains("/CreationDate") && !text.contains("/ID"));
    }

    #[test]
    fn the_same_scene_gives_the_same_bytes_and_few_letters_a_small_file() {
        let bytes = pdf(&scene()).unwrap();
        assert_eq!(bytes, pdf(&scene()).unwrap());
        assert!(bytes.len() < 20_000, "{}", bytes.len());
        assert!(pdf(&Scene::new("", 10.0)).is_ok());
    }

    #[test]
    fn letters_are_numbered_in_the_order_in_which_they_come() {
        let letters = Letters::of(&scene());
        let first: Vec<char> = letters.characters.iter().filter(|c| *c.0 > 0).map(|c| *c.1).take(3).collect();
        assert_eq!(first, ['y', 'ₜ', ' ']);
        // What the font does not have is its empty box.
        assert_eq!(letters.encoded("y漢"), [0, 1, 0, 0]);
    }
}
