//! Verbs that tell what there is and what would be done: schema, new, completions, list, dry runs.

use crate::tools::{Place, Ran, experiment};
use serde_json::Value;
use trackfail::plugin::Entry;

#[test]
fn a_new_experiment_runs_and_is_not_overwritten() {
    let place = Place::new();
    let told = place.run("new mine/first").ends(0).out;
    assert!(told.starts_with("experiment: first.toml\n"), "{told}");
    let text = place.read("first.toml");
    let schema = text.lines().next().and_then(|line| line.strip_prefix("#:schema ")).unwrap();
    assert_eq!(place.read(schema), place.run("schema").ends(0).out);
    assert!(text.contains("trackfail run first.toml") && text.lines().all(|line| line.len() <= 120));
    place.run("run first.toml --quiet").ends(0);
    place.holds("results/mine/first/scores.csv", &[",DTEF,"], &["failed"]);
    let kept = place.read("results/mine/first/experiment.toml");
    assert!(!kept.contains("#:schema") && text.ends_with(&kept), "{kept}");

    place.write("first.toml", "mine");
    place.run("new first").ends(2).tells("first.toml is there already");
    assert_eq!(place.read("first.toml"), "mine");
    place.run("new first --force").ends(0);
    // Before: the schema was replaced without a word.
    place.run("new second").ends(0);
    place.write(schema, "mine");
    place.run("new third").ends(2).tells("trackfail.schema.json is there already; --force");
    assert_eq!(place.read(schema), "mine");
    assert!(!place.has("third.toml"));
    for bad in ["../first", "''", "First", "a//b", "/a", "quickstart", "khalid2016/table1"] {
        place.run(&format!("new {bad}")).ends(2);
    }
}

#[test]
fn a_verb_with_swapped_letters_is_recognized() {
    let place = Place::new();
    let near = [("rnu", "'run'"), ("lsit", "'list'"), ("detcet", "'detect'"), ("data dad", "'add'")];
    near.into_iter().for_each(|(line, near)| drop(place.run(line).ends(2).tells("similar").tells(near)));
    place.run("xyzxyz").never_says("similar");
}

#[test]
fn shells_complete_every_verb() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let ran = place.run(&format!("completions {shell}")).ends(0);
        ran.says("detect").says("slurm").says("completions").says("dry-run");
    }
    let script = place.run("completions bash").out;
    let complete = "COMP_WORDS=(trackfail sl); COMP_CWORD=1; _trackfail trackfail sl trackfail; [ \"${COMPREPLY[*]}\" = slurm ]";
    Ran::of(assert_cmd::Command::new("bash").args(["-c", &format!("{script}\n{complete}")])).ends(0);
}

#[test]
fn lists_name_what_there_is() {
    fn kinds<T: ?Sized>(list: &'static [Entry<T>]) -> Vec<&'static str> {
        list.iter().map(|entry| entry.kind).collect()
    }
    let place = Place::new();
    let told = place.run("list").ends(0).out;
    let suites = vec!["otb-dtef20", "vot2014", "synthetic-otb", "synthetic-vot", "synthetic-d1", "d1-real"];
    for (what, words) in [
        ("experiments", vec!["quickstart", "khalid2016/table1", "sanmiguel2015/fig13-d1"]),
        ("suites", suites),
        ("methods", vec!["DTEF", "ARTE*"]),
        ("trackers", kinds(trackfail::tracker::TRACKERS)),
        ("signals", kinds(trackfail::signal::SIGNALS)),
        ("detectors", kinds(trackfail::detector::DETECTORS)),
        ("analyses", kinds(trackfail::analysis::ANALYSES)),
        ("protocols", vec!["khalid2016/1", "sanmiguel2015/1"]),
    ] {
        assert!(told.contains(&format!("\n {what} ")), "{told}");
        let csv = place.run(&format!("list {what} --format csv")).ends(0);
        words.iter().fold(csv, |ran, word| ran.says(word));
        let json = place.run(&format!("list {what} --format json")).ends(0).out;
        assert!(serde_json::from_str::<Value>(&json).unwrap().is_array(), "{what}");
    }
}

const SPEC: &str = r#"tracker = [{ name = "still" }]
method = [
    { name = "histogram", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 } },
    { name = "never", detector = { kind = "never" } },
]
"#;

#[test]
fn a_dry_run_gives_the_summary_first_and_the_cells_when_asked() {
    let place = Place::with(&[("try.toml", &experiment("mine/try", "synthetic-vot", SPEC))]);
    let run = |more: &str| place.run(&format!("run try.toml {more}")).ends(0).out;
    let first = run("--dry-run");
    assert!(first.starts_with("mine/try: A try\n  data "), "{first}");
    for words in [": 0 cached, 0 stale, ", " at hand\n", "\n  analyses  none\n", "\n  time      not known"] {
        assert!(first.contains(words), "{words}\n{first}");
    }
    assert!(first.lines().count() < 9, "{first}");
    let cells = run("--dry-run --verbose");
    assert!(cells.starts_with(&first) && cells.matches(" missing").count() > 10, "{cells}");
    assert!(cells.contains(" because") && cells.contains(" it was never computed here"), "{cells}");
    // Programs get the cells, as ever.
    assert!(run("--dry-run --format csv").starts_with("sequence,tracker,run,method,params,state\n"));

    let states = |told: &str| -> Vec<String> {
        told.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().to_string()).collect()
    };
    let shards = |of: &str| states(&run(&format!("--dry-run --shard {of} --format csv")));
    assert_eq!(shards("1/3"), ["to do", "to do", "to do"]);
    run("--quiet --shard 2/3");
    assert_eq!(shards("1/3"), ["to do", "done", "to do"]);
    run("--quiet --shard 3/3");
    assert_eq!(shards("3/3"), ["to do", "done", "done"]);
    let told = run("--dry-run --shard 1/3");
    assert!(told.contains("(share 1 of 3)\n") && told.contains("\n2 of 3 shares are done\n"), "{told}");
    // The shares have found what the tracker costs.
    assert!(told.contains("\n  time      about "), "{told}");
    run("--quiet");
    assert!(run("--dry-run").contains("\n  time      nothing is left to compute\n"));
    place.run("run --verbose").ends(2).tells("--dry-run");
    place.run("run try.toml --shard 1/2 --export-tracks tracks").refuses(2, "cannot be used with");
}

/// Cells of many sequences that fail for one cause are told in one line, by a whole run and by a share.
#[test]
fn cells_that_fail_for_the_same_cause_are_told_once() {
    let program = "[tracker.mine]\nversion = \"1\"\nprotocol = \"lines\"\ncommand = [\"sh\", \"-c\", \"echo Traceback >&2; echo no module named numpy >&2; exit 1\"]\n";
    let spec = SPEC.replace("name = \"still\"", "name = \"process\", program = \"mine\"");
    let spec = experiment("mine/try", "synthetic-vot", &spec);
    let place = Place::with(&[("plugins.toml", program), ("try.toml", &spec)]);
    for more in ["", "--shard 1/1"] {
        let all = place.run(&format!("run try.toml {more}")).ends(4).all();
        let lines: Vec<&str> = all.lines().filter(|line| line.starts_with("failed: ")).collect();
        let line = "failed: 18 cells: no module named numpy (process, 9 sequences, 2 methods)";
        assert_eq!(lines, [line], "{all}");
        let last = all.lines().last().unwrap();
        assert!(last.starts_with("error: mine/try: 18") && last.contains("numpy (process"), "{all}");
    }
}
