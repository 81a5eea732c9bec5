//! Boxes as users have them, in the formats of common tools: one target, or several of MOTChallenge.
//!
//! | format | a line | pixels count from |
//! |---|---|---|
//! | `xywh` | left, top, width, height | 1, or 0 on request |
//! | `xyxy` | left, top, right, bottom edge | 1, or 0 on request |
//! | `mot` | frame, target, left, top, width, height, and up to four columns that are not read | 1, or 0 on request |
//! | `vot` | corners `x1,y1,x2,y2,...`, or left, top, width, height; a single number is a mark of the VOT protocol, a frame without a box | 0, or 1 on request |
//! | `yolo` | center and size as shares of the frame's sides, perhaps after a class and before a confidence and a number | |
//! | words for columns | such as `frame,x1,y1,x2,y2,confidence`; shares where all numbers of boxes are about 0 to 1 | 1, or 0 on request |
//!
//! A header line says the format in the same words. Without one it is found out from all numbers; where these fit several
//! formats, that is an error which has them. A line is a frame, unless a column is the number of the frame. These
//! count from 1, or from 0 in a file that has a frame 0.

mod columns;
mod evidence;
mod header;
mod notes;

use super::rows::{self, Row, drop_empty_end};
use super::{Base, NoBox, region};
pub use columns::{Columns, ColumnsError, Role};
use header::Header;
use std::path::{Path, PathBuf};
use trackfail_core::num::readable;
use trackfail_core::region::{Rect, Region, RegionError};
use trackfail_dataset::DatasetError;

/// Content of the lines of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BoxFormat {
    /// Columns of a box, `xywh`, `xyxy` and `mot` among them.
    Columns(Columns),
    /// VOT, polygons above all.
    Vot,
    /// Center and size relative to the frame, in lines of 4 to 7 numbers.
    Yolo,
}

/// How a file is read.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Its format.
    pub format: Option<BoxFormat>,
    /// Its format if nothing else, no header either, says one; without this it is found out.
    pub usual: Option<BoxFormat>,
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
    /// Number of the left top pixel, of formats in pixels.
    pub base: Option<Base>,
    /// Number of the first frame, in a file that numbers them.
    pub first: Option<usize>,
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

/// Why a file of boxes cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum UserBoxesError {
    /// It has a fault.
    #[error(transparent)]
    Data(#[from] DatasetError),
    /// It may be several things.
    #[error("{}: the numbers may be {}", path.display(), listed(candidates))]
    Doubt {
        /// The file.
        path: PathBuf,
        /// Formats that fit, the likeliest first.
        candidates: Vec<Candidate>,
    },
}

/// A format that a file may have.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The format.
    pub format: BoxFormat,
    /// The first box in this format, if it is one.
    pub first: Option<Rect>,
}

/// The formats in words, with the box that each finds first.
fn listed(candidates: &[Candidate]) -> String {
    let words = |candidate: &Candidate| {
        let first = candidate.first.map_or_else(String::new, |Rect { x, y, w, h }| {
            let [x, y, w, h] = [x, y, w, h].map(|v| readable((v * 100.0).round() / 100.0));
            format!(" (the first box is {w} wide and {h} high at {x},{y})")
        });
        format!("{}{first}", candidate.format.words())
    };
    candidates.iter().map(words).collect::<Vec<_>>().join(" or ")
}

/// Words for the formats that have a name of their own.
const NAMED: [&str; 5] = ["xywh", "xyxy", "mot", "vot", "yolo"];

impl BoxFormat {
    /// Left, top, width, height in pixels.
    pub fn xywh() -> Self {
        Self::in_pixels(&[Role::Left, Role::Top, Role::Width, Role::Height], 0)
    }

    /// Left, top, right, bottom in pixels.
    pub fn xyxy() -> Self {
        Self::in_pixels(&[Role::Left, Role::Top, Role::Right, Role::Bottom], 0)
    }

    /// MOTChallenge.
    pub fn mot() -> Self {
        Self::in_pixels(&[Role::Frame, Role::Target, Role::Left, Role::Top, Role::Width, Role::Height], 4)
    }

    /// Columns of boxes in pixels, and `spare` more that may be there and are not read.
    fn in_pixels(roles: &[Role], spare: usize) -> Self {
        Self::Columns(Columns::new(roles.to_vec(), Some(false)).and_spare(spare))
    }

    /// The format of a name such as `xywh`, or of words for columns, joined by commas.
    ///
    /// # Errors
    /// Words that name no column, or no whole box.
    pub fn read(text: &str) -> Result<Self, ColumnsError> {
        match text {
            "xywh" => Ok(Self::xywh()),
            "xyxy" => Ok(Self::xyxy()),
            "mot" => Ok(Self::mot()),
            "vot" => Ok(Self::Vot),
            "yolo" => Ok(Self::Yolo),
            text => Ok(columns::of_user(text)?.map_or(Self::Vot, Self::Columns)),
        }
    }

    /// The text that [`BoxFormat::read`] takes for it.
    pub fn option(&self) -> String {
        let named = NAMED.into_iter().find(|name| Self::read(name).is_ok_and(|format| format == *self));
        named.map_or_else(|| self.words(), str::to_string)
    }

    /// The content of a line in words.
    pub fn words(&self) -> String {
        match self {
            Self::Columns(columns) => columns.words(),
            Self::Vot => "corners of polygons".into(),
            Self::Yolo => "centers and sizes of YOLO".into(),
        }
    }

    /// Words for columns that are not read.
    pub fn unread(&self) -> Vec<&'static str> {
        match self {
            Self::Columns(columns) => columns.unread(),
            Self::Vot | Self::Yolo => Vec::new(),
        }
    }

    /// Number of the left top pixel where nobody says otherwise; `None` for shares of the frame's sides.
    fn base(&self) -> Option<Base> {
        match self {
            Self::Columns(columns) => (columns.shares != Some(true)).then_some(Base::One),
            Self::Vot => Some(Base::Zero),
            Self::Yolo => None,
        }
    }

    fn columns(&self) -> Option<&Columns> {
        if let Self::Columns(columns) = self { Some(columns) } else { None }
    }
}

/// Reads the boxes of a file; `path` names it in messages.
///
/// # Errors
/// File and line of whatever is no box in its format or lies outside of the frame, a format that is in doubt, and boxes
/// that are shares of frames of unknown size.
pub fn parse(path: &Path, bytes: &[u8], options: &Options) -> Result<UserBoxes, UserBoxesError> {
    // The number of its version, 1 in two bytes, begins a trajectory of the VOT toolkit.
    if bytes.starts_with(b"\x01\0") {
        return Err(DatasetError::content(path, super::BINARY).into());
    }
    let mut lines = rows::lines(path, bytes)?;
    let header = rows::take_header(path, &mut lines)?.filter(|_| options.format.is_none());
    let header = header.map(|line| Header::read(path, line)).transpose()?;
    let said = header.as_ref().map(|header| &header.format);
    let given = options.format.as_ref().or(said).or(options.usual.as_ref());
    let columns = given.and_then(BoxFormat::columns);
    let mut rows = rows::numbers(path, lines, |line| header::values(line, columns))?;
    drop_empty_end(&mut rows, |n| options.absent && Some(n) == options.frames);
    let mut formats = match (&header, given) {
        (Some(header), _) => evidence::of_header(header, &rows, options.size),
        (None, Some(format)) => vec![evidence::with_unit(format.clone(), &rows)],
        (None, None) => evidence::candidates(&rows, options),
    };
    let reader = |format| Reader { path, format, options };
    if formats.len() > 1 {
        let candidate = |format: BoxFormat| Candidate { first: reader(format.clone()).first(&rows), format };
        let candidates = formats.into_iter().map(candidate).collect();
        return Err(UserBoxesError::Doubt { path: path.to_path_buf(), candidates });
    }
    if let Some(format) = formats.pop() {
        return Ok(reader(format).read(&rows)?);
    }
    let counts = rows.iter().rev().map(|(line, v)| (*line, v.len()));
    let (line, count) = counts.max_by_key(|(_, count)| *count).unwrap_or((1, 0));
    // The format that so many numbers have most often tells what is wrong with them.
    match evidence::usual(count).map(|format| reader(format).read(&rows)) {
        Some(Ok(boxes)) if count == 4 || boxes.format == BoxFormat::Vot => Ok(boxes),
        Some(Err(e)) => Err(e.into()),
        _ => Err(DatasetError::line(path, line, no_format(count)).into()),
    }
}

fn no_format(count: usize) -> String {
    format!(
        "a line of {count} numbers fits no format; name the columns in a header line or with --boxes-format, such as \
         frame,x,y,w,h or x1,y1,x2,y2,confidence,class, or say vot for the corners of polygons"
    )
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

    fn read(self, rows: &[Row]) -> Result<UserBoxes, DatasetError> {
        let numbered =
            self.format.columns().and_then(|columns| Some((columns, columns.position(Role::Frame)?)));
        let (frames, first, targets) = match numbered {
            Some((columns, frame)) => self.targets(rows, columns, frame)?,
            None => {
                let regions = rows.iter().map(|(line, row)| self.region(*line, row));
                let regions = regions.collect::<Result<Vec<_>, _>>()?;
                (regions.len(), None, vec![UserTarget { id: None, regions }])
            }
        };
        if let Some(empty) = targets.iter().find(|t| t.regions.iter().all(Option::is_none)) {
            let target = empty.id.map_or_else(String::new, |id| format!(" of target {id}"));
            return Err(DatasetError::content(self.path, format!("no frame has a box{target}")));
        }
        let base = self.base();
        Ok(UserBoxes { format: self.format, base, first, frames, targets })
    }

    /// The first box, in the file's pixels.
    fn first(&self, rows: &[Row]) -> Option<Rect> {
        let region = |(line, row): &Row| self.region(*line, row).ok().flatten();
        let region = rows.iter().find_map(region)?;
        Some(self.base().unwrap_or(Base::Zero).from_zero(&region).bounds())
    }

    /// Number of the left top pixel; `None` for shares.
    fn base(&self) -> Option<Base> {
        self.format.base().map(|own| self.options.base.unwrap_or(own))
    }

    /// The region of a line; `None` for an absent target.
    fn region(&self, line: usize, row: &[f64]) -> Result<Option<Region>, DatasetError> {
        let numbers = match (&self.format, row) {
            (_, []) => return self.without_box(line, NoBox::EmptyLine),
            // NaN stands for a box in any number of columns.
            (_, row) if row.iter().all(|v| v.is_nan()) => {
                return self.without_box(line, RegionError::NotFinite.into());
            }
            (BoxFormat::Vot, [0.0 | 1.0 | 2.0]) => return Ok(None),
            (BoxFormat::Vot, row) => row.to_vec(),
            (BoxFormat::Yolo, &[x, y, w, h]) => self.in_pixels(line, [x - w / 2.0, y - h / 2.0, w, h])?,
            (BoxFormat::Yolo, &[_, x, y, w, h, ..]) if row.len() <= 7 => {
                self.in_pixels(line, [x - w / 2.0, y - h / 2.0, w, h])?
            }
            (BoxFormat::Columns(columns), row) if columns.fits(row.len()) => match columns.shares {
                Some(true) => self.in_pixels(line, columns.rect(row))?,
                _ => columns.rect(row).to_vec(),
            },
            _ => {
                let (count, format) = (row.len(), self.format.option());
                return Err(
                    self.fault(line, format!("{count} numbers, which are no box of the format {format}"))
                );
            }
        };
        self.region_of(line, &numbers)
    }

    /// Left, top, width and height in pixels, of such shares of the frame's sides.
    fn in_pixels(&self, line: usize, shares: [f64; 4]) -> Result<Vec<f64>, DatasetError> {
        let Some((width, height)) = self.options.size else {
            let message =
                "the boxes are shares of the frame's sides, so the frames are needed; give --frames";
            return Err(DatasetError::content(self.path, message));
        };
        if shares.iter().any(|v| v.abs() > 2.0) {
            return Err(self.fault(
                line,
                "a share of the frame's side above 2; are these pixels (--boxes-format xywh)?",
            ));
        }
        let sides = [width, height, width, height];
        Ok(shares.iter().zip(sides).map(|(share, side)| share * side as f64).collect())
    }

    /// The region of numbers in the file's pixels.
    fn region_of(&self, line: usize, numbers: &[f64]) -> Result<Option<Region>, DatasetError> {
        let base = self.base().unwrap_or(Base::Zero);
        let region = match region(numbers, base) {
            Ok(region) => region,
            Err(reason) => return self.without_box(line, reason),
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

    /// Number of frames, number of the first one and the targets of a file that numbers its frames in column `frame`.
    fn targets(
        &self,
        rows: &[Row],
        columns: &Columns,
        frame: usize,
    ) -> Result<(usize, Option<usize>, Vec<UserTarget>), DatasetError> {
        if let Some((line, row)) = rows.iter().find(|(_, row)| !columns.fits(row.len())) {
            let message = format!("{} columns; a row is {}", row.len(), self.format.words());
            return Err(self.fault(*line, message));
        }
        let target = columns.position(Role::Target);
        let (first, targets) = rows::by_target(self.path, rows, frame, target, self.options.frames)?;
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
        let mut read = Vec::new();
        for (id, rows) in targets {
            let mut regions = vec![None; frames];
            for (t, (line, row)) in rows {
                regions[t] = self.region(*line, row)?;
            }
            read.push(UserTarget { id, regions });
        }
        Ok((frames, Some(first), read))
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
