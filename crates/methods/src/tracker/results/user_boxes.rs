//! Files of boxes from users, in the formats of common tools: one target, or several in MOTChallenge.
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
//! A header line gives the format in the same words. Without a header the format is found from all numbers.
//! If they fit several formats, the error lists these. Each line is a frame, unless a column has the number
//! of the frame. Frame numbers count from 1, or from 0 if the file has a frame 0, or are those of the frames'
//! files if they fit only these.

mod columns;
mod evidence;
mod notes;

use super::rows::{self, Row, drop_empty_end};
use super::{Base, NoBox, region};
use columns::Header;
pub use columns::{Columns, Role};
use std::path::{Path, PathBuf};
use trackfail_core::num::readable;
use trackfail_core::region::{Rect, Region, RegionError};
use trackfail_dataset::DatasetError;

/// Meaning of the numbers on a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BoxFormat {
    /// Named columns of a box, among them `xywh`, `xyxy` and `mot`.
    Columns(Columns),
    /// Lines of VOT, mostly polygons.
    Vot,
    /// Center and size as fractions of the frame, in lines of 4 to 7 numbers.
    Yolo,
}

/// Options for reading a file of boxes.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Format; `None`: from the header or the numbers.
    pub format: Option<BoxFormat>,
    /// Format to use if neither `format` nor a header gives one; `None`: it is found from the numbers.
    pub usual: Option<BoxFormat>,
    /// Number of the top left pixel; `None`: that of the format.
    pub base: Option<Base>,
    /// If true, a line that is empty, has NaN or no area, or has a box outside of the frame means that the
    /// target is absent.
    pub absent: bool,
    /// Number of frames, if it is known.
    pub frames: Option<usize>,
    /// Number of the first frame in a file that numbers them and fits it; else it is 0 if the file has a frame 0, and 1
    /// if not.
    pub first: Option<usize>,
    /// Number of the first frame by the name of its file, above 1; `None` if frames count from 0 or 1.
    pub number: Option<usize>,
    /// Width and height of the frames, if they are known.
    pub size: Option<(usize, usize)>,
}

/// Boxes that were read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct UserBoxes {
    /// Format of the file.
    pub format: BoxFormat,
    /// Number of the top left pixel; `None` if the format is not in pixels.
    pub base: Option<Base>,
    /// Number of the first frame; `None` if the file does not number frames.
    pub first: Option<usize>,
    /// Number of frames: of lines, or the largest that the file names.
    pub frames: usize,
    /// Targets by number. A format of one target has a single one, without a number.
    pub targets: Vec<UserTarget>,
}

/// Boxes of a target.
#[derive(Debug, Clone, PartialEq)]
pub struct UserTarget {
    /// Number of the target; `None` in a format of one target.
    pub id: Option<i64>,
    /// One region per frame, in 0-based pixels; `None` where the target is absent.
    pub regions: Vec<Option<Region>>,
}

/// Reason why a file of boxes cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum UserBoxesError {
    /// The file has an error.
    #[error(transparent)]
    Data(#[from] DatasetError),
    /// The file fits several formats.
    #[error("{}: the numbers may be {}", path.display(), listed(candidates))]
    Doubt {
        /// Path of the file.
        path: PathBuf,
        /// Formats that fit, the most likely first.
        candidates: Vec<Candidate>,
    },
}

/// A format that a file may have.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Format that fits the file.
    pub format: BoxFormat,
    /// The first box in this format; `None` if the first line has none.
    pub first: Option<Rect>,
}

/// The formats in words, each with its first box.
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

/// Formats that have a name.
const NAMED: [&str; 5] = ["xywh", "xyxy", "mot", "vot", "yolo"];

impl BoxFormat {
    /// Left, top, width, height in pixels.
    pub fn xywh() -> Self {
        Self::in_pixels(&[Role::Left, Role::Top, Role::Width, Role::Height], 0)
    }

    /// Format of MOTChallenge.
    pub fn mot() -> Self {
        Self::in_pixels(&[Role::Frame, Role::Target, Role::Left, Role::Top, Role::Width, Role::Height], 4)
    }

    /// Columns of boxes in pixels, and up to `spare` further columns, which are not read.
    fn in_pixels(roles: &[Role], spare: usize) -> Self {
        Self::Columns(Columns::new(roles.to_vec(), spare, Some(false)))
    }

    /// The format with a name such as `xywh`, or with words for columns between commas.
    ///
    /// # Errors
    /// When a word is not a column, or the columns do not make a box.
    pub fn read(text: &str) -> Result<Self, String> {
        match text {
            "xywh" => Ok(Self::xywh()),
            "xyxy" => Ok(Self::in_pixels(&[Role::Left, Role::Top, Role::Right, Role::Bottom], 0)),
            "mot" => Ok(Self::mot()),
            "vot" => Ok(Self::Vot),
            "yolo" => Ok(Self::Yolo),
            text => Ok(columns::of_user(text)?.map_or(Self::Vot, Self::Columns)),
        }
    }

    /// Text from which [`BoxFormat::read`] gets this format.
    pub fn option(&self) -> String {
        let named = NAMED.into_iter().find(|name| Self::read(name).is_ok_and(|format| format == *self));
        named.map_or_else(|| self.words(), str::to_string)
    }

    /// Words for the content of a line, for messages.
    pub fn words(&self) -> String {
        match self {
            Self::Columns(columns) => columns.words(),
            Self::Vot => "corners of polygons".into(),
            Self::Yolo => "centers and sizes of YOLO".into(),
        }
    }

    /// Words for the columns that are not read.
    pub fn unread(&self) -> Vec<&'static str> {
        self.columns().map_or_else(Vec::new, Columns::unread)
    }

    /// Usual number of the top left pixel; `None` if the format is in fractions of the frame.
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

/// Reads the boxes of a file; `path` is for messages.
///
/// # Errors
/// File and line of a box that is wrong or lies outside of the frame, a format that is in doubt, and boxes in
/// fractions of frames whose size is unknown.
pub fn parse(path: &Path, bytes: &[u8], options: &Options) -> Result<UserBoxes, UserBoxesError> {
    // The number of its version, 1 in two bytes, begins a trajectory of the VOT toolkit.
    if bytes.starts_with(b"\x01\0") {
        return Err(DatasetError::content(path, super::BINARY).into());
    }
    let with_commas = columns::with_commas(bytes);
    let mut lines = rows::lines(path, with_commas.as_deref().unwrap_or(bytes))?;
    let header = rows::take_header(path, &mut lines)?.filter(|_| options.format.is_none());
    let header = header.map(|line| Header::read(path, line)).transpose()?;
    let said = header.as_ref().map(|header| &header.format);
    let given = options.format.as_ref().or(said).or(options.usual.as_ref());
    let columns = given.and_then(BoxFormat::columns);
    let mut rows = rows::numbers(path, lines, |line| columns::values(line, columns))?;
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
        if targets.iter().flat_map(|target| &target.regions).all(Option::is_none) {
            return Err(DatasetError::content(self.path, "no frame has a box"));
        }
        let base = self.base();
        Ok(UserBoxes { format: self.format, base, first, frames, targets })
    }

    /// The first box, in the pixels of the file.
    fn first(&self, rows: &[Row]) -> Option<Rect> {
        let region = |(line, row): &Row| self.region(*line, row).ok().flatten();
        let region = rows.iter().find_map(region)?;
        Some(self.base().unwrap_or(Base::Zero).from_zero(&region).bounds())
    }

    /// Number of the top left pixel; `None` for fractions of the frame.
    fn base(&self) -> Option<Base> {
        self.format.base().map(|own| self.options.base.unwrap_or(own))
    }

    /// The region of a line; `None` if the target is absent.
    fn region(&self, line: usize, row: &[f64]) -> Result<Option<Region>, DatasetError> {
        let numbers = match (&self.format, row) {
            (_, []) => return self.without_box(line, NoBox::EmptyLine),
            // NaN stands for a box in any number of columns.
            (_, row) if row.iter().all(|v| v.is_nan()) => {
                return self.without_box(line, RegionError::NotFinite.into());
            }
            (BoxFormat::Vot, [0.0 | 1.0 | 2.0]) => return Ok(None),
            (BoxFormat::Vot, row) => row.to_vec(),
            (BoxFormat::Yolo, &[x, y, w, h] | &[_, x, y, w, h, ..]) if row.len() <= 7 => {
                self.in_pixels(line, [x - w / 2.0, y - h / 2.0, w, h])?
            }
            (BoxFormat::Columns(columns), row) if columns.fits(row.len()) => match columns.shares {
                Some(true) => self.in_pixels(line, columns.rect(row))?,
                _ => columns.rect(row).to_vec(),
            },
            _ => {
                let (count, format) = (row.len(), self.format.option());
                let message = format!("{count} numbers, which are no box of the format {format}");
                return Err(self.fault(line, message));
            }
        };
        self.region_of(line, &numbers)
    }

    /// Left, top, width and height in pixels, from fractions of the frame.
    fn in_pixels(&self, line: usize, shares: [f64; 4]) -> Result<Vec<f64>, DatasetError> {
        let Some((width, height)) = self.options.size else {
            let message =
                "the boxes are shares of the frame's sides, so the frames are needed; give --frames";
            return Err(DatasetError::content(self.path, message));
        };
        if shares.iter().any(|v| v.abs() > 2.0) {
            let message = "a share of the frame's side above 2; are these pixels (--boxes-format xywh)?";
            return Err(self.fault(line, message));
        }
        let sides = [width, height, width, height];
        Ok(shares.iter().zip(sides).map(|(share, side)| share * side as f64).collect())
    }

    /// The region of numbers in the pixels of the file.
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
                let message = format!(
                    "the box {x},{y},{w},{h} (x,y,w,h) lies outside of the frame of {width}x{height} pixels; if that \
                     means that the target is absent, give --absent"
                );
                Err(self.fault(line, message))
            }
            _ => Ok(Some(region)),
        }
    }

    /// Result for a line without a box: `None` if such lines mean absence, else an error.
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

    /// Number of the first frame: that of its file if the rows fit the numbers of the files and none from 0 or 1,
    /// else that of the options if the rows fit it. `None`: a frame 0 tells.
    fn first_frame(&self, rows: &[Row], frame: usize) -> Option<usize> {
        let Options { first, number, frames, .. } = *self.options;
        let count = frames.unwrap_or(0);
        let fit = |from: usize, count: usize| {
            let range = from as f64..(from + count) as f64;
            rows.iter().all(|(_, row)| row.get(frame).is_some_and(|n| range.contains(n)))
        };
        let of_files = number.filter(|number| fit(*number, count) && !fit(0, count + 1));
        of_files.or(first.filter(|first| fit(*first, count)))
    }

    /// Number of frames, number of the first frame, and targets of a file with frame numbers in column
    /// `frame`.
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
        let (frames, first) = (self.options.frames, self.first_frame(rows, frame));
        let (first, targets) = rows::by_target(self.path, rows, (frame, target), frames, first)?;
        let last = targets.values().flat_map(|rows| rows.keys()).max().map_or(0, |last| last + 1);
        let frames = frames.unwrap_or(last);
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

/// Largest product of targets and frames.
const MAX_BOXES: usize = 5_000_000;

/// True if no part of the region is inside a frame of this width and height.
fn is_outside(region: &Region, (width, height): (usize, usize)) -> bool {
    let frame = Region::Rect(Rect::new(0.0, 0.0, width as f64, height as f64));
    region.intersection(&frame) <= 0.0
}

#[cfg(test)]
mod tests;
