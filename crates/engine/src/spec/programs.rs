//! `plugins.toml`: programs that may be run as [trackers](trackfail_methods::tracker::process), [signals](trackfail_methods::signal::process) and
//! [detectors](trackfail_methods::detector::process). It is as strict as experiment files: an unknown key is an error with its line and the nearest valid word.

use super::error::{Source, SpecError};
use super::name::is_word;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};
use trackfail_dataset::{DatasetError, text};
use trackfail_methods::tracker::process::{Program, Programs, Protocol, Regions, Role};

/// Largest file, in bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Longest time limit, in seconds.
const MAX_WAIT: f64 = 86_400.0;
/// Environment variables that are set for the programs.
const RESERVED: [&str; 3] = ["TRACKFAIL_SEED", "TRACKFAIL_RUN", "TRAX"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wire {
    #[serde(default)]
    tracker: BTreeMap<String, Spanned<Wired>>,
    #[serde(default)]
    signal: BTreeMap<String, Spanned<WiredSignal>>,
    #[serde(default)]
    detector: BTreeMap<String, Spanned<WiredDetector>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WiredSignal {
    command: Spanned<Vec<String>>,
    version: Spanned<String>,
    start_timeout: Option<Spanned<f64>>,
    answer_timeout: Option<Spanned<f64>>,
    #[serde(default)]
    environment: BTreeMap<String, Spanned<String>>,
    #[serde(default)]
    digest: Vec<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WiredDetector {
    command: Spanned<Vec<String>>,
    version: Spanned<String>,
    start_timeout: Option<Spanned<f64>>,
    answer_timeout: Option<Spanned<f64>>,
    #[serde(default)]
    deterministic: bool,
    #[serde(default)]
    environment: BTreeMap<String, Spanned<String>>,
    #[serde(default)]
    digest: Vec<Spanned<String>>,
}

/// A signal has no seed, so that its answers cannot depend on one.
impl From<WiredSignal> for Wired {
    fn from(signal: WiredSignal) -> Self {
        let WiredSignal { command, version, start_timeout, answer_timeout, environment, digest } = signal;
        let detector = WiredDetector {
            command,
            version,
            start_timeout,
            answer_timeout,
            deterministic: true,
            environment,
            digest,
        };
        detector.into()
    }
}

impl From<WiredDetector> for Wired {
    fn from(detector: WiredDetector) -> Self {
        let WiredDetector {
            command,
            version,
            start_timeout,
            answer_timeout,
            deterministic,
            environment,
            digest,
        } = detector;
        let (protocol, regions, confidence) = (Protocol::Json, None, None);
        Self {
            command,
            version,
            protocol,
            regions,
            confidence,
            start_timeout,
            answer_timeout,
            deterministic,
            environment,
            digest,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wired {
    command: Spanned<Vec<String>>,
    version: Spanned<String>,
    #[serde(default)]
    protocol: Protocol,
    regions: Option<Spanned<Regions>>,
    confidence: Option<Spanned<String>>,
    start_timeout: Option<Spanned<f64>>,
    answer_timeout: Option<Spanned<f64>>,
    #[serde(default)]
    deterministic: bool,
    #[serde(default)]
    environment: BTreeMap<String, Spanned<String>>,
    #[serde(default)]
    digest: Vec<Spanned<String>>,
}

/// Reads a file of programs.
///
/// # Errors
/// A file that cannot be read, and the first thing that is wrong with it.
pub fn read(path: &Path) -> Result<Programs, SpecError> {
    let file = path.display().to_string();
    let whole = |message: String| SpecError::of_file(file.clone(), message);
    let bytes = text::read_at_most(path, MAX_BYTES).map_err(|e| match e {
        DatasetError::Io { source, .. } => whole(source.to_string()),
        DatasetError::Content { message, .. } => whole(message),
        e => whole(e.to_string()),
    })?;
    let text = String::from_utf8(bytes).map_err(|_| whole("bytes that are not UTF-8 text".into()))?;
    let absolute = std::path::absolute(path).map_err(|e| whole(e.to_string()))?;
    parse(&file, &text, absolute.parent().unwrap_or(&absolute))
}

/// Reads the text of a file of programs; `file` names it in messages, relative paths start from `folder`.
///
/// # Errors
/// The first thing that is wrong.
pub fn parse(file: &str, text: &str, folder: &Path) -> Result<Programs, SpecError> {
    let source = Source::new(file, text);
    let document = DeTable::parse(text).map_err(|e| source.toml(&e, 0..0))?;
    let whole = Spanned::new(document.span(), DeValue::Table(document.into_inner()));
    let wire = Wire::deserialize(ValueDeserializer::from(whole)).map_err(|e| source.toml(&e, 0..0))?;
    let trackers = wire.tracker.into_iter().map(|(name, wired)| (Role::Tracker, name, wired));
    let signals = wire.signal.into_iter().map(|(name, wired)| (Role::Signal, name, as_tracker(wired)));
    let detectors = wire.detector.into_iter().map(|(name, wired)| (Role::Detector, name, as_tracker(wired)));
    let all = trackers.chain(signals).chain(detectors);
    let all = all.map(|(role, name, wired)| check(source, role, name, wired, folder).map(Arc::new));
    Ok(Programs { file: file.to_string(), list: all.collect::<Result<_, _>>()? })
}

fn as_tracker<T: Into<Wired>>(wired: Spanned<T>) -> Spanned<Wired> {
    Spanned::new(wired.span(), wired.into_inner().into())
}

fn check(
    source: Source<'_>,
    role: Role,
    name: String,
    wired: Spanned<Wired>,
    folder: &Path,
) -> Result<Program, SpecError> {
    let (span, wired) = (wired.span(), wired.into_inner());
    if !is_word(&name) {
        let message = format!("the name {name:?} must have 1 to 64 characters of a-z, 0-9, `-` and `_`");
        return Err(source.error(span, message));
    }
    let command = wired.command.get_ref();
    if command.first().is_none_or(String::is_empty) || command.iter().any(|word| word.contains('\0')) {
        let message =
            "`command` must be a program and its arguments, such as [\"python3\", \"my_tracker.py\"]";
        return Err(source.error(wired.command.span(), message));
    }
    let version = wired.version.get_ref();
    if !(1..=64).contains(&version.chars().count()) || !version.chars().all(text::is_plain) {
        let message = "`version` must have 1 to 64 characters, on one line";
        return Err(source.error(wired.version.span(), message));
    }
    if let (Protocol::Trax, Some(regions)) = (wired.protocol, &wired.regions) {
        let message = "`regions` goes with protocol = \"lines\"; a TraX program says itself what it reads";
        return Err(source.error(regions.span(), message));
    }
    if let Some(name) = &wired.confidence
        && (name.get_ref().is_empty() || !name.get_ref().chars().all(|c| c.is_ascii_graphic() && c != '='))
    {
        let message = "`confidence` must be the name of a property, such as \"confidence\"";
        return Err(source.error(name.span(), message));
    }
    for (key, value) in &wired.environment {
        let is_name = !key.is_empty() && !key.contains(['=', '\0']) && !RESERVED.contains(&key.as_str());
        if !is_name || value.get_ref().contains('\0') {
            let message = format!("`{key}` cannot be set; {} are set already", RESERVED.join(", "));
            return Err(source.error(value.span(), message));
        }
    }
    if let Some(empty) = wired.digest.iter().find(|path| path.get_ref().is_empty()) {
        return Err(source.error(empty.span(), "`digest` must be names of files"));
    }
    Ok(Program {
        role,
        name,
        folder: folder.to_path_buf(),
        protocol: wired.protocol,
        start_timeout: seconds(source, "start_timeout", wired.start_timeout)?,
        answer_timeout: seconds(source, "answer_timeout", wired.answer_timeout)?,
        regions: wired.regions.map(Spanned::into_inner).unwrap_or_default(),
        confidence: wired.confidence.map(Spanned::into_inner),
        deterministic: wired.deterministic,
        environment: wired.environment.into_iter().map(|(k, v)| (k, v.into_inner())).collect(),
        digest: wired.digest.iter().map(|path| folder.join(path.get_ref())).collect(),
        command: wired.command.into_inner(),
        version: wired.version.into_inner(),
    })
}

fn seconds(source: Source<'_>, key: &str, value: Option<Spanned<f64>>) -> Result<Duration, SpecError> {
    let Some(value) = value else { return Ok(Duration::from_secs(30)) };
    let number = *value.get_ref();
    if !(number > 0.0 && number <= MAX_WAIT) {
        let message = format!("`{key}` must be above 0 and at most {MAX_WAIT} seconds, not {number}");
        return Err(source.error(value.span(), message));
    }
    Ok(Duration::from_secs_f64(number))
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
        assert_eq!(
            (mine.protocol, mine.regions, mine.deterministic),
            (Protocol::Lines, Regions::Polygon, true)
        );
        assert_eq!(mine.confidence.as_deref(), Some("score"));
        assert_eq!(mine.digest, [Path::new("/home/ann/bin/track"), Path::new("/models/a.bin")]);
        assert_eq!((mine.start_timeout.as_millis(), mine.answer_timeout.as_millis()), (2500, 500));
        let other = programs.find(Role::Tracker, "other").unwrap();
        assert_eq!((other.protocol, other.deterministic), (Protocol::Trax, false));
        assert_eq!((other.start_timeout.as_secs(), other.answer_timeout.as_secs()), (30, 30));
        let of = |role| programs.find(role, "other").unwrap();
        assert_eq!([of(Role::Signal).version.as_str(), &of(Role::Detector).version], ["3", "4"]);
        assert_eq!(
            (of(Role::Signal).protocol, of(Role::Detector).protocol),
            (Protocol::Json, Protocol::Json)
        );
        assert_eq!(of(Role::Signal).answer_timeout.as_millis(), 1500);
        assert!(programs.find(Role::Detector, "my-tracker").is_err());
        let unknown = programs.find(Role::Tracker, "my-traker").unwrap_err().to_string();
        assert_eq!(unknown, "plugins.toml: unknown program `my-traker`; did you mean `my-tracker`?");
        assert!(
            read("")
                .unwrap()
                .find(Role::Signal, "x")
                .unwrap_err()
                .to_string()
                .contains("plugins.toml names no signal")
        );
        assert!(
            Programs::default()
                .find(Role::Tracker, "x")
                .unwrap_err()
                .to_string()
                .contains("there is no plugins.toml here")
        );
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (from, to, line, words) in [
            ("protocol =", "protokol =", 3, "unknown field `protokol`"),
            ("protocol =", "protokol =", 3, "did you mean `protocol`?"),
            ("\"lines\"", "\"line\"", 3, "did you mean `lines`?"),
            ("\"lines\"", "\"trax\"", 7, "goes with protocol = \"lines\""),
            ("\"polygon\"", "\"mask\"", 7, "unknown variant `mask`"),
            ("[\"./bin/track\", \"--fast\"]", "[]", 2, "a program and its arguments"),
            ("[\"./bin/track\", \"--fast\"]", "\"./bin/track --fast\"", 2, "`command` must be a list"),
            ("\"--fast\"", "\"a\\u0000\"", 2, "a program and its arguments"),
            ("version = \"1\"\n", "", 1, "missing field `version`"),
            ("version = \"1\"", "version = \"\"", 4, "1 to 64 characters"),
            ("version = \"1\"", "version = \"a\\nb\"", 4, "on one line"),
            ("2.5", "0", 5, "above 0 and at most 86400 seconds, not 0"),
            ("2.5", "-1.0", 5, "above 0"),
            ("2.5", "nan", 5, "above 0"),
            ("0.5", "inf", 6, "above 0"),
            ("\"score\"", "\"\"", 8, "the name of a property"),
            ("\"score\"", "\"a b\"", 8, "the name of a property"),
            ("OMP_NUM_THREADS", "TRACKFAIL_SEED", 10, "are set already"),
            ("OMP_NUM_THREADS", "\"A=B\"", 10, "cannot be set"),
            ("\"bin/track\"", "\"\"", 11, "names of files"),
            ("[tracker.my-tracker]", "[tracker.\"My tracker\"]", 1, "a-z"),
            ("[tracker.other]", "[trackers.other]", 13, "did you mean `tracker`?"),
            ("answer_timeout = 1.5", "deterministic = true", 20, "unknown field `deterministic`"),
            ("version = \"4\"", "version = \"4\"\nregions = \"polygon\"", 25, "unknown field `regions`"),
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
