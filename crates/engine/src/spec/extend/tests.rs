//! Extending and grouping shorten a file without changing its meaning.

use crate::spec::error::SpecError;
use crate::spec::limits::MAX_BYTES;
use crate::spec::{builtin, parse, read_file};
use crate::testing::changed;
use proptest::prelude::*;
use sha2::{Digest, Sha256};
use std::path::Path;
use trackfail_core::num::hexadecimal;
use trackfail_dataset::suite::Catalog;

/// First 16 digits of the digests of built-in experiments without kept results, as they were when each file
/// said everything itself: plans, addresses and manifests come from the same text as then.
const FROZEN: [(&str, &str); 3] = [
    ("sanmiguel2015/built-in-model", "746e8d977da04859"),
    ("sanmiguel2015/fig13-d1-unsigned", "6917d77914c42ca0"),
    ("sanmiguel2015/start-up", "d29845f62e3099d1"),
];

/// Built-in experiments without kept results that were never shortened.
const FREE: [&str; 2] = ["benchmark/deep-models", "khalid2016/figures"];

#[test]
fn built_in_experiments_are_the_text_of_their_kept_results_or_as_before_they_were_shortened() {
    let results = concat!(env!("CARGO_MANIFEST_DIR"), "/../../results");
    for (name, text) in builtin::EXPERIMENTS {
        let source = parse(name, text).unwrap().source;
        // A complete text needs nothing more.
        assert_eq!(parse(name, &source).unwrap().source, source, "{name}");
        let kept = std::fs::read_to_string(Path::new(results).join(name).join("experiment.toml"));
        let digest = || hexadecimal(&Sha256::digest(source.as_bytes())[..8]);
        match (kept, FROZEN.iter().find(|(frozen, _)| frozen == name)) {
            (Ok(kept), None) => assert_eq!(source, kept, "{name}"),
            (Err(_), Some((_, frozen))) => assert_eq!(digest(), *frozen, "{name}"),
            (kept, frozen) => assert!(kept.is_err() && frozen.is_none() && FREE.contains(name), "{name}"),
        }
    }
    assert!(FROZEN.iter().all(|(frozen, _)| builtin::EXPERIMENTS.iter().any(|(name, _)| name == frozen)));
}

const BASE: &str = r#"schema = 1
name = "base"
title = "Base"
protocol = "khalid2016/1"
suites.test = "synthetic-vot"

[[tracker-group]]
group = "slow"
runs = 3
trackers = ["still", { name = "ncc", label = "NCC" }]

[[method-group]]
group = "anchors"
methods = [{ name = "never", detector = { kind = "never" } }, { name = "always", detector = { kind = "always" } }]

[[method-group]]
trackers = ["slow"]
grid = { below = [0.5, 0.9] }
methods = ["RgbHist", { name = "RLHist", grid = { below = [0.8] } }]

[[method]]
name = "RAW"
[method.signal]
kind = "rgb-histogram"
[method.detector]
kind = "level"
below = 0.9

[[table]]
name = "t"
rows = ["recall"]
columns = "method"
methods = ["RAW", "anchors"]

[[published]]
table = "t"
tracker = "SP"
row = "recall"
values = { RAW = ".1" }

[[claim]]
text = "more"
holds = "recall[RAW] > 0"
"#;

/// Writes files into a folder and reads the first.
fn read(files: &[(&str, &str)]) -> Result<crate::spec::Experiment, SpecError> {
    let dir = trackfail_testing::folder(files.iter().copied());
    let read = read_file(&dir.path().join(files[0].0), &Catalog::default(), None);
    read.map_err(|e| {
        let plain = |text: &str| text.replace(&format!("{}/", dir.path().display()), "");
        SpecError { file: plain(&e.file), message: plain(&e.message), ..e }
    })
}

/// Beginning of [`BASE`] up to its tables, with the groups written out.
const WRITTEN_OUT: &str = r#"schema = 1
name = "base"
title = "Base"
protocol = "khalid2016/1"

[suites]
test = "synthetic-vot"

[[tracker]]
name = "still"
runs = 3

[[tracker]]
name = "ncc"
label = "NCC"
runs = 3

[[method]]
name = "never"
detector = { kind = "never" }

[[method]]
name = "always"
detector = { kind = "always" }

[[method]]
name = "RgbHist"
trackers = ["still", "NCC"]
grid = { below = [0.5, 0.9] }

[[method]]
name = "RLHist"
trackers = ["still", "NCC"]
grid = { below = [0.8] }

[[method]]
name = "RAW"
signal = { kind = "rgb-histogram" }
detector = { kind = "level", below = 0.9 }
"#;

/// [`BASE`] with its groups written out.
fn written_out() -> String {
    let (_, tables) = BASE.split_once("\n[[table]]").unwrap();
    format!("{WRITTEN_OUT}\n[[table]]{}", tables.replace("\"anchors\"", "\"never\", \"always\""))
}

#[test]
fn groups_are_written_out() {
    assert_eq!(read(&[("base.toml", BASE)]).unwrap().source, written_out());
}

const CHILD: &str = r#"schema = 1
extends = "base.toml"
name = "child"
seed = 7
suites.train = "synthetic-d1"

[without]
method = ["RgbHist"]
tracker = ["NCC"]

[[tracker]]
name = "kcf"

[[method]]
name = "RAW"
detector = { kind = "level", below = 0.5 }

# Beside the others.
[[table]]
name = "u"
rows = ["precision"]
columns = "method"
methods = ["anchors"]

[[table]]
name = "t"
caption = "Recall"

[[figure]]
name = "f"
kind = "machine"

[[claim]]
text = "less"
holds = "recall[RAW] < 1"
"#;

#[test]
fn an_experiment_gives_what_differs() {
    let mut expected = written_out();
    for (of_base, of_child) in [
        ("name = \"base\"", "name = \"child\""),
        ("khalid2016/1\"\n", "khalid2016/1\"\nseed = 7\n"),
        ("test = \"synthetic-vot\"\n", "test = \"synthetic-vot\"\ntrain = \"synthetic-d1\"\n"),
        ("name = \"ncc\"\nlabel = \"NCC\"\nruns = 3\n", "name = \"kcf\"\n"),
        (
            "[[method]]\nname = \"RgbHist\"\ntrackers = [\"still\", \"NCC\"]\ngrid = { below = [0.5, 0.9] }\n\n",
            "",
        ),
        ("trackers = [\"still\", \"NCC\"]", "trackers = [\"still\"]"),
        ("below = 0.9 }", "below = 0.5 }"),
        (
            "\"always\"]\n",
            "\"always\"]\ncaption = \"Recall\"\n\n# Beside the others.\n[[table]]\nname = \"u\"\nrows = [\"precision\"]\n\
             columns = \"method\"\nmethods = [\"never\", \"always\"]\n",
        ),
    ] {
        assert_eq!(expected.matches(of_base).count(), 1, "{of_base}");
        expected = expected.replace(of_base, of_child);
    }
    expected += "\n[[claim]]\ntext = \"less\"\nholds = \"recall[RAW] < 1\"\n\n[[figure]]\nname = \"f\"\nkind = \"machine\"\n";
    assert_eq!(read(&[("child.toml", CHILD), ("base.toml", BASE)]).unwrap().source, expected);
}

#[test]
fn a_chain_of_files_and_a_built_in_base_are_read() {
    let third = "schema = 1\nextends = \"below/child.toml\"\nname = \"third\"\n";
    let files = [("third.toml", third), ("below/child.toml", CHILD), ("below/base.toml", BASE)];
    assert_eq!(read(&files).unwrap().name, "third");
    let quick = "schema = 1\nextends = \"quickstart\"\nname = \"quick\"\n[[tracker-group]]\nruns = 2\ntrackers = [\"PF\"]\n";
    let quick = parse("quick.toml", quick).unwrap();
    let runs: Vec<_> = quick.trackers.iter().map(|t| (t.label.as_str(), t.kind, t.runs)).collect();
    assert_eq!(runs, [("NCC", "ncc", 1), ("KCF", "kcf", 1), ("PF", "color-particle-filter", 2)]);
}

#[track_caller]
fn refused(child: &str, files: &[(&str, &str)], words: &str) {
    let all: Vec<(&str, &str)> = [("child.toml", child)].into_iter().chain(files.iter().copied()).collect();
    let error = read(&all).err().unwrap_or_else(|| panic!("read: {child}")).to_string();
    assert!(error.starts_with(words.split(" ... ").next().unwrap()), "{error}");
    assert!(words.split(" ... ").all(|part| error.contains(part)), "{error}");
}

#[test]
fn errors_name_both_files_and_their_lines() {
    for (from, to, words) in [
        ("seed", "sead", "child.toml:4: unknown key `sead` ... did you mean `seed`?"),
        ("0.5", "\"x\"", "child.toml:16: "),
        ("[\"RgbHist\"]", "[\"RAW\"]", "child.toml:14: method `RAW` needs a signal"),
        ("[\"RgbHist\"]", "[\"anchors\"]", "child.toml:23: nothing is left of"),
        ("RgbHist", "RgbHits", "child.toml:8: unknown method of the base `RgbHits`; did you mean `RgbHist`?"),
        ("method = [", "methods = [", "child.toml:8: unknown key `methods`; did you mean `method`?"),
        ("[\"NCC\"]", "\"NCC\"", "child.toml:9: `tracker` must be a list, not \"NCC\""),
        (
            "[[figure]]",
            "[[claim]]\ntext = \"less\"\nholds = \"1 > 0\"\n[[table]]\nname = \"u\"\n[[figure]]",
            "child.toml: 2 errors ... child.toml:33: table `u` is listed twice",
        ),
    ] {
        refused(&changed(CHILD, from, to), &[("base.toml", BASE)], words);
    }
    for (from, to, words) in [
        ("title", "tittle", "base.toml:3: unknown key `tittle` ... (extended by child.toml:2)"),
        (
            "[0.8]",
            "0.8",
            "base.toml:19: `below` must be a list that is not empty, not 0.8 ... (extended by child.toml:2)",
        ),
        ("rgb-histogram", "rgb-histogran", "base.toml:24: unknown signal `rgb-histogran`"),
        (BASE, "schema = ", "base.toml:1: ... (extended by child.toml:2)"),
    ] {
        refused(CHILD, &[("base.toml", &changed(BASE, from, to))], words);
    }
    let third = "schema = 1\n\nextends = \"third.toml\"\n";
    let bad = changed(BASE, "name = \"base\"", "name = \"Base\"");
    let third_base = changed(&bad, "schema = 1", "schema = 1\nextends = \"last.toml\"");
    refused(
        &CHILD.replacen("base.toml", "third.toml", 1).replace("name = \"child\"\n", ""),
        &[("third.toml", &third_base), ("last.toml", BASE)],
        "third.toml:3: `name` must be words ... (extended by child.toml:2)",
    );
    refused(
        third,
        &[("third.toml", "schema = 1\nextends = 3\n")],
        "third.toml:2: `extends` must be text in quotes, not 3 ... (extended by child.toml:3)",
    );
}

#[test]
fn bases_stay_in_the_folder_and_lead_nowhere_in_a_circle() {
    let child = |base: &str| format!("schema = 1\nextends = \"{base}\"\n");
    let circle = child("child.toml");
    refused(&circle, &[], "child.toml:2: `child.toml` extends itself");
    let words = "a.toml:2: `child.toml` extends itself (extended by child.toml:2)";
    refused(&child("a.toml"), &[("a.toml", &circle)], words);
    for outside in ["../a.toml", "/etc/a.toml", "./a/../../a.toml", "a/../a.toml"] {
        let words = "child.toml:2: `extends` must name a file in the folder";
        refused(&child(outside), &[("a.toml", BASE)], words);
    }
    refused(&child("nowhere.toml"), &[], "child.toml:2: nowhere.toml: ");
    let words = "child.toml:2: unknown built-in experiment `quikstart`; did you mean `quickstart`?";
    refused(&child("quikstart"), &[], words);
    let files: Vec<(String, String)> =
        (0..9).map(|k| (format!("f{k}.toml"), child(&format!("f{}.toml", k + 1)))).collect();
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    refused(&child("f0.toml"), &files, "f6.toml:2: more than 8 files extend one another");
    let unread = parse("a.toml", &child("b.toml")).err().unwrap();
    assert_eq!(unread.message, "only an experiment that is read from a file can extend a file");
    let without = format!("{BASE}[without]\ntable = [\"t\"]\n");
    refused(&without, &[], "child.toml:45: [without] is for experiments");
}

#[cfg(unix)]
#[test]
fn a_link_does_not_lead_out_of_the_folder() {
    let dir = trackfail_testing::folder([("base.toml", BASE), ("mine/child.toml", CHILD)]);
    std::os::unix::fs::symlink("../base.toml", dir.path().join("mine/base.toml")).unwrap();
    let error = read_file(&dir.path().join("mine/child.toml"), &Catalog::default(), None).err().unwrap();
    assert!(error.message.starts_with("`extends` must name a file in the folder"), "{error}");
}

#[test]
fn wrong_groups_are_refused() {
    for (group, words) in [
        ("group = \"g\"", "child.toml:44: `methods` is missing"),
        ("methods = [1]", "child.toml:45: `methods` must be text in quotes or a table, not 1"),
        ("methods = \"RAW\"", "child.toml:45: `methods` must be a list"),
        ("methods = [\"RAW\"]", "child.toml:45: method `RAW` is listed twice"),
        ("shared = 1\nmethods = [\"CovF\"]", "child.toml:45: unknown key `shared`"),
        ("group = \"RAW\"\nmethods = [\"CovF\"]", "child.toml:45: `RAW` is the name of a method already"),
        ("group = \"anchors\"\nmethods = [\"CovF\"]", "child.toml:45: two groups are called `anchors`"),
    ] {
        refused(&format!("{BASE}[[method-group]]\n{group}\n"), &[], words);
    }
    let table = BASE.replacen("[[tracker-group]]", "[tracker-group]", 1);
    refused(&table, &[], "child.toml:7: write [[tracker-group]]");
}

#[test]
fn what_grows_beyond_all_bounds_is_refused() {
    let many = "\"a\",".repeat(100_000);
    let long = "x".repeat(1000);
    let text = format!("{BASE}[[method-group]]\nlike = \"{long}\"\nmethods = [{many}]\n");
    assert!(parse("a.toml", &text).err().unwrap().message.contains(&format!("more than {MAX_BYTES} bytes")));
}

const WHOLE: &str = include_str!("../../../../../experiments/khalid2016/figures.toml");

proptest! {
    #[test]
    fn damaged_experiments_are_put_together_or_refused(
        at in any::<prop::sample::Index>(), from in any::<prop::sample::Index>(), length in 0..60_usize, which in 0..3_usize,
        insert in "(\\PC{0,3}|\\[{1,9}|\"|\\[\\[method(-group)?\\]\\]|\\[without\\]|#|=|\n|-?[0-9]{1,20}|1e999|\"\\\\u0000\"|inf|\\.\\.)",
        bytes in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let whole: Vec<char> = [BASE, &CHILD.replace("base.toml", "quickstart"), WHOLE][which].chars().collect();
        let (at, from) = (at.index(whole.len()), from.index(whole.len()));
        let [head, piece, tail] = [&whole[..at], &whole[from..(from + length).min(whole.len())], &whole[(at + length).min(whole.len())..]]
            .map(|part| part.iter().collect::<String>());
        let _ = parse("a.toml", &format!("{head}{}", String::from_utf8_lossy(&bytes)));
        for text in [format!("{head}{insert}{tail}"), format!("{head}{piece}{tail}"), format!("{head}{insert}")] {
            let Ok(experiment) = parse("a.toml", &text) else { continue };
            prop_assert!(parse("a.toml", &experiment.source).is_ok());
        }
    }
}
