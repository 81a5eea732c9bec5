//! A file over HTTP, in as many attempts as it takes.
//!
//! Bytes that have arrived are never requested again: an attempt requests the rest (`Range`), on condition that the
//! file is still the same (`If-Range`); an answer that does not continue exactly there starts the file anew.
//! Busy servers (408, 425, 429, 5xx), timeouts and broken connections are tried again, each time after twice
//! the pause or after `Retry-After` in seconds; an attempt that brought something new does not count. Every
//! other status ends it. Nothing is written beyond the size that is expected.

use super::address::{Address, of_archive};
use super::error::FetchError;
use super::part::Part;
use crate::archive::Archive;
use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use ureq::http::{HeaderMap, Response, header};
use ureq::{Agent, Body};

/// Most redirects that are followed.
const MAX_REDIRECTS: u32 = 10;

/// Observer of a download.
pub trait FetchWatch {
    /// Called as bytes arrive: those on disk, and those of the whole file if its size is known.
    fn arrived(&self, archive: &str, bytes: u64, total: Option<u64>);
    /// Called with a line of text that users should see.
    fn note(&self, text: &str);
}

/// Patience with a server.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patience {
    /// For a connection.
    pub connect: Duration,
    /// For the head of an answer.
    pub answer: Duration,
    /// For the next byte.
    pub stall: Duration,
    /// Time in which at least `slow` bytes must arrive.
    pub window: Duration,
    /// Bytes.
    pub slow: u64,
    /// Attempts in a row that bring nothing before it is given up; 3 at most while no server has answered.
    pub attempts: u32,
    /// Pause after the first of them, doubled after each, up to `longest`.
    pub pause: Duration,
    /// Longest pause, also where the server asks for one.
    pub longest: Duration,
    /// New bytes that make an attempt a good one.
    pub gain: u64,
    /// Most bytes of a file whose size is not pinned.
    pub limit: u64,
}

impl Default for Patience {
    /// 20 s for a connection, 60 s for an answer or the next byte, 1 KiB/s over a minute, 6 attempts in a row
    /// with pauses of 1 to 60 s, and 64 GiB.
    fn default() -> Self {
        let seconds = Duration::from_secs;
        Self {
            connect: seconds(20),
            answer: seconds(60),
            stall: seconds(60),
            window: seconds(60),
            slow: 60 << 10,
            attempts: 6,
            pause: seconds(1),
            longest: seconds(60),
            gain: 1 << 20,
            limit: 1 << 36,
        }
    }
}

/// A file that has arrived.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Download {
    pub path: PathBuf,
    pub url: String,
    pub size: u64,
    pub sha256: String,
}

/// Downloads an archive into `folder`, or finds it there.
///
/// # Errors
/// See [`FetchError`]; what has arrived stays, unless it is not the pinned file.
pub(super) fn download(
    folder: &Path,
    archive: &Archive,
    mirror: Option<&str>,
    patience: &Patience,
    watch: &dyn FetchWatch,
) -> Result<Download, FetchError> {
    let address = of_archive(&archive.url, mirror)?;
    let url = address.text();
    let mut part = Part::open(folder, &archive.name, &url, archive.sha256.is_some())?;
    // Once it is whole, the note says which bytes they were.
    if let Some(known) = part.note.sha256.clone()
        && known != part.sha256().unwrap_or_default()
    {
        part.reset()?;
    }
    if part.note.sha256.is_none() {
        ActiveDownload { archive, address: &address, patience, watch, part: &mut part }.until_whole()?;
    }
    let size = part.len()?;
    if let Some(expected) = archive.size
        && size != expected
    {
        part.reset()?;
        return Err(FetchError::Size { url, expected, got: size, source_of: "datasets.lock" });
    }
    let sha256 = part.sha256()?;
    if let Some(pinned) = &archive.sha256
        && !pinned.eq_ignore_ascii_case(&sha256)
    {
        part.reset()?;
        return Err(FetchError::Digest { url, expected: pinned.clone(), got: sha256 });
    }
    part.note.sha256 = Some(sha256.clone());
    part.write_note()?;
    Ok(Download { path: part.path().into(), url, size, sha256 })
}

/// Removes a download.
///
/// # Errors
/// [`FetchError::Disk`].
pub(super) fn discard(folder: &Path, archive: &Archive) -> Result<(), FetchError> {
    Part::open(folder, &archive.name, "", false)?.reset()
}

/// A download that is under way.
struct ActiveDownload<'a> {
    archive: &'a Archive,
    address: &'a Address,
    patience: &'a Patience,
    watch: &'a dyn FetchWatch,
    part: &'a mut Part,
}

/// End of an attempt that is no final error.
enum AttemptOutcome {
    /// The file is whole.
    Whole,
    /// A failure that may not happen again.
    Again { what: String, wait: Option<Duration>, answered: bool },
}

/// Answer to a request.
enum Reply {
    /// A response that is no redirect, and the address that gave it.
    Response(Address, Response<Body>),
    /// The server could not be reached, which may be different next time.
    Unreachable(AttemptOutcome),
}

impl AttemptOutcome {
    fn again(what: impl Into<String>) -> Self {
        Self::Again { what: what.into(), wait: None, answered: true }
    }
}

impl ActiveDownload<'_> {
    fn until_whole(&mut self) -> Result<(), FetchError> {
        let (mut failures, mut most, mut heard) = (0_u32, self.part.len()?, false);
        loop {
            let (what, wait) = match self.attempt()? {
                AttemptOutcome::Whole => return Ok(()),
                AttemptOutcome::Again { what, wait, answered } => {
                    heard |= answered;
                    (what, wait)
                }
            };
            let kept = self.part.len()?;
            let gained = kept >= most.saturating_add(self.patience.gain);
            most = most.max(kept);
            failures = if gained { 1 } else { failures + 1 };
            let allowed = if heard { self.patience.attempts } else { self.patience.attempts.min(3) };
            if failures >= allowed {
                return Err(FetchError::Network {
                    url: self.address.text(),
                    reason: what,
                    attempts: failures,
                    kept,
                });
            }
            let doubled = self.patience.pause.saturating_mul(1 << (failures - 1).min(16));
            let pause = wait.unwrap_or(doubled).min(self.patience.longest);
            let name = &self.archive.name;
            self.watch.note(&format!("{name}: {what}; trying again in {:.0} s", pause.as_secs_f64()));
            std::thread::sleep(pause);
        }
    }

    fn attempt(&mut self) -> Result<AttemptOutcome, FetchError> {
        let mut have = self.part.len()?;
        if have > 0 && self.part.note.total == Some(have) {
            return Ok(AttemptOutcome::Whole);
        }
        let pinned = self.archive.sha256.is_some();
        let too_long = self.archive.size.is_some_and(|size| have > size);
        if have > 0 && (too_long || (self.part.note.mark().is_none() && !pinned)) {
            self.part.reset()?;
            have = 0;
        }
        let (from, mut response) = match self.ask(have)? {
            Reply::Response(from, response) => (from, response),
            Reply::Unreachable(outcome) => return Ok(outcome),
        };
        let status = response.status().as_u16();
        let headers = response.headers();
        match status {
            200 => {
                let total = response.body().content_length();
                self.check_total(&from, total)?;
                self.part.reset()?;
                self.part.note.etag = text(headers, header::ETAG).filter(|etag| etag.starts_with('"'));
                self.part.note.modified = text(headers, header::LAST_MODIFIED);
                self.part.note.total = total;
                self.part.write_note()?;
                self.receive(&from, &mut response, 0, total)
            }
            206 if have > 0 => {
                let Some((first, total)) = content_range(headers) else {
                    self.part.reset()?;
                    return Ok(AttemptOutcome::again("a part of the file that is not said to be which"));
                };
                let known = self.part.note.total;
                let etag = text(headers, header::ETAG);
                let other_etag =
                    etag.is_some() && self.part.note.etag.is_some() && etag != self.part.note.etag;
                if first != have || other_etag || known.is_some_and(|known| total.is_some_and(|t| t != known))
                {
                    self.part.reset()?;
                    return Ok(AttemptOutcome::again(
                        "the file has changed on the server, it is fetched from its start",
                    ));
                }
                let total = total.or(known);
                self.check_total(&from, total)?;
                self.receive(&from, &mut response, have, total)
            }
            416 if have > 0 => {
                let total = text(headers, header::CONTENT_RANGE)
                    .and_then(|t| t.strip_prefix("bytes */").and_then(|n| n.parse::<u64>().ok()));
                let known = self.part.note.total.or(self.archive.size);
                if total == Some(have) && known.is_none_or(|known| known == have) {
                    return Ok(AttemptOutcome::Whole);
                }
                self.part.reset()?;
                Ok(AttemptOutcome::again("the file has changed on the server, it is fetched from its start"))
            }
            408 | 425 | 429 | 500..=599 => {
                let wait = text(headers, header::RETRY_AFTER).and_then(|t| t.trim().parse().ok());
                let wait = wait.map(Duration::from_secs);
                if status == 429 && wait.is_some_and(|wait| wait > self.patience.longest) {
                    return Err(FetchError::Status { url: from.text(), status });
                }
                Ok(AttemptOutcome::Again {
                    what: format!("the server answers {status}"),
                    wait,
                    answered: true,
                })
            }
            _ => Err(FetchError::Status { url: from.text(), status }),
        }
    }

    /// Asks for what is behind the first `have` bytes, following redirects.
    fn ask(&self, have: u64) -> Result<Reply, FetchError> {
        let mut address = self.address.clone();
        for _ in 0..=MAX_REDIRECTS {
            let agent = agent(&address, self.patience);
            let mut request = agent.get(address.uri());
            if have > 0 {
                request = request.header(header::RANGE, format!("bytes={have}-"));
                if let Some(mark) = self.part.note.mark() {
                    request = request.header(header::IF_RANGE, mark);
                }
            }
            let response = match request.call() {
                Ok(response) => response,
                Err(ureq::Error::BadUri(reason)) => {
                    return Err(FetchError::Address { url: address.text(), reason });
                }
                Err(e) => {
                    let what = format!("no answer ({e})");
                    let again = AttemptOutcome::Again { what, wait: None, answered: false };
                    return Ok(Reply::Unreachable(again));
                }
            };
            if !matches!(response.status().as_u16(), 301 | 302 | 303 | 307 | 308) {
                return Ok(Reply::Response(address, response));
            }
            let location = text(response.headers(), header::LOCATION).unwrap_or_default();
            address = address.redirected(&location)?;
        }
        let (url, to) = (self.address.text(), address.text());
        Err(FetchError::Redirect { url, to, reason: "which is one redirect too many" })
    }

    /// Compares the size a server announces with the expected one, before anything is written.
    fn check_total(&self, from: &Address, total: Option<u64>) -> Result<(), FetchError> {
        let url = from.text();
        match (self.archive.size, total) {
            (Some(expected), Some(got)) if got != expected => {
                Err(FetchError::Size { url, expected, got, source_of: "datasets.lock" })
            }
            (None, Some(got)) if got > self.patience.limit => {
                Err(FetchError::Limit { url, limit: self.patience.limit })
            }
            _ => Ok(()),
        }
    }

    /// Writes a body behind the `have` bytes that are there.
    fn receive(
        &self,
        from: &Address,
        response: &mut Response<Body>,
        mut have: u64,
        total: Option<u64>,
    ) -> Result<AttemptOutcome, FetchError> {
        let mut file: File = self.part.append()?;
        let mut body = response.body_mut().as_reader();
        let mut buffer = vec![0; 1 << 16];
        let (mut since, mut arrived) = (Instant::now(), 0_u64);
        loop {
            let n = match body.read(&mut buffer) {
                Ok(0) => break,
                Ok(n) => n,
                Err(e) if e.kind() == ErrorKind::Interrupted => continue,
                Err(e) => return Ok(AttemptOutcome::again(format!("cut after {have} bytes ({e})"))),
            };
            let end = have + n as u64;
            if let Some(expected) = self.archive.size.or(total).filter(|expected| end > *expected) {
                let source_of = if self.archive.size.is_some() { "datasets.lock" } else { "the server" };
                return Err(FetchError::Size { url: from.text(), expected, got: end, source_of });
            }
            if self.archive.size.is_none() && end > self.patience.limit {
                return Err(FetchError::Limit { url: from.text(), limit: self.patience.limit });
            }
            let bytes = buffer.get(..n).unwrap_or_default();
            file.write_all(bytes).map_err(|e| FetchError::disk(self.part.path(), e))?;
            have = end;
            arrived += n as u64;
            self.watch.arrived(&self.archive.name, have, total.or(self.archive.size));
            if since.elapsed() >= self.patience.window {
                if arrived < self.patience.slow {
                    return Ok(AttemptOutcome::again(format!(
                        "too slow, {arrived} bytes in {:.0?}",
                        since.elapsed()
                    )));
                }
                (since, arrived) = (Instant::now(), 0);
            }
        }
        match total.or(self.archive.size) {
            Some(total) if have < total => {
                Ok(AttemptOutcome::again(format!("cut after {have} of {total} bytes")))
            }
            _ => Ok(AttemptOutcome::Whole),
        }
    }
}

fn agent(address: &Address, patience: &Patience) -> Agent {
    let config = Agent::config_builder()
        .http_status_as_error(false)
        .max_redirects(0)
        .max_idle_connections(0)
        .user_agent(concat!("trackfail/", env!("CARGO_PKG_VERSION")))
        .accept_encoding("identity")
        .timeout_resolve(Some(patience.connect))
        .timeout_connect(Some(patience.connect))
        .timeout_recv_response(Some(patience.answer))
        .timeout_per_read(Some(patience.stall))
        .timeout_per_write(Some(patience.stall));
    let config = if address.is_local() { config.proxy(None) } else { config };
    config.build().into()
}

fn text(headers: &HeaderMap, name: header::HeaderName) -> Option<String> {
    headers.get(name)?.to_str().ok().map(String::from)
}

/// First byte and size of the whole file, of `bytes FIRST-LAST/TOTAL`.
fn content_range(headers: &HeaderMap) -> Option<(u64, Option<u64>)> {
    let value = text(headers, header::CONTENT_RANGE)?;
    let (range, total) = value.strip_prefix("bytes ")?.split_once('/')?;
    let (first, last) = range.split_once('-')?;
    let (first, last): (u64, u64) = (first.parse().ok()?, last.parse().ok()?);
    let total = if total == "*" { None } else { Some(total.parse().ok()?) };
    (first <= last && total.is_none_or(|t| last < t)).then_some((first, total))
}

#[cfg(test)]
mod tests {
    use super::*;

    // RFC 9110, section 14.4.
    #[test]
    fn content_ranges() {
        let read = |value: &str| {
            let mut headers = HeaderMap::new();
            headers.insert(header::CONTENT_RANGE, value.parse().unwrap());
            content_range(&headers)
        };
        assert_eq!(read("bytes 42-1233/1234"), Some((42, Some(1234))));
        assert_eq!(read("bytes 42-1233/*"), Some((42, None)));
        for bad in [
            "bytes */1234",
            "bytes 42-1234/1234",
            "bytes 9-8/10",
            "items 0-1/2",
            "bytes 0-/2",
            "bytes -1-1/2",
            "",
        ] {
            assert_eq!(read(bad), None, "{bad}");
        }
    }
}
