//! `trackfail serve-trax TRACKER`: serves a built-in tracker by the TraX protocol.

use super::Failure;
use super::live::live_tracker;
use crate::tracker::trax::server::{Server, SessionError};
use std::io::{stdin, stdout};

/// Arguments of `serve-trax`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Kind of tracker (see `trackfail list trackers`)
    #[arg(value_name = "TRACKER")]
    tracker: String,
    /// Its parameters as a TOML table, as in `{ search = 20 }`
    #[arg(long, value_name = "TABLE", default_value = "{}")]
    params: String,
    /// Seed of trackers that draw random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

/// Serves TraX on stdin and stdout, until the client quits.
///
/// # Errors
/// `Usage` for an unknown tracker or wrong parameters, `Data` for an image that cannot be read, `Io` for
/// other errors that end the session early.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (entry, config) = live_tracker(&args.tracker, &args.params)?;
    let server = Server { name: entry.kind, description: entry.summary, config: &*config, seed: args.seed };
    server.serve(stdin().lock(), stdout().lock()).map_err(|e| match e {
        SessionError::Image(_) => Failure::data(e.to_string()),
        e => Failure::io(e.to_string()),
    })
}
