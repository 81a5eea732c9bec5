//! `trackfail merge DIR...`

use super::{Failure, output};
use crate::engine::store::{FOLDER, Store};
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
    let io = |e: &dyn std::fmt::Display| Failure::Io(e.to_string());
    for folder in &args.folders {
        if !folder.join(FOLDER).is_dir() {
            let message = format!("{}: no store; name the --results folder of a run", folder.display());
            return Err(Failure::Usage(message));
        }
    }
    let mine = Store::open(&args.results).map_err(|e| io(&e))?;
    for folder in &args.folders {
        let theirs = Store::open_read_only(folder).map_err(|e| io(&e))?;
        let damaged = theirs.problems();
        if let Some(first) = damaged.first() {
            return Err(io(first));
        }
        let merged = mine.merge(&theirs).map_err(|e| io(&e))?;
        output::write(&format!(
            "{}: {} records added, {} known\n",
            folder.display(),
            merged.added,
            merged.known
        ))?;
    }
    Ok(())
}
