use super::*;
use trackfail_core::region::Rect;
use trackfail_testing::{needs, real_data};

/// Objects 7 (frames 0, 1, 3) and 9 (frames 1, 2), with what CAVIAR writes beside the boxes.
const TWO: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
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

fn folder(xml: &str, files: &[&str]) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("two.xml"), xml).unwrap();
    for name in files {
        let path = dir.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, b"").unwrap();
    }
    dir
}

fn rect(x: f64, y: f64, w: f64, h: f64) -> Option<Region> {
    Some(Region::Rect(Rect::new(x, y, w, h)))
}

const FIVE: [&str; 5] =
    ["img1/000001.jpg", "img1/000002.jpg", "img1/000003.jpg", "img1/000004.jpg", "img1/000005.jpg"];

#[test]
fn one_object_is_a_sequence_and_xml_frame_n_is_image_n_plus_1() {
    let dir = folder(TWO, &FIVE);
    let s = load(dir.path(), &Entry { target: Some(7), ..Entry::default() }).unwrap();
    assert_eq!(s.truth[..2], [rect(25.0, 30.0, 10.0, 20.0), rect(26.5, 30.0, 10.0, 20.0)]);
    assert_eq!(s.truth[2..], [None, rect(28.0, 30.0, 10.0, 20.0)]);
    assert_eq!(s.numbering, Numbering { first: 1, official: (1, 4) });
    let Frames::Files(files) = &s.frames else { panic!("files") };
    assert!(files.len() == 4 && files[3].ends_with("img1/000004.jpg"));

    let options = Entry { name: "x".into(), target: Some(9), range: Some((3, 4)), ..Entry::default() };
    let s = load(dir.path(), &options).unwrap();
    assert_eq!((s.name.as_str(), s.truth), ("x", vec![rect(1.0, 0.0, 4.0, 4.0), None]));
    assert_eq!(s.numbering, Numbering { first: 3, official: (2, 3) });
}

#[test]
fn without_a_target_the_object_with_most_boxes_is_taken() {
    let dir = folder(TWO, &FIVE);
    assert_eq!(load(dir.path(), &Entry::default()).unwrap().len(), 4);
    // Of two with as many, the smaller id.
    let even = TWO.replace(r#"<object id="7"><box h="20" w="10" xc="33" yc="40"/></object>"#, "");
    let s = load(folder(&even, &FIVE).path(), &Entry::default()).unwrap();
    assert_eq!((s.len(), s.number(0)), (2, 1));
}

#[test]
fn faults_say_what_to_do() {
    let message =
        |dir: &tempfile::TempDir, options: &Entry| load(dir.path(), options).unwrap_err().to_string();
    let any = Entry::default();
    let range = |first, last| Entry { target: Some(7), range: Some((first, last)), ..Entry::default() };
    assert!(message(&folder(TWO, &FIVE[..3]), &any).contains("frame 4 is missing"));
    assert!(message(&folder(TWO, &[]), &any).contains("no .jpg or .png"));
    assert!(message(&folder(TWO, &["b.xml"]), &any).contains("b.xml and two.xml: only one annotation"));
    assert!(message(&folder(TWO, &["a.mpg", "b.AVI"]), &any).contains("a.mpg and b.AVI: only one video"));
    assert!(message(&folder("<dataset/>", &FIVE), &any).contains("no object is annotated"));
    let dir = folder(TWO, &FIVE);
    let nobody = Entry { target: Some(8), ..Entry::default() };
    assert!(message(&dir, &nobody).contains("no object 8; annotated are 7, 9"));
    assert!(message(&dir, &range(4, 5)).contains("its last is 4"));
    assert!(message(&dir, &range(0, 2)).contains("frames 0 to 2"));
    assert!(message(&dir, &range(3, 2)).contains("frames 3 to 2"));
    std::fs::remove_file(dir.path().join("two.xml")).unwrap();
    assert!(message(&dir, &any).contains("no annotation (.xml)"));
}

#[test]
fn a_video_is_not_opened_by_loading() {
    let dir = folder(TWO, &["clip.mpg"]);
    let s = load(dir.path(), &Entry::default()).unwrap();
    let Frames::Video(video) = &s.frames else { panic!("a video") };
    assert_eq!((video.path(), s.len()), (dir.path().join("clip.mpg").as_path(), 4));
    // Images in a folder of their own go before a video beside it.
    let both = folder(TWO, &[&FIVE[..], &["clip.mpg"]].concat());
    assert!(matches!(load(both.path(), &Entry::default()).unwrap().frames, Frames::Files(_)));
}

// python3, on the same annotation and video file:
//   q = lambda v: struct.pack('<Q', v); s = lambda b: q(len(b)) + b
//   h = s(b'trackfail-video/1') + q(1) + q(1) + q(4) + q(4) + s(b'clip.mpg') + s(b'abc')
//   r = lambda *v: b'\1' + struct.pack('<4d', *v)
//   h += r(25, 30, 10, 20) + r(26.5, 30, 10, 20) + b'\0' + r(28, 30, 10, 20); hashlib.sha256(h).hexdigest()
#[test]
fn the_digest_pins_the_video_and_the_truth() {
    let dir = folder(TWO, &["clip.mpg"]);
    let clip = dir.path().join("clip.mpg");
    let digest = |bytes: &[u8]| {
        std::fs::write(&clip, bytes).unwrap();
        load(dir.path(), &Entry::default()).unwrap().digest().unwrap().to_owned()
    };
    assert_eq!(digest(b"abc"), VIDEO_DIGEST);
    assert_ne!(digest(b"abd"), VIDEO_DIGEST);
    std::fs::write(dir.path().join("two.xml"), TWO.replace("31.5", "31.6")).unwrap();
    assert_ne!(digest(b"abc"), VIDEO_DIGEST);
}
const VIDEO_DIGEST: &str = "4583078265fcc6cb1675b71efc556c531607a3ac28d11fbf2e6d8cb7e92d554d";

// python3: r = xml.etree.ElementTree.parse('PETS2009-S2L1.xml').getroot()
//   f = {int(f.get('number')): {int(o.get('id')): [float(o.find('box').get(k)) for k in ('xc', 'yc', 'w', 'h')]
//        for o in f.find('objectlist')} for f in r}
#[needs(real_data)]
#[test]
fn pets_is_read_as_python_reads_it() {
    let root = real_data();
    let xml = root.join("pets2009/S2L1/PETS2009-S2L1.xml");
    let a = parse(&xml, &text::read(&xml).unwrap()).unwrap();
    // len(f), sum(map(len, f.values()))
    let boxes = |id| (1..=795).filter(|&n| a.region(id, n).is_some()).count();
    assert_eq!((a.last(), a.objects().map(boxes).sum::<usize>()), (795, 4650));
    let boxed = |xc: f64, yc: f64, w: f64, h: f64| Some(Rect::new(xc - w / 2.0, yc - h / 2.0, w, h));
    // f[0][9], f[159][13], f[146][19]; 19 in f[147] is False
    assert_eq!(a.region(9, 1), boxed(514.7109, 195.2731, 31.03, 75.17));
    assert_eq!(a.region(13, 160), boxed(688.3543, 149.8108, 21.3969, 67.43));
    assert_eq!(a.region(19, 147), boxed(746.8693, 273.0064, 31.4838, 85.9221));
    assert_eq!(a.region(19, 148), None);
    // sum(v[i][0] - v[i][2] / 2 for v in f.values() if i in v), i = 9, 13, 19
    for (id, sum) in [(9, 210160.33444999982), (13, 167089.7354), (19, 65263.446749999974)] {
        let left: f64 = (1..=795).filter_map(|n| a.region(id, n)).map(|r| r.x).sum();
        assert!((left - sum).abs() < 1e-6, "{id}: {left}");
    }
}

#[needs(real_data)]
#[test]
fn pets_people_of_the_frames_that_are_here_are_loaded() {
    let root = real_data();
    let loaded = crate::suite::Catalog::default()
        .suite("pets2009-s2l1-160")
        .unwrap()
        .load(std::slice::from_ref(&root));
    assert_eq!((loaded.sequences.len(), loaded.missing.len(), loaded.broken.len()), (8, 0, 0));
    for s in &loaded.sequences {
        assert!(s.truth.iter().all(Option::is_some), "{}", s.name);
        let frame = s.frame(s.len() - 1).unwrap();
        assert_eq!((frame.width(), frame.height()), (768, 576));
        assert_eq!(s.attributes, ["target-person"]);
    }
}

proptest::proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..300)) {
        let dir = folder("", &FIVE);
        std::fs::write(dir.path().join("two.xml"), &bytes).unwrap();
        let _ = load(dir.path(), &Entry::default());
    }

    #[test]
    fn a_changed_byte_is_read_or_refused(at in 0..TWO.len(), byte in proptest::prelude::any::<u8>()) {
        let dir = folder("", &FIVE);
        let mut bytes = TWO.as_bytes().to_vec();
        bytes[at] = byte;
        std::fs::write(dir.path().join("two.xml"), &bytes).unwrap();
        if let Ok(s) = load(dir.path(), &Entry::default()) {
            proptest::prop_assert!(s.truth.iter().flatten().all(|r| r.area() > 0.0));
        }
    }
}
