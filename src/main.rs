//! The `trackfail` program: pick the verb, run it, print one error, set the exit code.

use clap::Parser;
use std::io::Write;
use std::process::ExitCode;
use trackfail::cli::{Cli, Failure, output};

fn main() -> ExitCode {
    // A panic is a bug; it has been told, and its exit code is that of a bug.
    let Ok(outcome) = std::panic::catch_unwind(|| Cli::parse().run()) else { return ExitCode::from(1) };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // Nobody is left to tell when stderr is closed; the exit code still counts.
            let message = output::for_terminal(&failure.to_string());
            let _ = writeln!(std::io::stderr(), "error: {message}");
            ExitCode::from(Failure::code(&failure))
        }
    }
}
