//! Small experiments for the tests of plans and of their execution.

use crate::limits::Stop;
use crate::plan::ExperimentPlan;
use crate::store::Store;
use crate::{execute, spec};

/// An experiment on a suite; further keys come first, then trackers and methods.
pub fn experiment(suite: &str, rest: &str) -> String {
    let head =
        "schema = 1\nname = \"mine/try\"\ntitle = \"A try\"\nprotocol = \"khalid2016/1\"\nsuites.test = ";
    format!("{head}\"{suite}\"\n{rest}")
}

/// A text with the first of some words replaced, which it must have.
#[track_caller]
pub fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

/// Result of a test on the plan of an experiment, with an empty store.
pub fn with_plan<T>(text: &str, test: impl FnOnce(&ExperimentPlan<'_>, &Store) -> T) -> T {
    let experiment = spec::parse("try.toml", text).unwrap();
    let suites = execute::load(&experiment, &[]).unwrap();
    let plan = ExperimentPlan::new(&experiment, suites, &[], &Stop::default()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    test(&plan, &Store::open(folder.path()).unwrap())
}
