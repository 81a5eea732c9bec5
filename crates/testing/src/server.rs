//! A server on this machine that answers as a test asks for, and records the requests.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// A request; names of header fields are in lower case.
#[derive(Debug, Clone)]
pub struct Request {
    /// Its path, with what follows a `?`.
    pub path: String,
    /// Its header fields.
    pub headers: BTreeMap<String, String>,
}

impl Request {
    /// Index of the first byte that is asked for.
    pub fn from(&self) -> Option<usize> {
        self.headers.get("range")?.strip_prefix("bytes=")?.strip_suffix('-')?.parse().ok()
    }
}

/// A step of a server's answer; after the last one the connection is closed.
#[derive(Debug, Clone)]
pub enum Step {
    /// Sends bytes.
    Send(Vec<u8>),
    /// Waits for so many milliseconds.
    Pause(u64),
    /// Waits until the client hangs up.
    Stall,
}

/// The server; it goes on until the program ends.
pub struct Server {
    /// Its address without a path.
    pub url: String,
    asked: Arc<Mutex<Vec<Request>>>,
}

impl Server {
    /// `answer` gets the number of the request, from 0, and the request.
    pub fn new(answer: impl Fn(usize, &Request) -> Vec<Step> + Send + Sync + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let url = format!("http://{}", listener.local_addr().expect("an address"));
        let asked = Arc::new(Mutex::new(Vec::new()));
        let (answer, log) = (Arc::new(answer), asked.clone());
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (answer, log) = (answer.clone(), log.clone());
                // A client that has hung up is part of many tests.
                std::thread::spawn(move || serve(stream, &*answer, &log).unwrap_or_default());
            }
        });
        Self { url, asked }
    }

    /// Gives the same answer to all requests.
    pub fn always(answer: Vec<Step>) -> Self {
        Self::new(move |_, _| answer.clone())
    }

    /// Serves one file, with ranges, under an ETag.
    pub fn file(body: Vec<u8>, etag: &str) -> Self {
        let etag = etag.to_owned();
        Self::new(move |_, request| file(request, &body, &etag))
    }

    /// The requests so far.
    pub fn asked(&self) -> Vec<Request> {
        self.asked.lock().expect("no panic").clone()
    }

    /// Indices of the first bytes that were asked for.
    pub fn asked_from(&self) -> Vec<Option<usize>> {
        self.asked().iter().map(Request::from).collect()
    }

    /// Address of the archive that tests fetch.
    pub fn archive(&self) -> String {
        format!("{}/a.zip", self.url)
    }
}

fn serve(
    stream: TcpStream,
    answer: &dyn Fn(usize, &Request) -> Vec<Step>,
    log: &Mutex<Vec<Request>>,
) -> std::io::Result<()> {
    let mut reader = BufReader::new(stream.try_clone()?);
    let lines = reader.by_ref().lines().map_while(Result::ok).take_while(|line| !line.is_empty());
    let lines: Vec<String> = lines.collect();
    let field = |line: &String| line.split_once(": ").map(|(k, v)| (k.to_lowercase(), v.to_owned()));
    let path = lines.first().and_then(|l| l.split(' ').nth(1)).unwrap_or_default().to_owned();
    let request = Request { path, headers: lines.iter().skip(1).filter_map(field).collect() };
    let number = {
        let mut log = log.lock().expect("no panic");
        log.push(request.clone());
        log.len() - 1
    };
    let mut out = stream;
    for step in answer(number, &request) {
        match step {
            Step::Send(bytes) => out.write_all(&bytes)?,
            Step::Pause(milliseconds) => std::thread::sleep(Duration::from_millis(milliseconds)),
            Step::Stall => drop(reader.read_to_end(&mut Vec::new())?),
        }
    }
    Ok(())
}

/// The head of an answer.
pub fn head(status: &str, fields: &[(&str, &str)]) -> Step {
    let fields: String = fields.iter().map(|(k, v)| format!("{k}: {v}\r\n")).collect();
    Step::Send(format!("HTTP/1.1 {status}\r\nConnection: close\r\n{fields}\r\n").into_bytes())
}

/// A whole answer.
pub fn full(status: &str, fields: &[(&str, &str)], body: &[u8]) -> Vec<Step> {
    let length = body.len().to_string();
    let fields: Vec<_> = fields.iter().copied().chain([("Content-Length", length.as_str())]).collect();
    vec![head(status, &fields), Step::Send(body.to_vec())]
}

/// The answer of a correct server for a file.
pub fn file(request: &Request, body: &[u8], etag: &str) -> Vec<Step> {
    let same = request.headers.get("if-range").is_none_or(|mark| mark == etag);
    match request.from() {
        Some(first) if same && first >= body.len() => {
            full("416 Range Not Satisfiable", &[("Content-Range", &format!("bytes */{}", body.len()))], b"")
        }
        Some(first) if same => {
            let range = format!("bytes {first}-{}/{}", body.len() - 1, body.len());
            full("206 Partial Content", &[("Content-Range", &range), ("ETag", etag)], &body[first..])
        }
        _ => full("200 OK", &[("ETag", etag)], body),
    }
}
