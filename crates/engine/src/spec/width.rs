//! Width of a figure or a table in print.

use serde::Serialize;

/// Width of a figure or a table in print.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Width {
    /// One of the two columns of a page: 3.3 inches.
    Column,
    /// The full text width of a page: 7 inches.
    #[default]
    Text,
}

impl Width {
    /// Both widths.
    pub(super) const ALL: [Self; 2] = [Self::Column, Self::Text];

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

    /// The width with this word.
    pub(super) fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|width| width.word() == word)
    }
}
