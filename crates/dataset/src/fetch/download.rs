//! A file over HTTP, in as many attempts as it takes.
//!
//! Bytes that have arrived are never requested again: an attempt requests the rest (`Range`), on condition
//! that the file is still the same (`If-Range`); an answer that does not continue exactly there starts the
//! file anew. Busy servers (408, 425, 429, 5xx), timeouts and broken connections are tried again, each time
//! after twice the pause or after `Retry-After` in seconds; an attempt that brought many new bytes does not
//! count as a failure. Every other status ends the download. Nothing is written beyond the size that is
//! expected. Redirects are followed to http and https, from an https address to https alone.

use super::part::Part;
use super::{FetchError, Result};
use crate::archive::Archive;
use crate::digest::file_digest;
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use ureq::http::{HeaderMap, Response, Uri, header};
use ureq::{Agent, Body, ResponseExt};

/// New bytes from which on an attempt does not count as a failure.
const GAIN: u64 = 1 << 20;

/// Longest wait for a connection to be made.
const CONNECT: Duration = Duration::from_secs(20);

const CHANGED: &str = "the answer does not continue what was begun, the file is fetched from its start";

/// News of a download.
pub enum Told<'t> {
    /// The number of bytes on disk, and the size of the whole file, if known.
    Arrived(u64, Option<u64>),
    /// A line of text that users should see.
    Note(&'t str),
}

/// Timeouts and retries for one server.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patience {
    /// Longest wait for the head of an answer, and for the next byte.
    pub stall: Duration,
    /// Number of failed attempts in a row after which the download is given up.
    pub attempts: u32,
    /// Pause after the first failed attempt; doubled after each further one, up to `longest`.
    pub pause: Duration,
    /// Longest pause, even if the server asks for a longer one.
    pub longest: Duration,
    /// Largest file in bytes, for files whose size is not pinned.
    pub limit: u64,
}

impl Default for Patience {
    /// 60 s for an answer or the next byte, 5 attempts in a row with pauses of 1 to 60 s, and 64 GiB.
    fn default() -> Self {
        let seconds = Duration::from_secs;
        Self { stall: seconds(60), attempts: 5, pause: seconds(1), longest: seconds(60), limit: 1 << 36 }
    }
}

/// A complete download on disk.
pub(super) struct Download {
    pub path: PathBuf,
    pub url: String,
    pub size: u64,
    pub sha256: String,
}

/// Parses a complete http or https address.
pub(super) fn address(url: &str) -> Result<Uri> {
    let uri: Option<Uri> = url.parse().ok();
    let is_complete = |uri: &Uri| {
        matches!(uri.scheme_str(), Some("http" | "https")) && uri.host().is_some_and(|host| !host.is_empty())
    };
    uri.filter(is_complete).ok_or_else(|| FetchError::Address(format!("`{url}`")))
}

/// Last part of the path of an address; empty if the path ends with `/`.
pub(super) fn file_name(address: &Uri) -> &str {
    address.path().rsplit('/').next().unwrap_or_default()
}

/// Downloads an archive into `folder`, or finds the complete download there. With a `mirror`, the file of the
/// same name below that address is taken.
///
/// # Errors
/// See [`FetchError`]. The bytes that arrived stay on disk, unless they are not of the pinned file.
pub(super) fn download(
    folder: &Path,
    archive: &Archive,
    mirror: Option<&str>,
    patience: &Patience,
    watch: &dyn Fn(Told<'_>),
) -> Result<Download> {
    let mut asked = address(&archive.url)?;
    if let Some(mirror) = mirror {
        asked = address(&format!("{}/{}", mirror.trim_end_matches('/'), file_name(&asked)))?;
    }
    let url = asked.to_string();
    let mut part = Part::open(folder, &archive.name, &url)?;
    let agent = agent(&asked, patience);
    Request { archive, url: &url, agent, patience, watch }.until_whole(&mut part)?;
    let size = part.len()?;
    let sha256 = file_digest(&part.path).map_err(|e| FetchError::disk(&part.path, io::Error::other(e)))?;
    let fault = match (archive.size, &archive.sha256) {
        (Some(expected), _) if size != expected => other_size(&url, size, expected),
        (_, Some(pinned)) if !pinned.eq_ignore_ascii_case(&sha256) => FetchError::Data(format!(
            "{url}: SHA-256 is {sha256}, pinned is {pinned}; the download is deleted: fetch again, and if it stays \
             so, the file at this address has been changed (use a --mirror that has the pinned one)"
        )),
        _ => return Ok(Download { path: part.path, url, size, sha256 }),
    };
    part.reset()?;
    Err(fault)
}

/// Removes a download and its note.
///
/// # Errors
/// [`FetchError::Disk`].
pub(super) fn discard(folder: &Path, archive: &Archive) -> Result<()> {
    Part::open(folder, &archive.name, "")?.reset()
}

/// A download in progress: the archive, its address, and the patience with the server.
struct Request<'a> {
    archive: &'a Archive,
    url: &'a str,
    agent: Agent,
    patience: &'a Patience,
    watch: &'a dyn Fn(Told<'_>),
}

/// Reason why an attempt did not bring the whole file though a further one may, and the pause that the server asks for.
type Cut = (String, Option<Duration>);

impl Request<'_> {
    fn until_whole(&self, part: &mut Part) -> Result<()> {
        let (mut failures, mut most) = (0_u32, part.len()?);
        loop {
            let Some((what, wait)) = self.attempt(part)? else { return Ok(()) };
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
            let note = format!("{name}: {what}; trying again in {:.0} s", pause.as_secs_f64());
            (self.watch)(Told::Note(&note));
            std::thread::sleep(pause);
        }
    }

    /// Requests the bytes that are missing, and receives them; `None` once the file is whole.
    fn attempt(&self, part: &mut Part) -> Result<Option<Cut>> {
        let mut have = part.len()?;
        if have > 0 && part.total.or(self.archive.size) == Some(have) {
            return Ok(None);
        }
        let is_known = part.mark.is_some() || self.archive.sha256.is_some();
        if have > 0 && (!is_known || self.archive.size.is_some_and(|size| have > size)) {
            part.reset()?;
            have = 0;
        }
        let mut request = self.agent.get(self.url);
        if have > 0 {
            request = request.header(header::RANGE, format!("bytes={have}-"));
            if let Some(mark) = &part.mark {
                request = request.header(header::IF_RANGE, mark.as_str());
            }
        }
        let mut response = match request.call() {
            Ok(response) => response,
            Err(
                e @ (ureq::Error::TooManyRedirects
                | ureq::Error::RequireHttpsOnly(_)
                | ureq::Error::BadUri(_)
                | ureq::Error::Http(_)
                | ureq::Error::Protocol(_)),
            ) => {
                let what = "a redirect or an answer that is not followed";
                let told = format!("{}: {what} ({e}); get the file by hand, or from a --mirror", self.url);
                return Err(FetchError::Data(told));
            }
            Err(e) => return Ok(Some((format!("no answer ({e})"), None))),
        };
        let (status, headers) = (response.status().as_u16(), response.headers().clone());
        match status {
            200 => {
                let total = response.body().content_length();
                self.check_size(total.unwrap_or(0), None)?;
                let etag = text(&headers, header::ETAG).filter(|etag| etag.starts_with('"'));
                part.begin(etag.or_else(|| text(&headers, header::LAST_MODIFIED)), total)?;
                self.receive(part, &mut response, 0)
            }
            206 if have > 0 && goes_on(part, have, &headers) => self.receive(part, &mut response, have),
            206 | 416 if have > 0 => {
                part.reset()?;
                Ok(Some((CHANGED.into(), None)))
            }
            408 | 425 | 429 | 500..=599 => {
                let wait = text(&headers, header::RETRY_AFTER).and_then(|t| t.trim().parse().ok());
                Ok(Some((format!("the server answers {status}"), wait.map(Duration::from_secs))))
            }
            // Trying again does not change it.
            _ => Err(FetchError::Data(format!(
                "{}: the server answers {}; get the file by hand, take it from a --mirror, or try again later",
                response.get_uri(),
                response.status()
            ))),
        }
    }

    /// Refuses an answer that has more bytes than expected, before any is written.
    fn check_size(&self, bytes: u64, announced: Option<u64>) -> Result<()> {
        let (url, limit) = (self.url, self.patience.limit);
        match self.archive.size.or(announced) {
            Some(expected) if bytes > expected => Err(other_size(url, bytes, expected)),
            _ if self.archive.size.is_none() && bytes > limit => Err(FetchError::Data(format!(
                "{url}: more than {limit} bytes, the most that is fetched without a size in datasets/archives.toml"
            ))),
            _ => Ok(()),
        }
    }

    /// Appends a body to the `have` bytes already on disk.
    fn receive(&self, part: &Part, response: &mut Response<Body>, mut have: u64) -> Result<Option<Cut>> {
        let total = part.total.or(self.archive.size);
        let mut file = part.append()?;
        let mut body = response.body_mut().as_reader();
        let mut buffer = vec![0; 1 << 16];
        loop {
            let n = match body.read(&mut buffer) {
                Ok(0) => break,
                Ok(n) => n,
                Err(e) if e.kind() == ErrorKind::Interrupted => continue,
                Err(e) => return Ok(Some((format!("cut after {have} bytes ({e})"), None))),
            };
            self.check_size(have + n as u64, total)?;
            file.write_all(&buffer[..n]).map_err(|e| FetchError::disk(&part.path, e))?;
            have += n as u64;
            (self.watch)(Told::Arrived(have, total));
        }
        let total = total.filter(|total| have < *total);
        Ok(total.map(|total| (format!("cut after {have} of {total} bytes"), None)))
    }
}

fn agent(address: &Uri, patience: &Patience) -> Agent {
    let config = Agent::config_builder()
        .http_status_as_error(false)
        .https_only(address.scheme_str() == Some("https"))
        .max_idle_connections(0)
        .user_agent(concat!("trackfail/", env!("CARGO_PKG_VERSION")))
        .accept_encoding("identity")
        .timeout_resolve(Some(CONNECT))
        .timeout_connect(Some(CONNECT))
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

fn other_size(url: &str, got: u64, expected: u64) -> FetchError {
    FetchError::Data(format!(
        "{url}: {got} bytes, expected are {expected} (by datasets/archives.toml or the server); the file at this \
         address is another one than was pinned, or was cut: try again later or use a --mirror"
    ))
}

fn text(headers: &HeaderMap, name: header::HeaderName) -> Option<String> {
    headers.get(name)?.to_str().ok().map(String::from)
}

/// True if the answer continues the begun file exactly after the first `have` bytes.
fn goes_on(part: &Part, have: u64, headers: &HeaderMap) -> bool {
    let range = text(headers, header::CONTENT_RANGE).unwrap_or_default();
    let rest = range.strip_prefix(&format!("bytes {have}-")).and_then(|rest| rest.split_once('/'));
    let Some((_, total)) = rest else { return false };
    let other_total =
        part.total.zip(total.parse().ok()).is_some_and(|(known, total): (u64, u64)| known != total);
    let mark = part.mark.as_ref().filter(|mark| mark.starts_with('"'));
    let other_mark = mark.zip(text(headers, header::ETAG)).is_some_and(|(mark, etag)| *mark != etag);
    !other_total && !other_mark
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
    fn only_the_rest_of_the_same_file_goes_on() {
        let part = Part { mark: Some("\"1\"".into()), total: Some(1234), ..Part::default() };
        let goes_on = |range: &str, etag: &str| {
            let mut headers = HeaderMap::new();
            headers.insert(header::CONTENT_RANGE, range.parse().unwrap());
            headers.insert(header::ETAG, etag.parse().unwrap());
            goes_on(&part, 42, &headers)
        };
        assert!(goes_on("bytes 42-1233/1234", "\"1\"") && goes_on("bytes 42-1233/*", "\"1\""));
        assert!(!goes_on("bytes 42-1233/1234", "\"2\""));
        let bad = "bytes */1234|bytes 41-1233/1234|bytes 42-1234/1235|items 42-1233/1234|bytes 42-|";
        for bad in bad.split('|') {
            assert!(!goes_on(bad, "\"1\""), "{bad}");
        }
    }
}
