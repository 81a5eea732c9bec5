//! `trackfail serve`: reports, and what runs are at, in a browser on this machine.
//!
//! A small HTTP/1.1 server on 127.0.0.1 and nowhere else, that reads and never writes: GET and HEAD of the files below the
//! reports folder, `/` with all experiments and the runs that go on, `/progress.json` with these runs. One thread a
//! connection, at most [`MOST_CONNECTIONS`]; one request a connection, small and in time, see [`request`].
//!
//! What it may show is decided in [`request`]: pages of other sites cannot read it, even by a name of theirs that leads
//! here, and no path leads out of the folder.

pub mod request;

use super::{Failure, output};
use crate::engine::observe::progress;
use crate::report::site;
use request::{Found, Refusal, Request, find, read_request};
use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// The port unless another is asked for.
pub const PORT: u16 = 8070;
/// Connections that are answered at once; further ones are told to come again.
pub const MOST_CONNECTIONS: usize = 64;
/// Longest wait for a whole request.
const PATIENCE: Duration = Duration::from_secs(10);
/// Longest wait for the other side to take what it asked for.
const SENDING: Duration = Duration::from_secs(30);

/// Arguments of `serve`.
#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "Only programs on this machine can ask (127.0.0.1); from elsewhere, use a tunnel such as \
ssh -L 8070:127.0.0.1:8070 HOST. Nothing is written. Ctrl-C ends it, with exit code 0."
)]
pub struct Args {
    /// Folder of reports that is shown
    #[arg(long, value_name = "DIR", default_value = "reports")]
    reports: PathBuf,
    /// Results folder whose runs are shown while they go on
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Port on 127.0.0.1; 0 takes a free one
    #[arg(long, value_name = "N", default_value_t = PORT)]
    port: u16,
}

/// What is shown.
#[derive(Debug, Clone)]
struct Shown {
    reports: PathBuf,
    results: PathBuf,
}

/// Runs the verb, until Ctrl-C.
///
/// # Errors
/// `Usage` when neither folder is there, `Io` when the port cannot be had.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (reports, results) = (&args.reports, &args.results);
    if !reports.is_dir() && !results.is_dir() {
        let message = format!(
            "neither {} nor {} is a folder; run an experiment first, or name its --reports and --results",
            reports.display(),
            results.display()
        );
        return Err(Failure::Usage(message));
    }
    let listener = listen(args.port)?;
    let address = listener.local_addr().map_err(|e| Failure::Io(e.to_string()))?;
    // It ends like this and has nothing to lose. Without a handler the signals end the program as well.
    let _ = ctrlc::set_handler(|| std::process::exit(0));
    output::write(&format!("http://{address}/\n"))?;
    output::note("Ctrl-C ends it");
    let shown = Arc::new(Shown { reports: reports.clone(), results: results.clone() });
    let open = Arc::new(AtomicUsize::new(0));
    loop {
        match listener.accept() {
            Ok((stream, _)) => accept(stream, &shown, &open),
            // Of a connection that is gone already, or when files run out for a moment.
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
    }
}

fn listen(port: u16) -> Result<TcpListener, Failure> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|e| {
        let hint = match e.kind() {
            ErrorKind::AddrInUse => "; name another with --port, or --port 0 for one that is free",
            ErrorKind::PermissionDenied => {
                "; take one above 1023 with --port, or --port 0 for one that is free"
            }
            _ => "",
        };
        Failure::Io(format!("port {port} of 127.0.0.1: {e}{hint}"))
    })
}

/// Counts a connection as long as it is open.
struct Open(Arc<AtomicUsize>);

impl Drop for Open {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

fn accept(mut stream: TcpStream, shown: &Arc<Shown>, open: &Arc<AtomicUsize>) {
    let before = open.fetch_add(1, Ordering::Relaxed);
    let counted = Open(open.clone());
    let _ = stream.set_write_timeout(Some(SENDING));
    if before >= MOST_CONNECTIONS {
        // This fits into what the system takes at once, so nobody can make the others wait.
        let _ = Answer::refusal(&Refusal::Busy).send(&mut stream, false);
        return;
    }
    let shown = shown.clone();
    // Without a thread the connection is closed, which the other side notices.
    let _ = std::thread::Builder::new().name("serve".into()).spawn(move || {
        let _counted = counted;
        // Who hangs up is nobody to tell.
        let _ = serve(&mut stream, &shown);
    });
}

fn serve(stream: &mut TcpStream, shown: &Shown) -> std::io::Result<()> {
    let (answer, whole) = match read_request(&mut Timed { stream, end: Instant::now() + PATIENCE }) {
        Ok(request) => (answer(&request, shown), !request.head),
        Err(refusal) => (Answer::refusal(&refusal), true),
    };
    answer.send(stream, whole)?;
    // What was sent arrives only if nothing that was not read is left behind.
    stream.shutdown(Shutdown::Write)?;
    let mut rest = Timed { stream, end: Instant::now() + Duration::from_secs(1) };
    std::io::copy(&mut (&mut rest).take(1 << 20), &mut std::io::sink()).map(|_| ())
}

/// Reads until a point in time, however slowly the other side sends.
struct Timed<'s> {
    stream: &'s mut TcpStream,
    end: Instant,
}

impl Read for Timed<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let left = self.end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        self.stream.set_read_timeout(Some(left))?;
        self.stream.read(buffer)
    }
}

/// What is sent back.
struct Answer {
    status: &'static str,
    kind: &'static str,
    fields: Vec<(&'static str, String)>,
    body: Body,
}

enum Body {
    Text(String),
    File(File, u64),
}

/// What a page that is served may load: files beside it, and what it has in itself.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:; script-src 'self' \
    'unsafe-inline'; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
/// Any other file shows itself and does nothing.
const SANDBOX: &str =
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'; sandbox";

impl Answer {
    fn text(status: &'static str, kind: &'static str, text: String) -> Self {
        Self { status, kind, fields: Vec::new(), body: Body::Text(text) }
    }

    fn refusal(refusal: &Refusal) -> Self {
        let mut answer = Self::text(refusal.status(), "text/plain; charset=utf-8", format!("{refusal}\n"));
        if *refusal == Refusal::Method {
            answer.fields.push(("Allow", "GET, HEAD".into()));
        }
        answer
    }

    fn send(self, stream: &mut TcpStream, whole: bool) -> std::io::Result<()> {
        let length = match &self.body {
            Body::Text(text) => text.len() as u64,
            Body::File(_, length) => *length,
        };
        let policy = if self.kind.starts_with("text/html") { POLICY } else { SANDBOX };
        let mut head = format!(
            "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {length}\r\nConnection: close\r\nCache-Control: \
             no-cache\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
             Cross-Origin-Resource-Policy: same-origin\r\nContent-Security-Policy: {policy}\r\n",
            self.status, self.kind
        );
        for (name, value) in &self.fields {
            head.push_str(&format!("{name}: {value}\r\n"));
        }
        head.push_str("\r\n");
        stream.write_all(head.as_bytes())?;
        match self.body {
            _ if !whole => Ok(()),
            Body::Text(text) => stream.write_all(text.as_bytes()),
            // A file that has become longer meanwhile is cut; one that has become shorter ends the connection early.
            Body::File(file, length) => std::io::copy(&mut file.take(length), stream).map(|_| ()),
        }
    }
}

fn answer(request: &Request, shown: &Shown) -> Answer {
    let failed = |e: &dyn std::fmt::Display| {
        Answer::text("500 Internal Server Error", "text/plain; charset=utf-8", format!("{e}\n"))
    };
    match find(&shown.reports, &request.path) {
        Ok(Found::Site) => {
            let (reports, running) = (site::collect(&shown.reports), progress::running(&shown.results));
            match site::render_live(&reports, &running, progress::clock()) {
                Ok(page) => Answer::text("200 OK", "text/html; charset=utf-8", page),
                Err(e) => failed(&e),
            }
        }
        Ok(Found::Progress) => match serde_json::to_string_pretty(&progress::running(&shown.results)) {
            Ok(text) => Answer::text("200 OK", "application/json", text + "\n"),
            Err(e) => failed(&e),
        },
        Ok(Found::Folder(path)) => {
            let mut answer =
                Answer::text("308 Permanent Redirect", "text/plain; charset=utf-8", String::new());
            answer.fields.push(("Location", path));
            answer
        }
        Ok(Found::File(path)) => match open(&path) {
            Some((file, length)) => {
                let (kind, body) = (request::kind(&path), Body::File(file, length));
                Answer { status: "200 OK", kind, fields: Vec::new(), body }
            }
            None => Answer::refusal(&Refusal::Absent),
        },
        Err(refusal) => Answer::refusal(&refusal),
    }
}

fn open(path: &Path) -> Option<(File, u64)> {
    // A pipe would be waited for.
    if !path.symlink_metadata().ok()?.is_file() {
        return None;
    }
    let file = File::open(path).ok()?;
    let about = file.metadata().ok().filter(std::fs::Metadata::is_file)?;
    Some((file, about.len()))
}
