//! The text of `datasets.lock`, parsed a suite at a time.
//!
//! Parsing all of it takes longer than most commands need for anything else, and a run needs one or two
//! suites. So the text is cut at its `[[suite]]` lines; what stands before the first are the archives.

use super::entry::{Entry, Format, TargetType};
use crate::archive::Archive;
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
struct One<T> {
    suite: [T; 1],
}

/// A suite of sequences on disk.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Pinned {
    pub name: String,
    pub title: String,
    pub format: Format,
    pub source: String,
    pub licence: String,
    pub how_to_get: String,
    pub sequence: Vec<Entry>,
}

/// A suite of rendered sequences.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Rendered {
    #[expect(dead_code, reason = "a section is found by its name before it is parsed")]
    name: String,
    #[expect(dead_code, reason = "a section has this type because of its format")]
    format: String,
    sequence: Vec<RenderedEntry>,
}

/// What a rendered sequence must be.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RenderedEntry {
    /// Name, unique in the suite.
    pub name: String,
    /// Number of frames.
    pub frames: usize,
    /// Width and height in pixels.
    pub size: (usize, usize),
    /// What the target is.
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

    fn get(&self) -> &T {
        self.parsed.get_or_init(|| {
            let One { suite: [suite] } =
                toml::from_str(self.text).expect("datasets.lock is part of the program");
            suite
        })
    }
}

struct Sections {
    head: &'static str,
    pinned: Vec<Section<Pinned>>,
    rendered: Vec<Section<Rendered>>,
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

/// The names of the suites on disk in order.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    sections().pinned.iter().map(|s| s.name)
}

/// The suite on disk of a name.
pub(super) fn suite(name: &str) -> Option<&'static Pinned> {
    sections().pinned.iter().find(|s| s.name == name).map(Section::get)
}

/// The sequences of the rendered suite of a name; none where there is no such suite.
pub(crate) fn rendered(name: &str) -> &'static [RenderedEntry] {
    let section = sections().rendered.iter().find(|s| s.name == name);
    section.map_or(&[], |s| &s.get().sequence)
}

/// The downloads in order.
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

    // The whole file is one TOML document, and its parts say the same as the whole.
    #[test]
    fn the_parts_are_the_whole() {
        let whole: toml::Table = toml::from_str(LOCK).unwrap();
        let all = whole["suite"].as_array().unwrap();
        let (drawn, kept): (Vec<_>, Vec<_>) =
            all.iter().partition(|s| s["format"].as_str() == Some("synthetic"));
        assert!(!drawn.is_empty() && !kept.is_empty());
        let parts = sections();
        let pinned = parts.pinned.iter().map(|s| (s.name, s.text, s.get().sequence.len()));
        let rendered = parts.rendered.iter().map(|s| (s.name, s.text, s.get().sequence.len()));
        for ((name, text, count), whole) in pinned.chain(rendered).zip(kept.into_iter().chain(drawn)) {
            let part: toml::Table = toml::from_str(text).unwrap();
            assert_eq!(&part["suite"][0], whole, "{name}");
            assert_eq!(name, whole["name"].as_str().unwrap());
            assert_eq!(count, whole["sequence"].as_array().unwrap().len());
        }
        assert_eq!(parts.pinned.len() + parts.rendered.len(), all.len());
        assert_eq!(archives().len(), whole["archive"].as_array().unwrap().len());
        assert!(suite("no such suite").is_none());
    }
}
