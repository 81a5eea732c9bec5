//! Messages that detector programs are sent, and the parts of their address.
#![cfg(unix)]

use super::*;
use crate::tracker::process::testing::{Kind, Script, detect};
use trackfail_testing::assert_says;

#[test]
fn a_program_gets_the_signal_and_its_answers_are_the_labels() {
    let script = Script::new(Kind::Detector, "begin; answer");
    let output = detect(&*script.bound(&ENTRY, ", params = { k = 4 }"), &[]);
    let (score, alarm) = (vec![0.5, 1.5, 2.5, 3.5], vec![false, true, false, true]);
    assert_eq!(output, DetectorOutput { score, alarm, ..DetectorOutput::default() });
    assert_eq!(script.read("environment"), "99  more \n");
    let expected = r#"{"meta":{"protocol":1,"program":"mine","role":"detector","frames":4,"params":{"k":4}}}
{"index":0,"value":0.5}
{"index":1,"value":-1.0}
{"index":2,"value":2.0}
{"index":3,"value":4.0}
"#;
    assert_eq!(script.read("log"), expected);
    let detector = script.bound(&ENTRY, ", signals = 2");
    assert_eq!(detector.facts().signals, 2);
    detect(&*detector, &[&[1.0, 2.0, 3.0, 4.0]]);
    assert_says(script.read("log"), r#""value":-1.0,"more":[2.0]}"#);
    assert!(ENTRY.build_from_text("{ program = \"mine\", signals = 0 }").is_err());
}

#[test]
fn version_files_and_seed_are_part_of_the_address() {
    let bound = |text: &str| {
        let mut script = Script::new(Kind::Detector, text);
        script.program.digest = vec![script.folder.path().join("script.sh")];
        script.bound(&ENTRY, "")
    };
    let detector = bound("# a");
    let shown = detector.params();
    assert_eq!((shown["version"].as_str(), detector.facts().uses_seed), (Some("7"), true));
    let file = shown["files"][0].as_str().unwrap();
    assert!(file.starts_with("script.sh ") && file.len() > 40, "{file}");
    assert_ne!(bound("# b").params(), shown);
    assert_eq!(bound("# a").params(), shown);
    let mut script = Script::new(Kind::Detector, "");
    script.program.deterministic = true;
    assert!(!script.bound(&ENTRY, "").facts().uses_seed);
    script.program.digest = vec![script.folder.path().join("absent.py")];
    let mut unbound = ENTRY.build_from_text("{ program = \"mine\" }").unwrap();
    assert_says(Bind::bind(&mut unbound, &script.programs()).unwrap_err().message, "absent.py");
}
