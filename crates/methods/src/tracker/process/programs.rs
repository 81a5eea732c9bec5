//! Programs that may be run as trackers; [`spec::programs`](crate::spec::programs) reads them.

use crate::dataset::text::shorten_to;
use crate::plugin;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// What a program speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Protocol {
    /// TraX, versions 1 to 4.
    #[default]
    Trax,
    /// Lines of text.
    Lines,
}

impl Protocol {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Trax => "trax",
            Self::Lines => "lines",
        }
    }
}

/// What regions a program reads that speaks lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Regions {
    /// `x,y,w,h`.
    #[default]
    Rectangle,
    /// Corners.
    Polygon,
}

/// A program, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// What experiments call it.
    pub name: String,
    /// Program and arguments, at least one.
    pub command: Vec<String>,
    /// Where it is started, absolute.
    pub folder: PathBuf,
    /// What it speaks.
    pub protocol: Protocol,
    /// Raised by its owner whenever its answers change.
    pub version: String,
    /// Longest time until it is ready.
    pub start_timeout: Duration,
    /// Longest time until it has answered to a frame.
    pub answer_timeout: Duration,
    /// What it reads, where it speaks lines.
    pub regions: Regions,
    /// Whether its answers depend neither on the seed nor on the run.
    pub deterministic: bool,
    /// Added to the environment.
    pub environment: BTreeMap<String, String>,
    /// Files whose bytes are part of a track's address, absolute.
    pub digest: Vec<PathBuf>,
}

/// The programs of one file.
#[derive(Debug, Clone, Default)]
pub struct Programs {
    /// The file as the user named it; empty where there is none.
    pub file: String,
    /// Its programs, sorted by name.
    pub list: Vec<Arc<Program>>,
}

impl Programs {
    /// A program by name.
    ///
    /// # Errors
    /// In words, with the nearest name there is.
    pub fn find(&self, name: &str) -> Result<Arc<Program>, String> {
        if let Some(program) = self.list.iter().find(|p| p.name == name) {
            return Ok(program.clone());
        }
        let name = shorten_to(name, 64);
        if self.list.is_empty() {
            let file = if self.file.is_empty() { "there is no plugins.toml here" } else { &self.file };
            return Err(format!(
                "unknown program `{name}`: {file}{}; programs are named in a file of one's own, see --plugins",
                if self.file.is_empty() { "" } else { " names none" },
            ));
        }
        let unknown = plugin::unknown("program", &name, self.list.iter().map(|p| p.name.as_str()));
        Err(format!("{}: {unknown}", self.file))
    }
}
