//! The texts of the batch scripts: the same plan gives the same bytes.
//!
//! `shards.sbatch` is an array; task I becomes `trackfail run --shard I/N`. `exec` puts the program in
//! the place of the batch shell, the process that `--signal=B:TERM` reaches. `report.sbatch`
//! runs the experiments again over the finished cells. It waits for the array by `afterany`: a task
//! with failed cells ends with exit code 4 and a task that ran out of time with 130, and after both
//! there is a report to write; `afterok` would wait for ever.
//!
//! Paths appear only where the shell reads them, in quotes. The working directory, and so the folder of
//! the logs, is an argument of sbatch.

use super::value::{NOTICE, Setting, Word};
use std::fmt::Write;

/// Name of the array's script in its folder.
pub const SHARDS: &str = "shards.sbatch";
/// Name of the report's script.
pub const REPORT: &str = "report.sbatch";
/// Name of the script that submits both.
pub const SUBMIT: &str = "submit.sh";

/// Experiments to run, with their folders and resources. All paths are absolute.
#[derive(Debug, Clone)]
pub struct ClusterRun {
    /// The program.
    pub program: Word,
    /// Experiment files, or names of built-in experiments.
    pub specs: Vec<Word>,
    /// Tasks of the array, at least 1.
    pub shards: u16,
    /// Largest number of tasks that run at once, unless all may.
    pub throttle: Option<u16>,
    /// Folder of results.
    pub results: Word,
    /// Folder of reports.
    pub reports: Word,
    /// Folders of real sequences.
    pub data_roots: Vec<Word>,
    /// File of programs that may be run as trackers.
    pub plugins: Option<Word>,
    /// Whether each task has a results folder of its own, `<results>/shards/<I>`.
    pub separate: bool,
    /// Whether to go on without sequences that are not there.
    pub allow_missing: bool,
    /// Time limit of each job.
    pub time: Setting,
    /// Memory of each job.
    pub memory: Setting,
    /// Cores, and worker threads, of each job.
    pub cpus: u16,
    /// Partition, unless the cluster's default.
    pub partition: Option<Setting>,
    /// Account, unless the user's default.
    pub account: Option<Setting>,
    /// Further arguments of sbatch, for both jobs.
    pub sbatch: Vec<Word>,
    /// Commands that both jobs run first, as they are.
    pub before: Vec<Word>,
    /// Folder of the scripts and logs; the jobs' working directory.
    pub folder: Word,
}

impl ClusterRun {
    /// The text of [`SHARDS`].
    pub fn shards_script(&self) -> String {
        let n = self.shards;
        let note = [
            format!(
                "Each task computes one of {n} shares of the cells and keeps them in the results folder."
            ),
            format!("It is told to stop {NOTICE} s before its time is up, keeps what it has and exits 130."),
            format!("To resume after any loss, run {SUBMIT} again: finished cells are not computed twice."),
        ];
        let at_once = self.throttle.map_or_else(String::new, |most| format!("%{most}"));
        let array = format!("--array=1-{n}{at_once}");
        let mut text = self.head(&note, &[&array, "--job-name=trackfail-shards", "--output=shard-%A_%a.log"]);
        let results = if self.separate {
            format!("{}/\"$SLURM_ARRAY_TASK_ID\"", self.shard_folders())
        } else {
            self.results.to_string()
        };
        text.push_str(
            &self.run(&[format!("--shard \"$SLURM_ARRAY_TASK_ID\"/{n}"), format!("--results {results}")]),
        );
        text
    }

    /// The text of [`REPORT`].
    pub fn report_script(&self) -> String {
        let note = [
            "Tables and report, once no task of the array is left. Tables mark cells that failed; cells"
                .into(),
            "of a task that was stopped are computed here, so nothing is missing. To stop everything,".into(),
            format!("cancel this job with the array; to resume, run {SUBMIT} again."),
        ];
        let mut text = self.head(&note, &["--job-name=trackfail-report", "--output=report-%j.log"]);
        if self.separate {
            text.push_str(&self.merge());
        }
        let folders = [format!("--results {}", self.results), format!("--reports {}", self.reports)];
        text.push_str(&self.run(&folders));
        text
    }

    /// The text of [`SUBMIT`].
    pub fn submit_script(&self) -> String {
        let own: String = self.sbatch.iter().map(|word| format!(" {word}")).collect();
        let command = |more: &str, script: &str| {
            format!("sbatch --parsable --chdir={}{own}{more} {}/{script}", self.folder, self.folder)
        };
        // On a federation sbatch answers `job;cluster`.
        format!(
            "#!/bin/sh\n\
             # Submits the array and, behind it, the report.\n\
             set -eu\n\
             shards=$({})\n\
             shards=${{shards%%;*}}\n\
             printf 'shards: job %s\\n' \"$shards\"\n\
             report=$({})\n\
             printf 'report: job %s\\n' \"${{report%%;*}}\"\n",
            command("", SHARDS),
            command(" --dependency=afterany:\"$shards\"", REPORT),
        )
    }

    /// Arguments of sbatch for one of the scripts; it waits for another job if one is given.
    pub fn sbatch_arguments(&self, script: &str, after: Option<&str>) -> Vec<String> {
        let folder = self.folder.text();
        let mut arguments = vec!["--parsable".to_string(), format!("--chdir={folder}")];
        arguments.extend(self.sbatch.iter().map(|word| word.text().to_string()));
        arguments.extend(after.map(|job| format!("--dependency=afterany:{job}")));
        arguments.push(format!("{folder}/{script}"));
        arguments
    }

    /// Everything down to `set -eu`. sbatch reads its lines only above the first command.
    ///
    /// Clusters define `module` and its kin for bash, and not all of them bear unset variables.
    fn head(&self, note: &[String], own: &[&str]) -> String {
        let mut text = if self.before.is_empty() { "#!/bin/sh\n" } else { "#!/bin/bash\n" }.to_string();
        for line in note {
            push_line(&mut text, format_args!("# {line}"));
        }
        for option in own {
            push_line(&mut text, format_args!("#SBATCH {option}"));
        }
        // A job that is put back in the queue, as after the loss of its node, goes on with its log.
        push_line(&mut text, format_args!("#SBATCH --open-mode=append"));
        push_line(&mut text, format_args!("#SBATCH --requeue"));
        push_line(&mut text, format_args!("#SBATCH --signal=B:TERM@{NOTICE}"));
        push_line(&mut text, format_args!("#SBATCH --time={}", self.time));
        push_line(&mut text, format_args!("#SBATCH --ntasks=1"));
        push_line(&mut text, format_args!("#SBATCH --cpus-per-task={}", self.cpus));
        push_line(&mut text, format_args!("#SBATCH --mem={}", self.memory));
        if let Some(partition) = &self.partition {
            push_line(&mut text, format_args!("#SBATCH --partition={partition}"));
        }
        if let Some(account) = &self.account {
            push_line(&mut text, format_args!("#SBATCH --account={account}"));
        }
        if !self.before.is_empty() {
            push_line(&mut text, format_args!("set -e"));
        }
        for command in &self.before {
            push_line(&mut text, format_args!("{}", command.text()));
        }
        text.push_str("set -eu\n");
        text
    }

    /// The last line of a script: the call of the program.
    fn run(&self, more: &[String]) -> String {
        let mut lines = vec![format!("exec {} run", self.program)];
        lines.extend(self.specs.iter().map(Word::to_string));
        lines.extend_from_slice(more);
        lines.extend(self.data_roots.iter().map(|root| format!("--data-root {root}")));
        lines.extend(self.plugins.as_ref().map(|file| format!("--plugins {file}")));
        lines.extend(self.allow_missing.then(|| "--allow-missing".to_string()));
        lines.push(format!("--jobs {}", self.cpus));
        lines.join(" \\\n    ") + "\n"
    }

    /// Merges the stores of the tasks; a task that never started has none.
    fn merge(&self) -> String {
        format!(
            "shard=1\n\
             set --\n\
             while [ \"$shard\" -le {} ]; do\n\
             \x20   folder={}/$shard\n\
             \x20   if [ -d \"$folder/.store\" ]; then set -- \"$@\" \"$folder\"; fi\n\
             \x20   shard=$((shard + 1))\n\
             done\n\
             if [ \"$#\" -gt 0 ]; then {} merge \"$@\" --results {}; fi\n",
            self.shards,
            self.shard_folders(),
            self.program,
            self.results,
        )
    }

    fn shard_folders(&self) -> String {
        format!("{}/shards", self.results)
    }
}

fn push_line(text: &mut String, line: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(text: &str) -> Word {
        Word::new(text).unwrap()
    }

    fn plan() -> ClusterRun {
        ClusterRun {
            program: word("/opt/trackfail"),
            specs: vec![word("quickstart"), word("/home/ann/it's mine.toml")],
            shards: 3,
            throttle: None,
            results: word("/scratch/ann/results"),
            reports: word("/scratch/ann/reports"),
            data_roots: vec![word("/data")],
            plugins: Some(word("/home/ann/plugins.toml")),
            separate: false,
            allow_missing: false,
            time: Setting::time("04:00:00").unwrap(),
            memory: Setting::memory("2G").unwrap(),
            cpus: 2,
            partition: Some(Setting::partition("short,long").unwrap()),
            account: Some(Setting::account("vision").unwrap()),
            sbatch: Vec::new(),
            before: Vec::new(),
            folder: word("/home/ann/jobs"),
        }
    }

    fn bare() -> ClusterRun {
        ClusterRun {
            specs: vec![word("quickstart")],
            separate: true,
            allow_missing: true,
            data_roots: Vec::new(),
            plugins: None,
            partition: None,
            account: None,
            cpus: 1,
            ..plan()
        }
    }

    /// Lines that both jobs share.
    const COMMON: &str = r#"#SBATCH --open-mode=append
#SBATCH --requeue
#SBATCH --signal=B:TERM@120
#SBATCH --time=04:00:00
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=2
#SBATCH --mem=2G
#SBATCH --partition=short,long
#SBATCH --account=vision
set -eu
exec '/opt/trackfail' run \
    'quickstart' \
    '/home/ann/it'\''s mine.toml' \
"#;

    const SHARDS_TEXT: &str = r#"#!/bin/sh
# Each task computes one of 3 shares of the cells and keeps them in the results folder.
# It is told to stop 120 s before its time is up, keeps what it has and exits 130.
# To resume after any loss, run submit.sh again: finished cells are not computed twice.
#SBATCH --array=1-3
#SBATCH --job-name=trackfail-shards
#SBATCH --output=shard-%A_%a.log
COMMON
    --shard "$SLURM_ARRAY_TASK_ID"/3 \
    --results '/scratch/ann/results' \
    --data-root '/data' \
    --plugins '/home/ann/plugins.toml' \
    --jobs 2
"#;

    const REPORT_TEXT: &str = r#"#!/bin/sh
# Tables and report, once no task of the array is left. Tables mark cells that failed; cells
# of a task that was stopped are computed here, so nothing is missing. To stop everything,
# cancel this job with the array; to resume, run submit.sh again.
#SBATCH --job-name=trackfail-report
#SBATCH --output=report-%j.log
COMMON
    --results '/scratch/ann/results' \
    --reports '/scratch/ann/reports' \
    --data-root '/data' \
    --plugins '/home/ann/plugins.toml' \
    --jobs 2
"#;

    const SUBMIT_TEXT: &str = r#"#!/bin/sh
# Submits the array and, behind it, the report.
set -eu
shards=$(sbatch --parsable --chdir='/home/ann/jobs' '/home/ann/jobs'/shards.sbatch)
shards=${shards%%;*}
printf 'shards: job %s\n' "$shards"
report=$(sbatch --parsable --chdir='/home/ann/jobs' --dependency=afterany:"$shards" '/home/ann/jobs'/report.sbatch)
printf 'report: job %s\n' "${report%%;*}"
"#;

    #[test]
    fn scripts_are_these() {
        assert_eq!(plan().shards_script(), SHARDS_TEXT.replace("COMMON\n", COMMON));
        assert_eq!(plan().report_script(), REPORT_TEXT.replace("COMMON\n", COMMON));
        assert_eq!(plan().submit_script(), SUBMIT_TEXT);
    }

    #[test]
    fn what_a_cluster_wants_besides_is_in_both_jobs() {
        let more = ClusterRun {
            throttle: Some(2),
            sbatch: vec![word("--constraint=a|b"), word("--comment=it's mine")],
            before: vec![word("module load ffmpeg/6"), word("source \"$HOME/env\"")],
            ..plan()
        };
        let before =
            "#SBATCH --account=vision\nset -e\nmodule load ffmpeg/6\nsource \"$HOME/env\"\nset -eu\nexec ";
        for script in [more.shards_script(), more.report_script()] {
            assert!(script.starts_with("#!/bin/bash\n") && script.contains(before), "{script}");
        }
        assert!(more.shards_script().contains("#SBATCH --array=1-3%2\n"));
        let words = r"--chdir='/home/ann/jobs' '--constraint=a|b' '--comment=it'\''s mine'";
        assert_eq!(more.submit_script().matches(words).count(), 2, "{}", more.submit_script());
        let arguments = more.sbatch_arguments(REPORT, Some("7"));
        assert_eq!(arguments[2..5], ["--constraint=a|b", "--comment=it's mine", "--dependency=afterany:7"]);
    }

    const SEPARATE_TEXT: &str = r#"set -eu
shard=1
set --
while [ "$shard" -le 3 ]; do
    folder='/scratch/ann/results'/shards/$shard
    if [ -d "$folder/.store" ]; then set -- "$@" "$folder"; fi
    shard=$((shard + 1))
done
if [ "$#" -gt 0 ]; then '/opt/trackfail' merge "$@" --results '/scratch/ann/results'; fi
exec '/opt/trackfail' run \
    'quickstart' \
    --results '/scratch/ann/results' \
    --reports '/scratch/ann/reports' \
    --allow-missing \
    --jobs 1
"#;

    #[test]
    fn separate_shards_are_merged_before_the_report() {
        let report = bare().report_script();
        assert!(
            report.ends_with(&format!("#SBATCH --cpus-per-task=1\n#SBATCH --mem=2G\n{SEPARATE_TEXT}")),
            "{report}"
        );
        let shards = bare().shards_script();
        let own = "    --results '/scratch/ann/results'/shards/\"$SLURM_ARRAY_TASK_ID\" \\\n";
        assert!(shards.contains(own), "{shards}");
    }
}
