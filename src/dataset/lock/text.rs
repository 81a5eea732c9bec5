//! The text of `datasets.lock`, parsed a suite at a time.
//!
//! Parsing all of it takes longer than most commands need for anything else, and a run needs one or two
//! suites. So the text is cut at its `[[suite]]` lines; what stands before the first are the archives.

use super::entry::{Entry, Format};
use crate::dataset::archive::Archive;
use serde::Deserialize;
use std::sync::OnceLock;

/// The built-in text.
pub const LOCK: &str = include_str!("../../../datasets.lock");

const SUITE: &str = "[[suite]]\n";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    schema: u32,
    #[serde(default)]
    archive: Vec<Archive>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct One {
    suite: [Pinned; 1],
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

struct Section {
    name: &'static str,
    text: &'static str,
    parsed: OnceLock<Pinned>,
}

struct Sections {
    head: &'static str,
    suites: Vec<Section>,
}

fn sections() -> &'static Sections {
    static SECTIONS: OnceLock<Sections> = OnceLock::new();
    SECTIONS.get_or_init(|| {
        let mut starts: Vec<usize> = LOCK.match_indices(SUITE).map(|(at, _)| at).collect();
        let head = &LOCK[..starts.first().copied().unwrap_or(LOCK.len())];
        starts.push(LOCK.len());
        let section = |cut: &[usize]| {
            let text = &LOCK[cut[0]..cut[1]];
            Section { name: name(text), text, parsed: OnceLock::new() }
        };
        Sections { head, suites: starts.windows(2).map(section).collect() }
    })
}

/// The value of a section's `name = "..."`, its first line.
fn name(section: &'static str) -> &'static str {
    section.lines().nth(1).and_then(|l| l.split('"').nth(1)).unwrap_or_default()
}

/// The names of the suites in order.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    sections().suites.iter().map(|s| s.name)
}

/// The suite of a name.
pub(super) fn suite(name: &str) -> Option<&'static Pinned> {
    let section = sections().suites.iter().find(|s| s.name == name)?;
    Some(section.parsed.get_or_init(|| {
        let One { suite: [suite] } =
            toml::from_str(section.text).expect("datasets.lock is part of the program");
        suite
    }))
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
        assert_eq!(
            names().collect::<Vec<_>>(),
            all.iter().map(|s| s["name"].as_str().unwrap()).collect::<Vec<_>>()
        );
        for (name, whole) in names().zip(all) {
            let part: toml::Table =
                toml::from_str(sections().suites.iter().find(|s| s.name == name).map(|s| s.text).unwrap())
                    .unwrap();
            assert_eq!(&part["suite"][0], whole, "{name}");
            assert_eq!(suite(name).unwrap().sequence.len(), whole["sequence"].as_array().unwrap().len());
        }
        assert_eq!(archives().len(), whole["archive"].as_array().unwrap().len());
        assert!(suite("no such suite").is_none());
    }
}
