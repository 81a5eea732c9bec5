//! Facts of `datasets.lock`: the pinned suites, their sequences, and the archives these come in.
//!
//! `datasets.lock` is a TOML file beside `Cargo.toml` that is built into the program; its head comment describes
//! it. A suite is parsed when it is first needed. A fact that no source states is left out of the file: an entry
//! without `range` takes all frames of its folder.
//!
//! For the synthetic suites that stand in for a paper's data, the file gives names, lengths, sizes and attributes
//! (`format = "synthetic"`), which the renderer takes from there.
//!
//! OTB attributes are kept in the file by their published codes and given to sequences spelled out
//! (`occlusion`, `scale-variation` ...), with the type of the target beside them (`target-car`,
//! `target-person`, `target-face`, `target-other`). The attributes of VOT, GOT-10k and LaSOT sequences are the
//! names of their labels.

mod built_in;
mod entry;

pub use built_in::LOCK;
pub(crate) use built_in::{PinnedSuite, RenderedEntry, pinned_suite, pinned_suite_names, rendered_entries};
pub use entry::{Entry, TargetType, attribute_word};
pub(crate) use entry::{attribute_words, below};

use crate::archive::Archive;

/// The archive of a name.
pub fn archive(name: &str) -> Option<&'static Archive> {
    archives().iter().find(|a| a.name == name)
}

/// All archives in the order of the file.
pub fn archives() -> &'static [Archive] {
    built_in::archives()
}
