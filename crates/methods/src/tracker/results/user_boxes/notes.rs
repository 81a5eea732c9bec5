//! Notes to the user about the boxes that were read.

use super::{Base, Options, UserBoxes};
use trackfail_core::region::{Rect, Region};

impl UserBoxes {
    /// Lines that say how the file `name` was read, unless `given` sets all of it, and which signs speak
    /// against it.
    pub fn notes(&self, name: &str, given: &Options) -> Vec<String> {
        let mut notes = Vec::new();
        let is_said = given.format.is_some() && (given.base.is_some() || self.base.is_none());
        if !is_said || self.first == Some(0) {
            let frames =
                self.first.map_or_else(String::new, |first| format!(", frames counted from {first}"));
            let (pixels, option) = match self.base.map(u8::from) {
                Some(base) => (format!(", pixels counted from {base}"), format!(" --base {base}")),
                None => (", in shares of the frame's sides".to_string(), String::new()),
            };
            let unread = match self.format.unread().join(", ") {
                words if words.is_empty() => words,
                words => format!("; not used: {words}"),
            };
            let (words, format) = (self.format.words(), self.format.option());
            notes.push(format!(
                "note: {name} is read as {words}{frames}{pixels} (--boxes-format {format}{option}){unread}"
            ));
        }
        let least =
            self.targets.iter().filter_map(|target| target.regions.iter().position(Option::is_some)).min();
        if let (Some(number), Some(first), Some(least)) = (given.number, self.first, least)
            && (first + 1..=first + least).contains(&number)
        {
            notes.push(format!(
                "warning: frame {first} in {name} is taken as the first of the frames, whose file has number {number}"
            ));
        }
        let regions = self.targets.iter().flat_map(|target| target.regions.iter().flatten());
        let bounds: Vec<Rect> = regions.map(Region::bounds).collect();
        // A left or top edge at 0 lies one pixel before the first one.
        let mut before = bounds.iter().flat_map(|r| [r.x, r.y]).filter(|place| *place < 0.0).peekable();
        let is_from_zero = before.peek().is_some() && before.all(|place| place == -1.0);
        if given.base.is_none() && self.base == Some(Base::One) && is_from_zero {
            notes.push(format!(
                "warning: a left or top edge in {name} is 0, but the first pixel 1; if pixels count from 0 there, give \
                 --base 0"
            ));
        }
        if let Some((width, height)) = given.size.filter(|_| given.format.is_none()) {
            let beyond = |r: &&Rect| r.x + r.w > 1.1 * width as f64 || r.y + r.h > 1.1 * height as f64;
            let (count, all) = (bounds.iter().filter(beyond).count(), bounds.len());
            if 2 * count > all {
                notes.push(format!(
                    "warning: {count} of {all} boxes of {name} reach far beyond the frame of {width}x{height} pixels; if \
                     the numbers mean something else, name the columns, as in --boxes-format x1,y1,x2,y2"
                ));
            }
        }
        notes
    }
}
