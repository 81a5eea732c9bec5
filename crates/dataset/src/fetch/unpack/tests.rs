use super::*;
use proptest::prelude::*;
use std::io::Cursor;
use std::path::Component;
use zip::write::{SimpleFileOptions, ZipWriter};

fn archive() -> Archive {
    let [name, url, into, below] = ["try", "http://h/try.zip", "otb", "all/of"].map(String::from);
    Archive { name, url, into, below: Some(below), ..Archive::default() }
}

#[test]
fn plain_names_are_taken() {
    let long = "x".repeat(255);
    let same = ["David/img/0001.jpg", ".hidden", "..a/b..c", "a b/é.txt", "console/com/com10/lptx", &long];
    let others = [("David/", "David"), ("./a/b", "a/b"), ("./", ""), (".", "")];
    for (raw, wanted) in same.map(|name| (name, name)).into_iter().chain(others) {
        assert_eq!(path_of(raw.as_bytes()).unwrap(), wanted, "{raw}");
    }
}

#[test]
fn every_other_name_is_refused() {
    let (long, wide) = ("x".repeat(256), "é".repeat(128));
    let refused: [(&str, &[&[u8]]); 10] = [
        ("not UTF-8", &[b"a\xff", b"\xc0\xae\xc0\xae/a"]),
        ("control", &[b"a\0b", b"a\x1b[2J", "a\u{85}".as_bytes(), b"a\nb"]),
        ("backslash", &[b"..\\a", b"\\\\host\\a"]),
        ("colon", &[b"C:a", b"C:/a", b"a.jpg:stream"]),
        ("absolute", &[b"/etc/passwd", b"//host/a", b"/"]),
        ("`..`", &[b"../a", b"a/../../b", b"a/..", b"..", b"a/./b", b"././a", b"./../a"]),
        ("empty", &[b"", b"a//b", b".//etc/passwd", b"a//"]),
        ("longer than 255", &[long.as_bytes(), wide.as_bytes()]),
        ("a dot or a space", &[b"a./b", b"a /b", b"..."]),
        ("keeps for itself", &[b"a/.trackfail-complete", b".TrackFail/lock"]),
    ];
    for (reason, names) in refused {
        for raw in names {
            let error = path_of(raw).unwrap_err();
            assert!(error.contains(reason), "{}: {error}", String::from_utf8_lossy(raw));
        }
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
