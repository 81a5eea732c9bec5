//! `run.json`: what differs from run to run. It is about the run and not about its results: no table, figure or page
//! shows it, no address is made from it, and it is not committed.

use serde::{Deserialize, Serialize};

/// The file.
pub const FILE: &str = "run.json";

/// How and where results were computed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Git revision that the program was built from; none outside a repository.
    pub revision: Option<String>,
    /// The machine.
    pub host: Host,
    /// Seconds from start to end of the run, without rendering.
    pub wall_seconds: f64,
}

/// The machine that a run was made on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Host {
    /// Operating system.
    pub os: String,
    /// Processor architecture.
    pub architecture: String,
    /// Number of processors.
    pub processors: usize,
}

impl RunRecord {
    /// The record of a run on this machine.
    pub fn here(revision: Option<&str>, wall_seconds: f64) -> Self {
        let host = Host {
            os: std::env::consts::OS.to_string(),
            architecture: std::env::consts::ARCH.to_string(),
            processors: std::thread::available_parallelism().map_or(1, usize::from),
        };
        Self { revision: revision.map(str::to_string), host, wall_seconds }
    }
}
