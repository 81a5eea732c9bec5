//! The page over all reports, and `trackfail serve`: what it shows, and what it refuses to show.

#[path = "../tools/serve.rs"]
mod helpers;

use crate::tools::trackfail;
use helpers::{Server, small};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};
use trackfail::engine::observe::progress::{self, ProgressWatch};
use trackfail::report::site;
use trackfail::spec;

fn run(root: &Path, name: &str, title: &str) {
    std::fs::write(root.join("a.toml"), small(name, title)).unwrap();
    let done = trackfail().current_dir(root).args(["run", "a.toml", "--quiet"]).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

impl Server {
    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream
    }

    /// Sends bytes; returns the head and the body of the answer.
    fn send(&self, bytes: &[u8]) -> (String, Vec<u8>) {
        let mut stream = self.connect();
        stream.write_all(bytes).unwrap();
        let mut all = Vec::new();
        stream.read_to_end(&mut all).unwrap();
        let end = all.windows(4).position(|w| w == b"\r\n\r\n").expect("an answer with a head");
        (String::from_utf8(all[..end].to_vec()).unwrap(), all[end + 4..].to_vec())
    }

    fn ask(&self, method: &str, path: &str, host: &str) -> (String, Vec<u8>) {
        self.send(format!("{method} {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes())
    }

    fn get(&self, path: &str) -> (String, Vec<u8>) {
        self.ask("GET", path, &format!("127.0.0.1:{}", self.port))
    }

    fn page(&self, path: &str) -> String {
        let (head, body) = self.get(path);
        assert!(head.starts_with("HTTP/1.1 200 OK\r\n"), "{path}: {head}");
        // A slash is escaped too.
        String::from_utf8(body).unwrap().replace("&#x2f;", "/")
    }

    fn status(&self, path: &str) -> String {
        self.get(path).0.split(' ').nth(1).unwrap_or_default().to_string()
    }
}

#[test]
fn only_reports_are_served() {
    let root = tempfile::tempdir().unwrap();
    run(root.path(), "mine/a", "A <b>first</b> one");
    let reports = root.path().join("reports");
    for (name, text) in [("secret.txt", "a secret"), ("reports-2/index.html", "a secret")] {
        let path = root.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    std::fs::write(reports.join(".hidden.txt"), "a secret").unwrap();
    std::fs::write(reports.join("table.csv"), "a,b\n").unwrap();
    std::os::unix::fs::symlink("../secret.txt", reports.join("link.txt")).unwrap();
    std::os::unix::fs::symlink("../../", reports.join("mine/up")).unwrap();
    let server = Server::start(root.path());

    files_have_their_types(&server, &reports);
    nothing_outside_is_served(&server, root.path());
    requests_of_other_hosts_are_refused(&server);

    // Clients that send nothing do not delay others.
    let silent: Vec<TcpStream> = (0..20).map(|_| server.connect()).collect();
    assert_eq!(server.status("/mine/a/"), "200");
    drop(silent);
}

/// Pages and files are served with their content types.
fn files_have_their_types(server: &Server, reports: &Path) {
    let site = server.page("/");
    assert!(site.contains("A &lt;b&gt;first&lt;/b&gt; one") && site.contains("No experiment is running"));
    assert_eq!(site.matches("<script").count(), 1);
    let file = |name: &str| std::fs::read(reports.join(name)).unwrap();
    for (path, name, kind) in [
        ("/mine/a/index.html?x=../y", "mine/a/index.html", "text/html; charset=utf-8"),
        ("/mine/a/", "mine/a/index.html", "text/html; charset=utf-8"),
        ("/mine/a/report.md", "mine/a/report.md", "text/plain; charset=utf-8"),
        ("/mine/a/%73ummary.json", "mine/a/summary.json", "application/json"),
        ("/table.csv", "table.csv", "text/csv; charset=utf-8"),
    ] {
        let (head, body) = server.get(path);
        assert!(head.starts_with("HTTP/1.1 200 OK\r\n"), "{path}: {head}");
        assert!(body == file(name), "{path}");
        let fields =
            [&format!("Content-Type: {kind}"), "X-Content-Type-Options: nosniff", "Connection: close"];
        assert!(fields.iter().all(|field| head.lines().any(|line| line == *field)), "{head}");
        assert!(head.contains(&format!("Content-Length: {}", body.len())), "{head}");
        let (only, nothing) = server.ask("HEAD", path, "localhost");
        assert_eq!((only, nothing), (head, Vec::new()));
    }
    let (head, _) = server.get("/mine/a");
    assert!(
        head.starts_with("HTTP/1.1 308 ") && head.lines().any(|line| line == "Location: /mine/a/"),
        "{head}"
    );
    assert_eq!(server.page("/progress.json").trim(), "[]");
}

/// Nothing outside the folder of reports is served, whatever the path.
fn nothing_outside_is_served(server: &Server, root: &Path) {
    let outside = root.join("secret.txt").display().to_string();
    let mut paths: Vec<String> =
        ["/nothing", "/mine", "/mine/", "/mine/a/figures/", "/.hidden.txt", "/link.txt"]
            .iter()
            .chain(&[
                "/mine/up/secret.txt",
                "/mine/up/reports-2/",
                "/mine/up/",
                "/%",
                "/mine/a/index.html%00",
            ])
            .map(ToString::to_string)
            .collect();
    for up in ["..", "%2e%2e", "%2E.", "%252e%252e", "..%00", "%c0%ae%c0%ae", "..%5c.."] {
        for slash in ["/", "%2f", "\\", "%5c", "//", "/./"] {
            paths.push(format!("/{up}{slash}secret.txt"));
            paths.push(format!("/mine{slash}{up}{slash}{up}{slash}secret.txt"));
            paths.push(format!("/{up}{slash}reports-2{slash}index.html"));
        }
    }
    paths.extend([format!("/{outside}"), outside.replace('/', "%2f").replacen("%2f", "/", 1), outside]);
    for path in &paths {
        let (head, body) = server.get(path);
        assert!(head.starts_with("HTTP/1.1 404 "), "{path}: {head}");
        assert_eq!(body, b"no such page\n", "{path}");
    }
}

/// Requests that would change something, and those of other hosts, are refused.
fn requests_of_other_hosts_are_refused(server: &Server) {
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "PATCH"] {
        let (head, _) = server.ask(method, "/", "localhost");
        assert!(head.starts_with("HTTP/1.1 405 ") && head.contains("Allow: GET, HEAD"), "{head}");
    }
    let body = "x".repeat(100_000);
    let request = format!("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n\r\n{body}");
    assert!(server.send(request.as_bytes()).0.starts_with("HTTP/1.1 405 "));
    for host in
        ["evil.example", "evil.example:80", "127.0.0.1.evil.example", "localhost@evil.example", "0.0.0.0", ""]
    {
        let (head, body) = server.ask("GET", "/mine/a/", host);
        assert!(head.starts_with("HTTP/1.1 403 ") && body.len() < 100, "{host}: {head}");
    }
    for host in ["localhost", "LOCALHOST:9", "[::1]:9", "127.0.0.1"] {
        assert!(server.ask("GET", "/", host).0.starts_with("HTTP/1.1 200 "), "{host}");
    }
    for request in [
        "GET / HTTP/1.1\r\n\r\n",
        "GET http://localhost/ HTTP/1.1\r\nHost: localhost\r\n\r\n",
        "\r\n\r\n",
        "\0\0\0\0\r\n\r\n",
        "GET / HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n\r\n",
    ] {
        assert!(server.send(request.as_bytes()).0.starts_with("HTTP/1.1 400 "), "{request:?}");
    }
    let long = format!("GET /{} HTTP/1.1\r\nHost: localhost\r\n\r\n", "a".repeat(1 << 15));
    assert!(server.send(long.as_bytes()).0.starts_with("HTTP/1.1 431 "));
}

#[test]
fn the_site_lists_every_run_and_can_be_rendered_again() {
    let root = tempfile::tempdir().unwrap();
    let reports = root.path().join("reports");
    let index = || std::fs::read_to_string(reports.join("index.html")).unwrap().replace("&#x2f;", "/");
    run(root.path(), "mine/b", "The second");
    let first = index();
    assert!(first.contains("href=\"mine/b/index.html\"") && first.contains("The second"));
    run(root.path(), "mine/a", "The first");
    let both = index();
    for part in [
        "The first",
        "The second",
        "2 experiments",
        "synthetic, no real video",
        "F1 score on still: hist and lax are equal, 0.000",
    ] {
        assert!(both.contains(part), "{part}\n{both}");
    }
    let summary: site::Summary =
        serde_json::from_slice(&std::fs::read(reports.join("mine/a/summary.json")).unwrap()).unwrap();
    assert_eq!((summary.claims.hold, summary.claims.do_not_hold, summary.claims.cannot_be_tested), (1, 1, 0));
    assert_eq!((summary.claims.undecided, summary.checks.hold), (0, 1));
    assert!(summary.synthetic && summary.present == summary.wanted && summary.best.len() == 1);
    let report =
        |names: &[&str]| trackfail().current_dir(root.path()).arg("report").args(names).output().unwrap();
    // The bytes do not depend on the order of writing, and finished runs leave no progress behind.
    assert!(report(&["mine/b"]).status.success());
    assert_eq!(index(), both);
    std::fs::remove_dir_all(&reports).unwrap();
    assert!(report(&[]).status.success());
    assert_eq!(index(), both);
    assert_eq!(progress::running(&root.path().join("results")), []);
    assert_eq!(std::fs::read_dir(root.path().join("results/.store/running")).unwrap().count(), 1);

    // A removed report is missing, and one with a broken summary gives a warning.
    std::fs::remove_dir_all(reports.join("mine/a")).unwrap();
    std::fs::create_dir_all(reports.join("other")).unwrap();
    std::fs::write(reports.join("other/index.html"), "page").unwrap();
    std::fs::write(reports.join("other/summary.json"), "{\"format\": []").unwrap();
    let done = report(&["mine/b"]);
    let stderr = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.success() && stderr.contains("warning: ") && stderr.contains("other"), "{stderr}");
    assert!(!index().contains("The first") && index().contains("href=\"other/index.html\""));
}

#[test]
fn running_experiments_are_shown() {
    let root = tempfile::tempdir().unwrap();
    let results = root.path().join("results");
    std::fs::create_dir_all(&results).unwrap();
    let server = Server::start(root.path());
    assert!(server.page("/").contains("no report yet"));
    // The progress of another run, published by hand.
    let experiment = spec::parse("x.toml", &small("mine/slow", "</h3><script>alert(1)</script>")).unwrap();
    let watch = Arc::new(ProgressWatch::default());
    watch.all_cells(9);
    watch.cells(4);
    watch.stage("judging");
    let at = watch.enter("<i>Girl</i>");
    let publisher = progress::publish(&results, &experiment, "2/3".parse().ok(), &watch).unwrap();
    let page = server.page("/");
    for part in
        ["mine/slow", "&lt;script&gt;alert(1)", "share <bdi>2/3</bdi>", "Running", "4 of 9", "&lt;i&gt;Girl"]
    {
        assert!(page.contains(part), "{part}\n{page}");
    }
    let runs: serde_json::Value = serde_json::from_str(&server.page("/progress.json")).unwrap();
    assert_eq!((&runs[0]["alive"], &runs[0]["cells"]), (&true.into(), &serde_json::json!([4, 9])));
    drop(at);
    drop(publisher);
    assert!(server.page("/").contains("Stopped"));

    // A real run is shown, is shown as stopped when it is killed, and disappears when it is run again.
    std::fs::write(root.path().join("a.toml"), small("mine/real", "A real one")).unwrap();
    let real = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
        command.current_dir(root.path()).args(["run", "a.toml", "--quiet", "--jobs", "1"]);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    let alive = || -> Option<bool> {
        let runs: serde_json::Value = serde_json::from_str(&server.page("/progress.json")).unwrap();
        let mine = runs.as_array().unwrap().iter().find(|run| run["experiment"] == "mine/real")?;
        assert!(mine["cells"][1].as_u64().is_some_and(|all| all > 0), "{mine}");
        mine["alive"].as_bool()
    };
    let mut process = real().spawn().unwrap();
    let end = Instant::now() + Duration::from_secs(120);
    while alive() != Some(true) {
        assert!(process.try_wait().unwrap().is_none() && Instant::now() < end, "it was never shown");
        std::thread::sleep(Duration::from_millis(5));
    }
    process.kill().unwrap();
    process.wait().unwrap();
    assert_eq!(alive(), Some(false));
    assert!(real().status().unwrap().success());
    assert_eq!(alive(), None);
    assert!(server.page("/").contains("href=\"mine/real/index.html\""));
}

#[test]
fn taken_ports_and_absent_folders_are_errors() {
    let root = tempfile::tempdir().unwrap();
    let serve = |port: &str| {
        let done = trackfail().current_dir(root.path()).args(["serve", "--port", port]).output().unwrap();
        (done.status.code(), String::from_utf8(done.stderr).unwrap())
    };
    let (code, stderr) = serve("0");
    assert!(code == Some(2) && stderr.contains("run an experiment first"), "{stderr}");
    std::fs::create_dir(root.path().join("reports")).unwrap();
    let mut server = Server::start(root.path());
    let (code, stderr) = serve(&server.port.to_string());
    assert!(code == Some(1) && stderr.contains("--port 0"), "{stderr}");
    // Ctrl-C is the regular end.
    let id = server.process.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    assert_eq!(server.process.wait().unwrap().code(), Some(0));
}
