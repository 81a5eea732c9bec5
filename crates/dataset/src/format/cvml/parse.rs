//! Parser of CVML's XML, which gives the box of an object in a frame.
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
//! `xc`, `yc` are the center, `w`, `h` the size, in pixels; four zeros stand for an object that is not
//! annotated. Everything else (groups, appearance, roles, hypotheses of CAVIAR) is ignored. The document is
//! read tag by tag. Its size and depth are limited and its own entities are refused, so that a small document
//! cannot fill the memory.

use crate::{DatasetError, text};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use trackfail_core::region::{Rect, Region};

/// Deepest nesting of elements. CVML needs 8.
const MAX_DEPTH: usize = 32;

/// Largest absolute coordinate and size, in pixels.
const MAX_COORDINATE: f64 = 1e6;

/// Largest frame number.
const LAST_FRAME: u32 = 10_000_000;

/// Boxes of all objects in a file.
#[derive(Debug, Default, PartialEq)]
pub struct Annotation {
    /// Boxes by object and image number (XML frame + 1).
    objects: BTreeMap<u32, BTreeMap<u32, Rect>>,
    /// Numbers of the images that have a `<frame>`.
    images: BTreeSet<u32>,
}

impl Annotation {
    /// Ids of the objects that have a box, ascending.
    pub fn objects(&self) -> impl Iterator<Item = u32> {
        self.objects.keys().copied()
    }

    /// Id of the object with most boxes; of several, the smallest id. `None` if there are no boxes.
    pub fn longest(&self) -> Option<u32> {
        self.objects.iter().rev().max_by_key(|(_, boxes)| boxes.len()).map(|(&id, _)| id)
    }

    /// Image numbers of an object's first and last box; `None` for an unknown object.
    pub fn presence(&self, object: u32) -> Option<(u32, u32)> {
        let boxes = self.objects.get(&object)?;
        Some((*boxes.keys().next()?, *boxes.keys().next_back()?))
    }

    /// Box of an object in the image with this number; `None` if it has none there.
    pub fn region(&self, object: u32, image: u32) -> Option<Rect> {
        self.objects.get(&object)?.get(&image).copied()
    }

    /// Boxes of an object in a range of images, ends included.
    pub(super) fn regions(&self, object: u32, (first, last): (u32, u32)) -> Vec<Option<Region>> {
        (first..=last).map(|image| self.region(object, image).map(Region::Rect)).collect()
    }

    /// Number of the last image that has a `<frame>`; 0 without any.
    pub fn last(&self) -> u32 {
        self.images.last().copied().unwrap_or_default()
    }
}

/// Reads a document; `path` is for messages.
///
/// # Errors
/// With the line: XML that is not well-formed or of another format; a number that is absent, malformed, not
/// finite or above the limits; a size of 0 or below; a frame that comes twice, or an object that comes twice
/// in a frame; an object without a box or with two; entities.
pub fn parse(path: &Path, document: &str) -> Result<Annotation, DatasetError> {
    let mut reader = Reader::from_str(document);
    let mut state = State::default();
    loop {
        let start = reader.buffer_position();
        let event = reader.read_event();
        let done = match &event {
            Ok(Event::Start(tag)) => state.open(tag),
            Ok(Event::Empty(tag)) => state.open(tag).and_then(|()| state.close()),
            Ok(Event::End(_)) => state.close(),
            Ok(Event::DocType(text)) if text.contains('[') => {
                Err("the document declares entities; CVML needs none, remove the declaration".into())
            }
            Ok(Event::GeneralRef(name)) if !is_harmless(name) => {
                Err(format!("the entity `{}` is not known", text::shorten(name)))
            }
            Ok(Event::Eof) if state.began && state.open.is_empty() => return Ok(state.found),
            Ok(Event::Eof) => {
                Err("the document ends before its last element is closed; fetch the file again".into())
            }
            Ok(_) => Ok(()),
            Err(e) => Err(format!("not well-formed XML: {}", text::shorten(&e.to_string()))),
        };
        if let Err(message) = done {
            let at = if event.is_err() { reader.error_position() } else { start };
            let line = text::line_of(document.as_bytes(), usize::try_from(at).unwrap_or(usize::MAX));
            return Err(DatasetError::line(path, line, message));
        }
    }
}

fn is_harmless(entity: &str) -> bool {
    entity.starts_with('#') || ["amp", "lt", "gt", "apos", "quot"].contains(&entity)
}

#[derive(Default)]
struct State {
    /// Names of the open elements, outermost first. Elements that CVML lacks are empty strings.
    open: Vec<&'static str>,
    began: bool,
    /// Image number of the open frame, and the objects seen in it so far.
    image: u32,
    in_frame: BTreeSet<u32>,
    /// Id of the open object, and true once it has a box.
    object: u32,
    has_box: bool,
    found: Annotation,
}

impl State {
    fn open(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        if self.open.len() == MAX_DEPTH {
            return Err(format!("elements nested more than {MAX_DEPTH} deep"));
        }
        let element = match (self.open.last().copied(), tag.name().into_inner()) {
            (None, _) if self.began => return Err("text after the end of the document".into()),
            (None, "dataset") => "dataset",
            (None, other) => {
                return Err(format!("starts with <{}>; CVML starts with <dataset>", text::shorten(other)));
            }
            (Some("dataset"), "frame") => self.frame(whole(tag, "number")?)?,
            (Some("frame"), "objectlist") => "objectlist",
            (Some("objectlist"), "object") => self.object(whole(tag, "id")?)?,
            (Some("object"), "box") => self.bounding_box(tag)?,
            _ => "",
        };
        self.began = true;
        self.open.push(element);
        Ok(())
    }

    fn close(&mut self) -> Result<(), String> {
        match self.open.pop() {
            Some("object") if !self.has_box => Err(format!("object {} has no <box>", self.object)),
            _ => Ok(()),
        }
    }

    fn frame(&mut self, number: u32) -> Result<&'static str, String> {
        if number >= LAST_FRAME {
            return Err(format!("frame {number}; no sequence has so many"));
        }
        self.image = number + 1;
        self.in_frame.clear();
        let is_new = self.found.images.insert(self.image);
        is_new.then_some("frame").ok_or_else(|| format!("frame {number} comes twice"))
    }

    fn object(&mut self, id: u32) -> Result<&'static str, String> {
        (self.object, self.has_box) = (id, false);
        let is_new = self.in_frame.insert(id);
        let twice = || format!("object {id} comes twice in frame {}", self.image - 1);
        is_new.then_some("object").ok_or_else(twice)
    }

    fn bounding_box(&mut self, tag: &BytesStart<'_>) -> Result<&'static str, String> {
        if std::mem::replace(&mut self.has_box, true) {
            return Err(format!("object {} has two boxes in frame {}", self.object, self.image - 1));
        }
        let [xc, yc, w, h] = [pixels(tag, "xc")?, pixels(tag, "yc")?, pixels(tag, "w")?, pixels(tag, "h")?];
        if [xc, yc, w, h] != [0.0; 4] {
            if w <= 0.0 || h <= 0.0 {
                return Err(format!("a box of {w} x {h} pixels has no area"));
            }
            let rect = Rect::new(xc - w / 2.0, yc - h / 2.0, w, h);
            self.found.objects.entry(self.object).or_default().insert(self.image, rect);
        }
        Ok("")
    }
}

/// Value of an attribute, as written.
fn attribute<'t>(tag: &'t BytesStart<'_>, key: &str) -> Result<std::borrow::Cow<'t, str>, String> {
    let name = tag.name().into_inner();
    let all: Vec<_> = tag.attributes().collect::<Result<_, _>>().map_err(|e| format!("<{name}>: {e}"))?;
    let found = all.into_iter().find(|attribute| attribute.key.into_inner() == key);
    found.map(|attribute| attribute.value).ok_or_else(|| format!("<{name}> has no attribute `{key}`"))
}

fn whole(tag: &BytesStart<'_>, key: &str) -> Result<u32, String> {
    let value = attribute(tag, key)?;
    value.trim().parse().map_err(|_| {
        format!("{key} is `{}`; a whole number from 0 to {} was expected", text::shorten(&value), u32::MAX)
    })
}

fn pixels(tag: &BytesStart<'_>, key: &str) -> Result<f64, String> {
    let value = attribute(tag, key)?;
    let no_number = |_| format!("{key} is `{}`, which is no number", text::shorten(&value));
    let number = value.trim().parse::<f64>().map_err(no_number)?;
    if !number.is_finite() || number.abs() > MAX_COORDINATE {
        return Err(format!("{key} is {}; no image has such a pixel", text::shorten(&value)));
    }
    Ok(number)
}

#[cfg(test)]
mod tests;
