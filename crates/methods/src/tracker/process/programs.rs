//! Programs that may be run as trackers, signals and detectors; [`spec::programs`](crate::spec::programs) reads them.

use crate::analysis::Analysis;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use trackfail_core::plugin::{self, Configured, ParamError};
use trackfail_dataset::text::shorten_to;

/// Protocol between this program and another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Protocol {
    /// TraX, versions 1 to 4.
    #[default]
    Trax,
    /// Lines of text.
    Lines,
    /// Lines of JSON, of signals and detectors.
    #[serde(skip)]
    Json,
}

/// Kinds of plugins that a program can stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// A tracker.
    Tracker,
    /// A signal.
    Signal,
    /// A detector.
    Detector,
}

impl Role {
    /// The word for it in `plugins.toml`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Tracker => "tracker",
            Self::Signal => "signal",
            Self::Detector => "detector",
        }
    }
}

impl Protocol {
    /// The word for it in `plugins.toml`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Trax => "trax",
            Self::Lines => "lines",
            Self::Json => "json",
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
    /// Its role.
    pub role: Role,
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
    /// Its programs, by role and name.
    pub list: Vec<Arc<Program>>,
}

impl Programs {
    /// The programs of a role.
    pub fn of(&self, role: Role) -> impl Iterator<Item = &Arc<Program>> {
        self.list.iter().filter(move |p| p.role == role)
    }

    /// A program by role and name.
    ///
    /// # Errors
    /// When there is no program of this role and name.
    pub fn find(&self, role: Role, name: &str) -> Result<Arc<Program>, UnknownProgram> {
        if let Some(program) = self.of(role).find(|p| p.name == name) {
            return Ok(program.clone());
        }
        let (name, file, role) = (shorten_to(name, 64), self.file.clone(), role.word());
        let known: Vec<&str> =
            self.list.iter().filter(|p| p.role.word() == role).map(|p| p.name.as_str()).collect();
        Err(match (file.is_empty(), known.is_empty()) {
            (true, _) => UnknownProgram::NoFile { name },
            (false, true) => UnknownProgram::NoneNamed { name, role, file },
            (false, false) => {
                UnknownProgram::OthersNamed { file, message: plugin::unknown("program", &name, known) }
            }
        })
    }

    /// As [`find`](Self::find), for the parameter `program` of a plugin.
    pub(crate) fn named(&self, role: Role, name: &str) -> Result<Arc<Program>, ParamError> {
        self.find(role, name).map_err(|e| ParamError {
            message: e.to_string(),
            key: Some("program"),
            span: None,
        })
    }
}

/// A plugin that may name a program.
pub trait Bind {
    /// Binds a configuration that names a program to that program, one of those that the user of this computer allows;
    /// others stay as they are.
    ///
    /// # Errors
    /// When the program, or a file of its digest, is not there.
    fn bind(plugin: &mut Configured<Self>, programs: &Programs) -> Result<(), ParamError>;
}

impl Bind for dyn Analysis {
    fn bind(_: &mut Configured<Self>, _: &Programs) -> Result<(), ParamError> {
        Ok(())
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
        "unknown program `{name}`: {file} names no {role}; programs are named in a file of one's own, see --plugins"
    )]
    NoneNamed {
        /// The name.
        name: String,
        /// The role.
        role: &'static str,
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
