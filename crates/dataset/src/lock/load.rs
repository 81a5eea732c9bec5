//! From an entry and a data root to a sequence.

use super::entry::words;
use super::text::Pinned;
use super::{Entry, Format, Missing};
use crate::files::{image_folder, numbered_images};
use crate::{DatasetError, Sequence, cvml, got10k, lasot, otb, sorted, video, vot};
use std::path::{Path, PathBuf};

impl Pinned {
    /// Outer result: readable or not; inner: there or not.
    pub(super) fn load(
        &self,
        entry: &Entry,
        data_root: Option<&Path>,
    ) -> Result<Result<Sequence, Missing>, DatasetError> {
        let loaded = self.load_unchecked(entry, data_root)?;
        if let (Ok(s), Some(root), Some(frames)) = (&loaded, data_root, entry.frames)
            && s.len() != frames
        {
            let message = format!("{} frames, pinned are {frames}; fetch it again", s.len());
            return Err(DatasetError::content(&entry.path(root), message));
        }
        // Some layouts have no way to take a part of a sequence.
        if let (Ok(s), Some(root), Some((first, last))) = (&loaded, data_root, entry.range) {
            let (from, to) = (s.number(0), s.number(s.len().saturating_sub(1)));
            if (from, to) != (first, last) {
                let message = format!("frames {from} to {to}, pinned are {first} to {last}");
                return Err(DatasetError::content(&entry.path(root), message));
            }
        }
        Ok(loaded)
    }

    /// The entry with the facts of what is under the data root: ranges, number of frames, size, digest.
    pub(super) fn facts(
        &self,
        entry: &Entry,
        data_root: Option<&Path>,
    ) -> Result<Result<Entry, Missing>, DatasetError> {
        let s = match self.load_unchecked(entry, data_root)? {
            Ok(sequence) => sequence,
            Err(missing) => return Ok(Err(missing)),
        };
        let last = s.number(s.len().saturating_sub(1));
        Ok(Ok(Entry {
            range: Some((s.numbering.first, last)),
            official: Some(s.numbering.official),
            frames: Some(s.len()),
            size: Some(s.size()?),
            digest: Some(s.digest()?.to_owned()),
            ..entry.clone()
        }))
    }

    /// Layout of the entry's folder.
    pub(super) fn format(&self, entry: &Entry) -> Format {
        entry.format.unwrap_or(self.format)
    }

    /// As [`Pinned::load`], whatever the number of frames.
    pub(super) fn load_unchecked(
        &self,
        entry: &Entry,
        data_root: Option<&Path>,
    ) -> Result<Result<Sequence, Missing>, DatasetError> {
        let missing = |hint: &str| {
            let (name, folder) = (entry.name.clone(), entry.folder.clone());
            Ok(Err(Missing { name, folder, how_to_get: format!("{hint}{}", self.how_to_get) }))
        };
        let Some(root) = data_root else {
            return missing("no data root given (--data-root or TRACKFAIL_DATA); ");
        };
        let folder = entry.path(root);
        if !folder.is_dir() {
            return missing("");
        }
        if self.format(entry) == Format::Cvml
            && let Some(part) = cvml::absent(&folder)?
        {
            return missing(&format!("no {part} in {}; ", entry.folder));
        }
        if let Some((first, last)) = self.cut_off(entry, &folder)? {
            return missing(&format!("frames {first} to {last} are not in {}; ", entry.folder));
        }
        let mut sequence = match self.format(entry) {
            Format::Vot => vot::load(&folder, Some(&entry.name))?,
            Format::Got10k => got10k::load(&folder, Some(&entry.name))?,
            Format::Lasot => lasot::load(&folder, Some(&entry.name))?,
            Format::Otb => {
                let options = otb::Options {
                    name: Some(entry.name.clone()),
                    target: entry.target,
                    range: entry.range,
                    official: entry.official,
                    truth: otb::Truth::Required,
                };
                otb::load(&folder, &options)?
            }
            Format::Cvml => {
                let options = cvml::Options {
                    name: Some(entry.name.clone()),
                    target: entry.target,
                    range: entry.range,
                    official: entry.official,
                    decoded: video::cache(root),
                };
                cvml::load(&folder, &options)?
            }
        };
        let words = words(&entry.attributes, entry.target_type);
        sequence.attributes = sorted(std::mem::take(&mut sequence.attributes).into_iter().chain(words));
        Ok(Ok(sequence))
    }

    /// First and last of the frames an entry needs that are absent, where they are its last ones.
    fn cut_off(&self, entry: &Entry, folder: &Path) -> Result<Option<(u32, u32)>, DatasetError> {
        let Some((first, last)) = entry.range else { return Ok(None) };
        let images = self.format(entry).image_folder(folder);
        let cuttable = match self.format(entry) {
            Format::Vot | Format::Got10k | Format::Lasot => false,
            Format::Otb => true,
            Format::Cvml => !cvml::is_video(folder)?,
        };
        if !cuttable {
            return Ok(None);
        }
        let images = numbered_images(&images)?;
        let absent = (first..=last).find(|n| !images.contains_key(n));
        Ok(absent.filter(|&n| images.range(n..=last).next().is_none()).map(|n| (n, last)))
    }
}

impl Format {
    /// Where a sequence's images are.
    pub(super) fn image_folder(self, folder: &Path) -> PathBuf {
        match self {
            Self::Vot | Self::Got10k => folder.to_path_buf(),
            Self::Otb | Self::Lasot => image_folder(folder, &["img"]),
            Self::Cvml => image_folder(folder, &cvml::IMAGE_FOLDERS),
        }
    }
}
