//! The client's side of the two protocols of trackers, TraX and lines.

use super::child::Child;
use super::programs::{Program, Protocol, Regions};
use crate::tracker::TrackerState;
use crate::tracker::trax::{self, Answer, Hello, Message, Properties};
use std::io::{BufRead, Read};
use std::path::Path;
use std::process::Command;
use trackfail_core::region::Region;
use trackfail_dataset::text::{shorten_to, visible};

/// A running program. It cannot be used after an error. A state has a confidence only if `plugins.toml` says so.
pub trait Peer: Send {
    /// Starts tracking on an image.
    fn init(&mut self, image: &Path, region: &Region) -> Result<TrackerState, String>;

    /// Tracks the target in the next image.
    fn frame(&mut self, image: &Path) -> Result<TrackerState, String>;

    /// Asks the program to quit after its last answer.
    ///
    /// # Errors
    /// When the program answers once more, or ends with an exit status other than 0.
    fn finish(&mut self) -> Result<(), String>;
}

/// Command that starts a program in its folder and with its environment.
pub(super) fn command(program: &Program) -> Result<Command, String> {
    let Some((name, arguments)) = program.command.split_first() else {
        return Err("no command".into());
    };
    // A bare name is looked up on the PATH, all others are relative to the folder.
    let is_bare = Path::new(name).components().count() == 1 && !name.contains('/');
    let mut command = match is_bare {
        true => Command::new(name),
        false => Command::new(program.folder.join(name)),
    };
    command.args(arguments).current_dir(&program.folder).envs(&program.environment);
    Ok(command)
}

/// Starts a program; `folder` is deleted when our own process dies.
pub fn start(program: &Program, seed: u64, run: u32, folder: &Path) -> Result<Box<dyn Peer>, String> {
    let mut command = command(program)?;
    command.env("TRACKFAIL_SEED", seed.to_string()).env("TRACKFAIL_RUN", run.to_string());
    match program.protocol {
        Protocol::Lines => {
            let limits = (program.start_timeout + program.answer_timeout, program.answer_timeout);
            let child = Child::start(command, Some(folder), limits, Some("quit\n"), read_line)?;
            let (regions, gives_confidence) = (program.regions, program.confidence.is_some());
            Ok(Box::new(Lines { child, regions, gives_confidence, asked: 0 }))
        }
        Protocol::Json => Err("it is no tracker, but a signal or a detector".into()),
        Protocol::Trax => {
            command.env("TRAX", "1");
            Trax::start(command, folder, program).map(|trax| Box::new(trax) as Box<dyn Peer>)
        }
    }
}

/// The region in the form that the program reads.
fn as_sent(region: &Region, regions: Regions) -> Region {
    match regions {
        Regions::Rectangle => Region::Rect(region.rect()),
        Regions::Polygon => Region::Polygon(region.corners()),
    }
}

/// Longest answer in the lines protocol, in bytes.
const MAX_LINE_BYTES: u64 = 16 << 10;

/// The next line without its end; `None` at the end of the stream.
pub(super) fn read_line(stream: &mut impl BufRead) -> Option<Result<String, String>> {
    let mut bytes = Vec::new();
    match stream.take(MAX_LINE_BYTES).read_until(b'\n', &mut bytes) {
        Err(e) => return Some(Err(format!("its stdout broke: {e}"))),
        Ok(0) => return None,
        Ok(n) if n as u64 == MAX_LINE_BYTES => {
            return Some(Err(format!("received a line of {MAX_LINE_BYTES} bytes and more")));
        }
        // The rest of it is lost, and part of a number may be a number, too.
        Ok(_) if !bytes.ends_with(b"\n") => {
            let text = received(&String::from_utf8_lossy(&bytes));
            return Some(Err(format!("{text} without a line end")));
        }
        Ok(_) => {}
    }
    let not_text = |e: std::string::FromUtf8Error| received(&String::from_utf8_lossy(e.as_bytes()));
    Some(String::from_utf8(bytes).map(|line| line.trim_end().to_string()).map_err(not_text))
}

pub(super) fn received(text: &str) -> String {
    format!("received `{}`", visible(&shorten_to(text.trim_end(), 80)))
}

struct Lines {
    child: Child<String>,
    regions: Regions,
    gives_confidence: bool,
    /// Number of messages that have been answered.
    asked: u64,
}

/// Form of the expected answer, for messages.
const LINE: &str = "`x,y,w,h` or corners `x1,y1,x2,y2,x3,y3,...`, and nothing but a confidence and `#N`, the message's number, behind";

impl Lines {
    fn ask(&mut self, line: String) -> Result<TrackerState, String> {
        let number = self.asked;
        self.asked += 1;
        let mut state = self.child.ask(line, LINE, |answer| parse_answer(answer, number))?;
        state.confidence = state.confidence.filter(|_| self.gives_confidence);
        Ok(state)
    }
}

/// Region and confidence in the answer to message number `message`; the error says why it is not an answer.
fn parse_answer(line: &str, message: u64) -> Result<TrackerState, String> {
    let mut words: Vec<&str> = line.split_whitespace().collect();
    if let Some(word) = words.pop_if(|word| word.starts_with('#')) {
        check_number(word.trim_start_matches('#'), message)?;
    }
    let (region, confidence) = match words.as_slice() {
        [] => return Err("an empty line".into()),
        [region] => (region, None),
        [region, word] => (region, Some(confidence(word)?)),
        _ => return Err("more than a region and a confidence".into()),
    };
    let numbers = region.split(',').map(number).collect::<Result<Vec<f64>, _>>()?;
    let region = Region::from_numbers(&numbers).map_err(|e| e.to_string())?;
    Ok(TrackerState { confidence, ..TrackerState::tracked(region) })
}

/// Checks that `word` is the number of this message.
fn check_number(word: &str, message: u64) -> Result<(), String> {
    match word.parse::<u64>() {
        Ok(number) if number == message => Ok(()),
        Ok(number) => Err(format!("the answer to message {number}, but {message} was asked")),
        Err(_) => Err(format!("`#{}` is no number of a message", visible(&shorten_to(word, 40)))),
    }
}

/// A word as a number; the error says why it is not one.
fn number(word: &str) -> Result<f64, String> {
    word.parse::<f64>().map_err(|_| format!("`{}` is no number", visible(&shorten_to(word, 40))))
}

/// A word as a confidence; the error says why it is not one.
fn confidence(word: &str) -> Result<f64, String> {
    let finite = number(word)?;
    if finite.is_finite() { Ok(finite) } else { Err("the confidence is not a finite number".into()) }
}

impl Peer for Lines {
    fn init(&mut self, image: &Path, region: &Region) -> Result<TrackerState, String> {
        let region = trax::numbers(&as_sent(region, self.regions));
        self.ask(format!("init\t{}\t{region}\n", image.display()))
    }

    fn frame(&mut self, image: &Path) -> Result<TrackerState, String> {
        self.ask(format!("frame\t{}\n", image.display()))
    }

    fn finish(&mut self) -> Result<(), String> {
        self.child.finish(|_| true)
    }
}

struct Trax {
    child: Child<Message>,
    hello: Hello,
    /// Name of the TraX property with the confidence; `None` if the program gives none.
    confidence: Option<String>,
    last: Option<Region>,
}

impl Trax {
    fn start(command: Command, folder: &Path, program: &Program) -> Result<Self, String> {
        let read = |stream: &mut _| trax::read(stream).map_err(|e| e.to_string()).transpose();
        let limits = (program.start_timeout, program.answer_timeout);
        let mut child = Child::start(command, Some(folder), limits, Some("@@TRAX:quit\n"), read)?;
        let expected = "`hello` of a TraX tracker, version 1 to 4";
        let hello = match child.receive(expected)? {
            Message::Hello(hello) => hello,
            other => return Err(child.fault(format!("{}; expected {expected}", in_words(&other)))),
        };
        let knows = |list: &[String], word: &str| list.iter().any(|w| w == word);
        if !knows(&hello.images, "path") {
            let images = listed(&hello.images.join(", "));
            let message = format!("it reads images as {images}; expected `path` among them");
            return Err(child.fault(message));
        }
        if !knows(&hello.regions, "rectangle") && !knows(&hello.regions, "polygon") {
            let regions = listed(&hello.regions.join(", "));
            let message = format!("it reads regions as {regions}; expected rectangle or polygon");
            return Err(child.fault(message));
        }
        let channels = hello.properties.get("trax.channels").map_or("", String::as_str);
        if channels.split(';').any(|channel| !channel.is_empty() && !channel.eq_ignore_ascii_case("color")) {
            let message = format!("it needs the image channels {}; expected `color` alone", listed(channels));
            return Err(child.fault(message));
        }
        let confidence = program.confidence.clone();
        Ok(Self { child, hello, confidence, last: None })
    }

    fn send(&mut self, message: &Message) -> Result<(), String> {
        let line = trax::write(message).map_err(|e| self.child.fault(e.to_string()))?;
        self.child.send(line, |early| matches!(early, Message::Quit { .. }).then(|| in_words(early)))
    }

    fn receive(&mut self) -> Result<TrackerState, String> {
        let expected = "`state` with a rectangle or polygon";
        let (answer, properties) = match self.child.receive(expected)? {
            Message::TrackerState { answer, properties } => (answer, properties),
            other => return Err(self.child.fault(format!("{}; expected {expected}", in_words(&other)))),
        };
        let region = match (answer, &self.last) {
            (Answer::Region(region), _) => region,
            // A code has no region.
            (Answer::Code(_), Some(last)) => last.clone(),
            (Answer::Code(code), None) => {
                return Err(self.child.fault(format!("received the code {code}; expected {expected}")));
            }
        };
        self.last = Some(region.clone());
        let given = self.confidence.as_ref().and_then(|name| Some((name, properties.get(name)?)));
        let confidence = given.map(|(name, word)| {
            confidence(word.trim()).map_err(|why| format!("its property {}: {why}", listed(name)))
        });
        let confidence = confidence.transpose().map_err(|why| self.child.fault(why))?;
        Ok(TrackerState { confidence, ..TrackerState::tracked(region) })
    }
}

/// Words of the program, quoted for messages.
fn listed(words: &str) -> String {
    format!("`{}`", visible(&shorten_to(words, 80)))
}

/// Describes a message that was not expected.
fn in_words(message: &Message) -> String {
    match message {
        Message::Quit { properties } => match properties.get("trax.reason") {
            Some(reason) if !reason.is_empty() => {
                format!("it quit: {}", visible(&shorten_to(reason, 200)))
            }
            _ => "it quit".into(),
        },
        other => match trax::write(other) {
            Ok(line) => received(&line),
            Err(e) => e.to_string(),
        },
    }
}

impl Peer for Trax {
    fn init(&mut self, image: &Path, region: &Region) -> Result<TrackerState, String> {
        let reads = |word: &str| self.hello.regions.iter().any(|w| w == word);
        let polygon = matches!(region, Region::Polygon(_)) && reads("polygon") || !reads("rectangle");
        let sent = as_sent(region, if polygon { Regions::Polygon } else { Regions::Rectangle });
        self.last = Some(sent.clone());
        let (image, properties) = (image.to_path_buf(), Properties::new());
        if self.hello.version < 4 {
            self.send(&Message::Initialize { image: Some(image), region: sent, properties })?;
        } else {
            let initialize =
                Message::Initialize { image: None, region: sent, properties: properties.clone() };
            self.send(&initialize)?;
            self.send(&Message::Frame { image, properties })?;
        }
        self.receive()
    }

    fn frame(&mut self, image: &Path) -> Result<TrackerState, String> {
        self.send(&Message::Frame { image: image.to_path_buf(), properties: Properties::new() })?;
        self.receive()
    }

    fn finish(&mut self) -> Result<(), String> {
        // Some confirm the end by the same message.
        self.child.finish(|message| !matches!(message, Message::Quit { .. }))
    }
}
