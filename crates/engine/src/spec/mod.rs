//! Experiments: one TOML file -> a checked [`Experiment`] -> cells.
//!
//! [`wire`] is the file's shape, [`read`] turns it into checked plugins, [`error`] tells where it is
//! wrong, [`limits`] how large it may be, [`claim`] is the small language of conclusions, [`builtin`] holds the experiments and the
//! methods that come with the program, [`programs`] reads what a user lets run as a tracker. A file can name only what the lists of trackers, signals,
//! detectors and protocols know; it cannot run code or leave the data root.

pub mod analysis;
pub mod builtin;
pub mod claim;
pub mod error;
pub mod figure;
pub mod limits;
pub mod method;
pub mod programs;
pub mod read;
pub mod schema;
pub mod table;
pub mod wire;

pub use error::SpecError;
pub use limits::read_text;
pub use read::{parse, parse_with};

use crate::dataset::suite::Catalog;
use crate::score::Protocol;
use crate::score::chance::Chance;
use crate::tracker::TrackerConfig;
use crate::tracker::protocol::RunProtocol;
use claim::Claim;
use figure::Figure;
use method::Method;
use std::collections::BTreeMap;
use std::sync::Arc;
use table::{Published, Table};

/// Role of the suite that results are about.
pub const TEST: &str = "test";

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
    /// What a reader must know beside the numbers.
    pub note: Option<String>,
    /// How labels are scored, unless a method says otherwise; none where there is no method.
    pub protocol: Option<&'static Protocol>,
    /// Base of all seeds.
    pub seed: u64,
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
    /// Conclusions as predicates.
    pub claims: Vec<Claim>,
    /// The file's text, kept beside the results.
    pub source: String,
}

impl Experiment {
    /// Lowers the repetitions of all trackers to at most `most`.
    pub fn limit_runs(&mut self, most: u32) {
        for tracker in &mut self.trackers {
            tracker.runs = tracker.runs.min(most);
            tracker.training_runs = tracker.training_runs.min(most);
        }
    }

    /// How the labels of a method are scored.
    pub fn protocol_of(&self, method: &str) -> Option<&'static Protocol> {
        self.methods.iter().find(|m| m.name == method).map(|m| m.protocol).or(self.protocol)
    }

    /// How random detections match by a method's protocol.
    pub fn chance_of(&self, method: &str) -> Option<Chance> {
        self.protocol_of(method).map(|p| p.chance)
    }
}

/// A tracker of an experiment.
pub struct Tracker {
    /// Name in tables, unique in the experiment.
    pub label: String,
    /// Plugin kind.
    pub kind: &'static str,
    /// Plugin version.
    pub version: u32,
    /// Repetitions on the test suite.
    pub runs: u32,
    /// Repetitions on suites that models are learned from.
    pub training_runs: u32,
    /// How it is run.
    pub protocol: RunProtocol,
    /// The checked tracker, under its protocol.
    pub setup: Arc<dyn TrackerConfig>,
}
