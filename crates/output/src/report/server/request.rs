//! Reads requests and decides what may be shown.
//!
//! A browser on this machine also runs the pages of other sites. These can send requests here, but they cannot read the
//! answers unless a domain name of theirs resolves to this machine: so only requests whose `Host` names this machine are
//! answered. The path of a request is split after `%` is decoded, once; every part must be a plain name, and the file
//! that it leads to, with links followed, must lie below the reports folder.

use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

/// Maximum length of the head of a request, in bytes.
pub const MAX_HEAD: usize = 16 << 10;

/// A request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// Whether only the head of the answer is wanted.
    pub head: bool,
    /// The path as sent, without the query.
    pub path: String,
}

/// Why a request is not answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// Not HTTP as this server understands it.
    #[error("not a request that is understood here")]
    Malformed,
    /// The head is longer than [`MAX_HEAD`].
    #[error("the head of the request is too long")]
    TooLong,
    /// The head did not come in time.
    #[error("the request did not come in time")]
    Slow,
    /// A method that would change something, or that is not known.
    #[error("only GET and HEAD are answered")]
    Method,
    /// `Host` names another machine.
    #[error("ask for localhost or 127.0.0.1")]
    Host,
    /// No such file, or one that is not shown.
    #[error("no such page")]
    Absent,
    /// Too many connections.
    #[error("too many connections; come again")]
    Busy,
}

impl Refusal {
    /// Status of the answer.
    pub fn status(self) -> &'static str {
        match self {
            Self::Malformed => "400 Bad Request",
            Self::TooLong => "431 Request Header Fields Too Large",
            Self::Slow => "408 Request Timeout",
            Self::Method => "405 Method Not Allowed",
            Self::Host => "403 Forbidden",
            Self::Absent => "404 Not Target",
            Self::Busy => "503 Service Unavailable",
        }
    }
}

/// Reads the head of a request.
///
/// # Errors
/// See [`Refusal`].
pub fn read_request(from: &mut impl Read) -> Result<Request, Refusal> {
    let mut bytes = Vec::new();
    let mut piece = [0; 2048];
    let end = loop {
        if let Some(end) = bytes.windows(4).position(|w| w == b"\r\n\r\n") {
            break end;
        }
        if bytes.len() >= MAX_HEAD {
            return Err(Refusal::TooLong);
        }
        match from.read(&mut piece) {
            Ok(0) => return Err(Refusal::Malformed),
            Ok(n) => bytes.extend_from_slice(&piece[..n]),
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) if matches!(e.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {
                return Err(Refusal::Slow);
            }
            Err(_) => return Err(Refusal::Malformed),
        }
    };
    if end > MAX_HEAD {
        return Err(Refusal::TooLong);
    }
    parse(std::str::from_utf8(&bytes[..end]).map_err(|_| Refusal::Malformed)?)
}

fn parse(head: &str) -> Result<Request, Refusal> {
    let mut lines = head.split("\r\n");
    let first: Vec<&str> = lines.next().unwrap_or_default().split(' ').collect();
    let [method, target, "HTTP/1.1" | "HTTP/1.0"] = first[..] else { return Err(Refusal::Malformed) };
    let mut hosts = Vec::new();
    for line in lines {
        // A line that begins with a blank, or has a bare line end in it, could hide a field.
        let (name, value) = line.split_once(':').ok_or(Refusal::Malformed)?;
        let is_name = |b: u8| b.is_ascii_alphanumeric() || b"!#$%&'*+-.^_`|~".contains(&b);
        if name.is_empty() || !name.bytes().all(is_name) || value.contains(['\r', '\n', '\0']) {
            return Err(Refusal::Malformed);
        }
        if name.eq_ignore_ascii_case("host") {
            hosts.push(value.trim_matches([' ', '\t']));
        }
    }
    let [host] = hosts[..] else { return Err(Refusal::Malformed) };
    if !is_this_machine(host) {
        return Err(Refusal::Host);
    }
    let head = match method {
        "GET" => false,
        "HEAD" => true,
        _ => return Err(Refusal::Method),
    };
    let path = target.split(['?', '#']).next().unwrap_or_default();
    if !path.starts_with('/') {
        return Err(Refusal::Malformed);
    }
    Ok(Request { head, path: path.to_string() })
}

/// Whether a `Host` is a name that can only be this machine's. Its port may be that of a tunnel.
fn is_this_machine(host: &str) -> bool {
    let (name, port) = match host.rsplit_once(':') {
        Some((name, port)) if !port.ends_with(']') => (name, Some(port)),
        _ => (host, None),
    };
    let is_port = |p: &str| (1..=5).contains(&p.len()) && p.bytes().all(|b| b.is_ascii_digit());
    let names = ["localhost", "127.0.0.1", "[::1]"];
    port.is_none_or(is_port) && names.iter().any(|known| name.eq_ignore_ascii_case(known))
}

/// Target of a request's path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// The page over all experiments.
    Site,
    /// The progress of runs.
    Progress,
    /// A folder with a page, asked for without a slash at the end: the path with one.
    Folder(String),
    /// A file below the reports folder, links followed.
    File(PathBuf),
}

/// Finds what a path, as sent, leads to.
///
/// # Errors
/// [`Refusal::Absent`] for everything that does not exist or is not shown; the two look the same.
pub fn find(reports: &Path, path: &str) -> Result<Target, Refusal> {
    let decoded = decode(path).ok_or(Refusal::Absent)?;
    let inner = decoded.strip_prefix('/').ok_or(Refusal::Absent)?;
    match inner {
        "" | "index.html" => return Ok(Target::Site),
        "progress.json" => return Ok(Target::Progress),
        _ => {}
    }
    let (inner, slash) = inner.strip_suffix('/').map_or((inner, false), |inner| (inner, true));
    if !inner.split('/').all(is_plain_name) {
        return Err(Refusal::Absent);
    }
    // Links on the way may not lead out of the root.
    let root = reports.canonicalize().map_err(|_| Refusal::Absent)?;
    let inside =
        |path: PathBuf| path.canonicalize().ok().filter(|p| p.starts_with(&root)).ok_or(Refusal::Absent);
    let wanted = inside(inner.split('/').fold(root.clone(), |path, part| path.join(part)))?;
    if !wanted.is_dir() {
        // A link may lead to a file whose name is not shown.
        let shown = wanted.strip_prefix(&root).is_ok_and(is_shown);
        return if wanted.is_file() && !slash && shown {
            Ok(Target::File(wanted))
        } else {
            Err(Refusal::Absent)
        };
    }
    let page = inside(wanted.join("index.html"))?;
    match page.is_file() && page.strip_prefix(&root).is_ok_and(is_shown) {
        true if slash => Ok(Target::File(page)),
        // Only for names without `%`, because the path is sent back as it came.
        true if path == format!("/{inner}") => Ok(Target::Folder(format!("{path}/"))),
        _ => Err(Refusal::Absent),
    }
}

fn is_shown(path: &Path) -> bool {
    path.components().all(|part| part.as_os_str().to_str().is_some_and(is_plain_name))
}

/// Whether a part of a path is a name that is shown: not hidden, and without special meaning to a file system.
fn is_plain_name(name: &str) -> bool {
    let special = |c: char| c.is_control() || "\\:".contains(c);
    !name.is_empty() && !name.starts_with('.') && !name.ends_with(['.', ' ']) && !name.contains(special)
}

/// A path with `%41` decoded, once.
fn decode(path: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(path.len());
    let mut rest = path.bytes();
    while let Some(b) = rest.next() {
        if b != b'%' {
            bytes.push(b);
            continue;
        }
        let mut digit = || char::from(rest.next()?).to_digit(16);
        let (high, low) = (digit()?, digit()?);
        bytes.push(u8::try_from(16 * high + low).ok()?);
    }
    String::from_utf8(bytes).ok()
}

/// Content type of a file, by its name.
pub fn content_type(path: &Path) -> &'static str {
    match path.extension().and_then(|e| e.to_str()).unwrap_or_default() {
        "html" => "text/html; charset=utf-8",
        "md" | "txt" | "tex" => "text/plain; charset=utf-8",
        "csv" => "text/csv; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "json" => "application/json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(text: &str) -> Result<Request, Refusal> {
        read_request(&mut text.as_bytes())
    }

    fn get(path: &str) -> Request {
        Request { head: false, path: path.into() }
    }

    #[test]
    fn requests_are_read_and_refused() {
        assert_eq!(read("GET / HTTP/1.1\r\nHost: localhost:8070\r\n\r\n"), Ok(get("/")));
        assert_eq!(read("GET /a?b=../c HTTP/1.0\r\nA: b\r\nhOsT:\t127.0.0.1 \r\n\r\nrest"), Ok(get("/a")));
        let head = Request { head: true, path: "/%41/".into() };
        assert_eq!(read("HEAD /%41/ HTTP/1.1\r\nHost: [::1]:1\r\n\r\n"), Ok(head));
        for bad in [
            "",
            "GET / HTTP/1.1\r\n\r\n",
            "GET / HTTP/1.1\r\nHost: localhost\r\n",
            "GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n",
            "GET / HTTP/1.1\nHost: localhost\n\n",
            "GET / HTTP/1.1\r\nHost : localhost\r\n\r\n",
            "GET / HTTP/1.1\r\nHost: localhost\r\n folded\r\n\r\n",
            "GET / HTTP/1.1\r\nHost: localhost\r\nA: b\nHost: evil\r\n\r\n",
            "GET / HTTP/2\r\nHost: localhost\r\n\r\n",
            "GET  / HTTP/1.1\r\nHost: localhost\r\n\r\n",
            "GET /a b HTTP/1.1\r\nHost: localhost\r\n\r\n",
            "GET http://localhost/ HTTP/1.1\r\nHost: localhost\r\n\r\n",
            "GET * HTTP/1.1\r\nHost: localhost\r\n\r\n",
            "GET\r\n\r\n",
        ] {
            assert_eq!(read(bad), Err(Refusal::Malformed), "{bad:?}");
        }
        for method in ["POST", "PUT", "DELETE", "OPTIONS", "CONNECT", "get", "TRACE"] {
            let request = format!("{method} / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n");
            assert_eq!(read(&request), Err(Refusal::Method));
        }
        let long = format!("GET / HTTP/1.1\r\nHost: localhost\r\nA: {}\r\n\r\n", "a".repeat(MAX_HEAD));
        assert_eq!(read(&long), Err(Refusal::TooLong));
    }

    #[test]
    fn only_names_of_this_machine_are_accepted_as_host() {
        for host in ["localhost", "LocalHost:80", "127.0.0.1:65535", "[::1]", "[::1]:8070"] {
            assert!(is_this_machine(host), "{host}");
        }
        for host in [
            "",
            ":80",
            "evil.example",
            "localhost.evil.example",
            "evil.example:8070",
            "127.0.0.1.evil.example",
            "127.0.0.2",
            "localhost:",
            "localhost:80:80",
            "localhost:8o",
            "::1",
            "[::1",
            "[::]",
            "0.0.0.0",
            "localhost@evil.example",
            "evil@localhost",
            "localhost.",
            "localhost:123456",
            "localhost evil",
        ] {
            assert!(!is_this_machine(host), "{host}");
        }
    }

    /// A folder with a report beside a folder with a secret.
    fn folders() -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        for (name, text) in [
            ("reports/a/b/index.html", "page"),
            ("reports/a/b/figures/f 1.svg", "<svg/>"),
            ("reports/.trackfail-tmp-x/index.html", "aside"),
            ("reports/a/.hidden", "hidden"),
            ("reports-secret/index.html", "secret"),
            ("secret", "secret"),
        ] {
            let path = root.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        root
    }

    #[test]
    fn files_below_the_folder_are_found() {
        let root = folders();
        let reports = root.path().join("reports");
        let file = |name: &str| Ok(Target::File(reports.canonicalize().unwrap().join(name)));
        assert_eq!(find(&reports, "/"), Ok(Target::Site));
        assert_eq!(find(&reports, "/index%2Ehtml"), Ok(Target::Site));
        assert_eq!(find(&reports, "/progress.json"), Ok(Target::Progress));
        assert_eq!(find(&reports, "/a/b/index.html"), file("a/b/index.html"));
        assert_eq!(find(&reports, "/a/b/"), file("a/b/index.html"));
        assert_eq!(find(&reports, "/a/b"), Ok(Target::Folder("/a/b/".into())));
        assert_eq!(find(&reports, "/a/b/figures/f%201.svg"), file("a/b/figures/f 1.svg"));
        assert_eq!(content_type(Path::new("a/f.svg")), "image/svg+xml");
        assert_eq!(find(&root.path().join("absent"), "/"), Ok(Target::Site));
        assert_eq!(find(&root.path().join("absent"), "/a"), Err(Refusal::Absent));
    }

    #[test]
    fn nothing_outside_or_hidden_is_found() {
        let root = folders();
        let reports = root.path().join("reports");
        let above = [
            "..",
            "%2e%2e",
            "%2E.",
            ".%2e",
            "%252e%252e",
            "..%00",
            "..;",
            "%c0%ae%c0%ae",
            "\u{ff0e}\u{ff0e}",
        ];
        let between = ["/", "%2f", "\\", "%5c", "//", "/./", "%252f"];
        let mut paths: Vec<String> = Vec::new();
        for up in above {
            for slash in between {
                paths.push(format!("/{up}{slash}secret"));
                paths.push(format!("/a{slash}{up}{slash}{up}{slash}secret"));
                paths.push(format!("/a/b/{up}{slash}{up}{slash}{up}{slash}secret"));
                paths.push(format!("/{up}{slash}reports-secret/index.html"));
                paths.push(format!("/{up}{slash}reports-secret/"));
            }
        }
        let whole = root.path().join("secret").display().to_string();
        paths.extend([format!("/{whole}"), format!("//{whole}"), whole.replace('/', "%2f"), whole]);
        let others = [
            "/a",
            "/a/",
            "/a/b/figures",
            "/a/b/figures/",
            "/a/.hidden",
            "/.trackfail-tmp-x/index.html",
            "/a/b/index.html/",
            "/a//b/",
            "/a/./b/",
            "/a/b/index.html%00.png",
            "/C:/a",
            "/a/b/index.html:$DATA",
            "/%",
            "/%4",
            "/%zz",
            "/a/b/%ff",
            "/a/b/figures/f+1.svg",
            "/nothing",
            "//",
            "/.",
            "/..",
            "/%2e",
            "/a/b/index.html.",
            "/a/b/%0d%0aA:%20b",
            "a",
        ];
        paths.extend(others.map(String::from));
        for path in paths {
            assert_eq!(find(&reports, &path), Err(Refusal::Absent), "{path}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_inside_the_folder_are_followed_and_no_others() {
        use std::os::unix::fs::symlink;
        let root = folders();
        let reports = root.path().join("reports");
        symlink("../secret", reports.join("out.txt")).unwrap();
        symlink(root.path().join("reports-secret"), reports.join("outside")).unwrap();
        symlink("../..", reports.join("a/up")).unwrap();
        symlink("b", reports.join("a/same")).unwrap();
        symlink(".hidden", reports.join("a/seen.txt")).unwrap();
        symlink("loop", reports.join("loop")).unwrap();
        std::fs::create_dir(reports.join("page")).unwrap();
        symlink("../../secret", reports.join("page/index.html")).unwrap();
        for path in [
            "/out.txt",
            "/outside/index.html",
            "/outside/",
            "/a/up/secret",
            "/a/up/reports-secret/index.html",
            "/a/seen.txt",
            "/loop",
            "/page/",
            "/page/index.html",
        ] {
            assert_eq!(find(&reports, path), Err(Refusal::Absent), "{path}");
        }
        assert!(matches!(find(&reports, "/a/same/index.html"), Ok(Target::File(_))));
        // The folder itself may be a link.
        symlink("reports", root.path().join("link")).unwrap();
        assert!(matches!(find(&root.path().join("link"), "/a/b/"), Ok(Target::File(_))));
    }

    proptest! {
        #[test]
        fn every_file_found_lies_below_the_folder(path in "/([a-b./%\\\\]|%2e|%2f|%5c|secret|index.html|\\.\\.){0,12}") {
            let root = folders();
            let reports = root.path().join("reports");
            if let Ok(Target::File(found)) = find(&reports, &path) {
                prop_assert!(found.starts_with(reports.canonicalize().unwrap()), "{}", path);
            }
        }

        #[test]
        fn any_bytes_are_read_without_a_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = read_request(&mut &bytes[..]);
        }
    }
}
