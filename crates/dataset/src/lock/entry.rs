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

/// One line of a suite: a sequence, and what a local copy must be like. The default entry stands for
/// everything in a folder.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Name, unique in the suite. Empty means the name of the folder.
    pub name: String,
    /// Folder or file under the data root, parts separated by `/`. Empty means the root itself.
    pub folder: String,
    /// Format of the folder; `None` for that of the suite.
    pub format: Option<&'static FormatEntry>,
    /// Target in a folder with several: OTB counts from 1, CVML uses the object's id.
    pub target: Option<u32>,
    /// First and last frame used, in the dataset's numbers; `None` for all frames of the folder.
    pub range: Option<(u32, u32)>,
    /// First and last frame of the dataset's own range; `None` for the frames that the ground truth covers.
    pub official: Option<(u32, u32)>,
    /// Number of frames used; `None` if unknown.
    pub frames: Option<usize>,
    /// Width and height in pixels; `None` until a copy has been read.
    pub size: Option<(usize, usize)>,
    /// Name of the underlying video, if it is not that of the sequence. See [`Entry::video`].
    pub video: Option<String>,
    /// Type of the target; `None` if unknown.
    pub target_type: Option<TargetType>,
    /// Codes of OTB attributes, such as `OCC`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attributes: Vec<String>,
    /// Files digest; `None` until a copy has been read.
    pub digest: Option<String>,
    /// Name of the [`Archive`] that contains the sequence; `None` if no address is known.
    pub archive: Option<String>,
    /// Name of the [`Archive`] that contains the ground truth, if it is not that of the frames.
    pub truth_archive: Option<String>,
}

impl Entry {
    /// Name of the underlying video: the name of the sequence, or of its folder if that has several targets,
    /// unless the entry gives another.
    pub fn video(&self) -> &str {
        let folder = self.target.and_then(|_| self.folder.rsplit('/').next());
        self.video.as_deref().or(folder).unwrap_or(&self.name)
    }

    /// Source of the video: the first folder below the data root.
    pub fn source(&self) -> &str {
        self.folder.split('/').next().unwrap_or_default()
    }

    /// Archives that contain the sequence; empty if no address is known.
    pub fn archives(&self) -> impl Iterator<Item = &'static Archive> {
        let names = [&self.archive, &self.truth_archive].into_iter().flatten();
        names.filter_map(|name| super::archives().iter().find(|archive| archive.name == *name))
    }

    /// Path of the sequence's folder or file under `root`.
    pub(crate) fn path(&self, root: &Path) -> PathBuf {
        below(root, &self.folder)
    }

    /// The entry as a line of its suite file.
    pub fn line(&self) -> String {
        let mut line = String::new();
        self.serialize(toml::ser::ValueSerializer::new(&mut line)).expect("an entry has texts and numbers");
        line + ","
    }
}

/// Attributes of a sequence: the OTB codes spelled out, and the type of the target.
pub(crate) fn attribute_words(
    codes: &[String],
    target_type: Option<TargetType>,
) -> impl Iterator<Item = String> {
    let target = target_type.map(|word| format!("target-{word:?}").to_lowercase());
    codes.iter().map(|code| attribute_word(code).to_owned()).chain(target)
}

/// Path of `folder`, with parts separated by `/`, under `root`.
pub(crate) fn below(root: &Path, folder: &str) -> PathBuf {
    folder.split('/').filter(|part| !part.is_empty()).fold(root.to_path_buf(), |path, part| path.join(part))
}

/// Spells out a code of an OTB attribute (Wu et al., PAMI 2015, Table 2). Other words are returned unchanged.
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
