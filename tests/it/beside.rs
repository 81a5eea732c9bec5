//! Kept results beside those of an experiment: one table, one bootstrap, and partners that are refused.

use crate::sent::changes_are_told;
use crate::tools::{Place, assert_same_files, assert_says, files};
use trackfail::results::beside::{Kept, keep};

/// An experiment with these keys behind its name, and these methods, each with its threshold.
fn spec(keys: &str, methods: &[(&str, f64)]) -> String {
    let method = |(name, below): &(&str, f64)| {
        format!(
            "[[method]]\nname = \"{name}\"\nsignal.kind = \"rgb-histogram\"\n\
             detector = {{ kind = \"level\", below = {below} }}\n"
        )
    };
    let methods: String = methods.iter().map(method).collect();
    format!(
        "schema = 1\nname = {keys}\ntitle = \"t\"\nprotocol = \"khalid2016/1\"\nseed = 3\nleaderboard = true\n\
         suites.test = \"synthetic-otb\"\ntracker = [{{ name = \"still\" }}]\n{methods}\
         [[table]]\nname = \"parts\"\nrows = [\"attribute\"]\ncolumns = \"method\"\nmetric = \"recall\"\n\
         [[table]]\nname = \"board\"\nrank = \"f_score\"\n[[table]]\nname = \"frames\"\nrank = \"auroc\"\n"
    )
}

const OLD: [(&str, f64); 2] = [("level", 0.9), ("low", 0.7)];
const MINE: &str = "\"mine/new\"\nbeside = \"kept/old\"";

/// A place with the results that are kept.
fn kept() -> Place {
    let place = Place::with(&[
        ("old.toml", &spec("\"kept/old\"", &OLD)),
        ("mine.toml", &spec(MINE, &[("strict", 0.3)])),
        ("both.toml", &spec("\"mine/new\"", &[("strict", 0.3), OLD[0], OLD[1]])),
    ]);
    place.run("run old.toml -q --compact").ends(0);
    place
}

#[test]
fn kept_rows_are_those_of_one_run() {
    let place = kept();
    place.run("run mine.toml").ends(0).says("level (kept)");
    place.run("run both.toml -q --results other --reports elsewhere").ends(0);
    for table in ["parts", "board", "frames"] {
        let of = |results: &str| place.read(&format!("{results}/mine/new/tables/{table}.csv"));
        assert_eq!(of("results").replace(" (kept)", ""), of("other"), "{table}");
    }
    assert_says(place.read("reports/mine/new/report.md"), "Rows marked (kept) are those of kept/old");
    let summary = place.json("reports/mine/new/summary.json");
    let methods: Vec<&str> =
        summary["standings"].as_array().unwrap().iter().map(|s| s["method"].as_str().unwrap()).collect();
    assert_eq!(methods, ["strict", "level", "low"]);
    // The results stand by themselves.
    std::fs::rename(place.path("reports"), place.path("before")).unwrap();
    let before_run = Kept::read(&place.path("results/kept/old")).unwrap();
    std::fs::remove_dir_all(place.path("results/kept")).unwrap();
    place.run("report mine/new").ends(0);
    assert_same_files(&place.path("before/mine/new"), &place.path("reports/mine/new"));
    place.run("explain mine/new/board 'level (kept)' f_score").ends(0).says("F1 score of level (kept)");
    // They are those from before the run, whatever became of them meanwhile.
    let copy = files(&place.path("results/mine/new/beside"));
    std::fs::remove_dir_all(place.path("results/mine/new/beside")).unwrap();
    keep(&before_run, &place.path("results/mine/new")).unwrap();
    assert!(copy == files(&place.path("results/mine/new/beside")));
}

/// Changes what a manifest says of the first sequence of the training suite, and gives the right digest.
fn with_other_training(place: &Place, manifest: &str) -> String {
    let digest = place.json(manifest)["digests"]["synthetic-vot"][0][1].as_str().unwrap().to_string();
    place.write(manifest, place.read(manifest).replacen(&digest, "other", 1));
    digest
}

#[test]
fn partners_that_learned_from_other_data_are_refused_by_runs_and_reports() {
    let place = Place::new();
    let trained = "{ train = \"train\", maximise = \"f_score\", grid = { values = [0.5, 0.9] } }";
    for (file, keys, label) in [("old.toml", "\"kept/old\"", "old"), ("mine.toml", MINE, "mine")] {
        let text = spec(keys, &OLD[..1])
            .replace("below = 0.9", &format!("below = {trained}"))
            .replace("suites.test", "suites.train = \"synthetic-vot\"\nsuites.test")
            .replace("\"still\"", &format!("\"still\", label = \"{label}\""));
        place.write(file, text);
        place.run(&format!("run {file} -q --compact")).ends(0);
    }
    let digest = with_other_training(&place, "results/mine/new/manifest.json");
    let words = format!("of synthetic-vot is other here and {digest} there; run mine/new again");
    place.run("report mine/new").refuses(1, &words);
    with_other_training(&place, "results/kept/old/manifest.json");
    place.run("run mine.toml -q").refuses(2, &format!("of synthetic-vot is {digest} here and other there"));
}

#[test]
fn sent_results_have_their_copy_of_kept_ones() {
    let place = kept();
    place.run("run mine.toml -q").ends(0);
    place.run("pack mine/new").ends(0);
    place.run("data verify results/mine/new").ends(0).says("not checked").never_says("beside");
    place.run("data verify mine-new.zip --unpack got").ends(0);
    let copy = files(&place.path("got/mine/new/beside"));
    assert!(copy.len() > 3 && copy == files(&place.path("results/mine/new/beside")));
    place.run("report --results got --reports seen").ends(0);
    let board = |results: &str| place.read(&format!("{results}/mine/new/tables/board.csv"));
    assert!(board("got").contains("level (kept)") && board("got") == board("results"));
    place.run("pack mine/new --results got --to again.zip").ends(0);
    assert!(place.bytes("mine-new.zip") == place.bytes("again.zip"));
    changes_are_told(&place, "mine/new", "beside/scores.parquet", "beside/notes.txt");
}

#[test]
fn other_partners_are_refused_before_anything_runs() {
    let place = kept();
    for (from, to, words) in [
        ("seed = 3", "seed = 4", "mine/new cannot stand beside kept/old: the seed is 4 here and 3 there"),
        ("synthetic-otb", "synthetic-vot", "synthetic-vot"),
        ("kept/old", "kept/odd", "did you mean `kept/old`?"),
        ("kept/old", "mine/new", "must name another experiment"),
        ("kept/old", "../old", "must be the name of an experiment"),
    ] {
        place.write("wrong.toml", spec(MINE, &[("strict", 0.3)]).replace(from, to));
        place.run("run wrong.toml -q").ends(2).tells(words);
        assert!(!place.has("results/mine/new"), "{to}");
    }
}
