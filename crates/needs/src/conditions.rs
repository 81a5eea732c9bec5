//! Data and programs that tests may need, and whether they are on this machine.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Something that is not on every machine.
pub struct Need {
    /// Name in `#[needs(name)]`.
    pub name: &'static str,
    /// The thing to get, for the person who reads the list of tests that were not run.
    pub what: &'static str,
    /// True if it is on this machine.
    pub is_met: fn() -> bool,
}

/// Everything that a test may need.
pub const NEEDS: [Need; 12] = [
    Need {
        name: "real_data",
        what: "real data (set TRACKFAIL_DATA to a data root, or to a list of them)",
        is_met: || real_data().is_some(),
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
        name: "parallel",
        what: "GNU parallel (Debian: parallel)",
        is_met: || runs("parallel", &["--will-cite", "true", ":::", "1"]),
    },
    Need { name: "python", what: "python3", is_met: || runs("python3", &["-c", "import json"]) },
    Need {
        name: "pillow",
        what: "python3 with numpy and pillow (pip install -r tests/requirements.txt)",
        is_met: || runs("python3", &["-c", "import numpy, PIL"]),
    },
    Need {
        name: "opencv",
        what: "python3 with OpenCV's KCF and CSRT (pip install -r tests/requirements.txt)",
        is_met: || runs("python3", &["-c", "import cv2; cv2.TrackerKCF.create, cv2.TrackerCSRT.create"]),
    },
    Need {
        name: "vot_trax",
        what: "python3 with vot-trax (pip install -r tests/requirements.txt)",
        is_met: || runs("python3", &["-c", "import trax"]),
    },
    Need {
        name: "pyarrow",
        what: "python3 with pyarrow and duckdb (pip install -r tests/requirements.txt)",
        is_met: || runs("python3", &["-c", "import duckdb, pyarrow.dataset, pyarrow.parquet"]),
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

/// The real data that tests look at, each by its name below a data root; `list.txt` is VOT's list of names.
pub const REAL_DATA: [&str; 24] = [
    "otb/CarScale",
    "otb/Couple",
    "otb/Crossing",
    "otb/David",
    "otb/FaceOcc1",
    "otb/Girl",
    "otb/Jogging",
    "otb/MotorRolling",
    "otb/MountainBike",
    "otb/Subway",
    "otb/Woman",
    "vot2014/diving",
    "vot2014/drunk",
    "vot2014/gymnastics",
    "vot2014/jogging",
    "vot2014/list.txt",
    "vot2014/sphere",
    "vot2014/sunshade",
    "vot2014/surfing",
    "vot2014/tunnel",
    "pets2009/S2L1",
    "otb-annotations/OTB2013.json",
    "results/otb",
    "results/vot2014",
];

/// Where each of [`REAL_DATA`] is: in the first folder of the path list `TRACKFAIL_DATA` that has it, by default in
/// `../shared/data` beside the checkout. `None` when one is nowhere.
pub fn real_data() -> Option<[PathBuf; 24]> {
    let beside = || vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data")];
    let named = std::env::var_os("TRACKFAIL_DATA");
    let roots = named.map_or_else(beside, |named| std::env::split_paths(&named).collect());
    let place = |name: &str| roots.iter().map(|root| root.join(name)).find(|place| place.exists());
    let places: Vec<PathBuf> = REAL_DATA.iter().map_while(|name| place(name)).collect();
    places.try_into().ok()
}

fn is_on_path(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

/// True if a program can be started with some arguments and ends well.
pub fn runs(program: &str, arguments: &[&str]) -> bool {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// True if this process may mount file systems: on Linux, the capability CAP_SYS_ADMIN.
fn can_mount() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let effective = status.lines().find_map(|line| line.strip_prefix("CapEff:"));
    let bits = effective.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok()).unwrap_or(0);
    bits & (1 << 21) != 0
}
