use super::super::tests::{TWO, changed, place, read, rect};
use super::*;
use trackfail_core::region::Rect;
use trackfail_testing::{assert_says, needs, put, real_data};

/// Folder with an annotation of two objects beside a video.
fn with_video() -> tempfile::TempDir {
    place("cvml", [], &[("two.xml", TWO), ("clip.mpg", "")])
}

fn of(target: u32) -> Entry {
    Entry { target: Some(target), ..Entry::default() }
}

#[test]
fn one_object_is_a_sequence_and_xml_frame_n_is_image_n_plus_1() {
    let dir = changed("cvml", &[]);
    let s = load(dir.path(), &of(7)).unwrap();
    assert_eq!(s.truth[..2], [rect(25.0, 30.0, 10.0, 20.0), rect(26.5, 30.0, 10.0, 20.0)]);
    assert_eq!(s.truth[2..], [None, rect(28.0, 30.0, 10.0, 20.0)]);
    assert_eq!(s.numbering, Numbering { first: 1, official: (1, 4) });
    let Frames::Files(files) = &s.frames else { panic!("files") };
    assert!(files.len() == 4 && files[3].ends_with("img1/000004.jpg"));

    let options = Entry { name: "x".into(), range: Some((3, 4)), ..of(9) };
    let s = load(dir.path(), &options).unwrap();
    assert_eq!((s.name.as_str(), s.truth), ("x", vec![rect(1.0, 0.0, 4.0, 4.0), None]));
    assert_eq!(s.numbering, Numbering { first: 3, official: (2, 3) });
}

#[test]
fn without_a_target_the_object_with_most_boxes_is_taken() {
    assert_eq!(read("cvml", &changed("cvml", &[])).unwrap().len(), 4);
    // Of two with as many, the smaller id.
    let even = TWO.replace(r#"<object id="7"><box h="20" w="10" xc="33" yc="40"/></object>"#, "");
    let s = read("cvml", &changed("cvml", &[("two.xml", &even)])).unwrap();
    assert_eq!((s.len(), s.number(0)), (2, 1));
}

#[test]
fn faults_say_what_to_do() {
    let message = |dir: &tempfile::TempDir, entry: Entry| load(dir.path(), &entry).unwrap_err().to_string();
    for (images, files, words) in [
        (3, &[("two.xml", TWO)][..], "frame 4 is missing"),
        (0, &[("two.xml", TWO)], "no .jpg or .png"),
        (0, &[("two.xml", TWO), ("b.xml", "")], "b.xml and two.xml: only one annotation"),
        (0, &[("two.xml", TWO), ("a.mpg", ""), ("b.AVI", "")], "a.mpg and b.AVI: only one video"),
        (5, &[("two.xml", "<dataset/>")], "no object is annotated"),
        (5, &[], "no annotation (.xml)"),
    ] {
        assert_says(message(&place("cvml", 1..=images, files), Entry::default()), words);
    }
    let of_zero = place("cvml", 0..=4, &[("two.xml", TWO)]);
    assert_says(message(&of_zero, Entry::default()), "number them from 1");
    let dir = changed("cvml", &[]);
    assert_says(message(&dir, of(8)), "no object 8; annotated are 7, 9");
    for (range, words) in [((4, 5), "its last is 4"), ((0, 2), "frames 0 to 2"), ((3, 2), "frames 3 to 2")] {
        assert_says(message(&dir, Entry { range: Some(range), ..of(7) }), words);
    }
}

#[test]
fn a_video_is_not_opened_by_loading() {
    let dir = with_video();
    let s = read("cvml", &dir).unwrap();
    let Frames::Video(video) = &s.frames else { panic!("a video") };
    assert_eq!((video.path(), s.len()), (dir.path().join("clip.mpg").as_path(), 4));
    // Images in a folder of their own go before a video beside it.
    let both = changed("cvml", &[("clip.mpg", "")]);
    assert!(matches!(read("cvml", &both).unwrap().frames, Frames::Files(_)));
}

// python3, on the same annotation and video file:
//   q = lambda v: struct.pack('<Q', v); s = lambda b: q(len(b)) + b
//   h = s(b'trackfail-video/1') + q(1) + q(1) + q(4) + q(4) + s(b'clip.mpg') + s(b'abc')
//   r = lambda *v: b'\1' + struct.pack('<4d', *v)
//   h += r(25, 30, 10, 20) + r(26.5, 30, 10, 20) + b'\0' + r(28, 30, 10, 20); hashlib.sha256(h).hexdigest()
#[test]
fn the_digest_pins_the_video_and_the_truth() {
    let dir = with_video();
    let digest = |bytes: &str| {
        put(dir.path(), "clip.mpg", bytes);
        read("cvml", &dir).unwrap().digest().unwrap().to_owned()
    };
    assert_eq!(digest("abc"), VIDEO_DIGEST);
    assert_ne!(digest("abd"), VIDEO_DIGEST);
    put(dir.path(), "two.xml", TWO.replace("31.5", "31.6"));
    assert_ne!(digest("abc"), VIDEO_DIGEST);
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
