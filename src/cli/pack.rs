//! `trackfail pack EXPERIMENT`: results as one file.

use super::{Failure, output};
use crate::engine::store::{folder_of, lock_exclusive};
use crate::report::finished;
use crate::results::manifest::sha256;
use crate::results::sent::Verified;
use crate::user_file;
use std::path::{Path, PathBuf};

/// Arguments of `pack`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Experiment
    experiment: String,
    /// File to write (default: the experiment's name with `-` for `/`, and `.zip`)
    #[arg(long, value_name = "FILE.zip")]
    to: Option<PathBuf>,
    /// Folder that results are read from
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// `Usage` for an experiment without results, `Io` for damaged ones and for what the file system refuses.
pub fn run(args: &Args) -> Result<(), Failure> {
    // A run must not replace the results while they are read.
    let lock = lock_exclusive(&args.results);
    let folder = finished::folder(&args.results, &args.experiment)?;
    let packed = Verified::read(&folder)?.pack()?;
    drop(lock);
    let name = || PathBuf::from(args.experiment.replace('/', "-") + ".zip");
    let file = args.to.clone().unwrap_or_else(name);
    let real = |path: &Path| path.canonicalize().ok();
    let places = [real(&file), real(folder_of(&file))];
    if real(&folder).is_some_and(|folder| places.iter().flatten().any(|place| place.starts_with(&folder))) {
        return Err(Failure::usage(format!(
            "--to {} is among the results; name another folder",
            file.display()
        )));
    }
    user_file::write(&file, &packed).map_err(Failure::io)?;
    output::write(&format!("{}: {} bytes, sha256 = \"{}\"\n", file.display(), packed.len(), sha256(&packed)))
}
