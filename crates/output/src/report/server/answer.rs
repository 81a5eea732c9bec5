//! Answers to a client.

use super::request::{self, Refusal, Request, Target, find};
use crate::report::site;
use std::fs::File;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use trackfail_engine::observe::progress;

/// The folders that are shown.
#[derive(Debug)]
pub struct ServedFolders {
    /// Folder of the reports.
    pub reports: PathBuf,
    /// Folder of the results.
    pub results: PathBuf,
}

/// An answer to a request.
pub struct Answer {
    status: &'static str,
    content_type: &'static str,
    fields: Vec<(&'static str, String)>,
    body: Body,
}

enum Body {
    Text(String),
    File(File, u64),
}

/// Content security policy of a page: it may load files beside it, and what it has in itself.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:; script-src 'self' \
    'unsafe-inline'; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
/// Content security policy of any other file, which shows itself and does nothing.
const SANDBOX: &str =
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'; sandbox";

impl Answer {
    fn text(status: &'static str, content_type: &'static str, text: String) -> Self {
        Self { status, content_type, fields: Vec::new(), body: Body::Text(text) }
    }

    /// The answer to a request that is refused.
    pub fn refusal(refusal: &Refusal) -> Self {
        let mut answer = Self::text(refusal.status(), "text/plain; charset=utf-8", format!("{refusal}\n"));
        if *refusal == Refusal::Method {
            answer.fields.push(("Allow", "GET, HEAD".into()));
        }
        answer
    }

    /// Sends the answer; its body only where `with_body`.
    ///
    /// # Errors
    /// When the client has hung up or does not take it in time.
    pub fn send(self, stream: &mut TcpStream, with_body: bool) -> std::io::Result<()> {
        let length = match &self.body {
            Body::Text(text) => text.len() as u64,
            Body::File(_, length) => *length,
        };
        let policy = if self.content_type.starts_with("text/html") { POLICY } else { SANDBOX };
        let mut head = format!(
            "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {length}\r\nConnection: close\r\nCache-Control: \
             no-cache\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
             Cross-Origin-Resource-Policy: same-origin\r\nContent-Security-Policy: {policy}\r\n",
            self.status, self.content_type
        );
        for (name, value) in &self.fields {
            head.push_str(&format!("{name}: {value}\r\n"));
        }
        head.push_str("\r\n");
        stream.write_all(head.as_bytes())?;
        match self.body {
            _ if !with_body => Ok(()),
            Body::Text(text) => stream.write_all(text.as_bytes()),
            // A file that has become longer meanwhile is cut; one that has become shorter ends the connection early.
            Body::File(file, length) => std::io::copy(&mut file.take(length), stream).map(|_| ()),
        }
    }
}

/// The answer to a request.
pub fn answer(request: &Request, folders: &ServedFolders) -> Answer {
    let failed = |e: &dyn std::fmt::Display| {
        Answer::text("500 Internal Server Error", "text/plain; charset=utf-8", format!("{e}\n"))
    };
    match find(&folders.reports, &request.path) {
        Ok(Target::Site) => {
            let (reports, running) = (site::collect(&folders.reports), progress::running(&folders.results));
            match site::render_live(&reports, &running, progress::clock()) {
                Ok(page) => Answer::text("200 OK", "text/html; charset=utf-8", page),
                Err(e) => failed(&e),
            }
        }
        Ok(Target::Progress) => match serde_json::to_string_pretty(&progress::running(&folders.results)) {
            Ok(text) => Answer::text("200 OK", "application/json", text + "\n"),
            Err(e) => failed(&e),
        },
        Ok(Target::Folder(path)) => {
            let mut answer =
                Answer::text("308 Permanent Redirect", "text/plain; charset=utf-8", String::new());
            answer.fields.push(("Location", path));
            answer
        }
        Ok(Target::File(path)) => match open(&path) {
            Some((file, length)) => {
                let (content_type, body) = (request::content_type(&path), Body::File(file, length));
                Answer { status: "200 OK", content_type, fields: Vec::new(), body }
            }
            None => Answer::refusal(&Refusal::Absent),
        },
        Err(refusal) => Answer::refusal(&refusal),
    }
}

/// A file and its length; none for anything but a file.
fn open(path: &Path) -> Option<(File, u64)> {
    // Opening a pipe would wait for its writer.
    if !path.symlink_metadata().ok()?.is_file() {
        return None;
    }
    let file = File::open(path).ok()?;
    let about = file.metadata().ok().filter(std::fs::Metadata::is_file)?;
    Some((file, about.len()))
}
