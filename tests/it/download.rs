//! Downloads that are interrupted, changed, refused or slow.

use crate::fetch::{arrives, job, job_of, nothing_left, options, run, sample, sha256, whole};
use crate::tools::files;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;
use trackfail::dataset::archive::Packing;
use trackfail::dataset::fetch::{FetchError, FetchJob, FetchOptions};
use trackfail_testing::put;
use trackfail_testing::server::{Server, Step, file, full, head};

fn download(root: &Path) -> (PathBuf, PathBuf) {
    let folder = root.join(".trackfail/downloads");
    (folder.join("try.part"), folder.join("try.json"))
}

/// A part of `bytes` from `server`, as a fetch leaves it that is killed.
fn leave(root: &Path, server: &Server, bytes: &[u8], etag: &str) {
    let (part, note) = download(root);
    put(root, part, bytes);
    let mark = if etag.is_empty() { "null".to_owned() } else { format!("{etag:?}") };
    put(root, note, format!(r#"{{"url":"{}","mark":{mark},"total":null}}"#, server.archive()));
}

#[track_caller]
pub fn fails(server: &Server, change: impl Fn(&mut FetchJob, &mut FetchOptions)) -> (FetchError, TempDir) {
    let root = tempfile::tempdir().unwrap();
    let (mut job, mut options) = (job_of(server), options());
    change(&mut job, &mut options);
    (run(root.path(), &job, &options).unwrap_err(), root)
}

/// Fails for good, with these words, and leaves nothing.
#[track_caller]
fn refused(server: &Server, change: impl Fn(&mut FetchJob, &mut FetchOptions), words: &str) {
    let (error, root) = fails(server, change);
    assert!(error.is_data() && error.to_string().contains(words), "{error}");
    nothing_left(root.path());
}

/// Bytes behind a head of an answer.
fn part(status: &str, fields: &[(&str, &str)], bytes: &[u8]) -> Vec<Step> {
    vec![head(status, fields), Step::Send(bytes.to_vec())]
}

/// The bytes of the sample behind a head of an answer.
fn behind(fields: &[(&str, &str)]) -> Vec<Step> {
    part("200 OK", fields, &sample())
}

#[test]
fn a_cut_download_goes_on_where_it_was_cut() {
    let root = tempfile::tempdir().unwrap();
    let body = sample();
    let server = Server::new(move |n, request| match n {
        0 => part("200 OK", &[("Content-Length", "5262"), ("ETag", "\"1\"")], &body[..999]),
        1 => {
            let range = format!("bytes 999-{}/{}", body.len() - 1, body.len());
            part("206 Partial Content", &[("Content-Range", &range)], &body[999..2000])
        }
        _ => file(request, &body, "\"1\""),
    });
    assert_eq!(sample().len(), 5262);
    arrives(root.path(), &server);
    assert_eq!(server.asked_from(), [None, Some(999), Some(2000)]);
    assert_eq!(server.asked()[2].headers["if-range"], "\"1\"");
}

/// Each case has the bytes that a kill left, the mark of the file then, true if its digest is pinned, and the byte from which
/// the next fetch asks.
#[test]
fn the_next_fetch_goes_on_after_a_kill() {
    let (start, all) = (sample()[..1234].to_vec(), sample());
    let old = b"of the old file".to_vec();
    let longer = [all.as_slice(), b"more"].concat();
    let of = |etag: &str| Server::file(sample(), etag);
    let without_ranges = Server::always(full("200 OK", &[("Last-Modified", "yesterday")], &sample()));
    for (server, left, mark, is_pinned, asked) in [
        (of("\"1\""), &start, "\"1\"", false, &[Some(1234_usize)][..]),
        (without_ranges, &start, "\"1\"", false, &[Some(1234)]),
        // Asked on condition, the server sends the whole new file.
        (of("\"2\""), &old, "\"1\"", false, &[Some(15)]),
        // A part without a mark goes on only towards a digest.
        (of("\"1\""), &start, "", false, &[None]),
        (of("\"1\""), &start, "", true, &[Some(1234)]),
        (of("\"1\""), &all, "\"1\"", false, &[Some(5262), None]),
        (of("\"1\""), &longer, "\"1\"", false, &[Some(5266), None]),
    ] {
        let root = tempfile::tempdir().unwrap();
        leave(root.path(), &server, left, mark);
        let mut job = job_of(&server);
        job.archive.sha256 = is_pinned.then(|| sha256(&sample()).to_uppercase());
        run(root.path(), &job, &options()).unwrap();
        whole(root.path());
        assert_eq!(server.asked_from(), asked, "{mark} {is_pinned}");
    }
}

// A server that takes no notice of the condition gives itself away by its ETag or its range.
#[test]
fn a_file_that_changed_meanwhile_is_not_glued() {
    for (field, left) in [(("ETag", "\"2\""), &b"the old"[..]), (("X", ""), b"of the old file")] {
        let root = tempfile::tempdir().unwrap();
        let server = Server::new(move |n, request| match n {
            0 => full("206 Partial Content", &[("Content-Range", "bytes 7-9/99"), field], b"new"),
            _ => file(request, &sample(), "\"2\""),
        });
        leave(root.path(), &server, left, "\"1\"");
        arrives(root.path(), &server);
        assert_eq!(server.asked_from()[1..], [None]);
    }
}

#[test]
fn a_download_that_was_whole_before_the_kill_is_not_asked_for_again() {
    let root = tempfile::tempdir().unwrap();
    let server = Server::file(sample(), "\"1\"");
    // A disk that refuses is no reason to drop the download.
    let in_the_way = put(root.path(), "otb", "a file");
    assert!(matches!(run(root.path(), &job_of(&server), &options()), Err(FetchError::Disk { .. })));
    assert!(download(root.path()).0.is_file());
    std::fs::remove_file(in_the_way).unwrap();
    arrives(root.path(), &server);
    assert_eq!(server.asked().len(), 1);
}

#[test]
fn a_file_that_is_not_the_wanted_one_is_refused() {
    let (server, pinned) = (Server::file(sample(), "\"1\""), "0".repeat(64));
    for words in [&pinned, &sha256(&sample())] {
        refused(&server, |job, _| job.archive.sha256 = Some(pinned.clone()), words);
    }
    // Before it is downloaded.
    refused(&server, |job, _| job.archive.size = Some(7), "5262 bytes, expected are 7 ");
    refused(&Server::always(full("200 OK", &[], b"\n<!DOCTYPE html>\n<p>Log in")), |_, _| {}, "a web page");
    // Shorter than it is: what is left out is missing in the archive.
    refused(&Server::always(behind(&[("Content-Length", "5000")])), |_, _| {}, "not a whole zip file");
    // Without a Content-Length it shows when the bytes come.
    let server_without = Server::always(behind(&[]));
    let (error, root) = fails(&server_without, |job, _| job.archive.size = Some(7));
    assert!(error.is_data() && error.to_string().contains("expected are 7 "), "{error}");
    assert!(files(root.path()).values().all(|b| b.len() <= 200));
    for server in [&server_without, &server] {
        let (error, _) = fails(server, |_, options| options.patience.limit = 5000);
        assert!(error.is_data() && error.to_string().contains("more than 5000 bytes"), "{error}");
    }
}

#[test]
fn chunks_are_put_together_and_a_missing_last_one_is_noticed() {
    let root = tempfile::tempdir().unwrap();
    let server = Server::new(move |n, _| {
        let mut steps = vec![head("200 OK", &[("Transfer-Encoding", "chunked")])];
        for chunk in sample().chunks(1000).take(if n == 0 { 3 } else { 9 }) {
            steps.push(Step::Send([format!("{:x}\r\n", chunk.len()).as_bytes(), chunk, b"\r\n"].concat()));
        }
        if n > 0 {
            steps.push(Step::Send(b"0\r\n\r\n".to_vec()));
        }
        steps
    });
    arrives(root.path(), &server);
    assert_eq!(server.asked().len(), 2);
    // An answer may also end with the connection.
    arrives(tempfile::tempdir().unwrap().path(), &Server::always(behind(&[])));
    // In drops, with pauses.
    let length = sample().len().to_string();
    let mut drops = vec![head("200 OK", &[("Content-Length", &length)])];
    for drop in sample().chunks(500) {
        drops.extend([Step::Pause(2), Step::Send(drop.to_vec())]);
    }
    arrives(tempfile::tempdir().unwrap().path(), &Server::always(drops));
}

#[test]
fn a_stall_is_an_error_after_a_while_and_what_came_is_kept() {
    let server = Server::new(move |_, request| {
        let mut steps = file(request, &sample(), "\"1\"");
        let Some(Step::Send(body)) = steps.last_mut() else { panic!("no body") };
        body.truncate(800);
        steps.push(Step::Stall);
        steps
    });
    let (error, root) = fails(&server, |_, options| options.patience.stall = Duration::from_millis(200));
    let kept = std::fs::metadata(download(root.path()).0).unwrap().len();
    let words = format!("{kept} bytes have arrived and are kept");
    assert!(matches!(error, FetchError::Network(_)) && error.to_string().contains(&words), "{error}");
    assert!(kept > 500 && error.to_string().contains("attempt 4") && !error.is_data(), "{error}");
    // No answer at all, and one that is longer than it ever comes.
    let stall = Server::always(vec![Step::Stall]);
    let long = Server::always(behind(&[("Content-Length", "9999")]));
    for server in [&stall, &long] {
        let (error, _) = fails(server, |_, options| options.patience.stall = Duration::from_millis(100));
        assert!(matches!(error, FetchError::Network(_)), "{error}");
    }
    assert_eq!(long.asked().len(), 4);
}

#[test]
fn busy_servers_are_asked_again_and_others_are_not() {
    for status in ["500 Oops", "503 Busy", "429 Too Many Requests", "408 Timeout"] {
        let root = tempfile::tempdir().unwrap();
        let server = Server::new(move |n, request| match n {
            0 => full(status, &[("Retry-After", "0")], b"wait"),
            1 => full(status, &[("Retry-After", "Fri, 31 Dec 1999 23:59:59 GMT")], b"wait"),
            _ => file(request, &sample(), "\"1\""),
        });
        arrives(root.path(), &server);
        assert_eq!(server.asked().len(), 3, "{status}");
    }
    for status in ["404 No", "403 No", "410 Gone", "401 Who", "204 Nothing", "304 Same", "206 Part"] {
        let server = Server::always(full(status, &[], b""));
        let (error, root) = fails(&server, |_, _| {});
        assert!(error.is_data() && error.to_string().contains(&status[..3]), "{error}");
        assert!(error.to_string().contains("--mirror"), "{error}");
        assert_eq!(server.asked().len(), 1, "{status}");
        nothing_left(root.path());
    }
    // A longer pause than the longest is not kept.
    for (status, pause, words) in [("500 Oops", "0", "0 bytes have"), ("429 No", "86400", "answers 429")] {
        let (error, _) = fails(&Server::always(full(status, &[("Retry-After", pause)], b"")), |_, _| {});
        let text = error.to_string();
        assert!(text.contains("(attempt 4, then given up)") && text.contains(words), "{text}");
    }
}

#[test]
fn redirects_are_followed_to_http_only_and_not_for_ever() {
    let root = tempfile::tempdir().unwrap();
    let server = Server::new(move |_, request| match request.path.as_str() {
        "/a.zip" => full("302 Found", &[("Location", "/b/c.zip")], b"there"),
        "/b/c.zip" => full("308 Moved", &[("Location", "d.zip?x")], b""),
        "/b/d.zip?x" => file(request, &sample(), "\"1\""),
        _ => Vec::new(),
    });
    leave(root.path(), &server, &sample()[..100], "\"1\"");
    arrives(root.path(), &server);
    assert!(server.asked().iter().all(|r| r.from() == Some(100)), "the range goes along");
    for to in ["file:///etc/passwd", "ftp://127.0.0.1/a.zip", "gopher:x", "http://", "//", ""] {
        let server = Server::always(full("301 Moved", &[("Location", to)], b""));
        refused(&server, |_, _| {}, "a redirect");
        assert!(server.asked().len() <= 11, "{to}");
    }
    let server = Server::always(full("307 Round", &[("Location", "/a.zip")], b""));
    refused(&server, |_, _| {}, "a redirect");
    assert_eq!(server.asked().len(), 11);
}

#[test]
fn without_a_network_it_says_so() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/a.zip", listener.local_addr().unwrap());
    drop(listener);
    let root = tempfile::tempdir().unwrap();
    let error = run(root.path(), &job(&url, Packing::Zip), &options()).unwrap_err();
    assert!(!error.is_data() && error.to_string().contains("Is this machine online"), "{error}");
    // A mirror is asked instead.
    let server = Server::file(sample(), "\"1\"");
    let options = FetchOptions { mirror: Some(format!("{}/copy/", server.url)), ..options() };
    run(root.path(), &job("http://nowhere.invalid/seq/a.zip", Packing::Zip), &options).unwrap();
    whole(root.path());
    assert_eq!(server.asked()[0].path, "/copy/a.zip");
}
