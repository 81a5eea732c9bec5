use super::super::user::{parse, with_sections};
use super::super::{Catalog, Finding, Suite, SuiteContent};
use super::*;
use std::sync::Arc;
use trackfail_testing::{assert_says, put};

fn format(word: &str) -> &'static FormatEntry {
    crate::format::find(word).unwrap()
}

fn image(root: &Path, path: &str) {
    ::image::RgbImage::new(8, 6).save(put(root, path, "")).unwrap();
}

/// Data root with `lasot/airplane/airplane-{1,2}`, `got/GOT-10k_Val_000001`, `otb/{Two,One}` and `vot/ball`,
/// of two frames each.
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
        truths.iter().for_each(|t| drop(put(root.path(), t, boxes)));
    }
    root
}

fn wanted<'w>(name: &'w str, format: &'static FormatEntry, folder: &'w str) -> GatherRequest<'w> {
    GatherRequest { name, title: None, format, folder, only: None }
}

/// Parses the only suite of a section.
fn read(section: &str) -> Suite {
    let text = with_sections("", section);
    let mut suites = parse(Path::new("user.lock"), text.as_bytes()).unwrap();
    assert_eq!(suites.len(), 1);
    Suite(SuiteContent::OnDisk(Arc::new(suites.remove(0))))
}

#[test]
fn a_folder_of_each_layout_becomes_a_suite() {
    let root = root();
    // OTB's Jogging has a third file, Human4 an empty one.
    put(root.path(), "otb/Two/groundtruth_rect.txt", b"1,1,2,2\n2,1,2,2\n");
    put(root.path(), "otb/One/groundtruth_rect.1.txt", b"");
    for (format, folder, names) in [
        (format("lasot"), "lasot", &["airplane-1", "airplane-2"][..]),
        (format("lasot"), "lasot/airplane", &["airplane-1", "airplane-2"]),
        (format("lasot"), "lasot/airplane/airplane-2", &["airplane-2"]),
        (format("got10k"), "got", &["GOT-10k_Val_000001"]),
        (format("otb"), "otb", &["One", "Two-1", "Two-2"]),
        (format("vot"), "vot", &["ball"]),
    ] {
        let section = gather(&wanted("mine", format, folder), root.path()).unwrap();
        let suite = read(&section);
        assert_eq!(suite.sequence_names(), names, "{folder}");
        // Only targets of one folder are of one video.
        let videos: Vec<&str> = suite.entries().iter().map(Entry::video).collect();
        assert_eq!(videos, if folder == "otb" { &["One", "Two", "Two"] } else { names }, "{folder}");
        let loaded = suite.load(&[root.path().to_path_buf()]);
        assert_eq!((loaded.sequences.len(), loaded.broken.len()), (names.len(), 0), "{folder}");
        // Boxes count from 1, but for those of VOT.
        let first = loaded.sequences[0].truth[0].as_ref().unwrap().rect().x;
        assert_eq!(first, if format.word == "vot" { 1.0 } else { 0.0 }, "{folder}");
        let entry = &suite.entries()[0];
        assert_eq!((entry.range, entry.frames, entry.size), (Some((1, 2)), Some(2), Some((8, 6))));
        let verified = suite.verify(&[root.path().to_path_buf()], |_| true);
        assert!(verified.iter().all(|c| c.1 == Finding::Same), "{folder}");
    }
}

#[test]
fn what_cannot_become_a_suite_is_named() {
    let root = root();
    let fails = |wanted: &GatherRequest<'_>| gather(wanted, root.path()).unwrap_err().to_string();
    for (name, format, folder, words) in [
        ("vot2014", format("lasot"), "lasot", "built-in"),
        ("a b", format("lasot"), "lasot", "1 to 60 letters"),
        ("mine", format("lasot"), "../x", "no folder under the data root"),
        ("mine", format("lasot"), "/", "no folder under the data root"),
        ("mine", format("lasot"), "nothing", "no folder under the data root"),
        ("mine", format("lasot"), "otb", "no folder with groundtruth.txt"),
        ("mine", format("otb"), "lasot", "no folder with groundtruth_rect.txt"),
        ("mine", format("cvml"), "lasot", "by hand"),
        ("mine", format("got10k"), "lasot", "airplane-1: no .jpg or .png"),
    ] {
        let error = fails(&wanted(name, format, folder));
        assert!(error.contains(words), "{name}, {folder}: {error}");
    }
    let names = ["airplane-2".to_owned(), "kite-1".to_owned()];
    let some = GatherRequest { only: Some(&names), ..wanted("mine", format("lasot"), "lasot") };
    assert_says(fails(&some), "`kite-1`");
    let one = GatherRequest { only: Some(&names[..1]), ..some };
    assert_eq!(read(&gather(&one, root.path()).unwrap()).sequence_names(), ["airplane-2"]);
    image(root.path(), "lasot/kite/airplane-1/img/00000001.png");
    put(root.path(), "lasot/kite/airplane-1/groundtruth.txt", b"1,1,2,2");
    let twice = fails(&wanted("mine", format("lasot"), "lasot"));
    assert!(twice.contains("airplane/airplane-1") && twice.contains("kite/airplane-1"), "{twice}");
    put(root.path(), "got/GOT-10k_Val_000001/groundtruth.txt", b"1,1,2,2");
    assert_says(fails(&wanted("mine", format("got10k"), "got")), "2 images, but 1 lines");
    put(root.path(), "otb/One/groundtruth_rect.txt", b"1,1,2,2\n2,1,2,2\n3,1,2,2\n");
    assert_says(fails(&wanted("mine", format("otb"), "otb")), "One: 3 lines of ground truth for 2 frames");
}

#[test]
fn ground_truth_without_a_box_is_named() {
    let root = root();
    put(root.path(), "otb/Two/groundtruth_rect.2.txt", b"0,0,0,0\nnan,nan,nan,nan\n");
    put(root.path(), "vot/ball/groundtruth.txt", b"0\nnan,nan,nan,nan\n");
    put(root.path(), "got/GOT-10k_Val_000001/absence.label", b"1\n1\n");
    for (word, folder, file) in [
        ("otb", "otb", "Two/groundtruth_rect.2.txt"),
        ("vot", "vot", "ball/groundtruth.txt"),
        ("got10k", "got", "GOT-10k_Val_000001/groundtruth.txt"),
    ] {
        let error = gather(&wanted("mine", format(word), folder), root.path()).unwrap_err();
        assert_says(error, format!("{file}: no frame has a box"));
    }
    // One frame is enough.
    put(root.path(), "vot/ball/groundtruth.txt", b"0\n1,1,2,2\n");
    assert!(gather(&wanted("mine", format("vot"), "vot"), root.path()).is_ok());
}

// What `data add` says of the published folders is what is pinned of them.
#[trackfail_testing::needs(real_data)]
#[test]
fn real_folders_become_what_is_pinned() {
    let root = trackfail_testing::real_data();
    for (format, folder, pinned) in
        [(format("otb"), "otb", "otb-dtef20"), (format("vot"), "vot2014", "vot2014")]
    {
        let added = read(&gather(&wanted("mine", format, folder), &root).unwrap());
        let known = Catalog::default().suite(pinned).unwrap();
        let mut same = 0;
        for entry in known.entries().iter().filter(|e| e.digest.is_some()) {
            let mine = added.entries().iter().find(|e| e.name == entry.name).unwrap();
            // Girl is cut there.
            if mine.range == entry.range {
                assert_eq!((&mine.digest, mine.official), (&entry.digest, entry.official), "{}", entry.name);
                same += 1;
            }
        }
        assert!(same > 7, "{folder}: {same}");
    }
}
