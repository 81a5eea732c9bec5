//! The server behind `trackfail serve`: reports, and the progress of runs, for a browser on this machine.
//!
//! A small HTTP/1.1 server on 127.0.0.1 only, which reads and never writes: GET and HEAD of the files below the reports
//! folder, `/` with all experiments and the running ones, `/progress.json` with the running ones. Each connection has a
//! thread, at most [`MAX_CONNECTIONS`] at once, and carries one request, which must be small and come in time.
//!
//! [`request`] decides what may be shown: pages of other sites cannot read it, even through a domain name of theirs that
//! leads to this machine, and no path leads out of the folder.

mod answer;
pub mod request;

use answer::{Answer, ServedFolders, answer};
use request::{Refusal, read_request};
use std::io::{ErrorKind, Read};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Maximum number of connections that are answered at once; further ones are refused as busy.
pub const MAX_CONNECTIONS: usize = 64;
/// Longest wait for a whole request.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(10);
/// Longest wait for the client to take the answer.
const SEND_TIMEOUT: Duration = Duration::from_secs(30);

/// A server that could not be started.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// Neither folder is there.
    #[error(
        "neither {} nor {} is a folder; run an experiment first, or name its --reports and --results",
        reports.display(),
        results.display()
    )]
    NoFolder {
        /// Folder of the reports.
        reports: PathBuf,
        /// Folder of the results.
        results: PathBuf,
    },
    /// The port is not available.
    #[error("port {port} of 127.0.0.1: {source}{}", port_hint(source.kind()))]
    Port {
        /// The port asked for.
        port: u16,
        /// Why the system refuses it.
        source: std::io::Error,
    },
}

/// Advice about a port that is refused.
fn port_hint(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::AddrInUse => "; name another with --port, or --port 0 for one that is free",
        ErrorKind::PermissionDenied => "; take one above 1023 with --port, or --port 0 for one that is free",
        _ => "",
    }
}

/// A server that listens.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    folders: Arc<ServedFolders>,
}

impl Server {
    /// Listens on a port of 127.0.0.1, a free one for 0, to show the reports and results in these folders.
    ///
    /// # Errors
    /// When neither folder is there, or the port is not available.
    pub fn listen(reports: &Path, results: &Path, port: u16) -> Result<Self, ServerError> {
        let (reports, results) = (reports.to_path_buf(), results.to_path_buf());
        if !reports.is_dir() && !results.is_dir() {
            return Err(ServerError::NoFolder { reports, results });
        }
        let refused = |source| ServerError::Port { port, source };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refused)?;
        let address = listener.local_addr().map_err(refused)?;
        Ok(Self { listener, address, folders: Arc::new(ServedFolders { reports, results }) })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Answers requests until the process ends.
    pub fn run(&self) -> ! {
        let open = Arc::new(AtomicUsize::new(0));
        loop {
            match self.listener.accept() {
                Ok((stream, _)) => accept(stream, &self.folders, &open),
                // The connection is gone already, or there are too many open files for a moment.
                Err(_) => std::thread::sleep(Duration::from_millis(20)),
            }
        }
    }
}

/// Counts a connection as long as it is open.
struct OpenConnection(Arc<AtomicUsize>);

impl Drop for OpenConnection {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

fn accept(mut stream: TcpStream, folders: &Arc<ServedFolders>, open: &Arc<AtomicUsize>) {
    let before = open.fetch_add(1, Ordering::Relaxed);
    let counted = OpenConnection(open.clone());
    let _ = stream.set_write_timeout(Some(SEND_TIMEOUT));
    if before >= MAX_CONNECTIONS {
        // The answer fits into the system's buffer, so a client that does not read it delays no other.
        let _ = Answer::refusal(&Refusal::Busy).send(&mut stream, false);
        return;
    }
    let folders = folders.clone();
    // Where no thread can be started the connection is closed, which the client notices.
    let _ = std::thread::Builder::new().name("serve".into()).spawn(move || {
        let _counted = counted;
        // A client that has hung up gets no error message.
        let _ = converse(&mut stream, &folders);
    });
}

/// Reads one request and answers it.
fn converse(stream: &mut TcpStream, folders: &ServedFolders) -> std::io::Result<()> {
    let (answer, with_body) = match read_request(&mut Timed { stream, end: Instant::now() + REQUEST_TIMEOUT })
    {
        Ok(request) => (answer(&request, folders), !request.head),
        Err(refusal) => (Answer::refusal(&refusal), true),
    };
    answer.send(stream, with_body)?;
    // Closing a connection with unread bytes would reset it, and the answer could be lost: the rest is read.
    stream.shutdown(Shutdown::Write)?;
    let mut rest = Timed { stream, end: Instant::now() + Duration::from_secs(1) };
    std::io::copy(&mut (&mut rest).take(1 << 20), &mut std::io::sink()).map(|_| ())
}

/// Reads until a point in time, however slowly the client sends.
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
