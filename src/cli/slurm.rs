//! `trackfail slurm SPEC... --shards N`: batch scripts that run experiments on a SLURM cluster.
//!
//! Writes an array of N jobs, a job that makes tables and report of what they computed, and a script
//! that submits both; with `--submit` does so itself. All paths must be on a file system that the
//! cluster's nodes share. Results are the bytes of a plain `trackfail run`.

mod estimate;
pub mod script;
pub mod value;

use super::{Failure, output, run::read_specs};
use crate::engine::store;
use crate::spec::Experiment;
use script::{ClusterRun, REPORT, SHARDS, SUBMIT};
use std::path::{Path, PathBuf};
use std::process::Command;
use value::{Setting, Word};

/// Arguments of `slurm`.
#[derive(Debug, Clone, clap::Args)]
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
    data_roots: super::DataRoots,
    /// File of programs that may be run as trackers, signals or detectors; TRACKFAIL_PLUGINS otherwise, else plugins.toml here
    #[arg(long, value_name = "FILE")]
    plugins: Option<PathBuf>,
    /// Give each task a results folder of its own and merge them at the end
    #[arg(long)]
    separate: bool,
    /// Go on without sequences that are not there; tables say how many were
    #[arg(long)]
    allow_missing: bool,
    /// Time limit of each job, at least 5 minutes
    #[arg(long, value_name = "TIME", default_value = "04:00:00", value_parser = Setting::time)]
    time: Setting,
    /// Memory of each job
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = Setting::memory)]
    memory: Setting,
    /// Cores of each job
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    cpus: u16,
    /// Partition to run in
    #[arg(long, value_name = "NAME", value_parser = Setting::partition)]
    partition: Option<Setting>,
    /// Account to charge
    #[arg(long, value_name = "NAME", value_parser = Setting::account)]
    account: Option<Setting>,
    /// Largest number of tasks that run at once; all without it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    throttle: Option<u16>,
    /// A further option of sbatch, such as --gres=gpu:1; may be given more than once
    #[arg(long = "sbatch-arg", value_name = "OPTION", allow_hyphen_values = true, value_parser = Word::sbatch_option)]
    sbatch: Vec<Word>,
    /// A command that every job runs first, such as `module load ffmpeg`; may be given more than once
    #[arg(long, value_name = "COMMAND", value_parser = Word::command)]
    before: Vec<Word>,
    /// Folder of the scripts, and of the jobs' logs
    #[arg(long, value_name = "FOLDER", default_value = "slurm")]
    output: PathBuf,
    /// Replace scripts that are there and differ
    #[arg(long)]
    force: bool,
    /// Submit the jobs too
    #[arg(long)]
    submit: bool,
}

/// Runs the verb. Experiments and data are checked before anything is written.
///
/// # Errors
/// `Usage` for a wrong experiment, a path that cannot stand in a script and scripts that are there, `Data` for data that is
/// missing, `Io` for what the file system or sbatch refuses.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (plan, experiments) = plan(args)?;
    let scripts =
        [(SHARDS, plan.shards_script()), (REPORT, plan.report_script()), (SUBMIT, plan.submit_script())];
    let folder = Path::new(plan.folder.text());
    let differs = |(name, text): &&(&str, String)| {
        let there = folder.join(name);
        there.symlink_metadata().is_ok() && std::fs::read(there).ok().is_none_or(|old| old != text.as_bytes())
    };
    if let Some((name, _)) = scripts.iter().find(differs).filter(|_| !args.force) {
        let path = folder.join(name);
        let message = format!("{} is there already, for other jobs; --force replaces it", path.display());
        return Err(Failure::usage(message));
    }
    let estimate = estimate::estimate(args, &experiments)?;
    for (name, text) in scripts {
        let path = folder.join(name);
        store::write(&path, text.as_bytes()).map_err(Failure::io)?;
    }
    if !args.submit {
        let folder = &plan.folder;
        return output::write(&format!(
            "scripts: {}\nsubmit:  sh {folder}/{SUBMIT}\ntime:    {estimate}\n",
            folder.text()
        ));
    }
    let shards = submit(&plan.sbatch_arguments(SHARDS, None)).map_err(Failure::io)?;
    let report = submit(&plan.sbatch_arguments(REPORT, Some(&shards))).map_err(|e| {
        Failure::io(format!("the array is in the queue as job {shards}, but its report is not: {e}"))
    })?;
    output::write(&format!("shards: job {shards}\nreport: job {report}\ntime:   {estimate}\n"))
}

/// Checks every argument that appears in a script.
fn plan(args: &Args) -> Result<(ClusterRun, Vec<Experiment>), Failure> {
    let data_roots = args.data_roots.folders()?;
    let catalog = super::catalog(&data_roots)?;
    let programs = super::programs(args.plugins.as_deref())?;
    let experiments = read_specs(&args.specs, &catalog, &programs)?;
    let mut specs = Vec::new();
    for name in &args.specs {
        let is_file = Path::new(name).is_file();
        specs.push(if is_file { absolute(Path::new(name))? } else { Word::new(name).map_err(usage)? });
    }
    let program = std::env::current_exe().map_err(|e| Failure::io(format!("path of this program: {e}")))?;
    let folder = std::path::absolute(&args.output).map_err(|e| unusable(&args.output, &e))?;
    let run = ClusterRun {
        program: Word::path(&program).map_err(usage)?,
        specs,
        shards: args.shards,
        throttle: args.throttle,
        results: absolute(&args.results)?,
        reports: absolute(&args.reports)?,
        data_roots: data_roots.iter().map(|root| absolute(root)).collect::<Result<_, _>>()?,
        plugins: super::plugins_file(args.plugins.as_deref()).as_deref().map(absolute).transpose()?,
        separate: args.separate,
        allow_missing: args.allow_missing,
        time: args.time.clone(),
        memory: args.memory.clone(),
        cpus: args.cpus,
        partition: args.partition.clone(),
        account: args.account.clone(),
        sbatch: args.sbatch.clone(),
        before: args.before.clone(),
        folder: Word::log_folder(&folder).map_err(usage)?,
    };
    Ok((run, experiments))
}

fn absolute(path: &Path) -> Result<Word, Failure> {
    let path = std::path::absolute(path).map_err(|e| unusable(path, &e))?;
    Word::path(&path).map_err(usage)
}

fn unusable(path: &Path, e: &std::io::Error) -> Failure {
    Failure::usage(format!("{:?}: {e}", path.display().to_string()))
}

fn usage(e: value::ValueError) -> Failure {
    Failure::usage(e.to_string())
}

/// Submits a script with sbatch; returns the job's number.
fn submit(arguments: &[String]) -> Result<String, String> {
    let output = Command::new("sbatch").args(arguments).output().map_err(|e| {
        format!("sbatch cannot be started ({e}); run {SUBMIT} on a machine that submits to the cluster")
    })?;
    let told = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("sbatch: {}: {}", output.status, told.trim()));
    }
    // On a federation the answer is `job;cluster`.
    let answer = String::from_utf8_lossy(&output.stdout);
    let job = answer.trim().split(';').next().unwrap_or_default();
    if job.is_empty() || !job.bytes().all(|b| b.is_ascii_digit()) {
        return Err(format!("sbatch gave no job number but {:?}", answer.trim()));
    }
    Ok(job.to_string())
}
