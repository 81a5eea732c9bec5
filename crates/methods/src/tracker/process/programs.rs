//! Programs that may be run as trackers, signals and detectors; [`spec::programs`](crate::spec::programs) reads them.

use crate::analysis::Analysis;
use crate::tracker::TrackerError;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::any::Any;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use trackfail_core::plugin::{self, Configured, ParamError, Plugin, Range};
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
    pub fn find(&self, role: Role, name: &str) -> Result<Arc<Program>, ParamError> {
        if let Some(program) = self.of(role).find(|p| p.name == name) {
            return Ok(program.clone());
        }
        let (name, file) = (shorten_to(name, 64), &self.file);
        let known: Vec<&str> = self.of(role).map(|p| p.name.as_str()).collect();
        let own = "programs are named in a file of one's own, see --plugins";
        Err(refused(if file.is_empty() {
            format!("unknown program `{name}`: there is no plugins.toml here; {own}")
        } else if known.is_empty() {
            format!("unknown program `{name}`: {file} names no {}; {own}", role.word())
        } else {
            format!("{file}: {}", plugin::unknown("program", &name, known))
        }))
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

/// Parameters that name a program.
pub trait Named: Clone + DeserializeOwned + Serialize + schemars::JsonSchema + Send + Sync + 'static {
    /// The kind of plugin that the program is.
    const ROLE: Role;

    /// Ranges of the other parameters.
    const RANGES: &'static [Range] = &[];

    /// Name of the program.
    fn program(&self) -> &str;

    /// Entries of the program among the shown parameters, beside its version.
    ///
    /// # Errors
    /// When a file of its digest is not there.
    fn facts(_program: &Program) -> Result<Vec<(&'static str, Value)>, ParamError> {
        Ok(Vec::new())
    }
}

/// A plugin that a program stands for.
pub struct Process<P> {
    /// Its parameters.
    pub params: P,
    /// `None` until it is bound; reports do not need it.
    program: Option<Arc<Program>>,
}

impl<P: Named> Plugin for Process<P> {
    type Params = P;

    const RANGES: &'static [Range] = P::RANGES;

    fn make(params: P) -> Result<Self, ParamError> {
        Ok(Self { params, program: None })
    }
}

impl<P: Named> Process<P> {
    /// The program.
    ///
    /// # Errors
    /// When it has not been bound to one.
    pub fn program(&self) -> Result<&Arc<Program>, TrackerError> {
        let name = self.params.program();
        let not_bound = || TrackerError::Missing(format!("the program {name} is not known here"));
        self.program.as_ref().ok_or_else(not_bound)
    }

    /// Whether its answers may depend on the seed.
    pub fn depends_on_seed(&self) -> bool {
        self.program.as_ref().is_none_or(|p| !p.deterministic)
    }

    /// Files whose bytes are part of an address.
    pub fn files(&self) -> Vec<PathBuf> {
        self.program.as_ref().map_or_else(Vec::new, |p| p.digest.clone())
    }
}

/// Binds a configuration, if it is a [`Process`] with such parameters, to the program that they name.
///
/// # Errors
/// As [`Bind::bind`].
pub fn bind<T, P: Named>(
    plugin: &mut Configured<T>,
    as_any: fn(&T) -> &(dyn Any + 'static),
    programs: &Programs,
) -> Result<(), ParamError>
where
    T: ?Sized + plugin::Role<Process<P>>,
{
    let Some(process) = as_any(&plugin.plugin).downcast_ref::<Process<P>>() else { return Ok(()) };
    let params = process.params.clone();
    let program = programs.find(P::ROLE, params.program())?;
    plugin.show("version", program.version.as_str());
    for (key, value) in P::facts(&program)? {
        plugin.show(key, value);
    }
    plugin.plugin = T::hold(Process { params, program: Some(program) });
    Ok(())
}

/// The error for a parameter `program` that cannot be bound.
pub fn refused(message: String) -> ParamError {
    ParamError { message, key: Some("program"), span: None }
}
