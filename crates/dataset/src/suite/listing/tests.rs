use super::*;
use proptest::prelude::*;
use trackfail_testing::{needs, real_data};

fn format(word: &str) -> &'static FormatEntry {
    crate::format::find(word).unwrap()
}

fn entry(line: &str) -> Entry {
    #[derive(serde::Deserialize)]
    struct One {
        sequence: [Entry; 1],
    }
    let One { sequence: [entry] } = toml::from_str(&format!("sequence = [{line}]")).unwrap();
    entry
}

/// A root with one folder of files, each with its name for content, and the folder's listing.
fn listed(format: &'static FormatEntry, names: &[&str]) -> (tempfile::TempDir, Vec<(String, String)>) {
    let root = tempfile::tempdir().unwrap();
    for name in names {
        let path = below(root.path(), &format!("a/b/{name}"));
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, name).unwrap();
    }
    let text = section("a/b", root.path(), format).unwrap();
    (root, read(text.strip_prefix("a/b\n").unwrap()))
}

// printf '%s' NAME | sha256sum | cut -c1-8
#[test]
fn a_section_is_written_and_read_back() {
    let names = ["img/0003.jpg", "img/0004.jpg", "img/0006.png", "groundtruth_rect.txt", "notes.txt"];
    let (root, files) = listed(format("otb"), &names);
    let text = section("a/b", root.path(), format("otb")).unwrap();
    assert_eq!(
        text,
        "a/b\n groundtruth_rect.txt 1adb3141\n img/%04d.jpg 3-4\n  acc47e4dc9e133f6\n img/0006.png 81304915\n"
    );
    let expected = [
        ("groundtruth_rect.txt", "1adb3141"),
        ("img/0003.jpg", "acc47e4d"),
        ("img/0004.jpg", "c9e133f6"),
        ("img/0006.png", "81304915"),
    ];
    assert_eq!(files, expected.map(|(name, digits)| (name.to_owned(), digits.to_owned())));
}

#[test]
fn the_first_difference_is_named() {
    let names = ["img/0001.jpg", "img/0002.jpg", "img/0003.jpg", "img/0004.jpg", "groundtruth_rect.1.txt"];
    let (root, files) = listed(format("otb"), &names);
    let entry = entry(
        r#"{ name = "x", folder = "a/b", target = 1, range = [2, 3], official = [1, 9], digest = "" }"#,
    );
    let first = || compare(&entry, format("otb"), root.path(), &files, |_| true);
    let write =
        |name: &str, text: &str| std::fs::write(below(root.path(), &format!("a/b/{name}")), text).unwrap();
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
    let (root, files) = listed(format("cvml"), &["gt.xml", "clip.mpg", "readme.txt"]);
    let clip = entry(r#"{ name = "x", folder = "a/b" }"#);
    assert_eq!(compare(&clip, format("cvml"), root.path(), &files, |_| true), None);
    std::fs::write(root.path().join("a/b/clip.mpg"), "clip.mpG").unwrap();
    let found = compare(&clip, format("cvml"), root.path(), &files, |_| true).unwrap();
    assert!(found.starts_with("clip.mpg is another file"), "{found}");

    let (root, files) =
        listed(format("vot"), &["00000000.jpg", "00000001.jpg", "groundtruth.txt", "a.label"]);
    let labels = |wanted| compare(&clip, format("vot"), root.path(), &files, wanted);
    std::fs::write(root.path().join("a/b/00000000.jpg"), "x").unwrap();
    assert_eq!(labels(|_| true), None, "frame 0 is no part of a VOT sequence");
    std::fs::write(root.path().join("a/b/b.label"), "1").unwrap();
    assert_eq!(labels(|_| true).unwrap(), "b.label does not belong there");
}

#[test]
fn every_pinned_sequence_is_listed() {
    for name in crate::lock::pinned_suite_names() {
        let suite = crate::lock::pinned_suite(name).unwrap();
        for e in suite.sequence.iter().filter(|e| e.size.is_some()) {
            let files = read(sections()[e.folder.as_str()]);
            let mine = files.iter().filter(|(name, _)| belongs(e, suite.format(e), Path::new(""), name));
            let (frames, text): (Vec<_>, Vec<_>) = mine.partition(|(name, _)| is_image(Path::new(name)));
            assert_eq!(Some(frames.len()), e.frames, "{name}/{}", e.name);
            assert!(!text.is_empty(), "{name}/{}", e.name);
        }
    }
}

#[needs(real_data)]
#[test]
fn sections_are_as_data_lock_writes_them() {
    let root = real_data();
    let mut seen = 0;
    for name in crate::lock::pinned_suite_names() {
        for (folder, text) in super::super::Catalog::default()
            .suite(name)
            .unwrap()
            .pin_files(std::slice::from_ref(&root))
            .unwrap()
        {
            assert_eq!(text, format!("{folder}\n{}", sections()[folder.as_str()]));
            seen += 1;
        }
    }
    assert!(seen > 0);
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(
        names in prop::collection::btree_set("(img/)?[a-z]{0,2}[0-9]{0,5}\\.(jpg|png|txt)", 0..40),
        digits in "[0-9a-f]{8}",
    ) {
        let files: Vec<_> = names.into_iter().filter(|n| !n.starts_with('.')).map(|n| (n, digits.clone())).collect();
        prop_assert_eq!(read(&write(&files)), files);
    }

    #[test]
    fn any_text_is_read(text in "[ a-f0-9%d\n.-]{0,200}") {
        let _ = read(&text);
    }
}
