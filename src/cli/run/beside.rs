//! Kept results that an experiment takes rows from (`beside`), before it is run.

use super::Args;
use crate::cli::Failure;
use crate::dataset::suite::Loaded;
use crate::report::finished;
use crate::results::beside::Kept;
use crate::spec::{Experiment, TEST};
use std::collections::BTreeMap;
use std::path::Path;

/// The kept results of a checkout, from its folder.
const SHIPPED: &str = "results";

/// The kept results that an experiment asks for: those in the folder of its own results, or else those of the checkout.
///
/// # Errors
/// `Usage` where they are in neither, `Io` where they cannot be read.
pub fn kept(args: &Args, experiment: &Experiment) -> Result<Option<Kept>, Failure> {
    let Some(name) = &experiment.beside else { return Ok(None) };
    let found = finished::folder(&args.results, name);
    let found = found.or_else(|e| finished::folder(Path::new(SHIPPED), name).map_err(|_| e));
    let folder = found.map_err(|e| Failure::usage(format!("{}: `beside`: {e}", experiment.name)))?;
    Ok(Some(Kept::read(&folder)?))
}

/// Leaves out the sequences of the test suite that the kept results do not have.
///
/// # Errors
/// `Usage` where none is left.
pub fn keep_common(
    kept: &Kept,
    experiment: &Experiment,
    suites: &mut BTreeMap<String, Loaded>,
) -> Result<(), Failure> {
    let Some(test) = suites.get_mut(TEST) else { return Ok(()) };
    let (name, there) = (&kept.results.manifest.experiment, &kept.results.manifest.suite.present);
    test.keep_only(|sequence| there.iter().any(|(known, _)| known == sequence), &format!("not in {name}"));
    if test.sequences.is_empty() {
        let suite = &experiment.suites[TEST];
        let message = format!("{}: `beside`: {name} has no sequence of {suite}", experiment.name);
        return Err(Failure::usage(message));
    }
    Ok(())
}
