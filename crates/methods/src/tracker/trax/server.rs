//! The server's side of TraX: serves a built-in tracker to any TraX client, in versions 1 to 3, with one target,
//! images by path, rectangles and polygons.
//!
//! Every `initialize` starts the tracker anew. A state has the property `confidence` if the tracker's
//! posterior has a likelihood. An error ends the session: `quit` is sent with the error as `trax.reason`.

use super::{Answer, Hello, Message, Properties, TraxError, numbers, read, write};
use crate::tracker::{RunContext, Tracker, TrackerConfig, TrackerError, TrackerState};
use std::io::{BufRead, Write};
use std::path::Path;
use trackfail_core::region::{Rect, Region};
use trackfail_dataset::files::of_size;
use trackfail_dataset::text::{shorten_to, visible};
use trackfail_dataset::user_frames::without_frames;
use trackfail_dataset::{DatasetError, Frames, Sequence};

/// Version that the server announces.
const VERSION: u32 = 3;

/// Reason why a session ended early.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The client violates the protocol.
    #[error(transparent)]
    Talk(#[from] TraxError),
    /// An image cannot be read.
    #[error(transparent)]
    Image(#[from] DatasetError),
    /// The target is outside of the image in which it is given.
    #[error("the region {0}")]
    Outside(String),
    /// The tracker failed.
    #[error(transparent)]
    Tracker(#[from] TrackerError),
}

/// A tracker to serve.
pub struct Server<'a> {
    /// Kind of the tracker.
    pub name: &'a str,
    /// Description of the tracker, on one line.
    pub description: &'a str,
    /// Configuration of the tracker.
    pub config: &'a dyn TrackerConfig,
    /// Seed that every start uses.
    pub seed: u64,
}

impl Server<'_> {
    /// Answers messages until the client quits or closes the stream.
    ///
    /// # Errors
    /// See [`SessionError`]. The client has got the error as the reason of `quit`.
    pub fn serve(&self, input: impl BufRead, mut output: impl Write) -> Result<(), SessionError> {
        let outcome = self.talk(input, &mut output);
        if let Err(e) = &outcome {
            let reason = visible(&shorten_to(&e.to_string(), 1000));
            let properties = [("trax.reason".to_string(), reason)].into();
            // If the client's pipe is closed, the reason cannot be sent either.
            let _ = say(&mut output, &Message::Quit { properties });
        }
        outcome
    }

    fn talk(&self, mut input: impl BufRead, output: &mut impl Write) -> Result<(), SessionError> {
        let named = |pairs: [(&str, &str); 5]| pairs.map(|(k, v)| (k.to_string(), v.to_string())).into();
        let hello = Hello {
            version: VERSION,
            images: vec!["path".into()],
            regions: vec!["rectangle".into(), "polygon".into()],
            properties: named([
                ("trax.name", self.name),
                ("trax.identifier", self.name),
                ("trax.description", self.description),
                ("trax.family", "trackfail"),
                // Without it, libtrax assumes all channels that it knows.
                ("trax.channels", "color"),
            ]),
        };
        say(output, &Message::Hello(hello))?;
        let mut tracker: Option<Session> = None;
        loop {
            let state = match (read(&mut input)?, &mut tracker) {
                (None | Some(Message::Quit { .. }), _) => return Ok(()),
                (Some(Message::Initialize { image: Some(image), region, .. }), _) => {
                    let (started, state) = self.start(&image, &region)?;
                    tracker = Some(started);
                    state
                }
                (Some(Message::Frame { image, .. }), Some(session)) => session.update(&image)?,
                (Some(Message::Frame { .. }), None) => return Err(unexpected("frame", "`initialize` first")),
                (Some(Message::Initialize { image: None, .. }), _) => {
                    return Err(unexpected("initialize", "an image and a region, as in version 3"));
                }
                (Some(Message::Hello(_)), _) => return Err(unexpected("hello", "a client's message")),
                (Some(Message::TrackerState { .. }), _) => {
                    return Err(unexpected("state", "a client's message"));
                }
            };
            say(output, &as_message(state))?;
        }
    }

    fn start(&self, image: &Path, region: &Region) -> Result<(Session, TrackerState), SessionError> {
        let sequence = sequence(image, Some(region.clone()));
        let frame = sequence.frame(0)?;
        let size @ (width, height) = (frame.width(), frame.height());
        if region.clipped(&Region::Rect(Rect::new(0.0, 0.0, width as f64, height as f64))).is_none() {
            let image = format!("the image of {width}x{height} pixels {}", image.display());
            return Err(SessionError::Outside(format!("{} lies outside of {image}", numbers(region))));
        }
        let context =
            RunContext { sequence: &sequence, start_frame: 0, run: 0, seed: self.seed, data_roots: &[] };
        let (tracker, state) = self.config.start(&context, &frame, region)?;
        Ok((Session { tracker, size }, state))
    }
}

/// A tracker since its start.
struct Session {
    tracker: Box<dyn Tracker>,
    /// Width and height of the first image.
    size: (usize, usize),
}

impl Session {
    fn update(&mut self, image: &Path) -> Result<TrackerState, SessionError> {
        let frame = of_size(sequence(image, None).frame(0)?, self.size, image)?;
        Ok(self.tracker.update(&frame)?)
    }
}

fn unexpected(kind: &str, expected: &str) -> SessionError {
    TraxError::unexpected(&format!("@@TRAX:{kind}"), expected).into()
}

fn say(output: &mut impl Write, message: &Message) -> Result<(), TraxError> {
    output.write_all(write(message)?.as_bytes())?;
    Ok(output.flush()?)
}

fn as_message(state: TrackerState) -> Message {
    let confidence = state.confidence_or_likelihood();
    let confidence = confidence.map(|c| ("confidence".to_string(), c.to_string()));
    Message::TrackerState {
        answer: Answer::Region(state.region),
        properties: confidence.into_iter().collect::<Properties>(),
    }
}

/// A sequence of one image.
fn sequence(image: &Path, region: Option<Region>) -> Sequence {
    let frames = Frames::Files(vec![image.to_path_buf()]);
    Sequence { truth: vec![region], frames, ..without_frames("trax", 1) }
}
