//! The built-in text of `datasets.lock`, parsed a suite at a time.
//!
//! Parsing the whole text takes longer than most commands take for everything else, and a run needs one or two
//! suites. So the text is cut at its `[[suite]]` lines; the part before the first one holds the archives.

use super::entry::{Entry, TargetType};
use crate::archive::Archive;
use crate::format::FormatEntry;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::sync::OnceLock;

/// The built-in text.
pub const LOCK: &str = include_str!("../../../../datasets.lock");

const SUITE: &str = "[[suite]]\n";
const SYNTHETIC: &str = "\nformat = \"synthetic\"\n";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    schema: u32,
    #[serde(default)]
    archive: Vec<Archive>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OneSuite<T> {
    suite: [T; 1],
}

/// A suite of sequences on disk.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PinnedSuite {
    /// Name, unique among all suites.
    pub name: String,
    /// One line about it.
    pub title: String,
    /// Format of its folders, unless an entry gives another.
    pub format: &'static FormatEntry,
    /// Address and paper of the data.
    pub source: String,
    /// Licence, as far as it is known.
    pub licence: String,
    /// How to get a missing sequence.
    pub how_to_get: String,
    /// Built-in suites whose sequences it has, before its own.
    #[serde(default)]
    pub includes: Vec<String>,
    /// Its sequences in order.
    #[serde(default)]
    pub sequence: Vec<Entry>,
}

impl PinnedSuite {
    /// The suite with the sequences of those that it includes; the name of one that is not known.
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

/// A suite of rendered sequences.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct RenderedSuite {
    #[expect(dead_code, reason = "a section is found by its name before it is parsed")]
    name: String,
    #[expect(dead_code, reason = "a section has this type because of its format")]
    format: String,
    sequence: Vec<RenderedEntry>,
}

/// One sequence of a rendered suite.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RenderedEntry {
    /// Name, unique in the suite.
    pub name: String,
    /// Number of frames.
    pub frames: usize,
    /// Width and height in pixels.
    pub size: (usize, usize),
    /// Type of the target.
    pub target_type: TargetType,
    /// Codes of OTB attributes.
    pub attributes: Vec<String>,
}

struct Section<T> {
    name: &'static str,
    text: &'static str,
    parsed: OnceLock<T>,
}

impl<T: DeserializeOwned> Section<T> {
    fn new((name, text): (&'static str, &'static str)) -> Self {
        Self { name, text, parsed: OnceLock::new() }
    }

    fn parsed(&self, complete: impl Fn(T) -> T) -> &T {
        self.parsed.get_or_init(|| {
            let OneSuite { suite: [suite] } =
                toml::from_str(self.text).expect("datasets.lock is part of the program");
            complete(suite)
        })
    }
}

impl Section<PinnedSuite> {
    fn suite(&self) -> &PinnedSuite {
        self.parsed(|suite| suite.complete().expect("datasets.lock is part of the program"))
    }
}

impl Section<RenderedSuite> {
    fn suite(&self) -> &RenderedSuite {
        self.parsed(|suite| suite)
    }
}

struct Sections {
    head: &'static str,
    pinned: Vec<Section<PinnedSuite>>,
    rendered: Vec<Section<RenderedSuite>>,
}

fn sections() -> &'static Sections {
    static SECTIONS: OnceLock<Sections> = OnceLock::new();
    SECTIONS.get_or_init(|| {
        let mut starts: Vec<usize> = LOCK.match_indices(SUITE).map(|(at, _)| at).collect();
        let head = &LOCK[..starts.first().copied().unwrap_or(LOCK.len())];
        starts.push(LOCK.len());
        let suites = starts.windows(2).map(|cut| &LOCK[cut[0]..cut[1]]).map(|text| (name(text), text));
        let (rendered, pinned): (Vec<_>, Vec<_>) = suites.partition(|(_, text)| text.contains(SYNTHETIC));
        Sections {
            head,
            pinned: pinned.into_iter().map(Section::new).collect(),
            rendered: rendered.into_iter().map(Section::new).collect(),
        }
    })
}

/// The value of a section's `name = "..."`, its first line.
fn name(section: &'static str) -> &'static str {
    section.lines().nth(1).and_then(|l| l.split('"').nth(1)).unwrap_or_default()
}

/// Names of the suites on disk, in order.
pub(crate) fn pinned_suite_names() -> impl Iterator<Item = &'static str> {
    sections().pinned.iter().map(|s| s.name)
}

/// The suite on disk of a name.
pub(crate) fn pinned_suite(name: &str) -> Option<&'static PinnedSuite> {
    sections().pinned.iter().find(|s| s.name == name).map(|section| section.suite())
}

/// The sequences of the rendered suite of a name; none if there is no such suite.
pub(crate) fn rendered_entries(name: &str) -> &'static [RenderedEntry] {
    let section = sections().rendered.iter().find(|s| s.name == name);
    section.map_or(&[], |s| &s.suite().sequence)
}

/// The archives in order.
pub(super) fn archives() -> &'static [Archive] {
    static ARCHIVES: OnceLock<Vec<Archive>> = OnceLock::new();
    ARCHIVES.get_or_init(|| {
        let head: Head = toml::from_str(sections().head).expect("datasets.lock is part of the program");
        assert_eq!(head.schema, 2, "datasets.lock is part of the program");
        head.archive
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    // The whole file is one TOML document, and its sections parsed one by one give the same.
    #[test]
    fn sections_parse_to_the_same_as_the_whole_file() {
        let whole: toml::Table = toml::from_str(LOCK).unwrap();
        let all = whole["suite"].as_array().unwrap();
        let (drawn, kept): (Vec<_>, Vec<_>) =
            all.iter().partition(|s| s["format"].as_str() == Some("synthetic"));
        assert!(!drawn.is_empty() && !kept.is_empty());
        let parts = sections();
        let pinned = parts.pinned.iter().map(|s| (s.name, s.text, s.suite().sequence.len()));
        let rendered = parts.rendered.iter().map(|s| (s.name, s.text, s.suite().sequence.len()));
        for ((name, text, count), whole) in pinned.chain(rendered).zip(kept.into_iter().chain(drawn)) {
            let part: toml::Table = toml::from_str(text).unwrap();
            assert_eq!(&part["suite"][0], whole, "{name}");
            assert_eq!(name, whole["name"].as_str().unwrap());
            let own = whole.get("sequence").map_or(0, |own| own.as_array().unwrap().len());
            let includes = whole.get("includes").and_then(|names| names.as_array()).into_iter().flatten();
            let included = includes.map(|name| pinned_suite(name.as_str().unwrap()).unwrap().sequence.len());
            assert_eq!(count, own + included.sum::<usize>(), "{name}");
        }
        assert_eq!(parts.pinned.len() + parts.rendered.len(), all.len());
        assert_eq!(archives().len(), whole["archive"].as_array().unwrap().len());
        assert!(pinned_suite("no such suite").is_none());
    }
}
