//! Finds the format of a file from its numbers.
//!
//! A row is a box, perhaps after a frame, a target or a class, and before a confidence or other columns. Each
//! such order of columns is tried twice: with left, top, width, height, and with left, top, right, bottom. It
//! is kept if it fits all rows: frame numbers ascend, targets and classes are whole numbers, confidences are
//! between 0 and 1, sizes are positive. Formats whose boxes reach far outside of the frame are dropped if
//! there are others. If both kinds of boxes are left, the kind is taken whose sizes change clearly less from
//! row to row. Rows of four numbers and rows of MOTChallenge are usually left, top, width, height; they are
//! read so unless the numbers speak against it.

use super::columns::{Columns, Header, Role};
use super::{BoxFormat, Options, Row};
use Role::{
    Bottom, CenterX, CenterY, Class, Confidence, Frame, Height, Left, Other, Right, Target, Top, Width,
};
use std::collections::{BTreeMap, BTreeSet};
use trackfail_core::num::summary;
use trackfail_core::region::{Rect, Region, RegionError};

/// Where left, top, width, height is the usual format, left, top, right, bottom is possible only if its sizes
/// change less or spread less than this fraction of those of the usual format. Rounded corners of a target
/// that hardly moves reach .9 in change and .6 in spread. Of 1274 results of trackers for OTB two may be
/// corners, and none is doubted.
const MUCH: f64 = 0.9;

/// Columns before a box, and the largest number of columns after it.
const SHAPES: [(&[Role], usize); 5] =
    [(&[], 4), (&[Frame, Target], 4), (&[Frame], 2), (&[Class], 1), (&[Class, Confidence], 0)];
/// Columns before a box that is in fractions of the frame.
const SHAPES_OF_SHARES: [&[Role]; 3] = [&[], &[Frame], &[Class]];
const SIDES: [Role; 4] = [Left, Top, Width, Height];
const CENTERS: [Role; 4] = [CenterX, CenterY, Width, Height];
const CORNERS: [Role; 4] = [Left, Top, Right, Bottom];

/// Formats that rows without a header may have, the most likely first; empty if none fits.
pub(super) fn candidates(rows: &[Row], options: &Options) -> Vec<BoxFormat> {
    let count = rows.iter().map(|(_, row)| row.len()).max().unwrap_or(0);
    let rows = rows.iter().map(|(_, row)| row.as_slice());
    let rows: Vec<&[f64]> =
        rows.filter(|row| row.len() == count && row.iter().all(|v| v.is_finite())).collect();
    if rows.is_empty() {
        return Vec::new();
    }
    let number = options.number.map(|number| number as f64);
    let table = Table { rows, count, frames: options.frames, number };
    let shares = table.shares();
    let (found, size) = match shares.is_empty() {
        true => (table.pixels(), options.size.map(|(width, height)| (width as f64, height as f64))),
        false => (shares, Some((1.0, 1.0))),
    };
    table.decided(in_frame(found, size))
}

/// The most common format of rows with this number of columns, if there is one.
pub(super) fn usual(count: usize) -> Option<BoxFormat> {
    match count {
        4 => Some(BoxFormat::xywh()),
        7 | 9 | 10 => Some(BoxFormat::mot()),
        0 | 1 => Some(BoxFormat::Vot),
        n if n >= 8 && n.is_multiple_of(2) => Some(BoxFormat::Vot),
        _ => None,
    }
}

/// The format with a unit: fractions of the frame if the numbers of the boxes are about 0 to 1 and not all
/// whole, else pixels.
pub(super) fn with_unit(format: BoxFormat, rows: &[Row]) -> BoxFormat {
    let BoxFormat::Columns(mut columns) = format else { return format };
    if columns.shares.is_none() {
        let rows = rows.iter().filter(|(_, row)| columns.fits(row.len()));
        let numbers: Vec<f64> = rows.flat_map(|(_, row)| columns.of_box(row)).collect();
        columns.shares = Some(are_shares(&numbers));
    }
    BoxFormat::Columns(columns)
}

/// Formats that a header may mean: in fractions of the frame, `x` and `y` may also be the center.
pub(super) fn of_header(header: &Header, rows: &[Row], size: Option<(usize, usize)>) -> Vec<BoxFormat> {
    let format = with_unit(header.format.clone(), rows);
    let BoxFormat::Columns(columns) = &format else { return vec![format] };
    if columns.shares != Some(true) || columns.position(Width).is_none() || !header.is_bare || size.is_none()
    {
        return vec![format];
    }
    let found = [columns.clone(), columns.centered()].map(|columns| {
        let rows = rows.iter().filter(|(_, row)| columns.fits(row.len()));
        let boxes = rows.map(|(_, row)| columns.rect(row)).collect();
        Found { format: BoxFormat::Columns(columns), shape: 0, is_custom: false, boxes }
    });
    in_frame(found.into(), Some((1.0, 1.0))).into_iter().map(|found| found.format).collect()
}

/// True if the numbers are fractions of the frame: about 0 to 1, and not all whole. NaN is ignored.
fn are_shares(numbers: &[f64]) -> bool {
    let mut numbers = numbers.iter().filter(|v| v.is_finite());
    numbers.clone().any(|v| v.fract() != 0.0) && numbers.all(|v| (-0.5..=1.5).contains(v))
}

/// A format that fits the rows, and its boxes.
struct Found {
    format: BoxFormat,
    /// Index into [`SHAPES`] of the columns before the box; the length of [`SHAPES`] for polygons.
    shape: usize,
    /// True if left, top, width, height is the usual format for these columns.
    is_custom: bool,
    /// Left, top, width and height of each row.
    boxes: Vec<[f64; 4]>,
}

impl Found {
    fn new(format: BoxFormat, columns: &Columns, shape: usize, is_custom: bool, rows: &[&[f64]]) -> Self {
        let rect = |row: &&[f64]| if columns.of_box(row).is_empty() { [0.0; 4] } else { columns.rect(row) };
        Self { format, shape, is_custom, boxes: rows.iter().map(rect).collect() }
    }

    /// True if no size is negative, and at least one is above `least`.
    fn has_area(&self, least: f64) -> bool {
        self.boxes.iter().all(|[.., w, h]| *w >= 0.0 && *h >= 0.0)
            && self.boxes.iter().any(|[.., w, h]| *w > least && *h > least)
    }

    /// Widths and heights of each target, row by row; rows without area are left out.
    fn sizes(&self, rows: &[&[f64]]) -> Vec<Vec<f64>> {
        let target = self.format.columns().and_then(|columns| columns.position(Target));
        let mut sizes: BTreeMap<u64, [Vec<f64>; 2]> = BTreeMap::new();
        for (row, [.., w, h]) in rows.iter().zip(&self.boxes).filter(|(_, [.., w, h])| *w > 0.0 && *h > 0.0) {
            let target = target.and_then(|k| row.get(k)).map_or(0, |id| id.to_bits());
            let [widths, heights] = sizes.entry(target).or_default();
            widths.push(*w);
            heights.push(*h);
        }
        sizes.into_values().flatten().collect()
    }
}

/// Sum of the absolute changes from each size to the next.
fn change(sizes: &[Vec<f64>]) -> f64 {
    sizes.iter().flat_map(|series| series.windows(2)).map(|pair| (pair[1] - pair[0]).abs()).sum()
}

/// Sum of the absolute differences of sizes from their median.
fn spread(sizes: &[Vec<f64>]) -> f64 {
    let of = |series: &Vec<f64>| {
        let middle = summary::median(&mut series.clone()).unwrap_or_default();
        series.iter().map(|size| (size - middle).abs()).sum::<f64>()
    };
    sizes.iter().map(of).sum()
}

/// Drops formats whose boxes reach far outside of the frame, if there are others.
fn in_frame(mut found: Vec<Found>, size: Option<(f64, f64)>) -> Vec<Found> {
    let Some((width, height)) = size else { return found };
    let is_far = |[x, y, w, h]: [f64; 4]| {
        x + w > 1.1 * width || y + h > 1.1 * height || x < -0.1 * width || y < -0.1 * height
    };
    let fits = |found: &Found| {
        let boxes: Vec<[f64; 4]> =
            found.boxes.iter().copied().filter(|[.., w, h]| *w > 0.0 && *h > 0.0).collect();
        let far = boxes.iter().filter(|b| is_far(**b)).count();
        2 * far <= boxes.len() && boxes.first().is_some_and(|b| !is_far(*b))
    };
    if found.iter().any(fits) {
        found.retain(fits);
    }
    found
}

/// Rows of finite numbers, all of the same length.
struct Table<'r> {
    rows: Vec<&'r [f64]>,
    count: usize,
    /// Number of frames, if it is known.
    frames: Option<usize>,
    /// Number of the first frame's file, if it has one.
    number: Option<f64>,
}

impl Table<'_> {
    /// Formats of boxes in fractions of the frame that fit.
    fn shares(&self) -> Vec<Found> {
        let mut found = Vec::new();
        for (shape, before) in SHAPES_OF_SHARES.into_iter().enumerate() {
            let Some(after) = self.count.checked_sub(before.len() + 4).filter(|after| *after <= 2) else {
                continue;
            };
            let (first, end) = (before.len(), before.len() + 4);
            let boxes = self.rows.iter().map(|row| &row[first..end]).filter(|numbers| **numbers != [-1.0; 4]);
            let numbers: Vec<f64> = boxes.flatten().copied().collect();
            let fits = match before {
                [] => after == 0 || !self.is_whole(0),
                [Frame] => self.is_counter(0),
                _ => self.is_whole(0) && !self.is_counter(0),
            };
            if !fits
                || !are_shares(&numbers)
                || !(end..self.count).all(|k| self.is_share(k) || self.is_whole(k))
            {
                continue;
            }
            for sides in [CENTERS, CORNERS] {
                let columns = Columns::new(self.roles(before, sides), 0, Some(true));
                let is_yolo = sides == CENTERS && (self.count == 4 || *before == [Class]);
                let format = if is_yolo { BoxFormat::Yolo } else { BoxFormat::Columns(columns.clone()) };
                let one = Found::new(format, &columns, shape, true, &self.rows);
                found.extend(Some(one).filter(|one| one.has_area(0.0)));
            }
        }
        found
    }

    /// Formats of boxes in pixels that fit.
    fn pixels(&self) -> Vec<Found> {
        let mut found = Vec::new();
        for (shape, (before, most)) in SHAPES.into_iter().enumerate() {
            let after = self.count.checked_sub(before.len() + 4).filter(|after| *after <= most);
            if after.is_none() || !self.may_begin_with(before) || !self.may_end_after(before) {
                continue;
            }
            let is_mot = before == [Frame, Target];
            for sides in [SIDES, CORNERS] {
                let columns = Columns::new(self.roles(before, sides), 0, Some(false));
                let format = match is_mot && sides == SIDES {
                    true => BoxFormat::mot(),
                    false => BoxFormat::Columns(columns.clone()),
                };
                let is_custom = self.count == 4 || (is_mot && self.count >= 7);
                let one = Found::new(format, &columns, shape, is_custom, &self.rows);
                found.extend(Some(one).filter(|one| one.has_area(1.0)));
            }
        }
        // A column of targets is not one of left edges.
        if self.count == 7 && found.iter().any(|one| one.is_custom) {
            found.retain(|one| one.is_custom || SHAPES[one.shape].0 != [Frame]);
        }
        let is_even = self.count >= 8 && self.count.is_multiple_of(2);
        if is_even && !self.is_counter(0) && (self.count == 8 || found.is_empty()) {
            found.extend(self.polygons());
        }
        found
    }

    /// Polygons, if they fit all rows.
    fn polygons(&self) -> Option<Found> {
        let bounds = |row: &&[f64]| match Region::from_numbers(row) {
            Ok(region) => {
                let Rect { x, y, w, h } = region.bounds();
                Some([x, y, w, h])
            }
            Err(RegionError::Empty) => Some([0.0; 4]),
            Err(_) => None,
        };
        let boxes: Vec<[f64; 4]> = self.rows.iter().map(bounds).collect::<Option<_>>()?;
        let found = Found { format: BoxFormat::Vot, shape: SHAPES.len(), is_custom: false, boxes };
        Some(found).filter(|found| found.has_area(0.0))
    }

    /// Formats that are left after the choice between the two kinds of boxes, where both fit with the same
    /// columns before them.
    fn decided(&self, found: Vec<Found>) -> Vec<BoxFormat> {
        let mut left = Vec::new();
        for pair in found.chunk_by(|a, b| a.shape == b.shape) {
            let [usual, corners] = pair else {
                left.extend(pair.iter().map(|one| one.format.clone()));
                continue;
            };
            let sizes = [usual, corners].map(|one| one.sizes(&self.rows));
            let [(by_custom, spread_by_custom), (of_corners, spread_of_corners)] =
                sizes.map(|sizes| (change(&sizes), spread(&sizes)));
            let is_out = match usual.is_custom {
                true => {
                    let is_alike =
                        of_corners >= MUCH * by_custom && spread_of_corners >= MUCH * spread_by_custom;
                    [false, is_alike]
                }
                false => [4.0 * of_corners < by_custom, 4.0 * by_custom < of_corners],
            };
            left.extend(pair.iter().zip(is_out).filter(|(_, out)| !out).map(|(one, _)| one.format.clone()));
        }
        left
    }

    /// Roles of all columns: those before the box, those of the box, and those after it as their numbers
    /// suggest.
    fn roles(&self, before: &[Role], sides: [Role; 4]) -> Vec<Role> {
        let first = before.len() + sides.len();
        let after = || first..self.count;
        let confidence = after().find(|k| self.is_share(*k) && !self.is_whole(*k));
        let confidence = confidence.or_else(|| after().find(|k| self.is_share(*k)));
        let class = after().find(|k| Some(*k) != confidence && self.is_whole(*k));
        let role = |k: usize| match Some(k) {
            k if k == confidence => Confidence,
            k if k == class => Class,
            _ => Other,
        };
        before.iter().copied().chain(sides).chain(after().map(role)).collect()
    }

    fn may_begin_with(&self, before: &[Role]) -> bool {
        match before {
            [] => self.count == 4 || !self.is_counter(0),
            [Frame] => self.may_be_frames(0) && self.rises(0),
            [Frame, Target] => self.may_be_frames(0) && self.is_whole(1) && self.names_targets(),
            [Class, more @ ..] => {
                let is_class = self.is_whole(0) && self.distinct(0) <= 3 && self.column(0).all(|v| v >= 0.0);
                let rises = self.rows.len() > 1 && self.rises(0);
                is_class && !rises && (more.is_empty() || self.is_share(1))
            }
            _ => false,
        }
    }

    fn may_end_after(&self, before: &[Role]) -> bool {
        let first = before.len() + 4;
        match (before, self.count - first) {
            ([Frame, Target], _) | (_, 0) => true,
            ([Class, ..], _) => self.is_share(first),
            (_, 1) => self.is_share(first) || (self.is_whole(first) && self.distinct(first) == 1),
            _ => {
                let rest = (first..self.count).all(|k| self.is_share(k) || self.is_whole(k));
                rest && (self.is_share(first) || self.is_share(first + 1))
            }
        }
    }

    fn column(&self, k: usize) -> impl Iterator<Item = f64> {
        self.rows.iter().map(move |row| row[k])
    }

    fn is_whole(&self, k: usize) -> bool {
        self.column(k).all(|v| v.fract() == 0.0 && v.abs() < 1e9)
    }

    /// True if the column may be a confidence.
    fn is_share(&self, k: usize) -> bool {
        self.column(k).all(|v| (0.0..=1.0).contains(&v)) || self.column(k).all(|v| v == -1.0)
    }

    fn distinct(&self, k: usize) -> usize {
        self.column(k).map(f64::to_bits).collect::<BTreeSet<_>>().len()
    }

    fn rises(&self, k: usize) -> bool {
        self.column(k).zip(self.column(k).skip(1)).all(|(a, b)| a < b)
    }

    /// True if the column counts rows from 0 or 1 or the number of the first frame's file, perhaps with gaps.
    fn is_counter(&self, k: usize) -> bool {
        let span = self.column(k).last().unwrap_or(0.0) - self.rows[0][k];
        let steps = self.rows.len() - 1;
        let starts = [Some(0.0), Some(1.0), self.number].contains(&Some(self.rows[0][k]));
        steps > 1 && starts && self.is_whole(k) && self.rises(k) && span < 2.0 * steps as f64
    }

    fn may_be_frames(&self, k: usize) -> bool {
        let least = self.column(k).fold(f64::INFINITY, f64::min);
        let most = self.column(k).fold(0.0, f64::max);
        // From 0, from 1, or as the frames' files are numbered.
        let first = self.number.filter(|number| least >= *number).unwrap_or(least.min(1.0));
        self.is_whole(k) && least >= 0.0 && self.frames.is_none_or(|frames| most < frames as f64 + first)
    }

    /// True if the second column may be the target, with the first one as the frame: no target is twice in a
    /// frame, and some frame has several.
    fn names_targets(&self) -> bool {
        let rows: BTreeSet<_> = self.rows.iter().map(|row| (row[0].to_bits(), row[1].to_bits())).collect();
        let is_short = self.distinct(0) == 1;
        rows.len() == self.rows.len() && (is_short || self.distinct(1) < self.rows.len())
    }
}
