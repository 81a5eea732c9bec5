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

mod entry;

pub use entry::{Entry, TargetType, attribute_word};
pub(crate) use entry::{attribute_words, below};

use crate::archive::Archive;
use crate::format::FormatEntry;
use serde::{Deserialize, Serialize};
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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ArchiveFile {
    archive: Vec<Archive>,
}

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
    static PARSED: LazyLock<ArchiveFile> = LazyLock::new(|| {
        let text = include_str!("../../../datasets/archives.toml");
        toml::from_str(text).expect("datasets/ is part of the program")
    });
    &PARSED.archive
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_is_the_suite_of_its_name() {
        assert!(pinned_suites().map(|suite| suite.name.as_str()).eq(pinned_suite_names()));
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../datasets");
        let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
        let files = files.filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
        assert_eq!(files.count(), SUITES.len() + 1);
        assert!(pinned_suite("no such suite").is_none());
    }
}
