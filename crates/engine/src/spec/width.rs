//! How wide a figure or a table is in print.

use super::error::At;
use serde::Serialize;

/// Width of a figure or a table in print.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Width {
    /// One of the two columns of a page: 3.3 inches.
    Column,
    /// All the text of a page: 7 inches.
    #[default]
    Text,
}

impl Width {
    const ALL: [Self; 2] = [Self::Column, Self::Text];

    /// The word in experiment files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Column => "column",
            Self::Text => "text",
        }
    }

    /// Width in inches.
    pub fn inches(self) -> f64 {
        match self {
            Self::Column => 3.3,
            Self::Text => 7.0,
        }
    }

    /// Checks `width` where it is given.
    pub(super) fn read(at: At<'_>, word: Option<&str>) -> Option<Self> {
        let word = word?;
        let known = Self::ALL.into_iter().find(|width| width.word() == word);
        if known.is_none() {
            at.key("width").tell_unknown("width", word, Self::ALL.map(Self::word));
        }
        known
    }
}
