//! Properties that every format must have, and sample folders of each.

use super::*;
use proptest::prelude::*;
use tempfile::TempDir;
use trackfail_core::region::Rect;
use trackfail_testing::{assert_says, damaged, folder, put};

/// Names of text files with their texts.
pub(super) type Texts = [(&'static str, &'static str)];

pub(super) const META: &str = "[METAINFO]\nurl: http://x/y\nanno_fps: 10Hz\nobject_class: Jet Ski\n\
                               motion_class: sliding\nroot_class: Artifact\nresolution: (64, 48)\n";

/// CVML of objects 7 (frames 0, 1, 3) and 9 (frames 1, 2), with the other elements that CAVIAR writes.
pub(super) const TWO: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<dataset name="Two">
<frame number="0"><objectlist>
  <object id="7"><orientation>90</orientation><box h="20" w="10" xc="30" yc="40"/><appearance>appear</appearance>
    <hypothesislist><hypothesis evaluation="1.0" id="1" prev="1.0"><movement evaluation="1.0">walking</movement>
    <box h="1" w="1" xc="1" yc="1"/></hypothesis></hypothesislist></object>
</objectlist><grouplist/></frame>
<frame number="1"><objectlist>
  <object id="7"><box h="20" w="10" xc="31.5" yc="40"/></object>
  <object id="9"><box h="4" w="4" xc="2" yc="2"/></object>
</objectlist><grouplist>
  <group id="7"><box h="99" w="99" xc="50" yc="50"/><members>7,9</members></group>
</grouplist></frame>
<frame number="2"><objectlist><object id="9"><box h="4" w="4" xc="3" yc="2"/></object></objectlist></frame>
<frame number="3"><objectlist><object id="7"><box h="20" w="10" xc="33" yc="40"/></object></objectlist></frame>
</dataset>
"#;

/// Word, number of images and files of a sample folder, for each format that has one.
pub(super) const SAMPLES: [(&str, u32, &Texts); 5] = [
    ("otb", 2, &[("groundtruth_rect.txt", "1,1,2,2\n1,1,2,2"), ("attributes.txt", "blur\n")]),
    ("vot", 2, &[("groundtruth.txt", "1,2,3,4\n1,2,3,4"), ("occlusion.label", "0\n1")]),
    (
        "got10k",
        5,
        &[
            (
                "groundtruth.txt",
                "10.0000,8.0000,20.0000,10.0000\n12.0000,8.0000,20.0000,10.0000\n14.5000,9.0000,20.0000,10.0000\n\
                 0.0000,0.0000,0.0000,0.0000\n20.0000,10.0000,16.0000,12.5000\n",
            ),
            ("absence.label", "0\n0\n0\n1\n0\n"),
            ("cover.label", "8\n8\n3\n0\n6\n"),
            ("cut_by_image.label", "0\n0\n0\n0\n1\n"),
            ("meta_info.ini", META),
        ],
    ),
    (
        "lasot",
        4,
        &[
            ("groundtruth.txt", "367,101,41,16\n366,103,45,16\n1,1,-1,-1\n363,103,43,17\n"),
            ("full_occlusion.txt", "0,0,1,0"),
            ("out_of_view.txt", "0,0,0,1\n"),
            ("nlp.txt", "white airplane\n"),
        ],
    ),
    ("cvml", 5, &[("two.xml", TWO)]),
];

pub(super) fn rect(x: f64, y: f64, w: f64, h: f64) -> Option<Region> {
    Some(Region::Rect(Rect::new(x, y, w, h)))
}

/// Creates a sequence folder with empty images of these numbers and with these files. A later file of the
/// same name wins.
pub(super) fn place<B: AsRef<[u8]> + Copy>(
    word: &str,
    images: impl IntoIterator<Item = u32>,
    files: &[(&str, B)],
) -> TempDir {
    let dir = folder(files.iter().copied());
    for n in images {
        let name = match word {
            "otb" => format!("img/{n:04}.jpg"),
            "lasot" => format!("img/{n:08}.jpg"),
            "cvml" => format!("img1/{n:06}.jpg"),
            _ => format!("{n:08}.jpg"),
        };
        put(dir.path(), name, "");
    }
    dir
}

/// Sample folder in which some files have other texts.
pub(super) fn changed(word: &str, files: &[(&str, &str)]) -> TempDir {
    let (_, images, sample) = SAMPLES.into_iter().find(|sample| sample.0 == word).unwrap();
    place(word, 1..=images, &[sample, files].concat())
}

/// Loads the sequence of a folder.
pub(super) fn read(word: &str, dir: &TempDir) -> Result<Sequence, DatasetError> {
    (find(word).unwrap().load)(dir.path(), &Entry::default())
}

#[test]
fn words_are_unique_and_help_texts_are_there() {
    for format in FORMATS {
        assert_eq!(FORMATS.iter().filter(|f| f.word == format.word).count(), 1, "{}", format.word);
        assert!(!format.summary.is_empty() && (format.reads)(format.truth_file), "{}", format.word);
        assert_eq!(find(format.word), Some(format));
    }
    assert_eq!(find("xml"), None);
}

// What is no ground truth is an error everywhere, and boxes have an area.
#[test]
fn empty_files_are_no_ground_truth() {
    for format in FORMATS {
        assert!((format.parse_truth)(Path::new("a"), b"").is_err(), "{}", format.word);
    }
}

#[test]
fn faults_name_file_and_line_or_both_counts() {
    for (word, file, words, texts) in [
        ("otb", "groundtruth_rect.txt, line 1", "", "1,1,2,-2\n1,1,2,2;1,1,2,2,3\n1,1,2,2;x,y,w,h\n1,1,2,2"),
        ("otb", "groundtruth_rect.txt, line 2", "", "1,1,2,2\n\n1,1,2,2"),
        ("otb", "groundtruth_rect.txt", "empty", ";\n\r\n;\u{feff}"),
        ("otb", "attributes.txt, line 2", "`=cmd|A0`: an attribute is plain text", "blur\nblur, =cmd|A0\n"),
        ("vot", "occlusion.label", "", "0\n1\n0;0\n2;;0 1 0"),
        ("got10k", "groundtruth.txt, line 2", "3 numbers", "1,1,2,2\n1,1,2\n1,1,2,2\n1,1,2,2\n1,1,2,2"),
        ("got10k", "groundtruth.txt, line 2", "empty line", "1,1,2,2\n\n1,1,2,2"),
        ("got10k", "groundtruth.txt", "empty", ""),
        ("got10k", "absence.label", "4 labels for 5", "0\n0\n0\n1\n"),
        ("got10k", "absence.label, line 4", "`2`", "0\n0\n0\n2\n0"),
        ("got10k", "cover.label, line 3", "`9`", "8\n8\n9\n0\n6"),
        ("got10k", "cover.label", "6 labels for 5", "8\n8\n8\n0\n6\n8"),
        ("got10k", "cut_by_image.label", "0 labels for 5", ""),
        ("got10k", "meta_info.ini, line 2", "key: value", "[METAINFO]\nurl"),
        ("lasot", "groundtruth.txt, line 2", "3 numbers", "1,1,2,2\n1,1,2\n1,1,2,2\n1,1,2,2"),
        ("lasot", "full_occlusion.txt", "3 labels for 4", "0,0,0"),
        ("lasot", "full_occlusion.txt, line 1", "`7`", "0,0,0,7"),
        ("lasot", "out_of_view.txt", "5 labels for 4", "0,0,0,0,0"),
    ] {
        let name = file.split(',').next().unwrap();
        for text in texts.split(';') {
            let error = read(word, &changed(word, &[(name, text)])).unwrap_err().to_string();
            assert!(error.contains(file) && error.contains(words), "{word}, {file}, {text:?}: {error}");
        }
    }
    // Second lines that are no box, and such that VOT has beside them.
    let (of_all, of_vot) = ("1,1,2|1,1,inf,2|1,1,nan,2", "1|1,2,3,4,5,6,7|0,0,1,1,0,1,1,0|1,1,1,1,1,1,1,1");
    for (word, lines, bad) in [
        ("otb", 2, format!("{of_all}|1,1,0,2")),
        ("vot", 2, format!("{of_all}|1,2,3,0|{of_vot}")),
        ("got10k", 5, format!("{of_all}|1,1,0,2")),
        ("lasot", 4, format!("{of_all}|1,1,-inf,2")),
    ] {
        let file = find(word).unwrap().truth_file;
        for line in bad.split('|') {
            let text = format!("1,1,2,2\n{line}{}", "\n1,1,2,2".repeat(lines - 2));
            let error = read(word, &changed(word, &[(file, &text)])).unwrap_err().to_string();
            assert!(error.contains(&format!("{file}, line 2")), "{word}, {line}: {error}");
        }
    }
    let error = read("otb", &place("otb", 1..=2, &[("groundtruth_rect.txt", b"1,1,2,2\n\xFF\xFE")]));
    assert!(matches!(error, Err(DatasetError::Line { line: 2, .. })));
}

#[test]
fn files_that_a_mac_puts_beside_others_are_no_labels() {
    let files = [("._occlusion.label", "Mac OS X"), ("._00000001.jpg", "Mac OS X"), (".label", "Mac OS X")];
    let attributes = read("vot", &changed("vot", &files)).unwrap().frame_attributes;
    assert_eq!(attributes, [("occlusion".to_owned(), vec![false, true])]);
}

#[test]
fn images_and_lines_are_as_many() {
    for (word, images, lines, words) in [
        ("got10k", 3, 2, "3 images, but 2 lines"),
        ("got10k", 2, 3, "2 images, but 3 lines"),
        ("got10k", 9, 1, "9 images, but 1 lines"),
        ("got10k", 9, 1, "test set"),
        ("lasot", 3, 4, "3 images, but 4 lines"),
        ("vot", 3, 2, ""),
        ("vot", 1, 2, ""),
        ("otb", 3, 2, "2 lines from frame 1 on do not cover frames 1 to 3"),
    ] {
        let name = find(word).unwrap().truth_file;
        let dir = place(word, 1..=images, &[(name, "1,1,2,2\n".repeat(lines).as_str())]);
        let error = read(word, &dir).unwrap_err().to_string();
        assert!(error.contains(words), "{word}, {images}, {lines}: {error}");
    }
    let gap = place("got10k", [1, 3, 4], &[("groundtruth.txt", "1,1,2,2\n1,1,2,2\n1,1,2,2")]);
    assert_says(read("got10k", &gap).unwrap_err(), "frame 2 is missing");
}

const BOXES: &[u8] =
    b"\xEF\xBB\xBF1,1,10,20\r\n-4\t7\t1.5\t2\r\n0,0,0,0\nNaN NaN NaN NaN\n3 4, 5 6\n367,101,41,16";
const REGIONS: &[u8] = b"1,2,3,4\r\n0,0,0,5,6,5,6,0\n1.5,2.5,9e1,-7.25,11,12\nnan,nan,nan,nan\n";
const WITHOUT_AREA: &[u8] =
    b"367,101,41,16\n366,103,45,16\r\n1,1,-1,-1\n0,0,0,0\nnan,nan,nan,nan\n3.5\t4\t5\t6";

proptest! {
    #[test]
    fn any_truth_is_read_or_refused(
        bytes in prop_oneof![
            prop::collection::vec(any::<u8>(), 0..300), any::<String>().prop_map(String::into_bytes),
            "[0-9NainF.,;\t\r\n -]{0,80}".prop_map(String::into_bytes),
            damaged(BOXES), damaged(REGIONS), damaged(WITHOUT_AREA), damaged(TWO.as_bytes()),
        ],
    ) {
        let has_areas = |truth: &[Option<Region>]| truth.iter().flatten().all(|r| r.area() > 0.0);
        for format in FORMATS {
            if let Ok(truth) = (format.parse_truth)(Path::new("a.txt"), &bytes) {
                prop_assert!(has_areas(&truth), "{}", format.word);
            }
        }
        // Each text file in its turn.
        for (word, images, files) in SAMPLES {
            let dir = changed(word, &[]);
            for (name, text) in files {
                put(dir.path(), name, &bytes);
                if let Ok(s) = read(word, &dir) {
                    prop_assert!(has_areas(&s.truth), "{word}, {name}");
                    prop_assert!(s.len() == images as usize || word == "cvml", "{word}, {name}");
                }
                put(dir.path(), name, text);
            }
        }
    }
}
