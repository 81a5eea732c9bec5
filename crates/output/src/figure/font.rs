//! The embedded font: widths, and text broken into lines.

use ab_glyph::{Font, FontRef, ScaleFont};
use std::sync::LazyLock;

/// Font families for SVG viewers. Widths are measured in DejaVu Sans; Verdana is as wide and the others are
/// narrower, so measured text fits in each of them.
pub const FAMILY: &str = "DejaVu Sans, Verdana, Geneva, sans-serif";

/// Contents of the font file.
pub const BYTES: &[u8] = include_bytes!("../../../../assets/fonts/DejaVuSans.ttf");

static FACE: LazyLock<FontRef<'static>> =
    LazyLock::new(|| FontRef::try_from_slice(BYTES).expect("the font in assets/ is a font"));

/// Width of one line of text at an em of `size`, in the unit of `size`. What the font lacks is an empty box.
pub fn width(text: &str, size: f64) -> f64 {
    let height = FACE.height_unscaled();
    let em = FACE.units_per_em().unwrap_or(height);
    let face = FACE.as_scaled(size as f32 * height / em);
    text.chars().map(|c| f64::from(face.h_advance(face.glyph_id(c)))).sum()
}

/// Width of the widest line at an em of `size`.
pub fn widest(lines: &[String], size: f64) -> f64 {
    lines.iter().map(|line| width(line, size)).fold(0.0, f64::max)
}

/// Converts the text to one printable line. Control characters and line ends become spaces. Characters that
/// XML forbids, or that change the reading direction, become the replacement character.
pub fn clean(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
            c if c.is_control() || c == '\u{2028}' || c == '\u{2029}' => ' ',
            c => c,
        })
        .collect()
}

/// Cleans the text and breaks it into lines at spaces, and within words that are wider than a line.
pub fn wrap(text: &str, size: f64, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut line = String::new();
    for word in clean(text).split_whitespace() {
        let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if width(&longer, size) <= room {
            line = longer;
            continue;
        }
        lines.extend((!line.is_empty()).then(|| std::mem::take(&mut line)));
        for c in word.chars() {
            let longer = format!("{line}{c}");
            if width(&longer, size) <= room || line.is_empty() {
                line = longer;
            } else {
                lines.push(std::mem::replace(&mut line, c.to_string()));
            }
        }
    }
    lines.extend((!line.is_empty()).then_some(line));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    // python3 -c "from PIL import ImageFont as F; f = F.truetype('assets/fonts/DejaVuSans.ttf', 2048,
    //   layout_engine=0); print(f.getlength('A'), f.getlength('0'), f.getlength('m'))"
    #[test]
    fn widths_are_the_fonts() {
        for (text, units) in [("A", 1401.0), ("0", 1303.0), ("m", 1995.0)] {
            assert!((width(text, 2048.0) - units).abs() < 0.5, "{text} {}", width(text, 2048.0));
        }
        assert!((width("A0m", 12.0) - (1401.0 + 1303.0 + 1995.0) * 12.0 / 2048.0).abs() < 1e-4);
    }

    #[test]
    fn has_the_letters_of_the_papers() {
        for c in "yₜOₜτ₁ŷₜ₊ₗ|z̃ₜ|δβ±−–≥×≤…".chars() {
            assert_ne!(FACE.glyph_id(c).0, 0, "{c}");
        }
    }

    #[test]
    fn wraps_at_spaces_and_breaks_long_words() {
        let room = width("aaa bbb", 10.0) + 0.1;
        assert_eq!(wrap("aaa bbb ccc ddd", 10.0, room), ["aaa bbb", "ccc ddd"]);
        assert_eq!(wrap("a bbbbbbbbbbb", 10.0, room), ["a", "bbbbbb", "bbbbb"]);
        assert!(wrap("  ", 10.0, 50.0).is_empty());
    }

    proptest! {
        #[test]
        fn wrapped_text_fits_and_nothing_is_lost(text in ".{0,300}", room in 30.0..400.0_f64) {
            let lines = wrap(&text, 12.0, room);
            prop_assert!(widest(&lines, 12.0) <= room + 1e-3);
            let letters = |text: &str| text.chars().filter(|c| !c.is_whitespace()).collect::<String>();
            prop_assert_eq!(letters(&lines.concat()), letters(&clean(&text)));
        }
    }
}
