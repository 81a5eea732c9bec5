//! `trackfail slurm SPEC... --shards N`: a batch script that runs experiments on a SLURM cluster.
//!
//! The script is an array of N tasks, `trackfail run --shard I/N`, with a final job that makes tables and
//! report. Started by hand or by `--submit`, it submits both. All paths must be on a file system that the
//! nodes of the cluster share. The results have the same bytes as those of a plain `trackfail run`.

use super::run::{load, read_specs};
use super::{Failure, output, output::quoted};
use crate::engine::store;
use minijinja::value::Serde;
use minijinja::{Environment, context};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::Command;

/// File name of the script.
pub const SCRIPT: &str = "trackfail.sbatch";
/// Text of the script, with placeholders for the user's settings.
const TEMPLATE: &str = include_str!("slurm.sbatch");

/// Arguments of `slurm`.
#[derive(Debug, Serialize, clap::Args)]
pub struct Args {
    /// Experiment files, or names of built-in experiments (see `trackfail list experiments`)
    #[arg(value_name = "SPEC", required = true)]
    specs: Vec<String>,
    // 1000 is the largest index of an array unless a cluster's MaxArraySize says otherwise.
    /// Tasks that the cells are shared out to, 1 to 1000
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    shards: u16,
    /// Folder that results are written to
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Folder that reports are written to
    #[arg(long, value_name = "DIR", default_value = "reports")]
    reports: PathBuf,
    #[command(flatten)]
    #[serde(skip)]
    data_roots: super::DataRoots,
    /// File of programs that may be run as trackers, signals or detectors; TRACKFAIL_PLUGINS otherwise, else plugins.toml here
    #[arg(long, value_name = "FILE")]
    plugins: Option<PathBuf>,
    /// Go on without sequences that are not there; tables say how many were
    #[arg(long)]
    allow_missing: bool,
    /// Time limit of each job, as sbatch takes it; jobs are told to stop 2 minutes before its end
    #[arg(long, value_name = "TIME", default_value = "04:00:00", value_parser = setting)]
    time: String,
    /// Memory of each job
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = setting)]
    memory: String,
    /// Cores of each job
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    cpus: u16,
    /// Partition to run in
    #[arg(long, value_name = "NAME", value_parser = setting)]
    partition: Option<String>,
    /// A further line of the script, such as "#SBATCH --gres=gpu:1", or a command that every job runs first, such as
    /// "module load ffmpeg"; may be given more than once
    #[arg(long = "line", value_name = "LINE", value_parser = line)]
    lines: Vec<String>,
    /// Folder of the script, and of the jobs' logs
    #[arg(long, value_name = "FOLDER", default_value = "slurm")]
    output: PathBuf,
    /// Submit the jobs too
    #[arg(long)]
    submit: bool,
}

/// Writes the script, and submits it on request. Experiments and data are checked before anything is written.
///
/// # Errors
/// `Usage` for a wrong experiment or a path that cannot stand in a script, `Data` for missing data, `Io` for
/// errors of the file system or sbatch.
pub fn run(args: &Args) -> Result<(), Failure> {
    let roots = args.data_roots.folders()?;
    let programs = super::programs(args.plugins.as_deref())?;
    for experiment in read_specs(&args.specs, &super::catalog(&roots)?, &programs)? {
        load(&experiment, &roots, args.allow_missing)?;
    }
    let spec = |name: &String| if Path::new(name).is_file() { path(name) } else { Ok(quoted(name)) };
    let program = std::env::current_exe().map_err(|e| Failure::io(format!("path of this program: {e}")))?;
    let folder = absolute(&args.output)?;
    if folder.contains(['%', '\\']) {
        return Err(Failure::usage(format!("{folder}: SLURM expands `%` and `\\`; name another --output")));
    }
    let script = Path::new(&folder).join(SCRIPT);
    let about = context! {
        program => path(&program)?,
        specs => args.specs.iter().map(spec).collect::<Result<Vec<_>, _>>()?,
        results => path(&args.results)?,
        reports => path(&args.reports)?,
        data_roots => roots.iter().map(path).collect::<Result<Vec<_>, _>>()?,
        plugins => super::plugins_file(args.plugins.as_deref()).map(path).transpose()?,
        folder => quoted(&folder),
        script => path(&script)?,
        ..Serde(args)
    };
    let text = Environment::new().render_str(TEMPLATE, about).map_err(Failure::io)? + "\n";
    store::write(&script, text.as_bytes()).map_err(Failure::io)?;
    if !args.submit {
        return output::write(&format!("script: {}\nsubmit: sh {}\n", script.display(), path(&script)?));
    }
    let status = Command::new("/bin/sh").arg(&script).status();
    match status.map_err(|e| Failure::io(format!("/bin/sh: {e}")))? {
        status if status.success() => Ok(()),
        status => Err(Failure::io(format!("{}: {status}; not all is submitted", script.display()))),
    }
}

/// Value of an `#SBATCH` line. sbatch has rules of its own for quotes, blanks and `#`.
fn setting(text: &str) -> Result<String, String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_.,:-".contains(c);
    let want = "want letters, digits, `_`, `.`, `,`, `:` and `-`";
    if text.is_empty() || !text.chars().all(is_plain) { Err(want.into()) } else { Ok(text.into()) }
}

/// Checks a line from the user: a single line that does not set what the script sets already.
fn line(text: &str) -> Result<String, String> {
    const LONG: [&str; 6] = ["--array", "--chdir", "--dependency", "--job-name", "--output", "--signal"];
    const SHORT: [&str; 5] = ["-a", "-D", "-d", "-J", "-o"];
    let line = text.trim_start();
    let option = line.strip_prefix("#SBATCH").map(str::trim_start).unwrap_or_default();
    let option = option.split(|c: char| c == '=' || c.is_whitespace()).next().unwrap_or_default();
    // The value of a short option may follow at once: `-a1-3`.
    let short = || SHORT.into_iter().find(|short| option.starts_with(*short));
    match LONG.into_iter().find(|long| *long == option).or_else(short) {
        _ if text.chars().any(char::is_control) => Err("want one line, without control characters".into()),
        Some(taken) => Err(format!("the script sets {taken} itself")),
        None => Ok(line.into()),
    }
}

/// Path as a word of the script.
fn path(path: impl AsRef<Path>) -> Result<String, Failure> {
    Ok(quoted(&absolute(path.as_ref())?))
}

fn absolute(path: &Path) -> Result<String, Failure> {
    let whole = std::path::absolute(path).map_err(|e| Failure::usage(format!("{path:?}: {e}")))?;
    let text = whole.into_os_string().into_string();
    text.map_err(|text| Failure::usage(format!("{}: the name is not UTF-8; rename it", text.display())))
}
