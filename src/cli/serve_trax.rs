//! `trackfail serve-trax TRACKER`

use super::Failure;
use crate::plugin;
use crate::spec::error::Source;
use crate::tracker::TRACKERS;
use crate::tracker::process;
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

/// Runs the verb: a TraX server on stdin and stdout, until the client quits.
///
/// # Errors
/// `Usage` for a tracker or parameters that there are not, `Data` for an image that cannot be read, `Io`
/// for anything else that ends the session early.
pub fn run(args: &Args) -> Result<(), Failure> {
    let kinds = || TRACKERS.iter().map(|e| e.kind);
    let Some(entry) = plugin::find(TRACKERS, &args.tracker) else {
        return Err(Failure::Usage(plugin::unknown("tracker", &args.tracker, kinds())));
    };
    if entry.kind == process::ENTRY.kind {
        return Err(Failure::Usage("a program of one's own is not served; let the client start it".into()));
    }
    // Known before its own parameters are: those of such trackers mean nothing here.
    if entry.build_from_text(entry.example).is_ok_and(|example| example.needs_truth()) {
        let kind = entry.kind;
        return Err(Failure::Usage(format!(
            "`{kind}` answers from ground truth or result files of known sequences; it cannot follow a client's frames"
        )));
    }
    let setup = entry.build_from_text(&args.params).map_err(|e| {
        let source = Source { file: "--params", text: &args.params };
        Failure::Usage(source.error(e.span.unwrap_or(0..0), e.message).to_string())
    })?;
    let server = Server { name: entry.kind, description: entry.summary, setup: &*setup, seed: args.seed };
    server.serve(stdin().lock(), stdout().lock()).map_err(|e| match e {
        SessionError::Image(_) => Failure::Data(e.to_string()),
        e => Failure::Io(e.to_string()),
    })
}
