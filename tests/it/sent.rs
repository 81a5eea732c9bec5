//! Results as one file: `pack`, and what `data verify` says of it at its receiver's.

use crate::fetch::sha256;
use crate::packed::{zip, zipped};
use crate::tools::{Place, files};
use serde_json::Value;
use std::io::{Cursor, Read};
use std::path::Path;

/// Small results, and the file that `pack` makes of them.
const SMALL: &str = "sanmiguel2015/fig14-real";
const PACKED: &str = "sanmiguel2015-fig14-real.zip";

/// Copies kept results of an experiment into a place.
pub fn keep(place: &Place, experiment: &str) {
    for (name, bytes) in files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("results").join(experiment)) {
        place.write(&format!("results/{experiment}/{}", name.display()), bytes);
    }
}

/// A place with kept results of an experiment.
pub fn place_with(experiment: &str) -> Place {
    let place = Place::new();
    keep(&place, experiment);
    place
}

/// A place with small results, and the bytes of their file.
fn packed() -> (Place, Vec<u8>) {
    let place = place_with(SMALL);
    place.run(&format!("pack {SMALL}")).ends(0);
    let bytes = place.bytes(PACKED);
    (place, bytes)
}

type Members = Vec<(String, Vec<u8>)>;

fn members(bytes: &[u8]) -> Members {
    let mut archive = ::zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut all = Members::new();
    for k in 0..archive.len() {
        let mut member = archive.by_index(k).unwrap();
        let name = String::from_utf8(member.name_raw().to_vec()).unwrap();
        let mut data = Vec::new();
        member.read_to_end(&mut data).unwrap();
        all.push((name, data));
    }
    all
}

#[test]
fn sent_results_arrive_whole() {
    let place = place_with("quickstart");
    let told = place.run("pack quickstart").ends(0).out;
    let sent = place.bytes("quickstart.zip");
    // 1 January 1980, whenever and wherever it is packed.
    assert_eq!(sent[10..14], [0, 0, 0x21, 0]);
    let names: Vec<String> = members(&sent).into_iter().map(|(name, _)| name).collect();
    assert!(names[0] == "manifest.json" && names[1..].is_sorted(), "{names:?}");

    let digest = told.split('"').nth(1).unwrap();
    let told = place.run("data verify quickstart.zip").ends(0).says(digest).says("khalid2016/1");
    told.says("synthetic-otb: 20 of 20 sequences, ")
        .says("written by     trackfail ")
        .never_says("not checked");
    let unpack = || place.run("data verify quickstart.zip --unpack got");
    unpack().ends(0).says("unpacked into got/quickstart\n");
    assert_eq!(place.list("got"), [place.path("got/quickstart")]);
    let results = |folder: &str| {
        let mut files = files(&place.path(folder));
        files.retain(|name, _| !name.starts_with("tables") && !name.ends_with("manifest.json"));
        files
    };
    let got = results("got/quickstart");
    assert!(got == results("results/quickstart"));
    for folder in ["models", "stills"] {
        assert!(got.keys().any(|name| name.starts_with(folder)), "{folder}");
    }
    place.run("data verify got/quickstart").ends(0).never_says("not checked");
    place.run("data verify results/quickstart").ends(0).says("not checked    models, stills, tables\n");
    unpack().refuses(2, "got/quickstart: there are results already");
    // The receiver can send them on.
    place.run("pack quickstart --results got --to again.zip").ends(0);
    assert!(sent == place.bytes("again.zip"));
}

#[test]
fn faults_of_sent_results_are_named() {
    let (place, bytes) = packed();
    let whole = members(&bytes);
    let refused = |change: &dyn Fn(&mut Members), words: &str| {
        let mut changed = whole.clone();
        change(&mut changed);
        let changed: Vec<_> = changed.iter().map(|(name, data)| zipped(name, data)).collect();
        place.write("bad.zip", zip(&changed));
        let ran = place.run("data verify bad.zip --unpack got").refuses(3, words).tells("bad.zip");
        ran.never_says(".trackfail-results");
        assert!(place.list("got").is_empty(), "{words}");
    };
    let at = |name: &str| whole.iter().position(|(known, _)| known == name).unwrap();
    let (manifest, spec, measures) = (at("manifest.json"), at("experiment.toml"), at("measures.csv"));
    refused(&|all| all[measures].1[99] ^= 1, "measures.csv is changed");
    refused(&|all| drop(all.remove(measures)), "measures.csv is missing");
    for (name, words) in [
        ("notes.txt", "notes.txt does not belong there"),
        ("run.json", "run.json does not belong there"),
        ("tables/a.md", "tables/a.md does not belong there"),
        ("other/manifest.json", "other/manifest.json does not belong there"),
        ("../notes.txt", "`..`"),
        ("/notes.txt", "absolute"),
        ("measures.csv", "the same name"),
    ] {
        refused(&|all| all.push((name.into(), b"x".to_vec())), words);
    }

    let text = String::from_utf8(whole[manifest].1.clone()).unwrap();
    // Another experiment among the files, as the manifest names it.
    for name in ["other/manifest.json", "models/manifest.json", "stills/a/manifest.json", "tables/a.csv"] {
        let mut named: Value = serde_json::from_str(&text).unwrap();
        named["files"][name] = sha256(text.as_bytes()).into();
        let plant = |all: &mut Members| {
            all[manifest].1 = named.to_string().into_bytes();
            all.push((name.into(), text.clone().into_bytes()));
        };
        refused(&plant, &format!("{name} does not belong there"));
    }
    refused(&|all| drop(all.remove(manifest)), "it has no manifest.json");
    refused(&|all| all[manifest].1 = b"{}".to_vec(), "manifest.json: missing field");
    let moved = text.replace(SMALL, "../notes");
    refused(&|all| all[manifest].1 = moved.clone().into_bytes(), "experiment.toml is of another experiment");
    // Another experiment, with the digest that the manifest must have for it.
    let later = b"schema = 99\n".to_vec();
    let named = text.replace(&sha256(&whole[spec].1), &sha256(&later));
    let swap = |all: &mut Members| {
        all[manifest].1 = named.clone().into_bytes();
        all[spec].1 = later.clone();
    };
    refused(&swap, "experiment.toml");
}

#[test]
fn damaged_files_are_refused_and_nothing_replaced() {
    let (place, whole) = packed();
    for k in 0..12 {
        let n = whole.len() * k / 12;
        place.write("cut.zip", &whole[..n]);
        place.run("data verify cut.zip").refuses(3, "cut.zip: not a whole zip file");
        let mut bytes = whole.clone();
        bytes[n] ^= 1;
        place.write("bad.zip", bytes);
        let code = place.run("data verify bad.zip").code;
        assert!(matches!(code, Some(0 | 3)), "{n}: {code:?}");
    }
    // Nothing is replaced; a link that leads nowhere is something, too.
    place.folder("got/sanmiguel2015");
    std::os::unix::fs::symlink("nowhere", place.path(&format!("got/{SMALL}"))).unwrap();
    place.run(&format!("data verify {PACKED} --unpack got")).refuses(2, "there are results already");
    assert_eq!(place.list("got").len(), 1);
}

/// A change of a file of results, its absence and a file of another kind are told, and a change is not packed.
pub fn changes_are_told(place: &Place, results: &str, file: &str, other: &str) {
    let path = |name: &str| format!("results/{results}/{name}");
    let verify = || place.run(&format!("data verify results/{results}"));
    let bytes = place.bytes(&path(file));
    place.write(&path(file), [&bytes[..], b"\n"].concat());
    verify().refuses(3, &format!("{file} is changed"));
    place.run(&format!("pack {results}")).refuses(1, &format!("{file} is changed"));
    place.remove(&path(file));
    verify().refuses(3, &format!("{file} is missing"));
    place.write(&path(file), bytes);
    place.write(&path(other), "x");
    verify().refuses(3, &format!("{other} does not belong there"));
}

#[test]
fn changed_results_are_not_packed() {
    let place = place_with(SMALL);
    // Results below these are another experiment's.
    place.write(&format!("results/{SMALL}/other/manifest.json"), "{}");
    place.run(&format!("data verify results/{SMALL}")).ends(0).says("7 of 7 sequences");
    changes_are_told(&place, SMALL, "measures.csv", "notes.txt");
    assert!(!place.has(PACKED));

    place.run(&format!("data verify results/{SMALL} --unpack got")).refuses(2, "--unpack takes a file");
    place.run("data verify --unpack got").refuses(2, "--unpack: name a file");
    place.run("data verify results/nothing").refuses(2, "results/nothing: no such file or folder");
    place.folder("results/empty");
    place.run("data verify results/empty").refuses(2, "results/empty: no manifest.json");
    place.run("pack nothing").refuses(2, "nothing");
}
