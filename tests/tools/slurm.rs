//! Helpers of the tests of batch scripts: a plan, its words, and a program that prints or records them.

use std::path::Path;
use std::process::Command;
use trackfail::cli::slurm::script::ClusterRun;
use trackfail::cli::slurm::value::{Setting, Word};

/// A name with everything that a shell or sbatch takes for something else.
pub const HOSTILE: &str = "it's \"$HOME\" `x` $(y) #SBATCH ; é *";

pub fn word(text: &str) -> Word {
    Word::new(text).unwrap()
}

pub fn path(path: &Path) -> Word {
    Word::path(path).unwrap()
}

pub fn plan(program: &Path, root: &str) -> ClusterRun {
    ClusterRun {
        program: path(program),
        specs: vec![word("quickstart"), word(&format!("{root}/a.toml"))],
        shards: 3,
        throttle: None,
        results: word(&format!("{root}/results")),
        reports: word(&format!("{root}/reports")),
        plugins: None,
        data_roots: vec![word(&format!("{root}/data"))],
        separate: false,
        allow_missing: false,
        time: Setting::time("00:05:00").unwrap(),
        memory: Setting::memory("500M").unwrap(),
        cpus: 1,
        partition: None,
        account: None,
        sbatch: Vec::new(),
        before: Vec::new(),
        folder: word(&format!("{root}/slurm")),
    }
}

/// The words of the program for a share, or for the report.
pub fn expected(plan: &ClusterRun, share: Option<&str>) -> Vec<String> {
    let mut words = vec!["run".to_string()];
    words.extend(plan.specs.iter().map(|s| s.text().to_string()));
    words.extend(share.iter().flat_map(|i| ["--shard".to_string(), format!("{i}/{}", plan.shards)]));
    let results = plan.results.text();
    words.push("--results".to_string());
    words.push(match share {
        Some(i) if plan.separate => format!("{results}/shards/{i}"),
        _ => results.to_string(),
    });
    if share.is_none() {
        words.extend(["--reports".to_string(), plan.reports.text().to_string()]);
    }
    words.extend(plan.data_roots.iter().flat_map(|d| ["--data-root".to_string(), d.text().to_string()]));
    words.extend(["--jobs".to_string(), plan.cpus.to_string()]);
    words
}

/// A program made of shell commands. It is put in place by another process: a file that this one has
/// open for writing, if only in a child that another thread just forked, cannot be started.
pub fn executable(path: &Path, commands: &str) {
    let source = path.with_extension("source");
    std::fs::write(&source, format!("#!/bin/sh\n{commands}\n")).unwrap();
    let done = Command::new("install").args(["-m", "755"]).arg(&source).arg(path).status().unwrap();
    assert!(done.success());
}

/// The calls that were printed.
pub fn calls(printed: &[u8]) -> Vec<Vec<String>> {
    let text = std::str::from_utf8(printed).unwrap();
    let words = |call: &str| call.split_terminator('\0').map(str::to_string).collect();
    text.split_terminator('\u{1e}').map(words).collect()
}
