//! How wide a figure or a table is in print.

use super::error::{Source, SpecError};
use serde::Serialize;
use toml::Spanned;

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
    pub(super) fn read(
        source: Source<'_>,
        word: Option<&Spanned<String>>,
    ) -> Result<Option<Self>, SpecError> {
        let of = |word: &Spanned<String>| {
            let known = Self::ALL.into_iter().find(|width| width.word() == word.get_ref());
            known.ok_or_else(|| {
                source.unknown(word.span(), "width", word.get_ref(), Self::ALL.map(Self::word))
            })
        };
        word.map(of).transpose()
    }
}
