//! `trackfail merge DIR...`: copies the records of other stores into one.

use super::run::print::store_problems;
use super::{Failure, output};
use crate::engine::store::{FOLDER, Merged, Store};
use std::path::PathBuf;

/// Arguments of `merge`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Results folders of other runs
    #[arg(value_name = "DIR", required = true)]
    folders: Vec<PathBuf>,
    /// Results folder whose store gets what theirs have
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    for folder in &args.folders {
        if !folder.join(FOLDER).is_dir() {
            let message = format!("{}: no store; name the --results folder of a run", folder.display());
            return Err(Failure::usage(message));
        }
    }
    let mine = Store::open(&args.results).map_err(Failure::io)?;
    // Packs of its own that are damaged are gone afterwards.
    store_problems(&mine);
    for folder in &args.folders {
        let theirs = Store::open_read_only(folder).map_err(Failure::io)?;
        let damaged = theirs.problems();
        if let Some(first) = damaged.first() {
            return Err(Failure::io(first.to_string()));
        }
        let Merged { added, known } = mine.merge(&theirs).map_err(Failure::io)?;
        store_problems(&mine);
        output::write(&format!("{}: {added} records added, {known} known\n", folder.display()))?;
    }
    Ok(())
}
