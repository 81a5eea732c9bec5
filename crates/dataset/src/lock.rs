//! What is pinned: the suites of published sequences, and the archives these come in.
//!
//! The facts are in the TOML files of `datasets/`, which are built into the program; its `README.md` describes them. A fact
//! that no source states is left out: an entry without `range` takes all frames of its folder.
//!
//! OTB attributes are kept in the file by their published codes and given to sequences spelled out
//! (`occlusion`, `scale-variation` ...), with the type of the target beside them (`target-car`,
//! `target-person`, `target-face`, `target-other`). The attributes of VOT, GOT-10k and LaSOT sequences are the
//! names of their labels.

mod built_in;
mod entry;

pub use built_in::SUITES;
pub(crate) use built_in::{PinnedSuite, pinned_suite, pinned_suite_names};
pub use entry::{Entry, TargetType, attribute_word};
pub(crate) use entry::{attribute_words, below};

use crate::archive::Archive;

/// The archive of a name.
pub fn archive(name: &str) -> Option<&'static Archive> {
    archives().iter().find(|a| a.name == name)
}

/// All archives, in order.
pub fn archives() -> &'static [Archive] {
    built_in::archives()
}
