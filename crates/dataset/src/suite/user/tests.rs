use super::*;
use proptest::prelude::*;

pub(in crate::suite) const USER_FILE: &str = r#"schema = 2

[[suite]]
name = "user-a"
title = 'A "good" title'
format = "otb"
source = ""
licence = ""
how_to_get = ""
sequence = [
    { name = "S", folder = "a/S", range = [3, 4], official = [2, 5], frames = 2, target_type = "car", attributes = ["IV"] },
    { name = "T", folder = "a/T", format = "vot" },
]
"#;

#[test]
fn a_pinned_type_of_target_stays_whatever_the_folder_says() {
    let root = trackfail_testing::folder([
        ("a/S/img/0001.jpg", ""),
        ("a/S/groundtruth_rect.txt", "1,1,5,5"),
        ("a/S/attributes.txt", "target-face, OCC"),
    ]);
    let attributes = |pins: &str| {
        let entry = format!("{{ name = \"S\", folder = \"a/S\"{pins} }}");
        let head = "schema = 2\n[[suite]]\nname = \"mine\"\ntitle = \"t\"\nformat = \"otb\"\nsource = \"\"\nlicence = \"\"\n\
                    how_to_get = \"\"\n";
        let text = format!("{head}sequence = [{entry}]");
        let suite = parse(Path::new("user.lock"), text.as_bytes()).unwrap().remove(0);
        suite.load(&suite.sequence[0], root.path()).unwrap().attributes
    };
    assert_eq!(attributes(""), ["OCC", "target-face"]);
    assert_eq!(attributes(", target_type = \"car\""), ["OCC", "target-car"]);
}

#[test]
fn files_are_read_and_faults_are_named() {
    let read = |text: &str| parse(Path::new("user.lock"), text.as_bytes());
    let suites = read(USER_FILE).unwrap();
    assert_eq!(suites[0].title, "A \"good\" title");
    assert_eq!(suites[0].sequence[1].format, crate::format::find("vot"));
    assert!(read("schema = 2").unwrap().is_empty());
    for (from, to, words) in [
        ("schema = 2", "schema = 1", "schema = 1"),
        ("schema = 2", "", "line 1"),
        ("format = \"otb\"", "format = \"otv\"", "user.lock, line 6"),
        ("format = \"otb\"", "format = \"synthetic\"", "user.lock, line 6"),
        ("source = \"\"", "sauce = \"\"", "user.lock, line 7"),
        ("\"user-a\"", "\"user a\"", "suite `user a`: a name has"),
        ("\"user-a\"", "\"otb-100\"", "built-in"),
        ("\"user-a\"", "\"synthetic-otb\"", "built-in"),
        ("'A \"good\" title'", "\"two\\nlines\"", "plain line"),
        ("\"a/S\"", "\"a/../S\"", "sequence `S`: `folder`"),
        ("\"a/S\"", "\"/a\"", "sequence `S`: `folder`"),
        ("\"a/S\"", "\"a\\\\S\"", "sequence `S`: `folder`"),
        ("name = \"T\"", "name = \"S\"", "sequence `S` is listed twice"),
        ("name = \"T\"", "name = \"T/1\"", "has no quotes"),
        ("name = \"T\"", "name = \"\"", "has no quotes"),
        ("range = [3, 4]", "range = [4, 3]", "`range`"),
        ("range = [3, 4]", "range = [0, 4294967295]", "`range`"),
        ("range = [3, 4]", "range = [3, 5]", "`frames`"),
        ("[\"IV\"]", "[\"a\\\"b\"]", "an attribute is"),
        // Before: they stood in scores.csv as they are, and a spreadsheet ran them.
        ("name = \"T\"", "name = \"=cmd|A0\"", "does not begin with one of = + - @"),
        ("name = \"T\"", "name = \"--x\"", "does not begin with one of = + - @"),
        ("name = \"T\"", "name = \" +x\"", "does not begin with one of = + - @"),
        ("[\"IV\"]", "[\"@x\"]", "an attribute is plain text that does not begin with one of = + - @"),
        ("\"user-a\"", "\"-a\"", "does not begin with `.` or `-`"),
        ("format = \"vot\"", "digest = \"ab\"", "`digest`"),
        ("format = \"vot\"", "archive = \"otb-Basketball\"", "archives"),
        ("sequence = [\n", "sequence = [] #", "line"),
    ] {
        let text = USER_FILE.replacen(from, to, 1);
        assert_ne!(text, USER_FILE, "{from}");
        let error = read(&text).err().unwrap_or_else(|| panic!("{to}")).to_string();
        assert!(error.starts_with("user.lock") && error.contains(words), "{to}: {error}");
    }
    let twice = format!("{USER_FILE}{}", USER_FILE.trim_start_matches("schema = 2"));
    assert!(read(&twice).unwrap_err().to_string().contains("twice"));
}

#[test]
fn sequences_of_built_in_suites_are_included_without_their_archives() {
    let text = USER_FILE.replacen("sequence = [", "includes = [\"vot2014\", \"otb-100\"]\nsequence = [", 1);
    let suite = parse(Path::new("a"), text.as_bytes()).unwrap().remove(0);
    let names: Vec<&str> = suite.sequence.iter().map(|entry| entry.name.as_str()).collect();
    assert_eq!((names.len(), names[0], &names[125..]), (127, "ball", &["S", "T"][..]));
    assert!(suite.sequence.iter().all(|entry| entry.archives().next().is_none()));
    // The copy of a results folder is read again.
    let kept = parse(Path::new("a"), with_sections("", &section(&suite)).as_bytes()).unwrap().remove(0);
    assert_eq!(section(&kept), section(&suite));
}

#[test]
fn sections_are_written_as_they_are_read() {
    let suites = parse(Path::new("a"), USER_FILE.as_bytes()).unwrap();
    let text = with_sections("schema = 2\n\n\n", &section(&suites[0]));
    assert_eq!(text, USER_FILE);
    let more = with_sections(&text, &section(&suites[0]).replace("user-a", "user-b"));
    let names: Vec<String> =
        parse(Path::new("a"), more.as_bytes()).unwrap().into_iter().map(|s| s.name).collect();
    assert_eq!(names, ["user-a", "user-b"]);
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(
        title in "\\PC{0,30}", folder in "[a-z .-]{1,8}(/[a-z]{1,4}){0,2}", last in 1..99_u32, digest in "[0-9a-f]{64}",
    ) {
        let mut suite = parse(Path::new("a"), USER_FILE.as_bytes()).unwrap().remove(0);
        suite.title = title;
        suite.sequence[1] = Entry {
            folder, range: Some((1, last)), frames: Some(last as usize), digest: Some(digest), format: None,
            ..suite.sequence[1].clone()
        };
        let again = parse(Path::new("a"), with_sections("", &section(&suite)).as_bytes());
        if check(&suite).is_ok() {
            prop_assert_eq!(section(&again.unwrap()[0]), section(&suite));
        } else {
            prop_assert!(again.is_err());
        }
    }

    #[test]
    fn damaged_files_are_read_or_refused(bytes in trackfail_testing::damaged(USER_FILE.as_bytes())) {
        let _ = parse(Path::new("a"), &bytes);
    }
}
