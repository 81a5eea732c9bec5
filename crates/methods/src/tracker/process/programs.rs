//! Programs that may run as trackers, signals and detectors. [`spec::programs`](crate::spec::programs) reads
//! them.

use crate::analysis::Analysis;
use crate::tracker::TrackerError;
use schemars::JsonSchema;
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

/// Protocol between this program and an external one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Protocol {
    /// TraX, versions 1 to 4.
    #[default]
    Trax,
    /// Lines of text.
    Lines,
    /// Lines of JSON, for signals and detectors.
    #[serde(skip)]
    Json,
}

/// Kind of plugin that a program stands for.
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
    /// The word for this protocol in `plugins.toml`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Tracker => "tracker",
            Self::Signal => "signal",
            Self::Detector => "detector",
        }
    }
}

impl Protocol {
    /// The word for this role in `plugins.toml`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Trax => "trax",
            Self::Lines => "lines",
            Self::Json => "json",
        }
    }
}

/// Form of the regions that a program reads in the lines protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Regions {
    /// `x,y,w,h`.
    #[default]
    Rectangle,
    /// Corners, `x1,y1,x2,y2,...`.
    Polygon,
}

/// A program of `plugins.toml`, after checks.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// Kind of plugin that it stands for.
    pub role: Role,
    /// Name by which experiments refer to it.
    pub name: String,
    /// Program and arguments; not empty.
    pub command: Vec<String>,
    /// Absolute path of the folder in which it is started.
    pub folder: PathBuf,
    /// Protocol that it speaks.
    pub protocol: Protocol,
    /// Version, which its owner raises when its answers change.
    pub version: String,
    /// Time limit for the start.
    pub start_timeout: Duration,
    /// Time limit for an answer to a frame.
    pub answer_timeout: Duration,
    /// Form of the regions that it reads in the lines protocol.
    pub regions: Regions,
    /// Name of the confidence, in TraX a property; `None` if the program gives none.
    pub confidence: Option<String>,
    /// True if the answers depend neither on the seed nor on the run.
    pub deterministic: bool,
    /// Variables that are added to the environment.
    pub environment: BTreeMap<String, String>,
    /// Absolute paths of files whose bytes are part of a track's address.
    pub digest: Vec<PathBuf>,
}

/// The programs of one `plugins.toml`.
#[derive(Debug, Clone, Default)]
pub struct Programs {
    /// Path of the file as the user gave it; empty if there is none.
    pub file: String,
    /// Programs, by role and name.
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

/// A kind of plugin whose configurations may name a program.
pub trait Bind {
    /// Binds a configuration that names a program to that program, which must be in the user's own
    /// `plugins.toml`. Other configurations stay unchanged.
    ///
    /// # Errors
    /// When the program, or a file in its `digest`, does not exist.
    fn bind(plugin: &mut Configured<Self>, programs: &Programs) -> Result<(), ParamError>;
}

impl Bind for dyn Analysis {
    fn bind(_: &mut Configured<Self>, _: &Programs) -> Result<(), ParamError> {
        Ok(())
    }
}

/// Parameters that name a program.
pub trait Named: Clone + DeserializeOwned + Serialize + JsonSchema + Send + Sync + 'static {
    /// Kind of plugin that the program stands for.
    const ROLE: Role;

    /// Ranges of the other parameters.
    const RANGES: &'static [Range] = &[];

    /// Name of the program.
    fn program(&self) -> &str;

    /// Entries about the program for the shown parameters, besides its version.
    ///
    /// # Errors
    /// When a file in its `digest` does not exist.
    fn facts(_program: &Program) -> Result<Vec<(&'static str, Value)>, ParamError> {
        Ok(Vec::new())
    }
}

/// A plugin that runs an external program.
pub struct Process<P> {
    /// Parameters, among them the name of the program.
    pub params: P,
    /// `None` until it is bound; reports do not need the program.
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
    /// When it has not been bound.
    pub fn program(&self) -> Result<&Arc<Program>, TrackerError> {
        let name = self.params.program();
        let not_bound = || TrackerError::Missing(format!("the program {name} is not known here"));
        self.program.as_ref().ok_or_else(not_bound)
    }

    /// True if the answers may depend on the seed.
    pub fn depends_on_seed(&self) -> bool {
        self.program.as_ref().is_none_or(|p| !p.deterministic)
    }

    /// Files whose bytes are part of an address.
    pub fn files(&self) -> Vec<PathBuf> {
        self.program.as_ref().map_or_else(Vec::new, |p| p.digest.clone())
    }
}

/// Binds a configuration to the program that its parameters name, if it is a [`Process`] with parameters of
/// type `P`.
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

/// Error for a parameter `program` that cannot be bound.
pub fn refused(message: String) -> ParamError {
    ParamError { message, key: Some("program"), span: None }
}
