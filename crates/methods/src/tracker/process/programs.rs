//! Programs that may be run as trackers; [`spec::programs`](crate::spec::programs) reads them.

use crate::dataset::text::shorten_to;
use crate::plugin;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Protocol between this program and another one.
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
    /// The word for it in `plugins.toml`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Trax => "trax",
            Self::Lines => "lines",
        }
    }
}

/// Form of the regions that a program reads in the lines protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Regions {
    /// `x,y,w,h`.
    #[default]
    Rectangle,
    /// Corners, `x1,y1,x2,y2,...`.
    Polygon,
}

/// A checked program.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// Its name in experiments.
    pub name: String,
    /// Program and arguments, at least one word.
    pub command: Vec<String>,
    /// Absolute path of the folder that it is started in.
    pub folder: PathBuf,
    /// Its protocol.
    pub protocol: Protocol,
    /// Raised by its owner whenever its answers change.
    pub version: String,
    /// Time limit until it is ready.
    pub start_timeout: Duration,
    /// Time limit of an answer to a frame.
    pub answer_timeout: Duration,
    /// Form of the regions that it reads, in the lines protocol.
    pub regions: Regions,
    /// Name of its confidence, the property of TraX that has it; `None` if it gives none.
    pub confidence: Option<String>,
    /// Whether its answers depend neither on the seed nor on the run.
    pub deterministic: bool,
    /// Variables that are added to the environment.
    pub environment: BTreeMap<String, String>,
    /// Absolute paths of the files whose bytes are part of a track's address.
    pub digest: Vec<PathBuf>,
}

/// The programs of one file.
#[derive(Debug, Clone, Default)]
pub struct Programs {
    /// The file as the user named it; empty if there is none.
    pub file: String,
    /// Its programs, sorted by name.
    pub list: Vec<Arc<Program>>,
}

impl Programs {
    /// A program by name.
    ///
    /// # Errors
    /// When there is no program of this name.
    pub fn find(&self, name: &str) -> Result<Arc<Program>, UnknownProgram> {
        if let Some(program) = self.list.iter().find(|p| p.name == name) {
            return Ok(program.clone());
        }
        let (name, file) = (shorten_to(name, 64), self.file.clone());
        Err(match (file.is_empty(), self.list.is_empty()) {
            (true, _) => UnknownProgram::NoFile { name },
            (false, true) => UnknownProgram::NoneNamed { name, file },
            (false, false) => {
                let known = self.list.iter().map(|p| p.name.as_str());
                UnknownProgram::OthersNamed { file, message: plugin::unknown("program", &name, known) }
            }
        })
    }
}

/// Why a program cannot be found.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnknownProgram {
    /// There is no file of programs.
    #[error(
        "unknown program `{name}`: there is no plugins.toml here; programs are named in a file of one's own, see \
         --plugins"
    )]
    NoFile {
        /// The name.
        name: String,
    },
    /// The file names no program.
    #[error(
        "unknown program `{name}`: {file} names none; programs are named in a file of one's own, see --plugins"
    )]
    NoneNamed {
        /// The name.
        name: String,
        /// The file of programs.
        file: String,
    },
    /// The file names others.
    #[error("{file}: {message}")]
    OthersNamed {
        /// The file of programs.
        file: String,
        /// The name, with the nearest one or all that there are.
        message: String,
    },
}
