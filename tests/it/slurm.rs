//! Batch scripts: the words that reach the program, and the calls of sbatch.

#[path = "../tools/slurm.rs"]
mod scripts;

use crate::tools::trackfail;
use proptest::prelude::*;
use scripts::{HOSTILE, calls, executable, expected, script};
use std::path::Path;
use std::process::{Command, Output};
use trackfail::cli::slurm::SCRIPT;

/// Shell function that prints its arguments, each followed by a NUL, and a mark at the end of the call.
const PRINT_CALL: &str = r#"printf '%s\0' "$@"; printf '\036'"#;

fn hostile_path() -> impl Strategy<Value = String> {
    let special = "/[- a'\"$`\\\\!*?;&|<>()#~{}%=\\[\\]]{1,20}";
    prop_oneof![special, "/\\PC{1,30}"]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn every_word_reaches_the_program_as_it_is(results in hostile_path()) {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join(HOSTILE);
        std::fs::create_dir(&root).unwrap();
        let program = root.join("program");
        executable(&program, PRINT_CALL);
        let path = script(&root, &program, &results, &[]);
        for shell in ["sh", "bash"] {
            for (part, share) in [("share", Some("2")), ("report", None)] {
                let mut command = Command::new(shell);
                let output = command.arg(&path).arg(part).env("SLURM_ARRAY_TASK_ID", "2").output().unwrap();
                prop_assert!(output.status.success(), "{}", text(&output.stderr));
                prop_assert_eq!(calls(&output.stdout), vec![expected(&root, &results, share)]);
            }
        }
    }
}

#[test]
fn a_script_that_is_no_task_of_an_array_does_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("program");
    executable(&program, PRINT_CALL);
    let path = script(folder.path(), &program, "results", &[]);
    let mut command = Command::new("sh");
    let output = command.arg(path).arg("share").env_remove("SLURM_ARRAY_TASK_ID").output().unwrap();
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
    assert_eq!(text(&output.stdout), "shards: job 41\nreport: job 41\n");
    let (folder, record) = (root.join("slurm"), root.join("record"));
    let by_program = calls(&std::fs::read(&record).unwrap());
    let [chdir, script] =
        [format!("--chdir={}", folder.display()), folder.join(SCRIPT).display().to_string()];
    let call = |name: &str, log: &str, more: &str, part: &str| {
        let (name, log) = (format!("--job-name=trackfail-{name}"), format!("--output={log}.log"));
        ["--parsable", &chdir, &name, &log, more, &script, part].map(str::to_string).to_vec()
    };
    let array = call("shards", "shard-%A_%a", "--array=1-3", "share");
    assert_eq!(by_program, [array, call("report", "report-%j", "--dependency=afterany:41", "report")]);

    std::fs::remove_file(&record).unwrap();
    let mut command = Command::new("/bin/sh");
    command.arg(&script).env("PATH", root.join("bin")).env("RECORD", &record);
    assert_eq!(text(&command.output().unwrap().stdout), "shards: job 41\nreport: job 41\n");
    assert_eq!(calls(&std::fs::read(&record).unwrap()), by_program);
}

#[test]
fn the_same_arguments_give_the_same_script_with_the_lines_of_the_user() {
    let root = tempfile::tempdir().unwrap();
    std::fs::write(root.path().join("plugins.toml"), "").unwrap();
    let written = |more: &[&str]| {
        let output = slurm(root.path(), None, more);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(text(&output.stdout).contains("\nsubmit: sh '"), "{}", text(&output.stdout));
        std::fs::read_to_string(root.path().join("slurm").join(SCRIPT)).unwrap()
    };
    let plain = written(&[]);
    assert_eq!(plain, written(&[]));
    let head = "#SBATCH --open-mode=append\n#SBATCH --requeue\n#SBATCH --signal=B:TERM@120\n#SBATCH --time=04:00:00\n#SBATCH --ntasks=1\n#SBATCH --cpus-per-task=1\n#SBATCH --mem=2G\nset -eu\n";
    assert!(plain.starts_with("#!/bin/bash\n# ") && plain.contains(head), "{plain}");
    assert!(plain.contains("\nshift\nset -- 'quickstart' --results '/"), "{plain}");
    assert!(plain.contains("/plugins.toml'\n# ") && plain.ends_with("\nesac\n"), "{plain}");

    let more = ["--time", "1-0", "--memory", "4096", "--cpus", "4", "--partition", "a,b", "--allow-missing"];
    let lines = ["--line", "#SBATCH --gres=gpu:1", "--line", "module load x", "--line", "y"];
    let script = written(&[&more[..], &lines].concat());
    for words in [
        "#SBATCH --time=1-0\n",
        "#SBATCH --cpus-per-task=4\n#SBATCH --mem=4096\n#SBATCH --partition=a,b\n#SBATCH --gres=gpu:1\nset -eu\n",
        "\nset +u\nmodule load x\ny\nset -u\nset -- 'quickstart'",
        " --jobs 4\n",
        "\nset -- \"$@\" --allow-missing\n# ",
    ] {
        assert!(script.contains(words), "{words}\n{script}");
    }
}

#[test]
fn lines_of_the_user_neither_change_the_job_nor_set_what_the_script_sets() {
    let root = tempfile::tempdir().unwrap();
    for (line, words) in [
        ("#SBATCH --array=1-9", "the script sets --array itself"),
        (" #SBATCH -o x.log", "the script sets -o itself"),
        ("a\nb", "one line"),
    ] {
        let output = slurm(root.path(), None, &["--line", line]);
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert!(text(&output.stderr).contains(words), "{line}: {}", text(&output.stderr));
    }
    let output = slurm(root.path(), None, &["--line", "set -- x; echo \"before $#\" >&2"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let script = root.path().join("slurm").join(SCRIPT);
    let job = Command::new("/bin/bash").arg(&script).arg("shar").output().unwrap();
    let told = text(&job.stderr);
    assert_eq!(job.status.code(), Some(2), "{told}");
    assert!(told.contains("before 1") && told.contains("`shar` is neither share nor report"), "{told}");
}

#[test]
fn what_sbatch_refuses_is_told() {
    let refused = |sbatch: Option<&str>, said: &str, words: &[&str]| {
        let root = tempfile::tempdir().unwrap();
        let output = slurm(root.path(), sbatch, &["--submit"]);
        let told = text(&output.stderr);
        assert_eq!((output.status.code(), text(&output.stdout)), (Some(1), said.to_string()), "{told}");
        for words in words {
            assert!(told.contains(words), "{told}");
        }
    };
    refused(None, "", &["sbatch", "not found", SCRIPT, "not all is submitted"]);
    refused(Some("echo 'no such partition' >&2; exit 1"), "", &["no such partition\n", "exit status: 1"]);
    let second = r#"case $* in *dependency*) echo full >&2; exit 1;; esac; echo 41"#;
    refused(Some(second), "shards: job 41\n", &["full\n", "not all is submitted"]);
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
    refused(2, &["--time", "4 h"], "want letters, digits");
    refused(2, &["--memory", ""], "want letters, digits");
    refused(2, &["--partition", "a\n#SBATCH --uid=0"], "want letters, digits");
    refused(2, &["--cpus", "0"], "0 is not in 1..=1024");
    refused(2, &["--output", "100%"], "name another --output");
    refused(2, &["--output", "a\\b"], "name another --output");
    refused(2, &["--output", ""], "a value is required");
    refused(3, &["--data-root", "nowhere"], "the data root is no folder");
    refused(3, &["khalid2016/table1"], "sequences of suite otb-dtef20 are missing");
    for shards in ["0", "1001", "-1", "two"] {
        let output = trackfail().args(["slurm", "quickstart", "--shards", shards]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{shards}");
    }
}
