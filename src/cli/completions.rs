//! `trackfail completions SHELL`: a script with which a shell completes the program's words.

use super::{Cli, Failure, output};
use clap::CommandFactory;
use clap_complete::Shell;

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The shell
    shell: Shell,
}

/// Runs the verb.
///
/// # Errors
/// When stdout cannot be written to.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "trackfail", &mut script);
    output::write(&String::from_utf8_lossy(&script))
}
