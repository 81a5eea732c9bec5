//! Batch scripts: the words that reach the program, and the calls of sbatch.

#[path = "../tools/slurm.rs"]
mod scripts;

use crate::tools::trackfail;
use proptest::prelude::*;
use scripts::{HOSTILE, calls, executable, expected, plan};
use std::path::Path;
use std::process::{Command, Output};
use trackfail::cli::slurm::script::{ClusterRun, REPORT, SHARDS, SUBMIT};

/// Shell function that prints its arguments, each followed by a NUL, and a mark at the end of the call.
const PRINT_CALL: &str = r#"printf '%s\0' "$@"; printf '\036'"#;

/// The calls of the program by a script that a shell runs as a task of the array.
fn run_script(shell: &str, script: &str) -> Vec<Vec<String>> {
    let task = |command: &mut Command| command.env("SLURM_ARRAY_TASK_ID", "2").output().unwrap();
    let output = task(Command::new(shell).args(["-c", script]));
    assert!(output.status.success(), "{script}\n{}", String::from_utf8_lossy(&output.stderr));
    calls(&output.stdout)
}

fn hostile_path() -> impl Strategy<Value = String> {
    let special = "/[- a'\"$`\\\\!*?;&|<>()#~{}%=\\[\\]]{1,20}";
    prop_oneof![special, "/\\PC{1,30}"]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn every_word_reaches_the_program_as_it_is(root in hostile_path(), separate: bool) {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join(HOSTILE);
        executable(&program, PRINT_CALL);
        let plan = ClusterRun { separate, ..plan(&program, &root) };
        for shell in ["sh", "bash"] {
            let shards = run_script(shell, &plan.shards_script());
            prop_assert_eq!(shards, vec![expected(&plan, Some("2"))]);
            let report = run_script(shell, &plan.report_script());
            prop_assert_eq!(report, vec![expected(&plan, None)]);
        }
    }
}

#[test]
fn the_report_merges_the_stores_that_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("program");
    executable(&program, PRINT_CALL);
    let root = folder.path().join(HOSTILE);
    let plan = ClusterRun { separate: true, ..plan(&program, root.to_str().unwrap()) };
    let results = plan.results.text();
    for shard in [1, 3] {
        std::fs::create_dir_all(format!("{results}/shards/{shard}/.store")).unwrap();
    }
    std::fs::create_dir_all(format!("{results}/shards/2")).unwrap();
    let merge =
        ["merge", &format!("{results}/shards/1"), &format!("{results}/shards/3"), "--results", results];
    let report = run_script("sh", &plan.report_script());
    assert_eq!(report, [merge.map(str::to_string).to_vec(), expected(&plan, None)]);

    // Stores that cannot be joined are not reported on as if they were.
    executable(&program, r#"[ "$1" != merge ] || exit 1; echo reported"#);
    let output = Command::new("sh").args(["-c", &plan.report_script()]).output().unwrap();
    assert_eq!((output.status.code(), output.stdout), (Some(1), Vec::new()));
}

#[test]
fn a_script_that_is_no_task_of_an_array_does_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("program");
    executable(&program, PRINT_CALL);
    let script = plan(&program, "/nowhere").shards_script();
    let output = Command::new("sh").args(["-c", &script]).env_remove("SLURM_ARRAY_TASK_ID").output().unwrap();
    assert!(!output.status.success() && output.stdout.is_empty());
}

/// `trackfail slurm quickstart --shards 3` in `root`, with an sbatch of these commands.
fn slurm(root: &Path, sbatch: Option<&str>, more: &[&str]) -> Output {
    let bin = root.join("bin");
    std::fs::create_dir_all(&bin).unwrap();
    if let Some(commands) = sbatch {
        executable(&bin.join("sbatch"), commands);
    }
    let mut command = trackfail();
    command.current_dir(root).env("PATH", &bin).env("RECORD", root.join("record"));
    command.args(["slurm", "quickstart", "--shards", "3"]).args(more).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

const RECORD_CALL: &str = r#"{ printf '%s\0' "$@"; printf '\036'; } >> "$RECORD"; echo '41;east'"#;

#[test]
fn jobs_are_submitted_alike_by_the_program_and_by_the_script() {
    let temporary = tempfile::tempdir().unwrap();
    let root = temporary.path().canonicalize().unwrap().join(HOSTILE);
    std::fs::create_dir(&root).unwrap();
    let output = slurm(&root, Some(RECORD_CALL), &["--submit"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let told = text(&output.stdout);
    assert!(told.starts_with("shards: job 41\nreport: job 41\ntime:   about "), "{told}");
    let folder = root.join("slurm").to_str().unwrap().to_string();
    let chdir = format!("--chdir={folder}");
    let record = root.join("record");
    let by_program = calls(&std::fs::read(&record).unwrap());
    let array = ["--parsable", &chdir, &format!("{folder}/{SHARDS}")];
    let report = ["--parsable", &chdir, "--dependency=afterany:41", &format!("{folder}/{REPORT}")];
    assert_eq!(by_program, [array.map(str::to_string).to_vec(), report.map(str::to_string).to_vec()]);

    std::fs::remove_file(&record).unwrap();
    let mut command = Command::new("/bin/sh");
    command.arg(root.join("slurm").join(SUBMIT)).env("PATH", root.join("bin")).env("RECORD", &record);
    assert_eq!(text(&command.output().unwrap().stdout), "shards: job 41\nreport: job 41\n");
    assert_eq!(calls(&std::fs::read(&record).unwrap()), by_program);
}

#[test]
fn the_same_arguments_give_the_same_scripts() {
    let root = tempfile::tempdir().unwrap();
    let scripts = || {
        let output = slurm(root.path(), None, &["--results", "r", "--partition", "a,b", "--cpus", "4"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(text(&output.stdout).contains("submit:  sh '"), "{}", text(&output.stdout));
        [SHARDS, REPORT, SUBMIT]
            .map(|name| std::fs::read_to_string(root.path().join("slurm").join(name)).unwrap())
    };
    let first = scripts();
    assert_eq!(first, scripts());
    let [shards, report, _] = &first;
    let program = format!("exec '{}' run", env!("CARGO_BIN_EXE_trackfail"));
    for script in [shards, report] {
        assert!(script.contains(&program) && script.contains("#SBATCH --partition=a,b\n"), "{script}");
        assert!(script.contains("    --results '/") && script.contains("/r' \\\n"), "{script}");
        assert!(script.ends_with("    --jobs 4\n"), "{script}");
    }
}

#[test]
fn scripts_for_other_jobs_are_replaced_only_when_asked() {
    let root = tempfile::tempdir().unwrap();
    let run = |more: &[&str]| slurm(root.path(), None, more);
    let script = || std::fs::read_to_string(root.path().join("slurm").join(SHARDS)).unwrap();
    assert!(run(&[]).status.success());
    let first = script();
    let refused = run(&["--cpus", "2"]);
    let told = text(&refused.stderr);
    assert!(
        refused.status.code() == Some(2) && told.contains("is there already, for other jobs; --force"),
        "{told}"
    );
    assert_eq!(script(), first);
    assert!(run(&[]).status.success(), "the same scripts may be written again");
    let more = [
        "--cpus",
        "2",
        "--force",
        "--throttle",
        "2",
        "--sbatch-arg=--qos=long",
        "--before",
        "module load ffmpeg",
    ];
    let output = run(&more);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).contains("for the longest share on 2 cores, from a few frames of"),
        "{}",
        text(&output.stdout)
    );
    for words in [
        "#SBATCH --array=1-3%2\n",
        "#SBATCH --output=shard-%A_%a.log\n",
        "\nset -e\nmodule load ffmpeg\nset -eu\n",
    ] {
        assert!(script().contains(words), "{}", script());
    }
    let submit = std::fs::read_to_string(root.path().join("slurm").join(SUBMIT)).unwrap();
    assert_eq!(submit.matches(" '--qos=long' ").count(), 2, "{submit}");
}

#[test]
fn what_sbatch_refuses_is_told() {
    let refused = |sbatch: Option<&str>, words: &[&str]| {
        let root = tempfile::tempdir().unwrap();
        let output = slurm(root.path(), sbatch, &["--submit"]);
        let told = text(&output.stderr);
        assert_eq!((output.status.code(), text(&output.stdout)), (Some(1), String::new()), "{told}");
        for words in words {
            assert!(told.contains(words), "{told}");
        }
    };
    refused(None, &["sbatch cannot be started", SUBMIT]);
    refused(Some("echo 'no such partition' >&2; exit 1"), &["exit status: 1: no such partition"]);
    refused(Some("echo 'Submitted batch job 41'"), &["no job number but \"Submitted batch job 41\""]);
    let second = r#"case $* in *dependency*) echo full >&2; exit 1;; esac; echo 41"#;
    refused(Some(second), &["the array is in the queue as job 41, but its report is not", "full"]);
}

#[test]
fn wrong_arguments_are_refused_before_anything_is_written() {
    let refused = |code: i32, more: &[&str], words: &str| {
        let root = tempfile::tempdir().unwrap();
        let output = slurm(root.path(), Some(RECORD_CALL), more);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{more:?}: {told}");
        assert!(told.contains(words), "{more:?}: {told}");
        let names: Vec<_> = std::fs::read_dir(root.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(names, ["bin"], "{more:?}");
    };
    refused(2, &["no-such-experiment", "--submit"], "no-such-experiment: no such file");
    refused(2, &["--time", "04:00"], "at least 5 minutes");
    refused(2, &["--time", "4h"], "HH:MM:SS");
    refused(2, &["--memory", "0"], "above 0");
    refused(2, &["--partition", "a b"], "want a name");
    refused(2, &["--account", "a\n#SBATCH --uid=0"], "want a name");
    refused(2, &["--cpus", "0"], "0 is not in 1..=1024");
    refused(2, &["--results", "a\nb"], "a control character");
    refused(2, &["--reports", "a\rb"], "a control character");
    refused(2, &["--output", "100%"], "name another --output");
    refused(2, &["--output", "a\\b"], "name another --output");
    refused(2, &["--output", ""], "a value is required");
    refused(3, &["--data-root", "nowhere"], "the data root is no folder");
    refused(3, &["khalid2016/table1"], "sequences of suite otb-dtef20 are missing");
    refused(2, &["--throttle", "0"], "0 is not in 1..");
    refused(2, &["--sbatch-arg=--array=1-9"], "which are set already");
    refused(2, &["--sbatch-arg", "gpu"], "want an option of sbatch");
    refused(2, &["--before", "module load a\nrm b"], "a control character");
    for shards in ["0", "1001", "-1", "two"] {
        let output = trackfail().args(["slurm", "quickstart", "--shards", shards]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{shards}");
    }
}
