//! The `trackfail` program: pick the verb, run it, print one error, set the exit code.

use clap::Parser;
use std::io::Write;
use std::process::ExitCode;
use trackfail::cli::{Cli, Failure, output};

fn main() -> ExitCode {
    // A panic is a bug. Its hook has printed it; the exit code is that of a bug.
    let Ok(outcome) = std::panic::catch_unwind(|| Cli::parse().run()) else { return ExitCode::from(1) };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // If stderr is closed the message is lost; the exit code still counts.
            let message = output::for_terminal(&failure.to_string());
            let _ = writeln!(std::io::stderr(), "error: {message}");
            ExitCode::from(Failure::code(&failure))
        }
    }
}
