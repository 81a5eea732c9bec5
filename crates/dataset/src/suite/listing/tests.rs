use super::super::Catalog;
use super::*;
use crate::lock::pinned_suites;
use std::collections::BTreeMap;
use trackfail_testing::{needs, put, real_data};

fn format(word: &str) -> &'static FormatEntry {
    crate::format::find(word).unwrap()
}

fn entry(line: &str) -> Entry {
    toml::from_str::<BTreeMap<String, Entry>>(&format!("entry = {line}")).unwrap().remove("entry").unwrap()
}

/// Root with one folder of files, each containing its own name, and the folder's section.
fn seen(format: &'static FormatEntry, names: &[&str]) -> (tempfile::TempDir, String) {
    let root = trackfail_testing::folder(names.iter().map(|name| (format!("a/b/{name}"), name)));
    let text = section("a/b", root.path(), format).unwrap();
    (root, text)
}

// printf '%s' NAME | sha256sum | cut -c1-8
#[test]
fn a_section_is_written_and_read_back() {
    let names = ["img/0004.jpg", "img/0003.jpg", "img/0006.png", "groundtruth_rect.txt", "notes.txt"];
    let (_root, text) = seen(format("otb"), &names);
    let expected = [
        ("groundtruth_rect.txt", "1adb3141"),
        ("img/0003.jpg", "acc47e4d"),
        ("img/0004.jpg", "c9e133f6"),
        ("img/0006.png", "81304915"),
    ];
    let lines = expected.map(|(name, digest)| format!(" {name} {digest}\n")).concat();
    assert_eq!(text, format!("a/b\n{lines}"));
    let among_others = format!("# seen\na\n b 12345678\n{text}a/b/c\n d 12345678\n");
    assert_eq!(listed(&among_others, "a/b"), expected);
    assert!(listed(&among_others, "b").is_empty());
}

#[test]
fn the_first_difference_is_named() {
    let names = ["img/0001.jpg", "img/0002.jpg", "img/0003.jpg", "img/0004.jpg", "groundtruth_rect.1.txt"];
    let (root, text) = seen(format("otb"), &names);
    let files = listed(&text, "a/b");
    let entry = entry(
        r#"{ name = "x", folder = "a/b", target = 1, range = [2, 3], official = [1, 9], digest = "" }"#,
    );
    let first = || first_difference(&entry, format("otb"), root.path(), &files, |_| true);
    let write = |name: &str, text: &str| drop(put(root.path(), format!("a/b/{name}"), text));
    assert_eq!(first(), None);
    // Neither another target's truth nor frames outside the range have to do with it.
    write("groundtruth_rect.2.txt", "x");
    write("img/0004.jpg", "x");
    write("img/0005.jpg", "x");
    assert_eq!(first(), None);
    write("img/x3.png", "x");
    assert_eq!(first().unwrap(), "img/x3.png does not belong there");
    write("img/0003.jpg", "x");
    assert!(first().unwrap().starts_with("img/0003.jpg is another file: its SHA-256 starts with 2d711642, "));
    std::fs::remove_file(root.path().join("a/b/img/0002.jpg")).unwrap();
    assert_eq!(first().unwrap(), "img/0002.jpg is missing");
    write("groundtruth_rect.1.txt", "x");
    assert!(first().unwrap().starts_with("groundtruth_rect.1.txt is another file"));
}

#[test]
fn videos_and_labels_are_files_too() {
    let (root, text) = seen(format("cvml"), &["gt.xml", "clip.mpg", "readme.txt"]);
    let files = listed(&text, "a/b");
    let clip = entry(r#"{ name = "x", folder = "a/b" }"#);
    assert_eq!(first_difference(&clip, format("cvml"), root.path(), &files, |_| true), None);
    put(root.path(), "a/b/clip.mpg", "clip.mpG");
    let found = first_difference(&clip, format("cvml"), root.path(), &files, |_| true).unwrap();
    assert!(found.starts_with("clip.mpg is another file"), "{found}");

    let (root, text) = seen(format("vot"), &["00000000.jpg", "00000001.jpg", "groundtruth.txt", "a.label"]);
    let files = listed(&text, "a/b");
    let labels = |wanted| first_difference(&clip, format("vot"), root.path(), &files, wanted);
    put(root.path(), "a/b/00000000.jpg", "x");
    assert_eq!(labels(|_| true), None, "frame 0 is no part of a VOT sequence");
    put(root.path(), "a/b/b.label", "1");
    assert_eq!(labels(|_| true).unwrap(), "b.label does not belong there");
}

#[test]
fn every_pinned_sequence_is_listed() {
    for suite in pinned_suites() {
        for e in suite.sequence.iter().filter(|e| e.size.is_some()) {
            let files = listed(FILES, &e.folder);
            let mine = files.iter().filter(|(name, _)| belongs(e, suite.format(e), name));
            let mine: Vec<&str> = mine.map(|(name, _)| *name).collect();
            let images = mine.iter().filter(|name| is_image(Path::new(name))).count();
            let videos = mine.iter().filter(|name| name.ends_with(".mpg")).count();
            assert!((videos, images) == (1, 0) || Some(images) == e.frames, "{}/{}", suite.name, e.name);
            assert!(images + videos < mine.len(), "{}/{}", suite.name, e.name);
        }
    }
}

#[needs(real_data)]
#[test]
fn sections_are_as_data_lock_writes_them() {
    let (catalog, roots) = (Catalog::default(), [real_data()]);
    let found: Vec<_> = catalog.suites().flat_map(|suite| suite.pin_files(&roots).unwrap()).collect();
    assert!(!found.is_empty());
    for (folder, text) in found {
        assert_eq!(listed(&text, &folder), listed(FILES, &folder));
    }
}
