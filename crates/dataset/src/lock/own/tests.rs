use super::super::{Finding, Suite};
use super::*;
use proptest::prelude::*;

fn write(root: &Path, path: &str, bytes: &[u8]) {
    let path = below(root, path);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, bytes).unwrap();
}

fn image(root: &Path, path: &str) {
    let path = below(root, path);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    ::image::RgbImage::new(8, 6).save(path).unwrap();
}

/// `lasot/airplane/airplane-{1,2}`, `got/GOT-10k_Val_000001`, `otb/{Two,One}` and `vot/ball`, of two frames each.
fn root() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    let boxes = b"1,1,2,2\n2,1,2,2\n";
    for (images, truths) in [
        ("lasot/airplane/airplane-1/img/0000000", &["lasot/airplane/airplane-1/groundtruth.txt"][..]),
        ("lasot/airplane/airplane-2/img/0000000", &["lasot/airplane/airplane-2/groundtruth.txt"]),
        ("got/GOT-10k_Val_000001/0000000", &["got/GOT-10k_Val_000001/groundtruth.txt"]),
        ("otb/Two/img/000", &["otb/Two/groundtruth_rect.1.txt", "otb/Two/groundtruth_rect.2.txt"]),
        ("otb/One/img/000", &["otb/One/groundtruth_rect.txt"]),
        ("vot/ball/0000000", &["vot/ball/groundtruth.txt"]),
    ] {
        [1, 2].iter().for_each(|n| image(root.path(), &format!("{images}{n}.png")));
        truths.iter().for_each(|t| write(root.path(), t, boxes));
    }
    root
}

fn wanted<'w>(name: &'w str, format: Format, folder: &'w str) -> Wanted<'w> {
    Wanted { name, title: None, format, folder, only: None }
}

/// The suite of a section, without making it known to the process.
fn read(section: &str) -> Suite {
    let text = with_sections("", section);
    let mut suites = parse(Path::new("own.lock"), text.as_bytes()).unwrap();
    assert_eq!(suites.len(), 1);
    Suite { content: super::super::Content::Pinned(Box::leak(Box::new(suites.remove(0)))) }
}

#[test]
fn a_folder_of_each_layout_becomes_a_suite() {
    let root = root();
    // OTB's Jogging has a third file, Human4 an empty one.
    write(root.path(), "otb/Two/groundtruth_rect.txt", b"1,1,2,2\n2,1,2,2\n");
    write(root.path(), "otb/One/groundtruth_rect.1.txt", b"");
    for (format, folder, names) in [
        (Format::Lasot, "lasot", &["airplane-1", "airplane-2"][..]),
        (Format::Lasot, "lasot/airplane", &["airplane-1", "airplane-2"]),
        (Format::Lasot, "lasot/airplane/airplane-2", &["airplane-2"]),
        (Format::Got10k, "got", &["GOT-10k_Val_000001"]),
        (Format::Otb, "otb", &["One", "Two-1", "Two-2"]),
        (Format::Vot, "vot", &["ball"]),
    ] {
        let section = gather(&wanted("my-own", format, folder), root.path()).unwrap();
        let suite = read(&section);
        assert_eq!(suite.sequence_names(), names, "{folder}");
        let loaded = suite.load(Some(root.path()));
        assert_eq!((loaded.sequences.len(), loaded.broken.len()), (names.len(), 0), "{folder}");
        // Boxes count from 1, but for those of VOT.
        let first = loaded.sequences[0].truth[0].as_ref().unwrap().rect().x;
        assert_eq!(first, if format == Format::Vot { 1.0 } else { 0.0 }, "{folder}");
        let entry = &suite.entries()[0];
        assert_eq!((entry.range, entry.frames, entry.size), (Some((1, 2)), Some(2), Some((8, 6))));
        assert!(suite.verify(Some(root.path())).iter().all(|c| c.finding == Finding::Same), "{folder}");
    }
}

#[test]
fn a_changed_frame_or_truth_is_told() {
    let root = root();
    let suite = read(&gather(&wanted("my-own", Format::Lasot, "lasot"), root.path()).unwrap());
    let first = || suite.verify(Some(root.path())).swap_remove(0).finding;
    write(root.path(), "lasot/airplane/airplane-1/out_of_view.txt", b"0,1");
    assert!(matches!(first(), Finding::Differs(_)), "an absent target has no truth");
    write(root.path(), "lasot/airplane/airplane-1/out_of_view.txt", b"0,0");
    assert_eq!(first(), Finding::Same);
    write(root.path(), "lasot/airplane/airplane-1/img/00000001.png", b"x");
    assert!(matches!(first(), Finding::Differs(_)));
    std::fs::remove_dir_all(root.path().join("lasot")).unwrap();
    assert!(matches!(first(), Finding::Missing(m) if m.how_to_get.contains("one of your own")));
}

#[test]
fn what_cannot_become_a_suite_is_named() {
    let root = root();
    let fails = |wanted: &Wanted<'_>| gather(wanted, root.path()).unwrap_err().to_string();
    for (name, format, folder, words) in [
        ("vot2014", Format::Lasot, "lasot", "built-in"),
        ("a b", Format::Lasot, "lasot", "1 to 60 letters"),
        ("mine", Format::Lasot, "../x", "no folder under the data root"),
        ("mine", Format::Lasot, "/", "no folder under the data root"),
        ("mine", Format::Lasot, "nothing", "no folder under the data root"),
        ("mine", Format::Lasot, "otb", "no folder with groundtruth.txt"),
        ("mine", Format::Otb, "lasot", "no folder with groundtruth_rect.txt"),
        ("mine", Format::Cvml, "lasot", "by hand"),
        ("mine", Format::Got10k, "lasot", "airplane-1: no .jpg or .png"),
    ] {
        let error = fails(&wanted(name, format, folder));
        assert!(error.contains(words), "{name}, {folder}: {error}");
    }
    let names = ["airplane-2".to_owned(), "kite-1".to_owned()];
    let some = Wanted { only: Some(&names), ..wanted("mine", Format::Lasot, "lasot") };
    assert!(fails(&some).contains("`kite-1`"));
    let one = Wanted { only: Some(&names[..1]), ..some };
    assert_eq!(read(&gather(&one, root.path()).unwrap()).sequence_names(), ["airplane-2"]);
    image(root.path(), "lasot/kite/airplane-1/img/00000001.png");
    write(root.path(), "lasot/kite/airplane-1/groundtruth.txt", b"1,1,2,2");
    let twice = fails(&wanted("mine", Format::Lasot, "lasot"));
    assert!(twice.contains("airplane/airplane-1") && twice.contains("kite/airplane-1"), "{twice}");
    write(root.path(), "got/GOT-10k_Val_000001/groundtruth.txt", b"1,1,2,2");
    assert!(fails(&wanted("mine", Format::Got10k, "got")).contains("2 images, but 1 lines"));
}

const OWN_FILE: &str = r#"schema = 2

[[suite]]
name = "own-a"
title = "A \"good\" title"
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
fn files_are_read_and_faults_are_named() {
    let read = |text: &str| parse(Path::new("own.lock"), text.as_bytes());
    let suites = read(OWN_FILE).unwrap();
    assert_eq!(suites[0].title, "A \"good\" title");
    assert_eq!(suites[0].sequence[1].format, Some(Format::Vot));
    assert!(read("schema = 2").unwrap().is_empty());
    for (from, to, words) in [
        ("schema = 2", "schema = 1", "schema = 1"),
        ("schema = 2", "", "line 1"),
        ("format = \"otb\"", "format = \"otv\"", "own.lock, line 6"),
        ("format = \"otb\"", "format = \"synthetic\"", "own.lock, line 6"),
        ("source = \"\"", "sauce = \"\"", "own.lock, line 7"),
        ("\"own-a\"", "\"own a\"", "suite `own a`: a name has"),
        ("\"own-a\"", "\"otb-100\"", "built-in"),
        ("\"own-a\"", "\"synthetic-otb\"", "built-in"),
        ("A \\\"good\\\" title", "two\\nlines", "plain line"),
        ("\"a/S\"", "\"a/../S\"", "sequence `S`: `folder`"),
        ("\"a/S\"", "\"/a\"", "sequence `S`: `folder`"),
        ("\"a/S\"", "\"a\\\\S\"", "sequence `S`: `folder`"),
        ("name = \"T\"", "name = \"S\"", "sequence `S` stands there twice"),
        ("name = \"T\"", "name = \"T/1\"", "without quotes"),
        ("name = \"T\"", "name = \"\"", "without quotes"),
        ("range = [3, 4]", "range = [4, 3]", "`range`"),
        ("range = [3, 4]", "range = [0, 4294967295]", "`range`"),
        ("range = [3, 4]", "range = [3, 5]", "`frames`"),
        ("[\"IV\"]", "[\"a\\\"b\"]", "attributes"),
        ("format = \"vot\"", "digest = \"ab\"", "`digest`"),
        ("format = \"vot\"", "archive = \"otb-Basketball\"", "archives"),
        ("sequence = [\n", "sequence = [] #", "line"),
    ] {
        let text = OWN_FILE.replacen(from, to, 1);
        assert_ne!(text, OWN_FILE, "{from}");
        let error = read(&text).err().unwrap_or_else(|| panic!("{to}")).to_string();
        assert!(error.starts_with("own.lock") && error.contains(words), "{to}: {error}");
    }
    let twice = format!("{OWN_FILE}{}", OWN_FILE.trim_start_matches("schema = 2"));
    assert!(read(&twice).unwrap_err().to_string().contains("twice"));
}

#[test]
fn sections_are_written_as_they_are_read() {
    let suites = parse(Path::new("a"), OWN_FILE.as_bytes()).unwrap();
    let text = with_sections("schema = 2\n\n\n", &section(&suites[0]));
    assert_eq!(text, OWN_FILE);
    let more = with_sections(&text, &section(&suites[0]).replace("own-a", "own-b"));
    let names: Vec<String> =
        parse(Path::new("a"), more.as_bytes()).unwrap().into_iter().map(|s| s.name).collect();
    assert_eq!(names, ["own-a", "own-b"]);
}

#[test]
fn suites_are_known_by_name_and_replaced() {
    let parsed = |text: &str| parse(Path::new("a"), text.as_bytes()).unwrap();
    let mut own = Own(Vec::new());
    own.add(parsed(OWN_FILE));
    let first: *const Pinned = own.suite("own-a").unwrap();
    own.add(parsed(OWN_FILE));
    assert_eq!((own.0.len(), std::ptr::from_ref(own.suite("own-a").unwrap())), (1, first));
    // What is read later under the same name stands in its place.
    own.add(parsed(&OWN_FILE.replace("\"S\"", "\"R\"")));
    own.add(parsed(&OWN_FILE.replace("own-a", "own-b")));
    assert_eq!(own.0.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["own-a", "own-b"]);
    assert_eq!(own.suite("own-a").unwrap().sequence[0].name, "R");
    assert!(own.suite("own-c").is_none());
    let text = own.text(&BTreeSet::from(["otb-100", "own-b"])).unwrap();
    assert_eq!(text, with_sections("", &section(own.0[1])));
    assert_eq!(own.text(&BTreeSet::from(["otb-100"])), None);
}

// What `data add` says of the published folders is what is pinned of them.
#[trackfail_testing::needs(real_data)]
#[test]
fn real_folders_become_what_is_pinned() {
    let root = trackfail_testing::real_data();
    for (format, folder, pinned) in [(Format::Otb, "otb", "otb-dtef20"), (Format::Vot, "vot2014", "vot2014")]
    {
        let own = read(&gather(&wanted("my-own", format, folder), &root).unwrap());
        let known = super::super::suite(pinned).unwrap();
        let mut same = 0;
        for entry in known.entries().iter().filter(|e| e.digest.is_some()) {
            let mine = own.entries().iter().find(|e| e.name == entry.name).unwrap();
            // Girl is cut there.
            if mine.range == entry.range {
                assert_eq!((&mine.digest, mine.official), (&entry.digest, entry.official), "{}", entry.name);
                same += 1;
            }
        }
        assert!(same > 7, "{folder}: {same}");
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(
        title in "\\PC{0,30}", folder in "[a-z .-]{1,8}(/[a-z]{1,4}){0,2}", last in 1..99_u32, digest in "[0-9a-f]{64}",
    ) {
        let mut suite = parse(Path::new("a"), OWN_FILE.as_bytes()).unwrap().remove(0);
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
    fn damaged_files_are_read_or_refused(bytes in trackfail_testing::damaged(OWN_FILE.as_bytes())) {
        let _ = parse(Path::new("a"), &bytes);
    }
}
