//! The `trackfail` program: pick the verb, run it, print one error, set the exit code.

use clap::Parser;
use std::io::Write;
use std::process::ExitCode;
use trackfail::cli::{Cli, Failure};

fn main() -> ExitCode {
    let outcome = Cli::parse().run();
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // Nobody is left to tell when stderr is closed; the exit code still counts.
            let _ = writeln!(std::io::stderr(), "error: {failure}");
            ExitCode::from(Failure::code(&failure))
        }
    }
}
