//! Pinned facts: the suites of published sequences, and the archives that contain these.
//!
//! The facts are in the TOML files of `datasets/`, which are built into the program; its `README.md` describes them. A fact
//! that no source states is left out: an entry without `range` takes all frames of its folder. Parsing all files takes
//! longer than most commands take for everything else, and a run needs one or two suites, so a file is parsed when its
//! suite is first asked for.
//!
//! OTB attributes are kept in the file by their published codes and given to sequences spelled out
//! (`occlusion`, `scale-variation` ...), with the type of the target beside them (`target-car`,
//! `target-person`, `target-face`, `target-other`). The attributes of VOT, GOT-10k and LaSOT sequences are the
//! names of their labels.

use crate::archive::Archive;
use crate::format::FormatEntry;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, OnceLock};

macro_rules! suites {
    ($($name:literal)*) => {
        &[$(($name, include_str!(concat!("../../../datasets/", $name, ".toml")))),*]
    };
}

/// Names of the built-in suites in order, each with the text of its file.
pub const SUITES: &[(&str, &str)] = suites!(
    "otb-dtef20" "otb-2013" "otb-100" "longterm" "otb-100-boxes" "vot2013" "vot2014" "otb-vot"
    "uav123-10fps" "tlp" "otb-vot-uav-tlp" "vot2015" "vot2016" "pets2009-s2l1" "pets2009-s2l1-160" "caviar"
    "clemson-heads" "d1-real"
);

/// A suite whose sequences are on disk.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PinnedSuite {
    /// Name, unique among all suites.
    pub name: String,
    /// Title: one line about the suite.
    pub title: String,
    /// Format of the folders, unless an entry gives another one.
    pub format: &'static FormatEntry,
    /// Address and paper of the data.
    pub source: String,
    /// Licence, as far as it is known.
    pub licence: String,
    /// How to get a missing sequence.
    pub how_to_get: String,
    /// Names of built-in suites whose sequences come before the suite's own.
    #[serde(default, skip_serializing)]
    pub includes: Vec<String>,
    /// Sequences of the suite in order; one line each in the file.
    #[serde(default, skip_serializing)]
    pub sequence: Vec<Entry>,
}

impl PinnedSuite {
    /// Adds the sequences of the included suites. An unknown name is returned as the error.
    pub fn complete(mut self) -> Result<Self, String> {
        let mut all = Vec::new();
        for name in &self.includes {
            let other =
                pinned_suite(name).filter(|other| other.name != self.name).ok_or_else(|| name.clone())?;
            let format = |entry: &Entry| Some(other.format(entry)).filter(|format| *format != self.format);
            let of = |entry: &Entry| Entry { format: format(entry), ..entry.clone() };
            all.extend(other.sequence.iter().map(of));
        }
        all.append(&mut self.sequence);
        self.sequence = all;
        Ok(self)
    }

    /// Format of the entry's folder.
    pub fn format(&self, entry: &Entry) -> &'static FormatEntry {
        entry.format.unwrap_or(self.format)
    }
}

/// Names of the built-in suites on disk, in order.
pub(crate) fn pinned_suite_names() -> impl Iterator<Item = &'static str> {
    SUITES.iter().map(|(name, _)| *name)
}

/// Built-in suites on disk, in order. Each file is parsed at its first use.
pub(crate) fn pinned_suites() -> impl Iterator<Item = &'static Arc<PinnedSuite>> {
    pinned_suite_names().filter_map(pinned_suite)
}

/// Returns the built-in suite called `name`.
pub(crate) fn pinned_suite(name: &str) -> Option<&'static Arc<PinnedSuite>> {
    static PARSED: [OnceLock<Arc<PinnedSuite>>; SUITES.len()] = [const { OnceLock::new() }; SUITES.len()];
    let (place, (_, text)) = SUITES.iter().enumerate().find(|(_, (known, _))| *known == name)?;
    Some(PARSED[place].get_or_init(|| {
        let suite: PinnedSuite = toml::from_str(text).expect("datasets/ is part of the program");
        Arc::new(suite.complete().expect("datasets/ is part of the program"))
    }))
}

/// All archives, in the order of the file.
pub fn archives() -> &'static [Archive] {
    static PARSED: LazyLock<BTreeMap<String, Vec<Archive>>> = LazyLock::new(|| {
        let text = include_str!("../../../datasets/archives.toml");
        toml::from_str(text).expect("datasets/ is part of the program")
    });
    &PARSED["archive"]
}

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
        names.filter_map(|name| archives().iter().find(|archive| archive.name == *name))
    }

    /// Path of the sequence's folder or file under `root`.
    pub(crate) fn path(&self, root: &Path) -> PathBuf {
        below(root, &self.folder)
    }

    /// Attributes of the sequence: the OTB codes spelled out, and the type of the target.
    pub(crate) fn attribute_words(&self) -> impl Iterator<Item = String> {
        let target = self.target_type.map(|word| format!("target-{word:?}").to_lowercase());
        self.attributes.iter().map(|code| attribute_word(code).to_owned()).chain(target)
    }

    /// The entry as a line of its suite file.
    pub fn line(&self) -> String {
        let mut line = String::new();
        self.serialize(toml::ser::ValueSerializer::new(&mut line)).expect("an entry has texts and numbers");
        line + ","
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_is_the_suite_of_its_name() {
        assert!(pinned_suites().map(|suite| suite.name.as_str()).eq(pinned_suite_names()));
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../datasets");
        let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
        let files = files.filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
        assert_eq!(files.count(), SUITES.len() + 1);
        assert!(pinned_suite("no such suite").is_none());
    }
}
