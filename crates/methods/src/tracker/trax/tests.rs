use super::*;
use proptest::prelude::*;
use std::io::Cursor;
use trackfail_core::region::Rect;
use trackfail_testing::assert_says;

fn one(line: &str) -> Message {
    parse(line.as_bytes()).unwrap().unwrap()
}

fn refused(line: &str) -> String {
    parse(line.as_bytes()).unwrap_err().to_string()
}

fn properties(pairs: &[(&str, &str)]) -> Properties {
    pairs.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect()
}

// The messages of the module's doc, in the words of the specification. What was understood is told by how it is written,
// since no two messages are written alike.
#[test]
fn messages_are_read() {
    for (read, written) in [
        (
            r#"hello "trax.version=2" trax.name=NCC "trax.region=rectangle;polygon;" "trax.image=path;URL""#,
            r#"hello "trax.version=2" "trax.image=path;url" "trax.region=rectangle;polygon" "trax.name=NCC""#,
        ),
        ("HELLO", r#"hello "trax.version=1" "trax.image=path" "trax.region=rectangle""#),
        (
            "initialize \"file:///data/a b/0001.jpg\" 10,20.5,30,40 \"x=1\"\r\n",
            r#"initialize "file:///data/a b/0001.jpg" "10,20.5,30,40" "x=1""#,
        ),
        // Version 4.
        ("initialize 10,20.5,30,40", r#"initialize "10,20.5,30,40""#),
        ("initialize /a.jpg 10,20.5,30,40", r#"initialize "file:///a.jpg" "10,20.5,30,40""#),
        (r#"frame "file:///d/\"a\\\n.jpg" "k=v w""#, r#"frame "file:///d/\"a\\\n.jpg" "k=v w""#),
        ("quit trax.reason=", r#"quit "trax.reason=""#),
        // Neither a path nor its `=` is a property: a key has no slash.
        ("frame   /data/x=1.png  ", r#"frame "file:///data/x=1.png""#),
        (
            r#"status "0,0,0,5,6,5,6,0" "confidence=0.9" empty="#,
            r#"state "0,0,0,5,6,5,6,0" "confidence=0.9" "empty=""#,
        ),
        ("state 0", r#"state "0""#),
        (
            r#"quit "trax.reason=all \"done\"\\\nbye = now""#,
            r#"quit "trax.reason=all \"done\"\\\nbye = now""#,
        ),
        (r"quit a=b\ c\nd", r#"quit "a=b c\nd""#),
    ] {
        assert_eq!(write(&one(&format!("@@TRAX:{read}"))).unwrap(), format!("@@TRAX:{written}\n"));
    }
}

#[test]
fn other_lines_are_skipped() {
    for line in ["", "loading ...", " @@TRAX:quit", "x@@TRAX:quit", "@@TRAX", "@@trax:quit"] {
        assert!(parse(line.as_bytes()).unwrap().is_none(), "{line}");
    }
}

#[test]
fn errors_name_the_received_and_the_expected_message() {
    for (words, lines) in [
        ("received `@@TRAX:bye `; expected hello, initialize, frame, state or quit", &["bye"][..]),
        ("expected hello", &["", " quit"]),
        ("named arguments alone", &["hello now", "quit now"]),
        ("received `trax.version=5`; expected a version from 1 to 4", &["hello trax.version=5"]),
        ("a version from 1 to 4", &["hello trax.version=0", "hello trax.version=-1"]),
        ("a version from 1 to 4", &["hello trax.version=9999999999999999999"]),
        ("one region, before it one image or none", &["initialize", "initialize a.jpg depth.png 1,2,3,4"]),
        ("separated by commas", &["initialize a.jpg", "state 1,,2,4", "state 1;2;3;4"]),
        ("a place to start from", &["initialize a.jpg 0"]),
        ("one image", &["frame", "frame a=1.jpg"]),
        ("file://", &["frame \"\"", "frame file://", "frame http://example.org/a.jpg"]),
        ("file://", &["frame image:2;2;rgb;AAAA", "frame data:image/jpeg;base64;AAAA"]),
        ("one region", &["state", "state 1,2,3,4 5,6,7,8"]),
        ("masks are not read", &["state mask:0,0,2,2,1,3", "state m0,0,2,2,1,3"]),
        ("received the region `1,2,3`: a region takes 4 numbers", &["state 1,2,3"]),
        ("no area", &["state 1,2,0,4"]),
        ("not a finite number", &["state 1,2,nan,4", "state 1,2,inf,4"]),
        ("not convex", &["state 0,0,2,1,0,2,0.5,1"]),
        ("not 1 numbers", &["state 1.5"]),
        ("every named argument once", &["quit a=1 a=2"]),
        ("a closing quote", &["quit \"a=1"]),
        ("a blank after a closing quote", &["quit \"a=1\"b=2"]),
        ("a character after", &["quit a=\\"]),
        ("without NUL", &["quit a=\0"]),
    ] {
        lines.iter().for_each(|line| assert_says(refused(&format!("@@TRAX:{line}")), words));
    }
    assert!(matches!(parse(b"@@TRAX:quit \xFF"), Err(TraxError::Unexpected(_))));
    let long = refused(&format!("@@TRAX:state {}", "9".repeat(5000)));
    assert!(long.len() < 200 && long.contains("999..."), "{long}");
}

#[test]
fn keys_have_an_alphabet_and_a_length() {
    let key = "k".repeat(64);
    let quit = Message::Quit { properties: properties(&[(&key, "1")]) };
    assert_eq!(one(&format!("@@TRAX:quit {key}=1")), quit);
    // Not a key, so an argument by position, which `quit` has none of.
    for bad in ["k".repeat(65), "a-b".into(), String::new(), "\u{e9}".into(), "a\\=b".into()] {
        assert!(refused(&format!("@@TRAX:quit {bad}=1")).contains("named arguments alone"), "{bad}");
    }
}

#[test]
fn messages_stand_among_other_output() {
    let noise = "x".repeat(3 * MAX_MESSAGE_BYTES);
    let text = format!(
        "loading\n{noise}\n\n@@TRAX:hello\r\n@@trax\nfps: 12 @@TRAX:quit\n@@TRAX:state 1,2,3,4\n@@TRAX:state 1,2,3,4"
    );
    // A small buffer, so that lines come in pieces.
    let mut reader = std::io::BufReader::with_capacity(7, Cursor::new(text));
    assert!(matches!(read(&mut reader).unwrap(), Some(Message::Hello(_))));
    assert!(matches!(read(&mut reader).unwrap(), Some(Message::TrackerState { .. })));
    // Nobody knows whether the last message is whole.
    assert!(read(&mut reader).unwrap().is_none());
    assert!(read(&mut reader).unwrap().is_none());
}

#[test]
fn a_message_without_end_is_refused_and_not_stored() {
    struct Endless;
    impl std::io::Read for Endless {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            buffer.fill(b'9');
            Ok(buffer.len())
        }
    }
    let endless = std::io::Read::chain(&b"log\n@@TRAX:state "[..], Endless);
    let mut reader = std::io::BufReader::new(endless);
    assert!(matches!(read(&mut reader), Err(TraxError::TooLong)));
    let line = format!("@@TRAX:quit a={}", "b".repeat(MAX_MESSAGE_BYTES));
    assert!(matches!(parse(line.as_bytes()), Err(TraxError::TooLong)));
}

#[test]
fn what_no_message_can_say_is_not_written() {
    let quit = |key: &str, value: &str| write(&Message::Quit { properties: properties(&[(key, value)]) });
    assert!(quit("a b", "").unwrap_err().to_string().contains("the key `a b`"));
    assert!(quit("", "").is_err() && quit("a", "\0").is_err());
    assert!(quit("a", &"b".repeat(MAX_MESSAGE_BYTES)).is_err());
    let nowhere = Message::Frame { image: PathBuf::new(), properties: Properties::new() };
    assert!(write(&nowhere).is_err());
    let hello = Hello { version: 5, images: vec![], regions: vec![], properties: Properties::new() };
    assert!(write(&Message::Hello(hello)).is_err());
}

fn texts() -> impl Strategy<Value = String> {
    "[a-z=\"\\\\ \n\r;,.\u{e9}\u{202e}-]{0,20}"
}

fn messages() -> impl Strategy<Value = Message> {
    let named = prop::collection::btree_map("[a-zA-Z0-9._]{1,64}", texts(), 0..4);
    let place = (-1e6..1e6_f64, -1e6..1e6_f64, 1e-3..1e6_f64, 1e-3..1e6_f64);
    let region = (place, any::<bool>()).prop_map(|((x, y, w, h), polygon)| {
        let rect = Rect::new(x, y, w, h);
        if polygon { Region::Polygon(rect.corners().to_vec()) } else { Region::Rect(rect) }
    });
    (0..6, named, texts(), region, any::<i64>()).prop_map(|(kind, properties, name, region, code)| {
        let image = PathBuf::from(format!("/{name}"));
        match kind {
            0 => Message::Initialize { image: Some(image), region, properties },
            5 => Message::Initialize { image: None, region, properties },
            1 => Message::Frame { image, properties },
            2 => Message::TrackerState { answer: Answer::Region(region), properties },
            3 => Message::TrackerState { answer: Answer::Code(code), properties },
            _ => Message::Quit { properties },
        }
    })
}

proptest! {
    #[test]
    fn written_messages_are_read_back(sent in prop::collection::vec(messages(), 1..4)) {
        let text: String = sent.iter().map(|m| write(m).unwrap()).collect();
        let mut reader = Cursor::new(text);
        for message in &sent {
            let read = read(&mut reader).unwrap();
            prop_assert_eq!(read.as_ref(), Some(message));
        }
        prop_assert!(read(&mut reader).unwrap().is_none());
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut reader = Cursor::new(&bytes);
        while let Ok(Some(_)) = read(&mut reader) {}
        let _ = parse(&[PREFIX.as_bytes(), &bytes].concat());
    }

    #[test]
    fn damaged_messages_are_read_or_refused(sent in messages(), at in any::<prop::sample::Index>(), byte: u8) {
        let mut bytes = write(&sent).unwrap().into_bytes();
        let at = at.index(bytes.len());
        bytes[at] = byte;
        let _ = parse(&bytes);
        let _ = parse(&bytes[..at]);
    }
}
