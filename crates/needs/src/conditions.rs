//! Data and programs that tests may need, and whether they are on this machine.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Something that is not on every machine.
pub struct Need {
    /// Name in `#[needs(name)]`.
    pub name: &'static str,
    /// The thing to get, for the person who reads the list of tests that were not run.
    pub what: &'static str,
    /// Whether it is on this machine.
    pub is_met: fn() -> bool,
}

/// Everything that a test may need.
pub const NEEDS: [Need; 8] = [
    Need {
        name: "real_data",
        what: "real data (set TRACKFAIL_DATA to a data root, or to a list of them)",
        is_met: || data_root().is_some(),
    },
    Need { name: "ffmpeg", what: "ffmpeg", is_met: || is_on_path("ffmpeg") },
    Need {
        name: "chromium",
        what: "chromium",
        is_met: || BROWSERS.iter().any(|name| runs(name, &["--version"])),
    },
    Need {
        name: "slurm",
        what: "munged, slurmctld, slurmd and sbatch (Debian: slurm-wlm and munge)",
        is_met: || ["munged", "slurmctld", "slurmd", "sbatch"].into_iter().all(is_on_path),
    },
    Need {
        name: "pillow",
        what: "python3 with numpy and pillow (pip install -r tests/requirements.txt)",
        is_met: || runs("python3", &["-c", "import numpy, PIL"]),
    },
    Need {
        name: "vot_trax",
        what: "python3 with vot-trax (pip install -r tests/requirements.txt)",
        is_met: || runs("python3", &["-c", "import trax"]),
    },
    Need {
        name: "latex",
        what: "tectonic, pdflatex or xelatex",
        is_met: || LATEX.iter().any(|name| runs(name, &["--version"])),
    },
    Need { name: "mount", what: "the right to mount a file system", is_met: can_mount },
];

/// Names under which Chromium is installed, the first one that runs is taken.
pub const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Programs that make a PDF of a LaTeX file, the first one that runs is taken.
pub const LATEX: [&str; 3] = ["tectonic", "pdflatex", "xelatex"];

/// The first folder of real sequences: that of `TRACKFAIL_DATA`, else `../shared/data` beside the checkout; `None` when
/// there is no such folder.
pub fn data_root() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let named = std::env::var_os("TRACKFAIL_DATA");
    let first = named.map_or_else(|| Some(beside()), |named| std::env::split_paths(&named).next());
    first.filter(|root| root.is_dir())
}

fn is_on_path(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

/// Whether a program can be started with some arguments and ends well.
pub fn runs(program: &str, arguments: &[&str]) -> bool {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// Whether this process may mount file systems: on Linux, the capability CAP_SYS_ADMIN.
fn can_mount() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let effective = status.lines().find_map(|line| line.strip_prefix("CapEff:"));
    let bits = effective.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok()).unwrap_or(0);
    bits & (1 << 21) != 0
}
