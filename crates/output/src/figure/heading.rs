//! Title and note above a figure.

use super::font;
use super::scene::{Anchor, Scene};
use super::style::{INK, LARGE, MARGIN, SMALL, SOFT};

/// Draws title and note; returns the first free line below.
pub fn heading(scene: &mut Scene, title: &str, note: &str) -> f64 {
    let room = scene.width - 2.0 * MARGIN;
    let mut y = MARGIN;
    for line in font::wrap(title, LARGE, room, 2) {
        scene.text(&line, (MARGIN, y + 9.0), LARGE, Anchor::Start, INK);
        y += 19.0;
    }
    for line in font::wrap(note, SMALL, room, 3) {
        scene.text(&line, (MARGIN, y + 7.0), SMALL, Anchor::Start, SOFT);
        y += 15.0;
    }
    if y > MARGIN { y + 5.0 } else { y }
}
