//! A file over HTTP, in as many attempts as it takes.
//!
//! Bytes that have arrived are never requested again: an attempt requests the rest (`Range`), on condition that the
//! file is still the same (`If-Range`); an answer that does not continue exactly there starts the file anew.
//! Busy servers (408, 425, 429, 5xx), timeouts and broken connections are tried again, each time after twice
//! the pause or after `Retry-After` in seconds; an attempt that brought much that is new does not count. Every
//! other status ends it. Nothing is written beyond the size that is expected. Redirects are followed to http and
//! https, from an https address to https alone.

use super::error::FetchError;
use super::part::Part;
use crate::archive::Archive;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use ureq::http::{HeaderMap, Response, Uri, header};
use ureq::{Agent, Body, ResponseExt};

/// New bytes that make an attempt a good one.
const GAIN: u64 = 1 << 20;

const CHANGED: &str = "the answer does not continue what was begun, the file is fetched from its start";

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
    /// For the head of an answer, and for the next byte.
    pub stall: Duration,
    /// Time in which at least `slow` bytes must arrive.
    pub window: Duration,
    /// Bytes.
    pub slow: u64,
    /// Attempts in a row that bring little before it is given up.
    pub attempts: u32,
    /// Pause after the first of them, doubled after each, up to `longest`.
    pub pause: Duration,
    /// Longest pause, also where the server asks for one.
    pub longest: Duration,
    /// Most bytes of a file whose size is not pinned.
    pub limit: u64,
}

impl Default for Patience {
    /// 20 s for a connection, 60 s for an answer or the next byte, 1 KiB/s over a minute, 5 attempts in a row
    /// with pauses of 1 to 60 s, and 64 GiB.
    fn default() -> Self {
        let seconds = Duration::from_secs;
        Self {
            connect: seconds(20),
            stall: seconds(60),
            window: seconds(60),
            slow: 60 << 10,
            attempts: 5,
            pause: seconds(1),
            longest: seconds(60),
            limit: 1 << 36,
        }
    }
}

/// A file that has arrived.
pub(super) struct Download {
    pub path: PathBuf,
    pub url: String,
    pub size: u64,
    pub sha256: String,
}

/// The complete http or https address that a text is.
pub(super) fn address(url: &str) -> Result<Uri, FetchError> {
    let fail = |why: &str| FetchError::Address(format!("{url}: {why}"));
    let uri: Uri = url.parse().map_err(|e| fail(&format!("no address ({e})")))?;
    match (uri.scheme_str(), uri.host()) {
        (Some("http" | "https"), Some(host)) if !host.is_empty() => Ok(uri),
        (Some("http" | "https"), _) => Err(fail("no host")),
        (Some(other), _) => Err(fail(&format!("`{other}` is not asked"))),
        (None, _) => Err(fail("no http:// or https:// at its start")),
    }
}

/// The last part of an address's path; empty when the path ends with `/`.
pub(super) fn file_name(address: &Uri) -> &str {
    address.path().rsplit('/').next().unwrap_or_default()
}

/// Downloads an archive into `folder`, or finds it there; from a mirror the file of the same name below its address.
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
    let mut address_asked = address(&archive.url)?;
    if let Some(mirror) = mirror {
        address_asked = address(&format!("{}/{}", mirror.trim_end_matches('/'), file_name(&address_asked)))?;
    }
    let url = address_asked.to_string();
    let mut part = Part::open(folder, &archive.name, &url, archive.sha256.is_some())?;
    // Once it is whole, the note says which bytes they were.
    if part.note.sha256.is_some() && part.note.sha256 != part.sha256().ok() {
        part.reset()?;
    }
    if part.note.sha256.is_none() {
        let agent = agent(&address_asked, patience);
        Request { archive, url: &url, agent, patience, watch }.until_whole(&mut part)?;
    }
    let size = part.len()?;
    if let Some(expected) = archive.size
        && size != expected
    {
        part.reset()?;
        return Err(other_size(&url, size, expected, "datasets/archives.toml"));
    }
    let sha256 = part.sha256()?;
    if let Some(pinned) = &archive.sha256
        && !pinned.eq_ignore_ascii_case(&sha256)
    {
        part.reset()?;
        return Err(FetchError::Data(format!(
            "{url}: SHA-256 is {sha256}, pinned is {pinned}; the download is deleted: fetch again, and if it stays \
             so, the file at this address has been changed (use a --mirror that has the pinned one)"
        )));
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

/// What is asked, of whom, and with what patience.
struct Request<'a> {
    archive: &'a Archive,
    url: &'a str,
    agent: Agent,
    patience: &'a Patience,
    watch: &'a dyn FetchWatch,
}

/// Why an attempt has not brought the whole file.
enum Cut {
    /// Another attempt would not bring it either.
    Final(FetchError),
    /// Another attempt may, after the pause that the server asks for.
    Again(String, Option<Duration>),
}

impl From<FetchError> for Cut {
    fn from(error: FetchError) -> Self {
        Self::Final(error)
    }
}

impl Request<'_> {
    fn until_whole(&self, part: &mut Part) -> Result<(), FetchError> {
        let (mut failures, mut most) = (0_u32, part.len()?);
        loop {
            let (what, wait) = match self.attempt(part) {
                Ok(()) => return Ok(()),
                Err(Cut::Final(error)) => return Err(error),
                Err(Cut::Again(what, wait)) => (what, wait),
            };
            let kept = part.len()?;
            failures = if kept >= most.saturating_add(GAIN) { 1 } else { failures + 1 };
            most = most.max(kept);
            if failures >= self.patience.attempts {
                return Err(FetchError::Network(format!(
                    "{}: {what} (attempt {failures}, then given up). Is this machine online, and is HTTPS_PROXY set \
                     if it needs a proxy? {kept} bytes have arrived and are kept: the same command goes on \
                     from there",
                    self.url
                )));
            }
            let doubled = self.patience.pause.saturating_mul(1 << (failures - 1).min(16));
            let pause = wait.unwrap_or(doubled).min(self.patience.longest);
            let name = &self.archive.name;
            self.watch.note(&format!("{name}: {what}; trying again in {:.0} s", pause.as_secs_f64()));
            std::thread::sleep(pause);
        }
    }

    fn attempt(&self, part: &mut Part) -> Result<(), Cut> {
        let mut have = part.len()?;
        if have > 0 && part.note.total == Some(have) {
            return Ok(());
        }
        let too_long = self.archive.size.is_some_and(|size| have > size);
        if have > 0 && (too_long || (part.note.mark.is_none() && self.archive.sha256.is_none())) {
            part.reset()?;
            have = 0;
        }
        let mut response = self.ask(part, have)?;
        let (status, headers) = (response.status().as_u16(), response.headers().clone());
        match status {
            200 => {
                let total = response.body().content_length();
                self.check_total(total)?;
                part.reset()?;
                let etag = text(&headers, header::ETAG).filter(|etag| etag.starts_with('"'));
                part.note.mark = etag.or_else(|| text(&headers, header::LAST_MODIFIED));
                part.note.total = total;
                part.write_note()?;
                self.receive(part, &mut response, 0, total)
            }
            206 if have > 0 => {
                let known = part.note.total;
                let range = content_range(&headers).filter(|(first, total)| {
                    let other_total = known.is_some_and(|known| total.is_some_and(|t| t != known));
                    *first == have && !other_total && !is_other(part.note.mark.as_deref(), &headers)
                });
                let Some((_, total)) = range else {
                    part.reset()?;
                    return Err(Cut::Again(CHANGED.into(), None));
                };
                let total = total.or(known);
                self.check_total(total)?;
                self.receive(part, &mut response, have, total)
            }
            416 if have > 0 => {
                let total = text(&headers, header::CONTENT_RANGE)
                    .and_then(|t| t.strip_prefix("bytes */").and_then(|n| n.parse::<u64>().ok()));
                let known = part.note.total.or(self.archive.size);
                if total == Some(have) && known.is_none_or(|known| known == have) {
                    return Ok(());
                }
                part.reset()?;
                Err(Cut::Again(CHANGED.into(), None))
            }
            408 | 425 | 429 | 500..=599 => {
                let wait = text(&headers, header::RETRY_AFTER).and_then(|t| t.trim().parse().ok());
                let wait = wait.map(Duration::from_secs);
                if status == 429 && wait.is_some_and(|wait| wait > self.patience.longest) {
                    return Err(refused(&response).into());
                }
                Err(Cut::Again(format!("the server answers {status}"), wait))
            }
            _ => Err(refused(&response).into()),
        }
    }

    /// Asks for what is behind the first `have` bytes.
    fn ask(&self, part: &Part, have: u64) -> Result<Response<Body>, Cut> {
        let mut request = self.agent.get(self.url);
        if have > 0 {
            request = request.header(header::RANGE, format!("bytes={have}-"));
            if let Some(mark) = &part.note.mark {
                request = request.header(header::IF_RANGE, mark.as_str());
            }
        }
        request.call().map_err(|e| match e {
            ureq::Error::TooManyRedirects
            | ureq::Error::RequireHttpsOnly(_)
            | ureq::Error::BadUri(_)
            | ureq::Error::Http(_)
            | ureq::Error::Protocol(_) => Cut::Final(FetchError::Data(format!(
                "{}: a redirect or an answer that is not followed ({e}); get the file by hand, or from a --mirror",
                self.url
            ))),
            e => Cut::Again(format!("no answer ({e})"), None),
        })
    }

    /// Compares the size a server announces with the expected one, before anything is written.
    fn check_total(&self, total: Option<u64>) -> Result<(), FetchError> {
        match (self.archive.size, total) {
            (Some(expected), Some(got)) if got != expected => {
                Err(other_size(self.url, got, expected, "datasets/archives.toml"))
            }
            (None, Some(got)) if got > self.patience.limit => Err(self.over_limit()),
            _ => Ok(()),
        }
    }

    fn over_limit(&self) -> FetchError {
        let (url, limit) = (self.url, self.patience.limit);
        FetchError::Data(format!(
            "{url}: more than {limit} bytes, the most that is fetched without a size in datasets/archives.toml"
        ))
    }

    /// Writes a body behind the `have` bytes that are there.
    fn receive(
        &self,
        part: &Part,
        response: &mut Response<Body>,
        mut have: u64,
        total: Option<u64>,
    ) -> Result<(), Cut> {
        let mut file = part.append()?;
        let mut body = response.body_mut().as_reader();
        let mut buffer = vec![0; 1 << 16];
        let (mut since, mut arrived) = (Instant::now(), 0_u64);
        let again = |what: String| Err(Cut::Again(what, None));
        loop {
            let n = match body.read(&mut buffer) {
                Ok(0) => break,
                Ok(n) => n,
                Err(e) if e.kind() == ErrorKind::Interrupted => continue,
                Err(e) => return again(format!("cut after {have} bytes ({e})")),
            };
            let end = have + n as u64;
            match (self.archive.size, total) {
                (Some(size), _) if end > size => {
                    return Err(other_size(self.url, end, size, "datasets/archives.toml").into());
                }
                (None, Some(total)) if end > total => {
                    return Err(other_size(self.url, end, total, "the server").into());
                }
                (None, _) if end > self.patience.limit => return Err(self.over_limit().into()),
                _ => {}
            }
            let bytes = buffer.get(..n).unwrap_or_default();
            file.write_all(bytes).map_err(|e| FetchError::disk(part.path(), e))?;
            have = end;
            arrived += n as u64;
            self.watch.arrived(&self.archive.name, have, total.or(self.archive.size));
            if since.elapsed() >= self.patience.window {
                if arrived < self.patience.slow {
                    return again(format!("too slow, {arrived} bytes in {:.0?}", since.elapsed()));
                }
                (since, arrived) = (Instant::now(), 0);
            }
        }
        match total.or(self.archive.size) {
            Some(total) if have < total => again(format!("cut after {have} of {total} bytes")),
            _ => Ok(()),
        }
    }
}

fn agent(address: &Uri, patience: &Patience) -> Agent {
    let config = Agent::config_builder()
        .http_status_as_error(false)
        .https_only(address.scheme_str() == Some("https"))
        .max_idle_connections(0)
        .user_agent(concat!("trackfail/", env!("CARGO_PKG_VERSION")))
        .accept_encoding("identity")
        .timeout_resolve(Some(patience.connect))
        .timeout_connect(Some(patience.connect))
        .timeout_recv_response(Some(patience.stall))
        .timeout_per_read(Some(patience.stall))
        .timeout_per_write(Some(patience.stall));
    let host = address.host().unwrap_or_default();
    let ip = host.trim_matches(['[', ']']).parse::<std::net::IpAddr>();
    // No proxy is asked for this machine.
    let is_local = host == "localhost" || ip.is_ok_and(|ip| ip.is_loopback());
    let config = if is_local { config.proxy(None) } else { config };
    config.build().into()
}

/// The error of an answer that trying again does not change.
fn refused(response: &Response<Body>) -> FetchError {
    let status = response.status().as_u16();
    let advice = match status {
        401 | 403 | 407 => " (not allowed): get the file by hand, or from a --mirror",
        404 | 410 => " (not there): the file has moved; get it by hand, or from a --mirror",
        429 => " (too many requests) and asks to wait long: try again in an hour",
        _ => ": try again later, or use a --mirror",
    };
    FetchError::Data(format!("{}: the server answers {status}{advice}", response.get_uri()))
}

fn other_size(url: &str, got: u64, expected: u64, source_of: &str) -> FetchError {
    FetchError::Data(format!(
        "{url}: {got} bytes, expected are {expected} ({source_of}); the file at this address is another one \
         than was pinned, or was cut: try again later or use a --mirror"
    ))
}

fn text(headers: &HeaderMap, name: header::HeaderName) -> Option<String> {
    headers.get(name)?.to_str().ok().map(String::from)
}

/// Whether an answer has another ETag than the one that a download has been begun with.
fn is_other(mark: Option<&str>, headers: &HeaderMap) -> bool {
    let etag = text(headers, header::ETAG);
    mark.is_some_and(|mark| mark.starts_with('"') && etag.is_some_and(|etag| etag != mark))
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

    #[test]
    fn only_complete_http_addresses() {
        for bad in
            ["", "x", "/a.zip", "file:///etc/passwd", "ftp://h/a", "http://", "http:///a", "HT TP://h/"]
        {
            assert!(matches!(address(bad), Err(FetchError::Address(_))), "{bad}");
        }
        assert_eq!(file_name(&address("http://h:81/a/b.zip?x=1").unwrap()), "b.zip");
        let patience = Patience::default();
        let asks_https_alone = |url| agent(&address(url).unwrap(), &patience).config().https_only();
        assert!(asks_https_alone("https://h/a") && !asks_https_alone("http://h/a"));
        for local in ["http://127.0.0.1:9/", "http://[::1]:9/", "http://localhost/"] {
            assert!(agent(&address(local).unwrap(), &patience).config().proxy().is_none(), "{local}");
        }
    }

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
