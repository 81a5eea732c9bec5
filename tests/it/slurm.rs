//! Batch scripts: the words that reach the program, and the calls of sbatch.

use crate::tools::slurm::{HOSTILE, calls, expected, script};
use crate::tools::{Place, Ran, trackfail};
use assert_cmd::Command;
use proptest::prelude::*;
use std::path::Path;
use trackfail::cli::slurm::SCRIPT;
use trackfail_testing::script as executable;

/// Shell function that prints its arguments, each followed by a NUL, and a mark at the end of the call.
const PRINT_CALL: &str = r#"printf '%s\0' "$@"; printf '\036'"#;

fn hostile_path() -> impl Strategy<Value = String> {
    prop_oneof!["/[- a'\"$`\\\\!*?;&|<>()#~{}%=\\[\\]]{1,20}", "/\\PC{1,30}"]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn every_word_reaches_the_program_as_it_is(results in hostile_path()) {
        let place = Place::new();
        let root = place.folder(HOSTILE);
        let program = root.join("program");
        executable(&program, PRINT_CALL);
        let path = script(&root, &program, &results, &[]);
        for shell in ["sh", "bash"] {
            for (part, share) in [("share", Some("2")), ("report", None)] {
                let mut command = Command::new(shell);
                let ran = Ran::of(command.arg(&path).arg(part).env("SLURM_ARRAY_TASK_ID", "2")).ends(0);
                prop_assert_eq!(calls(ran.out.as_bytes()), vec![expected(&root, &results, share)]);
            }
        }
    }
}

#[test]
fn a_script_that_is_no_task_of_an_array_does_nothing() {
    let place = Place::new();
    let program = place.path("program");
    executable(&program, PRINT_CALL);
    let path = script(place.root(), &program, "results", &[]);
    let mut command = Command::new("sh");
    let ran = Ran::of(command.arg(path).arg("share").env_remove("SLURM_ARRAY_TASK_ID"));
    assert!(ran.code != Some(0) && ran.out.is_empty(), "{ran:?}");
}

/// `trackfail slurm quickstart --shards 3` in `root`, with an sbatch of these commands.
fn slurm(root: &Path, sbatch: Option<&str>, more: &[&str]) -> Ran {
    let bin = root.join("bin");
    std::fs::create_dir_all(&bin).unwrap();
    if let Some(commands) = sbatch {
        executable(&bin.join("sbatch"), commands);
    }
    let mut command = trackfail();
    command.current_dir(root).env("PATH", &bin).env("RECORD", root.join("record"));
    Ran::of(command.args(["slurm", "quickstart", "--shards", "3"]).args(more))
}

const RECORD_CALL: &str = r#"{ printf '%s\0' "$@"; printf '\036'; } >> "$RECORD"; echo '41;east'"#;

#[test]
fn jobs_are_submitted_alike_by_the_program_and_by_the_script() {
    let place = Place::new();
    let root = place.folder(HOSTILE).canonicalize().unwrap();
    let told = "shards: job 41\nreport: job 41\n";
    assert_eq!(slurm(&root, Some(RECORD_CALL), &["--submit"]).ends(0).out, told);
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
    assert_eq!(Ran::of(&mut command).out, told);
    assert_eq!(calls(&std::fs::read(&record).unwrap()), by_program);
}

#[test]
fn the_same_arguments_give_the_same_script_with_the_lines_of_the_user() {
    let place = Place::with(&[("plugins.toml", "")]);
    let written = |more: &[&str]| {
        slurm(place.root(), None, more).ends(0).says("\nsubmit: sh '");
        place.read(&format!("slurm/{SCRIPT}"))
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
    let place = Place::new();
    for (line, words) in [
        ("#SBATCH --array=1-9", "the script sets --array itself"),
        (" #SBATCH -o x.log", "the script sets -o itself"),
        ("#SBATCH -J foo", "the script sets -J itself"),
        ("#SBATCH -a1-3", "the script sets -a itself"),
        ("#SBATCH -D/tmp", "the script sets -D itself"),
        ("#SBATCH -dafterok:1", "the script sets -d itself"),
        ("a\nb", "one line"),
    ] {
        slurm(place.root(), None, &["--line", line]).ends(2).tells(words);
    }
    slurm(place.root(), None, &["--line", "#SBATCH -Aproject"]).ends(0);
    slurm(place.root(), None, &["--line", "set -- x; echo \"before $#\" >&2"]).ends(0);
    let job = Ran::of(Command::new("/bin/bash").arg(place.path("slurm").join(SCRIPT)).arg("shar"));
    job.ends(2).tells("before 1").tells("`shar` is neither share nor report");
}

#[test]
fn what_sbatch_refuses_is_told() {
    let second = r#"case $* in *dependency*) echo full >&2; exit 1;; esac; echo 41"#;
    for (sbatch, said, words) in [
        (None, "", ["not found", SCRIPT, "not all is submitted"]),
        (Some("echo 'no such partition' >&2; exit 1"), "", ["no such partition\n", "exit status: 1", ""]),
        (Some(second), "shards: job 41\n", ["full\n", "not all is submitted", ""]),
    ] {
        let ran = slurm(Place::new().root(), sbatch, &["--submit"]).ends(1);
        assert_eq!(ran.out, said);
        words.iter().fold(ran, |ran, word| ran.tells(word));
    }
}

#[test]
fn wrong_arguments_are_refused_before_anything_is_written() {
    for (code, more, words) in [
        (2, &["no-such-experiment", "--submit"][..], "no-such-experiment: no such file"),
        (2, &["--time", "4 h"], "want letters, digits"),
        (2, &["--memory", ""], "want letters, digits"),
        (2, &["--partition", "a\n#SBATCH --uid=0"], "want letters, digits"),
        (2, &["--cpus", "0"], "0 is not in 1..=1024"),
        (2, &["--output", "100%"], "name another --output"),
        (2, &["--output", "a\\b"], "name another --output"),
        (2, &["--output", ""], "a value is required"),
        (3, &["--data-root", "nowhere"], "the data root is no folder"),
        (3, &["khalid2016/table1"], "sequences of suite otb-dtef20 are missing"),
    ] {
        let place = Place::new();
        slurm(place.root(), Some(RECORD_CALL), more).ends(code).tells(words);
        assert_eq!(place.list(""), [place.path("bin")], "{more:?}");
    }
    for shards in ["0", "1001", "-1", "two"] {
        Place::new().run(&format!("slurm quickstart --shards {shards}")).ends(2);
    }
}
