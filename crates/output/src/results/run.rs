//! `run.json`: facts that vary from run to run. No table, figure, page or address depends on the file, and it
//! is not committed.

use serde::{Deserialize, Serialize};

/// Name of the file.
pub const FILE: &str = "run.json";

/// Facts about how and where results were computed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Git revision that the program was built from; `None` outside a repository.
    pub revision: Option<String>,
    /// Machine of the run.
    pub host: Host,
    /// Seconds from start to end of the run, without rendering the report.
    pub wall_seconds: f64,
}

/// Machine on which a run was made.
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
    /// Record of a run on this machine.
    pub fn here(revision: Option<&str>, wall_seconds: f64) -> Self {
        let host = Host {
            os: std::env::consts::OS.to_string(),
            architecture: std::env::consts::ARCH.to_string(),
            processors: std::thread::available_parallelism().map_or(1, usize::from),
        };
        Self { revision: revision.map(str::to_string), host, wall_seconds }
    }
}
