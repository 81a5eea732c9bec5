//! Experiments: one TOML file -> a checked [`Experiment`] -> cells.
//!
//! A file can name only what the lists of trackers, signals, detectors and protocols know; it cannot run code or
//! leave its folder and the data root.
//!
//! In the order in which they use each other:
//!
//! | module | holds |
//! |---|---|
//! | [`name`], [`limits`], [`width`], [`error`] | what names may be, how large a file and a table may be, where a file is wrong |
//! | [`wire`] | the shape of the file; [`schema`] describes it as JSON Schema, by which `check` finds all that is wrong with keys, types and words |
//! | `raw_plugin` | plugins that are not yet built |
//! | `words` | the names that parts of an experiment can refer to |
//! | [`programs`] | `plugins.toml`: programs that a user lets run as trackers, signals and detectors |
//! | `extend`, `written_out` | files that say only how they differ from another, and methods that say only their name, put together |
//! | [`method`], [`analysis`], [`table`], [`figure`], [`claim`] | the parts of an experiment |
//! | [`builtin`] | experiments and methods that come with the program |
//! | [`presentation`] | what may change without another run |
//! | [`read`] | the way from the text to checked plugins, which goes on after an error |

pub mod analysis;
pub mod builtin;
mod check;
pub mod claim;
pub mod error;
mod extend;
pub mod figure;
pub mod limits;
pub mod method;
pub mod name;
pub mod presentation;
pub mod programs;
mod raw_plugin;
pub mod read;
pub mod schema;
pub mod table;
pub mod width;
pub mod wire;
mod words;
mod written_out;

pub use error::SpecError;
pub use name::check_experiment_name;
pub use read::{parse, parse_with, read_file};

use claim::Claim;
use figure::Figure;
use method::Method;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use table::{Published, Table};
use trackfail_core::plugin::Configured;
use trackfail_dataset::suite::Catalog;
use trackfail_methods::score::Protocol;
use trackfail_methods::score::chance::Chance;
use trackfail_methods::tracker::TrackerConfig;
use trackfail_methods::tracker::protocol::RunProtocol;

/// Role of the suite that methods are evaluated on.
pub const TEST: &str = "test";
/// In place of a role: the test suite without the sequence and the tracker that a parameter or model is made for.
pub const OTHERS: &str = "others";

/// A checked experiment.
pub struct Experiment {
    /// Path-like name, the folder of its results: `khalid2016/table1`.
    pub name: String,
    /// Title for people.
    pub title: String,
    /// Key of the paper it replicates, if any.
    pub paper: Option<String>,
    /// The paper's object: `Table 1`.
    pub object: Option<String>,
    /// Warning to the reader, without which the numbers would be misjudged.
    pub note: Option<String>,
    /// Whether its methods stand on the leaderboard, with all trackers pooled.
    pub leaderboard: bool,
    /// How labels are scored, unless a method names a protocol of its own; `None` without methods.
    pub protocol: Option<&'static Protocol>,
    /// Base of all seeds.
    pub seed: u64,
    /// Folds in which sequences are left out where a parameter or model is made on others.
    pub folds: FoldsBy,
    /// Role -> suite name; [`TEST`] is always there.
    pub suites: BTreeMap<String, String>,
    /// The catalog that the suites are looked up in.
    pub catalog: Catalog,
    /// Trackers in file order.
    pub trackers: Vec<Tracker>,
    /// Methods in file order.
    pub methods: Vec<Method>,
    /// Analyses in file order.
    pub analyses: Vec<analysis::Analysis>,
    /// Tables in file order.
    pub tables: Vec<Table>,
    /// Figures in file order.
    pub figures: Vec<Figure>,
    /// Numbers that the paper prints.
    pub published: Vec<Published>,
    /// Conclusions of the paper, as predicates over the measured numbers.
    pub claims: Vec<Claim>,
    /// The whole text, with what it extends and its groups written out; kept beside the results.
    pub source: String,
}

/// Unit of cross-validation: sequences, and for some units trackers, that are left out together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FoldsBy {
    /// A tenth of the videos, and the tracker.
    #[default]
    Video,
    /// A source of videos, on all trackers.
    Source,
}

impl Experiment {
    /// Lowers the repetitions of all trackers to at most `max_runs`.
    pub fn limit_runs(&mut self, max_runs: u32) {
        for tracker in &mut self.trackers {
            tracker.runs = tracker.runs.min(max_runs);
            tracker.training_runs = tracker.training_runs.min(max_runs);
        }
    }

    /// The suite of a role; the test suite for [`OTHERS`].
    pub fn suite_of(&self, role: &str) -> Option<&String> {
        self.suites.get(if role == OTHERS { TEST } else { role })
    }

    /// Protocol that scores the labels of a method.
    pub fn protocol_of(&self, method: &str) -> Option<&'static Protocol> {
        self.methods.iter().find(|m| m.name == method).map(|m| m.protocol).or(self.protocol)
    }

    /// How often random detections match events under a method's protocol.
    pub fn chance_of(&self, method: &str) -> Option<Chance> {
        self.protocol_of(method).map(|p| p.chance)
    }
}

/// A track that is known not to be there: `{ sequence = "Board", reason = "the file lacks a line" }`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Absence {
    /// Name of the sequence.
    pub sequence: String,
    /// Why there is no track.
    pub reason: String,
}

/// A tracker of an experiment.
pub struct Tracker {
    /// Name in tables, unique in the experiment.
    pub label: String,
    /// Family in which its measures are pooled.
    pub family: Option<String>,
    /// Label of the tracker that it is a reading of.
    pub like: Option<String>,
    /// Plugin kind.
    pub kind: &'static str,
    /// Plugin version.
    pub version: u32,
    /// Repetitions on the test suite.
    pub runs: u32,
    /// Repetitions on suites that models are learned from.
    pub training_runs: u32,
    /// Sources of videos on which it runs; all when `None`.
    pub sources: Option<Vec<String>>,
    /// Tracks that are known not to be there.
    pub absent: Vec<Absence>,
    /// Run protocol: one pass, resets or shifted starts.
    pub protocol: RunProtocol,
    /// The checked tracker, under its protocol.
    pub setup: Configured<dyn TrackerConfig>,
}

impl Tracker {
    /// Whether it is run on the videos of a source.
    pub fn runs_on(&self, source: &str) -> bool {
        self.sources.as_ref().is_none_or(|mine| mine.iter().any(|s| s == source))
    }
}
