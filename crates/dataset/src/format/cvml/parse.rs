//! The XML of CVML: which box an object has in a frame.
//!
//! ```text
//! <dataset>
//!   <frame number="0">
//!     <objectlist>
//!       <object id="9"> <box h="75.17" w="31.03" xc="514.7109" yc="195.2731"/> ... </object>
//!     </objectlist>
//!     <grouplist> ... </grouplist>
//!   </frame>
//! </dataset>
//! ```
//!
//! `xc`, `yc` are the center, `w`, `h` the size, in pixels; four zeros stand for an object that is not annotated.
//! Everything else (groups, appearance, roles, hypotheses of CAVIAR) is passed over. The document is read tag
//! by tag; its size, depth and number of boxes are limited, and entities of its own are refused, so that no
//! document takes more memory than its own size warrants.

use crate::{DatasetError, text};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use trackfail_core::region::Rect;

/// Deepest nesting of elements; CVML needs 8.
const MAX_DEPTH: usize = 32;

/// Most boxes of a file; the longest of CAVIAR has some thousands.
const MAX_BOXES: usize = 1_000_000;

/// Largest coordinate and size, in pixels.
const MAX_COORDINATE: f64 = 1e6;

/// Largest frame number.
const LAST_FRAME: u32 = 10_000_000;

/// The boxes of a file.
#[derive(Debug, Default, PartialEq)]
pub struct Annotation {
    /// Boxes by object and image number (XML frame + 1).
    objects: BTreeMap<u32, BTreeMap<u32, Rect>>,
    last: u32,
}

impl Annotation {
    /// The ids of the objects that have a box, ascending.
    pub fn objects(&self) -> impl Iterator<Item = u32> {
        self.objects.keys().copied()
    }

    /// The object with most boxes, of several the smallest id.
    pub fn longest(&self) -> Option<u32> {
        let most = self.objects.values().map(BTreeMap::len).max()?;
        self.objects.iter().find(|(_, boxes)| boxes.len() == most).map(|(&id, _)| id)
    }

    /// Image numbers of an object's first and last box.
    pub fn presence(&self, object: u32) -> Option<(u32, u32)> {
        let boxes = self.objects.get(&object)?;
        Some((*boxes.keys().next()?, *boxes.keys().next_back()?))
    }

    /// An object's box in the image of a number.
    pub fn region(&self, object: u32, image: u32) -> Option<Rect> {
        self.objects.get(&object)?.get(&image).copied()
    }

    /// Number of the last image that has a `<frame>`; 0 without any.
    pub fn last(&self) -> u32 {
        self.last
    }
}

/// Kind of an open element.
#[derive(Clone, Copy, PartialEq)]
enum Open {
    Dataset,
    Frame,
    Objects,
    Object,
    Other,
}

/// Reads a document; `path` is for messages.
///
/// # Errors
/// With the line: XML that is not well-formed or another format; a number that is absent, none, not finite or
/// above the limits; a size of 0 or below; a frame or, in one frame, an object that comes twice; an object
/// without a box or with two; entities.
pub fn parse(path: &Path, document: &str) -> Result<Annotation, DatasetError> {
    let mut reader = Reader::from_str(document);
    let mut state = State::default();
    loop {
        let start = reader.buffer_position();
        let fail = |at: u64, message: String| {
            let before = document.as_bytes().iter().take(usize::try_from(at).unwrap_or(usize::MAX));
            let line = 1 + before.filter(|&&b| b == b'\n').count();
            DatasetError::line(path, line, message)
        };
        let event = reader.read_event().map_err(|e| {
            let position = reader.error_position();
            fail(position, format!("not well-formed XML: {}", text::shorten(&e.to_string())))
        })?;
        let done = match event {
            Event::Start(tag) => state.open(&tag),
            Event::Empty(tag) => state.open(&tag).and_then(|()| state.close()),
            Event::End(_) => state.close(),
            Event::DocType(text) if text.contains('[') => {
                Err("the document declares entities; CVML needs none, remove the declaration".into())
            }
            Event::GeneralRef(name) if !harmless(&name) => {
                Err(format!("the entity `{}` is not known", text::shorten(&name)))
            }
            Event::Eof => break state.end().map_err(|message| fail(start, message)),
            _ => Ok(()),
        };
        done.map_err(|message| fail(start, message))?;
    }
}

fn harmless(entity: &str) -> bool {
    entity.starts_with('#') || ["amp", "lt", "gt", "apos", "quot"].contains(&entity)
}

#[derive(Default)]
struct State {
    open: Vec<Open>,
    closed: bool,
    /// Image number of the open frame.
    image: u32,
    /// Id of the open object, and whether it has a box yet.
    object: u32,
    has_box: bool,
    images: BTreeSet<u32>,
    in_frame: BTreeSet<u32>,
    boxes: usize,
    found: Annotation,
}

impl State {
    fn open(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        let name = tag.name().into_inner();
        if self.open.len() == MAX_DEPTH {
            return Err(format!("elements nested more than {MAX_DEPTH} deep"));
        }
        let element = match (self.open.last(), name) {
            (None, _) if self.closed => return Err("text after the end of the document".into()),
            (None, "dataset") => Open::Dataset,
            (None, other) => {
                return Err(format!("starts with <{}>; CVML starts with <dataset>", text::shorten(other)));
            }
            (Some(Open::Dataset), "frame") => self.frame(tag)?,
            (Some(Open::Frame), "objectlist") => Open::Objects,
            (Some(Open::Objects), "object") => self.start_object(tag)?,
            (Some(Open::Object), "box") => self.bounding_box(tag)?,
            _ => Open::Other,
        };
        self.open.push(element);
        Ok(())
    }

    fn close(&mut self) -> Result<(), String> {
        if self.open.pop() == Some(Open::Object) && !self.has_box {
            return Err(format!("object {} has no <box>", self.object));
        }
        self.closed = self.open.is_empty();
        Ok(())
    }

    fn end(self) -> Result<Annotation, String> {
        if !self.closed {
            return Err("the document ends before its last element is closed; fetch the file again".into());
        }
        Ok(self.found)
    }

    fn frame(&mut self, tag: &BytesStart<'_>) -> Result<Open, String> {
        let number: u32 = whole(tag, "number")?;
        if number >= LAST_FRAME {
            return Err(format!("frame {number}; no sequence has so many"));
        }
        self.image = number + 1;
        if !self.images.insert(self.image) {
            return Err(format!("frame {number} comes twice"));
        }
        self.found.last = self.found.last.max(self.image);
        self.in_frame.clear();
        Ok(Open::Frame)
    }

    fn start_object(&mut self, tag: &BytesStart<'_>) -> Result<Open, String> {
        self.object = whole(tag, "id")?;
        self.has_box = false;
        if !self.in_frame.insert(self.object) {
            return Err(format!("object {} comes twice in frame {}", self.object, self.image - 1));
        }
        Ok(Open::Object)
    }

    fn bounding_box(&mut self, tag: &BytesStart<'_>) -> Result<Open, String> {
        if self.has_box {
            return Err(format!("object {} has two boxes in frame {}", self.object, self.image - 1));
        }
        self.has_box = true;
        self.boxes += 1;
        if self.boxes > MAX_BOXES {
            return Err(format!("more than {MAX_BOXES} boxes"));
        }
        let [xc, yc, w, h] = [pixels(tag, "xc")?, pixels(tag, "yc")?, pixels(tag, "w")?, pixels(tag, "h")?];
        if [xc, yc, w, h] == [0.0; 4] {
            return Ok(Open::Other);
        }
        if w <= 0.0 || h <= 0.0 {
            return Err(format!("a box of {w} x {h} pixels has no area"));
        }
        let rect = Rect::new(xc - w / 2.0, yc - h / 2.0, w, h);
        self.found.objects.entry(self.object).or_default().insert(self.image, rect);
        Ok(Open::Other)
    }
}

/// The value of an attribute, as written.
fn attribute<'t>(tag: &'t BytesStart<'_>, key: &str) -> Result<std::borrow::Cow<'t, str>, String> {
    let name = tag.name().into_inner();
    let mut found = None;
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|e| format!("<{name}>: {e}"))?;
        if attribute.key.into_inner() == key {
            found = Some(attribute.value);
        }
    }
    found.ok_or_else(|| format!("<{name}> has no attribute `{key}`"))
}

fn whole(tag: &BytesStart<'_>, key: &str) -> Result<u32, String> {
    let value = attribute(tag, key)?;
    value.trim().parse().map_err(|_| {
        format!("{key} is `{}`; a whole number from 0 to {} was expected", text::shorten(&value), u32::MAX)
    })
}

fn pixels(tag: &BytesStart<'_>, key: &str) -> Result<f64, String> {
    let value = attribute(tag, key)?;
    let number: f64 = value
        .trim()
        .parse()
        .map_err(|_| format!("{key} is `{}`, which is no number", text::shorten(&value)))?;
    if !number.is_finite() || number.abs() > MAX_COORDINATE {
        return Err(format!("{key} is {}; no image has such a pixel", text::shorten(&value)));
    }
    Ok(number)
}

#[cfg(test)]
mod tests;
