use super::*;
use crate::archive::Packing;
use proptest::prelude::*;
use std::io::Cursor;
use std::path::Component;
use zip::write::{SimpleFileOptions, ZipWriter};

fn archive() -> Archive {
    let [name, url, into, below] = ["try", "http://h/try.zip", "otb", "all/of"].map(String::from);
    Archive { name, url, packing: Packing::Zip, size: None, sha256: None, into, below: Some(below) }
}

#[test]
fn plain_names_are_taken() {
    let long = "x".repeat(255);
    for (raw, wanted) in [
        ("David/img/0001.jpg", "David/img/0001.jpg"),
        ("David/", "David"),
        ("./a/b", "a/b"),
        ("./", ""),
        (".", ""),
        (".hidden", ".hidden"),
        ("..a/b..c", "..a/b..c"),
        ("a b/é.txt", "a b/é.txt"),
        ("console/com/com10/lptx", "console/com/com10/lptx"),
        (long.as_str(), long.as_str()),
    ] {
        assert_eq!(path_of(raw.as_bytes()).unwrap(), wanted, "{raw}");
    }
}

#[test]
fn every_other_name_is_refused() {
    let long = "x".repeat(256);
    let wide = "é".repeat(128);
    for (raw, reason) in [
        (&b"a\xff"[..], "not UTF-8"),
        (b"\xc0\xae\xc0\xae/a", "not UTF-8"),
        (b"a\0b", "control"),
        (b"a\x1b[2J", "control"),
        ("a\u{85}".as_bytes(), "control"),
        (b"a\nb", "control"),
        (b"..\\a", "backslash"),
        (b"\\\\host\\a", "backslash"),
        (b"C:a", "colon"),
        (b"C:/a", "colon"),
        (b"a.jpg:stream", "colon"),
        (b"/etc/passwd", "absolute"),
        (b"//host/a", "absolute"),
        (b"/", "absolute"),
        (b"../a", "`..`"),
        (b"a/../../b", "`..`"),
        (b"a/..", "`..`"),
        (b"..", "`..`"),
        (b"a/./b", "`..`"),
        (b"././a", "`..`"),
        (b"./../a", "`..`"),
        (b"", "empty"),
        (b"a//b", "empty"),
        (b".//etc/passwd", "empty"),
        (b"a//", "empty"),
        (long.as_bytes(), "longer than 255"),
        (wide.as_bytes(), "longer than 255"),
        (b"a./b", "a dot or a space"),
        (b"a /b", "a dot or a space"),
        (b"...", "a dot or a space"),
        (b"a/.trackfail-complete", "keeps for itself"),
        (b".TrackFail/lock", "keeps for itself"),
    ] {
        let error = path_of(raw).unwrap_err();
        assert!(error.contains(reason), "{}: {error}", String::from_utf8_lossy(raw));
    }
}

#[test]
fn members_go_where_the_list_says() {
    let members = ["all/of/a/1", "all/of/b/c/1", "all/of/b/1", "all/of/aa/1", "all/a/1", "a/1"];
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for name in members {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("try.zip");
    fs::write(&file, zip.finish().unwrap().into_inner()).unwrap();
    let into = folder.path().join("into");
    unpack(&file, &archive(), &["otb/a", "otb/b/c"].map(String::from), &Caps::default(), &into).unwrap();
    let files = walkdir::WalkDir::new(&into).into_iter().map(Result::unwrap);
    let mut files: Vec<_> = files.filter(|e| e.file_type().is_file()).map(|e| e.into_path()).collect();
    files.sort();
    assert_eq!(files, [into.join("otb/a/1"), into.join("otb/b/c/1")]);
}

proptest! {
    // The standard library's own reading of paths is the judge.
    #[test]
    fn a_name_that_is_taken_stays_inside(raw in prop_oneof![
        proptest::collection::vec(any::<u8>(), 0..40),
        "[./\\\\:aA ~\u{0}é]{0,12}".prop_map(String::into_bytes),
    ]) {
        let Ok(name) = path_of(&raw) else { return Ok(()) };
        let path = Path::new("/root").join(&name);
        let parts = if name.is_empty() { 0 } else { name.split('/').count() };
        let inside: Vec<Component> = path.components().collect();
        prop_assert!(path.starts_with("/root"));
        prop_assert_eq!(inside.len(), parts + 2);
        prop_assert!(inside[1..].iter().all(|c| matches!(c, Component::Normal(_))));
        prop_assert!(!name.contains(['\\', ':', '\0']) && name.split('/').all(|part| part.len() <= 255));
    }
}
