//! One sequence of a suite: a line of its file.

use crate::archive::Archive;
use crate::format::FormatEntry;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Type of a target, for tables by type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TargetType {
    /// A car.
    Car,
    /// A whole person.
    Person,
    /// A face or head.
    Face,
    /// Anything else.
    Other,
}

/// One line of a suite: a sequence and what a local copy must be. The default one is all that is in a folder.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Name, unique in the suite; if it is empty, that of the folder.
    pub name: String,
    /// Folder or file under the data root, parts separated by `/`; if it is empty, the root itself.
    pub folder: String,
    /// Format of the folder where it is not the suite's.
    pub format: Option<&'static FormatEntry>,
    /// Which target of a folder with several: OTB counts from 1, CVML uses the object's id.
    pub target: Option<u32>,
    /// First and last frame used, in the dataset's numbers; without it, all frames of the folder.
    pub range: Option<(u32, u32)>,
    /// First and last frame of the dataset's own range; without it, the frames that the ground truth covers.
    pub official: Option<(u32, u32)>,
    /// Number of frames used, if known.
    pub frames: Option<usize>,
    /// Width and height in pixels, if a copy has been read.
    pub size: Option<(usize, usize)>,
    /// The video that it is of, where another source has it under another name; see [`Entry::video`].
    pub video: Option<String>,
    /// Type of the target, if known.
    pub target_type: Option<TargetType>,
    /// Codes of OTB attributes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attributes: Vec<String>,
    /// Files digest, if a copy has been read.
    pub digest: Option<String>,
    /// Name of the [`Archive`] it comes in, if its address is known.
    pub archive: Option<String>,
    /// Name of the [`Archive`] its ground truth comes in, if that is another.
    pub truth_archive: Option<String>,
}

impl Entry {
    /// The video that it is of: its name, unless another one is given.
    pub fn video(&self) -> &str {
        self.video.as_deref().unwrap_or(&self.name)
    }

    /// The source of videos that it comes from: the first folder below the data root.
    pub fn source(&self) -> &str {
        self.folder.split('/').next().unwrap_or_default()
    }

    /// The archives it comes in; none if no address is known.
    pub fn archives(&self) -> impl Iterator<Item = &'static Archive> {
        let names = [&self.archive, &self.truth_archive].into_iter().flatten();
        names.filter_map(|name| super::archives().iter().find(|archive| archive.name == *name))
    }

    /// The sequence's folder or file under `root`.
    pub(crate) fn path(&self, root: &Path) -> PathBuf {
        below(root, &self.folder)
    }

    /// The entry's line in the file of its suite.
    pub fn line(&self) -> String {
        let mut line = String::new();
        self.serialize(toml::ser::ValueSerializer::new(&mut line)).expect("an entry has texts and numbers");
        line + ","
    }
}

/// The attributes of a sequence: OTB's codes spelled out, and the type of the target.
pub(crate) fn attribute_words(
    codes: &[String],
    target_type: Option<TargetType>,
) -> impl Iterator<Item = String> {
    let target = target_type.map(|word| format!("target-{word:?}").to_lowercase());
    codes.iter().map(|code| attribute_word(code).to_owned()).chain(target)
}

/// A folder whose parts are separated by `/`, under `root`.
pub(crate) fn below(root: &Path, folder: &str) -> PathBuf {
    folder.split('/').filter(|part| !part.is_empty()).fold(root.to_path_buf(), |path, part| path.join(part))
}

/// An OTB attribute spelled out (Wu et al., PAMI 2015, Table 2); other words stay as they are.
pub fn attribute_word(code: &str) -> &str {
    match code {
        "IV" => "illumination-variation",
        "SV" => "scale-variation",
        "OCC" => "occlusion",
        "DEF" => "deformation",
        "MB" => "motion-blur",
        "FM" => "fast-motion",
        "IPR" => "in-plane-rotation",
        "OPR" => "out-of-plane-rotation",
        "OV" => "out-of-view",
        "BC" => "background-clutter",
        "LR" => "low-resolution",
        other => other,
    }
}
