//! Standard input and output of a stream, and the signals that end it.
//!
//! One thread reads a line when it is asked for one, and another writes an answer; the program waits for either. So
//! nothing piles up when nobody reads the answers, and a signal is obeyed at once wherever the stream is stuck.

use super::line::MAX_LINE;
use crate::cli::Failure;
use crate::dataset::text;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::sync::mpsc::{Receiver, Sender, channel};

/// Why a stream ends.
pub(super) enum End {
    /// The input has ended, or nobody reads the answers any more.
    Done,
    /// Ctrl-C, or the system ends the program.
    Stopped,
    /// Reading, writing or keeping the state failed.
    Failed(Failure),
}

/// Something that was waited for.
enum Event {
    /// The next line; `None` at the end of the input.
    Line(io::Result<Option<Vec<u8>>>),
    /// The answer is written.
    Written(io::Result<()>),
    /// A signal.
    Stop,
}

/// The stream's ends.
pub(super) struct Pipes {
    events: Receiver<Event>,
    requests: Sender<()>,
    answers: Sender<String>,
}

impl Pipes {
    /// Standard input and output, and the handler of signals.
    pub fn open() -> Self {
        // A send fails only when the other end is gone, and with it the stream.
        let (sender, events) = channel();
        let (requests, requested) = channel();
        let (answers, answered) = channel::<String>();
        let stop = sender.clone();
        // Without a handler a signal ends the program, and its state is the last one that was written.
        let _ = ctrlc::set_handler(move || drop(stop.send(Event::Stop)));
        let lines = sender.clone();
        std::thread::spawn(move || {
            let mut input = BufReader::with_capacity(1 << 18, io::stdin().lock());
            let mut is_first = true;
            for () in requested {
                let line = read_line(&mut input);
                let line = if is_first { line.map(|line| line.map(without_mark)) } else { line };
                is_first = false;
                let _ = lines.send(Event::Line(line));
            }
        });
        std::thread::spawn(move || {
            let mut output = io::stdout().lock();
            for answer in answered {
                let written = output.write_all(answer.as_bytes()).and_then(|()| output.flush());
                let _ = sender.send(Event::Written(written));
            }
        });
        Self { events, requests, answers }
    }

    /// The next line, without its end.
    pub fn next_line(&self) -> Result<Vec<u8>, End> {
        let _ = self.requests.send(());
        match self.events.recv() {
            Ok(Event::Line(Ok(Some(line)))) => Ok(line),
            Ok(Event::Line(Ok(None))) => Err(End::Done),
            Ok(Event::Line(Err(e))) => Err(End::Failed(Failure::io(format!("stdin: {e}")))),
            _ => Err(End::Stopped),
        }
    }

    /// Writes an answer, and waits until it is taken.
    pub fn write(&self, answer: String) -> Result<(), End> {
        let _ = self.answers.send(answer);
        match self.events.recv() {
            Ok(Event::Written(Ok(()))) => Ok(()),
            Ok(Event::Written(Err(e))) if e.kind() == io::ErrorKind::BrokenPipe => Err(End::Done),
            Ok(Event::Written(Err(e))) => Err(End::Failed(Failure::io(format!("stdout: {e}")))),
            _ => Err(End::Stopped),
        }
    }
}

/// The first line without a byte-order mark, which some programs write before their text.
fn without_mark(line: Vec<u8>) -> Vec<u8> {
    text::without_mark(&line).to_vec()
}

/// The next line without its end; of one that is too long, the beginning, one byte longer than lines may be.
fn read_line(input: &mut impl BufRead) -> io::Result<Option<Vec<u8>>> {
    let mut line = Vec::new();
    input.take(MAX_LINE as u64 + 1).read_until(b'\n', &mut line)?;
    if line.is_empty() {
        return Ok(None);
    }
    if line.last() == Some(&b'\n') {
        line.pop();
    } else if line.len() > MAX_LINE {
        input.skip_until(b'\n')?;
    }
    Ok(Some(line))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_their_end_or_at_that_of_the_input() {
        let mut input = &b"one\n\nlast"[..];
        let mut next = || read_line(&mut input).unwrap();
        assert_eq!([next(), next(), next()], [&b"one"[..], b"", b"last"].map(|line| Some(line.to_vec())));
        assert_eq!(next(), None);
    }

    #[test]
    fn of_a_line_without_end_no_more_than_the_limit_is_kept() {
        let endless = io::repeat(b'x').take(MAX_LINE as u64 + 5_000_000);
        let mut input = BufReader::new(endless.chain(&b"\nnext\n"[..]));
        assert_eq!(read_line(&mut input).unwrap().unwrap().len(), MAX_LINE + 1);
        assert_eq!(read_line(&mut input).unwrap().unwrap(), b"next");
    }
}
