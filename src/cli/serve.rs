//! `trackfail serve`: reports, and the progress of runs, in a browser on this machine.

use super::{Failure, output};
use crate::report::server::{Server, ServerError};
use std::path::PathBuf;

/// The port unless another is asked for.
pub const PORT: u16 = 8070;

/// Arguments of `serve`.
#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "Only programs on this machine can ask (127.0.0.1); from elsewhere, use a tunnel such as \
ssh -L 8070:127.0.0.1:8070 HOST. Nothing is written. Ctrl-C ends it, with exit code 0."
)]
pub struct Args {
    /// Folder of reports that is shown
    #[arg(long, value_name = "DIR", default_value = "reports")]
    reports: PathBuf,
    /// Results folder whose runs are shown while they go on
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Port on 127.0.0.1; 0 takes a free one
    #[arg(long, value_name = "N", default_value_t = PORT)]
    port: u16,
}

/// Runs the verb, until Ctrl-C.
///
/// # Errors
/// `Usage` when neither folder is there, `Io` when the port is not available.
pub fn run(args: &Args) -> Result<(), Failure> {
    let server = Server::listen(&args.reports, &args.results, args.port).map_err(|e| match e {
        ServerError::NoFolder { .. } => Failure::usage(e.to_string()),
        ServerError::Port { .. } => Failure::io(e.to_string()),
    })?;
    // The server has nothing to lose when it is ended. Without a handler the signals end the program as well.
    let _ = ctrlc::set_handler(|| std::process::exit(0));
    output::write(&format!("http://{}/\n", server.address()))?;
    output::note("Ctrl-C ends it");
    server.run()
}
