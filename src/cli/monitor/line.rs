//! A line of the input: what is known of one frame.

use super::json::{List, Object};
use crate::dataset::DatasetError;
use crate::dataset::text::read_at_most;
use crate::image::{self, Frame, ImageError, MAX_FILE_BYTES, MAX_PIXELS, PixelFormat};
use crate::monitor::{Id, MAX_TARGETS, MonitorError};
use crate::region::{Region, RegionError};
use serde::de::{Error, MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer};
use std::path::PathBuf;

/// Longest line in bytes: the largest frame in base64, and some boxes.
pub(super) const MAX_LINE: usize = (MAX_PIXELS as usize) * 4 + (1 << 20);

/// Longest line in bytes without the pixels of a frame.
const MAX_WITHOUT_DATA: usize = 1 << 20;
/// Most numbers of a box, and most companions, which take far more memory than as text.
const MAX_NUMBERS: usize = 2048;
const MAX_COMPANIONS: usize = 256;
/// Most bytes of the id of a target.
const MAX_ID: usize = 256;

/// Why a line cannot be used.
#[derive(Debug, thiserror::Error)]
pub(super) enum LineError {
    /// There is nothing in it.
    #[error("the line is empty; a frame of which nothing is known is {{}}")]
    Empty,
    /// It is longer than any frame.
    #[error("the line is longer than {} MiB, or {} MiB with a raw frame's `data`", MAX_WITHOUT_DATA >> 20, MAX_LINE >> 20)]
    TooLong,
    /// It is no JSON, or has other keys or types.
    #[error("not a line of this protocol: {0}")]
    Json(#[from] serde_json::Error),
    /// The numbers of a box are no region.
    #[error("{key}: {source}; for a tracker that has no box, give null")]
    Region {
        /// Key of the box.
        key: &'static str,
        /// The fault.
        source: RegionError,
    },
    /// The file of a frame cannot be read.
    #[error("frame: {0}")]
    File(#[from] DatasetError),
    /// The frame's bytes are no image.
    #[error("frame{}: {source}", name.as_ref().map(|name| format!(" {}", name.display())).unwrap_or_default())]
    Image {
        /// Name of the frame's file.
        name: Option<PathBuf>,
        /// The fault.
        source: ImageError,
    },
    /// A raw frame has no bytes, or has them twice.
    #[error("frame: give `data` or `path` of a raw frame, one of the two")]
    RawSource,
    /// The id of a target is longer than any.
    #[error("id: a text of more than {MAX_ID} bytes")]
    LongId,
    /// There are too many targets.
    #[error(
        "{MAX_TARGETS} targets are followed already; one that is gone makes room: {{\"id\": 7, \"end\": true}}"
    )]
    TooMany,
    /// The target that ends was not there.
    #[error("no target of this id is followed")]
    NoTarget,
    /// The monitor refuses the frame or its box.
    #[error(transparent)]
    Monitor(#[from] MonitorError),
}

/// Numbers of a box: `x, y, w, h` or the corners of a polygon.
type Numbers = List<Option<f64>, MAX_NUMBERS>;

/// A line as it is written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Line {
    frame: Option<FrameSource>,
    #[serde(rename = "box")]
    numbers: Option<Numbers>,
    /// The tracker's confidence.
    pub confidence: Option<f64>,
    companions: Option<List<Option<Numbers>, MAX_COMPANIONS>>,
    /// Whether the tracker was started again with this box.
    pub restart: Option<bool>,
    id: Option<Id>,
    /// Whether the target is followed no more.
    pub end: Option<bool>,
}

/// Where a frame is: the text of a path, or `{"raw": ...}`.
#[derive(Debug)]
enum FrameSource {
    Path(PathBuf),
    Raw(Raw),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFrame {
    raw: Object<Raw>,
}

/// A frame without a header.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    width: u32,
    height: u32,
    format: PixelFormat,
    /// The bytes in base64.
    data: Option<String>,
    /// The file of the bytes.
    path: Option<PathBuf>,
}

impl<'de> Deserialize<'de> for FrameSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Source;
        impl<'de> Visitor<'de> for Source {
            type Value = FrameSource;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(
                    "the path of an image, or {\"raw\": {\"width\", \"height\", \"format\", \"data\"}}",
                )
            }

            fn visit_str<E: Error>(self, path: &str) -> Result<FrameSource, E> {
                Ok(FrameSource::Path(path.into()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<FrameSource, A::Error> {
                let frame = RawFrame::deserialize(MapAccessDeserializer::new(map))?;
                Ok(FrameSource::Raw(frame.raw.0))
            }
        }
        deserializer.deserialize_any(Source)
    }
}

impl Line {
    /// Reads a line.
    pub fn read(line: &[u8]) -> Result<Self, LineError> {
        let has_data = || line.windows(6).any(|word| word == b"\"data\"");
        if line.len() > MAX_LINE || line.len() > MAX_WITHOUT_DATA && !has_data() {
            return Err(LineError::TooLong);
        }
        if line.trim_ascii().is_empty() {
            return Err(LineError::Empty);
        }
        let read = |line: &[u8]| serde_json::from_slice::<Object<Self>>(line).map(|Object(line)| line);
        match read(line) {
            Err(error) => match without_nan(line) {
                Some(line) => Ok(read(&line)?),
                None => Err(error.into()),
            },
            line => Ok(line?),
        }
    }

    /// The tracker's box, whose top left pixel is `base`; `None` where it has none.
    pub fn region(&self, base: f64) -> Result<Option<Region>, LineError> {
        let read = |numbers: &Numbers| region(numbers, base);
        let found = self.numbers.as_ref().map_or(Ok(None), read);
        found.map_err(|source| LineError::Region { key: "box", source })
    }

    /// The boxes of companions; one that has none is nowhere.
    pub fn companions(&self, base: f64) -> Result<Vec<Region>, LineError> {
        let read = |numbers: &Option<Numbers>| -> Result<Region, RegionError> {
            let found = numbers.as_ref().map_or(Ok(None), |numbers| region(numbers, base));
            Ok(found?.unwrap_or_else(Region::nowhere))
        };
        let all = self.companions.iter().flat_map(|List(all)| all).map(read);
        all.collect::<Result<_, _>>().map_err(|source| LineError::Region { key: "companions", source })
    }

    /// The target that it is about, where it names one.
    pub fn id(&self) -> Result<Option<Id>, LineError> {
        match &self.id {
            Some(Id::Text(text)) if text.len() > MAX_ID => Err(LineError::LongId),
            id => Ok(id.clone()),
        }
    }

    /// The frame.
    pub fn frame(self) -> Result<Option<Frame>, LineError> {
        match self.frame {
            None => Ok(None),
            Some(FrameSource::Path(path)) => {
                let bytes = read_at_most(&path, MAX_FILE_BYTES)?;
                let frame = image::decode(&bytes);
                frame.map(Some).map_err(|source| LineError::Image { name: Some(path), source })
            }
            Some(FrameSource::Raw(raw)) => raw.frame().map(Some),
        }
    }
}

impl Raw {
    fn frame(self) -> Result<Frame, LineError> {
        let Self { width, height, format, data, path } = self;
        match (data, path) {
            (Some(text), None) => Frame::from_base64(width, height, format, &text)
                .map_err(|source| LineError::Image { name: None, source }),
            (None, Some(path)) => {
                let bytes = read_at_most(&path, 3 * MAX_PIXELS)?;
                Frame::from_raw(width, height, format, bytes)
                    .map_err(|source| LineError::Image { name: Some(path), source })
            }
            _ => Err(LineError::RawSource),
        }
    }
}

/// The region of a box; `None` if one of its numbers is none.
fn region(numbers: &Numbers, base: f64) -> Result<Option<Region>, RegionError> {
    let Some(mut numbers) = numbers.0.iter().copied().collect::<Option<Vec<f64>>>() else { return Ok(None) };
    // The sides of a box do not depend on where pixels begin to count.
    let places = if numbers.len() == 4 { 2 } else { numbers.len() };
    numbers.iter_mut().take(places).for_each(|place| *place -= base);
    Region::from_numbers(&numbers).map(Some)
}

/// The line with `null` for the word `NaN` and a number that is out of range for `Infinity`, which Python writes and JSON does
/// not know; `None` if it has none outside of texts.
fn without_nan(line: &[u8]) -> Option<Vec<u8>> {
    let (mut out, mut rest) = (Vec::with_capacity(line.len()), line);
    let (mut in_text, mut found) = (false, false);
    while let Some((&byte, after)) = rest.split_first() {
        let words: [(&[u8], &[u8]); 2] = [(b"NaN", b"null"), (b"Infinity", b"1e999")];
        let word = words.into_iter().find(|(word, _)| rest.starts_with(word));
        if let Some((word, json)) = word.filter(|_| !in_text) {
            out.extend_from_slice(json);
            (rest, found) = (&rest[word.len()..], true);
            continue;
        }
        let pair = if in_text && byte == b'\\' { after.first() } else { None };
        in_text ^= byte == b'"';
        out.push(byte);
        out.extend(pair);
        rest = if pair.is_some() { &after[1..] } else { after };
    }
    found.then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::Rect;
    use proptest::prelude::*;
    use std::path::Path;

    fn read(text: &str) -> Result<Line, LineError> {
        Line::read(text.as_bytes())
    }

    #[test]
    fn boxes_count_from_the_base_and_nothing_is_no_box() {
        let region = |text: &str, base| read(text).unwrap().region(base).map_err(|e| e.to_string());
        let rect = |x, y| Ok(Some(Region::Rect(Rect::new(x, y, 3.0, 4.0))));
        assert_eq!(region(r#"{"box": [1, 2, 3, 4]}"#, 0.0), rect(1.0, 2.0));
        assert_eq!(region(r#"{"box": [1, 2, 3, 4]}"#, 1.0), rect(0.0, 1.0));
        for none in ["{}", r#"{"box": null}"#, r#"{"box": [1, null, 3, 4]}"#, r#"{"box": [NaN, NaN, 3, 4]}"#]
        {
            assert_eq!(region(none, 1.0), Ok(None), "{none}");
        }
        assert!(region(r#"{"box": [0, 0, 0, 0]}"#, 0.0).unwrap_err().contains("give null"));
        assert!(region(r#"{"box": [1, 2, 3]}"#, 0.0).unwrap_err().starts_with("box: "));
        let polygon = region(r#"{"box": [1, 1, 5, 1, 1, 4]}"#, 1.0);
        assert_eq!(polygon, Ok(Some(Region::Polygon(vec![(0.0, 0.0), (4.0, 0.0), (0.0, 3.0)]))));
    }

    #[test]
    fn companions_without_a_box_keep_their_place() {
        let line = read(r#"{"companions": [[0, 0, 2, 2], null, [NaN, 1, 1, 1]]}"#).unwrap();
        let found = line.companions(0.0).unwrap();
        assert!(found[0] == Region::Rect(Rect::new(0.0, 0.0, 2.0, 2.0)) && found.len() == 3);
        assert!(found[1..].iter().all(|region| region.bounds().x.is_nan()));
    }

    // Python's json.dumps(float("inf")) is Infinity; an infinite number is a fault of the tracker, no word for absence.
    #[test]
    fn infinity_is_an_error() {
        for number in ["Infinity", "-Infinity", "1e999", "-1e999"] {
            for line in [
                format!(r#"{{"box": [1, 2, {number}, 4]}}"#),
                format!(r#"{{"box": [NaN, 2, {number}, 4]}}"#),
                format!(r#"{{"box": null, "confidence": {number}}}"#),
                format!(r#"{{"companions": [[1, 2, 3, {number}]]}}"#),
            ] {
                let told = read(&line).unwrap_err().to_string();
                assert!(told.contains("number out of range"), "{line}: {told}");
            }
        }
    }

    #[test]
    fn words_inside_texts_are_left_alone() {
        let line = read(r#"{"frame": "NaN\\", "confidence": NaN, "box": null}"#).unwrap();
        assert!(matches!(line.frame, Some(FrameSource::Path(path)) if path == Path::new("NaN\\")));
        assert_eq!(without_nan(br#"{"frame": "a\"NaN"}"#), None);
    }

    #[test]
    fn only_an_object_is_a_line_or_a_raw_frame() {
        for list in
            ["[]", "[null, [1, 2, 3, 4], 0.5, null]", "[\"a.png\", [1, 2, 3, 4], null, [[1, 2, 3, 4]]]"]
        {
            let told = read(list).unwrap_err().to_string();
            assert!(told.contains("invalid type: sequence, expected an object"), "{list}: {told}");
        }
        let raw = |raw: &str| read(&format!("{{\"frame\": {{\"raw\": {raw}}}}}"));
        assert!(raw(r#"{"width": 1, "height": 1, "format": "bgr", "data": "AAAA"}"#).is_ok());
        let told = raw(r#"[1, 1, "bgr", "AAAA", null]"#).unwrap_err().to_string();
        assert!(told.contains("invalid type: sequence, expected an object"), "{told}");
        for other in ["7", "null", "\"a.png\"", "true"] {
            assert!(read(other).unwrap_err().to_string().contains("expected an object"), "{other}");
        }
    }

    #[test]
    fn lists_and_lines_have_a_limit() {
        let list = |value: &str, count: usize| format!("[{}]", vec![value; count].join(","));
        let boxed = |count| read(&format!("{{\"box\": {}}}", list("1", count)));
        assert_eq!(boxed(MAX_NUMBERS).unwrap().numbers.unwrap().0.len(), MAX_NUMBERS);
        let told = boxed(MAX_NUMBERS + 1).unwrap_err().to_string();
        assert!(told.contains("a list of more than 2048 values"), "{told}");
        let beside = |count| read(&format!("{{\"companions\": {}}}", list("null", count)));
        assert_eq!(beside(MAX_COMPANIONS).unwrap().companions(0.0).unwrap().len(), MAX_COMPANIONS);
        let told = beside(MAX_COMPANIONS + 1).unwrap_err().to_string();
        assert!(told.contains("a list of more than 256 values"), "{told}");
        let blanks = " ".repeat(MAX_WITHOUT_DATA);
        assert!(matches!(read(&format!("{{{blanks}}}")), Err(LineError::TooLong)));
        assert!(read(&format!("{{{}}}", &blanks[2..])).is_ok());
        let raw = r#"{"frame": {"raw": {"width": 1, "height": 1, "format": "gray", "data": "AA=="}}}"#;
        assert!(read(&(raw.to_string() + &blanks)).is_ok());
    }

    #[test]
    fn mistakes_are_named() {
        let told = |text: &str| match read(text).and_then(Line::frame) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("{text}"),
        };
        assert!(told("").contains("empty") && told(" \r").contains("empty"));
        assert!(told(r#"{"bbox": [1, 2, 3, 4]}"#).contains("unknown field `bbox`, expected one of"));
        assert!(told(r#"{"frame": 7}"#).contains("the path of an image"));
        assert!(told(r#"{"frame": "no/such.jpg"}"#).contains("no/such.jpg"));
        let raw =
            |more: &str| told(&format!(r#"{{"frame": {{"raw": {{"width": 2, "height": 1, {more}}}}}}}"#));
        assert!(raw(r#""format": "bgr", "data": "AAAA""#).contains("are 6 bytes, not 3"));
        assert!(raw(r#""format": "yuv", "data": "AAAA""#).contains("unknown variant `yuv`"));
        assert!(raw(r#""format": "bgr""#).contains("give `data` or `path`"));
    }

    proptest! {
        #[test]
        fn no_line_makes_it_panic(line in prop::collection::vec(any::<u8>(), 0..60), text in r#"[{}\[\]",:\\a-zN0-9. ]{0,60}"#) {
            for line in [&line[..], text.as_bytes()] {
                let _ = Line::read(line).map(|line| (line.region(1.0), line.companions(0.0)));
            }
        }
    }
}
