//! Boxes as users have them, in the formats of common tools: one target, or several of MOTChallenge.
//!
//! | format | a line | pixels count from |
//! |---|---|---|
//! | `xywh` | left, top, width, height | 1, or 0 on request |
//! | `xyxy` | left, top, right, bottom edge | 1, or 0 on request |
//! | `mot` | frame from 1, target, left, top, width, height, and up to four columns that are not read | 1, or 0 on request |
//! | `vot` | corners `x1,y1,x2,y2,...`, or left, top, width, height; a single number is a mark of the VOT protocol, a frame without a box | 0, or 1 on request |
//! | `yolo` | center and size as shares of the frame's sides, perhaps after a class and before a confidence | |
//!
//! In all but `mot` a line is a frame. A header line of words is skipped. `BoxFormat::of` finds the format where the
//! numbers leave no doubt.

use super::{Base, NoBox, drop_empty_end};
use crate::dataset::{DatasetError, text};
use crate::num::readable;
use crate::region::{Rect, Region, RegionError};
use std::collections::BTreeMap;
use std::path::Path;

/// Forms of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoxFormat {
    /// Left, top, width, height.
    Xywh,
    /// Left, top, right, bottom.
    Xyxy,
    /// MOTChallenge.
    Mot,
    /// VOT, polygons above all.
    Vot,
    /// Relative to the frame.
    Yolo,
}

/// How a file is read.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// Its format; without one it is found out.
    pub format: Option<BoxFormat>,
    /// Number of the left top pixel; without one, the format's own.
    pub base: Option<Base>,
    /// Whether lines that are empty, have NaN, no area, or a box outside of the frame mean that the target is absent.
    pub absent: bool,
    /// Number of frames, where known.
    pub frames: Option<usize>,
    /// Width and height of the frames, where known.
    pub size: Option<(usize, usize)>,
}

/// The boxes of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct UserBoxes {
    /// The format that the file has.
    pub format: BoxFormat,
    /// Number of its frames: of its lines, or the largest that is named.
    pub frames: usize,
    /// Its targets, by number; a single one without a number in formats of one target.
    pub targets: Vec<UserTarget>,
}

/// The boxes of a target.
#[derive(Debug, Clone, PartialEq)]
pub struct UserTarget {
    /// Its number in a file of several.
    pub id: Option<i64>,
    /// A region in 0-based pixels for each frame; `None` where the target is absent.
    pub regions: Vec<Option<Region>>,
}

/// A line of a file: its number from 1, and its numbers; none for an empty line.
type Row = (usize, Vec<f64>);

impl BoxFormat {
    /// All formats with the words that name them.
    pub const NAMED: [(Self, &'static str); 5] = [
        (Self::Xywh, "xywh"),
        (Self::Xyxy, "xyxy"),
        (Self::Mot, "mot"),
        (Self::Vot, "vot"),
        (Self::Yolo, "yolo"),
    ];

    /// Number of the left top pixel where nobody says otherwise.
    pub fn base(self) -> Base {
        match self {
            Self::Xywh | Self::Xyxy | Self::Mot => Base::One,
            Self::Vot | Self::Yolo => Base::Zero,
        }
    }

    /// The format of rows after a header, which may be empty.
    ///
    /// Four numbers are `x,y,w,h`, unless the header names corners or all numbers are shares of a side. Two rows of whole
    /// numbers before five, seven or eight others are MOTChallenge, eight numbers otherwise four corners.
    fn of(header: &str, rows: &[Row]) -> Result<Self, &'static str> {
        let full = || rows.iter().filter(|(_, values)| !values.is_empty());
        let columns = full().map(|(_, values)| values.len()).max().unwrap_or(0);
        let is_share = |v: &f64| v.is_nan() || (0.0..=1.0).contains(v);
        let shares = |skip: usize| {
            let mut all = full().map(|(_, values)| values.iter().skip(skip));
            all.all(|mut values| values.all(is_share))
        };
        let is_whole = |v: &f64| v.fract() == 0.0;
        let numbered = || {
            let mut rows = full();
            rows.all(|(_, v)| {
                v.len() > 2 && v.iter().take(2).all(is_whole) && v.first().is_some_and(|t| *t >= 1.0)
            })
        };
        let names_corners = ["x2", "xmax", "x_max", "right"].iter().any(|word| header.contains(word));
        match columns {
            0..=1 => Ok(Self::Vot),
            4 if names_corners => Ok(Self::Xyxy),
            4 if shares(0) => Ok(Self::Yolo),
            4 => Ok(Self::Xywh),
            5 | 6 if shares(1) => Ok(Self::Yolo),
            7 | 9 => Ok(Self::Mot),
            10 if numbered() => Ok(Self::Mot),
            6 | 8 if numbered() => {
                Err("may be a row of MOTChallenge or a polygon; say which with --boxes-format mot or vot")
            }
            n if n >= 6 && n % 2 == 0 => Ok(Self::Vot),
            _ => Err(
                "fits no format: x,y,w,h and x1,y1,x2,y2 have 4 numbers, YOLO 4 to 6, MOTChallenge 6 to 10, polygons 6, 8, ...",
            ),
        }
    }
}

/// Reads the boxes of a file; `path` names it in messages.
///
/// # Errors
/// File and line of whatever is no box in its format or lies outside of the frame, a format that is in doubt, and boxes
/// that are shares of frames of unknown size.
pub fn parse(path: &Path, bytes: &[u8], options: &Options) -> Result<UserBoxes, DatasetError> {
    let (header, mut rows) = rows(path, bytes)?;
    drop_empty_end(&mut rows, |(_, v)| v.is_empty(), |n| options.absent && Some(n) == options.frames);
    let found = || {
        let line = rows.iter().find(|(_, v)| !v.is_empty()).map_or(1, |(line, _)| *line);
        BoxFormat::of(&header, &rows).map_err(|message| {
            let count = rows.iter().map(|(_, v)| v.len()).max().unwrap_or(0);
            DatasetError::line(path, line, format!("a line of {count} numbers {message}"))
        })
    };
    let format = options.format.map_or_else(found, Ok)?;
    let reader = Reader { path, format, options };
    let (frames, targets) = match format {
        BoxFormat::Mot => reader.targets(&rows)?,
        _ => {
            let regions =
                rows.iter().map(|(line, row)| reader.region(*line, row)).collect::<Result<Vec<_>, _>>()?;
            (regions.len(), vec![UserTarget { id: None, regions }])
        }
    };
    if let Some(empty) = targets.iter().find(|t| t.regions.iter().all(Option::is_none)) {
        let target = empty.id.map_or_else(String::new, |id| format!(" of target {id}"));
        return Err(DatasetError::content(path, format!("no frame has a box{target}")));
    }
    Ok(UserBoxes { format, frames, targets })
}

/// The header, or an empty text, and the rows.
fn rows(path: &Path, bytes: &[u8]) -> Result<(String, Vec<Row>), DatasetError> {
    let mut lines = text::lines_or_empty(path, text::decode(path, bytes)?)?;
    let mut header = String::new();
    if let Some((_, line)) = lines.first().filter(|(_, line)| is_header(line)) {
        header = line.to_ascii_lowercase();
        lines.remove(0);
    }
    if lines.iter().all(|(_, line)| line.is_empty()) {
        return Err(DatasetError::content(path, "a header and no box; one box a frame was expected"));
    }
    let row = |(line, text): (usize, &str)| {
        let values = if text.is_empty() { Ok(Vec::new()) } else { text::numbers(text) };
        let values = values.map_err(|e| DatasetError::line(path, line, e))?;
        if values.iter().any(|v| v.is_infinite()) {
            return Err(DatasetError::line(path, line, RegionError::NotFinite.to_string()));
        }
        Ok((line, values))
    };
    Ok((header, lines.into_iter().map(row).collect::<Result<_, _>>()?))
}

/// Whether a line is words.
fn is_header(line: &str) -> bool {
    let mut words = line.split(|c: char| ",;".contains(c) || c.is_whitespace()).filter(|w| !w.is_empty());
    let is_word = |w: &str| w.parse::<f64>().is_err() && w.contains(char::is_alphabetic);
    words.clone().count() >= 4 && words.all(is_word)
}

struct Reader<'a> {
    path: &'a Path,
    format: BoxFormat,
    options: &'a Options,
}

impl Reader<'_> {
    fn fault(&self, line: usize, message: impl Into<String>) -> DatasetError {
        DatasetError::line(self.path, line, message)
    }

    /// The region of a line that is a frame; `None` for an absent target.
    fn region(&self, line: usize, row: &[f64]) -> Result<Option<Region>, DatasetError> {
        let count = row.len();
        let four = |of: &[f64]| <[f64; 4]>::try_from(of).ok();
        let numbers = match (self.format, row) {
            (_, []) => return self.without_box(line, NoBox::EmptyLine),
            // NaN stands for a box in any number of columns.
            (_, row) if row.iter().all(|v| v.is_nan()) => {
                return self.without_box(line, RegionError::NotFinite.into());
            }
            (BoxFormat::Vot, [0.0 | 1.0 | 2.0]) => return Ok(None),
            (BoxFormat::Vot, row) => Some(row.to_vec()),
            (BoxFormat::Xyxy, row) => {
                four(row).map(|[left, top, right, bottom]| vec![left, top, right - left, bottom - top])
            }
            (BoxFormat::Yolo, row) => {
                let shares =
                    if count == 4 { row } else { row.get(1..5).filter(|_| count <= 6).unwrap_or_default() };
                four(shares).map(|shares| self.pixels_of_shares(line, shares)).transpose()?.map(Vec::from)
            }
            (_, row) => four(row).map(Vec::from),
        };
        let Some(numbers) = numbers else {
            let (_, word) =
                BoxFormat::NAMED.into_iter().find(|(f, _)| *f == self.format).unwrap_or(BoxFormat::NAMED[0]);
            return Err(self.fault(line, format!("{count} numbers, which are no box of the format {word}")));
        };
        self.region_of(line, &numbers)
    }

    /// A box in pixels from its center and size as shares of the frame's sides.
    fn pixels_of_shares(&self, line: usize, [x, y, w, h]: [f64; 4]) -> Result<[f64; 4], DatasetError> {
        let Some((width, height)) = self.options.size else {
            let message =
                "YOLO boxes are shares of the frame's sides, so the frames are needed; give --frames";
            return Err(DatasetError::content(self.path, message));
        };
        if [x, y, w, h].iter().any(|v| v.abs() > 2.0) {
            return Err(self.fault(
                line,
                "a share of the frame's side above 2; are these pixels (--boxes-format xywh)?",
            ));
        }
        let (width, height) = (width as f64, height as f64);
        Ok([(x - w / 2.0) * width, (y - h / 2.0) * height, w * width, h * height])
    }

    /// The region of numbers in the file's pixels.
    fn region_of(&self, line: usize, numbers: &[f64]) -> Result<Option<Region>, DatasetError> {
        let base = if self.format == BoxFormat::Yolo { None } else { self.options.base };
        let base = base.unwrap_or(self.format.base());
        let region = match Region::from_numbers(numbers) {
            Ok(region) => base.to_zero(region),
            Err(e) => return self.without_box(line, e.into()),
        };
        match self.options.size {
            Some((width, height)) if is_outside(&region, (width, height)) => {
                if self.options.absent {
                    return Ok(None);
                }
                let Rect { x, y, w, h } = base.from_zero(&region).bounds();
                let [x, y, w, h] = [x, y, w, h].map(readable);
                Err(self.fault(
                    line,
                    format!(
                        "the box {x},{y},{w},{h} (x,y,w,h) lies outside of the frame of {width}x{height} pixels; if that \
                         means that the target is absent, give --absent"
                    ),
                ))
            }
            _ => Ok(Some(region)),
        }
    }

    /// A frame without a box.
    fn without_box(&self, line: usize, reason: NoBox) -> Result<Option<Region>, DatasetError> {
        match reason.may_be_absence() {
            true if self.options.absent => Ok(None),
            true => {
                let message = format!("{reason}; if that means that the target is absent, give --absent");
                Err(self.fault(line, message))
            }
            false => Err(self.fault(line, reason.to_string())),
        }
    }

    /// Number of frames and the targets of a file of MOTChallenge.
    fn targets(&self, rows: &[Row]) -> Result<(usize, Vec<UserTarget>), DatasetError> {
        let mut targets: BTreeMap<i64, BTreeMap<usize, Option<Region>>> = BTreeMap::new();
        for (line, row) in rows {
            let &[frame, id, x, y, w, h, ..] = row.as_slice() else {
                return Err(
                    self.fault(*line, format!("{} columns; a row is frame,id,x,y,w,h,...", row.len()))
                );
            };
            if row.len() > 10 {
                return Err(self.fault(*line, format!("{} columns; a row has at most 10", row.len())));
            }
            let whole = |v: f64| (v.fract() == 0.0 && v.abs() < 1e9).then_some(v as i64);
            let numbers = (whole(frame).and_then(|f| usize::try_from(f).ok()?.checked_sub(1)), whole(id));
            let (Some(frame), Some(id)) = numbers else {
                return Err(self.fault(*line, "frame (from 1 on) and id are whole numbers"));
            };
            if let Some(frames) = self.options.frames.filter(|frames| frame >= *frames) {
                return Err(self.fault(*line, format!("frame {}, but there are {frames} frames", frame + 1)));
            }
            let region = self.region_of(*line, &[x, y, w, h])?;
            if targets.entry(id).or_default().insert(frame, region).is_some() {
                return Err(self.fault(*line, format!("a second row of target {id} in frame {}", frame + 1)));
            }
        }
        let last = targets.values().flat_map(|rows| rows.keys()).max().map_or(0, |last| last + 1);
        let frames = self.options.frames.unwrap_or(last);
        // A file of a few rows may name any frame.
        if frames.saturating_mul(targets.len()) > MAX_BOXES {
            let message = format!(
                "{} targets in {frames} frames; at most {MAX_BOXES} targets times frames are read, so give a part of them",
                targets.len()
            );
            return Err(DatasetError::content(self.path, message));
        }
        let target = |(id, mut rows): (i64, BTreeMap<usize, Option<Region>>)| UserTarget {
            id: Some(id),
            regions: (0..frames).map(|t| rows.remove(&t).flatten()).collect(),
        };
        Ok((frames, targets.into_iter().map(target).collect()))
    }
}

/// Largest number of targets times frames of a file that names both.
const MAX_BOXES: usize = 5_000_000;

/// Whether no part of a region lies in a frame of this width and height.
fn is_outside(region: &Region, (width, height): (usize, usize)) -> bool {
    let frame = Region::Rect(Rect::new(0.0, 0.0, width as f64, height as f64));
    region.intersection(&frame) <= 0.0
}

#[cfg(test)]
mod tests;
