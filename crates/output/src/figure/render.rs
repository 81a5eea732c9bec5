//! Draws the SVG of a page as bitmap (by resvg) and as PDF (by krilla). The bytes depend on the SVG alone, without
//! dates or random names.

use super::error::{FigureError, failed};
use super::font;
use super::page::Page;
use super::style::PER_INCH;
use ::image::{DynamicImage, RgbImage, RgbaImage};
use krilla::Document;
use krilla::geom::Size;
use krilla::metadata::Metadata;
use krilla::page::PageSettings;
use krilla_svg::{SurfaceExt, SvgSettings};
use resvg::tiny_skia::{IntSize, Pixmap, Transform};
use resvg::usvg::fontdb::Source;
use resvg::usvg::{Options, Tree};
use std::sync::{Arc, LazyLock};

/// Pixels per unit of a bitmap: 206 per inch.
pub const PIXELS: f64 = 2.0;

/// How SVG is read: with the embedded font alone.
static OPTIONS: LazyLock<Options<'static>> = LazyLock::new(|| {
    let mut options = Options::default();
    options.fontdb_mut().load_font_source(Source::Binary(Arc::new(font::BYTES)));
    options
});

/// Reads the SVG of a page, for both formats.
///
/// # Errors
/// [`FigureError::Draw`] if the text is not SVG.
pub fn tree(svg: &str) -> Result<Tree, FigureError> {
    Tree::from_str(svg, &OPTIONS).map_err(failed)
}

/// Draws a page on an image with [`PIXELS`] per unit.
pub fn paint(image: RgbImage, page: &Page, tree: &Tree) -> Result<RgbImage, FigureError> {
    let (width, height) = image.dimensions();
    let opaque = DynamicImage::ImageRgb8(image).into_rgba8().into_raw();
    let size = IntSize::from_wh(width, height).and_then(|size| Pixmap::from_vec(opaque, size));
    let mut pixels = size.ok_or_else(|| failed("it has no pixels"))?;
    let scale = (page.width * PIXELS) as f32 / tree.size().width();
    resvg::render(tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    let drawn =
        RgbaImage::from_raw(width, height, pixels.take()).ok_or_else(|| failed("it has lost pixels"))?;
    Ok(DynamicImage::ImageRgba8(drawn).into_rgb8())
}

/// The page as a PNG file.
pub fn png(page: &Page, tree: &Tree) -> Result<Vec<u8>, FigureError> {
    let side = |units: f64| (units.ceil() * PIXELS) as u32;
    let white = RgbImage::from_pixel(side(page.width), side(page.height), ::image::Rgb([255; 3]));
    encode(&paint(white, page, tree)?)
}

/// Encodes an image as PNG with its pixels per meter, so that programs show a figure at its print size.
pub fn encode(image: &RgbImage) -> Result<Vec<u8>, FigureError> {
    let mut out = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut out, image.width(), image.height());
    encoder.set_color(::png::ColorType::Rgb);
    encoder.set_depth(::png::BitDepth::Eight);
    let density = (PIXELS * PER_INCH / 0.0254).round() as u32;
    let unit = ::png::Unit::Meter;
    encoder.set_pixel_dims(Some(::png::PixelDimensions { xppu: density, yppu: density, unit }));
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(image.as_raw()).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(out)
}

/// The page as a PDF file of its size in print. It holds the glyphs that are used; texts can be searched and copied.
pub fn pdf(page: &Page, tree: &Tree) -> Result<Vec<u8>, FigureError> {
    // As wide and high as in inches to three places, without the noise of narrow numbers.
    let points = |units: f64| ((units * 72.0 / PER_INCH * 1000.0).round() / 1000.0) as f32;
    let (width, height) = (points(page.width), points(page.height.ceil()));
    let nothing = || failed("it has no size");
    let mut document = Document::new();
    let mut leaf = document.start_page_with(PageSettings::from_wh(width, height).ok_or_else(nothing)?);
    let mut surface = leaf.surface();
    let size = Size::from_wh(width, height).ok_or_else(nothing)?;
    surface.draw_svg(tree, size, SvgSettings::default()).ok_or_else(nothing)?;
    surface.finish();
    leaf.finish();
    document.set_metadata(Metadata::new().title(page.title.trim().into()));
    document.finish().map_err(|e| failed(format!("{e:?}")))
}

#[cfg(test)]
mod tests {
    use super::super::output::{document, svg};
    use super::super::page::Point;
    use super::super::style::{COLUMN, Color, INK, Style};
    use super::*;
    use plotters::style::text_anchor::HPos;
    use std::f64::consts::PI;

    #[test]
    fn a_pdf_is_as_wide_as_the_figure_in_print_and_small_and_the_same_each_time() {
        let mut page = Page::new("Wörter (1)", COLUMN);
        page.height = 40.0;
        page.line(vec![(1.0, 2.0), (30.0, 4.0)], Style::solid(INK, 1.0));
        page.text("yₜ (F₁) 漢", (20.0, 20.0), 11.0, HPos::Right, INK);
        page.lines_upwards(vec!["up".into()], (20.0, 20.0), 11.0, INK);
        let made = || pdf(&page, &tree(&svg(&page).unwrap()).unwrap()).unwrap();
        let (bytes, again) = (made(), made());
        let text = String::from_utf8_lossy(&bytes);
        // 3.3 inches of 72 points, 40 units of 0.7.
        assert!(text.starts_with("%PDF-1.7") && text.contains("/MediaBox[0 0 237.6 28]"), "{text}");
        assert!(text.contains("+DejaVuSans") && text.contains("/ToUnicode") && !text.contains("Date"));
        assert!(bytes == again && bytes.len() < 20_000, "{}", bytes.len());
    }

    /// Total darkness, in square units, that black shapes add to a page of 40 units.
    fn darkness(add: impl Fn(&mut Page)) -> f64 {
        let mut page = Page { height: 40.0, ..Page::new("", 40.0) };
        add(&mut page);
        let white = RgbImage::from_pixel(80, 80, ::image::Rgb([255; 3]));
        let image = paint(white, &page, &tree(&document(&page, "", "").unwrap()).unwrap()).unwrap();
        image.as_raw().iter().map(|v| f64::from(255 - v)).sum::<f64>() / 765.0 / PIXELS / PIXELS
    }

    #[test]
    fn shapes_cover_their_area() {
        let near = |add: &dyn Fn(&mut Page), area: f64, within: f64| {
            let dark = darkness(add);
            assert!((dark - area).abs() < within, "{dark} {area}");
        };
        let black = Color::BLACK;
        near(&|page: &mut Page| page.fill(vec![(4.0, 3.0), (16.0, 5.0), (9.0, 15.0)], black), 67.0, 1.0);
        // Round ends are drawn as curves that lie a little inside the circle.
        near(&|page: &mut Page| page.disc((9.3, 8.8), 4.0, black), 16.0 * PI, 1.2);
        // A line with two round ends, and one that runs back over itself.
        let line = |points: &[Point], page: &mut Page| page.line(points.into(), Style::solid(black, 1.5));
        let (from, to) = ((3.0, 5.0), (15.0, 10.0));
        let area = 13.0 * 1.5 + PI * 0.75 * 0.75;
        near(&|page: &mut Page| line(&[from, to], page), area, 0.5);
        near(&|page: &mut Page| line(&[from, to, from], page), area, 0.5);
    }
}
