//! Suites: which sequences they have, where those come from, and what exactly they must be.
//!
//! The facts are in `datasets.lock`, a TOML file beside `Cargo.toml` that is built into the program. Nothing
//! of the data itself is; a sequence that is not under the data root is reported as missing, with the way to
//! get it. Loading reads file lists and text only, in the order of the file; [`Suite::verify`] hashes.
//!
//! OTB attributes are kept in the file by their published codes and given to sequences spelled out
//! (`occlusion`, `scale-variation` ...), with the type of the target beside them (`target-car`,
//! `target-person`, `target-face`, `target-other`). VOT sequences have the names of their labels.

use super::{DatasetError, Sequence, otb, sorted, synthetic, vot};
use crate::plugin::unknown;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The built-in text.
pub const LOCK: &str = include_str!("../../datasets.lock");

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Lock {
    schema: u32,
    suite: Vec<Pinned>,
}

/// Layout of a suite's folders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// See [`otb`].
    Otb,
    /// See [`vot`].
    Vot,
}

/// What a target is, for tables by type.
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

impl TargetType {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Car => "car",
            Self::Person => "person",
            Self::Face => "face",
            Self::Other => "other",
        }
    }
}

/// A suite of sequences on disk.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Pinned {
    name: String,
    title: String,
    format: Format,
    source: String,
    licence: String,
    how_to_get: String,
    sequence: Vec<Entry>,
}

/// One line of `datasets.lock`: a sequence and what a local copy must be.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Name, unique in the suite.
    pub name: String,
    /// Folder under the data root, parts separated by `/`.
    pub folder: String,
    /// Which target of the folder, from 1, where there are several.
    pub target: Option<u32>,
    /// First and last frame used, in the dataset's numbers.
    pub range: (u32, u32),
    /// First and last frame of the dataset's own range.
    pub official: (u32, u32),
    /// Number of frames used.
    pub frames: usize,
    /// Width and height in pixels, where a copy has been seen.
    pub size: Option<(usize, usize)>,
    /// What the target is.
    pub target_type: TargetType,
    /// Codes of OTB attributes.
    #[serde(default)]
    pub attributes: Vec<String>,
    /// Files digest, where a copy has been seen.
    pub digest: Option<String>,
}

/// A named list of sequences.
#[derive(Clone)]
pub struct Suite {
    content: Content,
}

#[derive(Clone)]
enum Content {
    Pinned(&'static Pinned),
    Rendered(&'static synthetic::Suite),
}

/// A sequence that is not under the data root.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// Its name.
    pub name: String,
    /// Where it would be, under the data root.
    pub folder: String,
    /// What to do.
    pub how_to_get: String,
}

/// A sequence that is there but cannot be read.
#[derive(Debug)]
pub struct Broken {
    /// Its name.
    pub name: String,
    /// What is wrong.
    pub error: DatasetError,
}

/// What of a suite is here.
#[derive(Debug, Default)]
pub struct Loaded {
    /// The sequences that are, in the suite's order.
    pub sequences: Vec<Sequence>,
    /// The ones that are not.
    pub missing: Vec<Missing>,
    /// The ones that cannot be read.
    pub broken: Vec<Broken>,
    /// Number of sequences the suite has.
    pub wanted: usize,
}

/// How a local copy compares with what is pinned.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Finding {
    /// As pinned.
    Same,
    /// Number of frames and size are as pinned; no digest is.
    NoDigestPinned,
    /// Not there.
    Missing(Missing),
    /// Something else, or unreadable; the first difference.
    Differs(String),
}

/// One sequence of [`Suite::verify`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Checked {
    /// The sequence.
    pub name: String,
    /// What was found.
    pub finding: Finding,
}

fn pinned() -> &'static [Pinned] {
    static PARSED: OnceLock<Lock> = OnceLock::new();
    let lock = PARSED.get_or_init(|| {
        let lock: Lock = toml::from_str(LOCK).expect("datasets.lock is part of the program");
        assert_eq!(lock.schema, 1, "datasets.lock is part of the program");
        lock
    });
    &lock.suite
}

/// The names of all suites, those on disk first.
pub fn names() -> Vec<&'static str> {
    pinned().iter().map(|p| p.name.as_str()).chain(synthetic::SUITES.iter().map(|r| r.name)).collect()
}

/// The suite of a name.
///
/// # Errors
/// [`DatasetError::UnknownSuite`] with the nearest name.
pub fn suite(name: &str) -> Result<Suite, DatasetError> {
    let on_disk = pinned().iter().find(|p| p.name == name).map(Content::Pinned);
    let rendered = || synthetic::SUITES.iter().find(|r| r.name == name).map(Content::Rendered);
    match on_disk.or_else(rendered) {
        Some(content) => Ok(Suite { content }),
        None => Err(DatasetError::UnknownSuite(unknown("suite", name, names()))),
    }
}

impl Suite {
    /// Its name.
    pub fn name(&self) -> &'static str {
        match self.content {
            Content::Pinned(p) => &p.name,
            Content::Rendered(r) => r.name,
        }
    }

    /// One line about it.
    pub fn title(&self) -> &'static str {
        match self.content {
            Content::Pinned(p) => &p.title,
            Content::Rendered(r) => r.summary,
        }
    }

    /// Address and paper of the data, and what is known of their licence; `None` for rendered suites.
    pub fn source(&self) -> Option<(&'static str, &'static str)> {
        match self.content {
            Content::Pinned(p) => Some((&p.source, &p.licence)),
            Content::Rendered(_) => None,
        }
    }

    /// The pinned sequences in order; none for rendered suites.
    pub fn entries(&self) -> &'static [Entry] {
        match self.content {
            Content::Pinned(p) => &p.sequence,
            Content::Rendered(_) => &[],
        }
    }

    /// The names of its sequences, in order.
    pub fn sequence_names(&self) -> Vec<String> {
        match self.content {
            Content::Pinned(p) => p.sequence.iter().map(|e| e.name.clone()).collect(),
            Content::Rendered(r) => r.names().map(String::from).collect(),
        }
    }

    /// Loads what is under `data_root`; without one, all sequences on disk are missing.
    ///
    /// Cheap: no image is opened. Digests are not compared here, see [`Suite::verify`].
    pub fn load(&self, data_root: Option<&Path>) -> Loaded {
        match self.content {
            Content::Rendered(r) => {
                let sequences = r.sequences();
                Loaded { wanted: sequences.len(), sequences, ..Loaded::default() }
            }
            Content::Pinned(p) => {
                let mut loaded = Loaded { wanted: p.sequence.len(), ..Loaded::default() };
                for entry in &p.sequence {
                    match p.load(entry, data_root) {
                        Ok(Ok(sequence)) => loaded.sequences.push(sequence),
                        Ok(Err(missing)) => loaded.missing.push(missing),
                        Err(error) => loaded.broken.push(Broken { name: entry.name.clone(), error }),
                    }
                }
                loaded
            }
        }
    }

    /// Compares every sequence under `data_root` with what is pinned, hashing its files; in the suite's
    /// order. Rendered suites have nothing to compare.
    pub fn verify(&self, data_root: Option<&Path>) -> Vec<Checked> {
        let Content::Pinned(p) = self.content else { return Vec::new() };
        p.sequence
            .par_iter()
            .map(|entry| Checked { name: entry.name.clone(), finding: p.check(entry, data_root) })
            .collect()
    }

    /// The lines of `datasets.lock` for the sequences under `data_root`, with the facts found there.
    ///
    /// # Errors
    /// The first sequence that is there but cannot be read.
    pub fn pin(&self, data_root: Option<&Path>) -> Result<Vec<String>, DatasetError> {
        let Content::Pinned(p) = self.content else { return Ok(Vec::new()) };
        let lines: Vec<Option<String>> = p
            .sequence
            .par_iter()
            .map(|entry| match p.load_unchecked(entry, data_root)? {
                Err(_) => Ok(None),
                Ok(s) => {
                    let facts = Entry {
                        frames: s.len(),
                        size: Some(s.size()?),
                        digest: Some(s.digest()?.to_owned()),
                        ..entry.clone()
                    };
                    Ok(Some(facts.line()))
                }
            })
            .collect::<Result<_, DatasetError>>()?;
        Ok(lines.into_iter().flatten().collect())
    }
}

impl Pinned {
    /// Outer result: readable or not; inner: there or not.
    fn load(
        &self,
        entry: &Entry,
        data_root: Option<&Path>,
    ) -> Result<Result<Sequence, Missing>, DatasetError> {
        let loaded = self.load_unchecked(entry, data_root)?;
        if let (Ok(s), Some(root)) = (&loaded, data_root)
            && s.len() != entry.frames
        {
            let message = format!("{} frames, pinned are {}; fetch it again", s.len(), entry.frames);
            return Err(DatasetError::content(&entry.path(root), message));
        }
        Ok(loaded)
    }

    fn load_unchecked(
        &self,
        entry: &Entry,
        data_root: Option<&Path>,
    ) -> Result<Result<Sequence, Missing>, DatasetError> {
        let missing = |hint: &str| Missing {
            name: entry.name.clone(),
            folder: entry.folder.clone(),
            how_to_get: format!("{hint}{}", self.how_to_get),
        };
        let Some(root) = data_root else {
            return Ok(Err(missing("no data root given (--data-root or TRACKFAIL_DATA); ")));
        };
        let folder = entry.path(root);
        if !folder.is_dir() {
            return Ok(Err(missing("")));
        }
        let mut sequence = match self.format {
            Format::Vot => vot::load(&folder, Some(&entry.name))?,
            Format::Otb => {
                let options = otb::Options {
                    name: Some(entry.name.clone()),
                    target: entry.target,
                    range: Some(entry.range),
                    official: Some(entry.official),
                    truth: otb::Truth::Required,
                };
                otb::load(&folder, &options)?
            }
        };
        let target = format!("target-{}", entry.target_type.word());
        let words = entry.attributes.iter().map(|code| attribute_word(code).to_owned()).chain([target]);
        sequence.attributes = sorted(std::mem::take(&mut sequence.attributes).into_iter().chain(words));
        Ok(Ok(sequence))
    }

    fn check(&self, entry: &Entry, data_root: Option<&Path>) -> Finding {
        let compare = || -> Result<Finding, DatasetError> {
            let sequence = match self.load(entry, data_root)? {
                Err(missing) => return Ok(Finding::Missing(missing)),
                Ok(sequence) => sequence,
            };
            if let Some(pinned) = entry.size {
                let (width, height) = sequence.size()?;
                if (width, height) != pinned {
                    return Ok(Finding::Differs(format!(
                        "frames are {width}x{height} pixels, pinned are {}x{}",
                        pinned.0, pinned.1
                    )));
                }
            }
            let Some(pinned) = &entry.digest else { return Ok(Finding::NoDigestPinned) };
            let digest = sequence.digest()?;
            if digest != pinned {
                return Ok(Finding::Differs(format!(
                    "frames or ground truth are other bytes: digest {digest}, pinned {pinned}"
                )));
            }
            Ok(Finding::Same)
        };
        compare().unwrap_or_else(|e| Finding::Differs(e.to_string()))
    }
}

impl Entry {
    fn path(&self, root: &Path) -> PathBuf {
        self.folder.split('/').fold(root.to_path_buf(), |path, part| path.join(part))
    }

    /// The entry as it stands in `datasets.lock`.
    pub fn line(&self) -> String {
        use std::fmt::Write as _;
        let pair = |p: (u32, u32)| format!("[{}, {}]", p.0, p.1);
        let mut line = format!("{{ name = \"{}\", folder = \"{}\", ", self.name, self.folder);
        // Writing to a string cannot fail.
        if let Some(target) = self.target {
            let _ = write!(line, "target = {target}, ");
        }
        let (range, official) = (pair(self.range), pair(self.official));
        let _ = write!(line, "range = {range}, official = {official}, frames = {}, ", self.frames);
        if let Some((width, height)) = self.size {
            let _ = write!(line, "size = [{width}, {height}], ");
        }
        let _ = write!(line, "target_type = \"{}\"", self.target_type.word());
        if !self.attributes.is_empty() {
            let _ = write!(line, ", attributes = [\"{}\"]", self.attributes.join("\", \""));
        }
        if let Some(digest) = &self.digest {
            let _ = write!(line, ", digest = \"{digest}\"");
        }
        line + " },"
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lock_is_consistent() {
        for p in pinned() {
            let mut seen = std::collections::BTreeSet::new();
            for e in &p.sequence {
                assert!(seen.insert(&e.name), "{} twice", e.name);
                assert_eq!((e.range.1 - e.range.0) as usize + 1, e.frames, "{}", e.name);
                assert!(e.official.0 <= e.range.0 && e.range.1 <= e.official.1, "{}", e.name);
                assert!(e.attributes.iter().all(|a| attribute_word(a) != a), "{}", e.name);
                assert!(e.digest.as_ref().is_none_or(|d| d.len() == 64), "{}", e.name);
                assert!(!e.folder.contains("..") && !e.folder.starts_with('/'));
                assert!(LOCK.contains(&e.line()), "not as `data lock` writes it: {}", e.line());
            }
        }
    }

    // The published lengths of the 20 sequences, cut as in the paper and Jogging once, add up to 6717; Tiger1
    // starts at frame 6 here, as in the results of CVPR 2013.
    #[test]
    fn the_suites_have_the_published_sizes() {
        let dtef = suite("otb-dtef20").unwrap();
        assert_eq!(dtef.entries().len(), 21);
        let once = dtef.entries().iter().filter(|e| e.target != Some(2));
        assert_eq!(once.map(|e| e.frames).sum::<usize>() + 5, 6717);
        // wc -l of the 25 result files of a VOT2014 entry: 10213.
        let vot = suite("vot2014").unwrap();
        assert_eq!(
            (vot.entries().len(), vot.entries().iter().map(|e| e.frames).sum::<usize>()),
            (25, 10_213)
        );
    }

    #[test]
    fn unknown_suites_name_the_nearest() {
        let error = suite("otb-dtef2O").err().unwrap().to_string();
        assert!(error.contains("did you mean `otb-dtef20`"), "{error}");
        assert!(suite("zzz").err().unwrap().to_string().contains("vot2014"));
    }

    #[test]
    fn without_data_all_are_missing_and_say_how_to_get_them() {
        let nothing = tempfile::tempdir().unwrap();
        for name in ["otb-dtef20", "vot2014"] {
            for root in [None, Some(nothing.path())] {
                let loaded = suite(name).unwrap().load(root);
                assert_eq!((loaded.sequences.len(), loaded.missing.len()), (0, loaded.wanted));
                assert!(loaded.missing.iter().all(|m| m.how_to_get.contains("http")));
                assert_eq!(root.is_none(), loaded.missing[0].how_to_get.contains("--data-root"));
            }
        }
    }

    #[test]
    fn a_short_copy_is_broken_and_differs() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("vot2014/ball");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("00000001.jpg"), b"").unwrap();
        std::fs::write(folder.join("groundtruth.txt"), "1,2,3,4").unwrap();
        let vot = suite("vot2014").unwrap();
        let loaded = vot.load(Some(root.path()));
        assert_eq!((loaded.broken.len(), loaded.missing.len(), loaded.wanted), (1, 24, 25));
        assert!(loaded.broken[0].error.to_string().contains("602"));
        let checked = vot.verify(Some(root.path()));
        assert!(matches!(&checked[0].finding, Finding::Differs(fact) if fact.contains("1 frames")));
        assert!(matches!(checked[1].finding, Finding::Missing(_)));
    }

    #[test]
    fn real_data_are_as_pinned() {
        let Some(root) = crate::testing::real_data("real_data_are_as_pinned") else { return };
        for name in ["otb-dtef20", "vot2014"] {
            let suite = suite(name).unwrap();
            let loaded = suite.load(Some(&root));
            assert!(loaded.broken.is_empty(), "{:?}", loaded.broken);
            assert_eq!(loaded.sequences.len() + loaded.missing.len(), loaded.wanted);
            for checked in suite.verify(Some(&root)) {
                let fine = matches!(checked.finding, Finding::Same | Finding::Missing(_));
                assert!(fine, "{}: {:?}", checked.name, checked.finding);
            }
            for line in suite.pin(Some(&root)).unwrap() {
                assert!(LOCK.contains(&line), "{line}");
            }
        }
    }
}
