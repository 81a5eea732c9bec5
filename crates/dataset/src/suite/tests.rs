use super::user::{is_below, is_digest};
use super::*;
use crate::Sequence;
use crate::lock::{
    SUITES, TargetType, archives, attribute_word, pinned_suite, pinned_suite_names, pinned_suites,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use tempfile::{TempDir, tempdir};
use trackfail_core::region::Rect;
use trackfail_testing::{assert_says, needs, put, real_data};

fn suite(name: &str) -> Suite {
    Catalog::default().suite(name).unwrap()
}

/// The folder as the only data root.
fn at(root: &TempDir) -> [PathBuf; 1] {
    [root.path().to_path_buf()]
}

/// The entry of a name.
fn entry<'e>(entries: &'e [Entry], name: &str) -> &'e Entry {
    entries.iter().find(|entry| entry.name == name).unwrap()
}

/// Writes a sequence in the layout of OTB or VOT with `lines` lines of ground truth and empty images of these
/// numbers.
fn write(root: &Path, folder: &str, lines: usize, images: impl IntoIterator<Item = u32>) {
    let is_otb = folder.starts_with("otb/");
    let truth = if is_otb { "groundtruth_rect.txt" } else { "groundtruth.txt" };
    put(root, format!("{folder}/{truth}"), "1,1,2,2\n".repeat(lines));
    for n in images {
        let image = if is_otb { format!("img/{n:04}.jpg") } else { format!("{n:08}.jpg") };
        put(root, format!("{folder}/{image}"), "");
    }
}

/// Finding of `data verify` about one sequence.
fn checked(name: &str, sequence: &str, root: &TempDir) -> Finding {
    suite(name).verify(&at(root), |name| name == sequence).remove(0).1
}

/// The words of `data verify` for a copy that differs.
fn difference(finding: Finding) -> String {
    match finding {
        Finding::Differs(fact) => fact,
        other => panic!("{other:?}"),
    }
}

/// Advice of `data verify` for a copy that is missing.
fn hint(finding: Finding) -> String {
    match finding {
        Finding::Missing(missing) => missing.how_to_get,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_lock_is_consistent() {
    let mut copies: BTreeMap<_, &Entry> = BTreeMap::new();
    for p in pinned_suites() {
        let mut seen = BTreeSet::new();
        for e in &p.sequence {
            let name = format!("{}/{}", p.name, e.name);
            assert!(seen.insert(&e.name), "{name} twice");
            assert_eq!(e.range.map(|(a, b)| (b - a) as usize + 1), e.frames, "{name}");
            assert_eq!(e.range.is_some(), e.official.is_some(), "{name}");
            if let (Some(range), Some(official)) = (e.range, e.official) {
                assert!(1 <= official.0 && official.0 <= range.0 && range.1 <= official.1, "{name}");
            }
            assert!(e.attributes.iter().all(|a| attribute_word(a) != a), "{name}");
            assert!(e.digest.as_deref().is_none_or(is_digest), "{name}");
            let has_frames = p.format(e).word != "otb-boxes";
            assert_eq!(e.digest.is_some() && has_frames, e.size.is_some(), "{name}");
            assert!(is_below(&e.folder), "{name}");
            assert!(is_listed(&line(p, e)), "not as `data lock` writes it: {}", e.line());
            let wanted = [&e.archive, &e.truth_archive].into_iter().flatten().count();
            assert_eq!(e.archives().count(), wanted, "{name} names an archive that is not there");
            // What is unpacked lands in the sequence's folder, or in one that has it.
            assert!(e.archives().all(|a| Path::new(&e.folder).starts_with(&a.into)), "{name}");
            // The same frames of the same files are the same sequence, in whatever suite.
            let same = copies.entry((&e.folder, e.target, e.range, e.official)).or_insert(e);
            assert_eq!(same.digest, e.digest, "{name}");
            assert_eq!(same.archive, e.archive, "{name}");
        }
    }
}

fn is_listed(line: &str) -> bool {
    SUITES.iter().any(|(_, text)| text.contains(line))
}

/// Line of an entry in the file of the suite that defines it.
fn line(suite: &PinnedSuite, entry: &Entry) -> String {
    match suite.includes.is_empty() {
        true => entry.line(),
        false => Entry { format: None, ..entry.clone() }.line(),
    }
}

#[test]
fn archives_are_consistent_and_all_are_used() {
    let mut seen = BTreeSet::new();
    let entries = pinned_suites().flat_map(|p| &p.sequence);
    let used: BTreeSet<&str> = entries.flat_map(Entry::archives).map(|a| a.name.as_str()).collect();
    for a in archives() {
        assert!(seen.insert(&a.name), "{} twice", a.name);
        assert!(a.url.starts_with("http://") || a.url.starts_with("https://"), "{}", a.url);
        // Names of files below the data root.
        let file = a.url.rsplit('/').next().unwrap();
        assert!(is_below(file) && !a.name.contains('/') && is_below(&a.name), "{}", a.name);
        assert!(is_below(&a.into) && a.below.as_deref().is_none_or(is_below), "{}", a.name);
        assert!(a.sha256.as_deref().is_none_or(is_digest), "{}", a.name);
        assert!(used.contains(a.name.as_str()), "{} belongs to no sequence", a.name);
    }
}

// The published lengths of the 20 sequences, cut as in the paper and Jogging once, add up to 6717; Tiger1
// starts at frame 6 here, as in the results of CVPR 2013.
#[test]
fn the_suites_have_the_published_sizes() {
    let frames = |e: &Entry| e.frames.unwrap();
    let dtef = suite("otb-dtef20");
    assert_eq!(dtef.entries().len(), 21);
    let once = dtef.entries().iter().filter(|e| e.target != Some(2));
    assert_eq!(once.map(frames).sum::<usize>() + 5, 6717);
    // wc -l of the 25 result files of a VOT2014 entry: 10213.
    let vot = suite("vot2014");
    assert_eq!((vot.entries().len(), vot.entries().iter().map(frames).sum::<usize>()), (25, 10_213));
    let names = ["otb-2013", "otb-100", "vot2013", "vot2015", "vot2016"];
    assert_eq!(names.map(|name| suite(name).entries().len()), [51, 100, 16, 60, 60]);
}

// Where the benchmark uses other frames than a folder has (notes on its page, and its start frames).
#[test]
fn otb_has_the_ranges_of_the_benchmark() {
    let all = suite("otb-100");
    for (name, range) in [
        ("David", (300, 770)),
        ("Football1", (1, 74)),
        ("Freeman3", (1, 460)),
        ("Freeman4", (1, 283)),
        ("Diving", (1, 215)),
        ("Tiger1", (6, 354)),
        ("BlurCar1", (247, 988)),
        ("BlurCar3", (3, 359)),
        ("BlurCar4", (18, 397)),
    ] {
        assert_eq!(entry(all.entries(), name).range, Some(range), "{name}");
    }
    for e in suite("otb-2013").entries() {
        assert_eq!(e.line(), entry(all.entries(), &e.name).line());
    }
}

// Lengths and first images of OTB2013.json, an independent copy of the annotation of CVPR 2013.
#[needs(real_data)]
#[test]
fn otb_2013_has_as_many_frames_as_annotated() {
    let root = real_data();
    let text = std::fs::read(root.join("otb-annotations/OTB2013.json")).unwrap();
    let all: BTreeMap<String, serde_json::Value> = serde_json::from_slice(&text).unwrap();
    assert_eq!(all.len(), 51);
    let otb = suite("otb-2013");
    for (key, value) in &all {
        let name = match key.strip_prefix("jogging_") {
            Some(target) => format!("Jogging-{target}"),
            None => value["name"].as_str().unwrap().to_owned(),
        };
        let entry = entry(otb.entries(), &name);
        assert_eq!(entry.frames, Some(value["gt_rect"].as_array().unwrap().len()), "{name}");
        let first = value["image_files"][0].as_str().unwrap();
        assert_eq!(format!("{:04}.jpg", entry.range.unwrap().0), first, "{name}");
    }
}

fn pets_annotation(root: &Path) -> crate::format::cvml::Annotation {
    let xml = root.join("pets2009/S2L1/PETS2009-S2L1.xml");
    crate::format::cvml::parse(&xml, &crate::text::read(&xml).unwrap()).unwrap()
}

// python3: {o.get('id') for f in root for o in f.find('objectlist')}, and first and last frame + 1 of each.
#[needs(real_data)]
#[test]
fn pets_entries_are_the_presence_of_the_annotated_people() {
    let annotation = pets_annotation(&real_data());
    let ids: Vec<u32> = annotation.objects().collect();
    assert_eq!(ids, (1..=19).collect::<Vec<_>>());
    for (id, e) in ids.into_iter().zip(suite("pets2009-s2l1").entries()) {
        assert_eq!((e.target, e.range, e.official), (Some(id), annotation.presence(id), e.range));
    }
    let whole = suite("pets2009-s2l1");
    for e in suite("pets2009-s2l1-160").entries() {
        let (first, last) = entry(whole.entries(), &e.name).range.unwrap();
        assert_eq!((e.range, e.official), (Some((first, last.min(160))), Some((first, last))));
    }
}

/// Track id and frame range of each person in `d1-real`.
fn people_of_d1() -> Vec<(u32, (u32, u32))> {
    let d1 = suite("d1-real");
    let entries = d1.entries();
    let people = entries.iter().filter(|e| e.target_type != Some(TargetType::Face));
    people.map(|e| (e.target.unwrap(), e.range.unwrap())).collect()
}

#[test]
fn d1_real_has_six_people_and_a_face() {
    let ranges = [(9, 1, 160), (11, 17, 160), (12, 22, 160), (13, 41, 160), (15, 1, 160), (19, 1, 147)];
    assert_eq!(people_of_d1(), ranges.map(|(id, first, last)| (id, (first, last))));
    let d1 = suite("d1-real");
    let faces = d1.entries().iter().filter(|e| e.target_type == Some(TargetType::Face));
    assert_eq!(faces.map(|e| (e.name.as_str(), e.frames)).collect::<Vec<_>>(), [("seq_mb", Some(500))]);
}

// The rule of the file's comment, by another reading of the annotation:
// python3: b = {n: box of o in f for f in root if n(f) <= 160}; a = min(n for n in b if 0 <= x0(b[n]) and
// 0 <= y0(b[n]) and x1(b[n]) <= 768 and y1(b[n]) <= 576); e = a; while e + 1 in b: e += 1; e - a + 1 >= 60
// gives 9: 1-160, 11: 17-160, 12: 22-160, 13: 41-160, 15: 1-160, 19: 1-147.
#[needs(real_data)]
#[test]
fn the_people_of_d1_real_are_those_of_its_rule() {
    let roots = [real_data()];
    let annotation = pets_annotation(&roots[0]);
    let by_rule = annotation.objects().filter_map(|id| {
        let fits = |r: Rect| r.x >= 0.0 && r.y >= 0.0 && r.x + r.w <= 768.0 && r.y + r.h <= 576.0;
        let first = (1..=160).find(|n| annotation.region(id, *n).is_some_and(fits))?;
        let last = (first..=160).take_while(|n| annotation.region(id, *n).is_some()).last()?;
        (last - first + 1 >= 60).then_some((id, (first, last)))
    });
    assert_eq!(people_of_d1(), by_rule.collect::<Vec<_>>());
    let loaded = suite("d1-real").load(&roots);
    assert_eq!((loaded.sequences.len(), loaded.wanted), (7, 7), "{:?} {:?}", loaded.missing, loaded.broken);
    let has = |q: &Sequence, word: &str| q.attributes.iter().any(|a| a == word);
    assert!(loaded.sequences[..6].iter().all(|q| has(q, "target-person")));
    assert!(has(&loaded.sequences[6], "target-face"));
    let d1 = suite("d1-real");
    let verified = d1.verify(&roots, |_| true);
    assert!(verified.iter().all(|c| c.1 == Finding::Same), "{verified:?}");
}

#[test]
fn without_data_all_are_missing_and_say_how_to_get_them() {
    let nothing = tempdir().unwrap();
    for name in pinned_suite_names() {
        for roots in [&[][..], &at(&nothing)] {
            let loaded = suite(name).load(roots);
            assert_eq!((loaded.sequences.len(), loaded.missing.len()), (0, loaded.wanted));
            assert!(loaded.missing.iter().all(|m| m.how_to_get.contains("http")));
            assert_eq!(roots.is_empty(), loaded.missing[0].how_to_get.contains("--data-root"));
        }
    }
}

#[test]
fn sequences_left_out_count_as_missing() {
    let mut loaded = suite("synthetic-otb").load(&[]);
    loaded.keep_only(|name| name == "Tennis", "not in a/b");
    let kept: Vec<&str> = loaded.sequences.iter().map(|s| s.name.as_str()).collect();
    assert_eq!((kept, loaded.missing.len()), (vec!["Tennis"], loaded.wanted - 1));
    assert!(loaded.missing.iter().all(|m| m.folder == "not in a/b" && m.name != "Tennis"));
}

// OTB's sequence Crossing has 120 frames.
#[test]
fn the_first_root_that_has_all_of_a_sequence_is_taken() {
    let roots: Vec<_> = (0..4).map(|_| tempdir().unwrap()).collect();
    let paths: Vec<PathBuf> = roots.iter().map(|root| root.path().to_path_buf()).collect();
    for (root, frames) in [(1, 119), (2, 120), (3, 120)] {
        write(&paths[root], "otb/Crossing", 120, 1..=frames);
    }
    let taken = |roots: &[PathBuf]| {
        let loaded = suite("otb-dtef20").load(roots);
        assert_eq!((loaded.sequences.len(), loaded.broken.len()), (1, 0));
        loaded.sequences[0].origin.root.clone()
    };
    assert_eq!(taken(&paths), paths[2]);
    assert_eq!(taken(&[paths[3].clone(), paths[2].clone()]), paths[3]);
    // A copy with a gap is not all of it, in `data verify` as in `data list`.
    std::fs::remove_file(paths[2].join("otb/Crossing/img/0030.jpg")).unwrap();
    assert_eq!(taken(&paths), paths[3]);
    let finding =
        |roots: &[PathBuf]| suite("otb-dtef20").verify(roots, |name| name == "Crossing").remove(0).1;
    let broken = difference(finding(&paths[2..3]));
    assert_says(&broken, "frame 30 is missing");
    assert_ne!(difference(finding(&paths[2..])), broken);
    // A part of it says more than nothing.
    let missing = suite("otb-dtef20").load(&paths[..2]).missing;
    let crossing = missing.iter().find(|m| m.name == "Crossing").unwrap();
    assert!(crossing.how_to_get.starts_with("frames 120 to 120 are not in otb/Crossing"), "{crossing:?}");
}

#[test]
fn a_short_copy_is_broken_and_differs() {
    let root = tempdir().unwrap();
    write(root.path(), "vot2014/ball", 1, [1]);
    let vot = suite("vot2014");
    let loaded = vot.load(&at(&root));
    assert_eq!((loaded.broken.len(), loaded.missing.len(), loaded.wanted), (1, 24, 25));
    assert!(loaded.broken[0].1.to_string().contains("602"));
    let all = vot.verify(&at(&root), |_| true);
    assert!(matches!(&all[0].1, Finding::Differs(fact) if fact.contains("1 frames")));
    assert!(matches!(all[1].1, Finding::Missing(_)));
}

// OTB's sequence Deer has 71 frames.
#[test]
fn a_copy_that_ends_early_is_missing_and_one_with_a_gap_is_broken() {
    let finding = |images: Vec<u32>| {
        let root = tempdir().unwrap();
        write(root.path(), "otb/Deer", 71, images);
        checked("otb-2013", "Deer", &root)
    };
    assert_eq!(finding((1..=71).collect()), Finding::NoDigestPinned);
    let told = hint(finding((1..=50).collect()));
    assert!(told.starts_with("frames 51 to 71 are not in otb/Deer; "), "{told}");
    // Other frames than those of the range do not matter.
    hint(finding((100..=120).collect()));
    for gap in [1, 30] {
        let fact = difference(finding((1..=71).filter(|&n| n != gap).collect()));
        assert_says(fact, format!("frame {gap} is missing"));
    }
}

#[test]
fn a_clip_without_its_annotation_or_its_frames_is_missing() {
    let root = tempdir().unwrap();
    let folder = root.path().join("caviar/Walk1");
    std::fs::create_dir_all(&folder).unwrap();
    let xml = "<dataset><frame number=\"0\"><objectlist><object id=\"1\">\
               <box xc=\"5\" yc=\"5\" w=\"2\" h=\"2\"/></object></objectlist></frame></dataset>";
    let finding = || suite("caviar").verify(&at(&root), |_| true).swap_remove(0).1;
    assert!(hint(finding()).starts_with("no annotation (.xml) in caviar/Walk1; "));
    let clip = put(&folder, "Walk1.mpg", "");
    assert!(hint(finding()).starts_with("no annotation (.xml) in caviar/Walk1; "));
    put(&folder, "wk1gt.xml", xml);
    assert_eq!(finding(), Finding::NoDigestPinned);
    std::fs::remove_file(clip).unwrap();
    assert!(hint(finding()).starts_with("no images or video in caviar/Walk1; "));
}

#[test]
fn a_suite_of_the_users_is_compared_with_its_own_digests_alone() {
    let root = tempdir().unwrap();
    write(root.path(), "vot2014/ball", 2, 1..=2);
    let mut mine = user::parse(Path::new("a"), user::tests::USER_FILE.as_bytes()).unwrap().remove(0);
    let entry = Entry { name: "ball".into(), folder: "vot2014/ball".into(), ..mine.sequence[1].clone() };
    let digest = mine.load(&entry, root.path()).unwrap().digest().unwrap().to_owned();
    let entry = Entry { digest: Some(digest), ..entry };
    // Other files than those of the built-in suite that has this folder, and a label more.
    put(root.path(), "vot2014/ball/fast.label", "0\n1\n");
    mine.sequence = vec![entry];
    assert_eq!(mine.check(&mine.sequence[0], &at(&root)), Finding::Same);
    put(root.path(), "vot2014/ball/00000002.jpg", "changed");
    let fact = difference(mine.check(&mine.sequence[0], &at(&root)));
    assert!(fact.starts_with("frames or ground truth are other bytes"), "{fact}");
}

#[test]
fn an_entry_without_range_takes_what_is_there() {
    let root = tempdir().unwrap();
    write(root.path(), "vot2013/cup", 3, 1..=3);
    let loaded = suite("vot2013").load(&at(&root));
    assert_eq!((loaded.sequences.len(), loaded.sequences[0].len()), (1, 3));
    assert_eq!(checked("vot2013", "cup", &root), Finding::NoDigestPinned);
}

#[needs(real_data)]
#[test]
fn real_data_are_as_pinned() {
    let roots = [real_data()];
    let mut same = 0;
    for name in pinned_suite_names() {
        let suite = suite(name);
        let loaded = suite.load(&roots);
        assert!(loaded.broken.is_empty(), "{:?}", loaded.broken);
        assert_eq!(loaded.sequences.len() + loaded.missing.len(), loaded.wanted);
        for (entry, finding) in suite.verify(&roots, |_| true) {
            let fine = matches!(finding, Finding::Same | Finding::Missing(_));
            assert!(fine, "{}: {finding:?}", entry.name);
            same += usize::from(finding == Finding::Same);
        }
        // Lines of a suite with others are those of the others.
        let has_own_lines = pinned_suite(name).unwrap().includes.is_empty();
        for line in suite.pin(&roots).unwrap() {
            assert!(!has_own_lines || is_listed(&line), "{line}");
        }
    }
    assert!(same > 0);
}

// Files of other formats and of frames outside a range are told apart by the tests of listings.
#[needs(real_data)]
#[test]
fn one_changed_byte_in_each_kind_of_file_is_named() {
    let folder = "vot2014/sphere";
    let originals = trackfail_testing::files(&real_data().join(folder)).into_iter();
    let copy =
        trackfail_testing::folder(originals.map(|(name, bytes)| (Path::new(folder).join(name), bytes)));
    let pinned = pinned_suite("vot2014").unwrap();
    let check = || pinned.check(entry(&pinned.sequence, "sphere"), &at(&copy));
    assert_eq!(check(), Finding::Same);
    for file in ["groundtruth.txt", "occlusion.label", "camera_motion.label", "00000077.jpg"] {
        let path = copy.path().join(folder).join(file);
        let before = std::fs::read(&path).unwrap();
        let mut bytes = before.clone();
        // A digit near the middle, which is 0 or 1 in a label; in an image any byte.
        let mut places = before.len() / 2..before.len();
        let at = places.find(|&k| file.ends_with("jpg") || before[k].is_ascii_digit()).unwrap();
        bytes[at] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        let fact = difference(check());
        assert!(fact.starts_with(&format!("{file} is another file: ")), "{fact}");
        std::fs::write(&path, before).unwrap();
    }
    assert_eq!(check(), Finding::Same);
    let frame = copy.path().join(folder).join("00000077.jpg");
    let spare = frame.with_extension("png");
    std::fs::copy(&frame, &spare).unwrap();
    assert_says(difference(check()), " does not belong there; ");
    [&spare, &frame].iter().for_each(|file| std::fs::remove_file(file).unwrap());
    let fact = difference(check());
    assert!(fact.starts_with("00000077.jpg is missing; "), "{fact}");
}
