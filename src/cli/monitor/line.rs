//! A line of the input: the data of one frame.
//!
//! Lengths are checked before values are parsed, so that a line takes at most a few times its length in
//! memory.

use crate::cli::Cause;
use crate::dataset::text::read_at_most;
use crate::image::{self, Frame, MAX_FILE_BYTES, MAX_PIXELS, PixelFormat};
use crate::monitor::Id;
use crate::region::Region;
use serde::de::{DeserializeOwned, Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;
use std::fmt;
use std::path::PathBuf;

/// Longest line in bytes: the largest frame in base64, and some boxes.
pub(super) const MAX_LINE: usize = (MAX_PIXELS as usize) * 4 + (1 << 20);

/// Longest line without raw pixels, in bytes.
const MAX_WITHOUT_DATA: usize = 1 << 20;
/// Most numbers of a box, and most companions.
const MAX_NUMBERS: usize = 2048;
const MAX_COMPANIONS: usize = 256;
/// Longest id of a target, in bytes.
const MAX_ID: usize = 256;

/// Says what is wrong with the value of a key.
fn wrong(key: &str, error: impl fmt::Display) -> Cause {
    format!("{key}: {error}").into()
}

/// Numbers of a box: `x, y, w, h` or the corners of a polygon.
type Numbers = Vec<Option<f64>>;

/// A parsed line. Values that may be long are still JSON text.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object, {\"key\": value, ...}")]
pub(super) struct Line {
    frame: Option<Box<RawValue>>,
    #[serde(rename = "box")]
    numbers: Option<Box<RawValue>>,
    /// Confidence of the tracker.
    pub confidence: Option<f64>,
    companions: Option<Box<RawValue>>,
    /// True if the tracker was restarted with this box.
    pub restart: Option<bool>,
    /// Id of the target; `None` if the line names none.
    #[serde(default, deserialize_with = "id")]
    pub id: Option<Id>,
    /// True if the target is no longer followed.
    pub end: Option<bool>,
}

/// Parses the id of a target, or null.
fn id<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Id>, D::Error> {
    value.deserialize_any(IdVisitor)
}

struct IdVisitor;

impl Visitor<'_> for IdVisitor {
    type Value = Option<Id>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an id, a whole number or a text")
    }

    fn visit_unit<E: Error>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Self::Value, E> {
        Ok(Some(Id::Number(number)))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Self::Value, E> {
        let large = |_| E::custom(format!("id: {number} is above {}; give it as a text", i64::MAX));
        i64::try_from(number).map(|number| Some(Id::Number(number))).map_err(large)
    }

    // Tables of NumPy have whole numbers as 7.0.
    fn visit_f64<E: Error>(self, number: f64) -> Result<Self::Value, E> {
        const END: f64 = (1_u64 << 63) as f64;
        if number.fract() == 0.0 && number.abs() < END {
            return Ok(Some(Id::Number(number as i64)));
        }
        Err(E::invalid_type(Unexpected::Float(number), &self))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
        Ok(Some(Id::Text(text.to_string())))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFrame<'a> {
    #[serde(borrow)]
    raw: &'a RawValue,
}

/// A frame of raw pixels.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object, {\"key\": value, ...}")]
struct Raw {
    width: u32,
    height: u32,
    format: PixelFormat,
    /// Pixels in base64.
    data: Option<String>,
    /// File of the pixels.
    path: Option<PathBuf>,
}

/// Parses a JSON object. serde would also accept an array of the values in order, which is refused here.
fn object<'a, T: Deserialize<'a>>(text: &'a [u8]) -> serde_json::Result<T> {
    match text.trim_ascii_start().first() {
        Some(b'[') => Err(Error::invalid_type(Unexpected::Seq, &"an object, {\"key\": value, ...}")),
        _ => serde_json::from_slice(text),
    }
}

/// Parses the list of a key, with at most `most` items.
fn list<T: DeserializeOwned>(key: &str, value: &RawValue, most: usize) -> Result<Vec<T>, Cause> {
    let values: Vec<T> = serde_json::from_str(value.get()).map_err(|e| wrong(key, e))?;
    check_length(key, values.len(), most)?;
    Ok(values)
}

fn check_length(key: &str, length: usize, most: usize) -> Result<(), Cause> {
    let refused = || wrong(key, format_args!("a list of more than {most} values"));
    if length > most { Err(refused()) } else { Ok(()) }
}

impl Line {
    /// Parses a line.
    pub fn read(line: &[u8]) -> Result<Self, Cause> {
        let too_long = || -> Cause {
            let [most, with_data] = [MAX_WITHOUT_DATA, MAX_LINE].map(|bytes| bytes >> 20);
            format!("the line is longer than {most} MiB, or {with_data} MiB with a raw frame's `data`").into()
        };
        if line.len() > MAX_LINE {
            return Err(too_long());
        }
        if line.trim_ascii().is_empty() {
            return Err("the line is empty; a frame of which nothing is known is {}".into());
        }
        let read = object(line).or_else(|error| without_nan(line).map_or(Err(error), |line| object(&line)));
        let read: Self = read.map_err(|e| format!("not a line of this protocol: {e}"))?;
        let raw = read.frame.as_deref().map(RawValue::get).filter(|frame| frame.starts_with('{'));
        if line.len().saturating_sub(raw.map_or(0, str::len)) > MAX_WITHOUT_DATA {
            return Err(too_long());
        }
        match &read.id {
            Some(Id::Text(text)) if text.len() > MAX_ID => {
                Err(wrong("id", format_args!("a text of more than {MAX_ID} bytes")))
            }
            _ => Ok(read),
        }
    }

    /// Box of the tracker, with `base` the number of the top left pixel; `None` without a box.
    pub fn region(&self, base: f64) -> Result<Option<Region>, Cause> {
        let read = |value: &RawValue| region("box", list("box", value, MAX_NUMBERS)?, base);
        self.numbers.as_deref().map_or(Ok(None), read)
    }

    /// Boxes of the companions. One without a box has a region outside of every frame.
    pub fn companions(&self, base: f64) -> Result<Vec<Region>, Cause> {
        const KEY: &str = "companions";
        let Some(value) = &self.companions else { return Ok(Vec::new()) };
        let boxes: Vec<Option<Numbers>> = list(KEY, value, MAX_COMPANIONS)?;
        let read = |numbers: Option<Numbers>| {
            let found = numbers.map_or(Ok(None), |numbers| region(KEY, numbers, base));
            Ok(found?.unwrap_or_else(Region::nowhere))
        };
        boxes.into_iter().map(read).collect()
    }

    /// Decodes the frame; `None` if the line has none.
    pub fn frame(self) -> Result<Option<Frame>, Cause> {
        let Some(value) = self.frame else { return Ok(None) };
        let text = value.get();
        let refused = |e: serde_json::Error| wrong("frame", e);
        if text.starts_with('{') {
            let RawFrame { raw } = serde_json::from_str(text).map_err(refused)?;
            let raw: Raw = object(raw.get().as_bytes()).map_err(refused)?;
            return raw.frame().map(Some);
        }
        if !text.starts_with('"') {
            let want = r#"want the path of an image, or {"raw": {"width", "height", "format", "data"}}"#;
            return Err(wrong("frame", want));
        }
        let path: PathBuf = serde_json::from_str(text).map_err(refused)?;
        let bytes = read_at_most(&path, MAX_FILE_BYTES).map_err(|e| wrong("frame", e))?;
        image::decode(&bytes).map(Some).map_err(|e| wrong(&format!("frame {}", path.display()), e))
    }
}

impl Raw {
    fn frame(self) -> Result<Frame, Cause> {
        let Self { width, height, format, data, path } = self;
        match (data, path) {
            (Some(text), None) => {
                Frame::from_base64(width, height, format, &text).map_err(|e| wrong("frame", e))
            }
            (None, Some(path)) => {
                let bytes = read_at_most(&path, 3 * MAX_PIXELS).map_err(|e| wrong("frame", e))?;
                let frame = Frame::from_raw(width, height, format, bytes);
                frame.map_err(|e| wrong(&format!("frame {}", path.display()), e))
            }
            _ => Err(wrong("frame", "give `data` or `path` of a raw frame, one of the two")),
        }
    }
}

/// Region of a box; `None` if one of its numbers is null.
fn region(key: &str, numbers: Numbers, base: f64) -> Result<Option<Region>, Cause> {
    check_length(key, numbers.len(), MAX_NUMBERS)?;
    let Some(mut numbers) = numbers.into_iter().collect::<Option<Vec<f64>>>() else { return Ok(None) };
    // The sides of a box do not depend on where pixels begin to count.
    let places = if numbers.len() == 4 { 2 } else { numbers.len() };
    numbers.iter_mut().take(places).for_each(|place| *place -= base);
    let region = Region::from_numbers(&numbers).map(Some);
    region.map_err(|e| wrong(key, format_args!("{e}; for a tracker that has no box, give null")))
}

/// The line with `null` for `NaN` and a number out of range for `Infinity`, both of which Python writes
/// though JSON lacks them. `None` if there are none outside of strings.
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

    fn read(text: &str) -> Result<Line, Cause> {
        Line::read(text.as_bytes())
    }

    /// Error message of a line, whichever part is wrong.
    fn told(text: &str) -> String {
        let parts = |line: Line| {
            line.region(0.0)?;
            line.companions(0.0)?;
            line.frame()
        };
        match read(text).and_then(parts) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("{text}"),
        }
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
                let told = told(&line);
                assert!(told.contains("number out of range"), "{line}: {told}");
            }
        }
    }

    #[test]
    fn words_inside_texts_are_left_alone() {
        let line = read(r#"{"frame": "NaN\\", "confidence": NaN, "box": null}"#).unwrap();
        assert_eq!(line.frame.unwrap().get(), r#""NaN\\""#);
        assert_eq!(without_nan(br#"{"frame": "a\"NaN"}"#), None);
    }

    #[test]
    fn only_an_object_is_a_line_or_a_raw_frame() {
        for list in
            ["[]", "[null, [1, 2, 3, 4], 0.5, null]", "[\"a.png\", [1, 2, 3, 4], null, [[1, 2, 3, 4]]]"]
        {
            let told = told(list);
            assert!(told.contains("invalid type: sequence, expected an object"), "{list}: {told}");
        }
        let raw = |raw: &str| format!("{{\"frame\": {{\"raw\": {raw}}}}}");
        let good = read(&raw(r#"{"width": 1, "height": 1, "format": "bgr", "data": "AAAA"}"#)).unwrap();
        assert!(good.frame().is_ok());
        let list = told(&raw(r#"[1, 1, "bgr", "AAAA", null]"#));
        assert!(list.contains("invalid type: sequence, expected an object"), "{list}");
        for other in ["7", "null", "\"a.png\"", "true"] {
            assert!(told(other).contains("expected an object"), "{other}");
        }
    }

    #[test]
    fn lists_and_lines_have_a_limit() {
        let list = |value: &str, count: usize| format!("[{}]", vec![value; count].join(","));
        let boxed = |count| format!("{{\"box\": {}}}", list("1", count));
        assert!(told(&boxed(MAX_NUMBERS)).ends_with("give null"));
        assert!(told(&boxed(MAX_NUMBERS + 1)).contains("box: a list of more than 2048 values"));
        let beside = |count, value: &str| format!("{{\"companions\": {}}}", list(value, count));
        let all = read(&beside(MAX_COMPANIONS, "null")).unwrap().companions(0.0).unwrap();
        assert_eq!(all.len(), MAX_COMPANIONS);
        assert!(told(&beside(MAX_COMPANIONS + 1, "null")).contains("a list of more than 256 values"));
        let long = told(&beside(1, &list("1", MAX_NUMBERS + 1)));
        assert!(long.contains("companions: a list of more than 2048 values"), "{long}");
        let blanks = " ".repeat(MAX_WITHOUT_DATA);
        assert!(told(&format!("{{{blanks}}}")).starts_with("the line is longer than 1 MiB, or "));
        assert!(read(&format!("{{{}}}", &blanks[2..])).is_ok());
        let raw = r#"{"frame": {"raw": {"width": 1, "height": 1, "format": "gray", "data": "AA=="}}}"#;
        assert!(read(&(raw.to_string() + &blanks[20..])).is_ok());
    }

    #[test]
    fn an_id_is_a_whole_number_or_a_text() {
        let id = |text: &str| read(&format!(r#"{{"id": {text}, "box": null}}"#)).unwrap().id;
        for (text, number) in [("7", 7), ("7.0", 7), ("-3.0", -3), ("1e3", 1000)] {
            assert_eq!(id(text), Some(Id::Number(number)), "{text}");
        }
        assert_eq!([id("\"7.0\""), id("null"), id("NaN")], [Some(Id::Text("7.0".into())), None, None]);
        for text in ["1.5", "true", "[7]", "{}", "1e19"] {
            let told = told(&format!(r#"{{"id": {text}}}"#));
            assert!(told.contains("expected an id, a whole number or a text"), "{told}");
        }
        assert!(told(r#"{"id": 9223372036854775808}"#).contains("give it as a text"));
    }

    #[test]
    fn mistakes_are_named() {
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
