use super::super::manifest::{FORMAT, Manifest, MethodRecord, SuiteRecord, TrackerRecord};
use super::*;
use crate::report::claims;
use crate::sampling::{Sampling, Units, in_common, metric_of_sum};
use crate::table;
use crate::testing::{MANIFEST, failed_cell};
use serde_json::json;
use tempfile::TempDir;
use trackfail_engine::spec::read::parse;
use trackfail_methods::score::{Counts, Metric};
use trackfail_testing::assert_says;

/// TP, FP and FN of the methods `old` and `new` on four sequences.
const OLD: [[u64; 3]; 4] = [[1, 0, 1], [2, 1, 0], [0, 1, 1], [9, 9, 0]];
const NEW: [[u64; 3]; 4] = [[2, 0, 0], [1, 0, 1], [1, 1, 0], [0, 0, 9]];
const NAMES: [&str; 4] = ["a", "b", "c", "d"];

/// An experiment: its name with further keys, its tracker, its methods.
fn text(name: &str, tracker: &str, methods: &[&str]) -> String {
    let method = |name: &&str| {
        format!(
            "[[method]]\nname = \"{name}\"\nsignal.kind = \"rgb-histogram\"\ndetector = {{ kind = \"level\", below = 0.9 }}\n"
        )
    };
    let methods: String = methods.iter().map(method).collect();
    format!(
        "schema = 1\nname = {name}\ntitle = \"t\"\nprotocol = \"khalid2016/1\"\nseed = 7\n[suites]\n\
         test = \"synthetic-otb\"\n[[tracker]]\n{tracker}\n{methods}[[table]]\nname = \"parts\"\n\
         rows = [\"f_score\", \"recall\", \"tp\"]\ncolumns = \"method\"\n[[table]]\nname = \"board\"\nrank = \"f_score\"\n"
    )
}

/// Results of an experiment on the first sequences, with the counts of each of its methods.
fn written(text: &str, sequences: usize, methods: &[(&str, [[u64; 3]; 4])]) -> TempDir {
    let experiment = parse("a.toml", text).unwrap();
    let names = &NAMES[..sequences];
    let label = experiment.trackers[0].label.as_str();
    let counts = |[tp, fp, fn_]: [u64; 3]| Counts { tp, fp, fn_, tn: 5 };
    let (mut scores, mut measures) = (Vec::new(), Vec::new());
    for &(method, of) in methods {
        scores.extend(names.iter().zip(of).map(|(&sequence, of)| Score {
            track: (sequence, label, 0),
            method,
            counts: Some(counts(of)),
            status: "ok".to_string(),
            ..Score::default()
        }));
        let all: Counts = of.into_iter().take(sequences).map(counts).sum();
        let (of, done) = ((label, method, ""), sequences as i64);
        measures.push(MeasureRow { of, done, counts: Some(all), ..MeasureRow::default() });
    }
    let files = [
        (SPEC, text.as_bytes().to_vec()),
        (Score::NAME, Score::csv("synthetic-otb", scores).unwrap()),
        (MeasureRow::NAME, MeasureRow::csv("synthetic-otb", measures).unwrap()),
    ];
    let digest = |name: &&str| (name.to_string(), format!("digest of {name}"));
    let base: Manifest = serde_json::from_slice(MANIFEST).unwrap();
    let present = names.iter().map(|name| (name.to_string(), 9)).collect();
    let manifest = Manifest {
        format: FORMAT,
        experiment: experiment.name.clone(),
        spec_digest: sha256(text.as_bytes()),
        seed: experiment.seed,
        suite: SuiteRecord { name: "synthetic-otb".to_string(), wanted: 4, present, ..base.suite },
        digests: BTreeMap::from([("synthetic-otb".to_string(), names.iter().map(digest).collect())]),
        trackers: experiment.trackers.iter().map(TrackerRecord::of).collect(),
        cells_done: sequences * methods.len(),
        files: files.iter().map(|(name, bytes)| (name.to_string(), sha256(bytes))).collect(),
        ..base
    };
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in &files {
        store::write(&folder.path().join(name), bytes).unwrap();
    }
    write_json(&folder.path().join(manifest::FILE), &manifest).unwrap();
    folder
}

const NCC: &str = "name = \"ncc\"";
/// Another tracker.
const OTHER: &str = "name = \"ncc\"\nlabel = \"mine\"\nsearch = 1.5";
/// A threshold that is trained.
const TRAINED: &str = "{ train = \"others\", maximise = \"f_score\", grid = { values = [0.5, 0.9] } }";
const MINE: &str = "\"mine/new\"\nbeside = \"kept/old\"";

fn kept() -> TempDir {
    written(&text("\"kept/old\"", NCC, &["old"]), 4, &[("old", OLD)])
}

/// The results of `new` on the first sequences, with those of `old` beside them.
fn joined(sequences: usize) -> TempDir {
    let own = written(&text(MINE, NCC, &["new"]), sequences, &[("new", NEW)]);
    keep(&Kept::read(kept().path()).unwrap(), own.path()).unwrap();
    own
}

// By hand: on a, b and c `old` has 3 TP, 2 FP and 2 FN, so F is 6 / (6 + 2 + 2); with d 12 TP, 11 FP, 2 FN: 24 / (24 + 11 + 2).
#[test]
fn kept_methods_stand_beside_own_ones() {
    let value = |results: &Results, method: &str| {
        let measure = results.measures.iter().find(|m| m.method == method).unwrap();
        (measure.done, measure.value(Metric::F_SCORE))
    };
    let folder = joined(3);
    let mut results = Results::read(folder.path()).unwrap();
    assert_eq!(value(&results, "new"), (3, Some(8.0 / 10.0)));
    assert_eq!(value(&results, "old (kept)"), (3, Some(0.6)));
    let scores = results.scores().unwrap();
    let kept = scores.iter().filter(|s| s.method == "old (kept)").map(|s| s.sequence.as_str());
    assert_eq!(kept.collect::<Vec<_>>(), ["a", "b", "c"]);
    assert!(results.beside.as_ref().unwrap().note.contains("of its 4 sequences"));
    // Another caption needs no other results, nor does a report that is made again.
    let changed = folder.path().join("changed.toml");
    std::fs::write(&changed, text(MINE, NCC, &["new"]).replace("title = \"t\"", "title = \"u\"")).unwrap();
    results.present(&changed).unwrap();
    results.keep().unwrap();
    let results = Results::read(folder.path()).unwrap();
    let methods: Vec<&str> = results.experiment.methods.iter().map(|m| m.name.as_str()).collect();
    assert_eq!((results.experiment.title.as_str(), &methods[..]), ("u", &["new", "old (kept)"][..]));
    assert!(results.experiment.tables.iter().all(|table| table.methods == methods));

    let whole = Results::read(joined(4).path()).unwrap();
    assert_eq!(value(&whole, "old (kept)"), (4, Some(24.0 / 37.0)));
    assert!(!whole.beside.unwrap().note.contains("empty"));
}

// One bootstrap: tables and intervals are those of an experiment that ran both methods.
#[test]
fn joined_results_are_those_of_both() {
    let (joined, both) = (joined(3), text("\"mine/new\"", NCC, &["new", "old"]));
    let both = written(&both, 3, &[("new", NEW), ("old", OLD)]);
    let [joined, both] = [joined.path(), both.path()].map(|folder| Results::read(folder).unwrap());
    let of = |results: &Results, old: &str| {
        let scores = results.scores().unwrap();
        let units = Units::new(&results.experiment, &scores);
        let pairs = in_common(units.of("ncc", "new").unwrap(), units.of("ncc", old).unwrap());
        let recall = |sum: &[i64; 4]| metric_of_sum(Metric::RECALL, None, sum);
        let difference = Sampling::new(&results.experiment).difference(&pairs, recall);
        assert!(difference.is_some_and(|(low, high)| low < high), "{difference:?}");
        let tables = table::layouts(results, &scores, &units);
        let groups: Vec<_> = tables.iter().map(|table| (&table.columns, &table.groups)).collect();
        format!("{difference:?} {groups:?}").replace(MARK, "")
    };
    assert_eq!(of(&joined, "old (kept)"), of(&both, "old"));
}

#[test]
fn kept_trackers_stand_beside_an_own_one() {
    let claim = "[[claim]]\ntext = \"c\"\nholds = \"recall[old] >= 0\"\n";
    let other = text(MINE, OTHER, &["old", "new"]) + claim;
    let own = written(&other, 3, &[("old", NEW), ("new", NEW)]);
    keep(&Kept::read(kept().path()).unwrap(), own.path()).unwrap();
    let results = Results::read(own.path()).unwrap();
    let rows = results.measures.iter().map(|m| (m.tracker.as_str(), m.method.as_str(), m.pooled.counts.tp));
    let expected = [("mine", "old", 4), ("mine", "new", 4), ("ncc (kept)", "old", 3)];
    assert_eq!(rows.collect::<Vec<_>>(), expected);
    let runs = |k: usize| results.experiment.methods[k].runs_on("ncc (kept)");
    assert!(runs(0) && !runs(1));
    // Nobody claims anything of the kept trackers.
    let units = Units::new(&results.experiment, &results.scores().unwrap());
    let tested = claims::test(&results, &units).remove(0).tested;
    assert!(tested.len() == 1 && tested[0].tracker == "mine", "{tested:?}");
    assert!(!results.beside.unwrap().note.contains("trained"));
}

// A new tracker changes what the others learn from.
#[test]
fn the_note_says_which_methods_were_trained_without_the_new_tracker() {
    let trained = |text: String| text.replace("below = 0.9", &format!("below = {TRAINED}"));
    let other = written(&trained(text("\"kept/old\"", NCC, &["old"])), 4, &[("old", OLD)]);
    let own = written(&trained(text(MINE, OTHER, &["old", "new"])), 3, &[("old", NEW), ("new", NEW)]);
    keep(&Kept::read(other.path()).unwrap(), own.path()).unwrap();
    let note = Results::read(own.path()).unwrap().beside.unwrap().note;
    let words = "learn from several trackers (old) were trained without the new trackers in kept rows";
    assert!(note.contains(words), "{note}");
}

#[test]
fn kept_cells_that_failed_are_counted() {
    let failed = |sequence, method| failed_cell(sequence, "ncc", method, false, "it ended");
    let folder = kept();
    let mut there = Kept::read(folder.path()).unwrap();
    there.results.manifest.cells_failed =
        vec![failed("a", "old"), failed("b", "old[x=1]"), failed("b", ""), failed("d", "old")];
    let own = written(&text(MINE, NCC, &["new"]), 3, &[("new", NEW)]);
    keep(&there, own.path()).unwrap();
    let mut results = Results::read(own.path()).unwrap();
    let cells = results.cells_failed().map(|c| (c.sequence.as_str(), c.method.as_str()));
    assert_eq!(cells.collect::<Vec<_>>(), [("a", "old (kept)"), ("b", "old (kept)[x=1]")]);
    // In a table by attribute, too.
    results.manifest.suite.attributes = BTreeMap::from([("a".to_string(), vec!["dark".to_string()])]);
    let table =
        "[[table]]\nname = \"dark\"\nrows = [\"attribute\"]\ncolumns = \"method\"\nmetric = \"recall\"\n";
    let by_attribute = parse("a.toml", &(text(MINE, NCC, &["new"]) + table)).unwrap();
    let measures = table::pooled(&results, &results.scores().unwrap(), &by_attribute.tables);
    let dark = measures.iter().filter(|m| m.attribute.is_some());
    let counts = dark.map(|m| (m.method.as_str(), m.done, m.failed)).collect::<Vec<_>>();
    assert_eq!(counts, [("new", 1, 0), ("old (kept)", 1, 1)]);
}

/// Digests of a test suite.
fn digests(of_b: &str) -> BTreeMap<String, Vec<(String, String)>> {
    BTreeMap::from([("synthetic-otb".to_string(), vec![("b".to_string(), of_b.to_string())])])
}

#[test]
fn another_partner_is_refused_with_both_named() {
    let folder = kept();
    let mut there = Results::read_alone(folder.path()).unwrap();
    let told = |from: &str, to: &str, digests: &BTreeMap<_, _>, there: &Results| {
        let own = text(MINE, NCC, &["new"]);
        assert!(own.contains(from), "{from}");
        let own = parse("a.toml", &own.replace(from, to)).unwrap();
        check(&own, None, digests, there).map_err(|e| e.to_string())
    };
    let right = digests("digest of b");
    assert_eq!(told("seed", "seed", &right, &there), Ok(()));
    let other_tracker = "name = \"still\"\nlabel = \"ncc\"";
    for (from, to, words) in [
        ("khalid2016/1", "khalid2016/2", "the protocol is khalid2016/2 here and khalid2016/1 there"),
        ("seed = 7", "seed = 8", "the seed is 8 here and 7 there"),
        ("synthetic-otb", "synthetic-vot", "the suite is synthetic-vot here and synthetic-otb there"),
        (NCC, other_tracker, "tracker ncc is still version"),
        (NCC, "name = \"still\"", "they have no tracker and no method in common"),
        ("\"new\"\nsignal", "\"old (kept)\"\nsignal", "the name `old (kept)` is that of a kept one"),
        ("\"new\"\nsignal", "\"my (kept)\"\nsignal", "the name `my (kept)` is that of a kept one"),
        (NCC, "name = \"ncc\"\nlabel = \"my (kept)\"", "the name `my (kept)` is that of a kept one"),
    ] {
        let told = told(from, to, &right, &there).unwrap_err();
        assert!(told.starts_with("mine/new cannot stand beside kept/old: "), "{told}");
        assert_says(told, words);
    }
    let changed = told("seed", "seed", &digests("other"), &there).unwrap_err();
    assert_says(changed, "sequence b is other here and digest of b there");
    assert_says(told("seed", "seed", &BTreeMap::new(), &there).unwrap_err(), "no sequence in common");
    // A parameter of an earlier version, that the experiment file does not have.
    there.manifest.trackers[0].params["gone"] = true.into();
    assert_eq!(told("seed", "seed", &right, &there), Ok(()));
    let version = there.manifest.trackers[0].version;
    there.manifest.trackers[0].version = version + 1;
    let told = told("seed", "seed", &right, &there).unwrap_err();
    for words in [format!("is ncc version {version} "), format!("and ncc version {} ", version + 1)] {
        assert!(told.contains(&words), "{told}");
    }
}

// Beside another tracker, the methods of one name must be the same.
#[test]
fn another_method_of_the_name_is_refused() {
    let digests = digests("digest of b");
    let with = |text: String, below: &str| text.replace("below = 0.9", &format!("below = {below}"));
    let own = |below: &str| with(text(MINE, OTHER, &["old"]), below);
    let read = |below: &str| {
        let text = with(text("\"kept/old\"", NCC, &["old"]), below);
        Results::read_alone(written(&text, 4, &[("old", OLD)]).path()).unwrap()
    };
    let told = |own: &str, there: &Results| {
        check(&parse("a.toml", own).unwrap(), None, &digests, there).map_err(|e| e.to_string())
    };
    let (mut given, trained) = (read("0.9"), read(TRAINED));
    assert_eq!(told(&own("0.9"), &given), Ok(()));
    assert_eq!(told(&own(TRAINED), &trained), Ok(()));
    let others = "the training of method old is `below` on others of synthetic-otb by video, by ";
    let (signal, first) = ("signal.kind = \"rgb-histogram\"", "\nsignal.reference = \"first\"");
    for (own, there, words) in [
        (own("0.8"), &given, "the detector of method old is level version "),
        (own("0.9").replace(signal, &format!("{signal}{first}")), &given, "the signal of method old is "),
        (own("0.9").replace("khalid2016/1", "khalid2016/2"), &given, "the protocol of method old is "),
        (own(TRAINED), &given, others),
        (own(&TRAINED.replace("f_score", "recall")), &trained, "by recall among 0.5, 0.9 here and "),
        (own(&TRAINED.replace("0.9", "0.8")), &trained, "by f_score among 0.5, 0.8 here and "),
        (own(&TRAINED.replace("values = [0.5, 0.9]", "quantiles = 9")), &trained, "among 9 quantiles here"),
        (own(TRAINED).replace("seed = 7", "seed = 7\nfolds = \"source\""), &trained, "by source, by f_score"),
    ] {
        assert_says(told(&own, there).unwrap_err(), words);
    }
    // Versions are those of the run, parameters those of the experiment file.
    let variant = &given.experiment.methods[0].variants[0];
    let (signal, detector) = (variant.signals.first().unwrap(), &variant.detector.example);
    let record = |version: u32| -> MethodRecord {
        let signal = json!([signal.kind, signal.version, { "gone": 1 }]);
        let detector = json!([detector.kind, version, { "gone": 1 }]);
        let whole =
            json!({ "name": "old", "params": "", "signal": signal, "detector": detector, "thresholds": {} });
        serde_json::from_value(whole).unwrap()
    };
    let (same, later) = (record(detector.version), record(detector.version + 1));
    given.manifest.methods = vec![same];
    assert_eq!(told(&own("0.9"), &given), Ok(()));
    given.manifest.methods = vec![later];
    assert_says(told(&own("0.9"), &given).unwrap_err(), "the detector of method old is level version ");
}

#[test]
fn another_copy_is_refused() {
    for name in [FILE, "beside/scores.csv"] {
        let folder = joined(3);
        let path = folder.path().join(name);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text + " ").unwrap();
        let refused = Results::read(folder.path()).map(drop).unwrap_err().to_string();
        assert!(
            refused.starts_with(&format!("{}: not the file that the run wrote", path.display())),
            "{refused}"
        );
    }
}
