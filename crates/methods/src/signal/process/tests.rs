//! Messages that signal programs are sent, and the inputs they need.
#![cfg(unix)]

use super::*;
use crate::tracker::process::testing::{Kind, Script, sequence, values};
use crate::tracker::testing::context;
use trackfail_core::image::decode;
use trackfail_testing::assert_says;

#[test]
fn a_program_gets_what_it_reads_and_its_answers_are_the_signal() {
    let script = Script::new(Kind::Signal, "begin; answer; echo end >> log");
    let signal = script.bound(&ENTRY, ", params = { rate = 0.5, words = [\"a\"] }");
    assert_eq!(values(&*signal), Ok(vec![0.5, 1.5, 2.5, 3.5]));
    assert_eq!(script.read("environment"), "  more \n");
    let expected = r#"{"meta":{"protocol":1,"program":"mine","role":"signal","frames":4,"params":{"rate":0.5,"words":["a"]}}}
{"index":0,"frame":null,"box":[0.0,2.5,3.0,4.0],"absent":false,"confidence":null}
{"index":1,"frame":null,"box":[1.0,2.5,3.0,4.0],"absent":false,"confidence":0.125}
{"index":2,"frame":null,"box":[0.4384471871911697,1.4384471871911697,4.123105625617661,4.123105625617661],"polygon":[1.0,1.0,5.0,2.0,4.0,6.0,0.0,5.0],"absent":false,"confidence":0.25}
{"index":3,"frame":null,"box":[3.0,2.5,3.0,4.0],"absent":true,"confidence":0.375}
end
"#;
    // Nothing of the ground truth, nor of what is made of it.
    assert_eq!(script.read("log"), expected);
}

#[test]
fn frames_and_responses_are_sent_to_programs_that_read_them() {
    let script = Script::new(Kind::Signal, "begin; answer");
    assert_eq!(values(&*script.bound(&ENTRY, ", reads = \"pixels\"")).unwrap().len(), 4);
    assert_says(script.read("log"), "\"frames\":4,\"size\":[320,240]");
    for t in 0..4 {
        let seen = std::fs::read(script.folder.path().join(format!("seen{t}.png"))).unwrap();
        assert_eq!(decode(&seen).unwrap(), sequence().frame(t).unwrap());
    }
    assert_eq!(values(&*script.bound(&ENTRY, ", reads = \"response\"")).unwrap().len(), 4);
    assert_says(script.read("log"), "\"response\":{\"peak\":0.5");
}

#[test]
fn an_image_that_cannot_be_written_ends_the_program() {
    let text = "begin; ask; rm -r \"$(dirname \"$(image)\")\"; say; n=1; answer";
    let script = Script::new(Kind::Signal, text);
    let fault = values(&*script.bound(&ENTRY, ", reads = \"pixels\"")).unwrap_err();
    assert!(fault.starts_with("mine: frame 12 of Ramp: ") && fault.contains(".png: "), "{fault}");
}

#[test]
fn parameters_say_what_it_needs_and_what_is_good() {
    let mut script = Script::new(Kind::Signal, "");
    script.program.digest = vec!["/a/b".into()];
    let signal = script.bound(&ENTRY, ", good = \"low\", reads = \"pixels\"");
    assert_eq!((signal.facts().direction, signal.reads()), (Direction::LowerIsBetter, Reads::Pixels));
    let expected = serde_json::json!(
        { "program": "mine", "good": "low", "reads": "pixels", "params": {}, "version": "7" }
    );
    assert_eq!(signal.params(), expected);
    let inputs = signal.inputs(&context(&sequence(), 0)).unwrap();
    assert_eq!(inputs, [PathBuf::from("/a/b")]);
}
