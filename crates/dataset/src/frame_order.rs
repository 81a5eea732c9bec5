//! The order and the numbers of frame files, from the numbers in their names.
//!
//! Names are ordered as people do it: text as text, and every run of digits as a number, from left to right,
//! so that `img2_b` comes before `img10_a`. This number of a name counts the frames:
//!
//! | names | the number of a frame |
//! |---|---|
//! | one number differs (`0001`, `img (12)`, `DJI_1000(12)`) | that one |
//! | several differ, and those of the last follow each other in this order (`take1_0007`) | the last |
//! | several differ, and the first differs in all (`clip-12_jpg.rf.` and a hash) | the first, unless the last may as well be meant |
//! | several differ, as parts of a date, a time of day, seconds since 1970, or a decimal number | from 1 on |
//! | none has a number | from 1 on |
//!
//! A number that does not end the names counts from 1 for the first file. Files that are alike in that number, a file
//! without a number among others that have one, and names of which the last numbers give another order are errors.

use crate::DatasetError;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Number of file names that a message shows of an order.
const SHOWN: usize = 3;

/// Number in a name: its count of digits without leading zeros, and these digits. So tuples are ordered by
/// value.
type Value<'n> = (usize, &'n str);

/// File name split into text, run of digits, text, and so on. The first and the last text may be empty.
struct Name {
    path: PathBuf,
    texts: Vec<String>,
    runs: Vec<String>,
}

impl Name {
    /// Splits the whole path, or only its last part without the extension.
    fn new(path: PathBuf, whole: bool) -> Self {
        let stem = if whole { path.with_extension("") } else { path.file_stem().unwrap_or_default().into() };
        let stem = stem.to_string_lossy();
        let runs = stem.split(|c: char| !c.is_ascii_digit()).filter(|run| !run.is_empty());
        let runs: Vec<String> = runs.map(String::from).collect();
        let (mut texts, mut rest) = (Vec::new(), &*stem);
        for run in &runs {
            let (text, after) = rest.split_once(run.as_str()).unwrap_or_default();
            texts.push(text.to_string());
            rest = after;
        }
        texts.push(rest.to_string());
        Self { path, texts, runs }
    }

    /// The name with times of day from 0 to 23 hours in place of `12.59.58 PM`, as macOS names screenshots.
    fn on_24_hours(mut self) -> Self {
        for k in (0..self.runs.len()).filter(|k| is_time_of_day(&self, *k)).collect::<Vec<_>>() {
            let after = self.texts[k + 3].trim_start();
            let (half, rest) = after.split_at_checked(2).unwrap_or_default();
            let noon = ["am", "pm"].iter().position(|word| half.eq_ignore_ascii_case(word));
            let hour = self.runs[k].parse().ok().filter(|hour: &usize| (1..=12).contains(hour));
            if let (Some(noon), Some(hour)) = (noon, hour)
                && !rest.starts_with(char::is_alphanumeric)
            {
                // Seconds stay within the name: they do not number the frames.
                self.texts[k + 3] = format!(" {rest}");
                self.runs[k] = (hour % 12 + 12 * noon).to_string();
            }
        }
        self
    }

    /// Digits of a run; empty after the last run.
    fn digits(&self, run: usize) -> &str {
        self.runs.get(run).map_or("", String::as_str)
    }

    fn value(&self, run: usize) -> Option<Value<'_>> {
        let digits = self.runs.get(run)?.trim_start_matches('0');
        Some((digits.len(), digits))
    }

    fn last(&self) -> Option<Value<'_>> {
        self.value(self.runs.len().checked_sub(1)?)
    }

    fn ends_with_number(&self) -> bool {
        self.texts.last().is_some_and(String::is_empty)
    }

    /// True if the run stands after the point of a decimal number.
    fn is_fraction(&self, run: usize) -> bool {
        let point = |text: usize| self.texts.get(text).is_some_and(|text| text == ".");
        run > 0 && run < self.runs.len() && point(run) && !point(run - 1) && !point(run + 1)
    }
}

/// First names of a longer list, for messages.
pub(crate) fn shown<'p>(paths: impl Iterator<Item = &'p Path>) -> String {
    paths.map(|path| file_name(path) + ", ").collect::<String>() + "..."
}

/// Last part of a path, for messages.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Sorts files by all the numbers in their names.
pub(crate) fn natural_order(paths: Vec<PathBuf>) -> Vec<PathBuf> {
    named(paths).into_iter().map(|name| name.path).collect()
}

/// Files by frame number; the table of this module tells which number that is.
///
/// # Errors
/// Two files with one number, a file without a number, and [`DatasetError::FrameOrder`].
pub(crate) fn numbered(paths: Vec<PathBuf>) -> Result<BTreeMap<u32, PathBuf>, DatasetError> {
    let names = named(paths);
    let numbers = numbers(&names)?;
    Ok(numbers.into_iter().zip(names).map(|(number, name)| (number, name.path)).collect())
}

/// Names of the files in natural order. Folders are part of the name if there are several.
fn named(paths: Vec<PathBuf>) -> Vec<Name> {
    let whole = paths.windows(2).any(|pair| pair[0].parent() != pair[1].parent());
    let mut names: Vec<Name> = paths.into_iter().map(|path| Name::new(path, whole).on_24_hours()).collect();
    names.sort_by(|a, b| compare(a, b, false).then_with(|| a.path.cmp(&b.path)));
    names
}

/// Compares names part by part, texts and numbers in turn. A name that is the start of another comes first. In
/// names that differ in numbers alone, digits after a decimal point may be taken as fractions.
fn compare(a: &Name, b: &Name, has_fractions: bool) -> Ordering {
    let number = |k: usize| match has_fractions && a.is_fraction(k) {
        // Without zeros at their ends.
        true => a.digits(k).trim_end_matches('0').cmp(b.digits(k).trim_end_matches('0')),
        false => a.value(k).cmp(&b.value(k)),
    };
    let part = |k: usize| a.texts.get(k).cmp(&b.texts.get(k)).then_with(|| number(k));
    (0..a.texts.len().max(b.texts.len())).map(part).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
}

/// Frame numbers of the names, which are in natural order.
fn numbers(names: &[Name]) -> Result<Vec<u32>, DatasetError> {
    let from_one = || (1..=names.len() as u32).collect();
    if let [one] = names {
        let own = one.last().filter(|_| one.ends_with_number());
        return Ok(vec![own.and_then(whole).unwrap_or(1)]);
    }
    let Some(example) = names.iter().find(|name| !name.runs.is_empty()) else { return Ok(from_one()) };
    if let Some(other) = names.iter().find(|name| name.runs.is_empty()) {
        let message = format!(
            "no number in this name, but in those of other images, such as {}; move the file away, or give it the \
             number of its frame (`detect` also takes a pattern that fits the others alone)",
            file_name(&example.path)
        );
        return Err(DatasetError::content(&other.path, message));
    }
    let last: Vec<Value<'_>> = names.iter().filter_map(Name::last).collect();
    let twice = |pair: &&[Name]| compare(&pair[0], &pair[1], false).is_eq();
    if let Some(pair) = names.windows(2).find(twice) {
        return Err(again(&pair[0], &pair[1], pair[1].last()));
    }
    let at_end = names.iter().all(Name::ends_with_number);
    let ascends = rises(&last);
    if ascends && follow(&last) {
        return Ok(counted(&last, at_end));
    }
    let alike = names.iter().all(|name| name.texts == example.texts);
    let varying = first_that_varies(names);
    if alike
        && let Some(run) = varying
        && counts_down(names, run)?
    {
        return Ok(from_one());
    }
    let mut by_last: Vec<(Value<'_>, &Name)> = last.iter().copied().zip(names).collect();
    by_last.sort_by_key(|(value, _)| *value);
    let sorted: Vec<Value<'_>> = by_last.iter().map(|(value, _)| *value).collect();
    if let Some(run) = varying {
        let lead: Vec<Value<'_>> = names.iter().filter_map(|name| name.value(run)).collect();
        let leads = !alike || ascends || !rises(&sorted) || follow(&lead) && !follow(&sorted);
        if rises(&lead) && leads {
            return Ok(counted(&lead, at_end && names.iter().all(|name| name.runs.len() == run + 1)));
        }
        if !alike && let Some(pair) = names.windows(2).find(|pair| pair[0].value(run) == pair[1].value(run)) {
            return Err(again(&pair[0], &pair[1], pair[1].value(run)));
        }
    }
    if let Some(pair) = by_last.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(again(pair[0].1, pair[1].1, Some(pair[1].0)));
    }
    if alike && ascends {
        return Ok(counted(&last, at_end));
    }
    let by_last: Vec<&Name> = by_last.into_iter().map(|(_, name)| name).collect();
    Err(doubt(names, &by_last, "the last number alone"))
}

/// True if every value is larger than the one before.
fn rises(values: &[Value<'_>]) -> bool {
    values.windows(2).all(|pair| pair[0] < pair[1])
}

fn whole(value: Value<'_>) -> Option<u32> {
    if value.0 == 0 { Some(0) } else { value.1.parse().ok() }
}

/// True if every value is larger by 1 than the one before.
fn follow(values: &[Value<'_>]) -> bool {
    let numbers: Option<Vec<u32>> = values.iter().copied().map(whole).collect();
    numbers.is_some_and(|numbers| numbers.windows(2).all(|pair| pair[0].checked_add(1) == Some(pair[1])))
}

/// Frame numbers of rising values: the values themselves if they end the names, else counted from 1 for the
/// first. Values that are too large for a number are times; only their order is used.
fn counted(values: &[Value<'_>], at_end: bool) -> Vec<u32> {
    let own: Option<Vec<u32>> = values.iter().copied().map(whole).collect();
    let mut numbers = own.unwrap_or_else(|| (1..=values.len() as u32).collect());
    if let Some(first) = numbers.first().copied().filter(|_| !at_end) {
        numbers.iter_mut().for_each(|number| *number = (*number - first).saturating_add(1));
    }
    numbers
}

/// First run whose number differs among the names, provided that all text before it is the same.
fn first_that_varies(names: &[Name]) -> Option<usize> {
    let (first, rest) = names.split_first()?;
    let same_before = |run: &usize| {
        rest.iter().all(|name| name.texts.get(*run) == first.texts.get(*run) && name.runs.len() > *run)
    };
    let varies = |run: &usize| rest.iter().any(|name| name.value(*run) != first.value(*run));
    (0..first.runs.len()).take_while(same_before).find(varies)
}

/// True if the numbers from `run` on, where the names first differ, are one quantity in parts: a date, a time
/// or a decimal number. Each part counts within the one before it. The names differ in numbers alone.
///
/// # Errors
/// [`DatasetError::FrameOrder`] if fractions of different lengths would have another order as whole numbers.
fn counts_down(names: &[Name], run: usize) -> Result<bool, DatasetError> {
    let mut by_decimal: Vec<&Name> = names.iter().collect();
    by_decimal.sort_by(|a, b| compare(a, b, true));
    if by_decimal.iter().zip(names).any(|(a, b)| a.path != b.path) {
        return Err(doubt(names, &by_decimal, "decimal numbers"));
    }
    let Some(first) = names.first() else { return Ok(false) };
    let more = |k: usize| names.iter().any(|name| name.value(k) != first.value(k));
    if !(run + 1..first.runs.len()).any(more) {
        return Ok(false);
    }
    if let Some(night) = night(names, run) {
        let past_midnight: Vec<&Name> = names[night..].iter().chain(&names[..night]).collect();
        return Err(doubt(names, &past_midnight, "the clock past midnight"));
    }
    let covers = |start: usize| names.iter().all(|name| start + stamp_length(name, start) > run);
    Ok(first.is_fraction(run + 1) || (0..=run).any(covers))
}

/// True if the text has that many digits and its number is in the range.
fn is_number(digits: &str, count: RangeInclusive<usize>, range: RangeInclusive<u32>) -> bool {
    count.contains(&digits.len()) && digits.parse().is_ok_and(|value: u32| range.contains(&value))
}

/// True if the runs from `start` on are hours, minutes and seconds.
fn is_time_of_day(name: &Name, start: usize) -> bool {
    let is = |k: usize, last: u32| is_number(name.digits(start + k), 1..=2, 0..=last);
    let separator = |k: usize| name.texts.get(start + k).filter(|text| text.chars().count() == 1);
    is(0, 23) && is(1, 59) && is(2, 60) && separator(1).is_some() && separator(1) == separator(2)
}

/// First file after a gap of more than 12 hours, if the names have a time of day and no date. The files after
/// the gap may be those of the evening before.
fn night(names: &[Name], run: usize) -> Option<usize> {
    let first = names.first()?;
    let hour = (0..=run).find(|k| names.iter().all(|name| is_time_of_day(name, *k)))?;
    let has_date = (0..hour).any(|k| stamp_length(first, k) > 0);
    let hours: Vec<u32> = names.iter().filter_map(|name| whole(name.value(hour)?)).collect();
    let gap = hours.windows(2).position(|pair| pair[1].saturating_sub(pair[0]) > 12);
    gap.map(|before| before + 1).filter(|_| !has_date)
}

/// Number of runs from `start` on that form a date, a time of day, or seconds since 1970 with a fraction; 0
/// for anything else.
fn stamp_length(name: &Name, start: usize) -> usize {
    let digits = |k: usize| name.digits(start + k);
    let is_date = |year: &str, month: &str, day: &str| {
        is_number(year, 4..=4, 1900..=2099)
            && is_number(month, 1..=2, 1..=12)
            && is_number(day, 1..=2, 1..=31)
    };
    let time_after = |date: usize| date + usize::from(digits(date).len() == 6);
    let first = digits(0);
    if is_date(first, digits(1), digits(2)) {
        time_after(3)
    } else if matches!(first.len(), 8 | 14) && is_date(&first[..4], &first[4..6], &first[6..8]) {
        time_after(1)
    } else if is_time_of_day(name, start) {
        3
    } else if first.len() == 10 && first.starts_with('1') {
        2
    } else {
        0
    }
}

/// Error for two files with the same number.
fn again(other: &Name, name: &Name, value: Option<Value<'_>>) -> DatasetError {
    let number = value.map_or("0", |(_, digits)| if digits.is_empty() { "0" } else { digits });
    let message = format!("frame {number} again, after {}; keep one file a frame", file_name(&other.path));
    DatasetError::content(&name.path, message)
}

/// Error for names that can be put in two orders, or that are of several kinds.
fn doubt(names: &[Name], other: &[&Name], how: &str) -> DatasetError {
    let differs = names.iter().zip(other).position(|(a, b)| a.path != b.path);
    let from = differs.unwrap_or_default();
    let of_names = shown(names.iter().skip(from).take(SHOWN).map(|name| &*name.path));
    let of_other = shown(other.iter().skip(from).take(SHOWN).map(|name| &*name.path));
    let message = match differs {
        Some(_) => format!(
            "from frame {} on it is {of_names} by all numbers in the names, but {of_other} by {how}",
            from + 1
        ),
        None => format!(
            "the names are of several kinds, and their last numbers do not follow each other: {of_names}"
        ),
    };
    let folder = names.first().and_then(|name| name.path.parent()).filter(|path| *path != Path::new(""));
    DatasetError::FrameOrder { folder: folder.unwrap_or(Path::new(".")).into(), message }
}

#[cfg(test)]
mod tests;
