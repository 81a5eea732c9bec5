//! The `trackfail` program: picks the verb, runs it, prints the first error, sets the exit code.

use clap::Parser;
use std::io::Write;
use std::process::ExitCode;
use trackfail::cli::{Cli, Failure, output, with_nearest_verb};
use trackfail::dataset::guarded;

fn main() -> ExitCode {
    guarded::serve_if_asked();
    // A panic is a bug. Its hook has printed it; the exit code is that of a bug.
    let Ok(outcome) = std::panic::catch_unwind(run) else { return ExitCode::from(1) };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => ExitCode::from(failure.tell()),
    }
}

/// Runs the verb. Help and version go to stdout like other output; failing to write them is an error.
fn run() -> Result<(), Failure> {
    match Cli::try_parse() {
        Ok(cli) => cli.run(),
        Err(e) if e.use_stderr() => with_nearest_verb(e).exit(),
        Err(text) => output::written(text.print().and_then(|()| std::io::stdout().flush())),
    }
}
