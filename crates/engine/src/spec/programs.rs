//! `plugins.toml`: programs that may be run as [trackers](trackfail_methods::tracker::process),
//! [signals](trackfail_methods::signal::process) and [detectors](trackfail_methods::detector::process). As in
//! experiment files, an unknown key is an error with its line and the nearest valid word.

use super::check;
use super::error::{At, Errors, Source, SourceFile, SpecError};
use super::limits::read_at_most;
use super::name::is_word;
use super::schema::{remove, remove_null};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, LazyLock};
use std::time::Duration;
use toml::de::DeTable;
use trackfail_dataset::text;
use trackfail_methods::tracker::process::{Program, Programs, Protocol, Regions, Role};

/// Largest file, in bytes.
const MAX_BYTES: usize = 1 << 20;
/// Longest time limit that can be set, in seconds.
const MAX_WAIT: f64 = 86_400.0;
/// Environment variables that the engine sets for programs; users cannot set them.
const RESERVED: [&str; 3] = ["TRACKFAIL_SEED", "TRACKFAIL_RUN", "TRAX"];

/// Schema of the file. All signals and detectors speak the same protocol. A signal has no seed, so that its
/// answers cannot depend on one.
static SCHEMA: LazyLock<Value> = LazyLock::new(|| {
    let mut program = schemars::schema_for!(Wired).to_value();
    remove(&mut program, &["description"]);
    remove_null(&mut program);
    let definitions = program["$defs"].take();
    let programs = |without: &[&str]| {
        let mut program = program.clone();
        remove(&mut program["properties"], without);
        json!({ "type": "object", "additionalProperties": program })
    };
    let roles = json!({
        "tracker": programs(&[]),
        "signal": programs(&["protocol", "regions", "confidence", "deterministic"]),
        "detector": programs(&["protocol", "regions", "confidence"]),
    });
    json!({ "type": "object", "properties": roles, "additionalProperties": false, "$defs": definitions })
});

/// A program as written in the file. A description of a key would stand in messages about it.
#[derive(Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
struct Wired {
    command: Vec<String>,
    version: String,
    #[serde(default)]
    protocol: Protocol,
    regions: Option<Regions>,
    confidence: Option<String>,
    #[schemars(extend("description" = "seconds"))]
    start_timeout: Option<f64>,
    #[schemars(extend("description" = "seconds"))]
    answer_timeout: Option<f64>,
    #[serde(default)]
    deterministic: bool,
    #[serde(default)]
    environment: BTreeMap<String, String>,
    #[serde(default)]
    digest: Vec<String>,
}

/// Reads a file of programs.
///
/// # Errors
/// A file that cannot be read, or the errors in it.
pub fn read(path: &Path) -> Result<Programs, SpecError> {
    let file = path.display().to_string();
    let text = read_at_most(path, MAX_BYTES, "a file of programs")?;
    let absolute = std::path::absolute(path).map_err(|e| SpecError::of_file(file.clone(), e.to_string()))?;
    parse(&file, &text, absolute.parent().unwrap_or(&absolute))
}

/// Parses a file of programs; `file` is its name in messages. Relative paths start from `folder`.
///
/// # Errors
/// All errors of the text.
pub fn parse(file: &str, text: &str, folder: &Path) -> Result<Programs, SpecError> {
    let files = [SourceFile::new(file, text)];
    let (source, errors) = (Source(&files), Errors::default());
    let document = DeTable::parse(&files[0].text).map_err(|e| files[0].toml(&e))?;
    let document = check::check(source, &SCHEMA, document, DeTable::new(), &errors);
    let at = At::new(source, &document, &errors);
    let mut list = Vec::new();
    let mut roles: BTreeMap<String, BTreeMap<String, Wired>> = at.read().unwrap_or_default();
    for role in [Role::Tracker, Role::Signal, Role::Detector] {
        for (name, wired) in roles.remove(role.word()).unwrap_or_default() {
            let at = at.key(role.word()).key(&name);
            list.push(Arc::new(program(at, role, name, wired, folder)));
        }
    }
    errors.or(Some(Programs { file: file.to_string(), list }))
}

/// Checks a program.
fn program(at: At<'_>, role: Role, name: String, wired: Wired, folder: &Path) -> Program {
    let check = |key: &str, is_right: bool, message: &str| {
        if !is_right {
            at.key(key).tell(message);
        }
    };
    if !is_word(&name) {
        at.tell(format!("the name {name:?} must have 1 to 64 characters of a-z, 0-9, `-` and `_`"));
    }
    let command = &wired.command;
    check(
        "command",
        command.first().is_some_and(|program| !program.is_empty()) && !command.concat().contains('\0'),
        "`command` must be a program and its arguments, such as [\"python3\", \"my_tracker.py\"]",
    );
    check(
        "version",
        (1..=64).contains(&wired.version.chars().count()) && wired.version.chars().all(text::is_plain),
        "`version` must have 1 to 64 characters, on one line",
    );
    check(
        "regions",
        wired.protocol != Protocol::Trax || wired.regions.is_none(),
        "`regions` goes with protocol = \"lines\"; a TraX program says itself what it reads",
    );
    let is_property =
        |name: &String| !name.is_empty() && name.chars().all(|c| c.is_ascii_graphic() && c != '=');
    check(
        "confidence",
        wired.confidence.as_ref().is_none_or(is_property),
        "`confidence` must be the name of a property, such as \"confidence\"",
    );
    for (key, value) in &wired.environment {
        let is_name = !key.is_empty() && !key.contains(['=', '\0']) && !RESERVED.contains(&key.as_str());
        if !is_name || value.contains('\0') {
            let message = format!("`{key}` cannot be set; {} are set already", RESERVED.join(", "));
            at.key("environment").key(key).tell(message);
        }
    }
    check("digest", wired.digest.iter().all(|path| !path.is_empty()), "`digest` must be names of files");
    Program {
        role,
        name,
        folder: folder.to_path_buf(),
        protocol: if role == Role::Tracker { wired.protocol } else { Protocol::Json },
        start_timeout: seconds(at, "start_timeout", wired.start_timeout),
        answer_timeout: seconds(at, "answer_timeout", wired.answer_timeout),
        regions: wired.regions.unwrap_or_default(),
        confidence: wired.confidence,
        deterministic: wired.deterministic || role == Role::Signal,
        environment: wired.environment,
        digest: wired.digest.iter().map(|path| folder.join(path)).collect(),
        command: wired.command,
        version: wired.version,
    }
}

fn seconds(at: At<'_>, key: &str, value: Option<f64>) -> Duration {
    let number = value.unwrap_or(30.0);
    if number > 0.0 && number <= MAX_WAIT {
        return Duration::from_secs_f64(number);
    }
    at.key(key).tell(format!("`{key}` must be above 0 and at most {MAX_WAIT} seconds, not {number}"));
    Duration::default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Programs, SpecError> {
        parse("plugins.toml", text, Path::new("/home/ann"))
    }

    const FULL: &str = r#"[tracker.my-tracker]
command = ["./bin/track", "--fast"]
protocol = "lines"
version = "1"
start_timeout = 2.5
answer_timeout = 0.5
regions = "polygon"
confidence = "score"
deterministic = true
environment = { OMP_NUM_THREADS = "1" }
digest = ["bin/track", "/models/a.bin"]

[tracker.other]
command = ["other"]
version = "2026-01"

[signal.other]
command = ["python3", "signal.py"]
version = "3"
answer_timeout = 1.5

[detector.other]
command = ["python3", "detector.py"]
version = "4"
deterministic = true
"#;

    #[test]
    fn programs_are_read_with_their_defaults() {
        let programs = read(FULL).unwrap();
        let mine = programs.find(Role::Tracker, "my-tracker").unwrap();
        assert_eq!(mine.command, ["./bin/track", "--fast"]);
        let speaks = (mine.protocol, mine.regions, mine.deterministic);
        assert_eq!(speaks, (Protocol::Lines, Regions::Polygon, true));
        assert_eq!(mine.confidence.as_deref(), Some("score"));
        assert_eq!(mine.digest, [Path::new("/home/ann/bin/track"), Path::new("/models/a.bin")]);
        assert_eq!((mine.start_timeout.as_millis(), mine.answer_timeout.as_millis()), (2500, 500));
        let other = programs.find(Role::Tracker, "other").unwrap();
        assert_eq!((other.protocol, other.deterministic), (Protocol::Trax, false));
        assert_eq!((other.start_timeout.as_secs(), other.answer_timeout.as_secs()), (30, 30));
        let of = |role| programs.find(role, "other").unwrap();
        assert_eq!([of(Role::Signal).version.as_str(), &of(Role::Detector).version], ["3", "4"]);
        assert_eq!([Role::Signal, Role::Detector].map(|role| of(role).protocol), [Protocol::Json; 2]);
        assert_eq!(of(Role::Signal).answer_timeout.as_millis(), 1500);
        assert!(programs.find(Role::Detector, "my-tracker").is_err());
        assert_eq!((programs.file.as_str(), read("").unwrap().list.len()), ("plugins.toml", 0));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (from, to, line, words) in [
            ("protocol =", "protokol =", 3, "did you mean `protocol`?"),
            ("\"lines\"", "\"line\"", 3, "did you mean `lines`?"),
            ("\"lines\"", "\"trax\"", 7, "goes with protocol = \"lines\""),
            ("\"polygon\"", "\"mask\"", 7, "unknown regions `mask`"),
            ("[\"./bin/track\", \"--fast\"]", "[]", 2, "a program and its arguments"),
            ("[\"./bin/track\", \"--fast\"]", "\"./bin/track --fast\"", 2, "`command` must be a list"),
            ("\"--fast\"", "\"a\\u0000\"", 2, "a program and its arguments"),
            ("version = \"1\"\n", "", 1, "`version` is missing"),
            ("version = \"1\"", "version = \"\"", 4, "1 to 64 characters"),
            ("version = \"1\"", "version = \"a\\nb\"", 4, "on one line"),
            ("2.5", "0", 5, "above 0 and at most 86400 seconds, not 0"),
            ("2.5", "-1.0", 5, "above 0"),
            ("2.5", "nan", 5, "`start_timeout` must be a number, not nan"),
            ("0.5", "inf", 6, "`answer_timeout` must be a number, not inf"),
            ("\"score\"", "\"\"", 8, "the name of a property"),
            ("\"score\"", "\"a b\"", 8, "the name of a property"),
            ("OMP_NUM_THREADS", "TRACKFAIL_SEED", 10, "are set already"),
            ("OMP_NUM_THREADS", "\"A=B\"", 10, "cannot be set"),
            ("\"bin/track\"", "\"\"", 11, "names of files"),
            ("[tracker.my-tracker]", "[tracker.\"My tracker\"]", 1, "a-z"),
            ("[tracker.other]", "[trackers.other]", 13, "did you mean `tracker`?"),
            ("answer_timeout = 1.5", "deterministic = true", 20, "unknown key `deterministic`"),
            ("version = \"4\"", "version = \"4\"\nregions = \"polygon\"", 25, "unknown key `regions`"),
            ("[signal.other]", "[signal.Other]", 17, "a-z"),
            ("[tracker.other]", "[tracker.my-tracker]", 13, "duplicate key"),
        ] {
            let error = read(&FULL.replacen(from, to, 1)).err().unwrap_or_else(|| panic!("{to}")).to_string();
            assert!(error.contains(words), "{to}: {error}");
            assert!(error.starts_with(&format!("plugins.toml:{line}: ")), "{to}: {error}");
        }
        let absent = super::read(Path::new("/no/such/plugins.toml")).unwrap_err().to_string();
        assert!(absent.starts_with("/no/such/plugins.toml:1: "), "{absent}");
    }

    proptest::proptest! {
        #[test]
        fn damaged_files_are_read_or_refused(bytes in trackfail_testing::damaged(FULL.as_bytes())) {
            let _ = parse("plugins.toml", &String::from_utf8_lossy(&bytes), Path::new("/"));
        }
    }
}
