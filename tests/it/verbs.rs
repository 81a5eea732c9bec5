//! Verbs that tell what there is and what would be done: schema, new, completions, list, dry runs.

use crate::tools::{output, trackfail};
use std::path::Path;

fn good(folder: &Path, arguments: &[&str]) -> String {
    let output = trackfail().current_dir(folder).args(arguments).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {told}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_schema_is_the_one_in_the_repository() {
    let kept = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/schema.json");
    let schema = output(&["schema"]).1;
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(kept, &schema).unwrap();
    }
    assert!(
        schema == std::fs::read_to_string(kept).unwrap(),
        "experiments/schema.json is stale: UPDATE=1 cargo test"
    );
}

#[test]
fn a_new_experiment_runs_and_is_not_overwritten() {
    let dir = tempfile::tempdir().unwrap();
    let here = dir.path();
    let told = good(here, &["new", "mine/first"]);
    assert!(told.starts_with("experiment: first.toml\n"), "{told}");
    let text = std::fs::read_to_string(here.join("first.toml")).unwrap();
    let schema = text.lines().next().and_then(|line| line.strip_prefix("#:schema ")).unwrap();
    assert_eq!(std::fs::read_to_string(here.join(schema)).unwrap(), output(&["schema"]).1);
    good(here, &["run", "first.toml", "--quiet"]);
    let scores = std::fs::read_to_string(here.join("results/mine/first/scores.csv")).unwrap();
    assert!(scores.contains(",DTEF,") && !scores.contains("failed"), "{scores}");
    let kept = std::fs::read_to_string(here.join("results/mine/first/experiment.toml")).unwrap();
    assert!(!kept.contains("#:schema") && text.ends_with(&kept), "{kept}");

    std::fs::write(here.join("first.toml"), "mine").unwrap();
    let refused = trackfail().current_dir(here).args(["new", "first"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&refused.stderr).contains("first.toml is there already; --force replaces it")
    );
    assert_eq!(std::fs::read_to_string(here.join("first.toml")).unwrap(), "mine");
    good(here, &["new", "first", "--force"]);
    // Before: the schema was replaced without a word.
    good(here, &["new", "second"]);
    std::fs::write(here.join(schema), "mine").unwrap();
    let refused = trackfail().current_dir(here).args(["new", "third"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    let told = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(told.contains("trackfail.schema.json is there already; --force replaces it"), "{told}");
    assert_eq!(std::fs::read_to_string(here.join(schema)).unwrap(), "mine");
    assert!(!here.join("third.toml").exists());
    for bad in ["../first", "", "First", "a//b", "/a", "quickstart", "khalid2016/table1"] {
        let refused = trackfail().current_dir(here).args(["new", bad]).output().unwrap();
        assert_eq!(refused.status.code(), Some(2), "{bad}");
    }
}

#[test]
fn a_verb_with_swapped_letters_is_recognized() {
    for (arguments, near) in
        [("rnu", "'run'"), ("lsit", "'list'"), ("detcet", "'detect'"), ("data dad", "'add'")]
    {
        let (code, _, told) = output(&arguments.split(' ').collect::<Vec<_>>());
        assert!(code == 2 && told.contains("similar") && told.contains(near), "{arguments}: {told}");
    }
    assert!(!output(&["xyzxyz"]).2.contains("similar"));
}

#[test]
fn shells_complete_every_verb() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let (code, script, told) = output(&["completions", shell]);
        assert_eq!(code, 0, "{told}");
        for word in ["detect", "slurm", "completions", "dry-run"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    let check = |shell: &str, arguments: &[&str], script: &str| {
        let Ok(output) = std::process::Command::new(shell).args(arguments).arg(script).output() else {
            return;
        };
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    let script = output(&["completions", "bash"]).1;
    check("bash", &["-n", "-c"], &script);
    let complete = "COMP_WORDS=(trackfail sl); COMP_CWORD=1; _trackfail trackfail sl trackfail; [ \"${COMPREPLY[*]}\" = slurm ]";
    check("bash", &["-c"], &format!("{script}\n{complete}"));
}

#[test]
fn list_alone_tells_what_can_be_listed() {
    let (code, text, told) = output(&["list"]);
    assert_eq!(code, 0, "{told}");
    for what in
        ["experiments", "suites", "methods", "trackers", "signals", "detectors", "analyses", "protocols"]
    {
        assert!(text.contains(&format!("\n {what} ")), "{text}");
        assert_eq!(output(&["list", what, "--format", "json"]).0, 0, "{what}");
    }
}

const SPEC: &str = r#"schema = 1
name = "mine/try"
title = "A try"
protocol = "khalid2016/1"

[suites]
test = "synthetic-vot"

[[tracker]]
name = "still"

[[method]]
name = "histogram"
signal = { kind = "rgb-histogram" }
detector = { kind = "level", below = 0.9 }

[[method]]
name = "never"
detector = { kind = "never" }
"#;

#[test]
fn a_dry_run_gives_the_summary_first_and_the_cells_when_asked() {
    let dir = tempfile::tempdir().unwrap();
    let here = dir.path();
    std::fs::write(here.join("try.toml"), SPEC).unwrap();
    let dry = |more: &[&str]| good(here, &[&["run", "try.toml", "--dry-run"], more].concat());
    let first = dry(&[]);
    assert!(first.starts_with("mine/try: A try\n  data "), "{first}");
    for words in [": 0 cached, 0 stale, ", " at hand\n", "\n  analyses  none\n", "\n  time      not known"] {
        assert!(first.contains(words), "{words}\n{first}");
    }
    assert!(first.lines().count() < 9, "{first}");
    let cells = dry(&["--verbose"]);
    assert!(cells.starts_with(&first) && cells.matches(" missing").count() > 10, "{cells}");
    assert!(cells.contains(" because") && cells.contains(" it was never computed here"), "{cells}");
    // Programs get the cells, as ever.
    assert!(dry(&["--format", "csv"]).starts_with("sequence,tracker,run,method,params,state\n"));

    let states = |told: &str| -> Vec<String> {
        told.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().to_string()).collect()
    };
    let shards = |of: &str| states(&dry(&["--shard", of, "--format", "csv"]));
    assert_eq!(shards("1/3"), ["to do", "to do", "to do"]);
    good(here, &["run", "try.toml", "--quiet", "--shard", "2/3"]);
    assert_eq!(shards("1/3"), ["to do", "done", "to do"]);
    good(here, &["run", "try.toml", "--quiet", "--shard", "3/3"]);
    assert_eq!(shards("3/3"), ["to do", "done", "done"]);
    let told = dry(&["--shard", "1/3"]);
    assert!(told.contains("(share 1 of 3)\n") && told.contains("\n2 of 3 shares are done\n"), "{told}");
    // The shares have found what the tracker costs.
    assert!(told.contains("\n  time      about "), "{told}");
    good(here, &["run", "try.toml", "--quiet"]);
    assert!(dry(&[]).contains("\n  time      nothing is left to compute\n"));
    let (code, _, told) = output(&["run", "--verbose"]);
    assert!(code == 2 && told.contains("--dry-run"), "{told}");
}

/// Cells of many sequences that fail for one cause are told in one line, by a whole run and by a share.
#[cfg(unix)]
#[test]
fn cells_that_fail_for_the_same_cause_are_told_once() {
    let dir = tempfile::tempdir().unwrap();
    let here = dir.path();
    let program = "[tracker.mine]\nversion = \"1\"\nprotocol = \"lines\"\ncommand = [\"sh\", \"-c\", \"echo Traceback >&2; echo no module named numpy >&2; exit 1\"]\n";
    std::fs::write(here.join("plugins.toml"), program).unwrap();
    let spec = SPEC.replace("name = \"still\"", "name = \"process\"\nprogram = \"mine\"");
    std::fs::write(here.join("try.toml"), spec).unwrap();
    for more in [&[][..], &["--shard", "1/1"]] {
        let run = trackfail().current_dir(here).args(["run", "try.toml"]).args(more).output().unwrap();
        assert_eq!(run.status.code(), Some(4));
        let [said, told] =
            [&run.stdout, &run.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        let all = said + &told;
        let lines: Vec<&str> = all.lines().filter(|line| line.starts_with("failed: ")).collect();
        assert_eq!(
            lines,
            ["failed: 18 cells: no module named numpy (process, 9 sequences, 2 methods)"],
            "{all}"
        );
        let last = all.lines().last().unwrap();
        assert!(
            last.starts_with("error: mine/try: 18") && last.contains("no module named numpy (process"),
            "{all}"
        );
    }
}
