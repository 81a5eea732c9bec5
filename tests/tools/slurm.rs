//! Helpers of the tests of batch scripts: a script, its words, and what a program has printed.

use crate::tools::trackfail;
use std::path::{Path, PathBuf};
use trackfail::cli::output::quoted;
use trackfail::cli::slurm::SCRIPT;

/// A name with everything that a shell or sbatch takes for something else.
pub const HOSTILE: &str = "it's \"$HOME\" `x` $(y) #SBATCH ; é *";

/// Writes the script for the quickstart and an experiment file in three shares, whose tasks start `program`; all is in
/// `root`, the script in its folder `slurm`.
pub fn script(root: &Path, program: &Path, results: &str, more: &[&str]) -> PathBuf {
    std::fs::create_dir_all(root.join("data")).unwrap();
    let quickstart = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/quickstart.toml");
    std::fs::copy(quickstart, root.join("a.toml")).unwrap();
    let mut command = trackfail();
    command.current_dir(root).args(["slurm", "quickstart", "a.toml", "--shards", "3", "--data-root", "data"]);
    command.args(["--results", results]).args(more).assert().success();
    let path = root.join("slurm").join(SCRIPT);
    let text = std::fs::read_to_string(&path).unwrap();
    let own = quoted(env!("CARGO_BIN_EXE_trackfail"));
    assert_eq!(text.matches(&own).count(), 2, "{text}");
    std::fs::write(&path, text.replace(&own, &quoted(program.to_str().unwrap()))).unwrap();
    path
}

/// The words of the program for a share of that script, or for the report.
pub fn expected(root: &Path, results: &str, share: Option<&str>) -> Vec<String> {
    let root = root.canonicalize().unwrap();
    let path = |name: &str| std::path::absolute(root.join(name)).unwrap().to_str().unwrap().to_string();
    let mut words =
        ["run", "quickstart", &path("a.toml"), "--results", &path(results)].map(String::from).to_vec();
    words.extend(["--jobs", "1", "--data-root", &path("data")].map(String::from));
    words.extend(match share {
        Some(share) => ["--shard".to_string(), format!("{share}/3")],
        None => ["--reports".to_string(), path("reports")],
    });
    words
}

/// The calls that were printed.
pub fn calls(printed: &[u8]) -> Vec<Vec<String>> {
    let text = std::str::from_utf8(printed).unwrap();
    let words = |call: &str| call.split_terminator('\0').map(str::to_string).collect();
    text.split_terminator('\u{1e}').map(words).collect()
}
