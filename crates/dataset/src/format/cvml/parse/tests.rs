use super::*;
use proptest::prelude::*;
use trackfail_testing::assert_says;

fn read(document: &str) -> Result<Annotation, DatasetError> {
    parse(Path::new("a.xml"), document)
}

fn one(object: &str) -> String {
    format!("<dataset>\n<frame number=\"0\">\n<objectlist>\n{object}\n</objectlist>\n</frame>\n</dataset>")
}

#[test]
fn faults_name_their_line() {
    let good = r#"<object id="1"><box xc="5" yc="5" w="2" h="2"/></object>"#;
    assert_eq!(read(&one(good)).unwrap().region(1, 1), Some(Rect::new(4.0, 4.0, 2.0, 2.0)));
    let with = |from: &str, to: &str| one(&good.replacen(from, to, 1));
    for (document, line, words) in [
        (with("w=\"2\"", "w=\"-2\""), 4, "no area"),
        (with("w=\"2\"", "w=\"0\""), 4, "no area"),
        (with("w=\"2\"", "w=\"NaN\""), 4, "no image"),
        (with("w=\"2\"", "w=\"inf\""), 4, "no image"),
        (with("w=\"2\"", "w=\"1e300\""), 4, "no image"),
        (with("w=\"2\"", "w=\"2px\""), 4, "no number"),
        (with("w=\"2\"", "w=\"&lots;\""), 4, "no number"),
        (with("w=\"2\"", ""), 4, "no attribute `w`"),
        (with("w=\"2\"", "w=\"2\" w=\"2\""), 4, "<box>"),
        (with("id=\"1\"", "id=\"-1\""), 4, "whole number"),
        (with("id=\"1\"", "id=\"99999999999999999999\""), 4, "whole number"),
        (with("id=\"1\"", ""), 4, "no attribute `id`"),
        (one(&format!("{good}\n{good}")), 5, "object 1 comes twice in frame 0"),
        (one("<object id=\"1\">\n</object>"), 5, "has no <box>"),
        (one("<object id=\"1\"/>"), 4, "has no <box>"),
        (with("/></object>", "/>\n<box xc=\"5\" yc=\"5\" w=\"2\" h=\"2\"/></object>"), 5, "two boxes"),
        (with("</object>", "</objekt>"), 4, "not well-formed"),
        (with("<object", "\n<"), 5, "not well-formed"),
        (with("</object>", "&bomb;</object>"), 4, "entity `bomb`"),
        (one(good).replace("number=\"0\"", "number=\"4000000000\""), 2, "no sequence has so many"),
        (one(good).replace("<frame", "<frame number=\"0\"/>\n<frame"), 3, "comes twice"),
        (one(good).replace("dataset", "results"), 1, "starts with <results>"),
        (one(good).replace("</dataset>", ""), 7, "the document ends before"),
        (format!("{}\n<dataset/>", one(good)), 8, "after the end"),
        (String::new(), 1, "the document ends before"),
        ("0 0 1 1\n".into(), 2, "the document ends before"),
    ] {
        let error = read(&document).unwrap_err();
        assert!(matches!(error, DatasetError::Line { line: l, .. } if l == line), "{document}: {error}");
        assert_says(error, words);
    }
}

#[test]
fn entity_bombs_are_refused_before_they_are_anything() {
    let mut bomb = String::from("<?xml version=\"1.0\"?>\n<!DOCTYPE dataset [\n<!ENTITY a0 \"ha\">\n");
    for k in 1..40 {
        bomb += &format!("<!ENTITY a{k} \"&a{0};&a{0};\">\n", k - 1);
    }
    bomb += "]>\n<dataset>&a39;</dataset>";
    assert_says(read(&bomb).unwrap_err(), "line 2: the document declares entities");
    assert!(read("<!DOCTYPE dataset SYSTEM \"cvml.dtd\"><dataset><a>&lt;&#65;</a></dataset>").is_ok());
}

#[test]
fn depth_is_limited_wherever_it_is() {
    let deep = |n: usize| format!("<dataset>{}{}</dataset>", "<a>".repeat(n), "</a>".repeat(n));
    assert!(read(&deep(MAX_DEPTH - 1)).is_ok());
    assert_says(read(&deep(MAX_DEPTH)).unwrap_err(), "nested more than");
    assert!(read(&format!("<dataset>{}", "<a>".repeat(1_000_000))).is_err());
}

#[test]
fn four_zeros_are_no_annotation() {
    let zeros = one(r#"<object id="1"><box xc="0" yc="0" w="0" h="0"/></object>"#);
    let found = read(&zeros).unwrap();
    assert_eq!((found.objects().count(), found.last()), (0, 1));
}

/// CVML document of boxes, keyed by frame and object.
fn document(boxes: &BTreeMap<(u32, u32), (i32, i32, u32, u32)>) -> String {
    let mut text = String::from("<dataset>");
    let frames: BTreeSet<u32> = boxes.keys().map(|k| k.0).collect();
    for frame in frames.into_iter().rev() {
        text += &format!("<frame number=\"{frame}\"><objectlist>\n");
        for ((_, id), (xc, yc, w, h)) in boxes.range((frame, 0)..=(frame, u32::MAX)) {
            text += &format!("<object id=\"{id}\"><box w='{w}' h='{h}' yc='{yc}' xc='{xc}'/></object>\n");
        }
        text += "</objectlist></frame>";
    }
    text + "</dataset>"
}

proptest! {
    #[test]
    fn any_pieces_of_cvml_are_read_or_refused(
        pieces in prop::collection::vec(
            prop::sample::select(vec![
                "<dataset>", "</dataset>", "<frame number=\"0\">", "<frame number=\"1\">", "</frame>",
                "<objectlist>", "</objectlist>", "<object id=\"1\">", "</object>", "<box ", "xc=\"1\" ",
                "yc=\"1\" ", "w=\"1\" ", "h=\"1\" ", "h=\"NaN\" ", "/>", ">", "<!--", "-->", "<![CDATA[", "]]>",
                "<?x", "?>", "&a;", "&#x110000;", "<!DOCTYPE a [", "]>", "\n", "\u{0}", "é",
            ]),
            0..40,
        ),
    ) {
        let _ = read(&pieces.concat());
    }

    #[test]
    fn what_is_written_is_read_back(
        boxes in prop::collection::btree_map(
            (0..20_u32, 0..5_u32), (-500..500_i32, -500..500_i32, 1..300_u32, 1..300_u32), 0..40),
    ) {
        let found = read(&document(&boxes)).unwrap();
        for ((frame, id), (xc, yc, w, h)) in &boxes {
            let (w, h) = (f64::from(*w), f64::from(*h));
            let rect = Rect::new(f64::from(*xc) - w / 2.0, f64::from(*yc) - h / 2.0, w, h);
            prop_assert_eq!(found.region(*id, frame + 1), Some(rect));
        }
        let count: usize = found.objects().map(|id| (1..=20).filter(|&n| found.region(id, n).is_some()).count()).sum();
        prop_assert_eq!(count, boxes.len());
    }
}
