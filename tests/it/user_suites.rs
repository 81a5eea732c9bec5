//! Sequences of the user's own: from a folder to a suite, an experiment, and its report.

use crate::tools::{output, rows};
use std::path::Path;

fn write(root: &Path, path: &str, text: &str) {
    let path = root.join(path);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, text).unwrap();
}

const FRAMES: usize = 30;

/// Two GOT-10k sequences whose target moves two pixels a frame, with three repetitions of a tracker that
/// loses it from frame 16 on in the second sequence.
fn data_root(root: &Path) {
    for (name, lost) in [("GOT-10k_Val_000001", FRAMES), ("GOT-10k_Val_000002", 15)] {
        let folder = root.join("got/val").join(name);
        std::fs::create_dir_all(&folder).unwrap();
        let (mut truth, mut boxes) = (String::new(), String::new());
        for t in 0..FRAMES {
            let x = 2 * t as u32;
            let image = image::RgbImage::from_fn(96, 48, |u, v| {
                let inside = (x..x + 16).contains(&u) && (10..26).contains(&v);
                image::Rgb([u as u8, v as u8, if inside { 255 } else { 0 }])
            });
            image.save(folder.join(format!("{:08}.png", t + 1))).unwrap();
            // Pixels count from 1.
            truth += &format!("{}.0000,11.0000,16.0000,16.0000\n", x + 1);
            boxes += &format!("{:.3},11.000,16.000,16.000\n", if t < lost { x + 1 } else { 80 });
        }
        write(root, &format!("got/val/{name}/groundtruth.txt"), &truth);
        for (file, label) in [("absence", "0\n"), ("cover", "8\n"), ("cut_by_image", "0\n")] {
            write(root, &format!("got/val/{name}/{file}.label"), &label.repeat(FRAMES));
        }
        for run in 1..=3 {
            write(root, &format!("results/got/T/{name}/{name}_00{run}.txt"), &boxes);
        }
        write(root, &format!("results/got/T/{name}/{name}_time.txt"), "0.1,0.1,0.1\n");
    }
}

const SPEC: &str = r#"schema = 1
name = "mine/got"
title = "My own sequences"
protocol = "khalid2016/1"

[suites]
test = "my-got"

[[tracker]]
name = "replay"
results = "got/T"
label = "T"
runs = 3

[[method]]
name = "CovF"

[[table]]
name = "t"
rows = ["recall", "events"]
columns = "method"
"#;

#[test]
fn a_folder_becomes_a_suite_an_experiment_and_a_report() {
    let dir = tempfile::tempdir().unwrap();
    let root = dir.path();
    data_root(root);
    let at = |name: &str| root.join(name).to_str().unwrap().to_owned();
    let (data, spec) = (root.to_str().unwrap(), at("spec.toml"));
    write(root, "spec.toml", SPEC);
    let run = ["run", &spec, "--data-root", data, "--results", &at("r"), "--reports", &at("p")];

    let (code, _, told) = output(&run);
    assert!(code == 2 && told.contains("unknown suite `my-got`"), "{code} {told}");
    let add = ["data", "add", "my-got", "got/val", "--format", "got10k", "--data-root", data];
    let (code, said, told) = output(&add);
    assert!(code == 0 && said.starts_with("my-got: 2 sequences, in "), "{code} {said} {told}");
    let (code, _, told) = output(&add);
    assert!(code == 2 && told.contains("my-got is in "), "{code} {told}");
    let (_, listed, _) = output(&["list", "suites", "--data-root", data]);
    assert!(listed.contains("my-got"), "{listed}");
    let (code, checked, _) = output(&["data", "verify", "my-got", "--data-root", data]);
    assert_eq!((code, checked.matches("  ok\n").count()), (0, 2), "{checked}");
    let (_, listed, _) = output(&["data", "list", "my-got", "--data-root", data]);
    assert!(listed.contains("2 of 2 sequences are here"), "{listed}");

    let (code, _, told) = output(&run);
    assert!(code == 0 && !told.contains("has a result of run"), "{told}");
    write(root, "once.toml", &SPEC.replace("mine/got", "mine/once").replace("runs = 3", "runs = 2"));
    let (code, _, told) = output(&[&["run", &at("once.toml")][..], &run[2..]].concat());
    let more = "warning: T: GOT-10k_Val_000001 has a result of run 3, but `runs` is 2";
    assert!(code == 0 && told.contains(more), "{told}");
    let scores = std::fs::read_to_string(root.join("r/mine/got/scores.csv")).unwrap();
    let events: Vec<(String, String)> = rows(&scores)
        .into_iter()
        .filter(|r| r["method"] == "CovF" && r["sequence"] != "*")
        .map(|r| (r["sequence"].clone(), r["events"].clone()))
        .collect();
    let lost = |name: &str| events.iter().filter(|(n, e)| n == name && e == "1").count();
    assert_eq!((lost("GOT-10k_Val_000001"), lost("GOT-10k_Val_000002"), events.len()), (0, 3, 6));

    // The report needs neither the data root nor its suites.
    std::fs::remove_file(root.join("datasets.lock")).unwrap();
    let (code, _, told) = output(&["report", "--results", &at("r"), "--reports", &at("again")]);
    assert_eq!(code, 0, "{told}");
    assert!(root.join("again/mine/got/index.html").is_file());
}

#[test]
fn a_wrong_file_of_suites_is_named_and_left_as_it_is() {
    let dir = tempfile::tempdir().unwrap();
    let root = dir.path();
    data_root(root);
    let data = root.to_str().unwrap();
    let wrong = "schema = 2\n\n[[suite]]\nname = \"x\"\nformat = \"oct\"\n";
    write(root, "datasets.lock", wrong);
    for verb in [
        &["data", "add", "my-got", "got/val", "--format", "got10k", "--data-root", data][..],
        &["data", "list", "--data-root", data],
        &["run", "--data-root", data],
    ] {
        let (code, _, told) = output(verb);
        assert!(code == 3 && told.contains("datasets.lock, line 5"), "{verb:?}: {code} {told}");
    }
    assert_eq!(std::fs::read_to_string(root.join("datasets.lock")).unwrap(), wrong);
    for (name, folder, code, words) in [
        ("otb-100", "got/val", 2, "built-in suite"),
        ("mine", "got/nothing", 3, "no folder under the data root"),
        ("mine", "results", 3, "no sequence"),
    ] {
        std::fs::remove_file(root.join("datasets.lock")).ok();
        let add = ["data", "add", name, folder, "--format", "got10k", "--data-root", data];
        let (got, _, told) = output(&add);
        assert!(got == code && told.contains(words), "{name}, {folder}: {got} {told}");
        assert!(!root.join("datasets.lock").exists());
    }
}

/// Neither of two suites of one name is taken for the other, whatever the order of the data roots.
#[test]
fn two_roots_that_define_a_suite_differently_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let here = dir.path();
    let list = |first: &str, second: &str| {
        let at = |name: &str| here.join(name).to_str().unwrap().to_owned();
        output(&["data", "list", "--data-root", &at(first), "--data-root", &at(second)])
    };
    write(here, "a/datasets.lock", BOXES_LOCK);
    write(here, "b/datasets.lock", BOXES_LOCK);
    write(here, "c/datasets.lock", &BOXES_LOCK.replace("Walk.txt", "Run.txt"));
    assert_eq!(list("a", "b").0, 0);
    for (first, second) in [("a", "c"), ("c", "a")] {
        let (code, _, told) = list(first, second);
        assert!(code == 3 && told.contains("suite `my-boxes` is another one in "), "{code} {told}");
        assert!(["a", "c"].iter().all(|root| told.contains(here.join(root).to_str().unwrap())), "{told}");
    }
}

const BOXES_LOCK: &str = r#"schema = 2

[[suite]]
name = "my-boxes"
title = "Boxes alone"
format = "otb-boxes"
source = "mine"
licence = "mine"
how_to_get = "ask me"
sequence = [
    { name = "Walk", folder = "truth/Walk.txt" },
]
"#;

const BOXES_SPEC: &str = r#"schema = 1
name = "mine/boxes"
title = "Boxes alone"
protocol = "khalid2016/1"

[suites]
test = "my-boxes"
train = "synthetic-d1"

[[tracker]]
name = "replay"
results = "T"
label = "T"

[[tracker]]
name = "kcf"
label = "KCF"

[[method]]
name = "DTEF"

[[method]]
name = "Two-MChi"

[[method]]
name = "oracle"
detector = { kind = "oracle" }

[[analysis]]
name = "ope"
compute = { kind = "success", rules = "otb-matlab/1" }
suites = ["test"]

[[analysis]]
name = "change"
compute = { kind = "uncertainty-model" }
signal = { kind = "uncertainty" }
suites = ["test"]

[[table]]
name = "t"
rows = ["recall", "events"]
columns = "method"

[[table]]
name = "trackers"
shows = "ope.overall"
"#;

/// A method that needs frames or a posterior is listed as not run; the rest runs, and the exit code is that of success.
#[test]
fn boxes_alone_run_the_methods_that_need_no_more() {
    let dir = tempfile::tempdir().unwrap();
    let (data, here) = (dir.path().join("data"), dir.path());
    write(&data, "datasets.lock", BOXES_LOCK);
    write(&data, "truth/Walk.txt", &"1,1,9,9\n".repeat(30));
    write(&data, "results/T/Walk.txt", &("1,1,9,9\n".repeat(20) + &"50,1,9,9\n".repeat(10)));
    write(here, "spec.toml", BOXES_SPEC);
    let at = |name: &str| here.join(name).to_str().unwrap().to_owned();
    // The first root has nothing.
    std::fs::create_dir(here.join("empty")).unwrap();
    let (spec, r, p) = (at("spec.toml"), at("r"), at("p"));
    let roots = ["--data-root", &at("empty"), "--data-root", data.to_str().unwrap()];
    let run = [&["run", &spec, "--results", &r, "--reports", &p][..], &roots].concat();
    let (code, said, told) = output(&run);
    assert_eq!(code, 0, "{said}{told}");
    for line in [
        "DTEF was not run on T (1 cell): it needs frames, and the suite has boxes only",
        "Two-MChi was not run on T (1 cell): it needs a tracker that gives its posterior",
        "oracle was not run on KCF (1 cell): it needs frames, and the suite has boxes only",
        "analysis ope was not run on KCF: it needs frames, and the suite has boxes only",
        "analysis change was not run on T: it needs a tracker that gives its posterior",
    ] {
        assert!(said.contains(line), "{line}\n{said}");
    }
    let scores = std::fs::read_to_string(here.join("r/mine/boxes/scores.csv")).unwrap();
    assert!(scores.contains("\"not run: needs frames, and the suite has boxes only\""), "{scores}");
    let page = std::fs::read_to_string(here.join("p/mine/boxes/index.html")).unwrap();
    assert!(page.contains("DTEF was not run on KCF") && !page.contains("Without a result"), "{page}");
    // A share of the cells has none that failed either.
    let shares = ["run", &spec, "--results", &at("s"), "--reports", &p, "--shard", "1/1"];
    let (code, said, told) = output(&[&shares[..], &roots].concat());
    assert_eq!(code, 0, "{said}{told}");
    let (code, said, _) = output(&[&run[..], &["--dry-run", "--format", "csv"]].concat());
    assert!(code == 0 && said.lines().filter(|line| line.contains("absent")).count() == 5, "{said}");
}

/// An absent result file is told as such by the table's note, the summary, the page and the exit code, whole or as a share.
#[test]
fn a_result_file_that_is_absent_is_not_there_and_has_not_failed() {
    let dir = tempfile::tempdir().unwrap();
    let (data, here) = (dir.path().join("data"), dir.path());
    let two = BOXES_LOCK
        .replace("sequence = [", "sequence = [\n    { name = \"Run\", folder = \"truth/Run.txt\" },");
    write(&data, "datasets.lock", &two);
    for name in ["Walk", "Run"] {
        write(&data, &format!("truth/{name}.txt"), &"1,1,9,9\n".repeat(30));
    }
    write(&data, "results/T/Walk.txt", &"1,1,9,9\n".repeat(30));
    let spec = "schema = 1\nname = \"mine/absent\"\ntitle = \"Absent\"\nprotocol = \"khalid2016/1\"\n[suites]\n\
                test = \"my-boxes\"\n[[tracker]]\nname = \"replay\"\nresults = \"T\"\nlabel = \"T\"\n\
                [[method]]\nname = \"always\"\ndetector = { kind = \"periodic\", period = 5 }\n\
                [[table]]\nname = \"t\"\nrows = [\"detections\"]\ncolumns = \"method\"\n";
    write(here, "spec.toml", spec);
    let at = |name: &str| here.join(name).to_str().unwrap().to_owned();
    let (spec, root) = (at("spec.toml"), data.to_str().unwrap().to_owned());
    let common = ["run", &spec, "--results", &at("r"), "--reports", &at("p"), "--data-root", &root];
    let run = |more: &[&str]| output(&[&common[..], more].concat());

    let (code, said, told) = run(&[]);
    let reason = "no result of `T` for Run, run 0: none of Run.json";
    assert_eq!(code, 3, "{said}{told}");
    assert!(
        told.contains(&format!(
            "mine/absent: 1 of 2 cells are not there, the first: Run, T, always: {reason}"
        )),
        "{told}"
    );
    let (code, said, told) = run(&["--allow-missing"]);
    assert_eq!(code, 0, "{said}{told}");
    assert!(said.contains("† The data of 1 cell is not there; it is left out."), "{said}");
    assert!(said.contains(&format!("not there: T, Run, always: {reason}")), "{said}");
    let table = std::fs::read_to_string(here.join("r/mine/absent/tables/t.md")).unwrap();
    let page = std::fs::read_to_string(here.join("p/mine/absent/index.html")).unwrap();
    let index = std::fs::read_to_string(here.join("p/index.html")).unwrap();
    for text in [&said, &table, &page, &index] {
        assert!(!text.to_lowercase().contains("failed:") && !text.contains("<dt>Failed"), "{text}");
    }
    assert!(table.contains("is not there") && page.contains("not there: no result of"), "{table}");
    let scores = std::fs::read_to_string(here.join("r/mine/absent/scores.csv")).unwrap();
    assert!(scores.contains(&format!("\"missing: {reason}")) && !scores.contains("failed"), "{scores}");

    for (more, expected) in [(&["--shard", "1/1"][..], 3), (&["--shard", "1/1", "--allow-missing"], 0)] {
        let (code, _, told) = run(more);
        assert!(
            code == expected && told.contains("not there: T, Run, always: ") && !told.contains("failed"),
            "{told}"
        );
    }
}

const WITHOUT_BOX_SPEC: &str = r#"schema = 1
name = "mine/boxes"
title = "Frames without a box"

[suites]
test = "my-boxes"

[[tracker-group]]
group = "boxes"
trackers = [
    { name = "replay", results = "T", label = "absent", without_area = "absent" },
    { name = "replay", results = "T", label = "repeat", without_area = "repeat" },
]

[[tracker-group]]
group = "confidence"
without_area = "absent"
trackers = [
    { name = "replay", results = "empty", label = "empty" },
    { name = "replay", results = "zero", label = "zero" },
]

[[analysis]]
name = "got10k"
compute = { kind = "success", rules = "got10k/1" }
suites = ["test"]
trackers = ["boxes"]

[[analysis]]
name = "lasot"
compute = { kind = "success", rules = "lasot/1" }
suites = ["test"]
trackers = ["boxes"]

[[analysis]]
name = "overlap"
compute = { kind = "average-overlap" }
suites = ["test"]
trackers = ["boxes"]

[[analysis]]
name = "vot"
compute = { kind = "longterm" }
signal = { kind = "confidence" }
suites = ["test"]
trackers = ["confidence"]

[[table]]
name = "overlap"
shows = "overlap.overall"

[[table]]
name = "vot"
shows = "vot.overall"
"#;

// got10k 0.1.3 for a box and 29 times 0,0,0,0 on a target that stands still: success 20/21 and precision 1 in the first frame
// alone. vot-toolkit 0.9.0, `vot/analysis/longterm.py`, for no box in five frames of 30: a confidence that is missing is 0.
#[test]
fn frames_without_a_box_count_as_the_words_of_the_experiment_say() {
    let dir = tempfile::tempdir().unwrap();
    let (data, here) = (dir.path().join("data"), dir.path());
    write(&data, "datasets.lock", BOXES_LOCK);
    write(&data, "truth/Walk.txt", &"1,1,9,9\n".repeat(30));
    write(&data, "results/T/Walk.txt", &("1,1,9,9\n".to_string() + &"0,0,0,0\n".repeat(29)));
    for (name, none) in [("empty", "\n"), ("zero", "0\n")] {
        let lines = |one: &str, none: &str| one.repeat(20) + &none.repeat(5) + &one.repeat(5);
        write(&data, &format!("results/{name}/Walk.txt"), &lines("1,1,9,9\n", "nan,nan,nan,nan\n"));
        write(&data, &format!("results/{name}/Walk_confidence.value"), &lines("0.9\n", none));
    }
    write(here, "spec.toml", WITHOUT_BOX_SPEC);
    let at = |name: &str| here.join(name).to_str().unwrap().to_owned();
    let (spec, r, p) = (at("spec.toml"), at("r"), at("p"));
    let run = ["run", &spec, "--results", &r, "--reports", &p, "--data-root", data.to_str().unwrap()];
    let (code, said, told) = output(&run);
    assert_eq!(code, 0, "{said}{told}");
    let found = std::fs::read(here.join("r/mine/boxes/analyses.json")).unwrap();
    let found: Vec<serde_json::Value> = serde_json::from_slice(&found).unwrap();
    for (analysis, tracker, name, expected) in [
        ("got10k", "absent", "success_auc", 20.0 / 21.0 / 30.0),
        ("got10k", "absent", "precision_20", 1.0 / 30.0),
        ("lasot", "absent", "success_auc", 20.0 / 21.0),
        ("got10k", "repeat", "success_auc", 20.0 / 21.0),
        ("overlap", "absent", "ao", 0.0),
        ("overlap", "repeat", "ao", 1.0),
        ("vot", "empty", "lt_precision", 1.0),
        ("vot", "empty", "lt_recall", 25.0 / 30.0),
        ("vot", "zero", "lt_precision", 1.0),
        ("vot", "zero", "lt_recall", 25.0 / 30.0),
    ] {
        let is_it = |a: &&serde_json::Value| a["analysis"] == analysis && a["tracker"] == tracker;
        let numbers = found.iter().find(is_it).unwrap()["findings"]["numbers"].as_array().unwrap();
        let number = numbers.iter().find(|n| n[0] == name).unwrap()[1].as_f64().unwrap();
        assert!((number - expected).abs() < 1e-12, "{analysis} {tracker} {name}: {number}");
    }
}
