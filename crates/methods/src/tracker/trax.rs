//! Messages of the TraX protocol, versions 1 to 4, between an evaluator (client) and a tracker (server) over
//! a pair of streams. Processes and time limits are in [`process`](super::process).
//!
//! ```text
//! @@TRAX:hello "trax.version=1" "trax.name=NCC" "trax.region=rectangle;" "trax.image=path;"
//! @@TRAX:initialize "file:///data/girl/0001.jpg" "10,20,30,40"
//! @@TRAX:state "10,20,30,40" "confidence=.9"
//! @@TRAX:frame "file:///data/girl/0002.jpg"
//! @@TRAX:quit "trax.reason=done"
//! ```
//!
//! A message is a line that starts with `@@TRAX:`; other lines are skipped. Arguments are separated by blanks
//! and may be quoted; a backslash makes `"`, `\` and blanks ordinary and `\n` a line end. An argument that
//! begins with a key (1 to 64 letters, digits, `.`, `_`) and `=` is a property; the others count by their
//! position. Types may be in capital or small letters; `status` is the same as `state`.
//!
//! Regions: `x,y,w,h`; corners `x1,y1,...` of a convex polygon; a single integer is a code of the VOT
//! protocol; masks are refused. Coordinates are not converted. Images: `file://` and a path without escapes,
//! or the path alone; one image per frame (version 2 can also send depth). Version 4 separates image and
//! region: `initialize` has only a region and is not answered; the `frame` after it has the image and is
//! answered. Only one object is supported here. [`server`] is the side of a tracker,
//! [`process`](super::process) that of the client.
//!
//! The other side can be any program, so the length of lines is limited and anything unexpected is an error that
//! ends the session, as the specification asks. Specification: <https://trax.readthedocs.io/en/latest/protocol.html>;
//! Cehovin, TraX: The visual Tracking eXchange protocol and library, Neurocomputing 260, 2017.

pub mod server;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use trackfail_core::region::Region;
use trackfail_dataset::text::shorten_to;

/// Longest message, in bytes.
pub const MAX_MESSAGE_BYTES: usize = 64 << 10;
/// Latest version that is supported.
pub const LATEST_VERSION: u32 = 4;

const PREFIX: &str = "@@TRAX:";
const SCHEME: &str = "file://";

/// Named arguments, sorted by name.
pub type Properties = BTreeMap<String, String>;

/// A message of the protocol.
#[derive(Debug, Clone, PartialEq)]
pub enum Message {
    /// From the server: its name and abilities.
    Hello(Hello),
    /// From the client: start (again) on this image with the target in this region.
    Initialize {
        /// Image file; `None` in version 4, where it comes with the next `frame`.
        image: Option<PathBuf>,
        /// Region of the target.
        region: Region,
        /// All named arguments.
        properties: Properties,
    },
    /// From the client: the next image.
    Frame {
        /// Image file.
        image: PathBuf,
        /// All named arguments.
        properties: Properties,
    },
    /// From the server: the answer to `initialize` or `frame`.
    TrackerState {
        /// Region of the target, or a code.
        answer: Answer,
        /// All named arguments, such as a confidence.
        properties: Properties,
    },
    /// From either side: the end of the session.
    Quit {
        /// All named arguments, such as `trax.reason`.
        properties: Properties,
    },
}

/// Name and abilities of a server.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hello {
    /// Version of the protocol, 1 to [`LATEST_VERSION`].
    pub version: u32,
    /// Kinds of images that it reads: `path`, `memory`, `data`, `url` ...; `path` by default.
    pub images: Vec<String>,
    /// Kinds of regions that it reads: `rectangle`, `polygon`, `mask` ...; `rectangle` by default.
    pub regions: Vec<String>,
    /// All other properties: `trax.name`, `trax.identifier` ...
    pub properties: Properties,
}

/// Answer of a tracker.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// Place of the target in the frame.
    Region(Region),
    /// A code without a place; its meaning depends on the tracker.
    Code(i64),
}

/// Reason why a message could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum TraxError {
    /// The stream failed.
    #[error("the stream of messages broke: {0}")]
    Io(#[from] std::io::Error),
    /// A message is longer than [`MAX_MESSAGE_BYTES`].
    #[error("a message of more than {MAX_MESSAGE_BYTES} bytes; none is that long")]
    TooLong,
    /// A message is not allowed here by the protocol, or its numbers are not a region.
    #[error("received {0}")]
    Unexpected(String),
    /// The protocol cannot express the message.
    #[error("cannot be said in TraX: {0}")]
    Unwritable(String),
}

impl TraxError {
    fn unexpected(received: &str, expected: &str) -> Self {
        Self::Unexpected(format!("`{}`; expected {expected}", shorten_to(received, 80)))
    }
}

/// The next message of a stream; `None` at its end. Lines that are not messages are skipped, whatever their length.
///
/// # Errors
/// See [`TraxError`]; the stream should not be read on after one.
pub fn read(stream: &mut impl BufRead) -> Result<Option<Message>, TraxError> {
    while let Some(line) = next_line(stream)? {
        if let Some(message) = parse(&line)? {
            return Ok(Some(message));
        }
    }
    Ok(None)
}

/// The next line without its end; of one that is no message, at most the longest message's bytes. A message that the
/// stream ends in is none.
fn next_line(stream: &mut impl BufRead) -> Result<Option<Vec<u8>>, TraxError> {
    let mut line = Vec::new();
    let mut any = false;
    loop {
        let bytes = match stream.fill_buf() {
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => continue,
            bytes => bytes?,
        };
        if bytes.is_empty() {
            return Ok((any && !line.starts_with(PREFIX.as_bytes())).then_some(line));
        }
        any = true;
        let end = bytes.iter().position(|&b| b == b'\n');
        let part = &bytes[..end.unwrap_or(bytes.len())];
        let room = MAX_MESSAGE_BYTES.saturating_sub(line.len());
        line.extend_from_slice(&part[..part.len().min(room)]);
        let too_long = part.len() > room && line.starts_with(PREFIX.as_bytes());
        let used = part.len() + usize::from(end.is_some());
        stream.consume(used);
        if too_long {
            return Err(TraxError::TooLong);
        }
        if end.is_some() {
            return Ok(Some(line));
        }
    }
}

/// The message on a line; `None` if the line is not a message.
///
/// # Errors
/// See [`TraxError`].
pub fn parse(line: &[u8]) -> Result<Option<Message>, TraxError> {
    let Some(rest) = line.strip_prefix(PREFIX.as_bytes()) else { return Ok(None) };
    if rest.len() > MAX_MESSAGE_BYTES {
        return Err(TraxError::TooLong);
    }
    let rest = std::str::from_utf8(rest)
        .map_err(|_| TraxError::unexpected(&String::from_utf8_lossy(rest), "UTF-8 text"))?;
    let rest = rest.strip_suffix('\n').unwrap_or(rest);
    let rest = rest.strip_suffix('\r').unwrap_or(rest);
    let (kind, rest) = rest.split_once(' ').unwrap_or((rest, ""));
    let wrong = |expected: &str| TraxError::unexpected(&format!("{PREFIX}{kind} {rest}"), expected);
    let (arguments, mut properties) = arguments(rest).map_err(wrong)?;
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let message = match (kind.to_ascii_lowercase().as_str(), arguments.as_slice()) {
        ("hello", []) => Message::Hello(hello(&mut properties)?),
        ("hello", _) => return Err(wrong("`hello` with named arguments alone")),
        ("initialize", [before @ .., place]) if before.len() <= 1 => match answer(place)? {
            Answer::Region(region) => {
                let image = before.first().map(|at| image(at)).transpose()?;
                Message::Initialize { image, region, properties }
            }
            Answer::Code(_) => return Err(wrong("a place to start from")),
        },
        ("initialize", _) => return Err(wrong("`initialize` with one region, before it one image or none")),
        ("frame", [at]) => Message::Frame { image: image(at)?, properties },
        ("frame", _) => return Err(wrong("`frame` with one image")),
        ("state" | "status", [place]) => Message::TrackerState { answer: answer(place)?, properties },
        ("state" | "status", _) => return Err(wrong("`state` with one region")),
        ("quit", []) => Message::Quit { properties },
        ("quit", _) => return Err(wrong("`quit` with named arguments alone")),
        _ => return Err(wrong("hello, initialize, frame, state or quit")),
    };
    Ok(Some(message))
}

/// Arguments by position and by name; the error is what was expected instead.
fn arguments(text: &str) -> Result<(Vec<String>, Properties), &'static str> {
    let (mut positional, mut properties) = (Vec::new(), Properties::new());
    let mut rest = text.chars();
    loop {
        let Some(first) = rest.by_ref().find(|c| *c != ' ') else { return Ok((positional, properties)) };
        let quoted = first == '"';
        let mut next = if quoted { rest.next() } else { Some(first) };
        // An escaped `=` ends no key.
        let (mut argument, mut key) = (String::new(), None);
        loop {
            match next {
                None if quoted => return Err("a closing quote"),
                None => break,
                Some('"') if quoted => match rest.next() {
                    None | Some(' ') => break,
                    Some(_) => return Err("a blank after a closing quote"),
                },
                Some(' ') if !quoted => break,
                Some('\0') => return Err("text without NUL"),
                Some('\\') => match rest.next() {
                    Some('n') => argument.push('\n'),
                    Some(c) => argument.push(c),
                    None => return Err("a character after `\\`"),
                },
                Some('=') if key.is_none() && is_key(&argument) => key = Some(std::mem::take(&mut argument)),
                Some(c) => argument.push(c),
            }
            next = rest.next();
        }
        match key {
            None => positional.push(argument),
            Some(key) => {
                if properties.insert(key, argument).is_some() {
                    return Err("every named argument once");
                }
            }
        }
    }
}

fn is_key(text: &str) -> bool {
    (1..=64).contains(&text.len())
        && text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'.' || b == b'_')
}

fn hello(properties: &mut Properties) -> Result<Hello, TraxError> {
    let version = properties.remove("trax.version").unwrap_or_else(|| "1".into());
    let number = version.parse().ok().filter(|v| (1..=LATEST_VERSION).contains(v)).ok_or_else(|| {
        let expected = format!("a version from 1 to {LATEST_VERSION}");
        TraxError::unexpected(&format!("trax.version={version}"), &expected)
    })?;
    let mut list = |name: &str, default: &str| {
        let text = properties.remove(name).unwrap_or_else(|| default.into());
        text.split(';').filter(|w| !w.is_empty()).map(str::to_ascii_lowercase).collect::<Vec<_>>()
    };
    let (images, regions) = (list("trax.image", "path"), list("trax.region", "rectangle"));
    Ok(Hello { version: number, images, regions, properties: std::mem::take(properties) })
}

fn image(text: &str) -> Result<PathBuf, TraxError> {
    let path = text.strip_prefix(SCHEME).unwrap_or(text);
    let other = ["http:", "https:", "ftp:", "data:", "image:"].iter().any(|s| path.starts_with(s));
    if path.is_empty() || other {
        return Err(TraxError::unexpected(text, "an image as file:// and its path"));
    }
    Ok(path.into())
}

fn answer(text: &str) -> Result<Answer, TraxError> {
    if text.starts_with('m') {
        return Err(TraxError::unexpected(text, "a rectangle or a polygon; masks are not read"));
    }
    if let Ok(code) = text.trim().parse() {
        return Ok(Answer::Code(code));
    }
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    let numbers = numbers.map_err(|_| TraxError::unexpected(text, "numbers separated by commas"))?;
    let fault = |e| TraxError::Unexpected(format!("the region `{}`: {e}", shorten_to(text, 80)));
    Region::from_numbers(&numbers).map(Answer::Region).map_err(fault)
}

/// A message as a line, with the line end.
///
/// # Errors
/// [`TraxError::Unwritable`] if a path is empty, not UTF-8 or has a NUL, a key is not valid, the version is
/// not supported, or the message is longer than [`MAX_MESSAGE_BYTES`].
pub fn write(message: &Message) -> Result<String, TraxError> {
    let (kind, arguments, properties) = match message {
        Message::Hello(Hello { version, images, regions, properties }) => {
            if !(1..=LATEST_VERSION).contains(version) {
                return Err(TraxError::Unwritable(format!("version {version}")));
            }
            let version = format!("trax.version={version}");
            let images = format!("trax.image={}", images.join(";"));
            let regions = format!("trax.region={}", regions.join(";"));
            ("hello", vec![version, images, regions], properties)
        }
        Message::Initialize { image, region, properties } => {
            let image = image.as_deref().map(image_argument).transpose()?;
            ("initialize", image.into_iter().chain([numbers(region)]).collect(), properties)
        }
        Message::Frame { image, properties } => ("frame", vec![image_argument(image)?], properties),
        Message::TrackerState { answer: Answer::Region(region), properties } => {
            ("state", vec![numbers(region)], properties)
        }
        Message::TrackerState { answer: Answer::Code(code), properties } => {
            ("state", vec![code.to_string()], properties)
        }
        Message::Quit { properties } => ("quit", Vec::new(), properties),
    };
    let mut line = format!("{PREFIX}{kind}");
    for argument in arguments {
        push_quoted(&mut line, &argument)?;
    }
    for (key, value) in properties {
        if !is_key(key) {
            let key = shorten_to(key, 80);
            let rule = "a key has 1 to 64 letters, digits, `.` or `_`";
            return Err(TraxError::Unwritable(format!("the key `{key}`; {rule}")));
        }
        push_quoted(&mut line, &format!("{key}={value}"))?;
    }
    if line.len() > MAX_MESSAGE_BYTES {
        return Err(TraxError::Unwritable(format!("a message of more than {MAX_MESSAGE_BYTES} bytes")));
    }
    line.push('\n');
    Ok(line)
}

/// The numbers of a region, between commas.
pub(super) fn numbers(region: &Region) -> String {
    region.numbers().iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

fn image_argument(path: &Path) -> Result<String, TraxError> {
    let text = path.to_str().filter(|t| !t.is_empty()).ok_or_else(|| {
        TraxError::Unwritable(format!("the path {}, which is empty or not UTF-8", path.display()))
    })?;
    Ok(format!("{SCHEME}{text}"))
}

fn push_quoted(line: &mut String, text: &str) -> Result<(), TraxError> {
    if text.contains('\0') {
        return Err(TraxError::Unwritable("a text with a NUL".into()));
    }
    let escaped = text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
    write!(line, " \"{escaped}\"").map_err(|e| TraxError::Unwritable(e.to_string()))
}

#[cfg(test)]
mod tests;
