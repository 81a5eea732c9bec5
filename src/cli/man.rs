//! `trackfail man DIR`: a manual page for the program and for each verb.

use super::{Cli, Failure, output};
use clap::CommandFactory;
use std::path::PathBuf;

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder that the pages are written to, such as `~/.local/share/man/man1`
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// When there is no such folder, or it cannot be written to.
pub fn run(args: &Args) -> Result<(), Failure> {
    let folder = &args.folder;
    if !folder.is_dir() {
        return Err(Failure::io(format!("there is no folder {}; make it first", folder.display())));
    }
    let pages = clap_mangen::generate_to(Cli::command(), folder);
    pages.map_err(|e| Failure::io(format!("{}: {e}", folder.display())))?;
    output::write(&format!("pages: {}\n", folder.display()))
}
