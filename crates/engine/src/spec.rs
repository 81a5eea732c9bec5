//! Experiments: one TOML file -> a checked [`Experiment`] -> cells.
//!
//! A file can name only trackers, signals, detectors and protocols that are in the program's lists. It cannot
//! run code or leave its folder and the data root.
//!
//! In the order in which they use each other:
//!
//! | module | holds |
//! |---|---|
//! | [`name`], [`limits`], [`width`], [`error`] | valid names, largest sizes of files and tables, errors with their place |
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

/// Role of the suite on which methods are evaluated.
pub const TEST: &str = "test";
/// Word in place of a role: train on the test suite without the sequence and the tracker to be tested.
pub const OTHERS: &str = "others";

/// A checked experiment.
pub struct Experiment {
    /// Path-like name, the folder of its results: `khalid2016/table1`.
    pub name: String,
    /// Title for people.
    pub title: String,
    /// Key of the paper that the experiment replicates, if any.
    pub paper: Option<String>,
    /// The paper's object: `Table 1`.
    pub object: Option<String>,
    /// Warning to readers about what they could misjudge.
    pub note: Option<String>,
    /// True if the methods stand on the leaderboard, with all trackers pooled.
    pub leaderboard: bool,
    /// Name of the experiment whose results stand beside the own ones, if any.
    pub beside: Option<String>,
    /// How labels are scored, unless a method names a protocol of its own; `None` without methods.
    pub protocol: Option<&'static Protocol>,
    /// Seed from which all other seeds are derived.
    pub seed: u64,
    /// Unit of sequences that are left out together when training on others.
    pub folds: FoldsBy,
    /// Suite names by role. [`TEST`] is always present.
    pub suites: BTreeMap<String, String>,
    /// Catalog in which the suites are looked up.
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
    /// Numbers printed in the paper.
    pub published: Vec<Published>,
    /// Claims of the paper, each checked against our results.
    pub claims: Vec<Claim>,
    /// Whole text with extended files and groups written out; saved beside the results.
    pub source: String,
}

/// Unit of cross-validation: what is left out together when training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FoldsBy {
    /// A tenth of the videos, and the tracker.
    #[default]
    Video,
    /// A source of videos, for all trackers.
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

    /// Suite name of a role; that of the test suite for [`OTHERS`].
    pub fn suite_of(&self, role: &str) -> Option<&String> {
        self.suites.get(if role == OTHERS { TEST } else { role })
    }

    /// Protocol that scores the labels of a method.
    pub fn protocol_of(&self, method: &str) -> Option<&'static Protocol> {
        self.methods.iter().find(|m| m.name == method).map(|m| m.protocol).or(self.protocol)
    }

    /// Probability that random detections match events under a method's protocol.
    pub fn chance_of(&self, method: &str) -> Option<Chance> {
        self.protocol_of(method).map(|p| p.chance)
    }
}

/// A track that is known to be absent: `{ sequence = "Board", reason = "the file lacks a line" }`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Absence {
    /// Name of the sequence.
    pub sequence: String,
    /// Reason why there is no track.
    pub reason: String,
}

/// A tracker of an experiment.
pub struct Tracker {
    /// Name in tables, unique in the experiment.
    pub label: String,
    /// Family of trackers over which measures are pooled.
    pub family: Option<String>,
    /// Label of the tracker of which this one is another reading.
    pub like: Option<String>,
    /// Plugin kind.
    pub kind: &'static str,
    /// Plugin version.
    pub version: u32,
    /// Repetitions on the test suite.
    pub runs: u32,
    /// Repetitions on suites that models are learned from.
    pub training_runs: u32,
    /// Sources of videos on which the tracker runs; `None` for all.
    pub sources: Option<Vec<String>>,
    /// Tracks that are known to be absent.
    pub absent: Vec<Absence>,
    /// Protocol of the run: one pass, resets or shifted starts.
    pub protocol: RunProtocol,
    /// Tracker with checked parameters, wrapped in its run protocol.
    pub setup: Configured<dyn TrackerConfig>,
}

impl Tracker {
    /// True if the tracker is run on the videos of a source.
    pub fn runs_on(&self, source: &str) -> bool {
        self.sources.as_ref().is_none_or(|mine| mine.iter().any(|s| s == source))
    }
}
